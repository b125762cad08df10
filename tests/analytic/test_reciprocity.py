"""Light and camera exchanged: what a body in a beam sends along a view of all of it, summed over the picture, is the
same where beam and view change places, whatever is in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.analytic.scenes import (
    PHASES,
    Grid,
    Kind,
    Picture,
    Scene,
    affine,
    agree,
    ball,
    constant,
    cube_mesh,
    cuboid,
    noise,
    rectangle,
)

#: Two directions that see and light the body differently.
ONE, OTHER = [1.0, 0.4, 0.7], [-0.3, 0.9, 0.5]


def seen(scene: Scene, view: list[float], light: list[float]) -> Scene:
    """Seen along `view` by parallel rays around all of it, lit along `light`."""
    camera = {
        "kind": "orthographic",
        "origin": [0.5 - 4 * v for v in view],
        "target": [0.5] * 3,
        "up": [0.3, -1, 0.2],
        "height": 2.4,
    }
    lights = [{"kind": "directional", "direction": light, "irradiance": [3, 2, 1]}]
    return scene | {"camera": camera, "lights": lights}


def bodies(grid: Grid, folder: Path) -> dict[str, tuple[list[Kind], list[Kind]]]:
    """Media and surfaces; none are smooth, for no path finds the beam by way of a mirror."""
    mesh = {
        "kind": "mesh",
        "file": cube_mesh(folder),
        "to_world": affine([0.5, 0.2, 0], [0, 0.5, 0.1], [0.1, 0, 0.5], [0.2, 0, 0.1]),
    }
    rough = {"kind": "rough_dielectric", "ior": 1.4, "roughness": 0.4}
    lobe = PHASES["henyey_greenstein"]
    media = [
        grid(noise(4, 3, 5) ** 3, scale=20, albedo=[1, 0.9, 0.5], phase=lobe),
        constant(ball((0.2, 0.3, 0.4), 0.3), 5, 0.8, phase=PHASES["draine"]),
    ]
    return {
        "media": (media, []),
        "phases": ([constant(cuboid(), 3, 0.95, phase=PHASES["mixture"])], []),
        "coloured": ([constant(ball(), [1, 3, 9], 0.9, phase=lobe), grid(noise(3, 3, 4, 3), scale=4, albedo=0.9)], []),
        "surfaces": (
            media,
            [
                rectangle([0.5, 0, 0.2], [0, 0.3, 0.3], [0.4, 0.5, 0.9], {"kind": "diffuse", "reflectance": 0.9}),
                {**ball((0.8, 0.3, 0.3), 0.25), "material": {"kind": "diffuse", "reflectance": [0.9, 0.7, 0.5]}},
                {**ball((0.3, 0.8, 0.3), 0.2), "material": rough},
            ],
        ),
        "rough": ([constant(mesh, 4, 0.95, phase=lobe)], [mesh | {"material": rough}]),
        "rough sphere": ([constant(ball(), 4, 0.95, phase=lobe)], [ball() | {"material": rough}]),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "samples", "within"),
    [
        ("coloured", 1024, 0.01),
        ("surfaces", 4096, 0.01),
        pytest.param("media", 16384, 0.005, marks=pytest.mark.slow),
        pytest.param("phases", 16384, 0.015, marks=pytest.mark.slow),
        pytest.param("coloured", 16384, 0.003, marks=pytest.mark.slow),
        pytest.param("surfaces", 16384, 0.005, marks=pytest.mark.slow),
        pytest.param("rough", 16384, 0.02, marks=pytest.mark.slow),
        pytest.param("rough sphere", 16384, 0.01, marks=pytest.mark.slow),
    ],
)
def test_reciprocity(
    box: Scene, grid: Grid, tmp_path: Path, picture: Picture, name: str, samples: int, within: float
) -> None:
    volumes, surfaces = bodies(grid, tmp_path)[name]
    box |= {"volumes": volumes, "surfaces": surfaces}
    there, back = picture(seen(box, ONE, OTHER), samples), picture(seen(box, OTHER, ONE) | {"seed": 8}, samples)
    agree((1, there), (-1, back), within=within)
