"""The `woodcock` program: `submit` of its own, and the commands of whatever else is installed beside it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, version
from typing import Annotated, Any

import typer

from woodcock.scene import SceneError
from woodcock_client.connection import ServiceError, Unreachable
from woodcock_client.exits import BAD_INPUT, FAILED, INTERRUPTED, UNREACHABLE, fail
from woodcock_client.submit import SUBMIT_HELP, submit

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
    "certificates": "server",
    "scheduler": "server",
    "worker": "server,pocl",
}

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


def main() -> None:
    """Run the command line; never shows a traceback for what a user can cause."""
    asked = sys.argv[1:2]
    try:
        build(asked)()
    except ModuleNotFoundError as error:
        _absent(asked[0], error.name)()
    except SceneError as error:
        fail(str(error), BAD_INPUT)
    except ServiceError as error:
        fail(str(error), UNREACHABLE if error.status >= 500 else BAD_INPUT)
    except Unreachable as error:
        fail(str(error), UNREACHABLE)
    except OSError as error:
        fail(f"{error.filename}: {error.strerror}" if error.filename else str(error), FAILED)
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
        fail(f"the command `{name}` is not installed{because}; get it with: {_install(name)}", BAD_INPUT)

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


if __name__ == "__main__":
    main()
