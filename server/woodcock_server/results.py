"""What stays of a finished job: the picture, which says how to render it again, and the report, as data and a page."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from typing import Any

from woodcock import report
from woodcock.contract import outcome
from woodcock.film import Film
from woodcock.image import write_exr, write_preview, write_thumbnail
from woodcock.pages import report_page
from woodcock.reference import Reference
from woodcock.report import Use
from woodcock.scene import RelativeErrorStop, Scene
from woodcock.series import Point
from woodcock_server.storage import Storage

PREVIEW_SIZE, THUMBNAIL_SIZE = 1024, 320  # longest side, pixels


def preview(storage: Storage, job_id: str, film: Film) -> None:
    """Write preview.png and thumbnail.webp; blocks."""
    path = storage.job_file(job_id, "preview.png")
    write_preview(path, film, PREVIEW_SIZE)
    write_thumbnail(path.with_name("thumbnail.webp"), path, THUMBNAIL_SIZE)


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
    storage: Storage,
    job_id: str,
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
    write_exr(storage.job_file(job_id, "image.exr"), film, header, scene.denoise)
    preview(storage, job_id, film)
    seconds = {**seconds, "write": seconds["write"] + time.monotonic() - began}
    content = report.build(film, uses, series, seconds, scene=scene, reference=reference)
    storage.write_json(job_id, "report.json", content)
    storage.write_text(job_id, "report.html", report_page(content, scene, film, reference, name or "Untitled"))
    return content
