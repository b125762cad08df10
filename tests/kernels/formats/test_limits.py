"""What a file announces is held against memory before any of it is taken: no small file becomes a large array."""

from __future__ import annotations

import gzip
import io
import struct
import time
import tracemalloc
import zlib
from pathlib import Path
from typing import Any

import nibabel
import numpy as np
import pytest

from woodcock.formats import VolumeError, grid, list_grids, read_grid
from woodcock.formats.packed import unpack

MEMORY = 600  # bytes: 64 floats are less, 64 vectors or doubles are not all
VECTORS = np.ones((4, 4, 4, 3), "<f4")


@pytest.fixture
def little(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine of next to no memory."""
    monkeypatch.setattr(grid, "memory", lambda: MEMORY)


def nrrd(kind: str, sizes: str, encoding: str, values: bytes) -> bytes:
    head = (
        f"NRRD0004\ntype: {kind}\ndimension: {len(sizes.split())}\nsizes: {sizes}\nencoding: {encoding}\nendian: little"
    )
    return f"{head}\n\n".encode() + values


def saved(plain: bool = False, **arrays: Any) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **arrays) if plain else np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def both(path: Path, data: bytes) -> list[str]:
    """What is said when it is listed and when it is read; `read` for nothing."""
    path.unlink(missing_ok=True)
    path.write_bytes(data)
    said = []
    for read in (list_grids, read_grid):
        try:
            read(path)
            said.append("read")
        except VolumeError as error:
            said.append(str(error).removeprefix(f"{path}: "))
    return said


@pytest.mark.usefixtures("little")
def test_vectors_are_counted(tmp_path: Path) -> None:
    values = VECTORS.tobytes()
    plain = io.BytesIO()
    np.save(plain, VECTORS)
    files = {
        "npy": plain.getvalue(),
        "npz": saved(plain=True, density=VECTORS),
        "nrrd": nrrd("float", "3 4 4 4", "raw", values),
        "nifti": nibabel.Nifti1Image(VECTORS[:, :, :, None], np.eye(4)).to_bytes(),
        "vol": struct.pack("<3sB5i6f", b"VOL", 3, 1, 4, 4, 4, 3, 0, 0, 0, 1, 1, 1) + values,
    }
    for name, data in files.items():
        for said in both(tmp_path / "volume", data):
            assert "4 × 4 × 4 voxels, more than the 0 MiB of this machine's memory hold" in said, name
    assert both(tmp_path / "volume", nrrd("float", "4 4 4", "raw", values[:256])) == ["read"] * 2


@pytest.mark.usefixtures("little")
def test_what_is_packed_is_counted_unpacked(tmp_path: Path) -> None:
    """As doubles it is more than as the floats that it becomes."""
    doubles = np.ones((4, 4, 5), "<f8")
    files = [
        nrrd("double", "5 4 4", "gzip", gzip.compress(doubles.tobytes())),
        gzip.compress(nibabel.Nifti1Image(doubles.astype("f4"), np.eye(4)).to_bytes()),  # and the header
        saved(density=doubles),
    ]
    for data in files:
        for said in both(tmp_path / "volume", data):
            assert " bytes, more than the 0 MiB of this machine's memory hold" in said
            assert "unpacks to" in said


def test_leaves_are_counted(vdb_grid: Any, vdb_file: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of each one voxel is active, and 512 are kept."""
    one, last = np.arange(512) == 0, np.arange(512) == 511
    data = vdb_file(vdb_grid({(0, 0, 0): (np.ones((512, 1)), last), (8, 8, 8): (np.ones((512, 1)), one)}))
    assert both(tmp_path / "volume", data) == ["read"] * 2
    monkeypatch.setattr(grid, "memory", lambda: 4095)
    listed, read = both(tmp_path / "volume", data)
    assert listed == "read"
    assert (
        read
        == 'grid "density" has 2 leaf nodes, which take 4096 bytes, more than the 0 MiB of this machine\'s memory hold'
    )


def test_a_long_name_takes_no_more_than_itself(nanovdb_grid: Any, nanovdb_file: Any, tmp_path: Path) -> None:
    made = nanovdb_grid("float", {(0, 0, 0): (np.ones((512, 1)), np.ones(512, bool))}, name="a" + "\0" * (1 << 22))
    (tmp_path / "volume").write_bytes(nanovdb_file(made))
    tracemalloc.start()
    assert list_grids(tmp_path / "volume")[0].name == "a"
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 4 << 22


def test_many_small_members_are_unpacked_in_time() -> None:
    """The rest of a chunk is copied for each member that begins in it."""
    packer = zlib.compressobj(wbits=31)
    member = packer.compress(b"x") + packer.flush()
    count = 50_000
    began = time.process_time()
    assert unpack(member * count, 0, len(member) * count, count, "gzip") == b"x" * count
    assert time.process_time() - began < 2
