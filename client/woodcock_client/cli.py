"""The `woodcock` program: `submit` of its own, and the commands of whatever else is installed beside it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, version
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from woodcock.scene import SceneError, load
from woodcock_client import trials
from woodcock_client.client import Client
from woodcock_client.connection import ServiceError, Unreachable
from woodcock_client.models import JobSummary
from woodcock_client.progress import show
from woodcock_client.trial_models import Comparison

#: What a command needs beyond the client: the extra of the `woodcock` package that brings it.
EXTRAS = {
    "render": "render,pocl",
    "devices": "render,pocl",
    "schema": "render",
    "stability": "render,pocl",
    "import": "render",
    "compare": "render,pocl",
    "serve": "server,pocl",
    "token": "server",
    "backup": "server",
}

FAILED, BAD_INPUT, UNREACHABLE, INTERRUPTED = 1, 2, 3, 130

HELP = """Render participating media: clouds, smoke, fire, fog, tissue, milk.

\b
On this machine:
  woodcock render cloud.json -o cloud.exr
\b
As a service, with its gallery at http://127.0.0.1:8000:
  woodcock serve --data ./data
  woodcock submit cloud.json --follow -o cloud.exr

Exit codes: 0 done, 1 the render failed, 2 bad usage or a bad scene, 3 no answer from the service, 130 interrupted.
"""

SUBMIT_HELP = """Send a scene to a service, and fetch the picture if asked to.

The files that the scene names are uploaded first, unless the service has them already. The address of the render's page
is printed; without --follow or -o the command then ends, and the render goes on.

\b
Queue a render and go:
  woodcock submit cloud.json
\b
Watch it until it is done:
  woodcock submit cloud.json --follow
\b
Fetch the picture (cloud.exr) and the report (cloud.report.json):
  woodcock submit cloud.json --follow -o cloud.exr
\b
Ask how long it would take, and queue nothing:
  woodcock submit cloud.json --check
\b
Find the best estimator, each for half a minute (`woodcock compare` does that without a service):
  woodcock submit cloud.json --vary majorant=global,grid --seconds 30 --follow
\b
Use another service:
  woodcock submit cloud.json --server http://farm:8000
  WOODCOCK_SERVER=http://farm:8000 woodcock submit cloud.json
