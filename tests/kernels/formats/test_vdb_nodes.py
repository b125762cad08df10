"""Every way in which a node of an OpenVDB tree may be stored, on files encoded here and read by the library as well."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.formats import VolumeError, list_grids, read_grid

COMPRESSIONS = [0, 1, 2, 3, 4, 6, 7]  # bits: zip 1, active mask 2, blosc 4
# The code of a node -> inactive values that call for it; 1 and 3 (± the background) are no other than 0 if that is 0.
INACTIVE: dict[int, tuple[int, ...]] = {0: (0,), 1: (0,), 2: (7,), 3: (0,), 4: (7, 0), 5: (7, -3), 6: (7, -3, 2)}
FORCED = {1: 1, 3: 3}


def leaves(channels: int, inactive: tuple[int, ...]) -> dict[Any, Any]:
    """Three leaves, on both sides of the origin: some voxels active, none, all."""
    random = np.random.default_rng(channels)
    made = {}
    for n, origin in enumerate([(-8, 0, 120), (0, 8, -16), (16, 8, 0)]):
        active = np.array([random.random(512) < 0.4, np.zeros(512, bool), np.ones(512, bool)][n])
        values = random.integers(-64, 64, (512, channels)) / 8.0  # exact as halves
        values[~active] = random.choice(inactive, (512, 1))[~active]
        made[origin] = values, active
    return made


def dense(grid: Any) -> Any:
    """[z][y][x][channel] from (-9, -1, -17), large enough for `leaves`."""
    values = np.zeros((146, 18, 34, grid.channels), np.float32)
    for (x, y, z), (leaf, _) in grid.leaves.items():
        block = leaf.reshape(8, 8, 8, -1).swapaxes(0, 2)
        values[z + 17 : z + 25, y + 1 : y + 9, x + 9 : x + 17] = block
    return values


def matches(found: Any, expected: Any) -> bool:
    """Equal but for the planes of zeros around."""
    filled = np.argwhere(expected.any(axis=3))
    low, high = filled.min(axis=0), filled.max(axis=0) + 1
    cut = expected[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
    return np.array_equal(np.pad(cut, ((1, 1),) * 3 + ((0, 0),)), found)


@pytest.mark.parametrize("code", INACTIVE)
@pytest.mark.parametrize("flags", COMPRESSIONS)
def test_nodes(flags: int, code: int, vdb_grid: Any, vdb_file: Any, tmp_path: Path) -> None:
    for channels, half in itertools.product((1, 3), (False, True)):
        grid = vdb_grid(
            leaves(channels, INACTIVE[code]), flags=flags, half=half, channels=channels, code=FORCED.get(code, 0)
        )
        path = tmp_path / "nodes.vdb"
        path.write_bytes(vdb_file(grid))
        found = read_grid(path).values
        assert found.dtype == (np.float16 if half else np.float32)
        assert matches(found.reshape(*found.shape[:3], channels), dense(grid))


def test_the_library_reads_the_same_nodes(
    vdb_grid: Any, vdb_file: Any, tmp_path: Path, openvdb: Callable[..., None]
) -> None:
    grids = {
        f"{flags}_{code}_{channels}": vdb_grid(
            leaves(channels, INACTIVE[code]), flags=flags, half=half, channels=channels, code=FORCED.get(code, 0)
        )
        for flags, code, channels in itertools.product(COMPRESSIONS, INACTIVE, (1, 3))
        for half in [(flags + code + channels // 2) % 2 == 0]
    }
    for name, grid in grids.items():
        (tmp_path / f"{name}.vdb").write_bytes(vdb_file(grid))
    openvdb("dump", *(tmp_path / f"{name}.vdb" for name in grids))
    for name, grid in grids.items():
        with np.load(tmp_path / f"{name}.npz") as reference:
            seen = reference["values_0"].swapaxes(0, 2)
        filled = np.argwhere(seen.reshape(*seen.shape[:3], grid.channels).any(axis=3))
        low, high = filled.min(axis=0) - 1, filled.max(axis=0) + 2
        cut = seen[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
        assert np.array_equal(cut, read_grid(tmp_path / f"{name}.vdb").values), name


@pytest.mark.parametrize("flags", COMPRESSIONS)
@pytest.mark.parametrize("half", [False, True])
def test_tiles(flags: int, half: bool, vdb_grid: Any, vdb_file: Any, tmp_path: Path) -> None:
    tiles = {((0, 0, 0), 5): (0.5, True), ((0, 128, 0), 4): (0.25, False), ((8, 128, 0), 4): (2.0, True)}
    path = tmp_path / "tiles.vdb"
    path.write_bytes(vdb_file(vdb_grid({}, tiles, flags=flags, half=half)))
    values = read_grid(path).values
    assert values.shape == (130, 138, 130)
    expected = np.zeros_like(values)
    expected[1:129, 1:129, 1:129] = 0.5
    expected[1:9, 129:137, 1:9] = 0.25
    expected[1:9, 129:137, 9:17] = 2
    assert np.array_equal(values, expected)
    assert list_grids(path)[0].voxels == 128**3 + 8**3


@pytest.mark.parametrize("version", [222, 223, 224, 225])
def test_file_versions(version: int, vdb_grid: Any, vdb_file: Any, tmp_path: Path) -> None:
    path = tmp_path / "version.vdb"
    path.write_bytes(vdb_file(vdb_grid(leaves(1, (0,))), version=version))
    assert read_grid(path).values.any()


@pytest.mark.parametrize(
    ("kind", "numbers", "expected"),
    [
        ("TranslationMap", [1, 2, 3], [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3]]),
        (
            "UnitaryMap",
            [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
            [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]],
        ),
    ],
)
def test_maps_that_the_library_simplifies_away(
    kind: str, numbers: Any, expected: Any, vdb_grid: Any, vdb_file: Any, tmp_path: Path
) -> None:
    voxel = np.eye(512, 1)
    path = tmp_path / "map.vdb"
    path.write_bytes(vdb_file(vdb_grid({(0, 0, 0): (voxel, voxel[:, 0] > 0)}, map=(kind, np.array(numbers)))))
    grid = read_grid(path)
    assert grid.values.shape == (3, 3, 3)  # from -1 to 1
    assert np.array_equal(grid.index_to_world @ (0.5, 0.5, 0.5, 1), [*(np.array(expected) @ (-1, -1, -1, 1)), 1])
    assert np.array_equal(grid.index_to_world[:3, :3], np.array(expected)[:, :3])


def broken(data: bytes, old: bytes, new: bytes) -> bytes:
    assert data.count(old) == 1
    return data.replace(old, new)


def int64(n: int) -> bytes:
    return struct.pack("<q", n)


def test_hostile_files(vdb_grid: Any, vdb_file: Any, tmp_path: Path) -> None:
    made = leaves(1, (0,))
    plain = vdb_file(vdb_grid(made, flags=0))
    counted = vdb_file(vdb_grid(made, metadata={"file_voxel_count": ("int64", int64(5))}))
    zipped, blosced = (vdb_file(vdb_grid(made, flags=flags)) for flags in (3, 6))
    start = int.from_bytes(plain[100:108], "little")  # of the grid, as its descriptor says
    assert plain[start : start + 4] == bytes(4)
    root = plain.index(b"AffineMap") + 9 + 128
    chunk = zipped.index(b"\x78\x9c") - 8
    frame = blosced.index(b"\2\1\x21\4")
    active = sum(int(mask.sum()) for _, mask in made.values())
    singular = vdb_file(vdb_grid(made, map=("AffineMap", np.zeros((4, 4)))))
    infinite = vdb_file(vdb_grid(made, map=("UniformScaleMap", np.full(15, np.inf))))
    cases = {
        "version": (plain[:8] + b"\x63\0\0\0" + plain[12:], "file version 99"),
        "stream": (plain[:20] + b"\0" + plain[21:], "without a table of its grids"),
        "string": (plain[:65] + b"\xff" * 4 + plain[69:], "4294967295 bytes are due"),
        "grids": (plain[:61] + b"\xff" * 4 + plain[65:], "has 4294967295 grids, more than the 10000"),
        "no grids": (plain[:61] + bytes(4) + plain[65:], "holds no grid"),
        "metadata": (plain[:57] + b"\xff" * 4 + plain[61:], "damaged"),
        "beyond": (broken(plain, int64(start) * 2, int64(1 << 62) * 2), "is said to be at bytes"),
        "before": (broken(plain, int64(start) * 2, int64(-9) * 2), "is said to be at bytes"),
        "flags": (plain[:start] + b"\x40" + plain[start + 1 :], "unknown compression flags 0x40"),
        "tiles": (plain[: root + 8] + b"\xff" * 4 + plain[root + 12 :], "damaged or cut short"),
        "children": (plain[: root + 12] + b"\xff" * 4 + plain[root + 16 :], "a branch of the tree lies at"),
        "branch": (plain[: root + 16] + b"\1" + plain[root + 17 :], "a branch of the tree lies at (-4095, 0, 0)"),
        "zip size": (zipped[:chunk] + int64(1 << 40) + zipped[chunk + 8 :], "damaged or cut short"),
        "zip": (zipped[: chunk + 12] + b"\xff" * 8 + zipped[chunk + 20 :], "a zip buffer"),
        "bomb": (blosced[: frame + 4] + b"\xff\xff\xff\x7f" + blosced[frame + 8 :], "a blosc buffer does not unpack"),
        "count": (counted, f"it holds {active} active voxels, but says 5"),
        "singular": (singular, "no affine map that can be inverted"),
        "infinite": (infinite, "no affine map that can be inverted"),
        "cut": (plain[:-1], "is said to be at bytes"),
        "empty": (b"", "is no volume that can be read"),
    }
    for case, (data, message) in cases.items():
        path = tmp_path / "hostile.vdb"
        path.write_bytes(data)
        with pytest.raises(VolumeError) as caught:
            read_grid(path)
        assert str(caught.value).startswith(f"{path}: "), case
        assert message in str(caught.value), (case, str(caught.value))
        assert "\n" not in str(caught.value)


def test_names_out_of_a_file_stay_on_one_line_and_short(vdb_grid: Any, vdb_file: Any, tmp_path: Path) -> None:
    path = tmp_path / "names.vdb"
    path.write_bytes(vdb_file(*(vdb_grid(leaves(1, (0,)), name=f"{n}\n" + "x" * 1000) for n in range(30))))
    with pytest.raises(VolumeError) as caught:
        read_grid(path)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 2000


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(VolumeError, match=r"nothing\.vdb: No such file"):
        read_grid(tmp_path / "nothing.vdb")
    with pytest.raises(VolumeError, match="is not a file"):
        list_grids(tmp_path)
    with pytest.raises(VolumeError, match="is no name of a file"):
        read_grid(Path("a\0b"))
