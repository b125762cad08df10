"""NumPy's archives as volumes."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.formats import GridInfo, VolumeError, list_grids, read_grid

RAMP = np.arange(24, dtype=np.float32).reshape(2, 3, 4)


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_reads_what_numpy_writes(save: Any, tmp_path: Path) -> None:
    arrays = {
        "density": RAMP,
        "heat": RAMP.astype("f2"),
        "mask": RAMP > 3,
        "velocity": np.arange(72.0).reshape(2, 3, 4, 3),
        "fortran": np.asfortranarray(RAMP.astype(">i4")),
    }
    with (tmp_path / "volume").open("wb") as file:  # the suffix does not matter
        save(file, voxel_size=0.25, names=["a", "b"], **arrays)
    path = tmp_path / "volume"
    assert read_grid(path).name == "density"
    for name, array in arrays.items():
        grid = read_grid(path, name)
        assert grid.name == name
        assert np.array_equal(grid.values, array)
        assert grid.values.flags.c_contiguous
        assert grid.values.dtype == {"heat": np.float16, "mask": np.uint8}.get(name, np.float32)
        assert not grid.placed
        assert np.allclose(grid.index_to_world @ (4, 3, 2, 1), 1)
    types = ["float32", "float16", "bool", "float64[3]", "int32"]
    assert list_grids(path) == tuple(
        GridInfo(name, kind, (4, 3, 2), 24) for name, kind in zip(arrays, types, strict=True)
    )
    with pytest.raises(VolumeError, match=r'array "voxel_size" must be indexed \[z\]\[y\]\[x\]'):
        read_grid(path, "voxel_size")
    with pytest.raises(VolumeError, match=r'has no grid "smoke"; it has "density", "heat"'):
        read_grid(path, "smoke")


def test_the_only_volume_is_the_default(tmp_path: Path) -> None:
    np.savez(tmp_path / "volume.npz", RAMP, np.zeros(3))
    assert read_grid(tmp_path / "volume.npz").name == "arr_0"
    np.savez(tmp_path / "volume.npz", RAMP, RAMP)
    with pytest.raises(VolumeError, match='name one of "arr_0", "arr_1"'):
        read_grid(tmp_path / "volume.npz")


def test_zip64(tmp_path: Path) -> None:
    path = tmp_path / "volume.npz"
    np.savez(path, density=RAMP)
    data = path.read_bytes()
    end = data.rindex(b"PK\5\6")
    count, _, size, offset = struct.unpack("<2H2I", data[end + 8 : end + 20])
    end_64 = struct.pack("<4sQ2H2I4Q", b"PK\6\6", 44, 45, 45, 0, 0, count, count, size, offset)
    locator = struct.pack("<4sIQI", b"PK\6\7", 0, end, 1)
    full = struct.pack("<4s4H2IH", b"PK\5\6", 0, 0, 0xFFFF, 0xFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0)
    path.write_bytes(data[:end] + end_64 + locator + full)
    with np.load(path) as reference:
        assert np.array_equal(reference["density"], RAMP)
    assert np.array_equal(read_grid(path).values, RAMP)


def test_never_unpickles(tmp_path: Path) -> None:
    np.savez(tmp_path / "volume.npz", a=np.array([[[print]]], dtype=object), allow_pickle=True)
    with pytest.raises(VolumeError, match=r'array "a" must hold booleans, integers or floats, not "\|O"'):
        read_grid(tmp_path / "volume.npz", "a")


def test_bombs_and_damage(tmp_path: Path) -> None:
    path = tmp_path / "volume.npz"
    np.savez(path, density=RAMP)
    plain = path.read_bytes()
    np.savez_compressed(path, density=RAMP)
    packed = path.read_bytes()
    entry = packed.index(b"PK\1\2")
    local = 30 + struct.unpack_from("<H", packed, 26)[0] + struct.unpack_from("<H", packed, 28)[0]

    def archive(name: str, data: bytes, method: int = zipfile.ZIP_DEFLATED) -> bytes:
        with zipfile.ZipFile(path, "w", method) as written:
            written.writestr(name, data)
        return path.read_bytes()

    def array(shape: str, values: bytes) -> bytes:
        text = "{'descr': '<f4', 'fortran_order': False, 'shape': " + shape + "}"
        return b"\x93NUMPY\1\0" + len(text).to_bytes(2, "little") + text.encode() + values

    cases = {
        "more than the 8589934592 that are allowed": archive("a.npy", array("(4096, 4096, 4096)", b"")),
        "bytes are not those of an array of shape (2, 2, 2)": archive("a.npy", array("(2, 2, 2)", bytes(1 << 24))),
        "its checksum is wrong": plain[:200] + b"\xff" + plain[201:],
        "stream": packed[: local + 40] + bytes(20) + packed[local + 60 :],
        "is packed by method 14": archive("a.npy", array("(1, 1, 1)", bytes(4)), zipfile.ZIP_LZMA),
        "is damaged or cut short: a zip file must end": plain[:-30],
        "holds no array": archive("readme.txt", b"nothing"),
        "is no .npy array": archive("a.npy", b"nothing"),
        "where 10012 are due": packed[: entry + 24] + struct.pack("<I", 1 << 30) + packed[entry + 28 :],
        "directory of members cannot be read": packed[: entry + 2] + b"xx" + packed[entry + 4 :],
        "is damaged or cut short": packed[: entry + 42] + b"\xff\xff\xff\x7f" + packed[entry + 46 :],
    }
    for message, data in cases.items():
        path.write_bytes(data)
        with pytest.raises(VolumeError) as caught:
            read_grid(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert message in str(caught.value), (message, str(caught.value))


def test_a_directory_that_is_too_long(tmp_path: Path) -> None:
    path = tmp_path / "volume.npz"
    with zipfile.ZipFile(path, "w") as written:
        for n in range(10_001):
            written.writestr(f"{n}.npy", b"")
    with pytest.raises(VolumeError, match="has 10001 members, more than the 10000 that are allowed"):
        list_grids(path)