"""


def main() -> None:
    """Run the command line; never shows a traceback for what a user can cause."""
    asked = sys.argv[1:2]
    try:
        build(asked)()
    except ModuleNotFoundError as error:
        _absent(asked[0], error.name)()
    except SceneError as error:
        _fail(str(error), BAD_INPUT)
    except ServiceError as error:
        _fail(str(error), UNREACHABLE if error.status >= 500 else BAD_INPUT)
    except Unreachable as error:
        _fail(str(error), UNREACHABLE)
    except OSError as error:
        _fail(f"{error.filename}: {error.strerror}" if error.filename else str(error), FAILED)
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None


def build(asked: list[str]) -> typer.Typer:
    """The program. Only the command asked for is imported, so that `submit` does not wait for a renderer; any other
    first word (`--help`, nothing, a mistake) imports them all.
    """
    app = typer.Typer(
        help=HELP,
        no_args_is_help=True,
        add_completion=False,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_options)
    app.command("submit", help=SUBMIT_HELP)(submit)
    installed = {point.name: point for point in entry_points(group="woodcock.commands")}
    known = EXTRAS.keys() | installed.keys() | {"submit"}
    for name in sorted((known & set(asked) or known) - {"submit"}):
        try:
            loaded = _load(installed.get(name))
            if isinstance(loaded, typer.Typer):
                app.add_typer(loaded, name=name)
            else:
                app.command(name)(loaded)
        except ModuleNotFoundError as error:
            stand_in = _absent(name, error.name)
            app.command(name, help=f"(needs {_install(name)})", context_settings=ANY_ARGUMENTS)(stand_in)
    return app


ANY_ARGUMENTS = {"ignore_unknown_options": True, "allow_extra_args": True, "help_option_names": []}


def _load(point: EntryPoint | None) -> Callable[..., Any] | typer.Typer:
    if point is None:
        raise ModuleNotFoundError
    command: Callable[..., Any] | typer.Typer = point.load()
    return command


def _install(name: str) -> str:
    return f'pip install "woodcock[{EXTRAS[name]}]"' if name in EXTRAS else "a package that is not installed"


def _absent(name: str, missing: str | None) -> Callable[[], None]:
    """What runs in place of a command that is not there."""

    def command() -> None:
        because = f" ({missing} is missing)" if missing else ""
        _fail(f"the command `{name}` is not installed{because}; get it with: {_install(name)}", BAD_INPUT)

    return command


def _show_version(on: bool) -> None:
    if on:
        try:
            typer.echo(f"woodcock {version('woodcock')}")
        except PackageNotFoundError:
            typer.echo("woodcock, not installed (running from its sources)")
        raise typer.Exit()


def _options(
    version: Annotated[
        bool,
        typer.Option("--version", help="Show the version and exit.", is_eager=True, callback=_show_version),
    ] = False,
) -> None:
    pass


def submit(
    scene: Annotated[
        Path, typer.Argument(metavar="SCENE.json", help="Scene file; files that it names are relative to it.")
    ],
    follow: Annotated[bool, typer.Option("--follow", help="Show progress until the render is done.")] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="OUT.exr", help="Wait, then save the picture here and the report beside it."
        ),
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name in the gallery; by default the scene file's.")] = None,
    device: Annotated[
        str,
        typer.Option(
            metavar="ID", help="Render on this device alone, even if it failed its stability check; any: all trusted."
        ),
    ] = "any",
    reference: Annotated[
        str | None,
        typer.Option(
            metavar="REF", help="Hold the picture against this one: an EXR here, or the id of a job that has succeeded."
        ),
    ] = None,
    webhook: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Tell this URL of the render's end, signed by a secret (whsec_…)."),
    ] = None,
    webhook_secret: Annotated[
        str | None,
        typer.Option(
            envvar="WOODCOCK_WEBHOOK_SECRET", show_default=False, help="With --webhook; better in the variable."
        ),
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Queue nothing; say what it would take, by a pilot of some seconds.")
    ] = False,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FIELD=KIND,KIND", help="Compare variants: a field and the kinds to try; may be repeated."
        ),
    ] = None,
    seconds: Annotated[float, typer.Option(min=0.1, help="With --vary: rendering time of every variant.")] = 10.0,
    server: Annotated[
        str, typer.Option(metavar="URL", envvar="WOODCOCK_SERVER", help="Address of the service.")
    ] = "http://127.0.0.1:8000",
    token: Annotated[
        str | None,
        typer.Option(
            envvar="WOODCOCK_TOKEN", show_default=False, help="Where the service asks for one; better in the variable."
        ),
    ] = None,
) -> None:
    # Refuse what cannot end well before hours are spent on it
    if output is not None and output.suffix != ".exr":
        _fail(f"-o {output}: the name must end in .exr", BAD_INPUT)
    if output is not None and not output.parent.is_dir():
        _fail(f"-o {output}: {output.parent} is not a folder", BAD_INPUT)
    if ((check or vary) and output is not None) or (check and vary):
        _fail("--check, --vary and -o exclude each other", BAD_INPUT)
    if webhook and (check or vary):
        _fail("--webhook goes with neither --check nor --vary", BAD_INPUT)
    if webhook and not webhook_secret:
        _fail("--webhook needs WOODCOCK_WEBHOOK_SECRET: whsec_ and base64 of 24 to 64 random bytes", BAD_INPUT)
    try:
        varied = trials.choices(vary or [])
    except ValueError as error:
        _fail(str(error), BAD_INPUT)
    try:
        client = Client(server, token=token)
    except ValueError as error:
        _fail(f"--server: {error}", BAD_INPUT)

    with client:
        described, title = load(scene), scene.stem if name is None else name
        if check:
            trials.print_check(client.check(described, device=device))
            return
        if varied:
            named = _reference(client, reference)
            made = client.compare(described, varied, seconds, name=title, device=device, reference=named)
            _compare(client, made, follow)
            return
        job = client.submit(
            described,
            name=title,
            device=device,
            reference=_reference(client, reference),
            webhook=webhook,
            webhook_secret=webhook_secret,
        )
        page = f"{client.base_url}/renders/{job.id}"
        typer.echo(page)
        if not follow and output is None:
            return
        try:
            end = show(client.follow(job.id), quiet=not follow)
        except KeyboardInterrupt:
            _fail(f"interrupted; the render goes on at {page}", INTERRUPTED)
        if end.state == "failed":
            # What a compiler or a driver said besides is on the render's page
            sentence = (end.error or "the service gave no reason").strip().splitlines()[0]
            _fail(f"the render failed: {sentence}", FAILED)
        if end.state == "cancelled":
            _fail("the render was cancelled", FAILED)
        if output is not None:
            _save(client, end, output)


def _compare(client: Client, made: Comparison, follow: bool) -> None:
    page = f"{client.base_url}{made.links.self}"
    typer.echo(page)
    if not follow:
        return
    try:
        end = trials.wait(client, made)
    except KeyboardInterrupt:
        _fail(f"interrupted; the renders go on at {page}", INTERRUPTED)
    if end.verdict is None:
        faults = (f"{job.label}: {job.error}" for job in end.jobs if job.error)
        _fail(f"the comparison failed: {next(faults, 'fewer than two pictures are there')}", FAILED)
    typer.echo(end.verdict.says)
    if end.links.report is not None:
        typer.echo(f"{client.base_url}{end.links.report}")


def _reference(client: Client, named: str | None) -> str | None:
    """The id of a job or an upload; a file is uploaded."""
    return client.upload(Path(named)).id if named and named.lower().endswith(".exr") else named


def _save(client: Client, job: JobSummary, output: Path) -> None:
    report = output.with_suffix(".report.json")
    client.fetch(job.id, "image.exr", output)
    client.fetch(job.id, "report.json", report)
    typer.echo(f"{output}\n{report}")


def _fail(message: str, code: int) -> NoReturn:
    typer.echo(f"woodcock: {message}", err=True)
    raise SystemExit(code)


if __name__ == "__main__":
    main()
