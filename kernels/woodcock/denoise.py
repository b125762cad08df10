"""Denoised pictures, by Open Image Denoise on the processor: an extra. A layer beside the raw one, not in its place."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]


class DenoiseError(RuntimeError):
    """A picture that could not be denoised; the text says why, and what to install."""


def denoise(beauty: Floats, albedo: Floats | None = None, normal: Floats | None = None) -> Floats:
    """The beauty (height, width, 1 or 3), linear and 0 or more, without its noise, in the same shape.

    albedo: (height, width, 1 or 3) in [0, 1]; normal: (height, width, 3) in [-1, 1]; they help where they have edges.
    The mean stays to a percent or so, not exactly: the fewer the samples, the less.
    Raises DenoiseError where Open Image Denoise is missing or fails, ValueError for shapes that do not fit.
    """
    for name, image, channels in (("beauty", beauty, (1, 3)), ("albedo", albedo, (1, 3)), ("normal", normal, (3,))):
        if image is not None and (
            image.shape[:2] != beauty.shape[:2] or image.shape[2:] not in {(n,) for n in channels}
        ):
            raise ValueError(f"{name} must be (height, width, {' or '.join(map(str, channels))}), not {image.shape}")
    library, device = _library()
    if not beauty.any():
        return beauty.copy()  # the filter would light it faintly
    # The filter's half floats hold no radiance of 1e20: pictures go in with a mean near 1. Powers of two are exact.
    exponent = math.frexp(float(beauty.mean(dtype=np.float64)))[1]
    images = [np.ldexp(beauty, -exponent), albedo, normal]
    colour, *guides = (None if image is None else _three_channels(image) for image in images)
    try:
        result = np.array(library.denoise(colour, *guides, hdr=True, device=device))
    except library.Error as error:
        raise DenoiseError(f"Open Image Denoise failed: {error}") from None
    return np.asarray(np.ldexp(result[..., : beauty.shape[2]], exponent))


def require() -> None:
    """Raises DenoiseError where Open Image Denoise is missing: before a picture is rendered, not after."""
    _library()


def _three_channels(image: Floats) -> Floats:
    return np.ascontiguousarray(np.broadcast_to(image, (*image.shape[:2], 3)), np.float32)


@cache
def _library() -> tuple[Any, Any]:
    """The module and its device. The processor, so that a picture is the same whatever GPU renders beside it."""
    try:
        import mitsuba_oidn as library
    except ImportError as error:
        raise DenoiseError(f"Open Image Denoise is missing ({error}): pip install 'woodcock[denoise]'") from None
    return library, library.Device(library.DeviceType.CPU)
