"""Files that scenes name, small, as bytes."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name

#: A cube from -1 to 1: eight corners, six squares.
CUBE = (
    b"v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    b"f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 2 3 7 6\nf 1 5 8 4\n"
)
#: The same without its last side.
OPEN = CUBE.rsplit(b"f ", 1)[0]


def npy(values: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.asarray(values, np.float32))
    return stream.getvalue()


def npz(**grids: Any) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **{name: np.asarray(values, np.float32) for name, values in grids.items()})
    return stream.getvalue()


def exr(pixels: Any) -> bytes:
    """Of (height, width, 3)."""
    array = np.ascontiguousarray(pixels, np.float32)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.exr"
        image = oiio.ImageOutput.create(str(path))
        image.open(str(path), oiio.ImageSpec(array.shape[1], array.shape[0], 3, oiio.FLOAT))
        image.write_image(array)
        image.close()
        return path.read_bytes()


def fire(size: int = 6) -> bytes:
    """Grids `density`, `temperature` and `tint`."""
    ramp = np.linspace(0.2, 1, size**3).reshape(size, size, size)
    return npz(density=ramp, temperature=ramp[::-1], tint=np.stack([ramp, 1 - ramp, ramp * 0], axis=-1))
