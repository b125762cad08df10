"""Pictures of all directions, made anew where a scene cannot say how another renderer reads them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from numpy.typing import NDArray

from woodcock.image import ImageError
from woodcock.importing.report import SourceError, shown
from woodcock.importing.transforms import Array, vector
from woodcock.picture import read_picture

Picture = NDArray[np.float32]


def from_equal_area(path: Path, where: str, to_picture: Array) -> Callable[[Path], None]:
    """What writes pbrt's square picture, equal-area octahedral (Clarberg 2008), as one of longitude and latitude.

    `to_picture` (4, 4) takes directions of the world to those of the square.
    """
    try:
        square = np.broadcast_to(pixels := read_picture(path), (*pixels.shape[:2], 3))
    except ImageError as error:
        raise SourceError(f"{where}: {error}") from None
    side = square.shape[0]
    if square.shape[1] != side:
        raise SourceError(f"{where}: {shown(path.name)} must be square, as pbrt has it, not {square.shape[1]} × {side}")
    height = max(side, 2)
    directions = vector(to_picture, latlong_directions(height))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    u, v = equal_area(directions)
    pixels = np.zeros((height, 2 * height, 3), np.float32)
    x, y = u * side - 0.5, v * side - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    for dy in (0, 1):
        for dx in (0, 1):
            weight = (1 - abs(x - left - dx)) * (1 - abs(y - top - dy))
            column, row = _wrap(left + dx, top + dy, side)
            pixels += (weight[..., None] * square[row, column]).astype(np.float32)
    return lambda to: _write(to, pixels, where)


def latlong_directions(height: int) -> Array:
    """(height, 2 height, 3): directions of an ImageLight's pixels: +y up, -z in the middle, +x right of it."""
    longitude = (np.arange(2 * height) + 0.5) / (2 * height) * 2 * np.pi - np.pi
    latitude = np.pi / 2 - (np.arange(height) + 0.5) / height * np.pi
    level, up = np.cos(latitude)[:, None], np.sin(latitude)[:, None]
    return np.stack(
        [level * np.sin(longitude), np.broadcast_to(up, (height, 2 * height)), -level * np.cos(longitude)], axis=-1
    )


def equal_area(d: Array) -> tuple[Array, Array]:
    """Coordinates in the square, from 0 to 1, of unit directions (..., 3): the inverse of pbrt's mapping."""
    x, y, z = np.moveaxis(np.abs(d), -1, 0)
    r = np.sqrt(np.maximum(1 - z, 0))
    phi = np.arctan2(y, x) * 2 / np.pi
    v = phi * r
    u = r - v
    u, v = np.where(d[..., 2] < 0, 1 - v, u), np.where(d[..., 2] < 0, 1 - u, v)
    return (np.copysign(u, d[..., 0]) + 1) / 2, (np.copysign(v, d[..., 1]) + 1) / 2


def _wrap(column: NDArray[np.int_], row: NDArray[np.int_], side: int) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Beyond an edge the square goes on at the same edge, mirrored about its middle."""
    beyond = (column < 0) | (column >= side)
    column, row = np.where(beyond, np.clip(column, 0, side - 1), column), np.where(beyond, side - 1 - row, row)
    beyond = (row < 0) | (row >= side)
    return np.where(beyond, side - 1 - column, column), np.clip(row, 0, side - 1)


def _write(path: Path, pixels: Picture, where: str) -> None:
    height, width = pixels.shape[:2]
    output = oiio.ImageOutput.create(str(path))
    if (
        output is None
        or not output.open(str(path), oiio.ImageSpec(width, height, 3, oiio.FLOAT))
        or not output.write_image(np.ascontiguousarray(pixels))
        or not output.close()
    ):
        raise SourceError(f"{where}: the picture cannot be written: {oiio.geterror()}")
