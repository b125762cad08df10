"""What all readers have in common."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import nibabel
import numpy as np
import pytest

from woodcock.formats import VolumeError, list_grids, read_grid

VALUES = np.arange(60, dtype="<f4").reshape(3, 4, 5)


def saved(save: Callable[..., Any]) -> bytes:
    file = io.BytesIO()
    save(file, VALUES)
    return file.getvalue()


def files(nanovdb_grid: Any, nanovdb_file: Any) -> dict[str, bytes]:
    """By names that say nothing, but for raw values."""
    nrrd = b"NRRD0004\ntype: float\ndimension: 3\nsizes: 5 4 3\nencoding: raw\nendian: little\n\n"
    leaf = np.zeros((8, 8, 8))
    leaf[:5, :4, :3] = VALUES.T
    return {
        "npy": saved(np.save),
        "npz": saved(np.savez),
        "vol": struct.pack("<3sB5i6f", b"VOL", 3, 1, 5, 4, 3, 1, 0, 0, 0, 1, 1, 1) + VALUES.tobytes(),
        "nrrd": nrrd + VALUES.tobytes(),
        "nii": nibabel.Nifti1Image(VALUES.T, np.eye(4)).to_bytes(),
        "nvdb": nanovdb_file(nanovdb_grid("float", {(0, 0, 0): (leaf.reshape(512, 1), leaf.reshape(512) > 0)})),
        "5x4x3_float32.raw": VALUES.tobytes(),
    }


def test_a_grid_outlives_its_file(nanovdb_grid: Any, nanovdb_file: Any, tmp_path: Path) -> None:
    """Files are mapped: a grid that still looked at one that was cut short would kill the process."""
    for name, data in files(nanovdb_grid, nanovdb_file).items():
        path = tmp_path / name
        path.write_bytes(data)
        values = read_grid(path).values
        path.write_bytes(b"")
        assert values.sum() == VALUES.sum(), name
        with pytest.raises(VolumeError, match=r"is no volume that can be read|must have 240 bytes"):
            list_grids(path)


def test_names_and_suffixes_do_not_matter(nanovdb_grid: Any, nanovdb_file: Any, tmp_path: Path) -> None:
    for name, data in files(nanovdb_grid, nanovdb_file).items():
        if name.endswith(".raw"):
            continue
        path = tmp_path / "volume.vdb"
        path.unlink(missing_ok=True)
        path.write_bytes(data)
        assert read_grid(path).values.sum() == VALUES.sum(), name
        assert list_grids(path)[0].shape == (5, 4, 3)
