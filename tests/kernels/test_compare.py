"""The shoot-out: which scenes, how far a ratio is known, do pictures agree, and who wins."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom
from tests.conftest import Rng, described
from tests.kernels.made_rows import entry, part
from tests.statistics import accept

from woodcock.compare import CompareError, Slice, kinds, of_series, parse, ratio, variants, winner
from woodcock.compare.agreement import FAMILY_WISE, Mean, disagreeing, means
from woodcock.compare.efficiency import efficiency
from woodcock.film import Film

# Which scenes


def test_variants_are_all_combinations(box: dict[str, Any]) -> None:
    scene = described(box | {"majorant": {"kind": "grid", "resolution": 7}})
    found = variants(scene, {"majorant": ["global", "grid"], "integrator": ["volumetric_path"]})
    assert [variant.label for variant in found] == ["global", "grid"]
    assert [variant.choices["majorant"] for variant in found] == ["global", "grid"]
    assert found[0].scene.majorant.kind == "global"
    assert found[1].scene == scene  # a kind that it is of already keeps its numbers
    both = variants(scene, {"majorant": ["global", "grid"], "transmittance": ["ratio", "residual_ratio"]})
    assert [variant.label for variant in both] == [
        *("global, ratio", "global, residual_ratio"),
        *("grid, ratio", "grid, residual_ratio"),
    ]
    assert {(each.scene.majorant.kind, each.scene.transmittance.kind) for each in both if each.scene.transmittance} == {
        (majorant, transmittance) for majorant in ("global", "grid") for transmittance in ("ratio", "residual_ratio")
    }


@pytest.mark.parametrize(
    ("vary", "said"),
    [
        (["majorant"], "--vary majorant: write it as FIELD=kind,kind"),
        (["majorant=global,"], "write it as FIELD=kind,kind"),
        (["majorant=global,grid", "majorant=grid"], "majorant varies already"),
        (["camera=perspective,spherical"], "camera cannot vary; what can is majorant, free_flight, transmittance"),
        (["majorant=global,octree"], "majorant has no kind octree; it has global, grid"),
        (["majorant=grid,grid"], "majorant names grid twice"),
        (["majorant=grid"], "takes 2 to 64 variants, not 1"),
        ([], "takes 2 to 64 variants, not 1"),
    ],
)
def test_a_fault_says_what_would_be_right(vary: list[str], said: str, box: dict[str, Any]) -> None:
    with pytest.raises(CompareError) as error:
        variants(described(box), parse(vary))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_kinds_are_those_of_the_scene() -> None:
    assert list(kinds("majorant")) == ["global", "grid"]
    assert list(kinds("integrator")) == ["transmittance", "emission_absorption", "volumetric_path"]


# How far a ratio is known


def test_efficiency_is_one_over_variance_times_time() -> None:
    # 2 s for 10 samples of variance 4: the mean's variance is 0.4
    assert efficiency([Slice(2, 10, 4)]) == pytest.approx(1 / (0.4 * 2))
    # 3 + 7 degrees of freedom pool the variances; 12 samples in 6 s
    pooled = (3 * 2 + 7 * 5) / 10
    assert efficiency([Slice(2, 4, 2), Slice(4, 8, 5)]) == pytest.approx(12 / (pooled * 6))
    assert efficiency([Slice(2, 1, math.nan)]) is None
    assert efficiency([Slice(2, 8, 0)]) is None
    assert efficiency([]) is None
    # A slice of one sample has a time and no variance
    assert efficiency([Slice(2, 4, 3), Slice(1, 1, math.nan)]) == pytest.approx(5 / (3 * 3))


def slices(rng: np.random.Generator, turns: int, rate: float, variance: float, mood: Any = 1.0) -> list[Slice]:
    """Turns of samples of a variance that is estimated from 64 pixels of 4 samples, at a rate that the mood scales."""
    samples = 4
    seconds = samples / rate * np.exp(0.1 * rng.standard_normal(turns)) * mood
    freedom = 64 * (samples - 1)
    estimates = variance * rng.chisquare(freedom, turns) / freedom
    return [Slice(float(t), samples, float(v)) for t, v in zip(seconds, estimates, strict=True)]


@pytest.mark.parametrize(("mine", "its"), [(20, 20), (8, 8), (20, 13)], ids=["paired", "few", "not paired"])
def test_intervals_hold_the_truth_as_often_as_they_say(rng: Rng, mine: int, its: int) -> None:
    random, runs, held = rng(5), 400, 0
    truth = (3.0 / 2.0) / (1.0 / 1.7)
    for _ in range(runs):
        moods = np.exp(0.5 * random.standard_normal(max(mine, its)))
        if mine != its:
            moods[:] = 1.0  # it is pairs that moods cancel in
        found = ratio(
            slices(random, mine, 3.0, 2.0, moods[:mine]),
            slices(random, its, 1.0, 1.7, moods[:its]),
        )
        assert found is not None
        assert found["low"] is not None
        assert found["high"] is not None
        held += found["low"] <= truth <= found["high"]
    # At least 95 %, and not by being so wide that they say nothing: at most 98.5 %
    accept(float(binom.cdf(held, runs, 0.95)), "too few", exact=False)
    accept(float(binom.sf(held - 1, runs, 0.985)), "too many", exact=False)


def test_pairs_cancel_a_machines_moods(rng: Rng) -> None:
    random = rng(6)
    moods = np.exp(random.standard_normal(20))
    a, b = slices(random, 20, 2.0, 1.0, moods), slices(random, 20, 1.0, 1.0, moods)
    paired, unpaired = ratio(a, b), ratio(a, b[:-1])
    assert paired is not None
    assert unpaired is not None
    widths = [math.log((each["high"] or math.nan) / (each["low"] or math.nan)) for each in (paired, unpaired)]
    assert widths[0] < 0.5 * widths[1]


def test_a_ratio_of_one_turn_has_no_interval() -> None:
    assert ratio([Slice(1, 4, 1)], [Slice(2, 4, 1)]) == {"value": pytest.approx(2), "low": None, "high": None}
    assert ratio([Slice(1, 4, 1)], [Slice(2, 1, math.nan)]) is None
    same = [Slice(1, 4, 1.5), Slice(2, 4, 1)]
    found = ratio(same, same)
    assert found == {"value": 1.0, "low": 1.0, "high": 1.0}


def test_a_series_gives_the_slices_that_made_it(rng: Rng) -> None:
    """Of one pixel: the M2 of a part is that of all its samples, less what was there before."""
    values, points = rng(7).standard_normal(400), []
    for n in (2, 8, 40, 400):
        rmse = math.sqrt(values[:n].var(ddof=1) / n)
        points.append({"seconds": 9 * n, "device_seconds": 0.5 * n, "samples": n, "rmse": rmse})
    found = of_series(points)
    assert [each.samples for each in found] == [2, 6, 32, 360]
    assert [each.seconds for each in found] == [1, 3, 16, 180]
    squares = [np.sum((values[:n] - values[:n].mean()) ** 2) for n in (2, 8, 40, 400)]
    freedom = [1, 6, 32, 360]
    assert [each.variance for each in found] == pytest.approx(np.diff([0.0, *squares]) / freedom)


# Do they show the same picture?


def test_the_larger_part_is_believed() -> None:
    assert disagreeing([part(1.0), part(1.01), part(0.995)]) == []
    assert disagreeing([part(1.0), part(1.5), part(0.99)]) == [1]
    # However well a single one claims to know
    assert disagreeing([part(1.0), part(1.5, 1e-9), part(0.99), part(1.02)]) == [1]
    # Two against two: nobody is to be believed
    assert disagreeing([part(1.0), part(1.0), part(1.5), part(1.5)]) == [0, 1, 2, 3]
    assert disagreeing([part(1.0), part(1.5)]) == [0, 1]


def test_the_truth_decides_where_it_is_known() -> None:
    assert disagreeing([part(1.0), part(1.5), part(1.5)], part(1.0, 0.001)) == [1, 2]


def test_a_part_of_the_picture_is_enough_to_disagree() -> None:
    assert disagreeing([[*part(1.0), *part(2.0)], [*part(1.0), *part(1.5)]]) == [0, 1]


def test_bounds_and_rounding_are_no_disagreement() -> None:
    assert disagreeing([part(1.0, 1e-6), part(1.1, 1e-6, bound=0.2)]) == []
    assert disagreeing([part(1.0, 1e-9), part(1.0 + 5e-6, 1e-9)]) == []
    assert disagreeing([part(1.0, 0.0), part(1.1, 0.0)]) == [0, 1]
    assert disagreeing([part(1.0, math.nan), part(9.0)]) == []  # not known


def test_agreement_is_seldom_denied(rng: Rng) -> None:
    random, runs = rng(8), 1500
    denied = 0
    for _ in range(runs):
        found = [[Mean(1 + 0.01 * float(z), 0.01, 0.0) for z in random.standard_normal(17)] for _ in range(5)]
        denied += bool(disagreeing(found))
    accept(float(binom.sf(denied - 1, runs, FAMILY_WISE)), "denied", exact=False)


def test_means_of_a_film_are_those_of_its_parts(rng: Rng) -> None:
    values = rng(9).random((8, 12, 3))
    count = np.full((8, 12), 10, np.uint32)
    film = Film(count, values, 90 * 0.25 * np.ones((8, 12, 3)), ("R", "G", "B"), ((0, 10),))
    found = means(film)
    luminance = values @ [0.2126, 0.7152, 0.0722]
    assert len(found) == 17
    assert found[0].value == pytest.approx(luminance.mean())
    assert found[0].error == pytest.approx(0.5 / math.sqrt(96))  # every pixel's mean has a variance of 1/4
    assert found[1].value == pytest.approx(luminance[:2, :3].mean())
    assert found[-1].value == pytest.approx(luminance[6:, 9:].mean())


# Who wins


def test_the_most_efficient_wins_by_its_lead() -> None:
    verdict = winner([entry("slow", 1), entry("fast", 4), entry("second", 2)])
    assert verdict["winner"] == "fast"
    assert verdict["order"] == ["fast", "second", "slow"]
    assert (verdict["runner_up"], verdict["worst"], verdict["draw"]) == ("second", "slow", [])
    assert verdict["lead"] is not None
    assert verdict["lead"]["value"] == pytest.approx(2, rel=0.05)
    assert verdict["ratios"]["fast"]["value"] == pytest.approx(4, rel=0.05)
    assert "“fast” wins: " in verdict["says"]
    assert "times as efficient as “second”" in verdict["says"]


def test_what_cannot_be_told_apart_is_a_draw() -> None:
    verdict = winner([entry("a", 2.0), entry("bb", 2.005), entry("slow", 1)])
    assert verdict["winner"] is None
    assert set(verdict["draw"]) == {"a", "bb"}
    assert verdict["says"].startswith("A draw between ")
    assert winner([entry("a", 9, turns=1), entry("b", 1, turns=1)])["winner"] is None  # no interval, no winner


def test_who_disagrees_cannot_win() -> None:
    verdict = winner([entry("biased", 100, mean=1.4), entry("sound", 2), entry("slow", 1)])
    assert verdict["winner"] == "sound"
    assert verdict["disagree"] == ["biased"]
    assert verdict["order"][-1] == "biased"
    assert "Not believed, because the picture is not the others': “biased”." in verdict["says"]
    split = winner([entry("one", 4), entry("other", 1, mean=1.4)])
    assert (split["winner"], split["draw"]) == (None, [])
    assert split["says"] == "No winner: no more than half of the pictures are the same."
    known = winner([entry("one", 4), entry("other", 1, mean=1.4)], part(1.4, 1e-4))
    assert known["winner"] == "other"
    assert "is the only one left to win" in known["says"]


def test_what_has_no_noise_wins_if_it_is_right() -> None:
    exact = entry("exact", 1, deterministic=True)
    assert winner([entry("fast", 50), exact])["winner"] == "exact"
    wrong = entry("wrong", 1, mean=2.0, deterministic=True)
    assert winner([entry("fast", 50), wrong, entry("slow", 1)])["winner"] == "fast"
    assert set(winner([exact, entry("other", 1, deterministic=True)])["draw"]) == {"exact", "other"}


def test_equals_seldom_win(rng: Rng) -> None:
    random, runs, won = rng(11), 200, 0
    for _ in range(runs):
        rows = []
        for label in "abcd":
            found = slices(random, 12, 1.0, 1.0)
            rows.append(entry(label, 1) | {"slices": found, "efficiency": efficiency(found)})
        won += winner(rows)["winner"] is not None
    accept(float(binom.sf(won - 1, runs, 0.05)), "won", exact=False)
