"""The image light: reading, lookup, and sampling that fits the lookup."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
import pytest
from tests.conftest import Rng
from tests.kernels.device_code import call
from tests.statistics import accept_counts, accept_mean

from woodcock.device import Context
from woodcock.image import ImageError
from woodcock.light import image
from woodcock.light.image import Picture
from woodcock.scene import ImageLight
from woodcock.space import Space

SPACE = Space(radiance_exponent=3)
TURN = ((0.0, 0.0, 2.0, 5.0), (2.0, 0.0, 0.0, 5.0), (0.0, 2.0, 0.0, 5.0), (0.0, 0.0, 0.0, 1.0))
BUFFERS = "texels, rows, columns"
RANDOM = np.random.default_rng(9)


def picture(texels: np.ndarray, **keys: Any) -> Picture:
    return Picture(ImageLight(file="sky.exr", **keys), np.ascontiguousarray(texels, np.float32))


def sparse(height: int) -> np.ndarray:
    """Mostly black, a little dim, one sun, its neighbour another colour's."""
    texels = RANDOM.lognormal(0, 2, (height, 2 * height, 3)) * (RANDOM.random((height, 2 * height, 1)) < 0.3)
    texels[1, 3] = (5000, 3000, 2000)
    texels[1, 4] = (0, 0, 900)
    texels[height // 2] = 0
    return texels


PICTURES = {
    "turned": (picture(RANDOM.lognormal(0, 1, (8, 16, 3)), to_world=TURN, scale=(2, 1, 0.5)), 3),
    "sparse": (picture(sparse(6)), 3),
    "grey in colour": (picture(RANDOM.lognormal(0, 1, (4, 8, 1)), scale=(0.1, 0.2, 0.3)), 3),
    "grey": (picture(RANDOM.lognormal(0, 3, (4, 8, 1)), scale=3), 1),
    "two texels": (picture(np.array([[[1.0], [7.0]]])), 1),
    "black": (picture(np.zeros((2, 4, 1))), 1),
}
pictures = pytest.mark.parametrize("name", PICTURES)


def run(context: Context, lanes: int, name: str, body: str, results: list[str], **inputs: np.ndarray) -> np.ndarray:
    """Expressions on a picture; what `%` stands for comes once for every channel."""
    sky, channels = PICTURES[name]
    every = [result.replace("%", str(c)) for result in results for c in range(channels if "%" in result else 1)]
    # Other instances' elements come first, as in a scene of two pictures.
    before = {"texels": 5, "rows": 3, "columns": 2}
    buffers = {key: np.concatenate([np.zeros(before[key], a.dtype), a]) for key, a in image.buffers(sky).items()}
    record = image.record(sky, SPACE, before)
    values = call(context, "light", sky, record, body, every, inputs, lanes, channels=channels, buffers=buffers)
    return values.astype(float)


def sphere(n: int) -> np.ndarray:
    """(n, 3), and some along the axes, where longitudes wrap and poles are."""
    v = np.random.default_rng(10).standard_normal((n, 3))
    axes = np.concatenate([np.eye(3), -np.eye(3)]) + 1e-3
    v[:6], v[6:12] = axes, -axes
    return v / np.linalg.norm(v, axis=1, keepdims=True)


@pictures
def test_lookup_and_density(context: Context, lanes: int, name: str) -> None:
    sky, channels = PICTURES[name]
    d = sphere(1024).astype(np.float32)
    inputs = {axis: np.ascontiguousarray(d[:, i]) for i, axis in enumerate("xyz")}
    body = f"""vector d = vector_of(x, y, z);
    spectrum s = light_image_radiance(kind, {BUFFERS}, d);"""
    results = ["spectrum_channel(s, %)", f"light_image_pdf(kind, {BUFFERS}, d)"]
    *radiance, density = run(context, lanes, name, body, results, **inputs)
    exact = d.astype(float) / np.linalg.norm(d.astype(float), axis=1, keepdims=True)
    right = np.broadcast_to(image.radiance(sky, exact), (d.shape[0], channels))
    largest = max(float(image.strength(sky).max()), 1e-30)
    assert np.allclose(np.array(radiance).T * 8, right, rtol=1e-5, atol=3e-6 * largest)
    pdf = image.density(sky, exact)
    assert np.allclose(density, pdf, rtol=1e-3, atol=3e-6 * pdf.max())
    # Where there is radiance there is density.
    assert (density[np.array(radiance).max(axis=0) > 0] > 0).all()


@pictures
def test_samples(context: Context, lanes: int, name: str, rng: Rng) -> None:
    """A sample's weight times its density is the radiance there; samples follow the density; energy is all there."""
    sky, channels = PICTURES[name]
    n = 1 << 15
    u, v = rng(11).random((2, n), dtype=np.float32)
    u[:4], v[:4] = [0, 1 - 2.0**-24, 0, 1 - 2.0**-24], [0, 0, 1 - 2.0**-24, 1 - 2.0**-24]
    body = f"""light_sample s; light_image_sample(kind, {BUFFERS}, vector_of(u, u, u), u, v, &s);
    spectrum there = light_image_radiance(kind, {BUFFERS}, s.towards);"""
    results = ["s.towards.x", "s.towards.y", "s.towards.z", "s.distance", "s.pdf"]
    results += [f"light_image_pdf(kind, {BUFFERS}, s.towards)", "spectrum_channel(s.weight, %)"]
    got = run(context, lanes, name, body, [*results, "spectrum_channel(there, %)"], u=u, v=v)
    d, distance, pdf, again = got[:3].T, got[3], got[4], got[5]
    weight, there = got[6 : 6 + channels] * 8, got[6 + channels :] * 8
    assert np.allclose(np.linalg.norm(d, axis=1), 1, atol=3e-7)
    assert (distance == np.float32(1e30)).all()
    assert np.isfinite(weight).all()
    assert ((pdf > 0) | (weight == 0).all(axis=0)).all()
    # Looking a direction up again sees it rounded, which a sun between black texels enlarges.
    size = sky.texels.shape[1] / 16
    assert np.mean(~np.isclose(pdf, again, rtol=1e-4 * size)) < 2e-3
    assert np.mean(~np.isclose(weight * pdf, there, rtol=1e-4 * size).all(axis=0)) < 2e-3

    # Chi-square over cells of the sphere, against the oracle's density by fine quadrature.
    cells, fine = (6, 12), 24
    theta = (np.arange(cells[0] * fine) + 0.5) / (cells[0] * fine) * np.pi
    phi = (np.arange(cells[1] * fine) + 0.5) / (cells[1] * fine) * 2 * np.pi - np.pi
    sine = np.sin(theta)[:, None]
    grid = np.stack([sine * np.sin(phi), np.cos(theta)[:, None] + 0 * phi, -sine * np.cos(phi)], axis=-1)
    solid = 2 * np.pi**2 / theta.size / phi.size * sine
    probability = image.density(sky, grid) * solid
    assert probability.sum() == pytest.approx(1, abs=2e-3)
    expected = probability.reshape(cells[0], fine, cells[1], fine).sum(axis=(1, 3)).reshape(-1)
    row = np.minimum(np.arccos(np.clip(d[:, 1], -1, 1)) / np.pi * cells[0], cells[0] - 1).astype(int)
    column = ((np.arctan2(d[:, 0], -d[:, 2]) / (2 * np.pi) + 0.5) * cells[1]).astype(int) % cells[1]
    seen = np.bincount(row * cells[1] + column, minlength=expected.size)
    many = expected * n > 10
    observed, wanted = np.append(seen[many], seen[~many].sum()), np.append(expected[many], expected[~many].sum())
    kept = wanted > 0
    assert (seen[expected < 1e-9] == 0).all()
    accept_counts(observed[kept], wanted[kept])

    # Energy: the mean weight is the radiance's integral over the sphere.
    total = (image.radiance(sky, grid) * solid[..., None]).sum(axis=(0, 1))
    accept_mean(weight, total, "energy", allowed=3e-3 * total)


def test_energy_is_that_of_the_texels() -> None:
    """The radiance's integral is the texels' sum, each with its share of the sphere."""
    sky, _ = PICTURES["sparse"]
    edges = np.cos(np.linspace(0, np.pi, 7))
    share = (edges[:-1] - edges[1:]) * 2 * np.pi / 12
    theta, phi = ((np.arange(n) + 0.5) / n for n in (600, 1200))
    sine = np.sin(np.pi * theta)[:, None]
    angle = 2 * np.pi * phi
    d = np.stack([sine * np.sin(angle), np.cos(np.pi * theta)[:, None] + 0 * angle, -sine * np.cos(angle)], axis=-1)
    total = (image.radiance(sky, d) * sine[..., None]).sum(axis=(0, 1)) * 2 * np.pi**2 / (600 * 1200)
    # Interpolation moves a little of a texel's light to rows of another size.
    assert np.allclose(total, (sky.texels * share[:, None, None]).sum(axis=(0, 1)), rtol=0.1)


def test_orientation() -> None:
    """-z in the middle, +y up, +x a quarter to the right of the middle."""
    texels = np.zeros((4, 8, 3))
    texels[:, 3:5, 0], texels[0, :, 1], texels[:, 5:7, 2] = 1, 1, 1
    sky = picture(texels)
    red, green, blue = image.radiance(sky, np.array([[0, 0, -1.0], [0, 1, 1e-9], [1, 0, 0]]))
    assert red.tolist() == [1, 0, 0]
    assert green[1] == 1
    assert blue.tolist() == [0, 0, 1]


def test_big_pictures(context: Context) -> None:
    """A texel of 2 million that shines is found by every sample; and so is one that hardly does, at its own rate."""
    texels = np.zeros((1024, 2048, 1), np.float32)
    texels[300, 2000], texels[700, 5] = 1, 1e-12
    PICTURES["big"] = (picture(texels), 1)
    try:
        u, v = np.random.default_rng(12).random((2, 1024), dtype=np.float32)
        body = f"light_sample s; light_image_sample(kind, {BUFFERS}, vector_of(u, u, u), u, v, &s);"
        *d, pdf, weight = run(
            context, 1, "big", body, ["s.towards.x", "s.towards.y", "s.towards.z", "s.pdf", "s.weight"], u=u, v=v
        )
    finally:
        del PICTURES["big"]
    theta, phi = np.pi * 300.5 / 1024, 2 * np.pi * (2000.5 / 2048 - 0.5)
    middle = [np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)]
    assert np.abs(np.array(d).T - middle).max() < 2 * np.pi / 1024
    assert np.allclose(weight * 8, np.sin(theta) * 2 * np.pi**2 / (1024 * 2048), rtol=5e-3)
    assert (pdf > 0).all()
    rows = image.buffers(picture(texels))["rows"]
    assert np.flatnonzero(np.diff(rows)).tolist() == [300, 700]
    assert rows[-1] == 1 << 24


