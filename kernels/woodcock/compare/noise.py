"""Noise or bias? What the difference of two pictures is made of: z-scores of pixels, and a verdict.

Where both are right every pixel's difference has the expectation 0 and is independent of its neighbours', for samples
are placed by the filter and no two pixels share one. Bias shows in means over parts of the picture, or as differences
of neighbours that go together. Both hold for pictures that share random numbers, too, where variances say nothing of
the difference; how far its means may be off is then told by how it scatters itself.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal, NamedTuple, TypedDict

import numpy as np

from woodcock.certificate import MOST_DRIFT
from woodcock.compare.agreement import Mean, apart, most_by_chance, of_picture, regions
from woodcock.compare.rendered import Rendered
from woodcock.film import weights
from woodcock.pages import words
from woodcock.space import Array

#: A mean z² above the expected one by this factor, and by so many standard errors, is more than variances explain.
MOST_SCATTER, SCATTER_ERRORS = 1.2, 5.0
#: A picture whose variance is this often that of the other one, sample for sample, may be missing rare bright samples.
MOST_UNLIKE = 4.0

Kind = Literal["same", "noise", "bias", "unclear"]


class Part(TypedDict):
    """Of a picture, pixels from its top left. bias: mean luminance of I - R; deviation: its size in standard errors,
    None where these are 0."""

    x: int
    y: int
    width: int
    height: int
    bias: float
    deviation: float | None


class Scatter(TypedDict):
    """Of the z-scores of pixels that have noise, `pixels` of all (a share).

    mean_square: 1 on average for noise of many samples, and of few up to `expected`, None where that has no limit;
    error: its standard error. beyond_2, beyond_3: shares of sizes above, of a normal distribution .0455 and .0027.
    """

    pixels: float
    mean_square: float
    error: float
    expected: float | None
    beyond_2: float
    beyond_3: float


class Coherence(NamedTuple):
    """correlation: of a pixel's difference with its right and its lower neighbour's; deviation: of that from 0, in
    standard errors."""

    correlation: float
    deviation: float


class Verdict(TypedDict):
    """says: what kind the difference is of, and why. parts: the whole picture, and 4 × 4 parts of it.

    shared: both use the same random numbers, so that there are no z-scores. bias_error: standard error of the mean
    luminance of I - R; limit: standard errors that the largest of all deviations exceeds by chance once in a thousand
    comparisons; detectable: the bias of the whole that would have shown. None without noise.
    """

    kind: Kind
    says: str
    shared: bool
    parts: list[Part]
    limit: float
    scatter: Scatter | None
    coherence: float | None
    coherence_deviation: float | None
    bias_error: float | None
    detectable: float | None


def z_scores(picture: Rendered, reference: Rendered) -> Array | None:
    """(I - R) / √(var I + var R + r²) of every channel of every pixel, with r = 10⁻⁵ max(|I|, |R|) for rounding.

    Bounds are taken off the difference first. None where the variance of the difference is not known: of pictures that
    share random numbers, or have fewer than two samples; and where there is no noise at all.
    """
    if _noiseless(picture, reference) or picture.shares_with(reference):
        return None
    if picture.variance is None or reference.variance is None:
        return None
    off = picture.mean - reference.mean
    size = np.maximum(np.abs(off) - _bounds(picture, reference), 0)
    error = np.sqrt(picture.variance + reference.variance + _rounding(picture, reference) ** 2)
    return np.asarray(np.sign(off) * np.divide(size, error, out=np.zeros(size.shape), where=size > 0))


def coherence(off: Array) -> Coherence:
    """Of differences (height, width). By their own products: whatever their variances, noise is within few of 0."""
    scale = float(np.abs(off).max())
    off = off / scale if scale > 0 else off
    products = np.concatenate([(off[:, 1:] * off[:, :-1]).ravel(), (off[1:] * off[:-1]).ravel()])
    squares = [(a**2).sum() + (b**2).sum() for a, b in ((off[:, 1:], off[:, :-1]), (off[1:], off[:-1]))]
    total, error = float(products.sum()), math.sqrt(float((products**2).sum()))
    return Coherence(2 * total / float(sum(squares)), total / error) if error > 0 else Coherence(0.0, 0.0)


def judge(picture: Rendered, reference: Rendered) -> Verdict:
    """What the difference of two pictures of one shape is made of."""
    factors = weights(picture.mean.shape[-1])
    off, shared = (picture.mean - reference.mean) @ factors, picture.shares_with(reference)
    means = _means(picture, reference)
    limit = most_by_chance(len(means) + 1)
    verdict: Verdict = {
        "kind": "noise",
        "says": "",
        "shared": shared,
        "parts": _parts(means, *off.shape),
        "limit": limit,
        "scatter": _scatter(picture, reference),
        "coherence": None,
        "coherence_deviation": None,
        "bias_error": None,
        "detectable": None,
    }
    if _noiseless(picture, reference):
        verdict["kind"], verdict["says"] = _by_bounds(picture, reference)
        return verdict
    error = math.hypot(means[0][0].error, means[0][1].error)
    verdict["bias_error"], verdict["detectable"] = error, limit * error
    verdict["coherence"], verdict["coherence_deviation"] = coherence(off)
    mean = float(np.mean(np.abs(reference.mean @ factors)))
    verdict["kind"], verdict["says"] = _by_tests(picture, reference, verdict, mean)
    return verdict


# What is known of the two


def _noiseless(picture: Rendered, reference: Rendered) -> bool:
    return picture.bound is not None and reference.bound is not None


def _bounds(picture: Rendered, reference: Rendered) -> Array | float:
    return sum((one.bound for one in (picture, reference) if one.bound is not None), start=0.0)


def _rounding(picture: Rendered, reference: Rendered) -> Array:
    return np.asarray(MOST_DRIFT * np.maximum(np.abs(picture.mean), np.abs(reference.mean)))


def _means(picture: Rendered, reference: Rendered) -> list[tuple[Mean, Mean]]:
    """Of both pictures, over the whole and over parts; of their difference and of nothing, where only its own scatter
    tells its error."""
    factors = weights(picture.mean.shape[-1])
    if picture.variance is None or reference.variance is None or picture.shares_with(reference):
        off, rounding = (picture.mean - reference.mean) @ factors, _rounding(picture, reference) @ factors
        return [(one, Mean(0.0, 0.0, 0.0)) for one in of_picture(off, np.abs(off), rounding)]
    both = []
    for one, variance in ((picture, picture.variance), (reference, reference.variance)):
        bound = np.zeros(one.mean.shape) if one.bound is None else one.bound
        both.append(of_picture(one.mean @ factors, np.sqrt(variance) @ factors, bound @ factors))
    return list(zip(*both, strict=True))


def _parts(means: list[tuple[Mean, Mean]], height: int, width: int) -> list[Part]:
    found = []
    for (rows, columns), (mine, its) in zip(regions(height, width), means, strict=True):
        deviation = apart(mine, its)
        found.append(
            Part(
                x=columns.start,
                y=rows.start,
                width=columns.stop - columns.start,
                height=rows.stop - rows.start,
                bias=mine.value - its.value,
                deviation=deviation if math.isfinite(deviation) else None,
            )
        )
    return found


def _scatter(picture: Rendered, reference: Rendered) -> Scatter | None:
    scores = z_scores(picture, reference)
    if scores is None or picture.variance is None or reference.variance is None:
        return None
    noisy = picture.variance + reference.variance > _rounding(picture, reference) ** 2
    pixels = int(noisy.any(axis=-1).sum())
    if pixels == 0:
        return None
    size = np.abs(scores[noisy])
    # Of Student's t with n - 1 degrees of freedom: the other picture's only add to them.
    known = [one.samples - 1 for one in (picture, reference) if one.samples is not None and one.bound is None]
    freedom = min(known, default=math.inf)
    return {
        "pixels": pixels / noisy[..., 0].size,
        "mean_square": float(np.mean(size**2)),
        "error": float(np.std(size**2)) / math.sqrt(pixels),  # channels of a pixel count as one
        "expected": 1 / (1 - 2 / freedom) if freedom > 2 else None,
        "beyond_2": float(np.mean(size > 2)),
        "beyond_3": float(np.mean(size > 3)),
    }


# The verdict


def _by_bounds(picture: Rendered, reference: Rendered) -> tuple[Kind, str]:
    beyond = np.abs(picture.mean - reference.mean) > _bounds(picture, reference)
    share = float(np.mean(beyond.any(axis=-1)))
    if share == 0:
        return "same", "The same: neither picture has noise, and no pixel differs by more than both may be off."
    edges = "" if picture.samples == reference.samples else " Samples smooth edges, and there are not as many in both."
    return "bias", (
        f"Bias: neither picture has noise, and {words.percent(share)} of the pixels differ by more than both may be "
        f"off.{edges}"
    )


def _by_tests(picture: Rendered, reference: Rendered, verdict: Verdict, mean: float) -> tuple[Kind, str]:
    if not (np.abs(picture.mean - reference.mean) > _rounding(picture, reference)).any():
        why = " They share their random numbers, so that they agree in their noise." if verdict["shared"] else ""
        return "same", f"The same: no pixel differs by more than rounding.{why}"
    found = _bias(verdict, mean)
    if found is not None:
        if _unlike(picture, reference):
            return "unclear", (
                f"Not clear: {found} But sample for sample one picture scatters much less than the other: it may be "
                "missing rare bright samples, which is noise. More samples of it would tell."
            )
        return "bias", f"Bias: {found}"
    scatter = verdict["scatter"]
    if scatter is not None and scatter["expected"] is not None:
        most = MOST_SCATTER * scatter["expected"] + SCATTER_ERRORS * scatter["error"]
        if scatter["mean_square"] > most:
            return "unclear", (
                f"Not clear: the means agree, but pixels differ by more than their variances explain (mean z² is "
                f"{words.number(scatter['mean_square'])}). Either details differ, or samples are so few or so uneven "
                "that the variances of single pixels cannot be trusted."
            )
    detectable = verdict["detectable"]
    seen = (
        f" A bias above {words.percent(detectable / mean)} of the mean would have shown." if detectable and mean else ""
    )
    largest = max((part["deviation"] or 0.0) for part in verdict["parts"])
    return "noise", (
        f"Noise: the means of the whole and of {len(verdict['parts']) - 1} parts agree to {words.number(largest)} "
        f"standard errors, where chance allows {words.number(verdict['limit'])}, and neighbouring pixels differ "
        f"independently.{seen}"
    )


def _bias(verdict: Verdict, mean: float) -> str | None:
    """What shows a bias, as a sentence."""
    whole, *parts = verdict["parts"]
    for part, where in ((whole, "the picture"), (max(parts, key=_size), "a part of the picture")):
        if _size(part) > verdict["limit"]:
            how = "brighter" if part["bias"] > 0 else "darker"
            by = f"by {words.percent(abs(part['bias']) / mean)} of the mean" if mean > 0 else "than a black one"
            errors = (
                "with no noise there"
                if part["deviation"] is None
                else (
                    f"{words.number(part['deviation'])} standard errors, where chance allows "
                    f"{words.number(verdict['limit'])}"
                )
            )
            at = "" if part is whole else f" (from pixel {part['x']}, {part['y']}, {part['width']} × {part['height']})"
            return f"{where}{at} is {how} {by}, {errors}."
    if verdict["coherence_deviation"] is not None and abs(verdict["coherence_deviation"]) > verdict["limit"]:
        return (
            "the means agree, but differences of neighbouring pixels go together (correlation "
            f"{words.number(verdict['coherence'] or 0)}, {words.number(abs(verdict['coherence_deviation']))} standard "
            "errors), as those of noise do not. Something differs in detail: an edge, a place, a blur."
        )
    return None


def _size(part: Part) -> float:
    return math.inf if part["deviation"] is None else part["deviation"]


def _unlike(picture: Rendered, reference: Rendered) -> bool:
    """Would the difference be noise, had both pictures the larger of their variances of a sample?"""
    if picture.variance is None or reference.variance is None or not (picture.samples and reference.samples):
        return False
    if picture.bound is not None or reference.bound is not None or picture.shares_with(reference):
        return False
    ratio = picture.samples / reference.samples
    mine = np.maximum(picture.variance, reference.variance / ratio)
    its = np.maximum(reference.variance, picture.variance * ratio)
    if mine.mean() < MOST_UNLIKE * picture.variance.mean() and its.mean() < MOST_UNLIKE * reference.variance.mean():
        return False
    cautious = _means(replace(picture, variance=mine), replace(reference, variance=its))
    return max(apart(*pair) for pair in cautious) <= most_by_chance(len(cautious) + 1)
