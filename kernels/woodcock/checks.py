"""Laws that a program must keep, asked of the very program that rendered a picture, on the very device.

A program depends on a scene's kinds, not on its numbers: the same scene with numbers for which the answer is known is
rendered by the same text, to the hash. Where there are no such numbers, or they would make another program, a law reads
"not checked". What is found is kept on disk by program and device.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Literal, TypedDict

import numpy as np

from woodcock import __version__, laws
from woodcock.device import Device, cache_folder
from woodcock.files import replacing
from woodcock.film import Film
from woodcock.formats import Grid, VolumeError
from woodcock.generic import widen
from woodcock.image import ImageError
from woodcock.layout import Layout, Read
from woodcock.plan import lay_out, settled
from woodcock.probe import best_lanes, probe
from woodcock.render import Renderer, program_of
from woodcock.scene import Scene, SceneError

#: Samples per pixel of a law's picture, and pixels along its longer side.
SAMPLES, SIDE = 64, 16

#: A law holds within so many standard errors of a picture's mean, by chance broken once in 2 million times, and so much
#: of it besides, for the rounding of weights along a path.
STANDARD_ERRORS, ROUNDING = 5.0, 1e-4

#: Grids are thinned to so many voxels along each side: laws hold for any.
VOXELS = 48


class Check(TypedDict):
    """deviation: from what the law says, in standard errors of noise, or relative; limit: that it must keep."""

    name: str
    law: str
    status: Literal["passed", "failed", "not checked"]
    deviation: float | None
    unit: Literal["standard errors", "relative"]
    limit: float | None
    reason: str


def checked(scene: Scene, device: Device, program_hash: str, read: Read, *, full: bool = False) -> list[Check]:
    """Every law's check for a program on a device, looked up or made now. Raises DeviceError.

    read: gives the scene's grids; full: the program is the one with everything switched on, whose text does not tell
    what a scene uses of it.
    """
    of = scene.model_dump_json() if full else ""
    key = hashlib.sha256(f"{program_hash}|{device.identity}|{__version__}{of}".encode()).hexdigest()
    kept = cache_folder() / "checks" / f"{key[:32]}.json"
    try:
        found: list[Check] = json.loads(kept.read_text())
        return found
    except (OSError, ValueError):
        found = list(_all(scene, device, program_hash, cache(read), full))
    kept.parent.mkdir(exist_ok=True)
    with replacing(kept) as temporary:
        temporary.write_text(json.dumps(found))
    return found


def thinned(read: Read) -> Read:
    """Gives every grid by a part of its voxels, in the same place."""

    def few(file: str, name: str | None) -> Grid:
        grid = read(file, name)
        values, step = grid.values, max(1, math.ceil(max(grid.values.shape[:3]) / VOXELS))
        if step == 1:
            return grid
        for axis in range(3):  # maxima, so that what is sparse is not lost
            values = np.maximum.reduceat(values, np.arange(0, values.shape[axis], step), axis=axis)
        return replace(grid, values=values, index_to_world=grid.index_to_world @ np.diag([step, step, step, 1.0]))

    return few


def _all(scene: Scene, device: Device, program_hash: str, read: Read, full: bool) -> Iterator[Check]:
    longer = max(scene.film.width, scene.film.height)
    width, height = (max(1, round(SIDE * side / longer)) for side in (scene.film.width, scene.film.height))
    small = scene.model_copy(update={"film": scene.film.model_copy(update={"width": width, "height": height})})
    lanes = best_lanes(device, probe(device))

    def is_own(layout: Layout) -> bool:
        return program_of(layout, device, lanes)[0].hash == program_hash

    laid_out = widen if full else lay_out
    few = cache(thinned(read))
    # Settled now: with numbers for which the answer is known, another majorant might suit the scene.
    asked = settled(small, few)
    layout = laid_out(asked, few)
    if is_own(layout):
        read = few
    else:
        asked = settled(small, read)

    def render(changed: Scene, *, own: bool = True, samples: int | None = None) -> Film:
        if own and not is_own(laid_out(changed, read)):
            raise laws.DoesNotApply("with numbers for which the answer is known, the program would be another one")
        return Renderer(changed, device, read=read, full=own and full).render(0, samples or SAMPLES)

    for law in laws.laws_of(scene):
        yield _check(law, asked, layout, render)


def _check(law: laws.Law, scene: Scene, layout: Layout, render: laws.Render) -> Check:
    check: Check = {
        "name": law.name, "law": law.says, "status": "not checked",
        "deviation": None, "unit": "relative", "limit": None, "reason": "",
    }  # fmt: skip
    try:
        answer = law.ask(scene, layout, render)
    except laws.DoesNotApply as reason:
        return check | {"reason": str(reason)}
    except (SceneError, VolumeError, ImageError) as error:
        return check | {"reason": f"a scene to check it by cannot be made: {error}"}
    if answer.noise > 0:
        off = max(abs(answer.deviation) - ROUNDING * answer.scale, 0.0) / answer.noise
        check |= {"unit": "standard errors", "limit": STANDARD_ERRORS}
    else:
        off = abs(answer.deviation) / answer.scale
        check |= {"limit": ROUNDING}
    limit = check["limit"] or 0.0
    check |= {"status": "passed" if off <= limit else "failed", "deviation": off if math.isfinite(off) else None}
    if check["status"] == "failed":
        check["reason"] = f"off by {off:.3g} {'standard errors' if answer.noise > 0 else 'of it'}"
    return check
