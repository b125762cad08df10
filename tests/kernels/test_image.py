"""EXR layers and header come back as they went out; previews show what there is to see."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from woodcock.film import Film
from woodcock.image import ImageError, read_exr, tone_map, write_exr, write_preview


def film(channels: int) -> Film:
    random = np.random.default_rng(3)
    mean = random.lognormal(0, 4, (6, 9, channels))
    return Film(np.full((6, 9), 70000, np.uint32), mean, mean**2, ((0, 70000),))


@pytest.mark.parametrize(("channels", "beauty"), [(1, ["Y"]), (3, ["R", "G", "B"])])
def test_exr_round_trip(tmp_path: Path, channels: int, beauty: list[str]) -> None:
    path = tmp_path / "out.exr"
    header = {"scene": '{"a": "ω"}', "seed": "4294967295"}
    write_exr(path, film(channels), header)
    layers, read = read_exr(path)
    assert set(layers) == {*beauty, *(f"variance.{name}" for name in beauty), "samples.count"}
    for index, name in enumerate(beauty):
        assert np.array_equal(layers[name], film(channels).mean[..., index].astype(np.float32))
        assert np.array_equal(layers[f"variance.{name}"], film(channels).variance()[..., index].astype(np.float32))
    assert np.array_equal(layers["samples.count"], np.full((6, 9), 70000))
    assert read == header
    assert [file.name for file in tmp_path.iterdir()] == ["out.exr"]


@pytest.mark.parametrize("kept", [0, 100, 500])
def test_a_torn_exr_is_an_image_error(tmp_path: Path, kept: int) -> None:
    path = tmp_path / "out.exr"
    write_exr(path, film(3), {})
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(ImageError, match=r"out.exr"):
        read_exr(path)


def test_a_variance_beyond_float32_is_infinite(tmp_path: Path) -> None:
    huge = np.full((2, 2, 1), 1e30)
    write_exr(tmp_path / "out.exr", Film(np.full((2, 2), 4, np.uint32), huge, huge**2, ((0, 4),)), {})
    layers, _ = read_exr(tmp_path / "out.exr")
    assert np.isinf(layers["variance.Y"]).all()
    assert np.array_equal(layers["Y"], np.full((2, 2), np.float32(1e30)))


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        write_exr(tmp_path / "none" / "out.exr", film(1), {})


def test_preview(tmp_path: Path) -> None:
    ramp = np.linspace(0, 40, 300).reshape(1, 300, 1).repeat(200, 0)
    write_preview(tmp_path / "p.png", Film(np.ones((200, 300), np.uint32), ramp, ramp), size=150)
    layers, _ = read_exr(tmp_path / "p.png")
    assert layers["R"].shape == (100, 150)
    assert np.array_equal(layers["R"], layers["G"])
    assert (np.diff(layers["R"][50]) >= -1 / 255).all()
    assert layers["R"][50, 0] < 0.1
    assert layers["R"][50, -1] > 0.95


def test_tone_map_survives_anything() -> None:
    values = np.array([[[np.nan], [np.inf], [-1.0], [1e30], [0.0], [1.0]]])
    mapped = tone_map(values)
    assert mapped.shape == (1, 6, 3)
    assert ((mapped >= 0) & (mapped <= 1)).all()
    assert (tone_map(np.zeros((2, 2, 1))) == 0).all()
