"""The command line's `import`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from woodcock.importing import Report, SourceError, convert

BAD_INPUT = 2


def import_scene(
    source: Annotated[Path, typer.Argument(metavar="SCENE.xml|SCENE.pbrt", help="Scene of Mitsuba 3 or pbrt-v4.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.json", help="The scene; files it needs go beside it.")
    ],
) -> None:
    """Make a scene of one for Mitsuba 3 or pbrt-v4.

    \b
      woodcock import scene.xml -o scene.json
      woodcock import scene.pbrt -o scene.json

    What cannot be carried over is listed, with its file and line; meshes and grids in files of their own are referred
    to. Exit codes: 0 done, 2 bad usage or a file that cannot be read.
    """
    if output.suffix != ".json":
        _say(f"-o {output}: the name must end in .json")
        raise SystemExit(BAD_INPUT)
    if not output.parent.is_dir():
        _say(f"-o {output}: {output.parent} is not a folder")
        raise SystemExit(BAD_INPUT)
    report, fault = Report(), None
    try:
        written = convert(source, output, report)
    except SourceError as error:
        written, fault = [], error
    for note in report.notes:
        _say(str(note))
    if fault is not None:
        _say(str(fault))
        raise SystemExit(BAD_INPUT)
    typer.echo("\n".join(map(str, written)))


def _say(message: str) -> None:
    typer.echo(f"woodcock: {message}", err=True)
