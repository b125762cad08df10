"""The renderer's part of the command line: render, devices, schema."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from pydantic import BaseModel
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from woodcock.denoise import DenoiseError, require
from woodcock.device import Device, DeviceError, find
from woodcock.device import devices as list_devices
from woodcock.drive import drive
from woodcock.evidence import gather
from woodcock.files import replacing
from woodcock.film import Film
from woodcock.formats import VolumeError
from woodcock.image import ImageError, write_exr
from woodcock.pages import report_page
from woodcock.probe import probe
from woodcock.reference import Reference
from woodcock.render import Renderer
from woodcock.report import Use, build, header
from woodcock.report_schema import Report
from woodcock.scene import Scene, SceneError, load
from woodcock.series import Point

FAILED, BAD_INPUT = 1, 2


def render(
    scene: Annotated[
        Path, typer.Argument(metavar="SCENE.json", help="Scene file; files that it names are relative to it.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.exr", help="The picture; its report goes beside it.")
    ],
    device: Annotated[str | None, typer.Option(metavar="ID", help="Device, by its id in `woodcock devices`.")] = None,
    reference: Annotated[
        Path | None,
        typer.Option(
            metavar="REF.exr", help="Picture that errors are measured against: one of a long render, or exact."
        ),
    ] = None,
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="By the program with everything switched on: slower; shows what leaving out gains."
        ),
    ] = False,
) -> None:
    """Render a scene on this machine, without a service.

    \b
      woodcock render cloud.json -o cloud.exr
      woodcock render cloud.json -o cloud.exr --device gpu0
      woodcock render cloud.json -o cloud.exr --reference long.exr

    Writes the picture, with the layers that the scene asks for, the variance of every pixel and the number of its
    samples, and a report beside it: OUT.report.json, and OUT.report.html to look at. Exit codes: 0 done, 1 the render
    failed, 2 bad usage or a bad scene, 130 interrupted.
    """
    if output.suffix != ".exr":
        _fail(f"-o {output}: the name must end in .exr", BAD_INPUT)
    if not output.parent.is_dir():
        _fail(f"-o {output}: {output.parent} is not a folder", BAD_INPUT)
    try:
        described = load(scene)
        if described.denoise:
            require()
        truth = None if reference is None else _reference(reference).independent_of(described.seed)
        renderer = _renderer(described, find(device), full)
        film, series, seconds = _to_the_end(renderer, described, truth)
        use: Use = {
            **renderer.facts(),
            "samples": film.samples,
            "programs": {renderer.program_hash: film.mean_samples},
            "render_seconds": seconds["render"],
            "evidence": None,
        }
        began = time.perf_counter()
        write_exr(output, film, header(described, film, [use], series, seconds), described.denoise)
        seconds["write"] = (written := time.perf_counter()) - began
        use["evidence"] = gather(renderer, described)
        seconds["check"] += time.perf_counter() - written
        report = build(film, [use], series, seconds, scene=described, reference=truth)
        with replacing(output.with_suffix(".report.json")) as temporary:
            temporary.write_text(json.dumps(report, indent=2) + "\n")
        with replacing(output.with_suffix(".report.html")) as temporary:
            temporary.write_text(report_page(report, described, film, truth, scene.stem))
    except SceneError as error:
        _fail(str(error), BAD_INPUT)
    except (DeviceError, ImageError, DenoiseError) as error:
        _fail(str(error), FAILED)
    for line in report["certificate"]["lines"]:
        if line["status"] == "failed":
            typer.echo(f"woodcock: {line['name']}: {line['says']}", err=True)
    typer.echo(f"{output}\n{output.with_suffix('.report.json')}\n{output.with_suffix('.report.html')}")


def devices() -> None:
    """List the OpenCL devices of this machine, checked: with the lane widths that work, or with what is wrong."""
    try:
        found = list_devices()
    except DeviceError as error:
        _fail(str(error), FAILED)
    table = Table("id", "name", "platform", "driver", "units", "memory", "lanes")
    for device in found:
        result = probe(device)
        lanes = ", ".join(map(str, result.lanes)) or (result.fault or "")
        memory = f"{device.memory / 2**30:.1f} GiB"
        table.add_row(device.id, device.name, device.platform, device.driver, str(device.compute_units), memory, lanes)
    Console().print(table)


class Described(StrEnum):
    SCENE = "scene"
    REPORT = "report"


def schema(
    of: Annotated[Described, typer.Argument(help="What to describe.")] = Described.SCENE,
) -> None:
    """Print the JSON Schema of a scene, or that of a report: units and formulas of all its numbers."""
    model: type[BaseModel] = Scene if of is Described.SCENE else Report
    typer.echo(json.dumps(model.model_json_schema(), indent=2, ensure_ascii=False))


def _renderer(scene: Scene, device: Device, full: bool) -> Renderer:
    """Ends the program where the scene, or a file that it names, cannot be rendered. Raises DeviceError."""
    try:
        return Renderer(scene, device, full=full)
    except (SceneError, VolumeError, ImageError) as error:
        _fail(str(error), BAD_INPUT)


def _reference(path: Path) -> Reference:
    """Ends the program where it cannot be read."""
    try:
        return Reference.load(path)
    except ImageError as error:
        _fail(f"--reference {error}", BAD_INPUT)


def _check(reference: Reference, film: Film) -> None:
    """Ends the program where a film cannot be held against it."""
    try:
        reference.check(film.width, film.height, film.channels)
    except ImageError as error:
        _fail(f"--reference {error}", BAD_INPUT)


def _to_the_end(
    renderer: Renderer, scene: Scene, reference: Reference | None
) -> tuple[Film, list[Point], dict[str, float]]:
    """What `drive` gives, with its progress on the terminal."""
    if reference is not None:
        _check(reference, Film.empty(scene.film.width, scene.film.height, renderer.names))
    columns = (BarColumn(), TextColumn("{task.fields[facts]}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=1.0, facts="")

        def show(done: float, film: Film, series: Sequence[Point]) -> None:
            mean = film.mean_luminance()
            error = f", error {series[-1]['rmse'] / mean:.2%}" if series and mean else ""
            progress.update(task, completed=done, facts=f"{film.mean_samples:.0f} samples{error}")

        return drive(renderer, scene, show, reference)


def _fail(message: str, code: int) -> NoReturn:
    typer.echo(f"woodcock: {message}", err=True)
    raise SystemExit(code)
