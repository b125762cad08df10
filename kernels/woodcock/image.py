"""Pictures out: a multi-layer EXR of what was measured, a PNG to look at, and a small WebP of that."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, reduce
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from woodcock import denoise as denoiser
from woodcock.files import replacing
from woodcock.film import Film
from woodcock.layers import is_radiance


class ImageError(RuntimeError):
    """A picture that could not be written or read."""


class WriteError(ImageError):
    """The disk did not take it, for want of room or for a fault; where it may not be written at all, that is an
    OSError."""


def denoised(film: Film) -> NDArray[np.float32]:
    """The beauty without its noise, (height, width, channels), with the help of the film's albedo and normals, if any.

    Raises DenoiseError.
    """
    guides = {
        layer: film.layer(layer).mean.astype(np.float32) for layer in ("albedo", "normal") if layer in film.layers
    }
    return denoiser.denoise(film.layer("").mean.astype(np.float32), **guides)


def write_exr(path: Path, film: Film, header: Mapping[str, str], denoise: bool = False) -> None:
    """Writes float32, ZIP: every channel of the film, `variance.…` of those that are radiance, `samples.count`;
    `bound.…` of a film that has one, and `denoised.…` if asked for.

    header: becomes `woodcock:…`. Raises OSError, ImageError and DenoiseError.
    """
    layers = measured(film)
    if denoise:
        beauty = denoised(film)
        layers |= {f"denoised.{name}": beauty[..., i] for i, name in enumerate(film.names[: film.channels])}
    spec = oiio.ImageSpec(film.width, film.height, len(layers), oiio.FLOAT)
    spec.channelnames = tuple(layers)
    spec.attribute("compression", "zip")
    spec.attribute("oiio:ColorSpace", "lin_rec709")
    for name, value in header.items():
        spec.attribute(f"woodcock:{name}", value)
    # A variance that float32 cannot hold becomes infinite, never a wrong number.
    with np.errstate(over="ignore"):
        _write(path, spec, np.stack([pixels.astype(np.float32) for pixels in layers.values()], axis=-1))


def measured(film: Film) -> dict[str, NDArray[Any]]:
    """(height, width) by the name of the channel, as an EXR has them: those of the film, the variance of those that are
    radiance, the bound if there is one, and the count of samples."""
    variance = film.variance()
    layers: dict[str, NDArray[Any]] = {name: film.mean[..., index] for index, name in enumerate(film.names)}
    layers |= {f"variance.{name}": variance[..., i] for i, name in enumerate(film.names) if is_radiance(name)}
    if film.bound is not None:
        layers |= {f"bound.{name}": film.bound[..., i] for i, name in enumerate(film.names[: film.channels])}
    return {**layers, "samples.count": film.count}


def write_preview(path: Path, film: Film, size: int | None = None) -> None:
    """Writes a PNG of the beauty layer, its 99th percentile near white; size: longest side, pixels."""
    encoded = oiio.ImageBuf(np.ascontiguousarray(tone_map(film.layer("").mean), np.float32))
    if size is not None and max(film.width, film.height) > size:
        scale = size / max(film.width, film.height)
        roi = oiio.ROI(0, max(1, round(film.width * scale)), 0, max(1, round(film.height * scale)), 0, 1, 0, 3)
        encoded = oiio.ImageBufAlgo.resize(encoded, "", 0, roi=roi)
    pixels = np.asarray(encoded.get_pixels(oiio.FLOAT))
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, oiio.UINT8)
    # Written every second of a render: much faster than the default, for little more size.
    spec.attribute("png:compressionLevel", 1)
    _write(path, spec, pixels)


def write_thumbnail(path: Path, preview: Path, size: int) -> None:
    """Writes a WebP of a preview; size: longest side, pixels. Raises OSError and ImageError."""
    # Not through OpenImageIO, whose writer of WebP tries for ever where the disk is full.
    content = BytesIO()
    try:
        with Image.open(preview, formats=["PNG"]) as image:
            image.thumbnail((size, size), Image.Resampling.LANCZOS)
            image.save(content, "WEBP", quality=85)
    except UnidentifiedImageError:
        raise ImageError(f"{preview}: is no preview") from None
    with replacing(path) as temporary:
        temporary.write_bytes(content.getvalue())


def white_of(radiance: NDArray[np.float64]) -> float:
    """The radiance that a picture's exposure brings near white: the 99th percentile of its largest channel."""
    return float(np.percentile(reduce(np.maximum, np.moveaxis(_finite(radiance), -1, 0)), 99))


