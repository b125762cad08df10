"""Bare values, described by the name of their file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from woodcock.formats import GridInfo, VolumeError, list_grids, read_grid

TYPES = ["uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float16", "float32", "float64"]


@pytest.mark.parametrize("dtype", TYPES)
def test_every_type(dtype: str, tmp_path: Path) -> None:
    values = np.arange(60).reshape(3, 4, 5).astype(dtype)
    for path, order in ((tmp_path / f"my_cloud_5x4x3_{dtype}.raw", "<"), (tmp_path / f"5x4x3_{dtype}_be.raw", ">")):
        path.write_bytes(values.astype(values.dtype.newbyteorder(order)).tobytes())
        grid = read_grid(path)
        assert np.array_equal(grid.values, values)
        assert grid.values.dtype == {"uint8": np.uint8, "float16": np.float16}.get(dtype, np.float32)
        assert not grid.placed
        assert np.allclose(grid.index_to_world @ (5, 4, 3, 1), 1)
        assert list_grids(path) == (GridInfo("density", dtype, (5, 4, 3), 60),)


@pytest.mark.parametrize(
    ("name", "size", "message"),
    [
        ("a_5x4x3_uint8.raw", 59, "must have 60 bytes by its name, but has 59"),
        ("a_5x4x3_uint8.raw", 61, "must have 60 bytes by its name, but has 61"),
        ("a_0x4x3_uint8.raw", 0, "is empty by its name"),
        ("a_9999x9999x9999_uint8.raw", 9, "more than the 8589934592 that are allowed"),
        ("a_5x4x3.raw", 60, r"is no volume that can be read; .*raw values \(name_128x64x32_uint8\.raw\)"),
        ("a_5x4x3_uint8.dat", 60, "is no volume that can be read"),
    ],
)
def test_the_name_and_the_size_must_agree(name: str, size: int, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(bytes(size))
    with pytest.raises(VolumeError, match=message):
        read_grid(tmp_path / name)
