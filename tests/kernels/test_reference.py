"""References are read as anybody writes them, and refused in one sentence where they cannot be one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
import pytest

from woodcock.film import Film
from woodcock.image import ImageError, write_exr
from woodcock.layers import beauty_names
from woodcock.reference import Reference
from woodcock.space import Array


def written(path: Path, pixels: Array, names: tuple[str, ...]) -> Path:
    """As another program writes it."""
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], len(names), oiio.FLOAT)
    spec.channelnames = names
    image = oiio.ImageOutput.create(str(path))
    assert image.open(str(path), spec)
    assert image.write_image(np.ascontiguousarray(pixels, np.float32))
    assert image.close()
    return path


def ours(path: Path, channels: int, samples: int = 4) -> tuple[Path, Film]:
    random = np.random.default_rng(channels)
    shape = (2, 3, channels)
    count = np.full(shape[:2], samples, np.uint32)
    film = Film(count, random.random(shape), random.random(shape), beauty_names(channels), ((0, samples),))
    write_exr(path, film, {"seed": "7"})
    return path, film


@pytest.mark.parametrize("channels", [1, 3])
def test_of_ours(tmp_path: Path, channels: int) -> None:
    path, film = ours(tmp_path / "long.exr", channels)
    reference = Reference.load(path)
    assert reference.mean == pytest.approx(film.mean, rel=1e-6)
    assert reference.variance == pytest.approx(film.variance(), rel=1e-6)
    assert (reference.name, reference.width, reference.height, reference.seed) == ("long.exr", 3, 2, 7)


def test_of_one_sample_has_no_variance(tmp_path: Path) -> None:
    assert Reference.load(ours(tmp_path / "short.exr", 1, samples=1)[0]).variance is None


def test_of_another_program(tmp_path: Path) -> None:
    """Channels by their names, whatever is between them."""
    pixels = np.random.default_rng(1).random((2, 3, 5))
    reference = Reference.load(written(tmp_path / "their.exr", pixels, ("A", "B", "G", "R", "Z")))
    assert reference.mean == pytest.approx(pixels[..., [3, 2, 1]], rel=1e-6)
    assert (reference.variance, reference.seed) == (None, None)


def test_a_variance_among_other_channels(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).random((2, 3, 8))
    variance = tuple(f"variance.{name}" for name in ("B", "C", "G", "R", "Z"))
    reference = Reference.load(written(tmp_path / "their.exr", pixels, ("R", "G", "B", *variance)))
    assert reference.variance == pytest.approx(pixels[..., [6, 5, 3]], rel=1e-6)


def test_radiance_files(tmp_path: Path) -> None:
    reference = Reference.load(written(tmp_path / "their.hdr", np.full((2, 3, 3), 0.5), ("R", "G", "B")))
    assert reference.mean == pytest.approx(np.full((2, 3, 3), 0.5), rel=0.01)


def test_samples_that_are_shared_are_not_independent(tmp_path: Path) -> None:
    reference = Reference.load(ours(tmp_path / "long.exr", 1)[0])
    assert reference.independent_of(8) is reference
    assert reference.independent_of(7).variance is None
    plain = Reference(reference.mean, None, "theirs")
    assert plain.independent_of(0) is plain


def test_size_and_channels(tmp_path: Path) -> None:
    grey, colour = (Reference.load(ours(tmp_path / f"{n}.exr", n)[0]) for n in (1, 3))
    grey.check(3, 2, 1)
    colour.check(3, 2, 3)
    colour.check(3, 2, 1)
    with pytest.raises(ImageError, match=r"^3.exr: is 3 × 2 pixels; a reference must be 4 × 2, as the film is$"):
        colour.check(4, 2, 3)
    with pytest.raises(
        ImageError, match=r"^1.exr: is grey; the reference of a picture in colour must have R, G and B$"
    ):
        grey.check(3, 2, 3)


@pytest.mark.parametrize(("value", "says"), [(np.nan, r"pixel \(2, 1\) is no finite number"), (0.0, "is black")])
def test_what_is_no_reference(tmp_path: Path, value: float, says: str) -> None:
    pixels = np.zeros((2, 3, 1))
    pixels[1, 2] = value
    path = written(tmp_path / "bad.exr", pixels, ("Y",))
    with pytest.raises(ImageError, match=rf"bad.exr: {says}"):
        Reference.load(path)


def test_what_is_no_picture(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text("{}")
    with pytest.raises(ImageError, match=r"scene.json: is no picture that can be read"):
        Reference.load(path)
