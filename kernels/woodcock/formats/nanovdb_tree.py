"""NanoVDB's tree in memory, which is also how a file stores it.

Written from the definitions in NanoVDB's `PNanoVDB.h`, versions 32.x. A grid is one run of bytes: a header, the tree's
sizes, the root with its table, then nodes of 32³, of 16³ and leaves of 8³ voxels, each found from its parent by the
distance between them and 32-byte aligned. Positions are those of the parent's table, so a node's own idea of where it
lies is not looked at.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from woodcock.formats.dense import keep
from woodcock.formats.grid import VolumeError
from woodcock.formats.vdb_codec import Layout
from woodcock.formats.vdb_tree import (
    LOWER,
    ROOT_SPAN,
    SPAN,
    UPPER,
    Positions,
    Tree,
    add_leaves,
    add_tiles,
    check_content,
    places_of,
    room_for_leaves,
)

#: Version, the transform's 21 numbers, class, type.
GRID_HEADER = struct.Struct("<16xI364x21d80x2I32x")
TREE_END = GRID_HEADER.size + 64

_ALIGNMENT = 32
_MASKS = 32  # where the masks of an inner node begin: active values, then children
_TABLES = {UPPER: 8256, LOWER: 1088}  # where their tables begin
_LEAF_FLAGS, _LEAF_MASK, _LEAF_MINIMUM, _LEAF_CODES = 15, 16, 80, 96

Bytes: TypeAlias = npt.NDArray[np.uint8]
Places: TypeAlias = npt.NDArray[np.int64]  # (n,) where nodes begin


@dataclass(frozen=True)
class _Layout:
    """How a type is stored. `bits` are those of a quantised value in a leaf, 0 if each leaf has its own."""

    value: np.dtype[Any]
    channels: int = 1
    bits: int | None = None

    @property
    def size(self) -> int:
        return self.value.itemsize * self.channels

    @property
    def wide(self) -> bool:  # values of eight bytes are aligned to eight
        return self.value.itemsize == 8

    @property
    def root_size(self) -> int:  # box, count, background, minimum, maximum, two statistics
        return 96 if self.wide or self.channels == 3 else 64

    @property
    def stride(self) -> int:  # of a table, whose entries are values or distances
        return 16 if self.channels == 3 else 8

    @property
    def leaf_values(self) -> int:
        return 128 if self.wide or self.channels == 3 else 96

    @property
    def leaf_size(self) -> int:
        return self.leaf_values + 64 * self.bits if self.bits is not None else self.leaf_values + 512 * self.size


#: Types that can be read, by their numbers.
LAYOUTS = {
    1: _Layout(np.dtype("<f4")),
    2: _Layout(np.dtype("<f8")),
    6: _Layout(np.dtype("<f4"), channels=3),
    9: _Layout(np.dtype("<f2")),
    13: _Layout(np.dtype("<f4"), bits=4),
    14: _Layout(np.dtype("<f4"), bits=8),
    15: _Layout(np.dtype("<f4"), bits=16),
    16: _Layout(np.dtype("<f4"), bits=0),
}


def root_of(header: bytes | bytearray) -> int:
    """Where the root begins, from the first TREE_END bytes of a grid."""
    (distance,) = struct.unpack_from("<24xQ", header, GRID_HEADER.size)
    return GRID_HEADER.size + int(distance)


def topology(grid: bytes | bytearray, kind: int) -> tuple[Tree, Places]:
    """The tree, and where in `grid` its leaves are. Raises VolumeError for what is no such tree, has a background other
    than 0, or content too large for a dense array."""
    layout = LAYOUTS[kind]
    data = np.frombuffer(grid, np.uint8)
    if len(data) < TREE_END:
        raise VolumeError("is damaged: it is shorter than its header")
    tree = Tree(Layout(layout.channels, layout.value.itemsize == 2, 0))
    root = root_of(grid)
    uppers, origins = _root(data, root, layout, tree)
    lowers, origins = _children(data, uppers, origins, UPPER, layout, tree)
    leaves, origins = _children(data, lowers, origins, LOWER, layout, tree)
    _check(data, leaves, layout.leaf_size)
    masks = _gather(data, leaves, _ALIGNMENT * 3)[:, _LEAF_MASK : _LEAF_MASK + 64]
    add_leaves(tree, origins, np.ascontiguousarray(masks))
    check_content(tree)
    return tree, leaves


def leaf_values(grid: bytes | bytearray, kind: int, tree: Tree, leaves: Places) -> npt.NDArray[Any]:
    """(leaves, 512, channels)"""
    layout = LAYOUTS[kind]
    data = np.frombuffer(grid, np.uint8)
    values = room_for_leaves(tree)
    for start in range(0, len(leaves), 4096):  # in batches, to bound the memory for copies
        batch = slice(start, start + 4096)
        if layout.bits is None:
            stored = _gather(data, leaves[batch], layout.leaf_size)[:, layout.leaf_values :]
            values[batch] = _kept(stored.view(layout.value).reshape(-1, 512, layout.channels))
        else:
            values[batch] = _dequantised(data, leaves[batch], layout.bits)[..., None]
    return values


def _root(data: Bytes, root: int, layout: _Layout, tree: Tree) -> tuple[Places, Positions]:
    """Reads the root: its children, and the origins of what they span."""
    value_at, tile_size = (24, 32) if layout.wide else (20, 32)
    head = _bytes(data, root, layout.root_size)
    count = int(head[24:28].view("<u4")[0])
    background = 32 if layout.wide else 28
    if bool((head[background : background + layout.size].view(layout.value) != 0).any()):
        raise VolumeError("has a background other than 0: it would fill all of space")
    table = _bytes(data, root + layout.root_size, count * tile_size).reshape(-1, tile_size)
    keys, children = table[:, :8].copy().view("<u8")[:, 0], table[:, 8:16].copy().view("<i8")[:, 0]
    active = table[:, 16:20].copy().view("<u4")[:, 0] != 0
    values = table[:, value_at : value_at + layout.size].copy().view(layout.value)
    if len(np.unique(keys)) != count:
        raise VolumeError("is damaged: its root has two entries for one place")
    parts = np.stack([keys >> np.uint64(42), keys >> np.uint64(21), keys], axis=1) & np.uint64((1 << 20) - 1)
    cells = parts.astype(np.int64)
    origins = np.where(cells >= 1 << 19, cells - (1 << 20), cells) * ROOT_SPAN
    child = children != 0
    add_tiles(tree, origins[~child], ROOT_SPAN, _kept(values[~child]), active[~child], True)
    return root + children[child], origins[child]


def _children(
    data: Bytes, nodes: Places, origins: Positions, log2: int, layout: _Layout, tree: Tree
) -> tuple[Places, Positions]:
    """Reads the inner nodes of one level: all their children, and the origins of those."""
    count, masks = 1 << 3 * log2, (1 << 3 * log2) // 8
    size = _TABLES[log2] + count * layout.stride
    _check(data, nodes, size)
    places, found = [np.empty(0, np.int64)], [np.empty((0, 3), np.int64)]
    for node, origin in zip(nodes.tolist(), origins, strict=True):
        bits = np.unpackbits(data[node + _MASKS : node + _MASKS + 2 * masks], bitorder="little").view(np.bool_)
        active, child = bits[:count], bits[count:]
        table = data[node + _TABLES[log2] : node + size].reshape(count, layout.stride)
        children = np.flatnonzero(child)
        places.append(node + np.ascontiguousarray(table[children, :8]).view("<i8")[:, 0])
        found.append(places_of(origin, children, log2))
        stored = np.ascontiguousarray(table[:, : layout.size]).view(layout.value)
        tiles = np.flatnonzero(~child & (active | (stored != 0).any(axis=1)))
        add_tiles(tree, places_of(origin, tiles, log2), SPAN[log2], _kept(stored[tiles]), active[tiles], True)
    return np.concatenate(places), np.concatenate(found)


def _dequantised(data: Bytes, leaves: Places, own_bits: int) -> npt.NDArray[np.float32]:
    """(n, 512): minimum + quantum × code, the codes of 1 to 16 bits, the lowest bits of a byte first."""
    heads = _gather(data, leaves, _LEAF_CODES)
    minimum, quantum = np.ascontiguousarray(heads[:, _LEAF_MINIMUM : _LEAF_MINIMUM + 8]).view("<f4").T[..., None]
    widths = np.full(len(leaves), own_bits) if own_bits else 1 << (heads[:, _LEAF_FLAGS] >> 5).astype(np.int64)
    codes = np.empty((len(leaves), 512), np.float32)
    for bits in np.unique(widths).tolist():
        chosen = np.flatnonzero(widths == bits)
        if bits > 16:
            raise VolumeError(f"is damaged: a leaf of {bits} bits a value")
        _check(data, leaves[chosen], _LEAF_CODES + 64 * bits)
        packed = _gather(data, leaves[chosen], _LEAF_CODES + 64 * bits)[:, _LEAF_CODES:]
        if bits == 16:
            codes[chosen] = np.ascontiguousarray(packed).view("<u2")
        else:
            shifts = np.arange(0, 8, bits, dtype=np.uint8)
            codes[chosen] = (packed[:, :, None] >> shifts & ((1 << bits) - 1)).reshape(-1, 512)
    with np.errstate(all="ignore"):
        values: npt.NDArray[np.float32] = minimum + quantum * codes
    return values


def _kept(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return keep(values, owned=True)


def _bytes(data: Bytes, start: int, size: int) -> Bytes:
    if not 0 <= start <= start + size <= len(data):
        raise VolumeError(f"is damaged or cut short: {size} bytes are due at byte {start} of {len(data)}")
    return data[start : start + size]


def _check(data: Bytes, nodes: Places, size: int) -> None:
    """Refuses nodes that cannot all be there: beyond the grid, or so many that some would have to share their bytes."""
    outside = len(nodes) and (nodes.min() < 0 or nodes.max() > len(data) - size or bool((nodes % _ALIGNMENT).any()))
    if outside or len(nodes) * size > len(data):
        raise VolumeError(f"is damaged or cut short: {len(nodes)} nodes of {size} bytes cannot be in its {len(data)}")


def _gather(data: Bytes, nodes: Places, size: int) -> Bytes:
    """(n, size): the first bytes of checked nodes."""
    blocks = data[: len(data) // _ALIGNMENT * _ALIGNMENT].reshape(-1, _ALIGNMENT)
    gathered: Bytes = blocks[(nodes // _ALIGNMENT)[:, None] + np.arange(size // _ALIGNMENT)]
    return gathered.reshape(-1, size)