def write(path: Path, pixels: np.ndarray, names: str = "RGB") -> str:
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], oiio.FLOAT)
    spec.channelnames = tuple(names)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(np.ascontiguousarray(pixels, np.float32))
    assert out.close()
    return str(path)


@pytest.mark.parametrize(("suffix", "names"), [("exr", "RGB"), ("exr", "RGBA"), ("exr", "Y"), ("hdr", "RGB")])
def test_reading(tmp_path: Path, suffix: str, names: str) -> None:
    pixels = np.ldexp(RANDOM.integers(128, 256, (4, 8, len(names))), -6)
    sky = image.read(ImageLight(file=write(tmp_path / f"sky.{suffix}", pixels, names), scale=2))
    wanted = pixels[..., : 1 if names == "Y" else 3]
    assert np.allclose(sky.texels, wanted, rtol=0.01 if suffix == "hdr" else 0)
    assert image.is_coloured(sky) == (names != "Y")
    assert np.allclose(image.strength(sky), 2 * wanted.max(axis=(0, 1)), rtol=0.01)


def test_grey_pictures_are_grey(tmp_path: Path) -> None:
    grey = np.repeat(RANDOM.random((2, 4, 1)), 3, axis=2)
    file = write(tmp_path / "grey.exr", grey)
    assert image.read(ImageLight(file=file)).texels.shape == (2, 4, 1)
    assert not image.is_coloured(image.read(ImageLight(file=file)))
    assert image.is_coloured(image.read(ImageLight(file=file, scale=(1, 2, 3))))


