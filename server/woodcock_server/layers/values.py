"""Which layers a picture has, and what they hold in a rectangle of it."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from woodcock_server.layers.pictures import Picture
from woodcock_server.layers.schemas import Layer, LayerValues

BEAUTY = "beauty"
#: In which order layers are told; those that are not here come after the orders of scattering.
_FIRST, _LAST = (BEAUTY, "denoised", "order"), ("variance", "bound", "samples")
_UNITS = {"variance": "radiance²", "depth": "length", "position": "length", "samples": "samples"}
_RADIANCE = {BEAUTY, "denoised", "order", "bound"}


def layers_of(picture: Picture) -> dict[str, list[str]]:
    """Names of layers, in the order in which they are told, and of each its channels as the EXR has them."""
    found: dict[str, list[str]] = {}
    for name in picture.names:
        found.setdefault(name.rpartition(".")[0] or BEAUTY, []).append(name)
    return dict(sorted(found.items(), key=lambda item: _place(item[0])))


def described(picture: Picture, path: str) -> list[Layer]:
    """path: under which a layer is found by its name."""
    return [
        Layer.model_validate(
            {"name": name, "channels": _suffixes(channels), "unit": unit_of(name), "link": f"{path}/{name}"}
        )
        for name, channels in layers_of(picture).items()
    ]


def unit_of(layer: str) -> str:
    kind = layer.partition(".")[0]
    return "radiance" if kind in _RADIANCE else _UNITS.get(kind, "")


def values_in(picture: Picture, x: int, y: int, width: int, height: int) -> list[LayerValues]:
    """Blocks. Raises ImageError."""
    sums = dict.fromkeys(picture.names, 0.0)
    with np.errstate(invalid="ignore"):  # ∞ - ∞ is not a number, as it should be
        for strip in picture.strips(y, y + height):
            for name, rows in strip.items():
                sums[name] += float(rows[:, x : x + width].sum(dtype=np.float64))
    pixels = width * height
    return [LayerValues.model_validate(each) for each in _told(layers_of(picture), sums, pixels)]


def _told(layers: dict[str, list[str]], sums: dict[str, float], pixels: int) -> Iterator[dict[str, object]]:
    for name, channels in layers.items():
        variances = [sums.get(f"variance.{channel}") for channel in channels]
        known = [each for each in variances if each is not None]
        yield {
            "name": name,
            "channels": _suffixes(channels),
            "unit": unit_of(name),
            "values": [sums[channel] / pixels for channel in channels],
            "errors": [float(np.sqrt(each)) / pixels for each in known] if len(known) == len(channels) else None,
        }


def layer(picture: Picture, name: str) -> NDArray[np.float32] | None:
    """(height, width, channels), None if there is no such layer; blocks. Raises ImageError."""
    channels = layers_of(picture).get(name)
    return None if channels is None else picture.channels(channels)


def _suffixes(channels: list[str]) -> list[str]:
    return [channel.rpartition(".")[2] for channel in channels]


def _place(layer: str) -> tuple[int, list[tuple[int, str]]]:
    kind = layer.partition(".")[0]
    among = _FIRST.index(kind) if kind in _FIRST else len(_FIRST)
    among += 1 + _LAST.index(kind) if kind in _LAST else 0
    # Numbers by their size: order 10 comes after order 9.
    return among, [(int(part), "") if part.isdecimal() else (1 << 30, part) for part in re.split(r"\.", layer)]
