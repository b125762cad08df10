"""Mutated files: whatever the bytes are, the answer is a Grid or one VolumeError, soon, and in bounded memory."""

from __future__ import annotations

import io
import random
import time
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.formats import Grid, VolumeError, grid, list_grids, read_grid

MUTATIONS = 1000
SECONDS = 2.0  # for one file; the longest takes a few hundredths
LIMIT = 1 << 20  # voxels


def mutate(data: bytes, rng: random.Random) -> bytes:
    mutant = bytearray(data)
    # Where the descriptors and headers are, a mutation does more than among the values.
    at = rng.randrange(min(len(data), 600)) if rng.random() < 0.6 else rng.randrange(len(data))
    match rng.randrange(5):
        case 0:
            mutant[at] ^= 1 << rng.randrange(8)
        case 1:
            del mutant[at:]
        case 2:
            mutant[at:at] = rng.randbytes(rng.choice([1, 8, 100]))
        case 3:
            number = rng.choice([0, 1, 255, 1 << 15, (1 << 31) - 1, 1 << 31, (1 << 32) - 1])
            mutant[at : at + 4] = number.to_bytes(4, "little")
        case _:
            mutant[at : at + 16] = rng.randbytes(16)
    return bytes(mutant)


def survive(data: bytes, path: Path) -> bool:
    """Whether it is still a volume."""
    path.write_bytes(data)
    start = time.perf_counter()
    readable = True
    for read in (read_grid, list_grids):
        try:
            found: object = read(path)
        except VolumeError as error:
            found, readable = str(error).startswith(f"{path}: "), False
        assert isinstance(found, Grid | tuple) or found is True
    assert time.perf_counter() - start < SECONDS
    return readable


def fuzz(originals: list[bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grid, "MAX_VOXELS", LIMIT)
    rng = random.Random(1965)
    assert all(survive(data, tmp_path / "original") for data in originals)
    tracemalloc.start()
    readable = sum(survive(mutate(rng.choice(originals), rng), tmp_path / "mutant") for _ in range(MUTATIONS))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 16 * LIMIT
    assert 0 < readable < MUTATIONS


def test_vdb(vdb_grid: Any, vdb_file: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    random_values = np.random.default_rng(1)
    leaves = {}
    for origin in [(0, 0, 0), (8, 8, 0), (-8, 0, 16)]:
        active = random_values.random(512) < 0.5
        values = random_values.normal(size=(512, 1))
        values[~active] = random_values.choice([0, 3.0], (512, 1))[~active]
        leaves[origin] = values, active
    tiles = {((16, 0, 0), 4): (0.5, True)}
    entries = {"class": ("string", b"fog volume"), "file_bbox_min": ("vec3i", bytes(12))}
    originals = [
        vdb_file(*(vdb_grid(leaves, tiles, name, flags, half, metadata=entries) for name in ("density", "heat")))
        for flags, half in [(0, False), (3, True), (6, False), (7, True)]
    ]
    fuzz(originals, tmp_path, monkeypatch)


def test_npy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    originals = []
    for array in (np.ones((3, 4, 5), "f4"), np.ones((2, 3, 4, 3), "f8"), np.ones((4, 3, 2), "u1", order="F")):
        file = io.BytesIO()
        np.save(file, array)
        originals.append(file.getvalue())
    fuzz(originals, tmp_path, monkeypatch)
