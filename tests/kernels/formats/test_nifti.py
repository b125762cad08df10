"""The NIfTI reader on files that nibabel wrote."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path
from typing import Any

import nibabel
import numpy as np
import pytest

from woodcock.formats import GridInfo, VolumeError, list_grids, read_grid

SHARED = Path(__file__).parents[3].parent / "shared" / "data"
TYPES = ["u1", "i1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]
AFFINE = np.array([[0, -2, 0.1, 7], [1.5, 0, 0, -3], [0.2, 0, 4, 11], [0, 0, 0, 1.0]])
KINDS = {1: nibabel.Nifti1Image, 2: nibabel.Nifti2Image}


def ramp(dtype: str, shape: tuple[int, ...] = (5, 4, 3)) -> Any:
    return (np.arange(np.prod(shape)).reshape(shape) * 2 - (50 if "u" not in dtype else 0)).astype(dtype)


def save(path: Path, data: Any, version: int = 1, affine: Any = AFFINE, order: str = "<", **fields: Any) -> None:
    header = KINDS[version].header_class(endianness=order)
    header.set_data_dtype(data.dtype)
    image = KINDS[version](data, affine, header)
    for name, value in fields.items():
        image.header[name] = value
    image.to_filename(path)


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("dtype", TYPES)
def test_every_type(dtype: str, version: int, tmp_path: Path) -> None:
    data = ramp(dtype)
    for suffix in (".nii", ".nii.gz"):
        for order in "<>":
            save(tmp_path / f"a{suffix}", data, version, order=order)
            path = (tmp_path / f"a{suffix}").rename(tmp_path / "volume")  # the suffix does not matter
            grid = read_grid(path)
            assert grid.values.dtype == (np.uint8 if dtype == "u1" else np.float32)
            assert grid.values.dtype.isnative
            assert grid.values.flags.c_contiguous
            assert np.array_equal(grid.values, data.T)
            assert grid.placed
            assert np.allclose(grid.index_to_world @ (1.5, 2.5, 0.5, 1), AFFINE @ (1, 2, 0, 1), atol=1e-5)
            assert list_grids(path) == (GridInfo("density", data.dtype.name, (5, 4, 3), 60),)


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("handedness", [1, -1])
def test_places_as_nibabel_does(version: int, handedness: int, tmp_path: Path) -> None:
    angles = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    rotation = angles * np.sign(np.linalg.det(angles)) * (1, 1, handedness)
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = rotation * (0.5, 2, 3), (4, -5, 6)
    path = tmp_path / "volume.nii"
    image = KINDS[version](ramp("i2"), affine)
    image.set_qform(affine, code=1)
    for code in (0, 2):
        image.set_sform(AFFINE, code=code)
        image.to_filename(path)
        to_world = nibabel.load(path).affine
        assert np.allclose(to_world, AFFINE if code else affine, atol=1e-5)
        assert np.allclose(read_grid(path).index_to_world @ (3.5, 1.5, 2.5, 1), to_world @ (3, 1, 2, 1), atol=1e-4)


def test_without_a_form_voxels_have_their_size_alone(tmp_path: Path) -> None:
    path = tmp_path / "volume.nii"
    image = nibabel.Nifti1Image(ramp("i2"), None)
    image.header["pixdim"][1:4] = 0.5, 2, 3
    image.to_filename(path)
    grid = read_grid(path)
    assert grid.placed
    assert np.allclose(grid.index_to_world @ (1.5, 1.5, 1.5, 1), (0.5, 2, 3, 1))
    image.header["pixdim"][1:4], image.header["vox_offset"] = (0, 2, 3), 352
    path.write_bytes(image.header.binaryblock + bytes(4) + ramp("i2").tobytes("F"))
    unplaced = read_grid(path)
    assert not unplaced.placed
    assert np.allclose(unplaced.index_to_world @ (5, 4, 3, 1), 1)


@pytest.mark.parametrize("suffix", [".nii", ".nii.gz"])
def test_scaled_values_and_vectors(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"volume{suffix}"
    image = nibabel.Nifti1Image(ramp("u2"), AFFINE)
    image.header.set_slope_inter(0.25, -3)
    image.to_filename(path)
    assert np.array_equal(read_grid(path).values, nibabel.load(path).get_fdata().T)
    assert np.array_equal(read_grid(path).values, ramp("u2").T * 0.25 - 3)

    vectors = ramp("f4", (5, 4, 3, 1, 3))
    save(path, vectors)
    assert np.array_equal(read_grid(path).values, vectors[:, :, :, 0].transpose(2, 1, 0, 3))
    assert list_grids(path) == (GridInfo("density", "float32[3]", (5, 4, 3), 60),)


@pytest.mark.parametrize("shape", [(7,), (7, 2), (7, 2, 1), (7, 2, 1, 1)])
def test_few_dimensions(shape: tuple[int, ...], tmp_path: Path) -> None:
    save(tmp_path / "volume.nii", ramp("f4", shape))
    assert read_grid(tmp_path / "volume.nii").values.shape == (1, 2 if len(shape) > 1 else 1, 7)


@pytest.mark.parametrize("name", ["bonsai", "heptane"])
def test_reads_shared_data_as_nibabel_does(name: str) -> None:
    path = SHARED / f"{name}.nii.gz"
    if not path.exists():
        pytest.skip(f"the shared data is not there: {SHARED}")
    image, grid = nibabel.load(path), read_grid(path)
    assert np.array_equal(grid.values, np.asarray(image.dataobj).T)
    assert np.allclose(grid.index_to_world @ (0.5, 0.5, 0.5, 1), image.affine @ (0, 0, 0, 1))


def test_what_is_no_volume_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "volume.nii"
    save(path, ramp("f4"))
    good = path.read_bytes()
    save(path, ramp("f4", (5, 4, 3, 2)))
    times = path.read_bytes()
    save(path, ramp("f4").astype("c8"))
    complexes = path.read_bytes()

    def patched(at: int, new: bytes) -> bytes:
        return good[:at] + new + good[at + len(new) :]

    cases = {
        "holds 5 × 4 × 3 × 2 values; it must be one volume": times,
        "holds values of the NIfTI type 32": complexes,
        "has its values in another file (.img)": patched(344, b"ni1\0"),
        "is cut short: its header announces 240 bytes": good[:-1],
        "is said to have 9 dimensions": patched(40, struct.pack("<h", 9)),
        "values; it must be one volume (of one time), not empty": patched(42, struct.pack("<h", 0)),
        "holds 32767 × 32767 × 32767 voxels, more than": patched(42, struct.pack("<3h", *[32767] * 3)),
        "said to begin at byte 1e+20": patched(108, struct.pack("<f", 1e20)),
        " said to begin at byte nan": patched(108, struct.pack("<f", np.nan)),
        "is no affine map that can be inverted": patched(280, bytes(48)),
        "that its scale makes too large": patched(112, struct.pack("<2f", 3e38, 0)),
        "is no volume that can be read": good[:340],
        "packed bytes cannot hold": gzip.compress(patched(42, struct.pack("<3h", 512, 512, 512))),
        "gzip stream holds 352 bytes where 592 are due": gzip.compress(good[:352]),
        "gzip stream cannot be unpacked": gzip.compress(good)[:-8] + bytes(8),
    }
    for message, data in cases.items():
        path.write_bytes(data)
        with pytest.raises(VolumeError) as caught:
            read_grid(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert message.strip() in str(caught.value), message
