"""What is rendered next: every sample once, by steps, until the contract is met; and nobody is judged by himself."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.conftest import Rng
from tests.statistics import accept_mean

from woodcock import contract
from woodcock.batches import TILE, tiles
from woodcock.contract import MOST_SAMPLES, PILOT, STEP, Piece, next_round, outcome, relative_error
from woodcock.film import Film
from woodcock.judging import AIM, colours
from woodcock.scene import RelativeErrorStop, SamplesStop, SecondsStop, Stop

Array = NDArray[np.float64]


def part(values: Array, piece: Piece) -> Film:
    """A piece of a picture whose samples are these, (samples, height, width)."""
    chosen = np.zeros(values.shape[1:], bool)
    chosen.reshape(-1)[slice(None) if piece.pixels is None else piece.pixels] = True
    held = values[piece.start : piece.stop]
    mean = held.mean(axis=0)
    count = (chosen * len(held)).astype(np.uint32)
    m2 = ((held - mean) ** 2).sum(axis=0)
    return Film(count, (chosen * mean)[..., None], (chosen * m2)[..., None], ("Y",), ((piece.start, piece.stop),))


def rounds(stop: Stop, values: Array, most: int = 99) -> list[Film]:
    """Films after each round, the pilot's first; so many rounds at most."""
    film, found = Film.empty(values.shape[2], values.shape[1], ("Y",)), list[Film]()
    while len(found) < most and (pieces := next_round(stop, film)):
        assert pieces[-1].stop <= len(values), "the stream is too short"
        for piece in pieces:
            film = film.merge(part(values, piece))
        found.append(film)
    return found


def still(variance: Any, mean: float = 1.0, count: int = PILOT) -> Film:
    """A film whose pixels have these variances of a sample."""
    variance = np.asarray(variance, float)[..., None]
    counts = np.full(variance.shape[:2], count, np.uint32)
    return Film(counts, np.full(variance.shape, mean), variance * (count - 1), ("Y",), ((0, count),))


def asked(stop: Stop, film: Film) -> NDArray[np.int64]:
    """(height, width): how many samples more of every pixel."""
    more = np.zeros(film.count.size, np.int64)
    for piece in next_round(stop, film):
        more[slice(None) if piece.pixels is None else piece.pixels] += piece.stop - piece.start
    return more.reshape(film.count.shape)


def stop(error: float, per: Literal["image", "tile"] = "tile") -> RelativeErrorStop:
    return RelativeErrorStop(relative_error=error, per=per)


# Samples and seconds


@pytest.mark.parametrize(
    ("done", "expected"),
    [
        ((), [(0, 5)]),
        (((0, 5),), []),
        (((0, 2),), [(2, 5)]),
        (((1, 2), (3, 4)), [(0, 1), (2, 3), (4, 5)]),
        (((3, 9),), [(0, 3)]),
        (((7, 9),), [(0, 5)]),
    ],
)
def test_a_round_of_samples_is_what_is_missing(
    done: tuple[tuple[int, int], ...], expected: list[tuple[int, int]]
) -> None:
    film = Film(np.zeros((1, 1), np.uint32), np.zeros((1, 1, 1)), np.zeros((1, 1, 1)), ("Y",), done)
    pieces = next_round(SamplesStop(samples=5), film)
    assert [(piece.start, piece.stop, piece.pixels) for piece in pieces] == [(*span, None) for span in expected]


def test_seconds_have_no_end() -> None:
    (piece,) = next_round(SecondsStop(seconds=1), None)
    assert (piece.start, piece.stop, piece.pixels) == (0, MOST_SAMPLES, None)
    assert next_round(SecondsStop(seconds=1), still(np.ones((1, 1))))[0].start == PILOT


def test_pieces_are_cut_anywhere() -> None:
    pixels = np.array([1, 4], np.int32)
    assert Piece(3, 9, pixels).cut(2) == (Piece(3, 5, pixels), [Piece(5, 9, pixels)])
    assert Piece(3, 9, pixels).cut(0) == (Piece(3, 4, pixels), [Piece(4, 9, pixels)])
    assert Piece(3, 9, pixels).cut(99) == (Piece(3, 9, pixels), [])
    assert (Piece(3, 9, pixels).width(7), Piece(3, 9, None).width(7)) == (2, 7)


# Who judges whom


