"""The NanoVDB reader on files encoded in conftest.py, whose trees NanoVDB's PNanoVDB.h was seen to read alike."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.formats import GridInfo, VolumeError, list_grids, read_grid

TYPES = ["float", "double", "vec3f", "half", "fp4", "fp8", "fp16", "fpN"]
MATRIX = np.array([[0.5, 0.1, 0, 3], [0, 0.25, 0, -2], [0.2, 0, 2, 1], [0, 0, 0, 1.0]])
TILES = {((-128, 0, 0), 5): (0.5, True), ((0, 128, 0), 4): (0.25, False), ((8, 128, 0), 4): (2.0, True)}


def leaves(channels: int) -> dict[Any, Any]:
    """Six leaves, on both sides of the origin, some inactive voxels of which are not zero."""
    random = np.random.default_rng(channels)
    made = {}
    for n, origin in enumerate([(0, 0, 0), (0, 8, -16), (16, 8, 0), (-8, 136, 120), (8, 0, 0), (0, 0, 8)]):
        values = random.integers(0, 64, (512, channels)) / 8.0  # exact as halves
        values[0], values[1] = 0, 64 / 8
        active = random.random(512) < (0.4, 0, 1, 0.9, 0.5, 0.5)[n]
        made[origin] = values, active
    return made


def dense(grid: Any) -> Any:
    """[z][y][x][channel] from (-129, -1, -17)."""
    values = np.zeros((146, 146, 154, 3 if grid.type == "vec3f" else 1))
    for (at, level), (value, _) in grid.tiles.items():
        (x, y, z), edge = np.add(at, (129, 1, 17)), {5: 128, 4: 8}[level]
        values[z : z + edge, y : y + edge, x : x + edge] = value
    for at, (leaf, _) in grid.leaves.items():
        x, y, z = np.add(at, (129, 1, 17))
        values[z : z + 8, y : y + 8, x : x + 8] = leaf.reshape(8, 8, 8, -1).swapaxes(0, 2)
    return values


@pytest.mark.parametrize("codec", [0, 1, 2])
@pytest.mark.parametrize("kind", TYPES)
def test_every_type_and_codec(kind: str, codec: int, nanovdb_grid: Any, nanovdb_file: Any, tmp_path: Path) -> None:
    grid = nanovdb_grid(kind, leaves(3 if kind == "vec3f" else 1), TILES, matrix=MATRIX)
    path = tmp_path / "volume"
    path.write_bytes(nanovdb_file(grid, codec=codec))
    found = read_grid(path)
    expected = dense(grid)
    values = found.values.reshape(*found.values.shape[:3], -1)
    assert found.values.dtype == (np.float16 if kind == "half" else np.float32)
    assert found.values.flags.c_contiguous
    # From 0 to 8 in 15, 255 and 65535 steps; those of fpN have 1 bit a value at least.
    error = {"fp4": 4 / 15, "fp8": 4 / 255, "fp16": 4 / 65535, "fpN": 4}.get(kind, 0)
    assert values.shape == expected.shape
    assert abs(values - expected).max() <= error * 1.0001
    if error:
        assert abs(values - expected).max() > error / 2
    low, high = grid.box()
    shape = tuple(b - a + 1 for a, b in zip(low, high, strict=True))
    assert list_grids(path) == (GridInfo("density", kind, shape, grid.voxels()),)
    assert found.placed
    assert np.allclose(found.index_to_world @ (129.5, 1.5, 17.5, 1), MATRIX @ (0, 0, 0, 1))
    assert np.allclose(found.index_to_world[:3, :3], MATRIX[:3, :3])


def test_each_leaf_of_fpn_has_a_precision_of_its_own(nanovdb_grid: Any, nanovdb_file: Any, tmp_path: Path) -> None:
    grid = nanovdb_grid("fpN", leaves(1))
    (tmp_path / "volume").write_bytes(nanovdb_file(grid))
    found = read_grid(tmp_path / "volume").values
    x, y, z = (min(at[axis] for at in grid.leaves) - 1 for axis in range(3))
    for n, (at, (values, _)) in enumerate(grid.leaves.items()):
        i, j, k = at[0] - x, at[1] - y, at[2] - z
        leaf = found[k : k + 8, j : j + 8, i : i + 8].swapaxes(0, 2).reshape(-1)
        half_a_step = 4 / ((1 << (1 << n % 5)) - 1)
        assert half_a_step / 2 < abs(leaf - values[:, 0]).max() <= half_a_step * 1.0001


def test_segments_bare_grids_and_names(nanovdb_grid: Any, nanovdb_file: Any, tmp_path: Path) -> None:
    first, second = (nanovdb_grid("float", leaves(1), name=name) for name in ("heat", "density"))
    third = nanovdb_grid("half", leaves(1), name="heat")
    path = tmp_path / "volume"
    for data in (
        nanovdb_file(first, second, third, codec=1),
        nanovdb_file(first, second, codec=2, magic=b"NanoVDB0") + nanovdb_file(third),
        first.encode() + second.encode() + third.encode(),
    ):
        path.write_bytes(data)
        assert [info.name for info in list_grids(path)] == ["heat[0]", "density", "heat[1]"]
        assert [info.type for info in list_grids(path)] == ["float", "float", "half"]
        assert read_grid(path).name == "density"
        assert read_grid(path, "heat[1]").values.dtype == np.float16
        assert np.array_equal(read_grid(path, "heat[0]").values, read_grid(path, "heat[1]").values)


def test_what_cannot_be_rendered_is_refused(nanovdb_grid: Any, nanovdb_file: Any, tmp_path: Path) -> None:
    path = tmp_path / "volume"
    plain, zipped, blosced = (nanovdb_file(nanovdb_grid("float", leaves(1)), codec=codec) for codec in (0, 1, 2))
    grid = plain.index(b"NanoVDB1")
    root = grid + 736

    def patched(at: int, new: bytes) -> bytes:
        return plain[:at] + new + plain[at + len(new) :]

    far = {(0, 0, 0): leaves(1)[0, 0, 0], (100_000, 0, 100_000): leaves(1)[0, 0, 0]}
    cases = {
        'grid "density" is a level set': nanovdb_file(nanovdb_grid("float", leaves(1), grid_class=1)),
        "has a background other than 0": nanovdb_file(nanovdb_grid("float", leaves(1), background=1)),
        "spans 100008 × 8 × 100008 voxels, more than": nanovdb_file(nanovdb_grid("float", far)),
        "holds values of type index; float, double": patched(48, struct.pack("<I", 19)),
        "is not what its file says it is": patched(grid + 636, struct.pack("<I", 9)),
        "is of NanoVDB version 31": patched(8, struct.pack("<I", 31 << 21)),
        "a segment cannot be read": plain + b"NanoVDB9" + bytes(8),
        "active voxels, but says 7": patched(16 + 24, struct.pack("<Q", 7)),
        "nodes of 270400 bytes cannot be in its": patched(root + 64 + 32 + 8, struct.pack("<q", 1 << 40)),
        " nodes of 270400 bytes cannot be in its": patched(root + 64 + 32 + 8, struct.pack("<q", 65)),
        "  bytes are due at byte": patched(root + 24, struct.pack("<I", 1 << 31)),
        "two entries for one place": patched(root + 64 + 32, plain[root + 64 : root + 72]),
        "is no affine map that can be inverted": patched(grid + 384, bytes(72)),
        "bytes are due at byte": plain[:-1],
        "packed bytes cannot hold 1099511627776": zipped[:16] + struct.pack("<Q", 1 << 40) + zipped[24:],
        "its zip buffer does not fit": zipped[:200] + b"\xff" * 8 + zipped[208:],
        "its zlib stream": zipped[:220] + bytes(16) + zipped[236:],
        "a blosc buffer": blosced[:208] + bytes(16) + blosced[224:],
    }
    for message, data in cases.items():
        path.write_bytes(data)
        with pytest.raises(VolumeError) as caught:
            read_grid(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert message.strip() in str(caught.value), message


def test_nodes_that_share_their_children_do_not_multiply(nanovdb_grid: Any, tmp_path: Path) -> None:
    data = bytearray(nanovdb_grid("float", leaves(1)).encode())
    upper = 736 + 64 + 32 * (int.from_bytes(data[736 + 24 : 736 + 28], "little"))
    data[upper + 4128 : upper + 8224] = b"\xff" * 4096
    first = bytes(data[upper + 8256 :])
    child = next(n for n in range(32768) if any(first[8 * n : 8 * n + 8]))
    data[upper + 8256 : upper + 8256 + 8 * 32768] = first[8 * child : 8 * child + 8] * 32768
    (tmp_path / "volume").write_bytes(data)
    with pytest.raises(VolumeError, match="nodes of 33856 bytes cannot be in its"):
        read_grid(tmp_path / "volume")
