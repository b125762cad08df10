"""Encoders of OpenVDB and NanoVDB files, written apart from the readers, and the OpenVDB library itself."""

from __future__ import annotations

import os
import struct
import subprocess
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import UUID

import blosc
import numpy as np
import pytest

ZIP, MASK, BLOSC = 1, 2, 4
MATRIX = np.diag([0.5, 0.5, 0.5, 1.0])

Array = np.ndarray[Any, Any]
Position = tuple[int, ...]  # x, y, z


@dataclass
class VdbGrid:
    """`leaves`: origin -> values (512, channels) and which are active; `tiles`: origin, log2 of the node (5: tiles of
    128³, 4: of 8³) -> value and whether it is active. `code` (0, 1 or 3) is that of nodes whose inactive values are all
    0, which means the same three times."""

    leaves: dict[Position, tuple[Array, Array]]
    tiles: dict[tuple[Position, int], tuple[float, bool]] = field(default_factory=dict)
    name: str = "density"
    flags: int = BLOSC | MASK
    half: bool = False
    channels: int = 1
    code: int = 0
    map: tuple[str, Array] = ("AffineMap", MATRIX)
    metadata: dict[str, tuple[str, bytes]] = field(default_factory=dict)

    def marks(self) -> dict[str, tuple[str, bytes]]:
        return {"is_saved_as_half_float": ("bool", b"\1")} if self.half else {}

    def payload(self, values: Array) -> bytes:
        raw = values.astype("<f2" if self.half else "<f4").tobytes()
        if not self.flags & (ZIP | BLOSC) or (self.half and not raw):
            return raw
        if self.flags & BLOSC:
            packed: bytes = blosc.compress(raw, typesize=4, cname="lz4")
        else:
            packed = zlib.compress(raw)
            if len(packed) >= len(raw):
                return struct.pack("<q", -len(raw)) + raw
        return struct.pack("<q", len(packed)) + packed

    def node(self, values: Array, active: Array, child: Array) -> bytes:
        if not self.flags & MASK:
            return b"\6" + self.payload(values)
        inactive = values[~active & ~child]
        nonzero = inactive.any(axis=1)
        filled = list(np.unique(inactive[nonzero], axis=0))
        if len(filled) + (not nonzero.all()) > 2:
            return b"\6" + self.payload(values)
        code = {0: self.code, 1: 2 if nonzero.all() else 4, 2: 5}[len(filled)]
        head = bytes([code]) + b"".join(value.astype("<f4").tobytes() for value in filled)
        if code in (3, 4, 5):
            second = filled[1] if code == 5 else np.zeros(self.channels)
            head += bits((values == second).all(axis=1) & ~active)
        return head + self.payload(values[active])

    def internal(self, origin: Position, log2: int) -> tuple[bytes, bytes]:
        """Topology and buffers of an internal node."""
        if log2 == 3:
            values, active = self.leaves[origin]
            return bits(active), bits(active) + self.node(values, active, np.zeros(512, bool))
        edge, count = {5: 128, 4: 8}[log2], 1 << 3 * log2
        child, active, values = np.zeros(count, bool), np.zeros(count, bool), np.zeros((count, self.channels))
        below: dict[int, Position] = {}
        for place in self.leaves if log2 == 4 else [at for at, _ in self.tiles] + list(self.leaves):
            base = tuple(n // edge * edge for n in place)
            if inside(base, origin, edge << log2) and (base, 5) not in self.tiles:
                below[index(base, origin, edge, log2)] = base
        for n in below:
            child[n] = True
        for (place, level), (value, on) in self.tiles.items():
            if level == log2 and inside(place, origin, edge << log2):
                values[index(place, origin, edge, log2)], active[index(place, origin, edge, log2)] = value, on
        branches = [self.internal(below[n], log2 - 1) for n in sorted(below)]
        topology = bits(child) + bits(active) + self.node(values, active, child)
        return topology + b"".join(a for a, _ in branches), b"".join(b for _, b in branches)

    def encode(self) -> bytes:
        name, numbers = self.map
        body = struct.pack("<I", self.flags) + metadata(self.metadata | self.marks())
        body += string(name) + np.asarray(numbers, "<f8").T.tobytes()
        places = [*self.leaves, *(place for place, _ in self.tiles)]
        roots = sorted({tuple(n // 4096 * 4096 for n in place) for place in places})
        body += struct.pack("<I", 1) + bytes(4 * self.channels) + struct.pack("<2I", 0, len(roots))
        branches = [self.internal(root, 5) for root in roots]
        body += b"".join(struct.pack("<3i", *root) + a for root, (a, _) in zip(roots, branches, strict=True))
        return body + b"".join(b for _, b in branches)


def bits(mask: Array) -> bytes:
    return np.packbits(mask, bitorder="little").tobytes()


def inside(place: tuple[int, ...], origin: Position, edge: int) -> bool:
    return all(0 <= n - first < edge for n, first in zip(place, origin, strict=True))


def index(place: tuple[int, ...], origin: Position, edge: int, log2: int) -> int:
    x, y, z = ((n - first) // edge for n, first in zip(place, origin, strict=True))
    return x << 2 * log2 | y << log2 | z


def string(text: str) -> bytes:
    return struct.pack("<I", len(text)) + text.encode()


def metadata(entries: dict[str, tuple[str, bytes]]) -> bytes:
    packed = (string(key) + string(kind) + string(value.decode("latin-1")) for key, (kind, value) in entries.items())
    return struct.pack("<I", len(entries)) + b"".join(packed)


def encode_file(*grids: VdbGrid, version: int = 224) -> bytes:
    data = b" BDV\0\0\0\0" + struct.pack("<3IB", version, 10, 0, 1) + str(UUID(int=0)).encode() + metadata({})
    data += struct.pack("<i", len(grids))
    for grid in grids:
        tree = {1: "Tree_float_5_4_3", 3: "Tree_vec3s_5_4_3"}[grid.channels]
        data += string(grid.name) + string(tree + "_HalfFloat" * grid.half) + string("")
        body = grid.encode()
        start = len(data) + 24
        data += struct.pack("<3q", start, start, start + len(body)) + body
    return data


@pytest.fixture(scope="session")
def vdb_grid() -> type[VdbGrid]:
    return VdbGrid


@pytest.fixture(scope="session")
def vdb_file() -> Callable[..., bytes]:
    return encode_file


@pytest.fixture(scope="session")
def openvdb() -> Callable[..., None]:
    """Runs openvdb_reference.py with arguments; skips where Debian's python3-openvdb is missing."""
    python = "/usr/bin/python3"
    try:
        subprocess.run([python, "-c", "import numpy, pyopenvdb"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        message = "OpenVDB itself is missing: apt install python3-openvdb python3-numpy"
        if os.environ.get("WOODCOCK_REQUIRE_OPENVDB") == "1":
            pytest.fail(message)
        pytest.skip(message)

    def run(*arguments: str | Path) -> None:
        script = Path(__file__).with_name("openvdb_reference.py")
        done = subprocess.run([python, script, *arguments], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    return run


# Where things stand in a grid of NanoVDB 32.x, after `pnanovdb_grid_type_constants` of PNanoVDB.h. By type: its number,
# background in the root, size of the root, size of a table's entry, values of a leaf.
NANOVDB = {
    "float": (1, 28, 64, 8, 96),
    "double": (2, 32, 96, 8, 128),
    "vec3f": (6, 28, 96, 16, 128),
    "half": (9, 28, 64, 8, 96),
    "fp4": (13, 28, 64, 8, 96),
    "fp8": (14, 28, 64, 8, 96),
    "fp16": (15, 28, 64, 8, 96),
    "fpN": (16, 28, 64, 8, 96),
}


@dataclass
class NanoVdbGrid:
    """`leaves` and `tiles` as in VdbGrid. A leaf of a type fpN takes 1, 2, 4, 8 or 16 bits a value, in turn."""

    type: str
    leaves: dict[Position, tuple[Array, Array]]
    tiles: dict[tuple[Position, int], tuple[float, bool]] = field(default_factory=dict)
    name: str = "density"
    matrix: Array = field(default_factory=lambda: MATRIX)
    grid_class: int = 2
    background: float = 0.0

    @property
    def dtype(self) -> str:
        return {"double": "<f8", "half": "<f2"}.get(self.type, "<f4")

    def voxels(self) -> int:
        tiles = sum({5: 128, 4: 8}[log2] ** 3 for (_, log2), (_, on) in self.tiles.items() if on)
        return tiles + sum(int(active.sum()) for _, active in self.leaves.values())

    def box(self) -> tuple[Position, Position]:
        corners = [np.add(at, np.argwhere(on.reshape(8, 8, 8))) for at, (_, on) in self.leaves.items()]
        for (at, log2), (_, on) in self.tiles.items():
            corners += [np.add(at, [[0] * 3, [{5: 127, 4: 7}[log2]] * 3])] * on
        every = np.concatenate(corners)
        return tuple(every.min(axis=0).tolist()), tuple(every.max(axis=0).tolist())

    def leaf(self, values: Array, active: Array, number: int) -> bytes:
        table = NANOVDB[self.type][4]
        head = bytearray(table)
        head[16:80] = bits(active)
        if not self.type.startswith("fp"):
            return bytes(head) + values.astype(self.dtype).tobytes()
        width = 1 << number % 5 if self.type == "fpN" else int(self.type[2:])
        low = np.float32(values.min())
        quantum = np.float32((values.max() - low) / ((1 << width) - 1) or 1)
        head[15], head[80:88] = (width.bit_length() - 1) << 5, struct.pack("<2f", low, quantum)
        packed = bytearray(64 * width)
        for n, value in enumerate(values[:, 0]):
            code = round(float((value - low) / quantum))
            for byte in range(max(1, width // 8)):
                packed[n * width // 8 + byte] |= (code >> 8 * byte & 255) << n * width % 8
        return bytes(head + packed)

    def node(self, origin: Position, log2: int, below: dict[Position, int], start: int) -> bytes:
        """An inner node at byte `start`; `below`: where the nodes of the next level are, by their origins."""
        edge, count, stride = {5: 128, 4: 8}[log2], 1 << 3 * log2, NANOVDB[self.type][3]
        child, active, table = np.zeros(count, bool), np.zeros(count, bool), bytearray(count * stride)
        for place, address in below.items():
            if inside(place, origin, edge << log2):
                n = index(place, origin, edge, log2)
                child[n] = True
                table[n * stride : n * stride + 8] = struct.pack("<q", address - start)
        for (place, level), (value, on) in self.tiles.items():
            if level == log2 and inside(place, origin, edge << log2):
                n = index(place, origin, edge, log2)
                active[n] = on
                raw = np.full(3 if stride == 16 else 1, value, self.dtype).tobytes()
                table[n * stride : n * stride + len(raw)] = raw
        return (bytes(32) + bits(active) + bits(child)).ljust({5: 8256, 4: 1088}[log2], b"\0") + bytes(table)

    def encode(self, version: int = 32 << 21 | 6 << 10) -> bytes:
        kind, background, root_size, stride, _ = NANOVDB[self.type]

        def around(edge: int, *levels: int) -> list[Position]:
            places = [*self.leaves, *(place for place, level in self.tiles if level in levels)]
            return sorted({tuple(n // edge * edge for n in place) for place in places})

        roots, lowers = around(4096, 5, 4), around(128, 4)
        at = 736 + root_size + 32 * (len(roots) + 1)  # and one empty tile
        sizes = [{5: 8256, 4: 1088}[log2] + (stride << 3 * log2) for log2 in (5, 4)]
        upper_at = {place: at + n * sizes[0] for n, place in enumerate(roots)}
        lower_at = {place: at + len(roots) * sizes[0] + n * sizes[1] for n, place in enumerate(lowers)}
        leaf_at, leaves = {}, b""
        end = at + len(roots) * sizes[0] + len(lowers) * sizes[1]
        for number, (place, (values, active)) in enumerate(self.leaves.items()):
            leaf_at[place] = end + len(leaves)
            leaves += self.leaf(values, active, number)
        low, high = self.box()
        root = bytearray(struct.pack("<6iI", *low, *high, len(roots) + 1).ljust(root_size, b"\0"))
        root[background : background + 4] = np.array([self.background, 0], self.dtype).tobytes()[:4]
        for place in [(8192, -4096, 0), *roots]:
            key = sum((n >> 12 & (1 << 20) - 1) << shift for n, shift in zip(place, (42, 21, 0), strict=True))
            root += struct.pack("<Qq", key, upper_at.get(place, 736) - 736).ljust(32, b"\0")
        nodes = b"".join(self.node(place, 5, lower_at, upper_at[place]) for place in roots)
        nodes += b"".join(self.node(place, 4, leaf_at, lower_at[place]) for place in lowers)
        total = 736 + len(root) + len(nodes) + len(leaves)
        head = struct.pack("<8sQ2I2IQ256s", b"NanoVDB1", 0, version, 0, 0, 1, total, self.name.encode())
        head = head.ljust(384, b"\0") + self.matrix[:3, :3].astype("<f8").tobytes() + bytes(72)
        head += self.matrix[:3, 3].astype("<f8").tobytes()
        head = head.ljust(632, b"\0") + struct.pack("<2I", self.grid_class, kind)
        tree = struct.pack("<4Q6IQ", 0, 0, 0, 64, len(self.leaves), len(lowers), len(roots), 0, 0, 0, self.voxels())
        return head.ljust(672, b"\0") + tree + bytes(root) + nodes + leaves


def encode_nanovdb(*grids: NanoVdbGrid, codec: int = 0, magic: bytes = b"NanoVDB2", version: int = 32 << 21) -> bytes:
    """One segment."""
    head, body = struct.pack("<8sI2H", magic, version, len(grids), codec), b""
    for grid in grids:
        data = grid.encode()
        packed = [data, zlib.compress(data), blosc.compress(data, typesize=4, cname="lz4")][codec]
        packed = (struct.pack("<Q", len(packed)) if codec else b"") + packed
        low, high = grid.box()
        sizes = struct.pack("<4Q2I", len(data), len(packed), 0, grid.voxels(), NANOVDB[grid.type][0], grid.grid_class)
        head += sizes + struct.pack("<6d6i3d", *[0.0] * 6, *low, *high, *[1.0] * 3)
        head += struct.pack("<I7I2HI", len(grid.name) + 1, *[0] * 7, codec, 0, version) + grid.name.encode() + b"\0"
        body += packed
    return head + body


@pytest.fixture(scope="session")
def nanovdb_grid() -> type[NanoVdbGrid]:
    return NanoVdbGrid


@pytest.fixture(scope="session")
def nanovdb_file() -> Callable[..., bytes]:
    return encode_nanovdb
