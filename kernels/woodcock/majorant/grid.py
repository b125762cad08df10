"""Bounds on σ_t for the cells of a coarse grid over the tracking space.

A bound holds for every value that a lookup at any position of its cell may give, trilinear or one-tap stochastic, and a
little beyond its faces, because the device finds a ray's cell only to the rounding of float32.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from woodcock.majorant.hops import hops, pace
from woodcock.space import Array, Space

FIELDS = {"cells_x": "int", "cells_y": "int", "cells_z": "int", "per_cell": "vector3"}
BUFFERS = {"bounds": "float"}

#: The bits of a bound that tell of blocks; and a bound with which to tell of empty ones, per length of the device.
BLOCKS, LEAST = np.uint32(7), np.float32(2.0**-100)

Floats = NDArray[np.float32]

#: Cells along the longest side at most: 2^24 cells have indices that a float holds.
MOST_CELLS = 256

#: How far beyond a cell's faces its bound holds, as a part of the whole: 16 times what float32 rounds positions by.
MARGIN = 2.0**-20


@dataclass(frozen=True)
class Bounded:
    """What majorants need of a grid medium.

    slab(a, b) × scale: σ_t of the layers a to b - 1, float32 [z][y][x], scene units, the largest of its channels, as
    stored on the device; size: voxels (x, y, z); footprint: how far from a voxel's middle it counts, in voxels, 1
    trilinear and ½ nearest; to_scene: (4, 4) from voxels.
    """

    slab: Callable[[int, int], Floats]
    scale: float
    size: tuple[int, int, int]
    footprint: float
    to_scene: Array

    @property
    def sides(self) -> Array:
        """(3,): of its box in the scene."""
        return np.asarray(np.linalg.norm(self.to_scene[:3, :3], axis=0) * self.size)


def counts(size: Sequence[float] | Array, resolution: int) -> tuple[int, int, int]:
    """Cells (x, y, z) of a box: `resolution` along the longest side, as near to cubes as can be."""
    x, y, z = (max(1, round(resolution * side / max(size))) for side in size)
    return x, y, z


def cut(bounds: Array, sides: Array, space: Space, *, blocks: bool) -> tuple[str, Floats]:
    """The file by which walks go through cells, and what these hold: one by one, or by blocks.

    bounds: [z][y][x] in scene units; sides: (3,) of the box that is cut, in the scene.
    """
    if not blocks:
        return "majorant/grid_cells.h", buffers(bounds, space)["bounds"]
    found = hops(bounds, pace(sides, bounds.shape[::-1]))
    return "majorant/grid_hops.h", buffers(found.bounds, space, found.exponents)["bounds"]


def mean_chord(sides: Array) -> float:
    """Of a box by its sides, (3,): 4 V / S (Cauchy), as of every convex body."""
    return 2 / float(np.sum(1 / sides))


def record(cells: tuple[int, int, int], size: Array) -> dict[str, Array | int]:
    """size: (3,) of the tracking space."""
    return {"cells_x": cells[0], "cells_y": cells[1], "cells_z": cells[2], "per_cell": np.array(cells) / size}


def buffers(bounds: Array, space: Space, blocks: NDArray[np.uint32] | None = None) -> dict[str, Floats]:
    """bounds: [z][y][x] in scene units -> those of the device, rounded up. blocks: the exponents of hops.py, which the
    lowest bits of bounds tell; then no bound is quite 0."""
    with np.errstate(over="ignore"):
        scaled = np.ldexp(bounds, space.length_exponent).astype(np.float32)
    raised = np.where(scaled > 0, np.nextafter(scaled, np.float32(np.inf)), np.float32(0))
    kept = np.minimum(raised, np.finfo(np.float32).max / 256).astype(np.float32).reshape(-1)
    return {"bounds": kept if blocks is None else with_blocks(np.maximum(kept, LEAST), blocks.reshape(-1))}


def with_blocks(bounds: Floats, exponents: NDArray[np.uint32]) -> Floats:
    """The same bounds or a little higher, with these for their lowest bits."""
    return ((bounds.view(np.uint32) | BLOCKS) + 1 + exponents).view(np.float32)


def blocks_of(bounds: Floats) -> NDArray[np.uint32]:
    return bounds.view(np.uint32) & BLOCKS


def bounds(medium: Bounded, cells: tuple[int, int, int], error: float = 0.0, extreme: np.ufunc = np.maximum) -> Array:
    """[z][y][x]: the largest σ_t over each cell of the medium's own box. error: of positions, a length in the scene;
    extreme: np.minimum for the least."""
    margins = MARGIN * np.array(medium.size) + error * np.abs(np.linalg.inv(medium.to_scene)[:3, :3]).sum(axis=1)
    ranges = [
        _voxels(n, count, medium.footprint, margin)
        for n, count, margin in zip(medium.size, cells, margins.tolist(), strict=True)
    ]
    result = np.empty(cells[::-1])
    for layer, (low, high) in enumerate(ranges[2]):
        plane = extreme.reduce(medium.slab(low, high), axis=0)
        result[layer] = _pooled(_pooled(plane, ranges[1], extreme).T, ranges[0], extreme).T
    return result * medium.scale


def combined(
    media: Sequence[Bounded],
    cells: tuple[int, int, int],
    low: Array,
    high: Array,
    error: float = 0.0,
    extreme: np.ufunc = np.maximum,
) -> Array:
    """[z][y][x]: bounds on Σ σ_t over the cells of the axis-aligned box from low to high, (3,) each, in the scene; the
    least of a cell that lies partly outside a medium is 0."""
    total = np.zeros(cells[::-1])
    side = (high - low) / cells
    x, y, z = (low[axis] + side[axis] * np.arange(cells[axis]) for axis in range(3))
    for medium in media:
        # Every cell of the box covers a parallelepiped of the same extent in the medium; a few cells of it span that.
        to_voxels = np.linalg.inv(medium.to_scene)
        extent = np.abs(to_voxels[:3, :3]) @ side
        own = np.clip(np.ceil(4 * np.array(medium.size) / extent), 1, np.minimum(medium.size, MOST_CELLS)).astype(int)
        largest = bounds(medium, (int(own[0]), int(own[1]), int(own[2])), error, extreme)

        to_cells = np.diag([*(own / medium.size), 1.0]) @ to_voxels
        turn, extent = to_cells[:3, :3], extent * own / medium.size
        margin = MARGIN * (own + extent * max(cells)) + error * np.abs(turn).sum(axis=1)
        span = extent + 2 * margin
        window = np.minimum(np.floor(span) + 2, own).astype(int)
        for axis in range(3):
            largest = _windowed(largest, 2 - axis, int(window[axis]), extreme)
        first = to_cells[:3, 3] + np.minimum(turn, 0) @ side - margin
        for layer in range(cells[2]):
            places = []
            for axis in range(3):
                start = first[axis] + turn[axis, 0] * x + turn[axis, 1] * y[:, None] + turn[axis, 2] * z[layer]
                # A window no longer than the medium may end short of it: then any overlap counts as all.
                short = (window[axis] == own[axis]) & (start < 0) & (start + span[axis] >= 0)
                place = np.where(short, 0, np.floor(start))
                if extreme is np.minimum:
                    outside = (start < 0) | (start + span[axis] > own[axis])
                    place = np.where(outside, -window[axis], np.floor(start))
                places.append(np.clip(place, -window[axis], own[axis]).astype(int) + window[axis])
            total[layer] += largest[places[2], places[1], places[0]]
    return total


def _voxels(size: int, cells: int, footprint: float, margin: float) -> list[tuple[int, int]]:
    """For each cell along an axis the voxels [a, b) that count in it; the border ones count all the way outwards."""
    edges = np.arange(cells + 1) * (size / cells)
    low = np.clip(np.floor(edges[:-1] - margin + 0.5 - footprint), 0, size - 1).astype(int)
    high = np.clip(np.ceil(edges[1:] + margin - 0.5 + footprint), 1, size).astype(int)
    return list(zip(low.tolist(), high.tolist(), strict=True))


def _pooled(plane: Floats, ranges: list[tuple[int, int]], extreme: np.ufunc) -> Floats:
    """Extremes over ranges of the first axis."""
    # `reduceat` takes starts; every other one of its results is the gap between two ranges.
    padded = np.concatenate([plane, plane[-1:]])
    result: Floats = extreme.reduceat(padded, np.array(ranges).reshape(-1), axis=0)[::2]
    return result


def _windowed(values: Array, axis: int, width: int, extreme: np.ufunc) -> Array:
    """Extremes over [i - width, i) of an axis for i from 0 to its length + width; outside it is 0."""
    moved = np.moveaxis(values, axis, 0)
    padding = np.zeros((width, *moved.shape[1:]))
    result = np.concatenate([padding, moved, padding])
    covered = 1
    while covered < width:
        step = min(covered, width - covered)
        result = extreme(result[:-step], result[step:])
        covered += step
    return np.moveaxis(result, 0, axis)
