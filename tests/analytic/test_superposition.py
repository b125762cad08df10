"""The equation is linear in its lights: a picture by all of them is the sum of the pictures by each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.analytic.scenes import (
    PHASES,
    Grid,
    Kind,
    Picture,
    Scene,
    agree,
    ball,
    constant,
    cuboid,
    noise,
    picture_of,
    random_walk,
    rectangle,
    same,
)

#: Point lights stand clear of media and surfaces: next to them one sample may be arbitrarily bright.
LIGHTS: dict[str, Kind] = {
    "point": {"kind": "point", "position": [-0.4, 0.6, -0.3], "intensity": [1, 2, 3]},
    "second point": {"kind": "point", "position": [1.4, -0.3, 0.3], "intensity": 2},
    "spot": {"kind": "spot", "position": [0.5, -0.6, 0.2], "target": [0.5, 0.5, 0.5], "intensity": 4, "cutoff": 35},
    "directional": {"kind": "directional", "direction": [1, 1, 1], "irradiance": 2},
    "sun": {"kind": "sun", "direction": [-1, 0.5, 1], "irradiance": [2, 1, 1], "angular_radius": 20},
    "sky": {"kind": "constant", "radiance": 0.3},
    "image": {"kind": "image", "scale": 0.5},
    "surface": {"kind": "emissive", "radiance": 3, "two_sided": True},
    "medium": {"kind": "constant", "epsilon": [0.3, 0.2, 0.1]},
}
MEDIA = ("constant", "grid", "coloured")


def lit(box: Scene, folder: Path, medium: Kind, *names: str) -> Scene:
    """A medium on a floor by these lights; the surface that shines is there, black, in any case."""
    lights = [LIGHTS[name] for name in names if name not in ("surface", "medium")]
    sky = {"file": picture_of(folder, noise(8, 16, 3) ** 4)}
    lights = [light | sky if light["kind"] == "image" else light for light in lights]
    shining = LIGHTS["surface"] if "surface" in names else LIGHTS["surface"] | {"radiance": 0}
    surfaces = [
        rectangle([0.7, 0, 0], [0, 0, 0.7], [0.5, 1.05, 0.5], {"kind": "diffuse", "reflectance": [0.8, 0.5, 0.2]}),
        rectangle([0, 0.2, 0.2], [0.2, 0, 0], [0.5, 0.3, 1.4], shining),
        {**ball((0.3, 0.6, 0.2), 0.1), "material": {"kind": "null"}},
    ]
    emission = {"emission": LIGHTS["medium"]} if "medium" in names else {}
    return random_walk(box, lights=lights, surfaces=surfaces, volumes=[medium | emission])


@pytest.fixture
def media(grid: Grid) -> dict[str, Kind]:
    phase = PHASES["two_lobe"]
    return {
        "constant": constant(cuboid(), 2, [0.9, 0.8, 0.7], phase=phase),
        "grid": grid(noise(5, 4, 6), scale=4, albedo=[0.9, 0.8, 0.7], phase=phase),
        "coloured": constant(ball(), [1, 2, 4], 0.9, phase=phase),
    }


def test_of_all_lights(box: Scene, tmp_path: Path, picture: Picture, media: dict[str, Kind]) -> None:
    first, second = list(LIGHTS)[::2], list(LIGHTS)[1::2]
    scenes = [lit(box, tmp_path, media["constant"], *names) for names in (LIGHTS, first, second)]
    films = [picture(scene | {"seed": seed}, 512) for seed, scene in enumerate(scenes)]
    agree((1, films[0]), (-1, films[1]), (-1, films[2]), within=0.008)


@pytest.mark.slow
@pytest.mark.parametrize("medium", MEDIA)
def test_of_every_light(box: Scene, tmp_path: Path, picture: Picture, media: dict[str, Kind], medium: str) -> None:
    whole = picture(lit(box, tmp_path, media[medium], *LIGHTS), 4096)
    scenes = [lit(box, tmp_path, media[medium], name) for name in LIGHTS]
    parts = [picture(scene | {"seed": 8 + light}, 1024) for light, scene in enumerate(scenes)]
    agree((1, whole), *((-1, part) for part in parts), within=0.006)


@pytest.mark.slow
@pytest.mark.parametrize("medium", MEDIA)
@pytest.mark.parametrize("name", [name for name in LIGHTS if name not in ("surface", "medium")])
def test_twice_a_light_is_twice_as_bright(
    box: Scene, tmp_path: Path, picture: Picture, media: dict[str, Kind], medium: str, name: str
) -> None:
    """Once by a number, once by two of it, of which each is sampled half as often."""
    scene = lit(box, tmp_path, media[medium], name)
    once, (light,) = picture(scene, 1024), scene["lights"]
    scene |= {"lights": [light, light], "seed": 8}
    agree((2, once), (-1, picture(scene, 1024)), within=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("medium", MEDIA)
def test_sun_is_a_sphere_far_away(
    box: Scene, tmp_path: Path, picture: Picture, media: dict[str, Kind], medium: str
) -> None:
    """Its rays are parallel but for the medium's size over its distance; the middle of all is where they should be."""
    angle, distance = np.radians(30), 300.0
    towards = np.array([2.0, -1.0, -2.0]) / 3
    sun = {
        "kind": "sun",
        "direction": (-towards).tolist(),
        "irradiance": np.pi * np.sin(angle) ** 2,
        "angular_radius": 30,
    }
    scene = random_walk(box, volumes=[media[medium]], lights=[sun])
    by_sun = picture(scene, 1024)
    far: dict[str, Any] = ball(tuple((0.5 + distance * towards).tolist()), distance * float(np.sin(angle)))
    scene |= {"seed": 8, "lights": [], "surfaces": [far | {"material": {"kind": "emissive", "radiance": 1}}]}
    same(picture(scene, 1024), by_sun, within=0.005)