def test_faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good = np.ones((2, 4, 3))
    bad = {
        "twice as wide": write(tmp_path / "square.exr", np.ones((4, 4, 3))),
        "negative values, down to -1": write(tmp_path / "negative.exr", good * [1, -1, 1]),
        "not finite": write(tmp_path / "nan.exr", good * [1, np.nan, 1]),
        "No such file": str(tmp_path / "none.exr"),
        "OpenEXR": write(tmp_path / "sky.png", good),
        "null": "sky\0.exr",
    }
    torn = tmp_path / "torn.exr"
    torn.write_bytes((tmp_path / "square.exr").read_bytes()[:200])
    bad["cannot be read"] = str(torn)
    for message, file in bad.items():
        with pytest.raises(ImageError, match=message) as caught:
            image.read(ImageLight(file=file))
        assert str(caught.value).startswith(file)
    monkeypatch.setattr("woodcock.picture.MAX_TEXELS", 7)
    with pytest.raises(ImageError, match=r"is 4 × 2 pixels; 7 in all are the most"):
        image.read(ImageLight(file=write(tmp_path / "large.exr", good)))
    monkeypatch.undo()
    with pytest.raises(ImageError, match="largest radiance"):
        image.read(ImageLight(file=write(tmp_path / "bright.exr", good * 1e20), scale=1e20))
