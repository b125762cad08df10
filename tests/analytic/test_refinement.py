"""The same medium told in another way, and the same loop at another width, give the same picture."""

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
    affine,
    ball,
    constant,
    cube_mesh,
    cuboid,
    noise,
    random_walk,
    rectangle,
    same,
)

LOBE, BACK = PHASES["henyey_greenstein"], {"kind": "henyey_greenstein", "g": -0.5}
BEAM: Kind = {"kind": "directional", "direction": [1, 0.5, 0.6], "irradiance": 3}


def lit(box: Scene, *volumes: Kind, **keys: Any) -> Scene:
    return random_walk(box, volumes=list(volumes), lights=[*box["lights"], BEAM], **keys)


def majorant(resolution: int) -> Kind:
    return {"kind": "grid", "resolution": resolution}


@pytest.mark.parametrize(
    "keys",
    [
        {"resolution": 5},
        pytest.param({"interpolation": "nearest", "resolution": 1}, marks=pytest.mark.slow),
        pytest.param({"interpolation": "nearest", "resolution": 256}, marks=pytest.mark.slow),
    ],
    ids=str,
)
@pytest.mark.parametrize("sigma", [3, pytest.param([1, 2, 5], marks=pytest.mark.slow)], ids=str)
def test_constant_grid_is_a_homogeneous_medium(
    box: Scene, grid: Grid, picture: Picture, sigma: Any, keys: Kind
) -> None:
    keys = dict(keys)
    bound = majorant(keys.pop("resolution"))
    reference = picture(lit(box, constant(cuboid(), sigma, 0.9, phase=LOBE), seed=8), 512)
    medium = grid(np.full((4, 2, 3), 2, np.uint8), scale=(np.array(sigma) / 2).tolist(), albedo=0.9, phase=LOBE, **keys)
    same(picture(lit(box, medium, majorant=bound), 512), reference)


@pytest.mark.slow
@pytest.mark.parametrize("colours", [False, True])
@pytest.mark.parametrize("resolution", [1, 3, 16, 100])
def test_majorant_does_not_move_the_mean(
    box: Scene, grid: Grid, picture: Picture, resolution: int, colours: bool
) -> None:
    values = noise(5, 6, 4, 3) if colours else noise(5, 6, 4)
    medium = grid(values**4, scale=20, albedo=0.9, phase=LOBE)
    reference = picture(lit(box, medium, seed=8), 512)
    same(picture(lit(box, medium, majorant=majorant(resolution)), 512), reference)


def test_media_add(box: Scene, grid: Grid, picture: Picture) -> None:
    """One grid, and three in the same place that sum to it, of different resolutions, one of them homogeneous."""
    coarse = noise(2, 2, 2)
    fine = coarse.repeat(3, 0).repeat(2, 1).repeat(4, 2)
    parts = [
        grid(coarse, scale=2, albedo=0.9, interpolation="nearest", phase=LOBE),
        grid(fine, scale=3, albedo=0.9, interpolation="nearest", phase=LOBE),
        constant(cuboid(), 1.5, 0.9, phase=LOBE),
    ]  # fmt: skip
    whole = grid(coarse * 5 + 1.5, albedo=0.9, interpolation="nearest", phase=LOBE)
    same(picture(lit(box, *parts, majorant=majorant(4)), 512), picture(lit(box, whole, seed=8), 512))


@pytest.mark.slow
@pytest.mark.parametrize("sigma", [4, [1, 4, 8]], ids=str)
@pytest.mark.parametrize("kind", ["constant", "grid", "both"])
def test_two_halves_are_a_whole(box: Scene, grid: Grid, picture: Picture, kind: str, sigma: Any) -> None:
    half = (np.array(sigma) / 2).tolist()
    homogeneous = constant(cuboid(), half, 0.9, phase=LOBE)
    field = grid(np.ones((2, 2, 2), np.float32), scale=half, albedo=0.9, phase=LOBE)
    halves = {"constant": [homogeneous] * 2, "grid": [field] * 2, "both": [homogeneous, field]}[kind]
    reference = picture(lit(box, constant(cuboid(), sigma, 0.9, phase=LOBE), seed=8), 512)
    same(picture(lit(box, *halves), 512), reference)


@pytest.mark.parametrize("kind", ["constant", pytest.param("grid", marks=pytest.mark.slow)])
@pytest.mark.parametrize("sigma", [4, pytest.param([1, 4, 8], marks=pytest.mark.slow)], ids=str)
def test_two_media_are_a_mixture(box: Scene, grid: Grid, picture: Picture, kind: str, sigma: Any) -> None:
    """Of their phase functions, weighted by σ_s; σ_t and albedo are those of the sum."""

    def medium(share: float, albedo: float, phase: Kind) -> Kind:
        coefficient = (np.array(sigma) * share).tolist()
        if kind == "constant":
            return constant(cuboid(), coefficient, albedo, phase=phase)
        return grid(np.ones((2, 2, 2), np.float32), scale=coefficient, albedo=albedo, phase=phase)

    apart = [medium(0.25, 0.4, BACK), medium(0.75, 0.9, LOBE)]
    components = [{"weight": 0.25 * 0.4, "phase": BACK}, {"weight": 0.75 * 0.9, "phase": LOBE}]
    together = medium(1, 0.25 * 0.4 + 0.75 * 0.9, {"kind": "mixture", "components": components})
    same(picture(lit(box, *apart), 512), picture(lit(box, together, seed=8), 512), within=0.005)


