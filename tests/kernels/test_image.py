"""EXR layers and header come back as they went out; previews show what there is to see."""

from __future__ import annotations

import resource
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from woodcock.film import Film
from woodcock.image import ImageError, WriteError, read_exr, tone_map, write_exr, write_preview, write_thumbnail
from woodcock.layers import beauty_names


def film(channels: int) -> Film:
    random = np.random.default_rng(3)
    mean = random.lognormal(0, 4, (6, 9, channels))
    return Film(np.full((6, 9), 70000, np.uint32), mean, mean**2, beauty_names(channels), ((0, 70000),))


def test_layers_come_back_with_the_variance_of_radiance_alone(tmp_path: Path) -> None:
    path, names = tmp_path / "out.exr", ("R", "G", "B", "order.0.R", "order.0.G", "order.0.B", "normal.X", "depth.Z")
    mean = np.random.default_rng(4).random((3, 5, len(names)))
    write_exr(path, Film(np.full((3, 5), 9, np.uint32), mean, mean, names, ((0, 9),)), {})
    layers, _ = read_exr(path)
    added = (f"{layer}.{name}" for layer in ("variance", "variance.order.0") for name in "RGB")
    assert set(layers) == {*names, *added, "samples.count"}
    for index, name in enumerate(names):
        assert np.array_equal(layers[name], mean[..., index].astype(np.float32))
    assert np.allclose(layers["variance.order.0.B"], mean[..., 5] / 72)


