"""How far a picture is from a reference: plain functions of arrays.

Both are (height, width, 1 or 3), linear and in one unit; channels are weighted by luminance, as in `Film.rmse`.
variance: of the reference's own pixels, where it is known. Squares of errors hold it too, on average: it is subtracted.
"""

from __future__ import annotations

import math

import numpy as np

from woodcock import flip as evaluator
from woodcock.film import weights
from woodcock.space import Array

#: ε of relative errors squared, over the squared mean luminance: below a tenth of the mean, errors count as there.
EPSILON = 0.01
#: Seconds of FLIP for a pixel and an exposure, on one common core: to decide whether there is time for it.
FLIP_SECONDS = 2e-6
#: log2 of what the tone mapper of FLIP (ACES) takes for .85 of white: its first exposure brings the maximum there.
_FIRST_STOP = 1.0832972526550293


def mse(picture: Array, reference: Array, variance: Array | None = None) -> float:
    """Mean square error, radiance²: mean (I - R)² - mean variance, and 0 at least."""
    return _without(_mean((picture - reference) ** 2), variance)


def rel_mse(picture: Array, reference: Array, variance: Array | None = None) -> float:
    """Relative mean square error: mean (I - R)² / (R² + ε), the variance over the same subtracted, and 0 at least.

    ε = 0.01 × (mean luminance of R)², so that the unit of radiance does not matter, where Rousselle, Knaus & Zwicker
    (2011) have a constant. 0 / 0 = 0; huge where only the reference is black.
    """
    over = reference**2 + epsilon(reference)
    squares = _mean(relative_squares(picture, reference))
    return _without(squares, None if variance is None else _share(variance, over))


def relative_squares(picture: Array, reference: Array) -> Array:
    """(I - R)² / (R² + ε) of every channel of every pixel, whose mean is `rel_mse` without a variance."""
    return _share((picture - reference) ** 2, reference**2 + epsilon(reference))


def estimated_rel_mse(picture: Array, variance: Array) -> float:
    """Relative mean square error by the picture's own variances: mean variance / (I² + ε), with ε of the picture.

    I stands for its expectation, so that the estimate is off by a share of about its own size: of a pixel with relative
    variance x, by x (3 - 2 skewness / coefficient of variation) of it, to first order. It is good to 1 % below some
    0.003, and the order of magnitude up to 0.3. Of no pixel is it above 1, as the variance of a mean of samples that
    are not negative is not above its square: fireflies count for too little. 0 / 0 = 0.
    """
    return _mean(_share(variance, picture**2 + epsilon(picture)))


def smape(picture: Array, reference: Array) -> float:
    """Symmetric mean absolute percentage error, as a share: mean |I - R| / (|I| + |R|), 0 to 1, with 0 / 0 = 0.

    Makridakis (1993). The reference's noise adds to it, and cannot be subtracted.
    """
    return _mean(symmetric_errors(picture, reference))


def symmetric_errors(picture: Array, reference: Array) -> Array:
    """|I - R| / (|I| + |R|) of every channel of every pixel."""
    return _share(np.abs(picture - reference), np.abs(picture) + np.abs(reference))


def bias(picture: Array, reference: Array) -> float:
    """Mean luminance of I - R, radiance: of noise alone, 0 within its standard error."""
    return _mean(picture - reference)


def bias_error(*variances: Array) -> float:
    """Standard error of the bias by the variances of both pictures' pixels: √Σ (Σ_channels weight √variance)² / pixels.

    Channels of a pixel share their paths, so that their errors add: at most this.
    """
    squares = [(np.sqrt(one) @ weights(one.shape[-1])) ** 2 for one in variances]
    return math.sqrt(sum(float(np.sum(one)) for one in squares)) / squares[0].size


def flip(picture: Array, reference: Array) -> float | None:
    """Mean HDR-ꟻLIP, 0 to 1: how far an observer sees two pictures differ who flips between them.

    Andersson et al. (2021), by NVIDIA's flip-evaluator, at 67 pixels a degree. Radiance is linear Rec. 709 of any unit:
    the exposures go, a stop apart, from where the reference's maximum is white to where its median is (that of the
    pixels that are not black, where most are); of every pixel the largest error counts. Negative radiance counts as 0.
    None where the package is not installed, or the reference is black.
    """
    errors = flip_errors(picture, reference)
    return None if errors is None else float(errors.mean(dtype=np.float64))


def flip_errors(picture: Array, reference: Array) -> Array | None:
    """HDR-ꟻLIP of every pixel, (height, width, 1)."""
    stops = flip_stops(reference)
    if stops is None:
        return None
    white = float(_luminance(reference).max())
    shown = [np.clip(np.broadcast_to(one / white, (*one.shape[:2], 3)), 0, 1e6) for one in (reference, picture)]
    exposures = {"startExposure": _FIRST_STOP, "stopExposure": _FIRST_STOP + stops, "numExposures": _exposures(stops)}
    return evaluator.errors(shown, exposures, flip_seconds(reference))


def flip_seconds(reference: Array) -> float:
    """How long `flip` may take, roughly; 0 where it has no answer."""
    stops = flip_stops(reference)
    return 0.0 if stops is None else FLIP_SECONDS * _exposures(stops) * reference.shape[0] * reference.shape[1]


def flip_stops(reference: Array) -> float | None:
    """Stops from the maximum of a picture's luminance down to its median; None of a black one."""
    luminance = _luminance(reference)
    if not luminance.max() > 0:
        return None
    middle = float(np.median(luminance))
    if not middle > 0:
        middle = float(np.median(luminance[luminance > 0]))
    return float(np.log2(luminance.max() / middle))


def epsilon(picture: Array) -> float:
    """What is added to the squares that relative errors are over, radiance²."""
    return EPSILON * _mean(picture) ** 2


def noise(variance: Array) -> float:
    """Mean variance of a picture's pixels, radiance²: what it adds to a mean square error against it."""
    return _mean(variance)


def _exposures(stops: float) -> int:
    return max(2, math.ceil(stops))


def _luminance(picture: Array) -> Array:
    return np.asarray(picture @ weights(picture.shape[-1]))


def _share(value: Array, of: Array) -> Array:
    """Quotients, with 0 / 0 = 0; what is over 0 is huge."""
    with np.errstate(over="ignore"):
        return np.asarray(value / np.maximum(of, np.finfo(np.float64).tiny))


def _mean(values: Array) -> float:
    """Over pixels, channels weighted by luminance."""
    return float(values.mean(axis=(0, 1)) @ weights(values.shape[-1]))


def _without(square: float, variance: Array | None) -> float:
    return square if variance is None else max(square - noise(variance), 0.0)
