"""How a picture is held against the exact answer."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from woodcock.certificate import MOST_DRIFT
from woodcock.drift import Drift
from woodcock.film import Film
from woodcock.space import Array
from woodcock.stability.outcome import Unit, Verdict

#: Of a deviation in standard errors. A normal variable exceeds it with probability 2e-7, so that one of MOST_RANDOM
#: cases does with 1e-4. Seeds are fixed: on one device the outcome is always the same.
LIMIT = 5.2
MOST_RANDOM = 500

#: Roundings that a mean of random paths may be off by beside its noise, where a case says nothing else: the weight of a
#: path, the light and the mean are rounded once each.
ROUNDINGS = 4.0

#: Half the distance of two float32 numbers, relatively; and the smallest number that has all its digits.
ROUNDING, SMALLEST = 2.0**-24, 2.0**-126


@dataclass(frozen=True)
class Finding:
    """A row without its names and its time."""

    expected: float | None = None
    got: float | None = None
    deviation: float | None = None
    unit: Unit = "roundings"
    limit: float | None = None
    verdict: Verdict = "passed"
    says: str = ""


def failed(says: str) -> Finding:
    return Finding(verdict="failed", says=says)


def fault(film: Film) -> str:
    """What is wrong with a film whatever it should show; empty where nothing is."""
    total = film.mean[..., 0].size * film.samples
    if film.rejected:
        return f"{film.rejected} of {total} samples were NaN, infinite or negative"
    if film.violations:
        return f"σ_t exceeded its majorant {film.violations} times"
    if not np.isfinite(film.mean).all():
        return f"{np.count_nonzero(~np.isfinite(film.mean))} values of the picture are NaN or infinite"
    if film.mean.min() < 0:
        return f"a pixel is negative ({film.mean.min():g})"
    if not (film.m2 >= 0).all() or (film.bound is not None and not (film.bound >= 0).all()):
        return "a variance or a bound is negative or NaN"
    return ""


def within_bound(film: Film, expected: float | Array, light: float = 1.0) -> Finding:
    """Holds every pixel to the film's own bound on its error; the row shows the one that is nearest to it.

    expected: of all pixels, or (height, width) or (height, width, channels); light: the largest radiance of the scene,
    below 2^-126 of which float32 has few digits.
    """
    if wrong := fault(film):
        return failed(wrong)
    assert film.bound is not None
    exact = np.asarray(expected, float)
    exact = np.broadcast_to(exact[..., None] if exact.ndim == 2 else exact, film.mean.shape)
    unit = ROUNDING * np.maximum(np.abs(exact), SMALLEST * light)
    deviation = (film.mean - exact) / unit
    # The exact answer is rounded, too, to float64, a few times.
    limit = film.bound / unit + 2.0**-20
    worst = np.unravel_index(int(np.argmax(np.abs(deviation) / limit)), deviation.shape)
    fine = abs(deviation[worst]) <= limit[worst]
    return Finding(
        float(exact[worst]),
        float(film.mean[worst]),
        float(deviation[worst]),
        "roundings",
        float(limit[worst]),
        "passed" if fine else "failed",
        "" if fine else "the picture is off by more than its own bound",
    )


def everywhere(film: Film, expected: float, roundings: float = ROUNDINGS) -> Finding:
    """Holds every pixel to the same value, to roundings; the row shows the worst."""
    if wrong := fault(film):
        return failed(wrong)
    off = (film.mean - expected) / (ROUNDING * expected)
    worst = np.unravel_index(int(np.argmax(np.abs(off))), off.shape)
    return _judged(expected, float(film.mean[worst]), float(off[worst]), "roundings", roundings)


def by_chance(
    film: Film, expected: float | Array, spread: float | None = None, roundings: float = ROUNDINGS
) -> Finding:
    """Holds the mean over the picture to LIMIT standard errors, and to roundings where noise is less than these; the
    row shows the worst channel.

    expected: or (channels,); spread: standard deviation of a sample where theory knows it, for what samples show too
    rarely to be estimated from.
    """
    if wrong := fault(film):
        return failed(wrong)
    got = film.mean.mean(axis=(0, 1))[: film.channels]
    if spread is None:
        errors = np.sqrt(film.variance().sum(axis=(0, 1)))[: film.channels] / film.count.size
    else:
        errors = np.full(got.shape, spread / math.sqrt(film.count.sum()))
    exact = np.broadcast_to(np.asarray(expected, float), got.shape)
    found = [_noisy(*numbers, roundings) for numbers in zip(exact.tolist(), got.tolist(), errors.tolist(), strict=True)]
    return max(found, key=_exhausted)


def by_hits(film: Film, chance: float) -> Finding:
    """Holds the mean of paths that are 1 with probability `chance`, else 0, to the binomial law itself, because few
    hits have no standard error to speak of. The deviation is that of a normal variable which is as improbable."""
    if wrong := fault(film):
        return failed(wrong)
    paths, got = int(film.count.sum()), float(film.mean[..., 0].mean())
    deviation = equivalent_deviation(round(got * paths), paths, chance)
    return _judged(chance, got, deviation, "standard errors", LIMIT)


def unknown(film: Film, expected: float | Array, unresolved: str) -> Finding | None:
    """Of a picture whose own standard error says that nothing is known of it; None where it says something."""
    error = film.mean_luminance_error()
    if error <= float(np.max(expected)):
        return None
    says = f"float32 does not resolve {unresolved}; the picture's standard error of {error:.2g} says so"
    return Finding(float(np.max(expected)), float(film.mean.mean()), verdict="not expressible", says=says)


def explained(finding: Finding, drift: Drift | None, unresolved: str) -> Finding:
    """A finding that failed, once more: is it off by what the renderer itself finds that float32 moves it by?"""
    if drift is None or abs(drift["relative"]) <= MOST_DRIFT + LIMIT * drift["error"]:
        return finding
    if not finding.expected or finding.got is None or finding.deviation is None:
        return finding
    moved, noise = finding.got / finding.expected - 1, drift["error"]
    if finding.unit == "standard errors":
        noise = math.hypot(noise, moved / finding.deviation)
    if abs(moved - drift["relative"]) > LIMIT * noise:
        return finding
    says = (
        f"float32 does not resolve {unresolved}; the certificate says that it moves the mean by {drift['relative']:.1%}"
    )
    return replace(finding, verdict="not expressible", says=says)


def equivalent_deviation(hits: int, trials: int, chance: float) -> float:
    """Of a normal variable whose tail is as improbable as that of so many hits; 0 in the middle."""
    if not 0 < chance < 1:
        return 0.0 if hits == trials * chance else math.copysign(math.inf, hits - trials * chance)
    k = np.arange(trials + 1)
    choices = np.log(np.arange(trials, 0, -1)) - np.log(np.arange(1, trials + 1))
    logs = np.concatenate([[0.0], np.cumsum(choices)]) + k * math.log(chance) + (trials - k) * math.log1p(-chance)
    law = np.exp(logs)
    tail = max(min(float(law[: hits + 1].sum()), float(law[hits:].sum())), 1e-300)
    return 0.0 if tail >= 0.5 else math.copysign(NormalDist().inv_cdf(tail), hits - trials * chance)


def _noisy(expected: float, got: float, error: float, roundings: float) -> Finding:
    unit = ROUNDING * max(abs(expected), SMALLEST)
    if error > 64 * unit:
        return _judged(expected, got, (got - expected) / error, "standard errors", LIMIT)
    return _judged(expected, got, (got - expected) / unit, "roundings", LIMIT * error / unit + roundings)


def _judged(expected: float, got: float, deviation: float, unit: Unit, limit: float) -> Finding:
    fine = abs(deviation) <= limit
    says = "" if fine else f"the picture is off by more than {limit:.3g} {unit}"
    return Finding(expected, got, deviation, unit, limit, "passed" if fine else "failed", says)


def _exhausted(finding: Finding) -> float:
    """How much of its limit a finding uses."""
    if finding.deviation is None or not finding.limit:
        return math.inf
    return abs(finding.deviation) / finding.limit
