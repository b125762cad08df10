"""OpenVDB's tree, root → 32³ → 16³ → 8³ voxels, as a dense array.

A file has the topology first (masks, and the values of tiles), then the buffers of the leaves, both depth first. See
`tree/RootNode.h`, `InternalNode.h` and `LeafNode.h` of the OpenVDB project for the definition. In memory positions are
(x, y, z); within a node x is the slowest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from woodcock.formats.grid import VolumeError, check_bytes, check_size
from woodcock.formats.vdb_codec import Cursor, Layout, node_values

LEAF, LOWER, UPPER = 3, 4, 5  # log2 of a node's width in children; a leaf's children are voxels
SPAN = {LOWER: 1 << LEAF, UPPER: 1 << (LEAF + LOWER)}  # voxels along the edge of a child
ROOT_SPAN = 1 << (LEAF + LOWER + UPPER)

Positions = npt.NDArray[np.int64]  # (n, 3)
Masks = npt.NDArray[np.uint8]  # (n, 64): byte 8x + y, bit z


class Box:
    """The bounding box of what was added, in voxels; `low` and `high` are both inside."""

    def __init__(self) -> None:
        self.low: list[int] = []
        self.high: list[int] = []

    @property
    def shape(self) -> tuple[int, int, int]:
        x, y, z = (high - low + 1 for low, high in zip(self.low, self.high, strict=True)) if self.low else (0, 0, 0)
        return x, y, z

    def add(self, lows: Positions, highs: Positions) -> None:
        if len(lows):
            low, high = lows.min(axis=0).tolist(), highs.max(axis=0).tolist()
            self.low = list(map(min, self.low, low)) if self.low else low
            self.high = list(map(max, self.high, high)) if self.high else high

    def add_voxels(self, origins: Positions, masks: Masks) -> None:
        """The voxels of leaves that are on in their masks."""
        cells = masks.reshape(-1, 8, 8)
        kept = np.logical_or.reduce(cells, axis=(1, 2))
        cells, origins = cells[kept], origins[kept]
        along_x, along_y = np.logical_or.reduce(cells, axis=2), np.logical_or.reduce(cells, axis=1)
        along_z = np.unpackbits(np.bitwise_or.reduce(cells, axis=(1, 2)), bitorder="little").reshape(-1, 8)
        occupied = (along_x, along_y, along_z)
        first = np.stack([axis.argmax(axis=1) for axis in occupied], axis=1)
        last = np.stack([7 - axis[:, ::-1].argmax(axis=1) for axis in occupied], axis=1)
        self.add(origins + first, origins + last)


@dataclass
class Tree:
    """What the topology says. `content` bounds what is active or differs from the background of zero, as far as known
    before the leaves' buffers are read; the tiles are those that are not zero."""

    layout: Layout
    origins: Positions = field(default_factory=lambda: np.empty((0, 3), np.int64))
    masks: Masks = field(default_factory=lambda: np.empty((0, 64), np.uint8))
    tiles: list[tuple[Positions, int, npt.NDArray[Any]]] = field(default_factory=list)  # origins, edge, values
    active: Box = field(default_factory=Box)
    content: Box = field(default_factory=Box)
    voxels: int = 0  # active ones


def background(cursor: Cursor, layout: Layout) -> npt.NDArray[np.float32]:
    """The first thing in a tree, (channels,)."""
    if cursor.uint32() != 1:
        raise VolumeError("is damaged: a tree must have one buffer a leaf")
    return cursor.array("<f4", layout.channels)


def topology(cursor: Cursor, layout: Layout, *, dense: bool) -> Tree:
    """Reads on from the background. With `dense` false only `active` and `voxels` are right; with it a tree whose
    content is too large for a dense array is refused."""
    tree = Tree(layout)
    tile_count, child_count = cursor.uint32(), cursor.uint32()
    tile = np.dtype([("origin", "<i4", 3), ("value", "<f4", (layout.channels,)), ("active", "u1")])
    tiles = cursor.array(tile, tile_count)
    seen = set(map(tuple, tiles["origin"].tolist()))
    add_tiles(tree, tiles["origin"].astype(np.int64), ROOT_SPAN, tiles["value"], tiles["active"] != 0, dense)

    origins: list[Positions] = []
    masks: list[Masks] = []
    last: tuple[int, ...] = ()
    for _ in range(child_count):
        origin = cursor.array("<i4", 3).astype(np.int64)
        key = tuple(origin.tolist())
        if any(n % ROOT_SPAN for n in key) or key in seen or key <= last:
            raise VolumeError(f"is damaged: a branch of the tree lies at {key}")
        last = key
        for upper in _internal(cursor, tree, origin, UPPER, dense):
            leaves = _internal(cursor, tree, upper, LOWER, dense)
            origins.append(leaves)
            masks.append(cursor.array(np.uint8, 64 * len(leaves)).reshape(-1, 64))
    if origins:
        add_leaves(tree, np.concatenate(origins), np.concatenate(masks))
    if dense:
        check_content(tree)
    return tree


