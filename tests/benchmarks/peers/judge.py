"""How many times as efficient Woodcock is as its peers, from independent images of equal samples. Pure.

The mean square error of an image is its variance between rounds, over pixels and channels; efficiency is
1 / (mean square error × seconds). A ratio is of renders that show the same picture: where a peer's means disagree
with Woodcock's, there is none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypedDict

import numpy as np

from woodcock.compare import Ratio
from woodcock.compare.agreement import Mean, disagreeing, of_picture
from woodcock.film import LUMINANCE
from woodcock.regression import quantile
from woodcock.space import Array

#: Probability that an interval misses.
LEVEL = 0.05
#: What a peer's means may be off by beside noise, relative to them: rays that start off their surfaces, edges of cones.
ALLOWED = 5e-4
#: Least ratios by scene and peer, and of their geometric mean over the scenes.
GOALS = {"Mitsuba 3": 40.0, "Cycles": 25.0, "pbrt-v4": 12.0, "LuxCore": 20.0}
CLOUD_GOALS = {"Mitsuba 3": 100.0, "Cycles": 85.0, "pbrt-v4": 30.0, "LuxCore": 20.0}
GEOMETRIC = 1.5


class Shot(NamedTuple):
    """images: (rounds, height, width, channels), independent; seconds: of each."""

    images: Array
    seconds: Sequence[float]


class Row(TypedDict):
    """A peer on a scene. mse: of an image; ratio: Woodcock's efficiency over its own, None where their means differ or
    nothing varies; differs: how, in words; bias: of the whole picture's luminance, relative, with its standard error.
    """

    mse: float
    seconds: float
    efficiency: float | None
    ratio: Ratio | None
    differs: str | None
    bias: float
    bias_error: float


def mse(images: Array) -> float:
    return float(np.var(images, axis=0, ddof=1, dtype=np.float64).mean())


def efficiency(shot: Shot) -> float | None:
    """None where nothing varies."""
    cost = mse(shot.images) * float(np.mean(shot.seconds))
    return 1 / cost if cost > 0 else None


def ratio(ours: Shot, theirs: Shot) -> Ratio | None:
    """The 95 % interval is Student's, by the jackknife of the logarithm (Tukey 1958), over the rounds that both have:
    they were rendered in turns. None where nothing varies."""
    count = min(len(ours.seconds), len(theirs.seconds))
    ours, theirs = (Shot(shot.images[:count], shot.seconds[:count]) for shot in (ours, theirs))
    if efficiency(ours) is None or efficiency(theirs) is None:
        return None
    value = math.exp(_log(ours) - _log(theirs))
    if count < 3:
        return {"value": value, "low": None, "high": None}
    left_out = np.array([_log(_without(ours, round_)) - _log(_without(theirs, round_)) for round_ in range(count)])
    variance = (count - 1) / count * float(np.sum((left_out - left_out.mean()) ** 2))
    factor = math.exp(quantile(LEVEL, count - 1) * math.sqrt(variance))
    return {"value": value, "low": value / factor, "high": value * factor}


def means(images: Array, allowed: float = 0.0) -> list[Mean]:
    """Luminances of the whole picture and of its parts. allowed: relative, beside noise.

    Errors are from the pixels' variances or, where that is more because pixels share random numbers, from the parts'.
    """
    luminance = np.asarray(images, np.float64) @ LUMINANCE
    count = len(luminance)
    picture, deviation = luminance.mean(axis=0), luminance.std(axis=0, ddof=1) / math.sqrt(count)
    nothing = np.zeros(picture.shape)
    rounds = [[mean.value for mean in of_picture(each, nothing, nothing)] for each in luminance]
    errors = np.std(rounds, axis=0, ddof=1) / math.sqrt(count)
    found = of_picture(picture, deviation, allowed * picture)
    return [mean._replace(error=max(mean.error, float(error))) for mean, error in zip(found, errors, strict=True)]


def rows(reference: Array, ours: Shot, theirs: Mapping[str, Shot]) -> dict[str, Row]:
    """Of every peer of a scene. reference: images of Woodcock that are independent of theirs."""
    truth = means(reference)
    found = {name: means(shot.images, ALLOWED) for name, shot in theirs.items()}
    doubted = disagreeing(list(found.values()), truth)
    made: dict[str, Row] = {}
    for number, (name, shot) in enumerate(theirs.items()):
        whole, true = found[name][0], truth[0]
        made[name] = {
            "mse": mse(shot.images),
            "seconds": float(np.mean(shot.seconds)),
            "efficiency": efficiency(shot),
            "ratio": None if number in doubted else ratio(ours, shot),
            "differs": difference(found[name], truth) if number in doubted else None,
            "bias": whole.value / true.value - 1,
            "bias_error": math.hypot(whole.error / whole.value, true.error / true.value),
        }
    return made


def difference(found: Sequence[Mean], truth: Sequence[Mean]) -> str:
    """The largest beyond what is allowed, in standard errors."""
    off = [a.value - b.value for a, b in zip(found, truth, strict=True)]
    errors = [max(math.hypot(a.error, b.error), 1e-300) for a, b in zip(found, truth, strict=True)]
    worst = max(range(len(found)), key=lambda part: (abs(off[part]) - found[part].bound) / errors[part])
    where = "the whole" if worst == 0 else f"part {worst} of 16"
    return (
        f"means differ by {off[worst] / truth[worst].value:+.2%} ± {errors[worst] / truth[worst].value:.2%} in {where}"
    )


def geometric_mean(ratios: Sequence[float]) -> float:
    return math.exp(float(np.mean(np.log(ratios))))


def goal(scene: str, peer: str) -> float:
    return (CLOUD_GOALS if scene == "cloud" else GOALS)[_family(peer)]


def failures(ratios: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Which goals are missed, in words, of ratios by peer and scene. Goals are over peers as they come; what tuning
    by hand makes of them is told, but is no goal."""
    missed = []
    for peer, scenes in ratios.items():
        if peer.endswith("tuned"):
            continue
        for scene, value in scenes.items():
            if value < goal(scene, peer):
                missed.append(f"{scene}: {value:.3g} times as efficient as {peer}; the goal is {goal(scene, peer):g}")
        least = GEOMETRIC * GOALS[_family(peer)]
        if scenes and geometric_mean(list(scenes.values())) < least:
            value = geometric_mean(list(scenes.values()))
            missed.append(f"geometric mean: {value:.3g} times as efficient as {peer}; the goal is {least:g}")
    return missed


def _family(peer: str) -> str:
    return next(name for name in GOALS if peer.startswith(name))


def _log(shot: Shot) -> float:
    return -math.log(mse(shot.images) * float(np.mean(shot.seconds)))


def _without(shot: Shot, round_: int) -> Shot:
    return Shot(np.delete(shot.images, round_, axis=0), np.delete(np.array(shot.seconds), round_).tolist())
