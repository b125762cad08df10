"""An environment from a picture of all directions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from woodcock.image import ImageError
from woodcock.picture import read_picture
from woodcock.scene import ImageLight, Light
from woodcock.space import Array, Space

FIELDS = {
    "to_local": "affine",
    "to_world": "affine",
    "scale": "colour",
    "density": "float",
    "width": "int",
    "height": "int",
    "stride": "int",
    "texels": "int",
    "rows": "int",
    "columns": "int",
}
BUFFERS = {"texels": "float", "rows": "uint", "columns": "uint"}
ON_ESCAPE = True
SAMPLED = True
LOCAL = False

#: What all of a table's cumulative weights come to: the steps of a uniform.
STEPS = 1 << 24
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LARGEST = 1e30


@dataclass(frozen=True)
class Picture:
    """An image light, read. texels: (height, width, 1) where all of it is grey, else (height, width, 3)."""

    light: ImageLight
    texels: NDArray[np.float32]
    kind: Literal["image"] = "image"


def read(light: ImageLight) -> Picture:
    """Reads the light's file. Raises ImageError, whose text starts with it, for one that is no environment."""
    texels = read_picture(Path(light.file))
    height, width = texels.shape[:2]
    check_size(width, height, light.file)
    low, high = float(texels.min()), float(texels.max())
    if not (math.isfinite(low) and math.isfinite(high)):
        raise ImageError(f"{light.file}: holds values that are not finite; radiance is 0 or more and finite")
    if low < 0:
        raise ImageError(f"{light.file}: holds negative values, down to {low:g}; radiance is 0 or more")
    if texels.shape[2] == 3 and all(np.array_equal(texels[..., 0], texels[..., c]) for c in (1, 2)):
        texels = np.ascontiguousarray(texels[..., :1])
    picture = Picture(light, texels)
    if strength(picture).max() > LARGEST:
        raise ImageError(f"{light.file}: its largest value times scale is above {LARGEST:g}, the largest radiance")
    return picture


def check_size(width: int, height: int, file: str) -> None:
    """Raises ImageError for a picture that cannot be one of all directions."""
    if width != 2 * height:
        raise ImageError(f"{file}: is {width} × {height} pixels; a picture of all directions is twice as wide as high")


def read_all(lights: Sequence[Light]) -> list[Light | Picture]:
    """A scene's lights, those that are pictures read. Raises ImageError."""
    return [read(light) if isinstance(light, ImageLight) else light for light in lights]


def is_coloured(light: Light | Picture) -> bool:
    """Is it a picture that needs three channels: by its colours or by the scale's?"""
    if not isinstance(light, Picture):
        return False
    return light.texels.shape[2] == 3 or isinstance(light.light.scale, tuple)


def strength(picture: Picture) -> Array:
    return np.atleast_1d(picture.texels.max(axis=(0, 1)).astype(np.float64) * np.array(picture.light.scale))


def buffers(picture: Picture) -> dict[str, NDArray[np.generic]]:
    """texels, scaled to at most 1; cumulative weights of rows (height + 1) and in each row (height × (width + 1))."""
    height, width = picture.texels.shape[:2]
    texels = np.ldexp(picture.texels, -_exponent(picture)).reshape(-1)
    columns = np.empty((height, width + 1), np.uint32)
    weights = np.empty(height)
    for y in range(height):
        row = _luminance(picture, y)
        columns[y] = _cumulative(row)
        weights[y] = row.sum() * _sine(picture, y)
    return {"texels": texels, "rows": _cumulative(weights), "columns": columns.reshape(-1)}


def _exponent(picture: Picture) -> int:
    return math.frexp(float(picture.texels.max()))[1]


def _luminance(picture: Picture, y: int) -> Array:
    """(width,), of a row of texels, scaled to avoid overflow."""
    scale = np.broadcast_to(np.array(picture.light.scale), 3) / (np.max(picture.light.scale) or 1)
    row = np.broadcast_to(picture.texels[y], (picture.texels.shape[1], 3))
    return np.asarray(row.astype(np.float64) @ (LUMINANCE * scale))


def _sine(picture: Picture, y: int) -> float:
    """Of θ in the middle of a row."""
    return math.sin(math.pi * (y + 0.5) / picture.texels.shape[0])


def _cumulative(weights: Array) -> NDArray[np.uint32]:
    """(n,) -> (n + 1,) from 0 to STEPS; what weighs anything gets one step at least, the rest is shared by weight.

    Where nothing does, everything weighs the same.
    """
    if not weights.sum() > 0:
        weights = np.ones_like(weights)
    total = np.cumsum(weights)
    least = np.cumsum(weights > 0)
    steps = np.floor((STEPS - least[-1]) * (total / total[-1])) + least
    return np.concatenate([[0], steps]).astype(np.uint32)


def record(picture: Picture, space: Space, offsets: Mapping[str, int]) -> dict[str, Array | float | int]:
    height, width, channels = picture.texels.shape
    turn = rotation(picture.light)
    scale = space.radiance(np.ldexp(np.atleast_1d(np.array(picture.light.scale)), _exponent(picture)))
    still = np.zeros((3, 1))
    return {
        "to_local": np.hstack([turn.T, still]),
        "to_world": np.hstack([turn, still]),
        "scale": scale,
        "density": width * height / (2 * math.pi**2) / STEPS**2,
        "width": width,
        "height": height,
        "stride": channels,
        "texels": offsets["texels"],
        "rows": offsets["rows"],
        "columns": offsets["columns"],
    }


def rotation(light: ImageLight) -> Array:
    """(3, 3), the orthogonal matrix nearest to `to_world`: its rotation without its stretching."""
    u, _, v = np.linalg.svd(np.array(light.to_world)[:3, :3])
    return np.asarray(u @ v)


def radiance(picture: Picture, direction: Array) -> Array:
    """Float64 oracle: radiance (..., channels) that paths of unit directions (..., 3) find on escape."""
    values = _interpolated(picture, direction, picture.texels.astype(np.float64))
    return np.asarray(values * np.array(picture.light.scale))


def density(picture: Picture, direction: Array) -> Array:
    """Float64 oracle: density (...) per steradian of samples, by luminance × sin θ, bilinear as the radiance is."""
    height, width = picture.texels.shape[:2]
    weights = np.array([_luminance(picture, y) * _sine(picture, y) for y in range(height)])
    if not weights.sum() > 0:
        weights = np.ones_like(weights)
    sine = np.sin(np.arccos(np.clip((direction @ rotation(picture.light))[..., 1], -1, 1)))
    chosen = _interpolated(picture, direction, weights[..., None] / weights.sum())[..., 0]
    return np.asarray(chosen * width * height / (2 * np.pi**2 * sine))


def _interpolated(picture: Picture, direction: Array, values: Array) -> Array:
    """Of values (height, width, n), (..., n)."""
    height, width = picture.texels.shape[:2]
    local = direction @ rotation(picture.light)
    x = (np.arctan2(local[..., 0], -local[..., 2]) / (2 * np.pi) + 0.5) * width - 0.5
    y = np.arccos(np.clip(local[..., 1], -1, 1)) / np.pi * height - 0.5
    total = np.zeros((*direction.shape[:-1], values.shape[-1]))
    for down, across in np.ndindex(2, 2):
        i, j = np.floor(x) + across, np.floor(y) + down
        weight = (1 - np.abs(x - i)) * (1 - np.abs(y - j))
        total += weight[..., None] * values[np.clip(j, 0, height - 1).astype(int), i.astype(int) % width]
    return total
