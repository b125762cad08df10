"""NanoVDB files (.nvdb): the archive around the trees (`nanovdb_tree.py`).

Written from the definitions in NanoVDB's `io/IO.h` and `NanoVDB.h`, file versions 32.x. A file is a run of segments:
each a header, then for each grid its metadata and name, then the grids, plain or packed by zip or blosc. Since 32.6 a
file may also be the bare grids, one after the other.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from woodcock.formats.dense import Matrix, from_samples
from woodcock.formats.grid import MAX_GRIDS, Data, File, Grid, GridInfo, VolumeError, choose, quoted
from woodcock.formats.nanovdb_tree import GRID_HEADER, LAYOUTS, TREE_END, leaf_values, root_of, topology
from woodcock.formats.packed import check_packed, unpack
from woodcock.formats.vdb_codec import Cursor, unpack_blosc
from woodcock.formats.vdb_tree import dense_values

_SEGMENTS, _GRID = (b"NanoVDB0", b"NanoVDB2"), b"NanoVDB1"
MAJOR_VERSION = 32

_PLAIN, _ZIP, _BLOSC = range(3)
_BLOSC_CHUNK = 1 << 30  # bytes of a grid that are packed together
_LEVEL_SET = 1

_HEADER = struct.Struct("<8sI2H")
#: Sizes of the grid in memory and in the file, active voxels, type, their bounding box, size of the name.
_METADATA = struct.Struct("<2Q8xQI52x6i24xI36x")

_NAMES = [
    *("unknown", "float", "double", "int16", "int32", "int64", "vec3f", "vec3d", "mask", "half", "uint32", "bool"),
    *("rgba8", "fp4", "fp8", "fp16", "fpN", "vec4f", "vec4d", "index", "on index", "index mask", "on index mask"),
    *("point index", "vec3u8", "vec3u16", "uint8"),
]


@dataclass(frozen=True)
class _Entry:
    """A grid: what its segment says of it and where it stands."""

    name: str
    kind: int
    low: tuple[int, int, int]
    high: tuple[int, int, int]
    voxels: int
    codec: int
    start: int
    end: int
    size: int  # unpacked

    @property
    def type(self) -> str:
        return _NAMES[self.kind] if self.kind < len(_NAMES) else f"type {self.kind}"


def recognises(file: File) -> bool:
    return file.data[:8] in (*_SEGMENTS, _GRID)


def read(file: File, name: str | None) -> Grid:
    """The grid `name`. Raises VolumeError."""
    entries = _entries(file.data)
    entry = entries[choose([entry.name for entry in entries], name)]
    try:
        return _read(file.data, entry)
    except VolumeError as error:
        raise VolumeError(f"grid {quoted(entry.name)} {error}") from None


def list_grids(file: File) -> tuple[GridInfo, ...]:
    """All grids, by what the file says of them. Raises VolumeError."""
    infos = []
    for entry in _entries(file.data):
        x, y, z = (max(0, b - a + 1) if entry.voxels else 0 for a, b in zip(entry.low, entry.high, strict=True))
        infos.append(GridInfo(entry.name, entry.type, (x, y, z), entry.voxels))
    return tuple(infos)


def _read(data: Data, entry: _Entry) -> Grid:
    if entry.kind not in LAYOUTS:
        known = ", ".join(_NAMES[kind] for kind in LAYOUTS)
        raise VolumeError(f"holds values of type {entry.type}; {known} can be read")
    unpacked = _unpacked(data, entry)
    header = GRID_HEADER.unpack_from(unpacked)
    *numbers, grid_class, kind = header[1:]
    if header[0] >> 21 != MAJOR_VERSION or kind != entry.kind:
        raise VolumeError("is damaged: it is not what its file says it is")
    if grid_class == _LEVEL_SET:
        raise VolumeError("is a level set, which stores distances to a surface; convert it to a fog volume")
    tree, leaves = topology(unpacked, kind)
    if tree.voxels != entry.voxels:
        raise VolumeError(f"is damaged: it holds {tree.voxels} active voxels, but says {entry.voxels}")
    values, low = dense_values(leaf_values(unpacked, kind, tree, leaves), tree)
    if tree.layout.channels == 1:
        values = values[..., 0]
    return Grid(entry.name, values, _index_to_world(numbers, low), placed=True)


def _index_to_world(numbers: list[float], low: list[int]) -> Matrix:
    """`numbers` are the nine of the matrix, its inverse's nine, and the translation."""
    matrix, place = np.eye(4), np.eye(4)
    matrix[:3, :3] = np.reshape(numbers[:9], (3, 3))
    matrix[:3, 3] = numbers[18:21]
    place[:3, 3] = low
    with np.errstate(all="ignore"):
        return from_samples(matrix @ place)


