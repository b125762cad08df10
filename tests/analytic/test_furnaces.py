"""White furnace: nothing absorbs and light comes from everywhere, so every pixel is 1, whatever is in the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.analytic import scenes
from tests.analytic.scenes import PHASES, Grid, Kind, Picture, Scene, agree, ball, constant, cuboid, is_white, noise

SKY = {"kind": "constant", "radiance": 1}
WHITES: dict[str, Kind] = {
    "diffuse": {"kind": "diffuse", "reflectance": 1},
    "mirror": {"kind": "mirror", "reflectance": 1},
    "dielectric": {"kind": "dielectric", "ior": 1.5},
    "null": {"kind": "null"},
}
TILTED = scenes.affine([0.6, 0.2, 0], [-0.1, 0.7, 0.3], [0.2, -0.3, 0.5], [0.2, 0.2, 0.3])


def media(grid: Grid, folder: Path, sigma: float) -> dict[str, Kind]:
    """Media of every kind and shape that fill much of the unit cube and scatter all."""
    mesh = {"kind": "mesh", "file": scenes.cube_mesh(folder)}
    ones = folder / "ones.npy"
    np.save(ones, np.ones((2, 3, 2), np.float32))
    return {
        "box": constant(cuboid(), sigma, 1),
        "tilted box": constant(cuboid() | {"to_world": TILTED}, sigma, 1),
        "sphere": constant(ball(), sigma, 1),
        "mesh": constant(mesh, sigma, 1),
        "tilted mesh": constant(mesh | {"to_world": TILTED}, sigma, 1),
        "trilinear": grid(noise(6, 5, 7), scale=sigma, albedo=1),
        "nearest": grid(noise(3, 4, 2), scale=sigma, albedo=1, interpolation="nearest", to_world=TILTED),
        "albedo grid": grid(noise(5, 5, 5), scale=sigma, albedo=1, albedo_grid={"file": str(ones)}),
    }


def crowd(grid: Grid, folder: Path, sigma: float = 4) -> list[Kind]:
    """All of them at once, each with a phase function of its own."""
    found = media(grid, folder, sigma)
    return [medium | {"phase": phase} for medium, phase in zip(found.values(), PHASES.values(), strict=True)]


def furniture(folder: Path) -> list[Kind]:
    """Surfaces of every shape and white material."""
    mesh = {
        "kind": "mesh",
        "file": scenes.cube_mesh(folder),
        "to_world": scenes.affine([0.3, 0, 0.1], [0, 0.3, 0], [-0.1, 0, 0.3], [0.6, 0.1, 0.5]),
    }
    return [
        scenes.rectangle([1, 0, 0], [0, 0.3, 0.5], [0.5, 0.9, 0.6], WHITES["diffuse"]),
        {"kind": "disk", "center": [0.2, 0.5, 0.8], "normal": [1, 0, -1], "radius": 0.3, "material": WHITES["mirror"]},
        {**ball((0.35, 0.3, 0.4), 0.22), "material": WHITES["dielectric"]},
        {**ball((0.5, 0.5, 0.5), 1.2), "material": WHITES["null"]},
        mesh | {"material": WHITES["diffuse"]},
    ]  # fmt: skip


MAJORANTS: list[Kind] = [{"kind": "global"}, {"kind": "grid", "resolution": 1}, {"kind": "grid", "resolution": 50}]


@pytest.mark.parametrize(
    "majorant", [{"kind": "global"}, pytest.param({"kind": "grid", "resolution": 6}, marks=pytest.mark.slow)], ids=str
)
def test_of_everything(box: Scene, grid: Grid, tmp_path: Path, picture: Picture, majorant: Kind) -> None:
    box |= {"volumes": crowd(grid, tmp_path), "surfaces": furniture(tmp_path), "majorant": majorant}
    assert is_white(picture(box, 8))


@pytest.mark.slow
@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("sigma", [1e-6, 30])
def test_of_every_phase(box: Scene, grid: Grid, picture: Picture, phase: str, sigma: float) -> None:
    box["volumes"] = [
        constant(cuboid(), sigma, 1, phase=PHASES[phase]),
        grid(noise(3, 5, 4), scale=sigma, albedo=1, phase=PHASES[phase]),
    ]
    assert is_white(picture(box, 4))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "majorant"),
    [
        *((name, {"kind": "global"}) for name in ("sphere", "tilted box", "mesh", "tilted mesh")),
        *((name, majorant) for name in ("trilinear", "nearest", "albedo grid") for majorant in MAJORANTS),
    ],
    ids=str,
)
@pytest.mark.parametrize("sigma", [1e-6, 1, 300, 1e4])
def test_of_every_volume(
    box: Scene, grid: Grid, tmp_path: Path, picture: Picture, name: str, sigma: float, majorant: Kind
) -> None:
    """Hardly any path gets deep into the densest."""
    box |= {"volumes": [media(grid, tmp_path, sigma)[name]], "majorant": majorant}
    box["film"] = {"width": 16, "height": 16}
    assert is_white(picture(box, 1 if sigma > 300 else 4))


@pytest.mark.slow
@pytest.mark.parametrize("material", [*WHITES, "rough_dielectric"])
@pytest.mark.parametrize("kind", ["sphere", "mesh"])
def test_of_a_medium_in_a_body(box: Scene, tmp_path: Path, picture: Picture, kind: str, material: str) -> None:
    """Radiance rises by the square of the index on the way in, and falls by it on the way out."""
    mesh = {"kind": "mesh", "file": scenes.cube_mesh(tmp_path), "to_world": TILTED}
    surface = mesh if kind == "mesh" else ball()
    rough = {"kind": "rough_dielectric", "ior": 1.5, "roughness": 0.05}
    box["surfaces"] = [surface | {"material": WHITES.get(material, rough)}]
    box["volumes"] = [constant(surface, 3, 1, phase=PHASES["henyey_greenstein"])]
    film = picture(box, 64)
    if material == "rough_dielectric":
        # What facets mask is lost: microfacets scatter once.
        assert 0.98 < film.mean.mean() < 1 + 1e-4
        assert scenes.is_clean(film)
    else:
        assert is_white(film)


def test_of_a_medium_in_glass(box: Scene, tmp_path: Path, picture: Picture) -> None:
    mesh = {"kind": "mesh", "file": scenes.cube_mesh(tmp_path), "to_world": TILTED}
    box["surfaces"] = [mesh | {"material": WHITES["dielectric"]}]
    box["volumes"] = [constant(mesh, 3, 1, phase=PHASES["henyey_greenstein"]), constant(ball(radius=0.7), 1, 1)]
    assert is_white(picture(box, 16))


# Light that is sampled, too: samples and chance finds must weigh 1 together.


def shell(radius: float = 3) -> Kind:
    return {**ball(radius=radius), "material": {"kind": "emissive", "radiance": 1, "two_sided": True}}


@pytest.mark.parametrize("environment", ["image", "sky and image", "shell"])
def test_of_everything_by_sampled_light(
    box: Scene, grid: Grid, tmp_path: Path, picture: Picture, environment: str
) -> None:
    box |= {"volumes": crowd(grid, tmp_path, 1), "surfaces": furniture(tmp_path), "lights": []}
    if environment == "image":
        box["lights"] = [scenes.white_image(tmp_path)]
    elif environment == "sky and image":
        box["lights"] = [SKY | {"radiance": 0.5}, *([scenes.white_image(tmp_path) | {"scale": 0.25}] * 2)]
    else:
        box["surfaces"].append(shell())
    agree((1, picture(box, 64)), expected=1)


@pytest.mark.slow
@pytest.mark.parametrize("environment", ["image", "shell"])
@pytest.mark.parametrize("phase", PHASES)
def test_of_every_phase_by_sampled_light(
    box: Scene, tmp_path: Path, picture: Picture, phase: str, environment: str
) -> None:
    box["volumes"] = [constant(ball(), 5, 1, phase=PHASES[phase])]
    box |= (
        {"lights": [scenes.white_image(tmp_path)]} if environment == "image" else {"lights": [], "surfaces": [shell()]}
    )
    agree((1, picture(box, 128)), expected=1)


@pytest.mark.slow
@pytest.mark.parametrize("environment", ["image", "shell"])
@pytest.mark.parametrize("material", [*WHITES, "rough_dielectric"])
def test_of_every_material_by_sampled_light(
    box: Scene, tmp_path: Path, picture: Picture, material: str, environment: str
) -> None:
    """Of what microfacets lose, nothing depends on how the light is found."""
    rough = {"kind": "rough_dielectric", "ior": 1.5, "roughness": 0.3}
    box["volumes"] = [constant(ball(), 2, 1)]
    box["surfaces"] = [ball() | {"material": WHITES.get(material, rough)}]
    reference = picture(box | {"seed": 8}, 128)
    if environment == "image":
        box["lights"] = [scenes.white_image(tmp_path)]
    else:
        box["lights"] = []
        box["surfaces"].append(shell())
    scenes.same(picture(box, 256), reference)


# Coloured extinction


@pytest.mark.parametrize(
    "environment", ["sky", pytest.param("image", marks=pytest.mark.slow), pytest.param("shell", marks=pytest.mark.slow)]
)
def test_of_coloured_extinction(box: Scene, grid: Grid, tmp_path: Path, picture: Picture, environment: str) -> None:
    colours = noise(4, 3, 5, 3)
    box["volumes"] = [
        constant(ball(), [0.5, 2, 4], 1, phase=PHASES["henyey_greenstein"]),
        grid(colours, scale=[3, 2, 1], albedo=1, phase=PHASES["rayleigh"]),
        grid(noise(5, 4, 3), scale=2, albedo=1, to_world=TILTED),
    ]
    if environment == "image":
        box["lights"] = [scenes.white_image(tmp_path)]
    elif environment == "shell":
        box |= {"lights": [], "surfaces": [shell()]}
    agree((1, picture(box, 256)), expected=1)


@pytest.mark.slow
@pytest.mark.parametrize("sigma_t", [[1e-6, 1e-3, 1], [1, 10, 100], [0, 1, 0], [5, 5, 5]], ids=str)
def test_of_extremely_coloured_extinction(box: Scene, picture: Picture, sigma_t: list[float]) -> None:
    box["volumes"] = [constant(cuboid(), sigma_t, 1)]
    agree((1, picture(box, 1024)), expected=1, within=0.005)
