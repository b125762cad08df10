"""A grid as a medium reads it: how its values are stored, in bricks and chunks, and what they are bounded by."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.formats import Grid
from woodcock.space import Array

FIELDS = {
    "from_local": "affine",
    "width": "int",
    "height": "int",
    "depth": "int",
    "bricks_x": "int",
    "bricks_y": "int",
}

BRICK = 4
STORED: dict[str, np.dtype[Any]] = {
    "uint8": np.dtype(np.uint8),
    "half": np.dtype(np.float16),
    "float": np.dtype(np.float32),
}

#: Bytes of a buffer at most; a field that needs more is cut into chunks.
CHUNK = 512 << 20
#: Chunks of a field: a kernel takes no more than so many pointers; chunks grow instead.
MOST_CHUNKS = 32
#: Bytes of values that are converted at a time.
SLAB = 16 << 20

Values = NDArray[np.generic]
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Buffer:
    """An array of the device that is filled piece by piece: `pieces` gives its values in order, contiguous."""

    dtype: np.dtype[np.generic]
    size: int
    pieces: Callable[[], Iterator[Values]]

    @classmethod
    def of(cls, array: Values) -> Buffer:
        return cls(array.dtype, array.size, lambda: iter([np.ascontiguousarray(array).reshape(-1)]))

    @property
    def nbytes(self) -> int:
        return self.size * self.dtype.itemsize

    def array(self) -> Values:
        """All of it, on the host."""
        return np.concatenate(list(self.pieces()))


@dataclass(frozen=True)
class Field:
    """storage: key of STORED; a stored number times step is the value. error: the largest, relative to `largest`, the
    largest value. nearest: no interpolation."""

    grid: Grid
    largest: float
    storage: str
    step: float
    error: float
    nearest: bool = False

    @classmethod
    def of(cls, grid: Grid, largest: float, allowed: float = 0.0, *, nearest: bool = False) -> Field:
        """With the narrowest storage whose largest error, relative to the largest value, is `allowed` or less."""
        for storage, step in _candidates(grid.values.dtype, largest, allowed):
            error = _error(grid.values, storage, step, largest, allowed)
            if error is not None:
                break
        return cls(grid, largest, storage, step, error or 0.0, nearest)

    @property
    def channels(self) -> int:
        return 1 if self.grid.values.ndim == 3 else 3

    @property
    def size(self) -> tuple[int, int, int]:
        """Voxels (x, y, z)."""
        z, y, x = self.grid.values.shape[:3]
        return x, y, z

    @property
    def bricks(self) -> tuple[int, int, int]:
        """Bricks (x, y, z)."""
        x, y, z = (-(-n // BRICK) for n in self.size)
        return x, y, z

    def record(self, to_scene: Array, own_to_scene: Array) -> dict[str, Any]:
        """to_scene, own_to_scene: (4, 4) from the medium's local space and from this grid's."""
        width, height, depth = self.size
        from_local = np.linalg.solve(own_to_scene, to_scene)[:3]
        numbers = {"width": width, "height": height, "depth": depth}
        return {"from_local": from_local, **numbers, "bricks_x": self.bricks[0], "bricks_y": self.bricks[1]}

    def decoded(self, first: int, stop: int) -> Floats:
        """The layers as the device sees them: float32 [z][y][x], or [z][y][x][3]."""
        values = _encoded(self.grid.values[first:stop], self.storage, self.step)
        return _decoded(values, self.step)

    def stored(self, first: int, stop: int) -> Floats:
        """The layers' stored numbers, which times `step` are values: float32, exactly."""
        return _encoded(self.grid.values[first:stop], self.storage, self.step).astype(np.float32)

    def shift(self, most: int = CHUNK) -> int:
        """log2 of the bricks of a chunk, for buffers of at most so many bytes; MOST_CHUNKS may ask for more."""
        bytes_of_brick = BRICK**3 * self.channels * STORED[self.storage].itemsize
        shift, count = max(0, int(most // bytes_of_brick).bit_length() - 1), math.prod(self.bricks)
        while count >> shift >= MOST_CHUNKS:
            shift += 1
        return shift

    def chunks(self, shift: int) -> list[Buffer]:
        """Buffers of 2^shift bricks each, the last of what is left."""
        count, numbers = math.prod(self.bricks), BRICK**3 * self.channels
        dtype = np.dtype(np.uint16) if self.storage == "half" else STORED[self.storage]
        return [
            Buffer(dtype, (stop - first) * numbers, _Pieces(self, first, stop))
            for first in range(0, count, 1 << shift)
            for stop in (min(first + (1 << shift), count),)
        ]

    def _layers(self, first: int, stop: int) -> Iterator[Values]:
        """The bricks [first, stop), one run a layer of them; padded by the border's values."""
        x, y, _ = self.bricks
        padding = [(0, -n % BRICK) for n in self.size]
        for layer in range(first // (x * y), -(-stop // (x * y))):
            values = _encoded(self.grid.values[layer * BRICK : (layer + 1) * BRICK], self.storage, self.step)
            rows = [(0, BRICK - len(values)), padding[1], padding[0], *[(0, 0)] * (values.ndim - 3)]
            padded = np.pad(values, rows, mode="edge").reshape(BRICK, y, BRICK, x, BRICK, -1)
            bricks = padded.transpose(1, 3, 0, 2, 4, 5).reshape(x * y, -1)
            run = np.ascontiguousarray(bricks[max(first - layer * x * y, 0) : stop - layer * x * y]).reshape(-1)
            yield run.view(np.uint16) if self.storage == "half" else run


@dataclass(frozen=True)
class _Pieces:
    field: Field
    first: int
    stop: int

    def __call__(self) -> Iterator[Values]:
        return self.field._layers(self.first, self.stop)


def slabs(values: Values) -> Iterator[tuple[int, int]]:
    """Ranges of layers of at most SLAB bytes as float32, or one layer."""
    layers = max(1, SLAB // max(1, 4 * int(np.prod(values.shape[1:]))))
    for first in range(0, len(values), layers):
        yield first, min(first + layers, len(values))


def _candidates(dtype: np.dtype[np.generic], largest: float, allowed: float) -> Iterator[tuple[str, float]]:
    """(storage, step), the narrowest first. Half and float are scaled to the largest, so that no exponent is wasted."""
    exponent = int(np.frexp(largest)[1]) if largest > 0 else 0
    half = 2.0 ** (exponent - 16)
    if largest / half >= 65520:  # which rounds to infinity
        half *= 2
    if dtype == np.uint8:
        return iter([("uint8", 1.0)])
    quantised = [("uint8", largest / 255)] if allowed > 0 and largest > 0 else []
    return iter([("uint8", 1.0), *quantised, ("half", half), ("float", 2.0**exponent)])


def _encoded(values: Values, storage: str, step: float) -> Values:
    if values.dtype == STORED[storage] and step == 1:
        return values
    with np.errstate(over="ignore"):
        narrow = 1e-37 < step < 1e37
        scaled = values.astype(np.float32) / np.float32(step) if narrow else values.astype(np.float64) / step
        if storage == "uint8":
            scaled = np.clip(np.rint(scaled), 0, 255)
        stored: Values = scaled.astype(STORED[storage])
        return stored


def _decoded(stored: Values, step: float) -> Floats:
    if 1e-37 < step < 1e37:
        return stored.astype(np.float32) * np.float32(step)
    return (stored.astype(np.float64) * step).astype(np.float32)


def _error(values: Values, storage: str, step: float, largest: float, allowed: float) -> float | None:
    """The largest error of what is stored, relative to the largest value; None if it is more than allowed."""
    if storage == "float" or (values.dtype == np.uint8 and step == 1):
        return 0.0
    worst = 0.0
    for first, stop in slabs(values):
        slab = values[first:stop].astype(np.float64)
        off = np.abs(_encoded(values[first:stop], storage, step).astype(np.float64) * step - slab)
        worst = max(worst, float(off.max()) / largest if largest > 0 else 0.0)
        if worst > allowed:
            return None
    return worst
