"""OpenVDB files: the archive around the trees.

Written from the definition in the OpenVDB project: `io/Archive.cc` (header), `io/GridDescriptor.cc` (table of grids),
`MetaMap.cc` (metadata), `math/Maps.h` (transforms). A file is a header, metadata, and then for each grid its
descriptor, compression flags, metadata, transform and tree (`vdb_tree.py`). A grid may be an instance: it then has
everything but a tree and uses that of its parent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from woodcock.formats.grid import MAX_GRIDS, Data, File, Grid, GridInfo, VolumeError, choose, quoted
from woodcock.formats.vdb_codec import ACTIVE_MASK, BLOSC, ZIP, Cursor, Layout
from woodcock.formats.vdb_tree import background, dense_values, leaf_values, topology

MAGIC = b" BDV\0\0\0\0"

#: 222 came with OpenVDB 3 (2014); 225 only added a type of tree.
VERSIONS = range(222, 226)

_TREES = {"Tree_float_5_4_3": 1, "Tree_vec3s_5_4_3": 3}  # those that can be read, and their channels

_SCALE_MAPS = ("ScaleMap", "UniformScaleMap")
_SCALE_TRANSLATE_MAPS = ("ScaleTranslateMap", "UniformScaleTranslateMap")
_MATRIX_MAPS = ("AffineMap", "UnitaryMap")

Matrix = npt.NDArray[np.float64]
Metadata = dict[str, tuple[str, bytes]]  # name -> type, value


@dataclass(frozen=True)
class _Entry:
    """A grid's descriptor. Unique names of grids that share one carry a number after a record separator."""

    unique_name: str
    tree: str
    parent: str
    position: int

    @property
    def name(self) -> str:
        name, separator, number = self.unique_name.partition("\x1e")
        return f"{name}[{number}]" if separator else name


@dataclass(frozen=True)
class _Header:
    """What stands between a grid's descriptor and its tree; the cursor is at the tree."""

    compression: int
    metadata: Metadata
    map_type: str
    index_to_world: Matrix | None  # None if the map is none that can be used
    cursor: Cursor

    @property
    def half(self) -> bool:
        # The descriptor's type says it too, with a suffix, but this is what OpenVDB goes by.
        return self.metadata.get("is_saved_as_half_float") == ("bool", b"\1")

    def number(self, key: str) -> int | None:
        kind, value = self.metadata.get(key, ("", b""))
        return int.from_bytes(value, "little", signed=True) if kind == "int64" else None

    def position(self, key: str) -> list[int] | None:
        kind, value = self.metadata.get(key, ("", b""))
        return np.frombuffer(value, "<i4").tolist() if kind == "vec3i" and len(value) == 12 else None


def recognises(file: File) -> bool:
    return file.data[: len(MAGIC)] == MAGIC


def read(file: File, name: str | None) -> Grid:
    """The grid `name`. Raises VolumeError."""
    data = file.data
    entries = _entries(data)
    entry = entries[choose([entry.name for entry in entries], name)]
    try:
        return _read(data, entry, entries)
    except VolumeError as error:
        raise VolumeError(f"grid {quoted(entry.name)} {error}") from None


def _read(data: Data, entry: _Entry, entries: list[_Entry]) -> Grid:
    header = _header(data, entry)
    if entry.tree not in _TREES:
        raise VolumeError(f"holds values of type {quoted(_type(entry, header))}; only float and vec3s can be read")
    if header.index_to_world is None:
        raise VolumeError(f"is placed by a map of type {quoted(header.map_type)}; only linear maps can be read")
    if header.metadata.get("class") == ("string", b"level set"):
        raise VolumeError("is a level set, which stores distances to a surface; convert it to a fog volume")

    source = _source(data, entry, header, entries)
    layout = Layout(_TREES[entry.tree], source.half, source.compression)
    if bool((background(source.cursor, layout) != 0).any()):
        raise VolumeError("has a background other than 0: it would fill all of space")
    tree = topology(source.cursor, layout, dense=True)
    stated = source.number("file_voxel_count")
    if stated is not None and stated != tree.voxels:
        raise VolumeError(f"is damaged: it holds {tree.voxels} active voxels, but says {stated}")
    values, low = dense_values(leaf_values(source.cursor, tree), tree)
    if layout.channels == 1:
        values = values[..., 0]

    # The sample of voxel i is at index i in OpenVDB, and in the middle of the cell [i, i+1] here.
    cell_to_index = np.eye(4)
    cell_to_index[:3, 3] = np.array(low) - 0.5
    with np.errstate(all="ignore"):
        index_to_world = header.index_to_world @ cell_to_index
    if not np.isfinite(index_to_world).all():
        raise VolumeError("is damaged: its transform leads beyond all numbers")
    return Grid(entry.name, values, index_to_world, placed=True)


def list_grids(file: File) -> tuple[GridInfo, ...]:
    """All grids; of those that `read` refuses the shape and the number of voxels that their metadata states, or 0.
    Raises VolumeError."""
    entries = _entries(file.data)
    return tuple(_info(file.data, entry, entries) for entry in entries)


