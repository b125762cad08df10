"""A grid in few bytes, to be looked at: made by the child process of `parser.py`, cut into slices by the service."""

from __future__ import annotations

import base64
import struct
import zlib
from itertools import count
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Base64Bytes, BaseModel

from woodcock import formats

Axis: TypeAlias = Literal["x", "y", "z"]

#: Bytes of a grid's samples: 256 × 256 × 256 of numbers.
MOST_SAMPLES = 1 << 24


class Samples(BaseModel):
    """Every `stride`th voxel of a grid along each axis, in 8 bits: 0 for 0 and less, 255 for `high`.

    shape: of the grid, in voxels along x, y, z; channels: 1 or 3; low, high: least and largest of all its finite
    values, null where there are none; values: indexed [z][y][x][channel].
    """

    shape: tuple[int, int, int]
    channels: int
    low: float | None
    high: float | None
    stride: int
    values: Base64Bytes


def sample(path: Path, position: int) -> dict[str, Any]:
    """The fields of Samples, of the grid at this position of the file. Raises VolumeError."""
    name = formats.list_grids(path)[position].name
    values = formats.read_grid(path, name).values
    values = values.reshape(*values.shape[:3], -1)
    depth, height, width, channels = values.shape
    stride = next(n for n in count(1) if -(-depth // n) * -(-height // n) * -(-width // n) * channels <= MOST_SAMPLES)
    low, high = _range(values)
    kept = values[::stride, ::stride, ::stride].astype(np.float64)
    scaled = np.nan_to_num(kept, nan=0.0, posinf=0.0, neginf=0.0) / (high if high is not None and high > 0 else np.inf)
    return {
        "shape": (width, height, depth),
        "channels": channels,
        "low": low,
        "high": high,
        "stride": stride,
        "values": base64.b64encode(np.rint(255 * scaled.clip(0, 1)).astype(np.uint8).tobytes()).decode(),
    }


def _range(values: NDArray[Any]) -> tuple[float | None, float | None]:
    """The least and the largest finite value; plane by plane, for a mask of all would be as large as they are."""
    ranges = [(float(each.min()), float(each.max())) for plane in values if (each := plane[np.isfinite(plane)]).size]
    return (min(low for low, _ in ranges), max(high for _, high in ranges)) if ranges else (None, None)


def cut(samples: Samples, axis: Axis, position: int) -> NDArray[np.uint8]:
    """The voxels at a position along an axis, (rows, columns, channels): across and up are x and y, x and z, or y and
    z, whichever two are left, in that order."""
    width, height, depth = (-(-n // samples.stride) for n in samples.shape)
    values = np.frombuffer(samples.values, np.uint8).reshape(depth, height, width, samples.channels)
    plane: NDArray[np.uint8] = np.moveaxis(values, "zyx".index(axis), 0)[position // samples.stride]
    return plane[::-1]


def png(pixels: NDArray[np.uint8]) -> bytes:
    """(rows, columns, 1 or 3) as a PNG, grey or in colour (ISO/IEC 15948)."""
    rows, columns, channels = pixels.shape
    header = struct.pack(">IIBBBBB", columns, rows, 8, 0 if channels == 1 else 2, 0, 0, 0)
    unfiltered = np.zeros((rows, 1 + columns * channels), np.uint8)
    unfiltered[:, 1:] = pixels.reshape(rows, -1)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(unfiltered.tobytes())), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
