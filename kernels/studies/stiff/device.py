"""The renderer's own integrators on a problem's scene, and how often they looked σ_t and ε up.

Look-ups are counted by the device: the same program with a counter in it, which comes back in the place where the
film counts majorants that were too low (there are none here).
"""

from __future__ import annotations

import json
import re
import tempfile
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np

from studies.stiff.problems import Problem
from woodcock.device import Context, Device
from woodcock.evaluate import evaluate
from woodcock.film import Film
from woodcock.render import Renderer
from woodcock.scene import parse

#: Pattern -> what stands for it in the program that counts, for the integrators whose text has the first pattern.
#: A step of `emission_absorption`, accepted or not, takes five look-ups of (σ_t, ε) in both of its passes.
STEPS = {
    r"(real doubt;)(\s*// how many roundings)": r"\1 integer looked;\2",
    r"\bmedia_walk media;": "media_walk media; found->looked = (integer)0;",
    r"\bmask fine = active, resolved;": "mask fine = active, resolved; found->looked -= 5 * active;",
    r"(\bgather_emission\(world, &ray[^;]*;)": r"\1 amiss.violations += found.looked;",
}
#: A tentative collision looks σ_t up in one place, and ε in another on the way there.
FLIGHTS = {r"\baudit_majorant\(found,[^;]*;": "found->violations -= 2 * (active & ~p->walking);"}
#: A walk looks σ_t up alone.
WALKS = {r"\baudit_majorant\(found,[^;]*;": "found->violations -= active & p->walking;"}


class Result(NamedTuple):
    """value: L(0), the mean of all samples; error: its standard error, or of ours without noise the bound it states;
    evaluations: of all samples together; samples."""

    value: float
    error: float
    evaluations: int
    samples: int


def scene(problem: Problem, folder: Path, side: int, **keys: Any) -> Any:
    """A camera of side × side pixels that look along z, through the unit cube."""
    camera = {"kind": "orthographic", "origin": [0.5, 0.5, -1], "target": [0.5, 0.5, 0.5], "height": 0.5}
    film = {"width": side, "height": side}
    described = {"camera": camera, "volumes": problem.volumes(folder), "film": film, "seed": 1}
    return parse(json.dumps(described | problem.scene | keys))


def emission_absorption(device: Device, problem: Problem, tolerance: float = 1e-4) -> Result:
    """One ray, deterministic; error: the bound."""
    integrator = {"kind": "emission_absorption", "tolerance": tolerance}
    film, evaluations = _render(device, problem, STEPS, 1, 1, integrator=integrator)
    assert film.bound is not None
    return Result(float(film.mean[0, 0, 0]), float(film.bound[0, 0, 0]), evaluations, 1)


def volumetric_path(
    device: Device, problem: Problem, samples: int, *, side: int = 32, layer: str = "", majorant: int | None = None
) -> Result:
    """Delta tracking of one ray by side² × samples paths; layer `transmittance`: ratio tracking. majorant: cells of the
    bound on σ_t, one for all by default.
    """
    keys: dict[str, Any] = {"integrator": {"kind": "volumetric_path"}, "layers": [layer] if layer else []}
    if majorant:
        keys["majorant"] = {"kind": "grid", "resolution": majorant}
    grids = any(volume["kind"] == "grid" for volume in scene_media(problem))
    counter = (WALKS if layer else FLIGHTS) if grids else {}
    film, evaluations = _render(device, problem, counter, side, samples, **keys)
    paths = side * side * samples
    if not grids:  # A path asks every medium once for its clock and once for its emission.
        evaluations = 2 * len(scene_media(problem)) * paths
    chosen = film.layer(layer)
    error = float(np.sqrt(chosen.variance().sum())) / chosen.mean.size
    return Result(float(chosen.mean.mean()), error, evaluations, paths)


def scene_media(problem: Problem) -> list[dict[str, Any]]:
    with tempfile.TemporaryDirectory() as folder:
        return problem.volumes(Path(folder))


def _render(
    device: Device, problem: Problem, counter: dict[str, str], side: int, samples: int, **keys: Any
) -> tuple[Film, int]:
    """The film, and the look-ups that the counter found."""
    with tempfile.TemporaryDirectory() as folder, mock.patch.object(Context, "build", _building(counter)):
        film = Renderer(scene(problem, Path(folder), side, **keys), device).render(0, samples)
    if film.rejected:
        raise RuntimeError(f"{problem.name}: {film.rejected} samples were rejected")
    return film, film.violations


def _building(counter: dict[str, str]) -> Any:
    build = Context.build

    def counting(self: Context, text: str, *rest: Any) -> Any:
        for pattern, replacement in counter.items():
            text, found = re.subn(pattern, replacement, text)
            if found != 1:
                raise RuntimeError(f"the kernel has {pattern!r} {found} times: the study no longer fits it")
        return build(self, text, *rest)

    return counting


def advanced(device: Device, steps: int, step: float, *, compensated: bool, start: float = 0.5) -> float:
    """Where a walk in float32 comes to by so many steps: by `walk_advance` of majorant/walk.h, or by t += step."""
    add = "walk_advance(&t, &t_low, s, test(s > 0.f));" if compensated else "t += s;"
    body = f"real t = a, t_low = (real)0.f;\nfor (int k = 0; k < {steps}; ++k) {{ {add} }}"
    inputs = {"a": np.array([start], np.float32), "s": np.array([step], np.float32)}
    parts = ["core/rng.h", "core/vector.h", "majorant/walk.h"]
    return float(evaluate(Context.on(device), ["t"], inputs, lanes=1, parts=parts, body=body)[0, 0])
