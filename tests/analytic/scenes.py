"""What the laws are tested on: scenes of every kind, and how pictures are compared."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from numpy.typing import NDArray
from tests.statistics import NEGLIGIBLE, accept_z

from woodcock.film import Film

Scene = dict[str, Any]
Kind = dict[str, Any]
Grid = Callable[..., Kind]
Picture = Callable[..., Film]

#: Of a picture's mean in float32 weights, relative.
ROUNDING = 1e-6
COSINES = np.linspace(-1, 1, 9)

PHASES: dict[str, Kind] = {
    "isotropic": {},
    "henyey_greenstein": {"g": 0.8},
    "two_lobe": {"g1": 0.9, "g2": -0.4, "weight": 0.7},
    "rayleigh": {},
    "draine": {"g": 0.5, "alpha": 1},
    "mie_approx": {"diameter": 20},
    "tabulated": {"cosine": COSINES.tolist(), "value": np.exp(2 * COSINES).tolist()},
}
PHASES = {kind: {"kind": kind, **numbers} for kind, numbers in PHASES.items()}
MIXTURE: Kind = {
    "kind": "mixture",
    "components": [{"weight": weight, "phase": phase} for weight, phase in enumerate(PHASES.values(), 1)],
}
PHASES["mixture"] = MIXTURE


def noise(*shape: int, seed: int = 3) -> NDArray[np.float32]:
    return np.random.default_rng(seed).random(shape, dtype=np.float32)


def ball(center: tuple[float, float, float] = (0.5, 0.5, 0.5), radius: float = 0.5) -> Kind:
    return {"kind": "sphere", "center": list(center), "radius": radius}


def cuboid(low: float = 0, high: float = 1) -> Kind:
    return {"kind": "box", "min": [low] * 3, "max": [high] * 3}


def constant(shape: Kind, sigma_t: Any, albedo: Any, **keys: Any) -> Kind:
    return {"kind": "constant", "shape": shape, "sigma_t": sigma_t, "albedo": albedo, **keys}


def affine(x: list[float], y: list[float], z: list[float], origin: list[float]) -> list[list[float]]:
    """By its columns."""
    return [*([*row] for row in zip(x, y, z, origin, strict=True)), [0, 0, 0, 1]]


def rectangle(x: list[float], y: list[float], center: list[float], material: Kind) -> Kind:
    """x, y: from the middle to two of its edges."""
    placed = affine(x, y, np.cross(x, y).tolist(), center)
    return {"kind": "rectangle", "to_world": placed, "material": material}


def cube_mesh(folder: Path) -> str:
    """A PLY file of the cube from 0 to 1."""
    corners = list(itertools.product((0, 1), repeat=3))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    lines = ["ply", "format ascii 1.0", "element vertex 8", *(f"property float {axis}" for axis in "xyz")]
    lines += ["element face 6", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(str, corner)) for corner in corners]
    lines += [" ".join(map(str, (4, *face))) for face in faces]
    file = folder / "cube.ply"
    file.write_text("\n".join([*lines, ""]))
    return str(file)


def picture_of(folder: Path, pixels: Any) -> str:
    """An EXR file of pixels (height, width, 3)."""
    pixels = np.asarray(pixels, np.float32)
    file = folder / f"picture{len(list(folder.iterdir()))}.exr"
    out = oiio.ImageOutput.create(str(file))
    out.open(str(file), oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, oiio.FLOAT))
    out.write_image(pixels)
    out.close()
    return str(file)


def white_image(folder: Path) -> Kind:
    return {"kind": "image", "file": picture_of(folder, np.ones((4, 8, 3)))}


def random_walk(scene: Scene, **keys: Any) -> Scene:
    """By random paths, where a scene that does not scatter would be solved without."""
    return scene | {"integrator": {"kind": "volumetric_path"}} | keys


def is_clean(film: Film) -> bool:
    return film.rejected == film.violations == 0


def is_white(film: Film) -> bool:
    """Every pixel is 1, to the rounding of weights along a path."""
    return is_clean(film) and bool(np.abs(film.mean - 1).max() < 1e-4)


def balance(*terms: tuple[float, Film], expected: Any = 0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Σ weight × a picture's mean - expected, of every channel, and its standard error.

    Channels share their paths: only within one are errors independent.
    """
    difference = sum(weight * film.mean.mean(axis=(0, 1)) for weight, film in terms) - np.asarray(expected)
    variance = sum(weight**2 * film.variance().mean(axis=(0, 1)) / film.count.size for weight, film in terms)
    return np.asarray(difference), np.sqrt(np.asarray(variance))


def agree(*terms: tuple[float, Film], expected: Any = 0, within: float = 0.003, exact: bool = True) -> None:
    """Accepts that the sum is as expected, and asserts that it is known to `within` of the first picture's mean.

    Pictures must have seeds of their own: errors of the same random numbers are not independent. Channels share their
    paths, so the first alone counts as exact.
    """
    assert all(is_clean(film) for _, film in terms)
    difference, error = balance(*terms, expected=expected)
    scale = np.abs(terms[0][0]) * terms[0][1].mean.mean(axis=(0, 1))
    assert np.all(error <= within * scale), f"known to {np.max(error / scale):.2g} only"
    off = np.maximum(np.abs(difference) - ROUNDING * scale, 0)
    z = np.divide(off, error, out=np.where(off > 0, np.inf, 0.0), where=error > 0)
    what = f"off by {difference / scale} of it,"
    accept_z(z[0], what, exact=exact and bool(ROUNDING * scale[0] < NEGLIGIBLE * error[0]))
    if z.size > 1:
        accept_z(z[1:], what, exact=False)


def same(a: Film, b: Film, within: float = 0.003, exact: bool = True) -> None:
    agree((1, a), (-1, b), within=within, exact=exact)
