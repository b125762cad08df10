"""Which samples are handed out, and how many at once."""

from __future__ import annotations

import pytest

from woodcock.pace import GROWTH, RANGE_SECONDS, Pace, fit
from woodcock_server.ranges import Pool, share


def measured(rate: float, last: int) -> Pace:
    pace = Pace()
    pace.measured(last, last / rate)
    return pace


@pytest.mark.parametrize(
    ("done", "end", "expected"),
    [
        ((), 5, [0, 1, 2, 3, 4]),
        (((0, 5),), 5, []),
        (((0, 2),), 5, [2, 3, 4]),
        (((1, 2), (3, 4)), 6, [0, 2, 4, 5]),
        (((3, 9),), 5, [0, 1, 2]),
        (((7, 9),), 5, [0, 1, 2, 3, 4]),
    ],
)
def test_a_pool_holds_what_is_missing_and_hands_it_out_once(
    done: tuple[tuple[int, int], ...], end: int, expected: list[int]
) -> None:
    for size in (1, 2, 100):
        pool = Pool(done, end)
        assert pool.left == len(expected)
        taken: list[int] = []
        while pool.left:
            start, stop = pool.take(size)
            assert 0 < stop - start <= size
            taken += range(start, stop)
        assert taken == expected


def test_a_range_takes_about_a_second_and_never_more_than_is_left() -> None:
    pace = measured(rate=100, last=90)
    assert share(pace, 10_000, 100) == pytest.approx(100 * RANGE_SECONDS, abs=1)
    assert share(pace, 7, 100) == 7
    assert share(Pace(), 10_000, 0) == 1


def test_ranges_grow_by_steps() -> None:
    assert share(measured(rate=1e6, last=1), 10_000, 1e6) == GROWTH


def test_at_the_end_each_device_takes_its_share() -> None:
    slow, fast = measured(rate=50, last=50), measured(rate=150, last=150)
    assert share(slow, 40, 200) == 10
    assert share(fast, 40, 200) == 30
    assert share(slow, 8, 200) == 5, "a range of less than 0.1 s is not worth handing out"


def test_seconds_that_are_left_limit_a_range() -> None:
    pace = measured(rate=100, last=100)
    assert fit(pace, 20, nothing_yet=False) == pytest.approx(100, abs=1)
    assert fit(pace, 0.2, nothing_yet=False) == pytest.approx(20, abs=1)
    assert fit(pace, 0.001, nothing_yet=False) == 0
    assert fit(pace, -1, nothing_yet=False) == 0
    assert fit(measured(rate=0.01, last=1), 20, nothing_yet=False) == 0, "one sample would take 100 s"


def test_one_sample_at_least() -> None:
    assert fit(Pace(), -1, nothing_yet=True) == 1
    assert fit(Pace(), 5, nothing_yet=False) == 1
