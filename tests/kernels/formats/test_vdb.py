"""The OpenVDB reader against the library itself, voxel by voxel, on files that the library wrote."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.formats import Grid, GridInfo, VolumeError, list_grids, read_grid

ROOT = Path(__file__).parents[3]
FIREBALL = ROOT / "client" / "woodcock_client" / "examples" / "fireball.vdb"
SHARED = ROOT.parent / "shared" / "data"

READABLE = [
    *("sparse", "origin", "one_voxel", "empty", "half", "vector", "vector_half", "inactive", "tiles", "tiles_half"),
    *("several", "map_uniform_scale", "map_uniform_scale_translate", "map_scale", "map_scale_translate", "map_affine"),
]


def assert_same(grid: Grid, reference: Any, n: int) -> None:
    """Same values everywhere, same place, and nothing but the one voxel of border around what is not background."""
    low, matrix, expected = (reference[f"{key}_{n}"] for key in ("low", "matrix", "values"))
    assert grid.placed
    assert grid.background == 0
    assert grid.values.flags.c_contiguous
    first = np.linalg.solve(matrix, grid.index_to_world @ (0.5, 0.5, 0.5, 1))[:3]
    start = np.rint(first).astype(int)
    assert np.allclose(first, start, atol=1e-6)
    assert np.allclose(grid.index_to_world[:3, :3], matrix[:3, :3], rtol=1e-12, atol=1e-12)

    values = np.swapaxes(grid.values, 0, 2).astype(np.float32)
    seen = np.zeros_like(expected)
    inside = tuple(slice(a, a + size) for a, size in zip(start - low, values.shape[:3], strict=True))
    assert seen[inside].shape == values.shape
    seen[inside] = values
    assert np.array_equal(seen, expected)
    for axis in range(3):
        assert not values.take([0, -1], axis=axis).any()


def check(path: Path) -> None:
    with np.load(path.with_suffix(".npz")) as reference:
        infos = {info.name: info for info in list_grids(path)}
        for n in range(len(infos)):
            info = infos[str(reference[f"name_{n}"])]
            assert info.voxels == reference[f"voxels_{n}"]
            assert info.shape == tuple(reference[f"shape_{n}"])
            grid = read_grid(path, info.name)
            assert_same(grid, reference, n)
            # Active voxels count as content, zero or not.
            assert all(a >= b + 2 * (b > 0) for a, b in zip(grid.values.shape[2::-1], info.shape, strict=True))


@pytest.fixture(scope="module")
def folder(openvdb: Callable[..., None], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("openvdb")
    openvdb("write", folder)
    openvdb("dump", *(folder / f"{stem}.vdb" for stem in READABLE))
    return folder


@pytest.mark.parametrize("stem", READABLE)
def test_equals_the_library(stem: str, folder: Path) -> None:
    check(folder / f"{stem}.vdb")


@pytest.mark.parametrize("name", ["fireball", "smoke", "usd_densityAndHeat", "wdas_cloud_sixteenth"])
def test_equals_the_library_on_shared_data(name: str, tmp_path: Path, openvdb: Callable[..., None]) -> None:
    if not SHARED.is_dir():
        pytest.skip(f"the shared data is not there: {SHARED}")
    path = tmp_path / f"{name}.vdb"
    path.write_bytes((SHARED / path.name).read_bytes())
    openvdb("dump", path)
    check(path)


@pytest.mark.parametrize(
    ("stem", "dtype", "type_", "vector"),
    [
        ("sparse", np.float32, "float", ()),
        ("half", np.float16, "half", ()),
        ("vector", np.float32, "vec3s", (3,)),
        ("vector_half", np.float16, "vec3h", (3,)),
    ],
)
def test_keeps_the_precision_of_the_file(stem: str, dtype: Any, type_: str, vector: Any, folder: Path) -> None:
    path = folder / f"{stem}.vdb"
    grid = read_grid(path)
    assert grid.values.dtype == dtype
    assert grid.values.shape[3:] == vector
    assert list_grids(path)[0].type == type_


def test_fireball_is_read_in_well_under_a_second() -> None:
    start = time.perf_counter()
    grid = read_grid(FIREBALL)
    assert time.perf_counter() - start < 1
    assert grid.name == "density"
    assert grid.values.shape == (103, 100, 94)
    assert grid.values.dtype == np.float16
    assert list_grids(FIREBALL)[0] == GridInfo("density", "half", (92, 98, 101), 302157)


def test_density_is_the_default_and_any_name_can_be_asked_for(folder: Path) -> None:
    several = folder / "several.vdb"
    assert read_grid(several).name == "density"
    assert read_grid(several, "heat").name == "heat"
    assert read_grid(folder / "vector.vdb").name == "velocity"
    with pytest.raises(VolumeError, match=r'no_density\.vdb: has no grid "density" .* "a", "b"'):
        read_grid(folder / "no_density.vdb")
    with pytest.raises(VolumeError, match=r'has no grid "smoke"; it has "heat", "density", "fuel"'):
        read_grid(several, "smoke")


def test_an_instance_has_the_tree_of_its_parent_and_a_transform_of_its_own(folder: Path) -> None:
    heat, fuel = (read_grid(folder / "several.vdb", name) for name in ("heat", "fuel"))
    assert np.array_equal(heat.values, fuel.values)
    assert np.allclose(fuel.index_to_world[:3], 2 * heat.index_to_world[:3])


def test_grids_of_one_name_are_numbered(folder: Path) -> None:
    path = folder / "same_name.vdb"
    assert [info.name for info in list_grids(path)] == ["a[0]", "a[1]"]
    assert read_grid(path, "a[0]").values.shape != read_grid(path, "a[1]").values.shape


@pytest.mark.parametrize(
    ("stem", "name", "message"),
    [
        ("level_set", None, 'level_set.vdb: grid "surface" is a level set'),
        ("background", None, "has a background other than 0"),
        ("map_frustum", None, 'is placed by a map of type "NonlinearFrustumMap"; only linear maps can be read'),
        ("bool", "flags", 'grid "flags" holds values of type "bool"; only float and vec3s can be read'),
        ("root_tile", None, "spans 4096 × 4096 × 4096 voxels, more than"),
        ("far", None, "spans 200001 × 200001 × 200001 voxels, more than"),
    ],
)
def test_what_cannot_be_read_is_listed_and_refused(stem: str, name: str, message: str, folder: Path) -> None:
    path = folder / f"{stem}.vdb"
    info = list_grids(path)[0]
    assert info.voxels > 0
    assert min(info.shape) > 0
    with pytest.raises(VolumeError) as caught:
        read_grid(path, name)
    assert message in str(caught.value)


def test_a_grid_that_can_be_read_beside_one_that_cannot(folder: Path) -> None:
    assert read_grid(folder / "bool.vdb").name == "density"
