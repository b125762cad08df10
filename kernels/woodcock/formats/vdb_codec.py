"""How OpenVDB writes things: numbers, strings, masks, and the values of a node.

Everything is little-endian. See `openvdb/io/Compression.h` and `Compression.cc` of the OpenVDB project for the
definition of node values.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from woodcock.formats.grid import Data, VolumeError

ZIP, ACTIVE_MASK, BLOSC = 1, 2, 4  # the bits of a grid's compression flags

# What a node says of its inactive values, if it leaves them out (codes 0, 1 and 3 concern the background alone):
ONE_INACTIVE, MASK_AND_ONE_INACTIVE, MASK_AND_TWO_INACTIVE, ALL_VALUES = 2, 4, 5, 6
_WITH_VALUE = (ONE_INACTIVE, MASK_AND_ONE_INACTIVE, MASK_AND_TWO_INACTIVE)
_WITH_MASK = (3, MASK_AND_ONE_INACTIVE, MASK_AND_TWO_INACTIVE)


class Cursor:
    """A position in the bytes of a file that cannot leave them."""

    def __init__(self, data: Data, position: int = 0) -> None:
        self.data = data
        self.position = position

    def take(self, size: int) -> bytes:
        start = self.position
        self.skip(size)
        return self.data[start : self.position]

    def skip(self, size: int) -> None:
        end = self.position + size
        if not self.position <= end <= len(self.data):
            raise VolumeError(
                f"is damaged or cut short: {size} bytes are due at byte {self.position} of {len(self.data)}"
            )
        self.position = end

    def byte(self) -> int:
        return self.take(1)[0]

    def uint32(self) -> int:
        return int.from_bytes(self.take(4), "little")

    def int64(self) -> int:
        return int.from_bytes(self.take(8), "little", signed=True)

    def string(self) -> str:
        return self.take(self.uint32()).decode("utf-8", "replace")

    def array(self, dtype: npt.DTypeLike, count: int) -> npt.NDArray[Any]:
        return np.frombuffer(self.take(np.dtype(dtype).itemsize * count), dtype)

    def bits(self, count: int) -> npt.NDArray[np.bool_]:
        """A mask of `count` bits, the lowest bit of a byte first."""
        return np.unpackbits(self.array(np.uint8, count // 8), bitorder="little").view(np.bool_)


@dataclass(frozen=True)
class Layout:
    """How a tree's values are stored: numbers a value, half or float, and the grid's compression flags."""

    channels: int
    half: bool
    compression: int

    @property
    def dtype(self) -> np.dtype[Any]:
        return np.dtype("<f2" if self.half else "<f4")


def node_values(cursor: Cursor, layout: Layout, active: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """The values of a node whose `active` voxels (n,) are known, as (n, channels) of the layout's type.

    For a background of zero; with any other, the inactive values that equal ± the background are wrong.
    """
    code = cursor.byte()
    if code > ALL_VALUES:
        raise VolumeError(f"is damaged: a node says {code} of its inactive values, 0 to {ALL_VALUES} have a meaning")
    # These are full floats even in a grid of halves.
    first = _narrow(cursor.array("<f4", layout.channels), layout) if code in _WITH_VALUE else None
    second = _narrow(cursor.array("<f4", layout.channels), layout) if code == MASK_AND_TWO_INACTIVE else None
    selected = cursor.bits(len(active)) if code in _WITH_MASK else None

    sparse = bool(layout.compression & ACTIVE_MASK) and code != ALL_VALUES
    count = int(np.count_nonzero(active)) if sparse else len(active)
    stored = _unpack(cursor, layout, count).reshape(count, layout.channels)
    if count == len(active):
        return stored

    values = np.zeros((len(active), layout.channels), layout.dtype)
    if first is not None:
        values[:] = first
        if selected is not None:
            values[selected] = 0 if second is None else second
    values[active] = stored
    return values


def _narrow(value: npt.NDArray[Any], layout: Layout) -> npt.NDArray[Any]:
    with np.errstate(over="ignore", invalid="ignore"):
        narrow = value.astype(layout.dtype)
    if bool((np.isinf(narrow) & np.isfinite(value)).any()):
        raise VolumeError(f"is damaged: an inactive value {value.max():g} in a grid of halves")
    return narrow


def _unpack(cursor: Cursor, layout: Layout, count: int) -> npt.NDArray[Any]:
    """`count` values, flat."""
    size = count * layout.channels * layout.dtype.itemsize
    packed = layout.compression & (ZIP | BLOSC)
    # OpenVDB writes nothing at all for no halves, not even the size of nothing.
    if not packed or (layout.half and count == 0):
        return np.frombuffer(cursor.take(size), layout.dtype)
    length = cursor.int64()
    if length <= 0:  # the writer gained nothing by packing
        if -length != size:
            raise VolumeError(f"is damaged: a buffer of {-length} bytes where {size} are due")
        return np.frombuffer(cursor.take(size), layout.dtype)
    chunk = cursor.take(length)
    if size == 0:
        return np.empty(0, layout.dtype)
    return np.frombuffer(unpack_blosc(chunk, size) if packed & BLOSC else _zip(chunk, size), layout.dtype)


def _zip(chunk: bytes, size: int) -> bytes:
    stream = zlib.decompressobj()
    try:
        unpacked = stream.decompress(chunk, size + 1)
    except zlib.error:
        raise VolumeError("is damaged: a zip buffer cannot be unpacked") from None
    if len(unpacked) != size or not stream.eof:
        raise VolumeError(f"is damaged: a zip buffer does not unpack to the {size} bytes that are due")
    return unpacked


@cache
def _blosc() -> Any:
    import blosc

    # The buffers of a file are a few kilobytes each: handing them to threads costs more than unpacking them.
    blosc.set_nthreads(1)
    return blosc


def unpack_blosc(chunk: bytes, size: int) -> bytes:
    """The `size` bytes that one blosc buffer holds. Raises VolumeError."""
    # blosc believes the size in the buffer's own header and allocates it: check first.
    if len(chunk) < 16:
        raise VolumeError("is damaged: a blosc buffer is shorter than its header")
    unpacked_size, _, packed_size = struct.unpack_from("<3I", chunk, 4)
    if unpacked_size != size or packed_size != len(chunk):
        raise VolumeError(f"is damaged: a blosc buffer does not unpack to the {size} bytes that are due")
    blosc = _blosc()
    try:
        unpacked: bytes = blosc.decompress(chunk)
    except blosc.blosc_extension.error:
        raise VolumeError("is damaged: a blosc buffer cannot be unpacked") from None
    return unpacked
