"""The NRRD reader on files that pynrrd wrote, and on headers it would not write."""

from __future__ import annotations

import bz2
import gzip
from pathlib import Path
from typing import Any

import nrrd
import numpy as np
import pytest

from woodcock.formats import GridInfo, VolumeError, list_grids, read_grid

TYPES = ["u1", "i1", "<i2", "<u2", ">u2", "<i4", ">u4", "<i8", "<u8", "<f4", ">f4", "<f8", ">f8"]
DIRECTIONS = np.array([[0, 1.5, 0.2], [-2, 0, 0], [0.1, 0, 4]])


def ramp(dtype: str = "<f4", shape: tuple[int, ...] = (5, 4, 3)) -> Any:
    return (np.arange(np.prod(shape)).reshape(shape) * 2).astype(dtype)


def placed(**fields: Any) -> dict[str, Any]:
    space = {"space": "left-posterior-superior", "space directions": DIRECTIONS, "space origin": np.array([7, -3, 11])}
    return {**space, **fields}


@pytest.mark.parametrize("encoding", ["raw", "gzip", "bzip2"])
@pytest.mark.parametrize("dtype", TYPES)
def test_every_type_and_encoding(dtype: str, encoding: str, tmp_path: Path) -> None:
    data = ramp(dtype)
    for suffix in (".nrrd", ".nhdr"):
        path = tmp_path / f"volume{suffix}"
        nrrd.write(str(path), data, placed(encoding=encoding), detached_header=suffix == ".nhdr")
        grid = read_grid(path)
        assert grid.values.dtype == (np.uint8 if dtype == "u1" else np.float32)
        assert grid.values.dtype.isnative
        assert grid.values.flags.c_contiguous
        assert np.array_equal(grid.values, data.T)
        assert grid.placed
        assert np.allclose(grid.index_to_world @ (0.5, 0.5, 0.5, 1), (7, -3, 11, 1))
        assert np.allclose(grid.index_to_world[:3, :3], DIRECTIONS.T)
        assert list_grids(path) == (GridInfo("density", data.dtype.name, (5, 4, 3), 60),)


@pytest.mark.parametrize("axis", [0, 3])
def test_vectors(axis: int, tmp_path: Path) -> None:
    path = tmp_path / "volume.nrrd"
    data = ramp("<f4", (3, 5, 4, 2) if axis == 0 else (5, 4, 2, 3))
    directions = np.insert(DIRECTIONS, axis, np.nan, axis=0)
    kinds = ["domain"] * 3
    kinds.insert(axis, "vector")
    for fields in ({"kinds": kinds}, {"space directions": directions, "space": "right-anterior-superior"}):
        nrrd.write(str(path), data, fields)
        expected = data.transpose(3, 2, 1, 0) if axis == 0 else data.transpose(2, 1, 0, 3)
        assert np.array_equal(read_grid(path).values, expected)
        assert list_grids(path) == (GridInfo("density", "float32[3]", (5, 4, 2), 40),)
    assert np.allclose(read_grid(path).index_to_world[:3, :3], DIRECTIONS.T)


def header(*lines: str, version: int = 4) -> bytes:
    fields = ["type: float", "dimension: 3", "sizes: 5 4 3", "encoding: raw", "endian: little"]
    names = {line.split(":")[0] for line in lines}
    kept = [field for field in fields if field.split(":")[0] not in names]
    return "\n".join([f"NRRD000{version}", "# a comment: of no meaning", *kept, *lines, "key:=value", "", ""]).encode()


VALUES = ramp().tobytes("F")


def test_spacings_give_size_alone_and_without_them_the_unit_cube_is_filled(tmp_path: Path) -> None:
    path = tmp_path / "volume"
    path.write_bytes(header("spacings: 0.5 2 3") + VALUES)
    assert np.array_equal(read_grid(path).index_to_world, np.diag((0.5, 2, 3, 1)))
    assert read_grid(path).placed
    for lines in ((), ("spacings: nan nan nan",), ("spacings: 1",)):
        path.write_bytes(header(*lines) + VALUES)
        assert np.allclose(read_grid(path).index_to_world @ (5, 4, 3, 1), 1)
        assert not read_grid(path).placed


