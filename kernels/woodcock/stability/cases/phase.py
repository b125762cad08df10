"""Phase functions, g from -0.9999 to 0.9999 and on to 1."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, by_hits, on_average, white
from woodcock.stability.scenes import LOOPS, PATHS, Kind, beam, block, cube, parallel, seen, square

GROUP = "phase function"
ASYMMETRIES = (-0.9999, -0.999, -0.9, -0.5, -1e-6, 0.0, 1e-6, 0.5, 0.9, 0.999, 0.9999)


def _hg(g: float) -> Kind:
    return {"kind": "henyey_greenstein", "g": g}


def _cube(sigma: float, albedo: float, phase: Kind, keys: Kind, folder: Path) -> Description:
    return seen(cube(sigma, albedo, phase=phase)) | keys


def _beam(g: float, cosine: float, keys: Kind, folder: Path) -> Description:
    """τ = 1, seen along the beam or against it, of an albedo so small that what scatters twice does not count, though a
    lobe that points back turns light back by two scatterings rather than not at all; as bright as if all light that
    scatters went this way."""
    albedo = 1e-6 if g > -0.1 else 1e-14
    light = beam(1 / (albedo * exact.henyey_greenstein(g, cosine)), (0, 0, -cosine))
    return seen(cube(1.0, albedo, phase=_hg(g)), lights=[light]) | keys | square(16)


def _wide(tau: float, albedo: float, g: float, keys: Kind, folder: Path) -> Description:
    medium = block(1.0, albedo, (-2000, -2000, 0), (2000, 2000, tau), phase=_hg(g))
    return seen(medium, camera=parallel((0, 0, -1), (0, 0, 0), 1)) | keys | square(16)


def _mixture(*phases: Kind) -> Kind:
    return {"kind": "mixture", "components": [{"weight": w, "phase": p} for w, p in zip(WEIGHTS, phases, strict=True)]}


WEIGHTS = (1e12, 1.0, 1e-12, 3.0, 1e6, 1.0, 1e-6)
#: Of every kind, at its ends.
EVERY = {
    "forward": _mixture(
        {"kind": "isotropic"},
        _hg(0.9999),
        {"kind": "two_lobe", "g1": 0.9999, "g2": -0.9999, "weight": 0.5},
        {"kind": "rayleigh"},
        {"kind": "draine", "g": 0.9999, "alpha": 1},
        {"kind": "mie_approx", "diameter": 5},
        {"kind": "tabulated", "cosine": [-1, 1 - 1e-12, 1], "value": [0, 0, 1]},
    ),
    "backward": _mixture(
        {"kind": "isotropic"},
        _hg(-0.9999),
        {"kind": "two_lobe", "g1": 0.9999, "g2": -0.9999, "weight": 1e-6},
        {"kind": "rayleigh"},
        {"kind": "draine", "g": -0.9999, "alpha": 1e6},
        {"kind": "mie_approx", "diameter": 50},
        {"kind": "tabulated", "cosine": [-1, 0, 1e-9, 1], "value": [1, 1e-12, 1, 1e-12]},
    ),
}


def _cases() -> Iterator[Case]:
    for g in ASYMMETRIES:
        for loop, keys in LOOPS.items():
            name = f"g = {g:g}"
            yield white(GROUP, f"{name}, furnace, {loop}", partial(_cube, 10.0, 1.0, _hg(g), keys))
            back = partial(_beam, g, -1.0, keys)
            yield on_average(GROUP, f"{name}, a beam's way back, {loop}", back, lambda: exact.slab(2) / 2, (0, 64))
            if g > -0.9999:
                # t e^-t at 1, whatever the depth of the vertex.
                on = partial(_beam, g, 1.0, keys)
                yield on_average(GROUP, f"{name}, a beam's way on, {loop}", on, lambda: math.exp(-1), (0, 64))
    for loop, keys in LOOPS.items():
        for g in (-0.9, -0.5, -1e-6, 0.5, 0.9):
            scene, right = partial(_wide, 2.0, 0.8, g, keys), partial(exact.lit_slab, 0.8, g, 2.0)
            yield on_average(GROUP, f"g = {g:g}, slab under a sky, {loop}", scene, right, (0, 2048))
        # Light that hardly turns, or turns back: its path lengthens by 1e-4 a scattering, less than noise.
        scene = partial(_wide, 4.0, 0.5, 0.9999, keys)
        yield on_average(GROUP, f"g = 0.9999, straight on, {loop}", scene, lambda: math.exp(-2), (0, 256))
        scene = partial(_wide, 4.0, 0.5, -0.9999, keys)
        yield on_average(GROUP, f"g = -0.9999, to and fro, {loop}", scene, partial(exact.rod, 0.5, 4.0), (0, 256))
    scene = partial(_wide, 4.0, 0.5, 1.0, PATHS)
    yield by_hits(GROUP, "g = 1, straight on", scene, lambda: math.exp(-2), (0, 64))
    yield white(GROUP, "g = 1, furnace", partial(_cube, 1e6, 1.0, _hg(1), PATHS))
    for name, phase in EVERY.items():
        yield white(GROUP, f"every kind, {name}, furnace", partial(_cube, 10.0, 1.0, phase, PATHS))


CASES = tuple(_cases())
