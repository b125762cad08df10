"""NIfTI-1 and -2 in one file, plain (.nii) or through gzip (.nii.gz): one scalar volume, or one of three-vectors.

Written from the definitions nifti1.h and nifti2.h of the NIfTI Data Format Working Group. A header, its sizes in the
byte order of the file, stands before the values, x fastest. Its place is that of the sform if there is one, else of the
qform, else the voxel sizes alone; the axes, and units such as millimetres, are as the file has them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from woodcock.formats.dense import (
    NAME,
    Matrix,
    check_shape,
    from_samples,
    info,
    keep,
    scaled,
    unit_cube,
    values_at,
)
from woodcock.formats.grid import Data, File, Grid, GridInfo, VolumeError, choose
from woodcock.formats.packed import check_packed, unpack

_GZIP = b"\x1f\x8b"
_MOST_EXTENSIONS = 1 << 26  # bytes between header and values

_NAMES = ["size", "datatype", "dim", "pixdim", "start", "slope", "offset", "qform", "sform", "quaternion", "origin"]


def _layout(size: int, small: str, number: str, start: str, real: str, offsets: tuple[int, ...]) -> np.dtype[Any]:
    formats: list[Any] = ["i4", "i2", (number, 8), (real, 8), start, real, real, small, small, (real, 3), (real, 3)]
    names, formats = [*_NAMES, "srow"], [*formats, (real, (3, 4))]
    return np.dtype({"names": names, "formats": formats, "offsets": list(offsets), "itemsize": size})


# What is used of a header and where it stands. Both begin with their size, which also shows the byte order.
_LAYOUTS = {
    348: _layout(348, "i2", "i2", "f4", "f4", (0, 70, 40, 76, 108, 112, 116, 252, 254, 256, 268, 280)),
    540: _layout(540, "i4", "i8", "i8", "f8", (0, 12, 16, 104, 168, 176, 184, 344, 348, 352, 376, 400)),
}
_MAGICS = {348: (344, b"n+1\0"), 540: (4, b"n+2\0\r\n\x1a\n")}
_PAIRS = {348: b"ni1\0", 540: b"ni2\0\r\n\x1a\n"}

_TYPES = {2: "u1", 4: "i2", 8: "i4", 16: "f4", 64: "f8", 256: "i1", 512: "u2", 768: "u4", 1024: "i8", 1280: "u8"}


@dataclass(frozen=True)
class _Header:
    shape: tuple[int, ...]  # [z][y][x] or [3][z][y][x]
    dtype: np.dtype[Any]
    start: int  # of the values
    slope: float
    offset: float
    samples_to_world: Matrix | None

    @property
    def end(self) -> int:  # of the values
        return self.start + math.prod(self.shape) * self.dtype.itemsize


def recognises(file: File) -> bool:
    try:
        start = _start(file.data, 352)
    except VolumeError:
        return False
    size, _ = _kind(start)
    return size > 0 and _magic(start, size) in (_MAGICS[size][1], _PAIRS[size])


def read(file: File, name: str | None) -> Grid:
    """The volume. Raises VolumeError."""
    choose((NAME,), name)
    header = _header(file.data)
    packed, start = file.data[:2] == _GZIP, header.start
    data: Data | bytearray = file.data
    if packed:
        data = _unpacked(file.data, header.end)
    values = values_at(data, start, header.shape, header.dtype)
    if len(header.shape) == 4:
        values = np.moveaxis(values, 0, -1)
    if (header.slope, header.offset) != (1, 0):
        values = scaled(values, header.slope, header.offset)
    else:
        values = keep(values, owned=packed)
    if header.samples_to_world is None:
        return Grid(NAME, values, unit_cube(values.shape), placed=False)
    return Grid(NAME, values, from_samples(header.samples_to_world), placed=True)


def list_grids(file: File) -> tuple[GridInfo, ...]:
    """The one volume; every voxel counts as active. Raises VolumeError."""
    header = _header(file.data)
    if file.data[:2] == _GZIP:
        check_packed(len(file.data), header.end, "gzip")
    else:
        values_at(file.data, header.start, header.shape, header.dtype)
    shape = (*header.shape[1:], 3) if len(header.shape) == 4 else header.shape
    return (info(NAME, shape, header.dtype),)


def _start(data: Data, size: int) -> bytes:
    return bytes(_unpacked(data, size)) if data[:2] == _GZIP else data[:size]


def _unpacked(data: Data, size: int) -> bytearray:
    return unpack(data, 0, len(data), size, "gzip")


def _kind(start: bytes) -> tuple[int, Literal["<", ">"]]:
    """The size of the header and its byte order; 0 for what is no header."""
    orders: tuple[Literal["<", ">"], ...] = ("<", ">")
    for order in orders:
        size = int(np.frombuffer(start[:4], f"{order}i4")[0]) if len(start) >= 4 else 0
        if size in _LAYOUTS:
            return size, order
    return 0, "<"


def _magic(start: bytes, size: int) -> bytes:
    at, magic = _MAGICS[size]
    return start[at : at + len(magic)]


def _header(data: Data) -> _Header:
    size, order = _kind(_start(data, 4))
    start = _start(data, size)
    if _magic(start, size) == _PAIRS[size]:
        raise VolumeError("has its values in another file (.img); store both in one (.nii)")
    if len(start) < size:
        raise VolumeError("is cut short in its header")
    fields = np.frombuffer(start, _LAYOUTS[size].newbyteorder(order))[0]
    if int(fields["datatype"]) not in _TYPES:
        raise VolumeError(f"holds values of the NIfTI type {fields['datatype']}; only integers and floats can be read")
    shape = _shape(fields["dim"].tolist())
    place = float(fields["start"])
    if not size <= place <= size + _MOST_EXTENSIONS or not place.is_integer():
        raise VolumeError(f"is damaged: its values are said to begin at byte {place:g}")
    slope, offset = float(fields["slope"]), float(fields["offset"])
    if slope == 0 or not (math.isfinite(slope) and math.isfinite(offset)):  # as the definition says: not scaled
        slope, offset = 1.0, 0.0
    dtype = np.dtype(_TYPES[int(fields["datatype"])]).newbyteorder(order)
    return _Header(shape, dtype, int(place), slope, offset, _samples_to_world(fields))


def _shape(dim: list[int]) -> tuple[int, ...]:
    """[z][y][x], or [3][z][y][x] for vectors, which lie along the fifth dimension."""
    if not 1 <= dim[0] <= 7:
        raise VolumeError(f"is damaged: it is said to have {dim[0]} dimensions")
    x, y, z, *others = (dim[1 : dim[0] + 1] + [1] * 7)[:7]
    if min(x, y, z) < 1 or others not in ([1] * 4, [1, 3, 1, 1]):
        size = " × ".join(map(str, dim[1 : dim[0] + 1]))
        raise VolumeError(
            f"holds {size} values; it must be one volume (of one time), not empty, of scalars or 3-vectors"
        )
    check_shape((z, y, x, others[1]))
    return (3, z, y, x) if others[1] == 3 else (z, y, x)


def _samples_to_world(fields: Any) -> Matrix | None:
    """Sample (i, j, k) to the world, by the best of the three methods; None if the file does not say."""
    matrix = np.eye(4)
    if fields["sform"] > 0:
        matrix[:3] = fields["srow"]
        return matrix
    steps = fields["pixdim"][1:4].astype(np.float64)
    if not (np.isfinite(steps).all() and (steps > 0).all()):
        return None
    if fields["qform"] > 0:
        with np.errstate(all="ignore"):
            matrix[:3, :3] = _rotation(*fields["quaternion"].astype(np.float64))
        if fields["pixdim"][0] < 0:
            steps[2] *= -1
        matrix[:3, 3] = fields["origin"]
    with np.errstate(all="ignore"):
        matrix[:3, :3] *= steps
    return matrix


def _rotation(b: float, c: float, d: float) -> list[list[float]]:
    """By the quaternion a + bi + cj + dk of length one, a ≥ 0."""
    a = math.sqrt(max(0.0, 1 - (b * b + c * c + d * d)))
    return [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c],
    ]