def tone_map(radiance: NDArray[np.float64], white: float | None = None) -> NDArray[np.float32]:
    """(height, width, 1 or 3) of any scale -> sRGB (height, width, 3) in [0, 1]: exposure, soft shoulder, curve.

    white: `white_of` another picture, for the same exposure.
    """
    white = white_of(radiance) if white is None else white
    table = _curve()
    at = _finite(radiance)
    with np.errstate(over="ignore"):
        at *= (len(table) - 1) / _LIGHTEST / (white if white > 0 else 1.0)
    at += 0.5
    np.clip(at, 0, len(table) - 1, out=at)
    return np.broadcast_to(table[at.astype(np.uint16)], (*radiance.shape[:2], 3))


#: From there on all is white, to seven digits.
_LIGHTEST = 4.0


@cache
def _curve() -> NDArray[np.float32]:
    """sRGB by radiance from 0 to _LIGHTEST, in steps of a fifth of what 8 bits tell apart where it is steepest."""
    x = np.linspace(0, _LIGHTEST, 1 << 16)
    # Linear up to 0.8, then rolled off towards 1 with matching slope.
    knee = 0.8
    rolled = knee + (1 - knee) * (1 - np.exp(-(x - knee).clip(0) / (1 - knee)))
    linear = np.where(x < knee, x, rolled)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055).astype(np.float32)


def _finite(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """A copy, with zero for what is no number or infinite."""
    return np.where(np.isfinite(values), values, 0.0)


def read_exr(path: Path) -> tuple[dict[str, NDArray[np.float32]], dict[str, str]]:
    """Every channel by name (height, width), and the `woodcock:…` header without that prefix. Raises ImageError."""
    with _opened(path) as image:
        spec = image.spec()
        return _rows(path, image, 0, spec.height, spec.channelnames), header_of(spec)


def shape_of(path: Path) -> tuple[tuple[str, ...], int, int]:
    """Names of an EXR's channels, its width and its height, without reading a pixel. Raises ImageError."""
    with _opened(path) as image:
        spec = image.spec()
        return tuple(spec.channelnames), spec.width, spec.height


def read_rows(path: Path, start: int, stop: int, names: Sequence[str]) -> dict[str, NDArray[np.float32]]:
    """Rows [start, stop) of an EXR's channels of these names (stop - start, width). Raises ImageError."""
    with _opened(path) as image:
        return _rows(path, image, start, stop, names)


@contextmanager
def _opened(path: Path) -> Iterator[oiio.ImageInput]:
    image = oiio.ImageInput.open(str(path))
    if image is None:
        raise ImageError(f"{path}: {oiio.geterror()}")
    try:
        yield image
    finally:
        image.close()


def _rows(
    path: Path, image: oiio.ImageInput, start: int, stop: int, names: Sequence[str]
) -> dict[str, NDArray[np.float32]]:
    spec = image.spec()
    at = [spec.channelnames.index(name) for name in names]
    first, last = min(at), max(at)
    pixels = image.read_scanlines(0, 0, spec.y + start, spec.y + stop, 0, first, last + 1, oiio.FLOAT)
    if pixels is None:
        raise ImageError(f"{path}: {image.geterror()}")
    pixels = pixels.reshape(stop - start, spec.width, last + 1 - first)
    return {name: pixels[..., index - first] for name, index in zip(names, at, strict=True)}


def header_of(spec: oiio.ImageSpec) -> dict[str, str]:
    """What `write_exr` was given as the header."""
    return {
        a.name.removeprefix("woodcock:"): str(a.value) for a in spec.extra_attribs if a.name.startswith("woodcock:")
    }


def _write(path: Path, spec: oiio.ImageSpec, pixels: NDArray[np.generic]) -> None:
    with replacing(path) as temporary:
        image = oiio.ImageOutput.create(str(temporary))
        if image is None:
            raise ImageError(f"{path}: {oiio.geterror()}")
        if not (image.open(str(temporary), spec) and image.write_image(np.ascontiguousarray(pixels)) and image.close()):
            raise WriteError(f"{path}: {image.geterror()}")
        # OpenImageIO does not see that the last bytes find no room, those of a PNG or of an EXR.
        if not (_is_whole_png(temporary.read_bytes()) if path.suffix == ".png" else _has_last_row(temporary)):
            raise WriteError(f"{path}: could not be written as a whole")


def _is_whole_png(content: bytes) -> bool:
    at = 8
    while at + 12 <= len(content):
        (length,) = struct.unpack_from(">I", content, at)
        end = at + 8 + length
        if end + 4 > len(content) or zlib.crc32(content[at + 4 : end]) != struct.unpack_from(">I", content, end)[0]:
            return False
        at = end + 4
    return at == len(content) and content.endswith(b"IEND\xaeB`\x82")


def _has_last_row(path: Path) -> bool:
    image = oiio.ImageInput.open(str(path))
    if image is None:
        return False
    try:
        spec = image.spec()
        return image.read_scanline(spec.y + spec.height - 1, 0, oiio.FLOAT) is not None
    finally:
        image.close()
