"""Scenes of other renderers in: the participating-media subset of Mitsuba 3 (XML) and pbrt-v4 (text).

    mitsuba/  xml.py tree, element.py values, scene.py camera and film, media.py, lights.py, shapes.py
    pbrt/     tokens.py text, parameters.py values, state.py directives, scene.py camera and film, …
    draft.py  the new scene, and the files that go beside it        report.py  what was not carried over

What a scene cannot say is never dropped in silence: it is a Note of the Report, with its file and line.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from woodcock.importing.draft import Draft
from woodcock.importing.mitsuba.scene import convert as from_mitsuba
from woodcock.importing.pbrt.scene import convert as from_pbrt
from woodcock.importing.report import Note, Report, SourceError

__all__ = ["Note", "Report", "SourceError", "convert"]


def convert(source: Path, target: Path, report: Report) -> list[Path]:
    """Writes the scene in `source` as `target`, with the files that it needs beside it; returns what was written.

    A file that begins with `<` is Mitsuba's, any other pbrt's. What is not carried over goes into `report`.
    Raises SourceError; then nothing is written.
    """
    try:
        with source.open("rb") as file:
            start = file.read(256)
    except (OSError, ValueError) as error:
        raise SourceError(f"{source}: {getattr(error, 'strerror', None) or error}") from None
    draft = Draft(source, target, report)
    # Numbers too large for their products are found where matrices and scenes are checked
    with np.errstate(all="ignore"):
        (from_mitsuba if start.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"<") else from_pbrt)(source, draft)
        return draft.write()
