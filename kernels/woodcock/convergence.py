"""How fast a render's error falls: the slope of log error over log time, its band, and whether it is as it should be.

Points of a series share their samples, so that they are correlated, and an ordinary band is far too narrow. With n
independent samples a pixel, of finite fourth moment, the covariance of the errors' logarithms is known up to a factor:

- estimated, log s² / n: s² is an average, (2 + κ) / max(n, n′) for samples of excess kurtosis κ;
- true, log (mean - truth)²: 2 min(n, n′) / max(n, n′) + κ / max(n, n′).

Lines are fitted by generalised least squares with these; the factor is that of the residuals. How evenly a device works
is an average over samples too, and has the same shape: the band of a slope over seconds has it in its factor, but not
a drift of its speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple, TypedDict

import numpy as np

from woodcock.regression import Line, fit, quantile
from woodcock.space import Array

if TYPE_CHECKING:
    from woodcock.series import Point

#: Of independent samples with a variance.
EXPECTED = -0.5
#: Probability that the band misses the slope.
BAND = 0.05
#: Probability that chance alone flags a series by its slope, or by its excess.
FLAG = 1e-4
#: A slope that is off by less than this is not flagged, nor an excess of this share of the mean square error.
MOST_OFF, MOST_EXCESS = 0.05, 0.2
#: Half a band, at most, of a slope that is known: it tells -1/2 from -1/3, that of a tail of index 3/2.
WIDEST = 1 / 6
#: After so many points, an estimated mean square error that is still uncertain by this share of it has a heavy tail.
STEADY_POINTS, UNSTEADY = 10, 0.15

Verdict = Literal["as expected", "flagged", "not known"]


class Fit(TypedDict):
    """A slope, its 95 % band, and the number of points it is through."""

    slope: float
    low: float
    high: float
    points: int


class Slope(TypedDict):
    """d log rmse / d log device seconds and its 95 % band, through so many points: None for fewer than three.

    verdict: of how the error falls with samples, which the speed of devices does not change; says: why.
    against: the slope of the true error √mse, over points where it exceeds the reference's noise.
    """

    slope: float | None
    low: float | None
    high: float | None
    expected: float
    points: int
    verdict: Verdict
    says: str
    against: Fit | None


class Curve(NamedTuple):
    """Mean square errors after so many samples and seconds; shape: of the covariance of their logarithms."""

    samples: Array
    seconds: Array
    squares: Array
    shape: Array

    def over(self, x: Array) -> Line:
        return fit(np.log(x), np.log(self.squares), self.shape)


def slope(series: Sequence[Point], *, uniform: bool = True) -> Slope:
    """uniform: every pixel has as many samples as any other. Otherwise there is no slope to expect."""
    estimated = _estimated(series)
    if estimated is None:
        return _slope(None, "not known", "It takes three points to know how the error falls.", None)
    true = _true(series, estimated)
    said: tuple[Verdict, str]
    if not uniform:
        said = "not known", "Pixels have as many samples as they need: there is no slope to expect."
    else:
        said = _bias(estimated, true) or _heavy_tail(estimated) or _as_expected(estimated)
    return _slope(_fitted(estimated), *said, None if true is None else _fitted(true))


def _slope(found: Fit | None, verdict: Verdict, says: str, true: Fit | None) -> Slope:
    return {
        "slope": found and found["slope"],
        "low": found and found["low"],
        "high": found and found["high"],
        "expected": EXPECTED,
        "points": found["points"] if found else 0,
        "verdict": verdict,
        "says": says,
        "against": true,
    }


def _fitted(curve: Curve) -> Fit:
    """Over seconds, of the root mean square error."""
    line = curve.over(curve.seconds)
    middle, half = line.slope / 2, quantile(BAND, line.freedom) * line.error / 2
    return {"slope": middle, "low": middle - half, "high": middle + half, "points": len(curve.samples)}


def _bias(estimated: Curve, true: Curve | None) -> tuple[Verdict, str] | None:
    """More error than the samples know of, at the end or by how slowly it falls."""
    if true is None:
        return None
    line, own = true.over(true.samples), estimated.over(estimated.samples)
    at = int(np.searchsorted(estimated.samples, true.samples[-1]))
    excess = math.log(true.squares[-1] / estimated.squares[at])
    # As if samples were normal too: a kurtosis that is taken for too large makes the factor too small.
    factor = max(line.scale, true._replace(shape=_drifting(true.samples)).over(true.samples).scale)
    error = math.hypot(factor, own.scale * math.sqrt(estimated.shape[at, at]))
    more = excess > max(math.log1p(MOST_EXCESS), quantile(FLAG, line.freedom) * error)
    if not (more or _off(line) > 0):
        return None
    return "flagged", (
        f"Bias: the true error falls with the samples to the power {line.slope / 2:.2f}, and at the end is "
        f"{math.exp(excess / 2):.2f} times what the samples tell: something is wrong, or rarely found, or the "
        "reference is off by more than it says."
    )


def _heavy_tail(curve: Curve) -> tuple[Verdict, str] | None:
    """An estimated error that falls at another pace than the variance of a mean, or does not settle."""
    line = curve.over(curve.samples)
    unsteady = line.scale / math.sqrt(curve.samples[-1])
    if len(curve.samples) >= STEADY_POINTS and unsteady > UNSTEADY:
        return "flagged", (
            f"Heavy tail: a few samples outweigh the rest, and the error itself is known to {50 * unsteady:.0f} % only."
        )
    if _off(line):
        return "flagged", (
            f"Heavy tail: the error falls with the samples to the power {line.slope / 2:.2f}, because a few of them "
            "outweigh the rest."
        )
    return None


def _off(line: Line) -> float:
    """How far the slope of an error is from the expected one, 0 where that may be chance or does not matter."""
    off = line.slope / 2 - EXPECTED
    return off if abs(off) > max(MOST_OFF, quantile(FLAG, line.freedom) * line.error / 2) else 0.0


def _as_expected(curve: Curve) -> tuple[Verdict, str]:
    line = curve.over(curve.samples)
    half = quantile(BAND, line.freedom) * line.error / 2
    found = f"{line.slope / 2:.3f} ± {half:.3f}"
    if half > WIDEST:
        return (
            "not known",
            f"The error falls with the samples to the power {found}: the series is too short to tell more.",
        )
    text = f"The error falls with the samples to the power {found}, as that of independent samples does."
    over_time = curve.over(curve.seconds).slope / 2
    if abs(over_time - EXPECTED) > MOST_OFF:
        text += f" Over time the power is {over_time:.2f}, because devices did not work at one speed."
    return "as expected", text


# Curves and the shapes of their covariances


def _estimated(series: Sequence[Point]) -> Curve | None:
    points = _kept([(one["samples"], one["device_seconds"], one["rmse"] ** 2) for one in series])
    return None if points is None else Curve(*points, _averaging(points[0]))


def _true(series: Sequence[Point], estimated: Curve) -> Curve | None:
    """Over points where it exceeds the reference's own noise, of which no more is known than that it is subtracted.

    The kurtosis follows from the factors: over N pixels (2 + κ) / N of the estimated error, 2 / N of the true one.
    """
    pairs = [(one, one["against"]) for one in series]
    points = _kept(
        [(p["samples"], p["device_seconds"], a["mse"]) for p, a in pairs if a and a["mse"] > (a["reference_mse"] or 0)]
    )
    if points is None:
        return None
    curve = Curve(*points, _drifting(points[0]))
    factor = estimated.over(estimated.samples).scale
    for _ in range(4):
        own = curve.over(curve.samples).scale
        excess = max((factor / own) ** 2 - 1, 0.0) if own > 0 else 0.0
        curve = curve._replace(shape=_drifting(curve.samples) + excess * _averaging(curve.samples))
    return curve


def _kept(points: Sequence[tuple[float, float, float]]) -> tuple[Array, Array, Array] | None:
    """Of points (samples, seconds, square error) those that add samples and have an error; None for fewer than 3."""
    kept: list[tuple[float, float, float]] = []
    for point in points:
        if min(point) > 0 and (not kept or (point[0] > kept[-1][0] and point[1] > kept[-1][1])):
            kept.append(point)
    if len(kept) < 3:
        return None
    samples, seconds, squares = np.array(kept).T
    return samples, seconds, squares


def _averaging(samples: Array) -> Array:
    """Of averages over so many samples, the later ones over the earlier ones' too."""
    return np.asarray(1 / np.maximum.outer(samples, samples))


def _drifting(samples: Array) -> Array:
    """Of squared deviations of such averages, relative to their means."""
    return np.asarray(np.minimum.outer(samples, samples) / np.maximum.outer(samples, samples))
