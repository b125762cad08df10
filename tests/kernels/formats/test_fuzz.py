"""Mutated files: whatever the bytes are, the answer is a Grid or one VolumeError, soon, and in bounded memory."""

from __future__ import annotations

import bz2
import gzip
import io
import random
import struct
import time
import tracemalloc
from pathlib import Path
from typing import Any

import nibabel
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
    """Whether it is still a volume, which then makes sense in itself."""
    path.unlink(missing_ok=True)  # a file that is mapped must not be cut short
    path.write_bytes(data)
    start = time.perf_counter()
    readable = True
    for read in (read_grid, list_grids):
        message, found = f"{path}: ", None
        try:
            found = read(path)
        except VolumeError as error:
            message, readable = str(error), False
        assert message.startswith(f"{path}: ")
        assert message.removeprefix(str(path)).isprintable()
        assert len(message) < 2000
        if isinstance(found, Grid):
            make_sense(found)
        elif isinstance(found, tuple):
            assert all(info.voxels >= 0 and min(info.shape) >= 0 for info in found)
    assert time.perf_counter() - start < SECONDS
    return readable


def make_sense(found: Grid) -> None:
    values = found.values
    assert values.dtype in (np.float32, np.float16, np.uint8)
    assert values.dtype.isnative
    assert values.flags.c_contiguous
    assert min(values.shape) > 0
    assert np.prod(values.shape[:3]) <= LIMIT
    assert values.ndim == 3 or (values.ndim == 4 and values.shape[3] == 3)
    assert np.isfinite(found.index_to_world).all()
    assert np.array_equal(found.index_to_world[3], (0, 0, 0, 1))
    assert np.linalg.det(found.index_to_world[:3, :3]) != 0


def fuzz(originals: list[bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str = "volume") -> None:
    monkeypatch.setattr(grid, "MAX_VOXELS", LIMIT)
    rng = random.Random(1965)
    assert all(survive(data, tmp_path / name) for data in originals)
    tracemalloc.start()
    readable = sum(survive(mutate(rng.choice(originals), rng), tmp_path / name) for _ in range(MUTATIONS))
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


def test_npz(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    originals = []
    for save in (np.savez, np.savez_compressed):
        file = io.BytesIO()
        save(file, density=np.arange(60, dtype="f4").reshape(3, 4, 5), heat=np.ones((3, 4, 5, 3), "u1"), size=0.5)
        originals.append(file.getvalue())
    fuzz(originals, tmp_path, monkeypatch)


def test_nanovdb(nanovdb_grid: Any, nanovdb_file: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    random_values = np.random.default_rng(1)
    leaves = {at: (random_values.random((512, 1)), random_values.random(512) < 0.5) for at in [(0, 0, 0), (8, 8, -8)]}
    tiles = {((16, 0, 0), 4): (0.5, True)}
    grids = [nanovdb_grid(kind, leaves, tiles) for kind in ("float", "half", "fp8", "fpN")]
    grids[2].name = "heat"
    bare = grids[0].encode()
    originals = [nanovdb_file(grids[0]), nanovdb_file(*grids[1:3], codec=1), nanovdb_file(grids[3], codec=2), bare]
    fuzz(originals, tmp_path, monkeypatch)


def test_nanovdb_trees(nanovdb_grid: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Mutations of nothing but what the tree is made of, of which a file of mostly zeros has little."""
    monkeypatch.setattr(grid, "MAX_VOXELS", LIMIT)
    rng = random.Random(1965)
    leaves = {at: (np.ones((512, 1)), np.ones(512, bool)) for at in [(0, 0, 0), (8, 8, -8)]}
    data = nanovdb_grid("fpN", leaves).encode()
    filled = np.flatnonzero(np.frombuffer(data, np.uint8)).tolist()
    tracemalloc.start()
    for _ in range(MUTATIONS):
        mutant = bytearray(data)
        at = max(0, rng.choice(filled) - rng.randrange(16))
        mutant[at : at + 8] = rng.choice([rng.randbytes(8), bytes(8), mutant[at + 8 : at + 16], b"\xff" * 8])
        survive(bytes(mutant), tmp_path / "volume")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 16 * LIMIT


def test_vol(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    head = [struct.pack("<3sB5i6f", b"VOL", 3, kind, 5, 4, 3, kind, 0, 0, 0, 1, 2, 3) for kind in (1, 3)]
    fuzz([head[0] + np.ones(60, "<f4").tobytes(), head[1] + bytes(180)], tmp_path, monkeypatch)


def test_nrrd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    head = "NRRD0005\ntype: {}\ndimension: {}\nsizes: {}\nencoding: {}\nendian: big\n{}\n\n"
    space = (
        "space: left-posterior-superior\nspace directions: {}(1,0,0.5) (0,-2,0) (0,0,3)\nspace origin: (1,2e-1,-3.5)"
    )
    values = np.arange(180, dtype=">f4").tobytes()
    originals = [
        head.format("float", 3, "5 4 9", "raw", space.format("")).encode() + values,
        head.format("float", 4, "3 5 4 3", "gzip", space.format("none ")).encode() + gzip.compress(values),
        head.format("uint16", 3, "5 8 9", "bzip2", "line skip: 1\nspacings: 1 2 3").encode()
        + b"\n"
        + bz2.compress(values),
        head.format("short", 3, "5 8 9", "raw", "byte skip: -1\nkinds: domain domain domain").encode() + values,
    ]
    fuzz(originals, tmp_path, monkeypatch)


def test_nifti(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    originals = []
    for version, image in enumerate((nibabel.Nifti1Image, nibabel.Nifti2Image)):
        made = image(np.arange(60, dtype="f4").reshape(5, 4, 3), np.diag((1, 2, 3, 1)))
        made.set_qform(np.diag((1, -2, 3, 1)), code=1)
        made.set_sform(None if version else made.affine, code=0 if version else 1)
        originals += [made.to_bytes(), gzip.compress(made.to_bytes(), mtime=0)]
    scaled = nibabel.Nifti1Image(np.ones((5, 4, 3, 1, 3), "u2"), np.eye(4))
    scaled.header.set_slope_inter(2, 1)
    fuzz([*originals, scaled.to_bytes()], tmp_path, monkeypatch)


def test_raw(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fuzz([bytes(120), bytes(range(120))], tmp_path, monkeypatch, "cloud_5x4x3_float16.raw")


def test_names_of_raw_files(tmp_path: Path) -> None:
    rng = random.Random(1965)
    for _ in range(MUTATIONS):
        name = mutate(b"cloud_5x4x3_float16_be.raw", rng).decode("latin-1").replace("/", "_").replace("\0", "0")[:200]
        if name.strip("."):
            survive(bytes(rng.choice([0, 60, 120])), tmp_path / name)
