"""Woodcock as one peer of many: `python woodcock_side.py FOLDER`, by an interpreter that has it.

Beside what every adapter says, this one names the device, and whether the scene has no random numbers.
"""

from __future__ import annotations

import os
import time
from functools import cache
from typing import Any

import numpy as np
from protocol import Image, Job, Render, serve

import woodcock
from woodcock.device import find
from woodcock.render import Renderer, read_file
from woodcock.scene import Scene


def make(job: Job) -> tuple[dict[str, Any], Render]:
    """Scenes are rendered as they stand: what may be chosen is the program's own choice."""
    os.chdir(job.folder)
    scene, read = Scene.model_validate(job.scene), cache(read_file)
    device = find()

    def render(samples: int, seed: int) -> tuple[Image, float]:
        renderer = Renderer(scene.model_copy(update={"seed": seed}), device, read=read)
        renderer.render(0, 1)
        began = time.perf_counter()
        film = renderer.render(0, samples)
        seconds = time.perf_counter() - began
        return np.broadcast_to(film.layer("").mean, (film.height, film.width, 3)), seconds

    own = Renderer(scene, device, read=read)
    facts = own.facts()
    kinds = ", ".join(f"{name} {own.kinds[name][0]}" for name in ("integrator", "majorant") if own.kinds.get(name))
    described = {
        "name": "Woodcock",
        "version": woodcock.__version__,
        "settings": f"{kinds}, {own.lanes} lanes of {facts['precision']}s",
        "device": f"{device.name}, {device.compute_units} compute units",
        "driver": f"{device.platform} {device.driver}",
        "doubles": facts["precision"] == "double",
        "deterministic": own.deterministic,
    }
    return described, render


if __name__ == "__main__":
    serve(make)