@pytest.mark.parametrize(("height", "width"), [(64, 96), (7, 5), (1, 9), (6, 1), (1, 2), (1, 1)])
def test_two_by_two_pixels_have_each_colour_once(height: int, width: int) -> None:
    board = colours(height, width)
    assert board.shape == (height, width)
    for y in range(0, height, 2):
        for x in range(0, width, 2):
            block = board[y : y + 2, x : x + 2].reshape(-1)
            assert np.unique(block).size == block.size
            assert block.max() < 4
    assert np.array_equal(board, colours(height, width))


def test_no_pattern_hides_from_a_colour() -> None:
    """Colours are by chance: along lines and diagonals, and on every field of a chess board, there are all of them."""
    board = colours(128, 128)
    y, x = np.indices(board.shape)
    for pattern in (y == 3, x == 70, x == y, (x + y) % 2 == 0, (x % 2 == 0) & (y % 2 == 0)):
        shares = np.bincount(board[pattern], minlength=4) / pattern.sum()
        assert (shares > 0.1).all()


@pytest.mark.parametrize("per", ["image", "tile"])
def test_a_pixel_is_never_judged_by_its_own_colour(per: Literal["image", "tile"]) -> None:
    """Whatever becomes of a colour's values, nothing becomes of its own number of samples."""
    board = colours(64, 64)
    film = still(np.ones((64, 64)))
    before = asked(stop(0.05, per), film)
    for colour in range(4):
        own, others = board == colour, board == (colour - 1) % 4
        changed = still(np.where(own, 7.0, 1.0))
        changed = Film(changed.count, np.where(own, 3.0, 1.0)[..., None], changed.m2, ("Y",), changed.ranges)
        after = asked(stop(0.05, per), changed)
        assert np.array_equal(after[~others], before[~others])
        assert (after[others] != before[others]).all()


def test_what_lies_in_a_corner_of_a_tile_is_seen() -> None:
    """A pixel is judged by its neighbours beyond the border too: of four noisy ones, one in each of four tiles."""
    variance = np.zeros((64, 64))
    variance[31:33, 31:33] = 100.0
    assert (asked(stop(0.01), still(variance)) > 0).reshape(2, 32, 2, 32).any(axis=(1, 3)).all()


# How many


@pytest.mark.parametrize("per", ["image", "tile"])
def test_numbers_are_what_the_error_asks_for(per: Literal["image", "tile"]) -> None:
    """σ² / n = (ε mean)², with the aim a little better, the pilot counted, and rounded up to a step."""
    more = asked(stop(0.05, per), still(np.full((40, 70), 4.0), mean=5.0))
    assert np.unique(more).size == 1
    expected = 4.0 / (0.05 * 5.0 * AIM) ** 2 - PILOT
    assert expected <= more[0, 0] <= np.ceil(STEP * expected)


def test_only_tiles_that_need_them_get_samples() -> None:
    variance = np.zeros((64, 96))
    variance[:, 64:] = 1.0
    variance[32:, 64:] = 16.0
    more = asked(stop(0.05), still(variance))
    assert (more[:, :32] == 0).all()
    assert more[32:, 64:].mean() / more[:32, 64:].mean() == pytest.approx(16, rel=0.25)
    assert more[:, 32:64].mean() < more[:, 64:].mean() / 20  # beside noisy ones, whose pixels judge across the border


def test_judges_that_differ_ask_for_a_standard_error_more() -> None:
    """All pixels have some variance, or a sixteenth of them have all: of 256 judges 16, which is √15 / 16 less sure."""
    few = np.zeros((32, 32))
    few[1::4, 1::4] = 16.0
    even, sparse = (asked(stop(0.005), still(variance)).mean() for variance in (np.ones((32, 32)), few))
    assert sparse / even == pytest.approx(1 + np.sqrt(15) / 16, rel=0.07)


def test_what_is_met_within_the_aim_is_left_alone() -> None:
    """Between what was asked and what is aimed at nothing happens, so that rounds do not dribble."""
    count = int(1.0 / 0.05**2) + 1
    assert not next_round(stop(0.05), still(np.ones((32, 32)), count=count))
    assert next_round(stop(0.05), still(np.ones((32, 32)), count=count - 2))


