"""The layers of pictures as the API shows them."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator


class Layer(BaseModel):
    """A layer of a picture. channels: in their order; unit: that the scene's author chose, empty for plain numbers."""

    name: str
    channels: list[str]
    unit: Literal["radiance", "radiance²", "length", "samples", ""]
    link: str


class LayerList(BaseModel):
    """samples: of a pixel that has all of them; it grows while the job is rendered."""

    width: int
    height: int
    samples: int
    layers: list[Layer]


def _told(value: float) -> float | str:
    if math.isfinite(value):
        return value
    return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"


#: JSON has no other numbers than finite ones; the words for these are understood by what reads numbers from text.
Value = Annotated[float | Literal["NaN", "Infinity", "-Infinity"], BeforeValidator(_told)]


class LayerValues(BaseModel):
    """values: of each channel, the mean over the pixels, each counting the same; errors: their estimated standard
    errors, the root of the sum of the pixels' variances over the number of pixels, for pixels share no samples. Null
    where no variance was measured, NaN where a pixel has fewer than two samples."""

    name: str
    channels: list[str]
    unit: str
    values: list[Value]
    errors: list[Value] | None


class Pixels(BaseModel):
    """What the layers hold in a rectangle of pixels, whose upper left one is (x, y). One pixel has its very values, as
    the EXR has them. samples: of the picture."""

    x: int
    y: int
    width: int
    height: int
    samples: int
    layers: list[LayerValues]
