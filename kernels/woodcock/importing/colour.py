"""Spectra as red, green and blue: linear Rec. 709, by the CIE 1931 observer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from woodcock.emission.blackbody import SECOND_CONSTANT, observer
from woodcock.importing.transforms import Array

Colour = float | list[float]

#: Nanometres.
WAVELENGTHS = np.arange(360.0, 831.0)
#: Wien's, nanometre kelvin.
DISPLACEMENT = 2.897771955e6
_FROM_XYZ = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)


#: (3, n), normalised to ∫ȳ = 1.
_OBSERVER = observer(WAVELENGTHS).T / observer(WAVELENGTHS)[:, 1].sum()


def simple(rgb: Sequence[float] | Array) -> Colour:
    """One number where all three are the same."""
    red, green, blue = (float(value) for value in rgb)
    return red if red == green == blue else [red, green, blue]


def triple(colour: Colour) -> Array:
    return np.broadcast_to(np.asarray(colour, float), (3,)).copy()


def of_samples(wavelengths: Sequence[float], values: Sequence[float], emitted: bool) -> Colour:
    """A spectrum given at wavelengths in nanometres, linear between.

    An even spectrum is grey where it says how much is reflected, absorbed or scattered. As light it is equal-energy
    white, which Rec. 709 with its D65 white shows as reddish.
    """
    if len(set(values)) == 1:
        return simple(values[0] * _FROM_XYZ.sum(axis=1)) if emitted else float(values[0])
    order = np.argsort(wavelengths)
    spectrum = np.interp(WAVELENGTHS, np.asarray(wavelengths)[order], np.asarray(values)[order])
    rgb = _FROM_XYZ @ _OBSERVER @ spectrum
    return simple(np.maximum(rgb if emitted else rgb / _FROM_XYZ.sum(axis=1), 0.0))


def blackbody(kelvin: Any) -> Array:
    """(..., 3) of Planck's law at temperatures in kelvin, its peak brought to 1; what Rec. 709 cannot show is 0."""
    temperature = np.maximum(np.asarray(kelvin, float), 1.0)[..., None]
    exponent = np.minimum(SECOND_CONSTANT / (WAVELENGTHS * temperature), 700.0)
    at_peak = np.expm1(SECOND_CONSTANT / DISPLACEMENT)
    spectrum = (DISPLACEMENT / (WAVELENGTHS * temperature)) ** 5 * at_peak / np.expm1(exponent)
    return np.asarray(np.maximum(spectrum @ (_FROM_XYZ @ _OBSERVER).T, 0.0))


def luminance(rgb: Array) -> float:
    return float(rgb @ np.array([0.2126729, 0.7151522, 0.0721750]))


def from_srgb(code: int) -> float:
    """Linear value of an 8-bit sRGB code (IEC 61966-2-1)."""
    value = code / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
