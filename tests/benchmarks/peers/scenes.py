"""The scenes that this renderer and its peers render, each written to a folder as a scene file and its grids."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter

from woodcock.emission.blackbody import radiance
from woodcock.formats import read_grid
from woodcock.scene import BlackbodyEmission
from woodcock.space import Array

Scene = dict[str, Any]

SIDE = 256
#: Volumes of others, beside the repository.
DATA = Path(__file__).resolve().parents[3].parent / "shared" / "data"
FILM = {"width": SIDE, "height": SIDE}


@dataclass(frozen=True)
class Case:
    """A scene of the comparison. file: of DATA that it needs; write: its grids into a folder, and the scene."""

    name: str
    says: str
    write: Callable[[Path], Scene]
    file: str | None = None

    def written(self, folder: Path) -> Scene:
        """The scene; in the folder, its grids and itself as scene.json."""
        scene = self.write(folder)
        (folder / "scene.json").write_text(json.dumps(scene, indent=1))
        return scene


def noise(n: int, seed: int = 1) -> Array:
    """A ball of band-limited noise, (n, n, n) in [0, 1], indexed [z][y][x]."""
    rng, total = np.random.default_rng(seed), np.zeros((n, n, n), np.float32)
    for width, weight in ((n / 8, 1.0), (n / 16, 0.5), (n / 32, 0.25), (n / 64, 0.12)):
        octave = gaussian_filter(rng.standard_normal((n, n, n)).astype(np.float32), width, mode="wrap")
        total += weight * octave / octave.std()
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    density = np.clip(total * 0.6 + 1.2 - 2.0 * np.sqrt(x**2 + y**2 + z**2), 0, None)
    return np.asarray(density / density.max())


def _bytes(folder: Path) -> None:
    np.save(folder / "density.npy", np.round(noise(128) * 255).astype(np.uint8))


def cloud(folder: Path) -> Scene:
    _bytes(folder)
    return {
        "camera": {
            "kind": "orthographic",
            "origin": [0.5, 0.5, -1],
            "target": [0.5, 0.5, 0.5],
            "up": [0, -1, 0],
            "height": 1,
        },
        "volumes": [{"kind": "grid", "file": "density.npy", "scale": 40 / 255, "albedo": 0.9}],
        "lights": [{"kind": "constant", "radiance": 1}],
        "film": FILM,
    }


def cloud_sun(folder: Path) -> Scene:
    _bytes(folder)
    phase = {"kind": "henyey_greenstein", "g": 0.85}
    return {
        "camera": {"kind": "perspective", "origin": [0.5, 0.35, -1.6], "target": [0.5, 0.5, 0.5], "fov": 30},
        "volumes": [{"kind": "grid", "file": "density.npy", "scale": 40 / 255, "albedo": 0.99, "phase": phase}],
        "lights": [
            {"kind": "constant", "radiance": [0.3, 0.5, 0.9]},
            {"kind": "directional", "direction": [-0.5, -1, 0.3], "irradiance": [3, 2.8, 2.4]},
        ],
        "film": FILM,
    }


def smoke(folder: Path) -> Scene:
    (folder / "smoke.vdb").write_bytes((DATA / "smoke.vdb").read_bytes())
    return {
        "camera": {"kind": "perspective", "origin": [-90, 55, 190], "target": [-6, 40, 0], "fov": 35},
        "volumes": [
            {
                "kind": "grid",
                "file": "smoke.vdb",
                "scale": 2.5,
                "albedo": [0.93, 0.92, 0.9],
                "phase": {"kind": "henyey_greenstein", "g": 0.6},
            }
        ],
        "lights": [
            {"kind": "constant", "radiance": [0.1, 0.13, 0.19]},
            {"kind": "directional", "direction": [1, -0.35, -0.25], "irradiance": [7, 6.0, 4.8]},
        ],
        "film": FILM,
    }


def fog_spot(folder: Path) -> Scene:
    return {
        "camera": {"kind": "perspective", "origin": [0, 1.5, 9], "target": [0, 1.8, 0], "fov": 38},
        "volumes": [
            {
                "kind": "constant",
                "shape": {"kind": "box", "min": [-8, -0.5, -8], "max": [8, 6, 8]},
                "sigma_t": 0.07,
                "albedo": 0.8,
                "phase": {"kind": "henyey_greenstein", "g": 0.6},
            }
        ],
        "surfaces": [
            {
                "kind": "rectangle",
                "to_world": [[12, 0, 0, 0], [0, 0, 12, 0], [0, -12, 0, 0], [0, 0, 0, 1]],
                "material": {"kind": "diffuse", "reflectance": [0.2, 0.19, 0.18]},
            },
            {
                "kind": "sphere",
                "center": [0.4, 1.2, 0],
                "radius": 0.6,
                "material": {"kind": "diffuse", "reflectance": [0.6, 0.25, 0.18]},
            },
        ],
        # Its edge is sharp, as renderers differ in how they soften one.
        "lights": [
            {
                "kind": "spot",
                "position": [-3.2, 7, -1.5],
                "target": [0.6, 0.9, 0.2],
                "intensity": [420, 390, 330],
                "cutoff": 17,
                "beam": 16.99,
            },
            {"kind": "constant", "radiance": [0.012, 0.016, 0.024]},
        ],
        "film": FILM,
    }


def milk(folder: Path) -> Scene:
    return {
        "camera": {"kind": "perspective", "origin": [0, 0, 4.2], "target": [0, 0, 0], "fov": 30},
        "volumes": [
            {
                "kind": "constant",
                "shape": {"kind": "sphere", "center": [0, 0, 0], "radius": 1},
                "sigma_t": [24, 28, 36],
                "albedo": [0.9995, 0.9988, 0.995],
                "phase": {"kind": "henyey_greenstein", "g": 0.75},
            }
        ],
        "lights": [
            {"kind": "constant", "radiance": [0.25, 0.32, 0.42]},
            {"kind": "directional", "direction": [-0.6, -1, -0.5], "irradiance": [3, 2.8, 2.4]},
        ],
        "film": FILM,
    }


def fire(folder: Path) -> Scene:
    """Fire by its temperatures. Its emission is baked: ε of a voxel, which every renderer interpolates alike."""
    density, temperature = (read_grid(DATA / "fireball.vdb", name) for name in ("density", "temperature"))
    scale, albedo = 30.0, 0.7
    glow = BlackbodyEmission(kelvin=800, reference=2000, luminance=4)
    sigma_a = scale * (1 - albedo) * density.values.astype(float)
    np.save(folder / "density.npy", density.values.astype(np.float32))
    epsilon = sigma_a[..., None] * radiance(glow, 800 * temperature.values.astype(float))
    np.save(folder / "emission.npy", epsilon.astype(np.float32))
    return {
        "camera": {
            "kind": "perspective",
            "origin": [1.4, -3.6, 1.3],
            "target": [1.4, 1.4, 1.6],
            "up": [0, 0, 1],
            "fov": 26,
        },
        "volumes": [
            {
                "kind": "grid",
                "file": "density.npy",
                "to_world": (density.index_to_world @ np.diag([*density.values.shape[::-1], 1.0])).tolist(),
                "scale": scale,
                "albedo": albedo,
                "phase": {"kind": "henyey_greenstein", "g": 0.3},
                "emission": {"kind": "grid", "file": "emission.npy"},
            }
        ],
        "lights": [{"kind": "constant", "radiance": [0.05, 0.07, 0.1]}],
        "film": FILM,
    }


#: The head phantom of L. A. Shepp and B. F. Logan (1974) in three dimensions, with the contrast of P. Toft (1996):
#: value, half axes, middle, and the turn about z in degrees.
_HEAD = (
    (1.0, (0.69, 0.92, 0.81), (0, 0, 0), 0),
    (-0.8, (0.6624, 0.874, 0.78), (0, -0.0184, 0), 0),
    (-0.2, (0.11, 0.31, 0.22), (0.22, 0, 0), -18),
    (-0.2, (0.16, 0.41, 0.28), (-0.22, 0, 0), 18),
    (0.1, (0.21, 0.25, 0.41), (0, 0.35, -0.15), 0),
    (0.1, (0.046, 0.046, 0.05), (0, 0.1, 0.25), 0),
    (0.1, (0.046, 0.046, 0.05), (0, -0.1, 0.25), 0),
    (0.1, (0.046, 0.023, 0.05), (-0.08, -0.605, 0), 0),
    (0.1, (0.023, 0.023, 0.02), (0, -0.606, 0), 0),
    (0.1, (0.023, 0.046, 0.02), (0.06, -0.605, 0), 0),
)


def phantom(n: int) -> Array:
    """(n, n, n) float32, smoothed over about a voxel as scanners do."""
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    total = np.zeros((n, n, n))
    for value, (a, b, c), (p, q, r), degrees in _HEAD:
        cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        u, v = (x - p) * cosine + (y - q) * sine, (y - q) * cosine - (x - p) * sine
        total[(u / a) ** 2 + (v / b) ** 2 + ((z - r) / c) ** 2 <= 1] += value
    return gaussian_filter(np.maximum(total, 0), 0.8).astype(np.float32)


def ct(folder: Path) -> Scene:
    np.save(folder / "phantom.npy", phantom(192))
    return {
        "camera": {"kind": "perspective", "origin": [2.4, 1.1, -1.3], "target": [0.5, 0.5, 0.5], "fov": 26},
        "volumes": [{"kind": "grid", "file": "phantom.npy", "scale": 4.0, "albedo": 0}],
        "lights": [{"kind": "constant", "radiance": 1}],
        "film": FILM,
    }


def stiff(folder: Path) -> Scene:
    """A ball of σ_t 10⁴ in haze of σ_t 1/2, with nothing around."""
    n = 64
    z, y, x = np.meshgrid(*[np.arange(n) + 0.5] * 3, indexing="ij")
    haze = np.pad(np.full((n - 2, n - 2, n - 2), 0.5), 1)
    core = (x - 30) ** 2 + (y - 34) ** 2 + (z - 31) ** 2 < 4**2
    np.save(folder / "density.npy", np.where(core, 1e4, haze).astype(np.float32))
    return {
        "camera": {"kind": "perspective", "origin": [0.5, 0.6, -1.8], "target": [0.5, 0.5, 0.5], "fov": 32},
        "volumes": [{"kind": "grid", "file": "density.npy", "scale": 1, "albedo": 0.9}],
        "lights": [
            {"kind": "constant", "radiance": 0.5},
            {"kind": "directional", "direction": [1, -1, 0.6], "irradiance": 2},
        ],
        "film": FILM,
    }


CASES = (
    Case("cloud", "grey cloud of 128³ bytes, isotropic, σ_t 40, albedo 0.9, under a white sky", cloud),
    Case("cloud_sun", "the same with albedo 0.99 and g 0.85, under sun and sky", cloud_sun),
    Case("smoke", "sparse smoke from a VDB file, coloured albedo, g 0.6, under sun and sky", smoke, "smoke.vdb"),
    Case("fog_spot", "thin homogeneous fog, a spot light's shaft, a floor and a ball", fog_spot),
    Case("milk", "a ball of dense homogeneous milk, coloured extinction, albedo above 0.99, under sun and sky", milk),
    Case("fire", "emission, absorption and scattering by a grid of temperatures", fire, "fireball.vdb"),
    Case("ct", "absorption alone through a phantom of 192³ floats", ct),
    Case("stiff", "a ball of σ_t 10⁴ in thin haze, under sun and sky", stiff),
)
