"""Spectra as red, green and blue: linear Rec. 709, by the CIE 1931 observer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from woodcock.importing.transforms import Array

Colour = float | list[float]

_WAVELENGTHS = np.arange(360.0, 831.0)
_FROM_XYZ = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)


def _observer() -> Array:
    """x̄, ȳ and z̄ (3, n): the fits of Wyman, Sloan & Shirley (2013), Simple Analytic Approximations to the CIE XYZ
    Color Matching Functions, multi-lobe; normalised to ∫ȳ = 1."""

    def lobe(height: float, middle: float, below: float, above: float) -> Array:
        offset = (_WAVELENGTHS - middle) * np.where(middle > _WAVELENGTHS, below, above)
        return np.asarray(height * np.exp(-0.5 * offset**2))

    x = lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(-0.065, 501.1, 0.0490, 0.0382)
    y = lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322)
    z = lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725)
    return np.asarray(np.array([x, y, z]) / y.sum())


_OBSERVER = _observer()


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
    spectrum = np.interp(_WAVELENGTHS, np.asarray(wavelengths)[order], np.asarray(values)[order])
    rgb = _FROM_XYZ @ _OBSERVER @ spectrum
    return simple(np.maximum(rgb if emitted else rgb / _FROM_XYZ.sum(axis=1), 0.0))


def blackbody(kelvin: Any) -> Array:
    """(..., 3) of Planck's law at temperatures in kelvin, its peak brought to 1; what Rec. 709 cannot show is 0."""
    metres = _WAVELENGTHS * 1e-9
    temperature = np.maximum(np.asarray(kelvin, float), 1.0)[..., None]
    # hc / k, and Wien's law for the peak
    exponent = 1.438776877e-2 / (metres * temperature)
    peak = 2.897771955e-3 / temperature
    at_peak = 1.438776877e-2 / 2.897771955e-3
    spectrum = (peak / metres) ** 5 * np.expm1(at_peak) / np.expm1(np.minimum(exponent, 700.0))
    return np.asarray(np.maximum(spectrum @ (_FROM_XYZ @ _OBSERVER).T, 0.0))


def luminance(rgb: Array) -> float:
    return float(rgb @ np.array([0.2126729, 0.7151522, 0.0721750]))


def from_srgb(code: int) -> float:
    """Linear value of an 8-bit sRGB code (IEC 61966-2-1)."""
    value = code / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
