"""The renderer's part of the command line: render, devices, schema."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from woodcock.denoise import DenoiseError, require
from woodcock.device import Device, DeviceError, find
from woodcock.device import devices as list_devices
from woodcock.evidence import gather
from woodcock.files import replacing
from woodcock.film import Film
from woodcock.formats import VolumeError
from woodcock.image import ImageError, write_exr
from woodcock.pace import RANGE_SECONDS, Pace, fit
from woodcock.probe import probe
from woodcock.render import Renderer
from woodcock.report import SERIES_GROWTH, Point, Use, build, header, point
from woodcock.scene import SamplesStop, Scene, SceneError, load

FAILED, BAD_INPUT = 1, 2


def render(
    scene: Annotated[
        Path, typer.Argument(metavar="SCENE.json", help="Scene file; files that it names are relative to it.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.exr", help="The picture; its report goes beside it.")
    ],
    device: Annotated[str | None, typer.Option(metavar="ID", help="Device, by its id in `woodcock devices`.")] = None,
) -> None:
    """Render a scene on this machine, without a service.

    \b
      woodcock render cloud.json -o cloud.exr
      woodcock render cloud.json -o cloud.exr --device gpu0

    Writes the picture, with the layers that the scene asks for, the variance of every pixel and the number of its
    samples, and a report beside it (OUT.report.json). Exit codes: 0 done, 1 the render failed, 2 bad usage or a bad
    scene, 130 interrupted.
    """
    if output.suffix != ".exr":
        _fail(f"-o {output}: the name must end in .exr", BAD_INPUT)
    if not output.parent.is_dir():
        _fail(f"-o {output}: {output.parent} is not a folder", BAD_INPUT)
    try:
        described = load(scene)
        if described.denoise:
            require()
        renderer = _renderer(described, find(device))
        film, series, seconds = _to_the_end(renderer, described)
        use: Use = {**renderer.facts(), "samples": film.samples, "render_seconds": seconds, "evidence": None}
        began = time.perf_counter()
        write_exr(output, film, header(described, film, [use]), described.denoise)
        written = time.perf_counter()
        use["evidence"] = gather(renderer, described)
        report = build(film, [use], series, seconds, time.perf_counter() - written, written - began)
        with replacing(output.with_suffix(".report.json")) as temporary:
            temporary.write_text(json.dumps(report, indent=2) + "\n")
    except SceneError as error:
        _fail(str(error), BAD_INPUT)
    except (DeviceError, ImageError, DenoiseError) as error:
        _fail(str(error), FAILED)
    for line in report["certificate"]["lines"]:
        if line["status"] == "failed":
            typer.echo(f"woodcock: {line['name']}: {line['says']}", err=True)
    typer.echo(f"{output}\n{output.with_suffix('.report.json')}")


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


def schema() -> None:
    """Print the JSON Schema of a scene."""
    typer.echo(json.dumps(Scene.model_json_schema(), indent=2, ensure_ascii=False))


def _renderer(scene: Scene, device: Device) -> Renderer:
    """Ends the program where the scene, or a file that it names, cannot be rendered. Raises DeviceError."""
    try:
        return Renderer(scene, device)
    except (SceneError, VolumeError, ImageError) as error:
        _fail(str(error), BAD_INPUT)


def _to_the_end(renderer: Renderer, scene: Scene) -> tuple[Film, list[Point], float]:
    """Renders range after range until the scene's contract is met; the film, the error series, the seconds it took."""
    stop, pace, series = scene.stop, Pace(), list[Point]()
    film = Film.empty(scene.film.width, scene.film.height, renderer.names)
    columns = (BarColumn(), TextColumn("{task.fields[facts]}"), TimeElapsedColumn())
    began = time.perf_counter()
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=1.0, facts="")
        while True:
            elapsed = time.perf_counter() - began
            if isinstance(stop, SamplesStop):
                count, done = min(stop.samples - film.samples, pace.size(RANGE_SECONDS)), film.samples / stop.samples
            else:
                count = fit(pace, stop.seconds - elapsed, nothing_yet=film.samples == 0)
                done = min(1.0, elapsed / stop.seconds)
            if count == 0:
                break
            error = (
                f", error {series[-1]['rmse'] / film.mean_luminance():.2%}" if series and film.mean_luminance() else ""
            )
            progress.update(task, completed=done, facts=f"{film.samples} samples{error}")
            start = time.perf_counter()
            film = film.merge(renderer.render(film.samples, film.samples + count))
            pace.measured(count, time.perf_counter() - start)
            last = isinstance(stop, SamplesStop) and film.samples == stop.samples
            due = not series or film.samples >= series[-1]["samples"] * SERIES_GROWTH
            if (due or last) and (now := point(time.perf_counter() - began, film)):
                series.append(now)
    return film, series, time.perf_counter() - began


def _fail(message: str, code: int) -> NoReturn:
    typer.echo(f"woodcock: {message}", err=True)
    raise SystemExit(code)
