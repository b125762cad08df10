"""What a film, or a comparison with a reference, looks like: pictures as data URIs, and the scales of false colour."""

from __future__ import annotations

import base64
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from numpy.typing import NDArray

from woodcock.image import ImageError
from woodcock.space import Array

#: Longest side of a picture on a page, pixels.
LARGEST = 1024


def _colours(digits: str) -> Array:
    values = [int(digits[at : at + 2], 16) for at in range(0, len(digits), 2)]
    return np.array(values, float).reshape(-1, 3) / 255


#: viridis (van der Walt & Smith 2015) and the diverging RdBu (Brewer 1994), turned round: sRGB at equal steps.
SEQUENTIAL = _colours(
    "44015448186a472d7b4240863b528b33638d2c728e26828e21918c1fa08828ae803fbc735ec96284d44baddc30d8e219fde725"
)
DIVERGING = _colours("0530612065ab4393c390c4ddd1e5f0f7f6f6fddbc7f3a481d6604db1182b67001f")


@dataclass(frozen=True)
class Scale:
    """False colour of numbers in [low, high]. unit: of the numbers; logarithmic: equal ratios are equal steps."""

    low: float
    high: float
    unit: str
    logarithmic: bool = False
    diverging: bool = False

    def colours(self, values: Array) -> Array:
        """(height, width) -> sRGB (height, width, 3); what lies outside has the colour of the nearer end."""
        known = np.clip(np.nan_to_num(values, nan=self.low, posinf=self.high, neginf=self.low), self.low, self.high)
        low, high = (math.log(self.low), math.log(self.high)) if self.logarithmic else (self.low, self.high)
        share = ((np.log(known) if self.logarithmic else known) - low) / (high - low)
        return self._mixed(share)

    def ramp(self, steps: int) -> Array:
        """(steps, 3) from low to high."""
        return self._mixed((np.arange(steps) + 0.5) / steps)

    def _mixed(self, share: Array) -> Array:
        palette = DIVERGING if self.diverging else SEQUENTIAL
        steps = np.linspace(0, 1, len(palette))
        return np.stack([np.interp(share, steps, palette[:, channel]) for channel in range(3)], axis=-1)


def decades(values: Array, unit: str) -> Scale | None:
    """A logarithmic scale for what is 0 or more: from the first to the 99.9th percentile of what is more, between one
    and four decades. None where all is 0."""
    positive = values[np.isfinite(values) & (values > 0)]
    if not positive.size:
        return None
    low, high = (float(each) for each in np.percentile(positive, (1, 99.9)))
    high = max(high, float(np.finfo(np.float32).tiny))
    return Scale(min(max(low, high / 1e4), high / 10), high, unit, logarithmic=True)


def both_ways(values: Array, unit: str) -> Scale | None:
    """A scale around 0, to the 99th percentile of the size. None where all is 0."""
    sizes = np.abs(values[np.isfinite(values)])
    most = float(np.percentile(sizes, 99)) or float(sizes.max(initial=0.0))
    return Scale(-most, most, unit, diverging=True) if most > 0 else None


def data_uri(srgb: NDArray[np.floating]) -> str:
    """A PNG of sRGB (height, width, 3) in [0, 1]. Raises ImageError."""
    image = oiio.ImageBuf(np.ascontiguousarray(srgb, np.float32))
    image.set_write_format("uint8")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        if not image.write(str(path)):
            raise ImageError(f"a picture of a page could not be encoded: {image.geterror()}")
        return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()


def shrunk(values: NDArray[np.floating], largest: int = LARGEST) -> NDArray[np.float32]:
    """(height, width, channels) made smaller until its longest side is `largest`, by means over areas."""
    height, width = values.shape[:2]
    pixels = np.ascontiguousarray(values, np.float32)
    if max(height, width) <= largest:
        return pixels
    scale = largest / max(height, width)
    size = oiio.ROI(0, max(1, round(width * scale)), 0, max(1, round(height * scale)), 0, 1, 0, values.shape[2])
    image = oiio.ImageBufAlgo.resize(oiio.ImageBuf(pixels), "box", 0, roi=size)
    return np.asarray(image.get_pixels(oiio.FLOAT)).reshape(size.height, size.width, values.shape[2])
