"""Which samples are handed out, and how many at once."""

from __future__ import annotations

import numpy as np
import pytest

from woodcock.contract import Piece
from woodcock.pace import GROWTH, RANGE_SECONDS, Pace, fit
from woodcock_server.ranges import BUSY, FILM, HANDING_SECONDS, LONGEST_SECONDS, Pool, length, share, turn_of


def measured(rate: float, last: int) -> Pace:
    """Of samples of all pixels of a picture of 100; rate: of those, per second."""
    pace = Pace()
    pace.measured(last, last / rate, 100)
    return pace


def test_a_pool_hands_every_sample_out_once() -> None:
    few = np.array([3, 5], np.int32)
    pieces = [Piece(2, 5, None), Piece(9, 10, None), Piece(10, 17, few)]
    for size in (1, 2, 100):
        pool = Pool(pieces, 100)
        assert pool.left == 400 + 14
        taken: list[int] = []
        while pool.left:
            pixels, piece = pool.pixels, pool.take(size)
            assert 0 < piece.stop - piece.start <= size
            assert piece.pixels is (few if piece.start >= 10 else None)
            assert pixels == (2 if piece.start >= 10 else 100)
            taken += range(piece.start, piece.stop)
        assert taken == [2, 3, 4, *range(9, 17)]
        assert (pool.left, pool.pixels) == (0, 0)


def pool(samples: int, pixels: int | None = None) -> Pool:
    """Of so many samples of a picture of 100 pixels, or of some of them."""
    return Pool([Piece(0, samples, None if pixels is None else np.arange(pixels, dtype=np.int32))], 100)


def test_a_range_takes_about_a_second_and_its_pieces_end() -> None:
    pace = measured(rate=100, last=90)
    assert share(pace, pool(10_000), 100 * 100) == pytest.approx(100 * RANGE_SECONDS, abs=1)
    assert share(Pace(), pool(10_000), 0) == 1


def test_ranges_are_as_long_as_the_dispatcher_needs() -> None:
    """It is busy for half of the time, however many devices it has and however large the picture."""
    assert length(turn_of(2, 0.045)) == RANGE_SECONDS
    for devices, merging in ((200, 0.0), (20, 0.045), (100, 0.045)):
        seconds = length(turn_of(devices, merging))
        assert RANGE_SECONDS < seconds < LONGEST_SECONDS
        assert devices * (HANDING_SECONDS + FILM * merging) == pytest.approx(BUSY * seconds)
    assert length(turn_of(10_000, 0.045)) == LONGEST_SECONDS
    assert length(turn_of(10_000, 0.045), longest=0.5) == RANGE_SECONDS
    pace = measured(rate=100, last=90)
    assert share(pace, pool(10_000), 100 * 100, seconds=3) == pytest.approx(300, abs=1)
    assert fit(pace, 20, nothing_yet=False, pixels=100, longest=3) == pytest.approx(300, abs=1)


def test_few_pixels_take_less_time() -> None:
    """Work is counted in paths: a fifth of the pixels, five times the samples in the same time."""
    pace = measured(rate=100, last=90)
    assert share(pace, pool(10_000, 20), 100 * 100) == pytest.approx(500 * RANGE_SECONDS, abs=1)
    assert fit(pace, 0.2, nothing_yet=False, pixels=20) == pytest.approx(100, abs=1)


def test_ranges_grow_by_steps() -> None:
    assert share(measured(rate=1e6, last=1), pool(10_000), 1e8) == GROWTH
    assert share(measured(rate=1e6, last=3), pool(10_000, 1), 1e8) == 3 * GROWTH, "a device may not be full"


def test_at_the_end_each_device_takes_its_share() -> None:
    slow, fast = measured(rate=50, last=50), measured(rate=150, last=150)
    assert share(slow, pool(40), 200 * 100) == 10
    assert share(fast, pool(40), 200 * 100) == 30
    assert share(slow, pool(8), 200 * 100) == 5, "a range of less than 0.1 s is not worth handing out"
    assert share(slow, pool(40), 200 * 100, turn=0.4) == 20, "nor one for which others would wait"


def test_seconds_that_are_left_limit_a_range() -> None:
    pace = measured(rate=100, last=100)
    assert fit(pace, 20, nothing_yet=False, pixels=100) == pytest.approx(100, abs=1)
    assert fit(pace, 0.2, nothing_yet=False, pixels=100) == pytest.approx(20, abs=1)
    assert fit(pace, 0.001, nothing_yet=False, pixels=100) == 0
    assert fit(pace, -1, nothing_yet=False, pixels=100) == 0
    assert fit(measured(rate=0.01, last=1), 20, nothing_yet=False, pixels=100) == 0, "one sample would take 100 s"


def test_one_sample_at_least() -> None:
    assert fit(Pace(), -1, nothing_yet=True) == 1
    assert fit(Pace(), 5, nothing_yet=False) == 1
