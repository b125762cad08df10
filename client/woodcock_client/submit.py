"""`woodcock submit`"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from woodcock.scene import load
from woodcock_client import sweeps, trials
from woodcock_client.batch_models import Batch
from woodcock_client.client import Client
from woodcock_client.exits import BAD_INPUT, FAILED, INTERRUPTED, fail
from woodcock_client.models import JobSummary
from woodcock_client.progress import show
from woodcock_client.trial_models import Comparison

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
Render a scene at every combination of values of some of its fields:
  woodcock submit cloud.json --sweep 'volumes[0].scale=1,2,4' --sweep camera.fov=20,35 --follow
\b
Use another service:
  woodcock submit cloud.json --server http://farm:8000
  WOODCOCK_SERVER=http://farm:8000 woodcock submit cloud.json
"""


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
            metavar="ID", help="Render on this device alone, trusted or not; or on a kind (cpu, gpu), or any."
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
    sweep: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=VALUE,VALUE",
            help="Render every combination of values of a field with those of the others; may be repeated.",
        ),
    ] = None,
    zip: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=VALUE,VALUE", help="Likewise, but these fields take their values together; may be repeated."
        ),
    ] = None,
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
        fail(f"-o {output}: the name must end in .exr", BAD_INPUT)
    if output is not None and not output.parent.is_dir():
        fail(f"-o {output}: {output.parent} is not a folder", BAD_INPUT)
    if sum(map(bool, (check, vary, sweep or zip, output))) > 1:
        fail("--check, --vary, --sweep and -o exclude each other", BAD_INPUT)
    if webhook and (check or vary):
        fail("--webhook goes with neither --check nor --vary", BAD_INPUT)
    if webhook and not webhook_secret:
        fail("--webhook needs WOODCOCK_WEBHOOK_SECRET: whsec_ and base64 of 24 to 64 random bytes", BAD_INPUT)
    try:
        varied = trials.choices(vary or [])
        product, zipped = sweeps.axes("--sweep", sweep or []), sweeps.axes("--zip", zip or [])
    except ValueError as error:
        fail(str(error), BAD_INPUT)
    try:
        client = Client(server, token=token)
    except ValueError as error:
        fail(f"--server: {error}", BAD_INPUT)

    with client:
        described, title = load(scene), scene.stem if name is None else name
        if check:
            trials.print_check(client.check(described, device=device))
            return
        named = _reference(client, reference)
        if varied:
            made = client.compare(described, varied, seconds, name=title, device=device, reference=named)
            _compare(client, made, follow)
            return
        if product or zipped:
            batch = client.sweep(
                described,
                product,
                zipped,
                name=title,
                device=device,
                reference=named,
                webhook=webhook,
                webhook_secret=webhook_secret,
            )
            _sweep(client, batch, follow)
            return
        job = client.submit(
            described, name=title, device=device, reference=named, webhook=webhook, webhook_secret=webhook_secret
        )
        page = f"{client.base_url}/renders/{job.id}"
        typer.echo(page)
        if not follow and output is None:
            return
        try:
            end = show(client.follow(job.id), quiet=not follow)
        except KeyboardInterrupt:
            fail(f"interrupted; the render goes on at {page}", INTERRUPTED)
        if end.state == "failed":
            # What a compiler or a driver said besides is on the render's page
            sentence = (end.error or "the service gave no reason").strip().splitlines()[0]
            fail(f"the render failed: {sentence}", FAILED)
        if end.state == "cancelled":
            fail("the render was cancelled", FAILED)
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
        fail(f"interrupted; the renders go on at {page}", INTERRUPTED)
    if end.verdict is None:
        faults = (f"{job.label}: {job.error}" for job in end.jobs if job.error)
        fail(f"the comparison failed: {next(faults, 'fewer than two pictures are there')}", FAILED)
    typer.echo(end.verdict.says)
    if end.links.report is not None:
        typer.echo(f"{client.base_url}{end.links.report}")


def _sweep(client: Client, made: Batch, follow: bool) -> None:
    page = f"{client.base_url}/batches/{made.id}"
    typer.echo(page)
    if not follow:
        return
    try:
        end = sweeps.show(client.follow_batch(made.id))
    except KeyboardInterrupt:
        fail(f"interrupted; the renders go on at {page}", INTERRUPTED)
    sweeps.print_table(end)
    if lacking := [job for job in end.jobs if job.state != "succeeded"]:
        why = next((job.error.strip().splitlines()[0] for job in lacking if job.error), "cancelled")
        fail(f"{len(lacking)} of {len(end.jobs)} renders did not succeed: {why}", FAILED)


def _reference(client: Client, named: str | None) -> str | None:
    """The id of a job or an upload; a file is uploaded."""
    return client.upload(Path(named)).id if named and named.lower().endswith(".exr") else named


def _save(client: Client, job: JobSummary, output: Path) -> None:
    report = output.with_suffix(".report.json")
    client.fetch(job.id, "image.exr", output)
    client.fetch(job.id, "report.json", report)
    typer.echo(f"{output}\n{report}")
