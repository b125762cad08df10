"""The files that the scenes of references name, made anew where they are needed: a sky, grids, a mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from numpy.typing import NDArray

Array = NDArray[np.float64]

HEIGHT = 512
LOBES = (((0.6, 0.5, -0.62), 6, (3, 2, 1)), ((-0.8, -0.1, 0.59), 3, (0.3, 0.8, 2)))
#: A closed body without symmetries, its faces counter-clockwise seen from outside.
CORNERS = ((1.1, 0.1, 0), (-0.9, 0, 0.2), (0, 1.2, 0.1), (0.2, -0.9, 0), (0, 0.1, 1), (-0.1, 0, -0.8))
FACES = ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5))


def radiance(direction: Array) -> Array:
    """Of a smooth sky, (..., 3)."""
    total = np.full((*direction.shape[:-1], 3), 0.1)
    for axis, sharpness, colour in LOBES:
        unit = np.array(axis) / np.linalg.norm(axis)
        total += np.exp(sharpness * (direction @ unit - 1))[..., None] * np.array(colour)
    return total


def sky(theta: Array) -> NDArray[np.float32]:
    """The sky as a picture with rows at the angles theta from +y; -z lies in the middle, +x to the right of it."""
    longitude = 2 * np.pi * ((np.arange(2 * HEIGHT) + 0.5) / (2 * HEIGHT) - 0.5)
    x, z = np.outer(np.sin(theta), np.sin(longitude)), -np.outer(np.sin(theta), np.cos(longitude))
    y = np.broadcast_to(np.cos(theta)[:, None], x.shape)
    return radiance(np.stack([x, y, z], axis=-1)).astype(np.float32)


def middles() -> Array:
    """Rows that stand for bands of latitude; Mitsuba's stand for circles, the first and the last for the poles."""
    return np.asarray((np.arange(HEIGHT) + 0.5) * np.pi / HEIGHT)


def density() -> NDArray[np.float32]:
    """[z][y][x], from .1 to 1."""
    return np.random.default_rng(20).uniform(0.1, 1, (5, 4, 6)).astype(np.float32)


def colours() -> NDArray[np.float32]:
    """[z][y][x][3], from .3 to 1."""
    return np.random.default_rng(21).uniform(0.3, 1, (3, 4, 2, 3)).astype(np.float32)


def write(folder: Path) -> None:
    """Writes sky.exr, density.npy, colours.npy and body.ply."""
    np.save(folder / "density.npy", density())
    np.save(folder / "colours.npy", colours())
    lines = ["ply", "format ascii 1.0", f"element vertex {len(CORNERS)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {len(FACES)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(str, corner)) for corner in CORNERS]
    lines += [" ".join(map(str, (3, *face))) for face in FACES]
    (folder / "body.ply").write_text("\n".join(lines) + "\n")
    write_picture(
        folder / "sky.exr", {"R": sky(middles())[..., 0], "G": sky(middles())[..., 1], "B": sky(middles())[..., 2]}
    )


def write_picture(path: Path, channels: dict[str, NDArray[np.float32]], half: str = "", **header: str) -> None:
    """An EXR; channels whose names begin with `half`, if that is not empty, become half floats."""
    height, width = next(iter(channels.values())).shape
    spec = oiio.ImageSpec(width, height, len(channels), oiio.FLOAT)
    spec.channelnames = tuple(channels)
    if half:
        spec.channelformats = tuple(oiio.HALF if name.startswith(half) else oiio.FLOAT for name in channels)
    spec.attribute("compression", "zip")
    for name, value in header.items():
        spec.attribute(f"woodcock:{name}", value)
    image = oiio.ImageOutput.create(str(path))
    pixels = np.ascontiguousarray(np.stack(list(channels.values()), axis=-1), np.float32)
    if not (image and image.open(str(path), spec) and image.write_image(pixels) and image.close()):
        raise OSError(f"{path}: {oiio.geterror()}")
