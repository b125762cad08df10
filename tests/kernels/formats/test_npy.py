"""NumPy arrays as volumes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.formats import GridInfo, VolumeError, list_grids, read_grid

KEPT = {"?": np.uint8, "u1": np.uint8, "f2": np.float16}  # all others become float32
TYPES = ["?", "u1", "i1", "<u2", ">u2", "<i2", "<i4", ">u4", "<i8", "<u8", "<f2", ">f2", "<f4", ">f4", "<f8", ">f8"]


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("shape", [(2, 3, 4), (2, 3, 4, 3), (1, 1, 1)])
@pytest.mark.parametrize("dtype", TYPES)
def test_reads_every_type(dtype: str, shape: Any, order: Any, tmp_path: Path) -> None:
    array = np.asarray(np.arange(np.prod(shape)).reshape(shape) % 100 - ("i" in dtype), dtype=dtype, order=order)
    path = tmp_path / "volume.bin"  # the suffix does not matter
    with path.open("wb") as file:
        np.save(file, array)
    grid = read_grid(path)
    assert grid.values.dtype == KEPT.get(dtype.strip("<>"), np.float32)
    assert grid.values.dtype.isnative
    assert grid.values.flags.c_contiguous
    assert np.array_equal(grid.values, array)
    assert not grid.placed
    assert grid.index_to_world.dtype == np.float64
    assert np.allclose(grid.index_to_world @ (shape[2], shape[1], shape[0], 1), 1)
    kind = array.dtype.name + "[3]" * (len(shape) == 4)
    assert list_grids(path) == (GridInfo("density", kind, shape[2::-1], int(np.prod(shape[:3]))),)


def test_a_memory_map_and_later_versions_of_the_format(tmp_path: Path) -> None:
    path = tmp_path / "volume.npy"
    mapped = np.lib.format.open_memmap(path, mode="w+", dtype="f4", shape=(3, 2, 1))
    mapped[:] = 7
    mapped.flush()
    assert (read_grid(path).values == 7).all()
    for version in ((2, 0), (3, 0)):
        with path.open("wb") as file:
            np.lib.format.write_array(file, np.full((1, 2, 3), 5, np.float16), version=version)
        assert (read_grid(path).values == 5).all()


def saved(path: Path, array: Any) -> bytes:
    np.save(path, array)
    return path.read_bytes()


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((2, 2)), r"must be indexed \[z\]\[y\]\[x\] or .* has the shape \(2, 2\)"),
        (np.zeros((2, 2, 2, 4)), "has the shape"),
        (np.zeros((2, 0, 2)), "not be empty"),
        (np.zeros((2, 2, 2), complex), 'must hold booleans, integers or floats, not "<c16"'),
        (np.zeros((2, 2, 2), "f4,i4"), "must hold booleans, integers or floats, not records"),
        (np.full((2, 2, 2), 1e39), "too large for a 32-bit float"),
    ],
)
def test_refuses_what_is_no_volume(array: Any, message: str, tmp_path: Path) -> None:
    np.save(tmp_path / "volume.npy", array)
    with pytest.raises(VolumeError, match=message):
        read_grid(tmp_path / "volume.npy")


def test_infinities_and_nan_are_left_to_the_caller(tmp_path: Path) -> None:
    np.save(tmp_path / "volume.npy", np.array([[[np.inf, -np.inf, np.nan]]]))
    assert not np.isfinite(read_grid(tmp_path / "volume.npy").values).any()


def test_never_unpickles(tmp_path: Path) -> None:
    np.save(tmp_path / "volume.npy", np.array([[[print]]], dtype=object), allow_pickle=True)
    with pytest.raises(VolumeError, match=r"must hold booleans, integers or floats, not \"\|O\""):
        read_grid(tmp_path / "volume.npy")


def test_hostile_headers(tmp_path: Path) -> None:
    path = tmp_path / "volume.npy"
    good = saved(path, np.zeros((2, 3, 4), np.float32))

    def header(text: str) -> bytes:
        return b"\x93NUMPY\1\0" + len(text).to_bytes(2, "little") + text.encode() + bytes(96)

    def shape(text: str) -> bytes:
        return header("{'descr': '<f4', 'fortran_order': False, 'shape': " + text + "}")

    cases = {
        "cut short: its header announces 96 bytes": good[:-1],
        "cut short in its .npy header": good[:40],
        "unknown .npy version 9.0": good[:6] + b"\x09" + good[7:],
        "unknown .npy version": good[:6],
        "damaged .npy header": header("(" * 9000),
        " damaged .npy header": header("{'descr': 1"),
        "a .npy header of 20000 bytes": header(" " * 20000),
        "more than the 8589934592 that are allowed": shape("(99999, 99999, 99999)"),
        "damaged shape": shape("(-1, 2, 3)"),
        " damaged shape": shape("(True, 2, 3)"),
        "  damaged shape": shape("[1, 2, 3]"),
        "   damaged shape": shape("(0x" + "f" * 9000 + ", 2, 3)"),
        "not records": header("{'descr': [0x" + "f" * 9000 + "], 'fortran_order': 0, 'shape': ()}"),
        "announces 4096000000 bytes of values": shape("(1000, 1000, 1024)"),
    }
    for message, data in cases.items():
        path.write_bytes(data)
        with pytest.raises(VolumeError) as caught:
            read_grid(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert message.strip() in str(caught.value)


def test_an_array_has_the_name_density_only(tmp_path: Path) -> None:
    np.save(tmp_path / "volume.npy", np.zeros((2, 2, 2)))
    assert read_grid(tmp_path / "volume.npy", "density").name == "density"
    with pytest.raises(VolumeError, match='has no grid "heat"; it has "density"'):
        read_grid(tmp_path / "volume.npy", "heat")
