"""Mitsuba's .vol."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.formats import GridInfo, VolumeError, list_grids, read_grid

#: VolumeGrid(numpy.arange(12, dtype="f4").reshape(2, 3, 2)).write(…) of Mitsuba 3.9.1.
MITSUBA = (
    "564f4c0301000000020000000300000002000000010000000000000000000000000000000000803f0000803f0000803f"
    "000000000000803f0000004000004040000080400000a0400000c0400000e04000000041000010410000204100003041"
)
BOX = (-1.0, 0.0, 2.0, 3.0, 1.0, 2.5)


def encode(values: Any, kind: int, box: tuple[float, ...] = BOX, version: int = 3) -> bytes:
    z, y, x = values.shape[:3]
    channels = values.shape[3] if values.ndim == 4 else 1
    return struct.pack("<3sB5i6f", b"VOL", version, kind, x, y, z, channels, *box) + values.tobytes()


@pytest.mark.parametrize("channels", [(), (3,)])
@pytest.mark.parametrize(
    ("kind", "dtype", "kept"), [(1, "<f4", np.float32), (2, "<f2", np.float16), (3, "u1", np.float32)]
)
def test_every_type(kind: int, dtype: str, kept: Any, channels: tuple[int, ...], tmp_path: Path) -> None:
    values = np.arange(24 * (3 if channels else 1)).reshape(2, 3, 4, *channels).astype(dtype)
    path = tmp_path / "volume"
    path.write_bytes(encode(values, kind))
    grid = read_grid(path)
    assert grid.values.dtype == kept
    assert np.array_equal(grid.values, values if kind < 3 else (values / 255).astype("f4"))
    assert grid.placed
    assert np.allclose(grid.index_to_world @ (0, 0, 0, 1), (-1, 0, 2, 1))
    assert np.allclose(grid.index_to_world @ (4, 3, 2, 1), (3, 1, 2.5, 1))
    assert list_grids(path) == (GridInfo("density", values.dtype.name + "[3]" * len(channels), (4, 3, 2), 24),)


def test_reads_what_mitsuba_wrote(tmp_path: Path) -> None:
    path = tmp_path / "volume.vol"
    path.write_bytes(bytes.fromhex(MITSUBA))
    grid = read_grid(path)
    assert np.array_equal(grid.values, np.arange(12).reshape(2, 3, 2))
    assert np.array_equal(grid.index_to_world, np.diag((1 / 2, 1 / 3, 1 / 2, 1)))


def test_what_is_no_volume_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "volume"
    values = np.zeros((2, 3, 4), "<f4")
    good = encode(values, 1)
    cases = {
        "is cut short in its header": good[:47],
        "its header announces 96 bytes of values, 95 follow": good[:-1],
        "is of .vol version 2": encode(values, 1, version=2),
        "holds values of type 4;": encode(values, 4),
        "holds 4 × 3 × 2 voxels of 2 channels": encode(np.zeros((2, 3, 4, 2), "<f4"), 1),
        "holds -1 × 3 × 2 voxels of 1 channels": good[:8] + b"\xff" * 4 + good[12:],
        "more than the 8589934592": good[:8] + struct.pack("<3i", *[1 << 30] * 3) + good[20:],
        "it must have a volume": encode(values, 1, (0, 0, 0, 1, 0, 1)),
        " it must have a volume": encode(values, 1, (0, 0, 0, 1, np.nan, 1)),
    }
    for message, data in cases.items():
        path.write_bytes(data)
        with pytest.raises(VolumeError) as caught:
            read_grid(path)
        assert message.strip() in str(caught.value), message
