"""Pictures in, through OpenImageIO: OpenEXR and Radiance HDR, linear, as environments and references need them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from numpy.typing import NDArray

from woodcock.image import ImageError, header_of

#: Texels that a picture may have: 16384 × 8192.
MAX_TEXELS = 1 << 27

# What files of these formats begin with; what other formats hold is not linear, and uploaded files have no suffix.
_MAGICS = (b"\x76\x2f\x31\x01", b"#?RADIANCE", b"#?RGBE")


def recognises(path: Path) -> bool:
    """Is the file a picture by what it begins with? Raises OSError, and ValueError for what is no name of a file."""
    with path.open("rb") as file:
        return file.read(max(map(len, _MAGICS))).startswith(_MAGICS)


def read_picture(path: Path) -> NDArray[np.float32]:
    """(height, width, 3) of red, green, blue or (height, width, 1) of grey; other channels are left.

    Raises ImageError, whose text starts with the path, for a file that cannot be read or is too large.
    """
    with _opened(path) as image:
        return _pixels(path, image, _channels(list(image.spec().channelnames)))


def read_variance(path: Path) -> tuple[NDArray[np.float32] | None, dict[str, str]]:
    """Of the same channels, those named `variance.…`, None where there are none; and the file's `woodcock:…` header
    without that prefix. Raises ImageError."""
    return read_beside(path, "variance")


def read_beside(path: Path, layer: str) -> tuple[NDArray[np.float32] | None, dict[str, str]]:
    """As `read_variance`, of another layer that has the picture's channels: `bound`, `denoised`."""
    with _opened(path) as image:
        names = list(image.spec().channelnames)
        wanted = [f"{layer}.{names[index]}" for index in _channels(names)]
        known = set(wanted) <= set(names)
        pixels = _pixels(path, image, [names.index(name) for name in wanted]) if known else None
        return pixels, header_of(image.spec())


@contextmanager
def _opened(path: Path) -> Iterator[oiio.ImageInput]:
    _check_format(path)
    image = oiio.ImageInput.open(str(path))
    if image is None:
        reason = oiio.geterror()
        # The format is known: its own reader gave up, and what it said was lost when others were tried.
        known = not reason.startswith("OpenImageIO could not find a format reader")
        raise _unreadable(path, reason if known else "its header is damaged, or announces more than the file can hold")
    try:
        spec = image.spec()
        if spec.width * spec.height > MAX_TEXELS:
            raise ImageError(f"{path}: is {spec.width} × {spec.height} pixels; {MAX_TEXELS} in all are the most")
        yield image
    finally:
        image.close()


def _pixels(path: Path, image: oiio.ImageInput, channels: list[int]) -> NDArray[np.float32]:
    """(height, width, channels)"""
    first, stop = min(channels), max(channels) + 1
    if stop - first > len(channels):
        # One by one: what lies between them could be a thousand others.
        return np.concatenate([_run(path, image, index, index + 1) for index in channels], axis=-1)
    pixels = _run(path, image, first, stop)
    order = [index - first for index in channels]
    return pixels if order == sorted(order) else np.ascontiguousarray(pixels[..., order])


def _run(path: Path, image: oiio.ImageInput, first: int, stop: int) -> NDArray[np.float32]:
    """(height, width, stop - first)"""
    pixels: NDArray[np.float32] | None = image.read_image(0, 0, first, stop, oiio.FLOAT)
    if pixels is None:
        raise _unreadable(path, image.geterror())
    return pixels


def _check_format(path: Path) -> None:
    try:
        known = recognises(path)
    except (OSError, ValueError) as error:
        raise ImageError(f"{path}: {getattr(error, 'strerror', None) or error}") from None
    if not known:
        raise ImageError(f"{path}: is no picture that can be read; OpenEXR (.exr) and Radiance (.hdr) files can")


def _unreadable(path: Path, reason: str) -> ImageError:
    """Of what OpenImageIO says, the first line."""
    return ImageError(f"{path}: cannot be read: {next(iter(reason.splitlines()), 'OpenImageIO does not say why')}")


def _channels(names: list[str]) -> list[int]:
    """Of red, green and blue by their names, else of Y, else the first three or the first."""
    for wanted in (["R", "G", "B"], ["Y"]):
        if set(wanted) <= set(names):
            return [names.index(name) for name in wanted]
    return [0, 1, 2] if len(names) >= 3 else [0]
