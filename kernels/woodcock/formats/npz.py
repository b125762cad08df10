"""NumPy's .npz: a zip file of .npy arrays, as numpy.savez and savez_compressed write it; an array's name is its grid's.

Members that are no volumes (a voxel size, say) are passed over unless they are asked for by name. Only what these two
functions write is read: members stored or deflated, not encrypted. The format is PKWARE's APPNOTE 6.3: local members,
the central directory, its end record, each of the last two also in a 64-bit form. Nothing is ever unpickled.
"""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass

from woodcock.formats import npy
from woodcock.formats.dense import check_shape, info, keep, unit_cube
from woodcock.formats.grid import MAX_GRIDS, Data, File, Grid, GridInfo, VolumeError, choose, quoted
from woodcock.formats.packed import check_packed, unpack

_MEMBER, _ENTRY, _END, _END_64, _LOCATOR_64 = (b"PK" + kind for kind in (b"\3\4", b"\1\2", b"\5\6", b"\6\6", b"\6\7"))
_STORED, _DEFLATED = 0, 8
_LONGEST_END = 20 + 22 + 0xFFFF  # locator, end record and its comment
_FULL = 0xFFFFFFFF  # a 32-bit field that stands in the 64-bit form instead


@dataclass(frozen=True)
class _Member:
    name: str
    method: int
    checksum: int
    packed: int
    size: int
    position: int  # of its local header


def recognises(file: File) -> bool:
    return file.data[:4] in (_MEMBER, _END)


def read(file: File, name: str | None) -> Grid:
    """The array `name`; it fills the unit cube. Raises VolumeError."""
    members = _members(file.data)
    if name not in members:
        infos = _volumes(file.data, members)
        name = infos[choose([found.name for found in infos], name)].name
    member = members[name]
    try:
        header = _header(file.data, member)
        data, start = _payload(file.data, member)
        values = keep(npy.array(data, header, start), owned=isinstance(data, bytearray))
    except VolumeError as error:
        raise VolumeError(f"array {quoted(name)} {error}") from None
    return Grid(name, values, unit_cube(values.shape), placed=False)


def list_grids(file: File) -> tuple[GridInfo, ...]:
    """All arrays that are volumes; every voxel counts as active. Raises VolumeError."""
    return _volumes(file.data, _members(file.data))


def _volumes(data: Data, members: dict[str, _Member]) -> tuple[GridInfo, ...]:
    found, fault = [], "holds no array"
    for member in members.values():
        try:
            header = _header(data, member)
            found.append(info(member.name, header.shape, header.dtype))
        except VolumeError as error:
            fault = f"array {quoted(member.name)} {error}"
    if not found:
        raise VolumeError(fault)
    return tuple(found)


def _header(data: Data, member: _Member) -> npy.Header:
    start, end = _span(data, member)
    size = min(member.size, npy.LONGEST_HEADER)
    if member.method == _DEFLATED:
        header = npy.header(unpack(data, start, end, size, "deflate"))
    else:
        header = npy.header(data[start : min(end, start + size)])
    check_shape(header.shape)
    if member.size != header.start + math.prod(header.shape) * header.dtype.itemsize:
        raise VolumeError(f"is damaged: its {member.size} bytes are not those of an array of shape {header.shape}")
    if member.method == _DEFLATED:
        check_packed(end - start, member.size, "deflate")
    return header


def _payload(data: Data, member: _Member) -> tuple[Data | bytearray, int]:
    """What holds the bytes of a member whose size has been checked, and where they begin in it."""
    start, end = _span(data, member)
    if member.method == _DEFLATED:
        unpacked = unpack(data, start, end, member.size, "deflate")
        checksum = zlib.crc32(unpacked)
    else:
        with memoryview(data) as whole, whole[start:end] as stored:
            checksum = zlib.crc32(stored)
    if checksum != member.checksum:
        raise VolumeError("is damaged: its checksum is wrong")
    return (unpacked, 0) if member.method == _DEFLATED else (data, start)


def _span(data: Data, member: _Member) -> tuple[int, int]:
    """Where the packed bytes of a member begin and end."""
    if member.method not in (_STORED, _DEFLATED):
        raise VolumeError(f"is packed by method {member.method}; only those that numpy writes, 0 and 8, can be read")
    local = _take(data, member.position, 30)
    name_length, extra_length = struct.unpack_from("<2H", local, 26)
    start = member.position + 30 + name_length + extra_length
    end = start + member.packed
    if local[:4] != _MEMBER or end > len(data) or (member.method == _STORED and member.packed != member.size):
        raise VolumeError("is damaged or cut short")
    return start, end


def _members(data: Data) -> dict[str, _Member]:
    """The .npy members by name, in the file's order."""
    position, count = _directory(data)
    if count > MAX_GRIDS:
        raise VolumeError(f"has {count} members, more than the {MAX_GRIDS} that are allowed")
    members = {}
    for _ in range(count):
        entry = _take(data, position, 46)
        method, checksum, packed, size = struct.unpack_from("<10xH4x3I", entry)
        name_length, extra_length, comment_length, local = struct.unpack_from("<28x3H8xI", entry)
        if entry[:4] != _ENTRY:
            raise VolumeError("is damaged: its directory of members cannot be read")
        rest = _take(data, position + 46, name_length + extra_length + comment_length)
        name = rest[:name_length].decode("utf-8", "replace")
        size, packed, local = _wide(rest[name_length : name_length + extra_length], (size, packed, local))
        if name.endswith(".npy"):
            name = name.removesuffix(".npy")
            members[name] = _Member(name, method, checksum, packed, size, local)
        position += 46 + len(rest)
    return members


def _directory(data: Data) -> tuple[int, int]:
    """Where the central directory begins, and how many members it has."""
    tail_start = max(0, len(data) - _LONGEST_END)
    tail = data[tail_start:]
    at = tail.rfind(_END)
    if at < 0:
        raise VolumeError("is damaged or cut short: a zip file must end in its directory of members")
    count, position = struct.unpack("<10xH4xI2x", _take(data, tail_start + at, 22))
    locator = tail[max(0, at - 20) : at]
    if locator[:4] == _LOCATOR_64:
        end_64 = _take(data, int.from_bytes(locator[8:16], "little"), 56)
        if end_64[:4] != _END_64:
            raise VolumeError("is damaged: its directory of members cannot be found")
        count, position = struct.unpack_from("<32xQ8xQ", end_64)
    return position, count


def _wide(extra: bytes, numbers: tuple[int, int, int]) -> list[int]:
    """The numbers of an entry, those that do not fit in 32 bits from its extra field of kind 1."""
    wide = b""
    while len(extra) >= 4 and not wide:
        kind, length = struct.unpack_from("<2H", extra)
        wide, extra = extra[4 : 4 + length] if kind == 1 else b"", extra[4 + length :]
    found = []
    for number in numbers:
        if number == _FULL and len(wide) >= 8:
            number, wide = int.from_bytes(wide[:8], "little"), wide[8:]
        found.append(number)
    return found


def _take(data: Data, position: int, size: int) -> bytes:
    if position + size > len(data):
        raise VolumeError(f"is damaged or cut short: {size} bytes are due at byte {position} of {len(data)}")
    return data[position : position + size]
