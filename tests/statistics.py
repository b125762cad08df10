"""Statistical comparisons of tests: each ends in a p-value, and every one is accepted or refused here.

A p-value is recorded, with whether it is exact: uniform where nothing is wrong, and independent of the other exact
ones. Those that are not (discrete or bounded, with an allowance for what is no noise, of data that another one has
seen) must be conservative. `make calibrate` holds the exact ones to their law; `tests/README.md` says how.
"""

from __future__ import annotations

import hashlib
import os
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm, t

#: Probability that any comparison of a run of the tests fails by chance; seeds are fixed, so it is met once for all.
FAMILY_WISE = 1e-4
#: Comparisons that a run makes, at most: a run that makes more fails.
FAMILY = 4096
#: The level of each: Šidák (1967).
SIGNIFICANCE = float(-np.expm1(np.log1p(-FAMILY_WISE) / FAMILY))
#: An allowance below this share of the standard error leaves a p-value exact.
NEGLIGIBLE = 0.01

Array = NDArray[np.float64]


class Comparison(NamedTuple):
    test: str
    what: str
    p: float
    exact: bool


#: Of this run, in order.
COMPARISONS: list[Comparison] = []
#: What a calibration run makes all seeds of; empty where tests have their own.
FRESH = ""


def running() -> str:
    """The test that is running; pytest keeps it there."""
    return os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" ")[0]


def seed(own: int) -> int:
    """A test's own seed, 32 bits; in a calibration run another one, which no other test and no other run has."""
    if not FRESH:
        return own
    return int.from_bytes(hashlib.sha256(f"{FRESH} {running()} {own}".encode()).digest()[:4])


def accept(p: float, what: str = "", exact: bool = True) -> None:
    """Asserts that a p-value is none that only a fault explains."""
    COMPARISONS.append(Comparison(running(), what, float(p), bool(exact)))
    assert p >= SIGNIFICANCE, f"{what or 'p'}: p = {p:.3g}"


def least(p: Any) -> float:
    """The p-value of the smallest of independent ones: Šidák (1967)."""
    p = np.asarray(p, float).reshape(-1)
    with np.errstate(divide="ignore"):  # of p = 1
        return float(-np.expm1(p.size * np.log1p(-p.min())))


def accept_z(z: Any, what: str = "", exact: bool = True) -> None:
    """Of independent deviations in standard errors: two-sided, the largest of all."""
    z = np.abs(np.asarray(z, float)).reshape(-1)
    assert not np.isnan(z).any(), f"{what or 'z'}: not a number"
    accept(least(2 * norm.sf(z)), f"{what} {z.max():.3g} standard errors".strip(), exact)


def accept_mean(values: Any, expected: Any, what: str = "", allowed: Any = 0, exact: bool = True) -> None:
    """Of the mean of independent values along the last axis: Student's t, the largest of all means.

    allowed: what the mean may be off without noise. The law is Student's for values so many or so close to normal that
    their mean is normal; where a few rare ones make the mean it is not, and another test is right.
    """
    values = np.asarray(values, float)
    n = values.shape[-1]
    error = values.std(axis=-1, ddof=1) / np.sqrt(n)
    off = np.maximum(np.abs(values.mean(axis=-1) - expected) - allowed, 0)
    ratio = np.divide(off, error, out=np.where(off > 0, np.inf, 0.0), where=error > 0)
    exact = exact and bool(np.all(np.asarray(allowed) < NEGLIGIBLE * error))
    accept(least(2 * t.sf(ratio, n - 1)), f"{what} {np.max(ratio):.3g} standard errors".strip(), exact)


def accept_counts(counts: Any, expected: Any = None, what: str = "", exact: bool = True) -> None:
    """Of counts in bins that are expected to hold so many, in proportion, or the same each: Pearson's χ²."""
    counts = np.asarray(counts, float)
    expected = np.ones(counts.shape) if expected is None else np.asarray(expected, float)
    expected = expected * (counts.sum() / expected.sum())
    statistic = float(((counts - expected) ** 2 / expected).sum())
    what = f"{what} χ² = {statistic:.4g} of {counts.size} bins".strip()
    accept(float(chi2.sf(statistic, counts.size - 1)), what, exact)


def accept_squares(total: float, freedom: float, what: str = "", exact: bool = True) -> None:
    """Of a sum of squares of normal deviates, in units of their variance: χ², neither too large nor too small."""
    p = 2 * min(chi2.sf(total, freedom), chi2.cdf(total, freedom))
    accept(float(p), f"{what} variance {total / freedom:.4g} of what it should be".strip(), exact)