def _unpacked(data: Data, entry: _Entry) -> bytes | bytearray:
    if entry.size < GRID_HEADER.size:
        raise VolumeError("is damaged: it is shorter than its header")
    if entry.codec == _PLAIN:
        return data[entry.start : entry.end]
    cursor = Cursor(data, entry.start)
    if entry.codec == _ZIP:
        length = cursor.int64()
        if not 0 <= length <= entry.end - cursor.position:
            raise VolumeError("is damaged: its zip buffer does not fit into the file")
        return unpack(data, cursor.position, cursor.position + length, entry.size, "zlib")
    unpacked = bytearray()
    while len(unpacked) < entry.size:
        chunk = cursor.take(cursor.int64())
        unpacked += unpack_blosc(chunk, min(_BLOSC_CHUNK, entry.size - len(unpacked)))
    return unpacked


def _entries(data: Data) -> list[_Entry]:
    """All grids of a file; those of one name are numbered."""
    entries = list(_bare(data) if data[:8] == _GRID else _segments(data))
    counts = Counter(entry.name for entry in entries)
    numbers: Counter[str] = Counter()
    for place, entry in enumerate(entries):
        if counts[entry.name] > 1:
            entries[place] = replace(entry, name=f"{entry.name}[{numbers[entry.name]}]")
            numbers[entry.name] += 1
    return entries


def _segments(data: Data) -> Iterator[_Entry]:
    cursor, known = Cursor(data), 0
    while cursor.position < len(data):
        magic, version, count, codec = _HEADER.unpack(cursor.take(_HEADER.size))
        known += count
        if magic not in _SEGMENTS or codec > _BLOSC or known > MAX_GRIDS:
            raise VolumeError(f"is damaged: a segment cannot be read before byte {cursor.position}")
        if version >> 21 != MAJOR_VERSION:
            raise VolumeError(f"is of NanoVDB version {version >> 21}; {MAJOR_VERSION} can be read, write it anew")
        found = []
        for _ in range(count):
            size, packed, voxels, kind, *box, length = _METADATA.unpack(cursor.take(_METADATA.size))
            name = cursor.take(length).partition(b"\0")[0].decode("utf-8", "replace")
            found.append((name, kind, box, voxels, packed, size))
        for name, kind, box, voxels, packed, size in found:
            start = cursor.position
            cursor.skip(size if codec == _PLAIN else packed)
            if codec != _PLAIN:
                check_packed(packed, size, "zlib" if codec == _ZIP else "blosc")
            low, high = tuple(box[:3]), tuple(box[3:])
            yield _Entry(name, kind, low, high, voxels, codec, start, cursor.position, size)


def _bare(data: Data) -> Iterator[_Entry]:
    cursor, known = Cursor(data), 0
    while cursor.position < len(data):
        start, known = cursor.position, known + 1
        header = cursor.take(TREE_END)
        version, size = struct.unpack_from("<16xI12xQ", header)
        if header[:8] != _GRID or size < TREE_END or known > MAX_GRIDS:
            raise VolumeError(f"is damaged: a grid cannot be read at byte {start}")
        if version >> 21 != MAJOR_VERSION:
            raise VolumeError(f"is of NanoVDB version {version >> 21}; {MAJOR_VERSION} can be read, write it anew")
        name = header[40:296].partition(b"\0")[0].decode("utf-8", "replace")
        (kind,), (voxels,) = struct.unpack_from("<I", header, 636), struct.unpack_from("<Q", header, TREE_END - 8)
        box = Cursor(data, start + root_of(header)).array("<i4", 6).tolist()
        cursor.position = start
        cursor.skip(size)
        yield _Entry(name, kind, tuple(box[:3]), tuple(box[3:]), voxels, _PLAIN, start, cursor.position, size)