@given(st.data())
def test_a_round_asks_for_every_sample_once(data: st.DataObject) -> None:
    """Its pieces are disjoint, sorted, new to the film, of ever fewer pixels; every pixel gets what it needs, or a step
    more; those that need nothing get nothing."""
    height, width = data.draw(st.integers(1, 40)), data.draw(st.integers(1, 70))
    seed, error = data.draw(st.integers(0, 99)), data.draw(st.floats(1e-3, 1))
    random = np.random.default_rng(seed)
    film = still(random.lognormal(0, 2, (height, width)) * (random.random((height, width)) < 0.5))
    pieces = next_round(stop(error), film)
    last = PILOT
    for before, piece in zip([None, *pieces], pieces, strict=False):
        assert piece.start == last < piece.stop
        last = piece.stop
        if piece.pixels is not None:
            assert piece.pixels.dtype == np.int32
            assert 0 < piece.pixels.size < height * width
            assert (np.diff(piece.pixels) > 0).all()
            if before is not None and before.pixels is not None:
                assert np.isin(piece.pixels, before.pixels).all()
    needed = np.maximum(contract.needed(stop(error), film) - PILOT, 0)
    more = asked(stop(error), film)
    assert (more >= needed - 1e-6).all()
    assert (more <= np.ceil(STEP * needed + 1e-6)).all()


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 99), st.sampled_from(["image", "tile"]))
def test_every_contract_ends(height: int, width: int, seed: int, per: Literal["image", "tile"]) -> None:
    """However small the picture: those of one pixel, or of two colours, judge as well as they can."""
    random = np.random.default_rng(seed)
    values = random.exponential(1, (4000, height, width)) * (random.random((height, width)) < 0.7)
    films = rounds(stop(0.2, per), values)
    assert films[0].ranges == ((0, PILOT),)
    for before, after in pairwise(films):
        assert (after.count >= before.count).all()
    assert not next_round(stop(0.2, per), films[-1])


# Pictures without anything to judge by


@pytest.mark.parametrize("per", ["image", "tile"])
@pytest.mark.parametrize(("variance", "mean"), [(0.0, 0.0), (0.0, 1.0), (np.nan, 1.0), (np.inf, 1.0), (1.0, 0.0)])
def test_there_is_nothing_to_do(per: Literal["image", "tile"], variance: float, mean: float) -> None:
    for size in ((1, 1), (33, 40)):
        assert not next_round(stop(1e-6, per), still(np.full(size, variance), mean))


def test_a_pixel_without_a_variance_judges_nobody() -> None:
    variance = np.ones((64, 64))
    variance[5, 5] = np.inf
    more = asked(stop(0.05), still(variance))
    assert more.min() > 300
    assert more.max() < 600


def test_samples_that_cannot_be_addressed_are_not_asked_for() -> None:
    pieces = next_round(stop(1e-6), still(np.ones((4, 4))))
    assert pieces[-1].stop == MOST_SAMPLES
    assert not next_round(stop(1e-6), still(np.ones((4, 4)), count=MOST_SAMPLES))


def test_without_noise_the_pilot_is_all() -> None:
    film = still(np.ones((4, 4)))
    sure = Film(film.count, film.mean, film.m2, ("Y",), film.ranges, bound=np.full((4, 4, 1), 0.01))
    assert not next_round(stop(0.001), sure)
    assert outcome(stop(0.02), sure, 1.0)["met"]
    missed = outcome(stop(0.001), sure, 1.0)
    assert not missed["met"]
    assert missed["reached"] == pytest.approx(0.01)


def test_a_film_of_any_past_will_do() -> None:
    """After a crash: a pilot with holes is filled, and a round that was cut short is decided anew; no sample is lost or
    counted twice, and tiles that are done stay done."""
    values = np.random.default_rng(3).exponential(1, (3000, 32, 64))
    values[..., :32] = 1.0
    torn = part(values, Piece(4, 9, None)).merge(part(values, Piece(20, PILOT, None)))
    assert [(piece.start, piece.stop) for piece in next_round(stop(0.05), torn)] == [(0, 4), (9, 20)]
    film = rounds(stop(0.05), values, most=1)[0]
    *_, last = next_round(stop(0.05), film)
    film = film.merge(part(values, last))  # out of turn, and nothing of what comes before
    while pieces := next_round(stop(0.05), film):
        for piece in pieces:
            assert piece.start >= last.stop
            film = film.merge(part(values, piece))
    assert (film.count[:, :32] <= PILOT + last.stop - last.start).all()
    assert outcome(stop(0.05), film, 1.0)["met"]


