"""`woodcock compare`: which estimator is the best for a scene, by trying them for equal time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from woodcock.compare import vary as varying
from woodcock.compare.agreement import of_reference
from woodcock.compare.judge import Row, Verdict, twins, winner
from woodcock.compare.page import bias_text, efficiency_text, error_text, page, ratio_text, standing
from woodcock.compare.run import TURNS, Outcome, run
from woodcock.device import Device, DeviceError, find
from woodcock.files import replacing
from woodcock.formats import VolumeError
from woodcock.image import ImageError
from woodcock.pages import words
from woodcock.reference import Reference
from woodcock.scene import Scene, SceneError, load

FAILED, BAD_INPUT = 1, 2
#: Columns of a table that goes to no terminal.
PRINTED = 160


def compare(
    scene: Annotated[
        Path, typer.Argument(metavar="SCENE.json", help="Scene file; files that it names are relative to it.")
    ],
    vary: Annotated[
        list[str],
        typer.Option(metavar="FIELD=KIND,KIND", help="A field of the scene and the kinds to try; may be repeated."),
    ],
    seconds: Annotated[float, typer.Option(min=0.1, help="Rendering time of every variant.")] = 10.0,
    reference: Annotated[
        Path | None, typer.Option(metavar="REF.exr", help="A picture that counts as true, of the same size.")
    ] = None,
    device: Annotated[str | None, typer.Option(metavar="ID", help="Device, by its id in `woodcock devices`.")] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PAGE.html", help="A page with curves and pictures."),
    ] = None,
) -> None:
    """Render variants of a scene for equal time, in turns, and say which one wins and by how much.

    \b
      woodcock compare cloud.json --vary majorant=global,grid
      woodcock compare cloud.json --vary transmittance=ratio,residual_ratio,ray_marching \\
          --vary free_flight=delta,decomposition --seconds 30 -o cloud.html

    The winner has the highest efficiency = 1 / (variance × time), by more than chance; one whose picture differs from
    the others' cannot win. Exit codes: 0 done, 1 the render failed, 2 bad usage or a bad scene, 130 interrupted.
    """
    if output is not None and (output.suffix != ".html" or not output.parent.is_dir()):
        _fail(f"-o {output}: the name must end in .html, in a folder that exists", BAD_INPUT)
    try:
        described = load(scene)
        variants = varying.variants(described, varying.parse(vary))
        truth = None if reference is None else Reference.load(reference)
        if truth is not None:
            truth.check(described.film.width, described.film.height, 1)
        chosen = find(device)
        outcome = _watched(described, variants, chosen, seconds, truth)
    except (SceneError, VolumeError, ImageError, varying.CompareError) as error:
        _fail(str(error), BAD_INPUT)
    except DeviceError as error:
        _fail(str(error), FAILED)
    verdict = winner(outcome.rows, None if truth is None else of_reference(truth))
    _print(outcome, verdict)
    if output is not None:
        measured = how(outcome, described, chosen, seconds, truth)
        text = page(scene.stem, outcome.rows, verdict, outcome.films, described, measured, outcome.same)
        with replacing(output) as temporary:
            temporary.write_text(text)
        typer.echo(output)


def how(
    outcome: Outcome, scene: Scene, device: Device, seconds: float, reference: Reference | None
) -> list[tuple[str, str]]:
    """How a comparison was made, as names and texts."""
    turns = [len(row["slices"]) for row in outcome.rows]
    facts = [
        ("device", f"{device.name} ({device.id}); {device.platform}, {device.driver}"),
        ("time", f"{words.duration(seconds)} of rendering for each; reading and building do not count"),
        (
            "turns",
            f"A B C A B C …, {min(turns)} to {max(turns)} of each: {words.duration(seconds / TURNS)} or the fewest "
            "samples that have a variance",
        ),
        (
            "efficiency",
            "1 ∕ (variance × seconds): the variance of a pixel’s mean by its samples, weighted by luminance",
        ),
        (
            "intervals",
            "95 %, of the ratio of two: Student’s t by the jackknife over turns, in pairs where both have as many",
        ),
        (
            "winner",
            "its ratio to every other is above 1 with that confidence; else it is a draw",
        ),
        (
            "agreement",
            "means of the whole and of 4 × 4 parts, every two variants, Welch’s test; by chance alone one "
            "comparison in a thousand marks a variant",
        ),
        ("seeds", f"from {scene.seed} on, another for each variant"),
    ]
    return facts if reference is None else [*facts, ("reference", reference.name)]


def _watched(
    scene: Scene,
    variants: Sequence[varying.Variant],
    device: Device,
    seconds: float,
    reference: Reference | None,
) -> Outcome:
    """The comparison, with its progress on the terminal."""
    columns = (BarColumn(), TextColumn("{task.fields[facts]}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=1.0, facts=f"building {len(variants)} variants")

        def show(done: float, total: float) -> None:
            facts = f"{words.duration(done)} of {words.duration(total)}, {len(variants)} variants in turns"
            progress.update(task, completed=done / total, facts=facts)

        return run(scene, variants, device, seconds, reference, show)


def _print(outcome: Outcome, verdict: Verdict) -> None:
    by_label = {row["label"]: row for row in outcome.rows}
    against = any(row["against"] for row in outcome.rows)
    console = Console()
    if not console.is_terminal:
        console.width = PRINTED
    table = Table("variant", "verdict", "over the worst", "efficiency", "error", box=SIMPLE_HEAD)
    for name in [*(("true MSE", "bias") if against else ()), "samples", "rendered", "built in"]:
        table.add_column(name, justify="right")
    for label in verdict["order"]:
        table.add_row(*_cells(by_label[label], verdict), style="bold" if label == verdict["winner"] else None)
    console.print(table)
    for label, others in twins(outcome.same).items():
        typer.echo(f"Left out, for it is the same program as “{label}”: {', '.join(f'“{each}”' for each in others)}.")
    typer.echo(verdict["says"])


def _cells(row: Row, verdict: Verdict) -> list[str]:
    ratio, interval = ratio_text(row, verdict)
    name = f"{row['label']} (default)" if row["default"] else row["label"]
    truth = [] if row["against"] is None else [words.number(row["against"]["mse"]), bias_text(row["against"])]
    times = [words.duration(row["seconds"]), words.duration(row["build_seconds"])]
    known = f"{ratio} ({interval})" if interval else ratio
    return [
        *(name, standing(row, verdict), known, efficiency_text(row), error_text(row)),
        *(*truth, words.count(row["samples"]), *times),
    ]


def _fail(message: str, code: int) -> NoReturn:
    typer.echo(f"woodcock: {message}", err=True)
    raise SystemExit(code)