@pytest.mark.slow
def test_albedo_grid_is_media_apart(box: Scene, grid: Grid, tmp_path: Path, picture: Picture) -> None:
    """An albedo of 0 or 1, voxel by voxel, is that of two media with densities of their own."""
    density, bright = noise(4, 5, 3) * 5, (noise(4, 5, 3, seed=8) < 0.5).astype(np.float32)
    np.save(tmp_path / "bright.npy", bright)
    keys: Kind = {"interpolation": "nearest", "phase": LOBE}
    whole = grid(density, albedo=1, albedo_grid={"file": str(tmp_path / "bright.npy")}, **keys)
    apart = [grid(density * bright, albedo=1, **keys), grid(density * (1 - bright), albedo=0, **keys)]
    same(picture(lit(box, whole), 512), picture(lit(box, *apart, seed=8), 512))


@pytest.mark.parametrize("shape", ["mesh", pytest.param("box", marks=pytest.mark.slow)])
def test_a_box_by_its_matrix_or_its_faces(box: Scene, tmp_path: Path, picture: Picture, shape: str) -> None:
    """The unit cube as a mesh, or as a box turned into itself."""
    turned = {
        "kind": "box",
        "min": [-1, 0, 0],
        "max": [1, 3, 0.5],
        "to_world": affine([0, 0.5, 0], [0, 0, -1 / 3], [2, 0, 0], [0, 0.5, 1]),
    }
    other = {"kind": "mesh", "file": cube_mesh(tmp_path)} if shape == "mesh" else turned
    reference = picture(lit(box, constant(cuboid(), 3, 0.9, phase=LOBE), seed=8), 512)
    same(picture(lit(box, constant(other, 3, 0.9, phase=LOBE)), 512), reference)


def test_index_matched_surfaces_are_nothing(box: Scene, picture: Picture) -> None:
    """Between a medium and its lights, of all estimators: by chance, by samples, and by equal angles around a point."""
    lamp = {"kind": "emissive", "radiance": 3, "two_sided": True}
    scene = lit(box, constant(cuboid(), 2, 0.9, phase=LOBE))
    scene["lights"].append({"kind": "point", "position": [1.3, 0.2, 0.3], "intensity": 1})
    scene["surfaces"] = [rectangle([0.4, 0, 0], [0, 0.4, 0], [0.5, 0.5, 1.3], lamp)]
    reference = picture(scene, 1024)
    nothing: list[Kind] = [{**ball(radius=radius), "material": {"kind": "null"}} for radius in (0.3, 0.4, 0.75)]
    same(picture(scene | {"surfaces": scene["surfaces"] + nothing, "seed": 8}, 1024), reference, within=0.004)


# Light that goes straight on


@pytest.mark.parametrize("kind", ["constant", pytest.param("grid", marks=pytest.mark.slow)])
def test_forward_scattering_is_none(box: Scene, grid: Grid, picture: Picture, kind: str) -> None:
    """A Henyey–Greenstein lobe of g = 1 leaves the absorption; a mixture with one leaves the rest of it, too."""

    def medium(sigma: float, albedo: float, phase: Kind) -> Kind:
        if kind == "constant":
            return constant(ball(), sigma, albedo, phase=phase)
        return grid(noise(3, 4, 2), scale=sigma, albedo=albedo, phase=phase)

    straight = {"kind": "henyey_greenstein", "g": 1}
    components = [{"weight": 3, "phase": straight}, {"weight": 1, "phase": LOBE}]
    scenes = [
        lit(box, medium(8, 0.8, {"kind": "mixture", "components": components})),
        lit(box, medium(8 * (1 - 0.75 * 0.8), 0.8 * 0.25 / (1 - 0.75 * 0.8), LOBE)),
        lit(box, medium(8, 0.8, straight)),
        lit(box, medium(8 * 0.2, 0, {"kind": "isotropic"})),
    ]
    mixed, rest, forward, absorbing = (picture(scene | {"seed": seed}, 512) for seed, scene in enumerate(scenes))
    same(mixed, rest)
    same(forward, absorbing)


# Widths


def test_of_every_width(box: Scene, grid: Grid, tmp_path: Path, picture: Picture, lanes: int) -> None:
    """Everything that a path meets: the same paths, but for the few on which rounding turned a decision."""
    scene = lit(
        box,
        constant({"kind": "mesh", "file": cube_mesh(tmp_path)}, [1, 2, 3], 0.8, phase=PHASES["mixture"]),
        grid(noise(5, 4, 3), scale=5, albedo=0.9, phase=LOBE),
        surfaces=[{**ball((0.5, 0.5, 0.6), 0.3), "material": {"kind": "rough_dielectric"}}],
        orders=2,
    )
    same(picture(scene, 64, lanes), picture(scene | {"seed": 8}, 64, 1), within=0.1)
    one, other = picture(scene, 16, 1), picture(scene, 16, lanes)
    assert np.mean(~np.isclose(one.mean, other.mean, rtol=1e-3)) < 0.05
