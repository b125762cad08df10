"""Thermal emission, ε = σ_a B(T) (Kirchhoff): Planck's law seen by the CIE 1931 observer, in linear Rec. 709.

The observer is the analytic fit of C. Wyman, P.-P. Sloan and P. Shirley, "Simple analytic approximations to the CIE XYZ
color matching functions", JCGT 2(2), 2013. What lies outside Rec. 709, the blue of embers, is cut off at 0.
"""

from __future__ import annotations

import numpy as np

from woodcock.scene import BlackbodyEmission
from woodcock.space import Array, Space

FIELDS = {"relative": "float", "coldest": "float", "per_entry": "float", "entries": "int"}

#: Nanometres; trapezoids of two are right to 1e-5.
WAVELENGTHS = np.arange(360.0, 831.0, 2.0)
#: h c / k, in nanometre kelvin.
SECOND_CONSTANT = 1.438776877e7

# Of each lobe: weight, middle, width below and above it, in nanometres.
_LOBES = (
    ((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
    ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
    ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)),
)
_REC709 = np.array(
    [
        [3.2404541621141054, -1.5371385127977166, -0.4985314095560162],
        [-0.9692660305051868, 1.8760108454466942, 0.0415560175303498],
        [0.0556434309591147, -0.2040259135167538, 1.0572251882231791],
    ]
)
#: What is this much fainter than the hottest is nothing.
_FAINTEST = 1e-20
#: Of the table's interpolation: relative to the brightest channel, plus a part of the hottest.
_TABLE_ERROR, _DARK = 4e-5, 1e-8
_MOST_ENTRIES = 1 << 16


def observer(wavelengths: Array) -> Array:
    """(..., 3): x̄, ȳ, z̄ at wavelengths in nanometres."""

    def lobe(weight: float, middle: float, below: float, above: float) -> Array:
        width = np.where(wavelengths < middle, below, above)
        return np.asarray(weight * np.exp(-(((wavelengths - middle) / width) ** 2) / 2))

    return np.stack([sum((lobe(*numbers) for numbers in lobes), np.zeros(())) for lobes in _LOBES], axis=-1)


def tristimulus(kelvin: Array) -> Array:
    """(..., 3): X, Y, Z of Planck's radiance at temperatures > 0, by one common factor.

    Past 830 nm and 360 nm the observer is blind. exp(-x) / (1 - exp(-x)) for 1 / (exp(x) - 1), which overflows.
    """
    x = SECOND_CONSTANT / (WAVELENGTHS * np.asarray(kelvin, np.float64)[..., None])
    width = np.gradient(WAVELENGTHS) * np.where((WAVELENGTHS == 360) | (WAVELENGTHS == 830), 0.5, 1)
    weights = observer(WAVELENGTHS) * (width / (WAVELENGTHS / 560) ** 5)[:, None]
    return np.asarray(np.exp(-x) / -np.expm1(-x) @ weights)


def radiance(emission: BlackbodyEmission, kelvin: Array) -> Array:
    """Float64 oracle: B(T), (..., 3), in the scene's radiance; 0 at 0 K."""
    kelvin = np.asarray(kelvin, np.float64)
    xyz = np.where(kelvin[..., None] > 0, tristimulus(np.maximum(kelvin, 1.0)), 0.0)
    reference = tristimulus(np.array(emission.reference))[1]
    return np.asarray(np.maximum(xyz @ _REC709.T, 0) / reference * np.array(emission.luminance))


def record(emission: BlackbodyEmission, largest: float, step: float, table: Array) -> dict[str, float | int]:
    """largest: value of the grid; step: what a stored number is multiplied by to give the value; table: of `table`."""
    coldest = _coldest(emission.kelvin * largest)
    return {
        "relative": step / largest if largest > 0 else 0.0,
        "coldest": coldest,
        "per_entry": (len(table) - 1) / (1 / coldest - 1),
        "entries": len(table),
    }


def table(emission: BlackbodyEmission, largest: float, space: Space) -> Array:
    """(n, 3): B, in the device's radiance, at n temperatures from the largest of the grid down, even in 1 / T."""
    hottest = emission.kelvin * largest
    if hottest <= 0:
        return np.zeros((2, 3))
    inverse = 1 / _coldest(hottest)
    entries = 2048
    while True:
        # Every other one of twice as many: the rest are the middles that interpolation must meet.
        fine = radiance(emission, hottest / np.linspace(1, inverse, 2 * entries - 1))
        middles, brightest = (fine[:-2:2] + fine[2::2]) / 2, fine[1::2].max(axis=-1, keepdims=True)
        allowed = _TABLE_ERROR * brightest + _DARK * fine.max()
        if np.all(np.abs(middles - fine[1::2]) <= allowed) or entries >= _MOST_ENTRIES:
            coarse = fine[::2].copy()
            coarse[-1] = 0
            return np.asarray(space.radiance(coarse))
        entries *= 2


def _coldest(hottest: float) -> float:
    """The temperature, as a part of the hottest, whose luminance is _FAINTEST of its."""
    parts = 1 / np.linspace(1, 1000, 4096)
    if hottest <= 0:
        return 0.5
    luminance = tristimulus(np.maximum(hottest * parts, 1e-3))[:, 1]
    faint = luminance <= _FAINTEST * luminance[0]
    return float(parts[np.argmax(faint)]) if faint.any() else float(parts[-1])