def _info(data: Data, entry: _Entry, entries: list[_Entry]) -> GridInfo:
    header = _header(data, entry)
    if entry.tree in _TREES and header.index_to_world is not None:
        source = _source(data, entry, header, entries)
        layout = Layout(_TREES[entry.tree], source.half, source.compression)
        background(source.cursor, layout)
        tree = topology(source.cursor, layout, dense=False)
        return GridInfo(entry.name, _type(entry, source), tree.active.shape, tree.voxels)
    low, high = header.position("file_bbox_min"), header.position("file_bbox_max")
    x, y, z = (max(0, b - a + 1) for a, b in zip(low, high, strict=True)) if low and high else (0, 0, 0)
    return GridInfo(entry.name, _type(entry, header), (x, y, z), max(0, header.number("file_voxel_count") or 0))


def _type(entry: _Entry, header: _Header) -> str:
    value = entry.tree.removeprefix("Tree_").removesuffix("_5_4_3")
    return {"float": "half", "vec3s": "vec3h"}.get(value, value) if header.half else value


def _source(data: Data, entry: _Entry, header: _Header, entries: list[_Entry]) -> _Header:
    """The header of the grid whose tree this one uses: its own, unless it is an instance."""
    if not entry.parent:
        return header
    for other in entries:
        if other.unique_name == entry.parent and other.tree == entry.tree and not other.parent:
            source_header = _header(data, other)
            if source_header.index_to_world is not None:
                return source_header
    raise VolumeError(
        f"is an instance of {quoted(entry.parent)}, which the file does not have as a grid of the same type"
    )


def _entries(data: Data) -> list[_Entry]:
    cursor = Cursor(data, len(MAGIC))
    version = cursor.uint32()
    if version not in VERSIONS:
        raise VolumeError(
            f"is of OpenVDB file version {version}; {VERSIONS[0]} to {VERSIONS[-1]} can be read, write it anew"
        )
    cursor.take(8)  # version of the library
    has_offsets = cursor.byte()
    if not has_offsets:
        raise VolumeError("was written to a stream, without a table of its grids; write it to a file")
    cursor.take(36)  # uuid
    _metadata(cursor)
    entries = []
    count = cursor.uint32()
    if count > MAX_GRIDS:
        raise VolumeError(f"has {count} grids, more than the {MAX_GRIDS} that are allowed")
    for _ in range(count):
        name, tree, parent = cursor.string(), cursor.string(), cursor.string()
        position, _, end = cursor.int64(), cursor.int64(), cursor.int64()
        # Every grid lies behind the last: this ends, whatever the numbers are.
        if not cursor.position <= position <= end <= len(data):
            raise VolumeError(
                f"is damaged: grid {quoted(name)} is said to be at bytes {position} to {end} of {len(data)}"
            )
        entries.append(_Entry(name, tree.removesuffix("_HalfFloat"), parent, position))
        cursor.position = end
    return entries


def _header(data: Data, entry: _Entry) -> _Header:
    cursor = Cursor(data, entry.position)
    compression = cursor.uint32()
    if compression & ~(ZIP | ACTIVE_MASK | BLOSC):
        raise VolumeError(f"is damaged: unknown compression flags {compression:#x}")
    metadata = _metadata(cursor)
    map_type = cursor.string()
    return _Header(compression, metadata, map_type, _index_to_world(cursor, map_type), cursor)


def _metadata(cursor: Cursor) -> Metadata:
    # Every value states its length, so types that are not known, such as that for delayed loading, need no care.
    metadata: Metadata = {}
    for _ in range(cursor.uint32()):
        name, kind = cursor.string(), cursor.string()
        metadata[name] = kind, cursor.take(cursor.uint32())
    return metadata


def _index_to_world(cursor: Cursor, map_type: str) -> Matrix | None:
    matrix = np.eye(4)
    if map_type in _MATRIX_MAPS:
        matrix[:] = cursor.array("<f8", 16).reshape(4, 4).T  # the file's is for row vectors
    elif map_type == "TranslationMap":
        matrix[:3, 3] = cursor.array("<f8", 3)
    elif map_type in _SCALE_TRANSLATE_MAPS:
        matrix[:3, 3] = cursor.array("<f8", 3)
        matrix[:3, :3] = np.diag(cursor.array("<f8", 15)[:3])  # what follows the scale is derived from it
    elif map_type in _SCALE_MAPS:
        matrix[:3, :3] = np.diag(cursor.array("<f8", 15)[:3])
    else:
        return None
    with np.errstate(all="ignore"):
        size = abs(np.linalg.det(matrix[:3, :3])) if np.isfinite(matrix).all() else 0.0
    if not 0 < size < np.inf or not np.allclose(matrix[3], (0, 0, 0, 1), rtol=0, atol=1e-9):
        raise VolumeError("is damaged: its transform is no affine map that can be inverted")
    matrix[3] = (0, 0, 0, 1)
    return matrix
