"""What stays of a finished job: the picture, which says how to render it again, and the report."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from woodcock import report
from woodcock.film import Film
from woodcock.image import write_exr, write_preview
from woodcock.report import Point, Use
from woodcock.scene import Scene
from woodcock_server.storage import Storage

PREVIEW_SIZE = 1024  # longest side, pixels


def preview(storage: Storage, job_id: str, film: Film) -> None:
    """Write preview.png; blocks."""
    write_preview(storage.job_file(job_id, "preview.png"), film, PREVIEW_SIZE)


def write(
    storage: Storage,
    job_id: str,
    scene: Scene,
    film: Film,
    uses: Sequence[Use],
    series: Sequence[Point],
    seconds: Mapping[str, float],
) -> None:
    """Write image.exr, preview.png and report.json; blocks. seconds: of render and check. Raises DenoiseError."""
    began = time.monotonic()
    write_exr(storage.job_file(job_id, "image.exr"), film, report.header(scene, film, uses), scene.denoise)
    preview(storage, job_id, film)
    content = report.build(film, uses, series, **seconds, write=time.monotonic() - began)
    storage.write_json(job_id, "report.json", content)