# What it is for


def test_tiles_meet_their_error() -> None:
    """Noise that differs by a factor of a hundred: every tile meets its error by its own variances, none by far where
    the pilot did not do, and the variances tell the truth."""
    random = np.random.default_rng(11)
    scale = np.repeat(np.repeat(np.geomspace(0.01, 1, 12).reshape(3, 4), TILE, 0), TILE, 1)
    values = 1 + scale * (random.exponential(1, (1200, *scale.shape)) - 1)
    film = rounds(stop(0.05), values)[-1]
    errors = np.sqrt(tiles(film.variance()[..., 0])) / film.mean_luminance()
    assert errors.max() <= 0.05
    assert np.sqrt(tiles((film.mean[..., 0] - 1) ** 2)).max() == pytest.approx(errors.max(), rel=0.1)
    needs_more = tiles(scale**2) / PILOT > 0.05**2
    assert errors[needs_more].min() > 0.04
    assert (film.count[:TILE, :TILE] == PILOT).all()
    assert outcome(stop(0.05), film, 1.0)["met"]


def heavy(random: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Log-normal, mean 1, variance 3.2; its fourth moment is 500 times the square of that."""
    return np.exp(random.normal(-0.72, 1.2, shape))


def until_low(values: Array, error: float) -> float:
    """The mean of a pixel (samples) that stops when its own variance says so: what is not done here."""
    count = PILOT
    while (needed := values[:count].var(ddof=1) / (error * values[:count].mean()) ** 2) > count:
        count = min(max(int(needed / AIM**2), count + 1), len(values))
    return float(values[:count].mean())


def test_means_and_variances_are_unbiased(rng: Rng) -> None:
    """Exactly, after three decisions: of pictures so small that a pixel has one judge. The usual rule is off by many
    standard errors, on the same numbers."""
    random, error = rng(21), 0.2
    means, variances, usual = [], [], []
    for _ in range(800):
        values = heavy(random, (4000, 2, 2))
        film = rounds(stop(error), values, most=4)[-1]
        means.append(film.mean.mean())
        variances.append((film.variance() * film.count[..., None]).mean())
        usual.append(np.mean([until_low(values[:, y, x], error) for y in range(2) for x in range(2)]))
    accept_mean(means, 1.0, "judged by others: mean")
    accept_mean(variances, np.exp(1.44) - 1, "judged by others: variance", exact=False)
    off = (1.0 - np.mean(usual)) / (np.std(usual, ddof=1) / np.sqrt(len(usual)))
    assert off > 10, "the usual rule should be seen to be biased here"


# What is said of it


def test_what_is_said_of_a_contract() -> None:
    film = still(np.ones((2, 2)), count=64)
    done = outcome(SamplesStop(samples=64), film, 3.0)
    assert done == {
        "kind": "samples", "asked": 64, "reached": 64, "met": True, "says": "64 of 64 samples of every pixel.",
    }  # fmt: skip
    assert not outcome(SamplesStop(samples=65), film, 3.0)["met"]
    timed = outcome(SecondsStop(seconds=3), film, 2.9)
    assert (timed["kind"], timed["asked"], timed["reached"], timed["met"]) == ("seconds", 3, 2.9, True)
    found = outcome(stop(0.125), film, 3.0)
    assert found["reached"] == pytest.approx(0.125)
    assert "12.5 % of the mean luminance; 12.5 % was asked for." in found["says"]
    assert outcome(stop(0.12), film, 3.0)["met"] is False


def test_the_error_of_a_contract_is_the_worst_tiles_or_the_pictures() -> None:
    variance = np.zeros((TILE, 2 * TILE))
    variance[:, TILE:] = 4.0
    film = still(variance, mean=2.0, count=100)
    assert relative_error(stop(0.1), film) == pytest.approx(0.2 / 2)
    assert relative_error(stop(0.1, "image"), film) == pytest.approx(0.2 / 2 / np.sqrt(2))
    assert relative_error(stop(0.1), still(np.zeros((2, 2)), mean=0.0)) == 0
    assert relative_error(stop(0.1), still(np.ones((2, 2)), mean=0.0)) is None
    assert relative_error(stop(0.1), still(np.ones((2, 2)), count=1)) is None
