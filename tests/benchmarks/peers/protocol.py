"""What an adapter shares with the harness: lines of JSON, and images of NumPy beside them.

Adapters are run by the interpreters of their renderers, so this needs Python 3.11, NumPy, and nothing else.

    PYTHON NAME_side.py FOLDER    with FOLDER/peer.json: {"scene", "grids"}; see README.md
      → {"name", "version", "settings"}   or {"skip": "reason"}
    {"samples", "seed"} → {"seconds", "image"}   or {"error": "one sentence"}; and so on, until stdin ends
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

Image = np.ndarray
#: render(samples of every pixel, seed) -> picture (height, width, 3), linear Rec. 709, row 0 on top; seconds it took
Render = Callable[[int, int], tuple[Image, float]]


class Skip(Exception):  # noqa: N818  it is no error
    """This peer cannot render this scene; the reason, one clause."""


@dataclass(frozen=True)
class Job:
    """A scene, whole, with its defaults; `folder` holds its files. Grids are asked for by the scene's names of them."""

    scene: dict[str, Any]
    folder: Path
    grids: dict[str, dict[str, Any]]

    @classmethod
    def read(cls, folder: Path) -> Job:
        described = json.loads((folder / "peer.json").read_text())
        return cls(described["scene"], folder, described["grids"])

    def values(self, file: str) -> Image:
        """(z, y, x) or (z, y, x, 3) float32; a sample is the middle of its voxel, at i + 1/2."""
        return np.asarray(np.load(self.folder / self.grids[file]["values"]))

    def to_scene(self, file: str) -> Image:
        """4 × 4, from the unit cube that the grid fills, x first, to the scene; applied to column vectors."""
        return np.array(self.grids[file]["to_scene"], float)


def serve(make: Callable[[Job], tuple[dict[str, Any], Render]]) -> None:
    """Talks the protocol on stdout until stdin ends. What libraries print goes to stderr."""
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    sys.stdout = sys.stderr

    def say(answer: dict[str, Any]) -> None:
        print(json.dumps(answer), file=out, flush=True)

    job = Job.read(Path(sys.argv[1]).resolve())
    try:
        described, render = make(job)
    except Skip as skip:
        say({"skip": str(skip)})
        return
    except Exception as error:
        traceback.print_exc()
        say({"error": sentence(error)})
        return
    say(described)
    shape = (job.scene["film"]["height"], job.scene["film"]["width"], 3)
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            image, seconds = render(asked["samples"], asked["seed"])
            if image.shape != shape:
                raise ValueError(f"the picture is of shape {image.shape}, not {shape}")
            if not np.isfinite(image).all():
                raise ValueError("the picture holds numbers that are not finite")
            file = f"{Path(sys.argv[0]).stem}-{asked['seed']}.npy"
            np.save(job.folder / file, image.astype(np.float32))
            say({"seconds": seconds, "image": file})
        except Exception as error:
            traceback.print_exc()
            say({"error": sentence(error)})


def sentence(error: Exception) -> str:
    """What went wrong, in one line."""
    return f"{type(error).__name__}: {error}".splitlines()[0].rstrip(".: ")
