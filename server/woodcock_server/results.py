"""What stays of a finished job: the picture, which says how to render it again, and the report, as data and a page."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from woodcock import report
from woodcock.contract import outcome
from woodcock.film import Film
from woodcock.image import WriteError, write_exr, write_preview, write_thumbnail
from woodcock.pages import report_page
from woodcock.reference import Reference
from woodcock.report import Use
from woodcock.scene import RelativeErrorStop, Scene
from woodcock.series import Point
from woodcock_server.storage import StoreAway, write_json, write_text

#: What a disk that is full, read-only or at fault makes of writing, and a store that does not answer.
UNWRITTEN = (OSError, WriteError, StoreAway)

PREVIEW_SIZE, THUMBNAIL_SIZE = 1024, 320  # longest side, pixels


def preview(folder: Path, film: Film) -> None:
    """Write preview.png and thumbnail.webp; blocks."""
    path = folder / "preview.png"
    write_preview(path, film, PREVIEW_SIZE)
    write_thumbnail(folder / "thumbnail.webp", path, THUMBNAIL_SIZE)


def figures(scene: Scene, film: Film, seconds: float) -> dict[str, Any]:
    """The columns of a job that tell how far its picture is."""
    rmse = film.rmse()
    return {
        "samples": film.samples,
        "seconds": seconds,
        "rmse": rmse if math.isfinite(rmse) else None,
        "relative_rmse": report.relative_rmse(film),
        "reached": outcome(scene.stop, film, seconds)["reached"] if isinstance(scene.stop, RelativeErrorStop) else None,
    }


def write(
    folder: Path,
    name: str,
    scene: Scene,
    film: Film,
    uses: Sequence[Use],
    series: Sequence[Point],
    seconds: Mapping[str, float],
    reference: Reference | None,
) -> dict[str, Any]:
    """Write image.exr, preview.png, thumbnail.webp, report.json and report.html; blocks. Returns the report. Raises
    DenoiseError.

    seconds: of render, merge and check, and of what was written before.
    """
    began = time.monotonic()
    header = report.header(scene, film, uses, series, seconds)
    write_exr(folder / "image.exr", film, header, scene.denoise)
    preview(folder, film)
    seconds = {**seconds, "write": seconds["write"] + time.monotonic() - began}
    content = report.build(film, uses, series, seconds, scene=scene, reference=reference)
    write_json(folder / "report.json", content)
    write_text(folder / "report.html", report_page(content, scene, film, reference, name or "Untitled"))
    return content