def test_denoised_layer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside the raw beauty, made with the guides that the film has."""
    given: dict[str, np.ndarray] = {}

    def double(beauty: np.ndarray, **guides: np.ndarray) -> np.ndarray:
        given.update(guides)
        return beauty * 2

    monkeypatch.setattr("woodcock.denoise.denoise", double)
    names = ("Y", "depth.Z", "albedo.Y", "normal.X", "normal.Y", "normal.Z")
    mean = np.random.default_rng(4).random((3, 5, len(names)))
    write_exr(tmp_path / "out.exr", Film(np.full((3, 5), 9, np.uint32), mean, mean, names), {}, denoise=True)
    layers, _ = read_exr(tmp_path / "out.exr")
    assert np.array_equal(layers["Y"], mean[..., 0].astype(np.float32))
    assert np.array_equal(layers["denoised.Y"], layers["Y"] * 2)
    assert np.array_equal(given["albedo"], mean[..., 2:3].astype(np.float32))
    assert np.array_equal(given["normal"], mean[..., 3:].astype(np.float32))


def test_a_film_without_noise_comes_with_its_bound(tmp_path: Path) -> None:
    still = replace(film(1), bound=np.full((6, 9, 1), 0.25))
    write_exr(tmp_path / "out.exr", still, {})
    layers, _ = read_exr(tmp_path / "out.exr")
    assert (layers["bound.Y"] == 0.25).all()
    assert (layers["variance.Y"] == 0).all()


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
    write_exr(tmp_path / "out.exr", Film(np.full((2, 2), 4, np.uint32), huge, huge**2, ("Y",), ((0, 4),)), {})
    layers, _ = read_exr(tmp_path / "out.exr")
    assert np.isinf(layers["variance.Y"]).all()
    assert np.array_equal(layers["Y"], np.full((2, 2), np.float32(1e30)))


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        write_exr(tmp_path / "none" / "out.exr", film(1), {})


def test_preview(tmp_path: Path) -> None:
    ramp = np.linspace(0, 40, 300).reshape(1, 300, 1).repeat(200, 0)
    write_preview(tmp_path / "p.png", Film(np.ones((200, 300), np.uint32), ramp, ramp, ("Y",)), size=150)
    write_preview(
        tmp_path / "layers.png",
        Film(np.ones((200, 300), np.uint32), np.concatenate([ramp, -ramp], -1), ramp, ("Y", "depth.Z")),
        150,
    )
    assert (tmp_path / "layers.png").read_bytes() == (tmp_path / "p.png").read_bytes()
    layers, _ = read_exr(tmp_path / "p.png")
    assert layers["R"].shape == (100, 150)
    assert np.array_equal(layers["R"], layers["G"])
    assert (np.diff(layers["R"][50]) >= -1 / 255).all()
    assert layers["R"][50, 0] < 0.1
    assert layers["R"][50, -1] > 0.95


def test_a_thumbnail_is_its_preview_in_small(tmp_path: Path) -> None:
    ramp = np.linspace(0, 1, 300).reshape(1, 300, 1).repeat(200, 0)
    coloured = np.concatenate([ramp, ramp[:, ::-1], np.full_like(ramp, 0.2)], -1)
    write_preview(tmp_path / "p.png", Film(np.ones((200, 300), np.uint32), coloured, coloured, ("R", "G", "B")))
    write_thumbnail(tmp_path / "t.webp", tmp_path / "p.png", size=60)
    content = (tmp_path / "t.webp").read_bytes()
    assert (content[:4], content[8:12]) == (b"RIFF", b"WEBP")
    preview, thumbnail = (read_exr(tmp_path / name)[0] for name in ("p.png", "t.webp"))
    assert thumbnail["R"].shape == (40, 60)
    for name in "RGB":  # what is thrown away is what the eye does not see
        means = preview[name].reshape(40, 5, 60, 5).mean((1, 3))
        assert np.abs(thumbnail[name] - means).mean() < 0.02
    write_thumbnail(tmp_path / "same.webp", tmp_path / "p.png", size=300)
    assert read_exr(tmp_path / "same.webp")[0]["R"].shape == (200, 300), "never larger"
    (tmp_path / "p.png").write_bytes(b"no picture")
    with pytest.raises(ImageError, match=r"p\.png"):
        write_thumbnail(tmp_path / "t.webp", tmp_path / "p.png", size=60)
    assert (tmp_path / "t.webp").read_bytes() == content


def test_tone_map_survives_anything() -> None:
    values = np.array([[[np.nan], [np.inf], [-1.0], [1e30], [0.0], [1.0]]])
    mapped = tone_map(values)
    assert mapped.shape == (1, 6, 3)
    assert ((mapped >= 0) & (mapped <= 1)).all()
    assert (tone_map(np.zeros((2, 2, 1))) == 0).all()


def test_previews_show_colours_as_they_are(tmp_path: Path) -> None:
    """A red pixel, a green one and a blue one, in that order."""
    write_preview(
        tmp_path / "p.png", Film(np.ones((1, 3), np.uint32), np.eye(3)[None], np.eye(3)[None], ("R", "G", "B"))
    )
    layers, _ = read_exr(tmp_path / "p.png")
    shown = np.stack([layers[name][0] for name in "RGB"])
    assert np.array_equal(shown > 0.5, np.eye(3, dtype=bool))


@pytest.mark.parametrize("lacking", [1, 100, 30000])
@pytest.mark.parametrize("name", ["p.png", "p.exr", "t.webp"])
def test_a_picture_that_finds_no_room_leaves_the_old_one(tmp_path: Path, name: str, lacking: int) -> None:
    noise = np.random.default_rng(3).random((192, 192, 3))
    film = Film(np.full((192, 192), 2, np.uint32), noise, noise, ("R", "G", "B"))
    write_preview(tmp_path / "other.png", film)
    other = (tmp_path / "other.png").read_bytes()

    def write() -> None:
        match name:
            case "p.exr":
                write_exr(tmp_path / name, film, {})
            case "p.png":
                write_preview(tmp_path / name, film)
            case _:
                write_thumbnail(tmp_path / name, tmp_path / "other.png", 192)

    write()
    whole = (tmp_path / name).read_bytes()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) - lacking, before[1]))
    try:
        with pytest.raises((WriteError, OSError), match=f"{name}|File too large"):
            write()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"other.png": other, name: whole}