def test_skips_and_detached_values(tmp_path: Path) -> None:
    path = tmp_path / "volume.nhdr"
    other = tmp_path / "values.bin"
    for lines, data in {
        ("line skip: 2",): b"one\ntwo\n" + VALUES,
        ("byte skip: 3",): b"abc" + VALUES,
        ("byteskip: -1",): b"anything\n\nat all" + VALUES,
        ("lineskip: 1", "byte skip: 3", "encoding: gz"): b"one\n" + gzip.compress(b"abc" + VALUES),
        ("byte skip: 3", "encoding: bz2"): bz2.compress(b"a") + bz2.compress(b"bc" + VALUES),
        ("encoding: GZIP",): gzip.compress(VALUES[:7]) + gzip.compress(VALUES[7:]),
        ("TYPE: Float", "Endian: LITTLE", "content: a\r"): VALUES + b"and more",
    }.items():
        path.write_bytes(header(*lines) + data)
        assert np.array_equal(read_grid(path).values, ramp().T), lines
        path.write_bytes(header(*lines, "data file: values.bin"))
        other.write_bytes(data)
        assert np.array_equal(read_grid(path).values, ramp().T), lines
    path.write_bytes(header("datafile: values.bin").rstrip())  # no empty line is due
    other.write_bytes(VALUES)
    assert np.array_equal(read_grid(path).values, ramp().T)


def test_hostile_headers(tmp_path: Path) -> None:
    path = tmp_path / "volume"
    (tmp_path / "values").mkdir()
    space = "space dimension: 3"
    cases = {
        'is encoded as "ascii"; raw, gzip': header("encoding: ascii") + VALUES,
        'holds values of type "block"': header("type: block") + VALUES,
        "must say whether it is endian": header("endian: middle") + VALUES,
        "must have three axes": header("dimension: 2", "sizes: 5 4") + VALUES,
        " must have three axes": header("sizes: 5 0 3") + VALUES,
        'says it has "3" dimensions, and has 2 sizes': header("sizes: 5 4") + VALUES,
        "has no sizes that can be read": header("sizes: 5 4 x") + VALUES,
        " has no sizes that can be read": header("sizes: " + "9" * 5000) + VALUES,
        "4 values a voxel, along axis 0": header("dimension: 4", "sizes: 4 2 2 2") + VALUES,
        "has four axes, of which one alone": header("dimension: 4", "sizes: 2 2 2 2", "kinds: list list list list")
        + VALUES,
        "more than the 8589934592": header("sizes: 99999 99999 99999") + VALUES,
        "its header announces 240 bytes of values, 239 follow": header() + VALUES[:-1],
        "its header announces 240 bytes of values, 231 follow": header("byte skip: 9") + VALUES,
        "which cannot be right": header("byte skip: -2") + VALUES,
        " which cannot be right": header("line skip: -1") + VALUES,
        "does not have the 9999 lines": header("line skip: 9999") + VALUES,
        "must have three space directions": header(space, "space directions: (1,0,0) (0,1,0)") + VALUES,
        " must have three space directions": header(space, "space directions: (1,0,0) (0,1,0) (a,b,c)") + VALUES,
        "map that can be inverted": header(space, "space directions: (1,0,0) (0,1,0) (0,2,0)") + VALUES,
        " map that can be inverted": header("space directions: (1,0,0) (0,1,0) (0,0,1)", "space origin: (1,2)")
        + VALUES,
        'in "../x"; it must be one file of the same folder': header("data file: ../x"),
        'in "/etc/passwd"; it must be': header("data file: /etc/passwd"),
        'in ".."; it must be': header("data file: .."),
        'in "values", which cannot be read': header("data file: values"),
        'in "absent", which cannot be read': header("data file: absent"),
        'in "LIST"': header("data file: LIST") + b"a.raw\nb.raw\n",
        "no empty line within 1048576 bytes": header().rstrip() + b"#" * (1 << 21),
        "cannot hold 400000000": header("sizes: 1000 1000 100", "encoding: gzip") + gzip.compress(VALUES),
        "holds 240 bytes where 480 are due": header("sizes: 5 4 6", "encoding: bzip2") + bz2.compress(VALUES),
        "stream cannot be unpacked": header("encoding: gzip") + VALUES,
        " stream cannot be unpacked": header("encoding: bzip2") + VALUES,
    }
    for message, data in cases.items():
        path.write_bytes(data)
        with pytest.raises(VolumeError) as caught:
            read_grid(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert message.strip() in str(caught.value), (message, str(caught.value))
