"""An encoder of OpenVDB files that can write what the library can read but will not write, and the library itself."""

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
