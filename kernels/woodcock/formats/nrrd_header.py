"""NRRD's header: lines of `field: value` up to an empty one.

Written from "Definition of NRRD File Format" of the Teem project, versions NRRD0001 to NRRD0005. `space directions` and
`space origin` (of the first sample) place the samples; without directions `spacings` give the size of the voxels of a
box that begins at the origin. The axes of space are as the file has them, whatever they are called; `axis mins`,
`measurement frame` and units are not looked at.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from woodcock.formats.dense import Matrix, check_shape
from woodcock.formats.grid import Data, VolumeError, quoted

MAGIC = b"NRRD000"

#: Encoding -> how it is unpacked.
PACKED = {"gzip": "gzip", "gz": "gzip", "bzip2": "bzip2", "bz2": "bzip2"}

_MOST_BYTES = 1 << 20  # of a header
_MOST_SKIPPED = 1 << 26  # lines or bytes before the values

_WIDTHS = {"char": 1, "short": 2, "int": 4, "longlong": 8, "long long": 8}
_WORDS = re.compile(r"(signed |unsigned |u)?(char|short|int|longlong|long long)( int)?")
_SIZED = re.compile(r"(u?)int(8|16|32|64)(_t)?")
_VECTOR = re.compile(r"none|\(([^(),]{1,60}),([^(),]{1,60}),([^(),]{1,60})\)")
_SPATIAL_KINDS = ("domain", "space", "???", "none")


@dataclass(frozen=True)
class Header:
    """What the values are, and where: behind `end` (or in `data_file`) first `lines` are skipped, then, once unpacked,
    `skip` bytes; -1 says that the values are the last bytes. `shape` has the slowest axis first."""

    shape: tuple[int, ...]
    vector_axis: int | None  # which of the shape holds the three numbers of a vector
    dtype: np.dtype[Any]
    encoding: str
    data_file: str | None
    lines: int
    skip: int
    end: int
    samples_to_world: Matrix | None

    @property
    def size(self) -> int:
        return math.prod(self.shape) * self.dtype.itemsize


def parse(data: Data) -> Header:
    """The header at the beginning of a file. Raises VolumeError."""
    end, fields = _fields(data)
    encoding = fields.get("encoding", "").lower()
    if encoding != "raw" and encoding not in PACKED:
        raise VolumeError(f"is encoded as {quoted(encoding)}; raw, gzip and bzip2 can be read")
    sizes = _integers(fields, "sizes")
    vector_axis = _vector_axis(sizes, fields)
    axes = [axis for axis in range(len(sizes)) if axis != vector_axis]
    check_shape([*(sizes[axis] for axis in reversed(axes)), 1 if vector_axis is None else 3])
    (lines,), (skip,) = _integers(fields, "lineskip", "0"), _integers(fields, "byteskip", "0")
    if not 0 <= lines <= _MOST_SKIPPED or not (0 if encoding in PACKED else -1) <= skip <= _MOST_SKIPPED:
        raise VolumeError(f"skips {lines} lines and {skip} bytes before its values, which cannot be right")
    return Header(
        shape=tuple(reversed(sizes)),
        vector_axis=None if vector_axis is None else len(sizes) - 1 - vector_axis,
        dtype=_dtype(fields),
        encoding=encoding,
        data_file=fields.get("datafile"),
        lines=lines,
        skip=skip,
        end=end,
        samples_to_world=_samples_to_world(fields, axes),
    )


def _fields(data: Data) -> tuple[int, dict[str, str]]:
    """Where the header ends, and its fields by their names in small letters without blanks."""
    start = data[:_MOST_BYTES]
    blank = re.search(rb"\n\r?\n", start)
    if not blank and len(data) > _MOST_BYTES:
        raise VolumeError(f"has no empty line within {_MOST_BYTES} bytes, which would end its header")
    end = blank.end() if blank else len(start)
    fields = {}
    for line in start[:end].decode("utf-8", "replace").split("\n")[1:]:
        name, colon, value = line.partition(":")
        if colon and not line.startswith("#") and not value.startswith("="):  # := marks what is no field
            fields[name.replace(" ", "").lower()] = value.strip()
    return end, fields


def _integers(fields: dict[str, str], name: str, default: str = "") -> list[int]:
    words = fields.get(name, default).split()
    if not words or len(words) > 16 or not all(re.fullmatch(r"-?[0-9]{1,18}", word) for word in words):
        raise VolumeError(f"has no {name} that can be read: {quoted(fields.get(name, ''))}")
    if len(words) > 1 and name != "sizes":
        raise VolumeError(f"has several numbers for its {name}")
    return list(map(int, words))


def _vector_axis(sizes: list[int], fields: dict[str, str]) -> int | None:
    if fields.get("dimension") != str(len(sizes)):
        raise VolumeError(f"says it has {quoted(fields.get('dimension', ''))} dimensions, and has {len(sizes)} sizes")
    if len(sizes) not in (3, 4) or min(sizes) < 1:
        size = " × ".join(map(str, sizes))
        raise VolumeError(f"holds {size} values; it must have three axes, or four, one of them for vectors")
    if len(sizes) == 3:
        return None
    directions = [match[0] == "none" for match in _VECTOR.finditer(fields.get("spacedirections", ""))]
    kinds = [kind.lower() not in _SPATIAL_KINDS for kind in fields.get("kinds", "").split()]
    stated = [marks for marks in (directions, kinds) if len(marks) == 4] or [[True, False, False, False]]
    for marks in stated:
        if sum(marks) == 1:
            axis = marks.index(True)
            if sizes[axis] == 3:
                return axis
            raise VolumeError(f"has {sizes[axis]} values a voxel, along axis {axis}; it must have 1 or 3")
    raise VolumeError("has four axes, of which one alone must not be one of space")


def _dtype(fields: dict[str, str]) -> np.dtype[Any]:
    text = " ".join(fields.get("type", "").lower().split())
    words, sized = _WORDS.fullmatch(text), _SIZED.fullmatch(text)
    if text in ("float", "double"):
        code = "f4" if text == "float" else "f8"
    elif sized:
        code = f"{'u' if sized[1] else 'i'}{int(sized[2]) // 8}"
    elif words:
        code = f"{'u' if (words[1] or '').startswith('u') else 'i'}{_WIDTHS[words[2]]}"
    else:
        raise VolumeError(f"holds values of type {quoted(text)}; only integers and floats can be read")
    order = {"little": "<", "big": ">"}.get(fields.get("endian", "").lower())
    if order is None and code[1] != "1":
        raise VolumeError("must say whether it is endian: little or endian: big")
    return np.dtype(f"{order or '|'}{code}")


def _samples_to_world(fields: dict[str, str], axes: list[int]) -> Matrix | None:
    """Sample (i, j, k) to the world; None if the header does not say."""
    matrix = np.eye(4)
    if "spacedirections" in fields:
        directions = [_numbers(match) for match in _VECTOR.finditer(fields["spacedirections"])]
        columns = [directions[axis] for axis in axes if axis < len(directions)]
        if len(columns) != 3 or None in columns:
            raise VolumeError("must have three space directions of three numbers each")
        matrix[:3, :3] = np.transpose(np.array(columns))
        origin = _VECTOR.fullmatch(fields.get("spaceorigin", "(0,0,0)"))
        matrix[:3, 3] = (origin and _numbers(origin)) or math.nan
        return matrix
    try:
        spacings = [float(word) for word in fields["spacings"].split()]
        steps = np.array([spacings[axis] for axis in axes])
    except (KeyError, ValueError, IndexError):
        return None
    if not (np.isfinite(steps).all() and (steps > 0).all()):
        return None
    matrix[:3, :3] = np.diag(steps)
    matrix[:3, 3] = steps / 2
    return matrix


def _numbers(vector: re.Match[str]) -> list[float] | None:
    try:
        return [float(number) for number in vector.groups()]
    except (ValueError, TypeError):
        return None