def check_content(tree: Tree) -> None:
    """Refuses a tree whose content is too large for a dense array."""
    check_size(tree.content.shape, "spans", tree.layout.channels)


def add_leaves(tree: Tree, origins: Positions, masks: Masks) -> None:
    """All the leaves there are."""
    tree.origins, tree.masks = origins, masks
    tree.voxels += int(np.bitwise_count(masks).sum(dtype=np.int64))
    for box in (tree.active, tree.content):
        box.add_voxels(origins, masks)


def _internal(cursor: Cursor, tree: Tree, origin: Positions, log2: int, dense: bool) -> Positions:
    """Reads one internal node, adds its tiles to the tree and returns the origins of its children, (n, 3)."""
    count = 1 << 3 * log2
    child, active = cursor.bits(count), cursor.bits(count)
    values = node_values(cursor, tree.layout, active)
    tiles = np.flatnonzero(~child & (active | (values != 0).any(axis=1)))
    add_tiles(tree, places_of(origin, tiles, log2), SPAN[log2], values[tiles], active[tiles], dense)
    return places_of(origin, np.flatnonzero(child), log2)


def places_of(origin: Positions, children: npt.NDArray[np.intp], log2: int) -> Positions:
    mask = (1 << log2) - 1
    xyz = np.stack([children >> 2 * log2, children >> log2 & mask, children & mask], axis=1)
    places: Positions = origin + xyz * SPAN[log2]
    return places


def add_tiles(
    tree: Tree,
    origins: Positions,
    span: int,
    values: npt.NDArray[Any],
    active: npt.NDArray[np.bool_],
    dense: bool,
) -> None:
    tree.voxels += int(np.count_nonzero(active)) * span**3
    tree.active.add(origins[active], origins[active] + (span - 1))
    if dense:
        filled = (values != 0).any(axis=1)
        content = origins[active | filled]
        tree.content.add(content, content + (span - 1))
        # Now, not at the end: it also bounds how many tiles a hostile file can make us keep.
        check_content(tree)
        if filled.any():
            tree.tiles.append((origins[filled], span, values[filled]))


def dense_values(leaves: npt.NDArray[Any], tree: Tree) -> tuple[npt.NDArray[Any], list[int]]:
    """All values as [z][y][x][channel], one voxel of background on every side of the content, and the position
    (x, y, z) of the first. `leaves` (n, 512, channels) are those of `tree.origins`. A tree without content gives one
    voxel."""
    filled = (leaves != 0).any(axis=2)
    tree.content.add_voxels(tree.origins, np.packbits(filled, axis=1, bitorder="little"))
    low = [n - 1 for n in tree.content.low] or [0, 0, 0]
    shape = [n + 2 for n in tree.content.shape] if tree.content.low else [1, 1, 1]
    check_size(shape, "spans, with its border,", tree.layout.channels)

    kept = np.float16 if tree.layout.half else np.float32
    values = np.zeros((*shape[::-1], tree.layout.channels), kept)
    for origins, span, tiles in tree.tiles:
        for (x, y, z), tile in zip((origins - low).tolist(), tiles, strict=True):
            values[z : z + span, y : y + span, x : x + span] = tile
    # Where a leaf's voxels go, in the flat array: its place plus the same 512 steps for all. Voxels beyond the box are
    # zero and left out, so that every index is inside.
    flat, (_, height, width) = values.reshape(-1, tree.layout.channels), values.shape[:3]
    voxel = np.arange(512)
    steps = ((voxel & 7) * height + (voxel >> 3 & 7)) * width + (voxel >> 6)
    x, y, z = (tree.origins - low).T
    places = (z * height + y) * width + x
    for start in range(0, len(leaves), 4096):  # in batches, to bound the memory for indices
        batch = slice(start, start + 4096)
        flat[(places[batch, None] + steps)[filled[batch]]] = leaves[batch][filled[batch]]
    return values, low


def leaf_values(cursor: Cursor, tree: Tree) -> npt.NDArray[Any]:
    """Reads on from the topology: (leaves, 512, channels)."""
    values = room_for_leaves(tree)
    for leaf, mask in enumerate(tree.masks):
        if cursor.take(64) != mask.tobytes():
            raise VolumeError(
                f"is damaged: leaf {leaf} of {len(tree.masks)} does not have the mask it was announced by"
            )
        active = np.unpackbits(mask, bitorder="little").view(np.bool_)
        values[leaf] = node_values(cursor, tree.layout, active)
    return values


def room_for_leaves(tree: Tree) -> npt.NDArray[Any]:
    """(leaves, 512, channels), not yet filled."""
    shape, dtype = (len(tree.masks), 512, tree.layout.channels), tree.layout.dtype
    check_bytes(math.prod(shape) * dtype.itemsize, f"has {len(tree.masks)} leaf nodes, which take")
    return np.empty(shape, dtype)
