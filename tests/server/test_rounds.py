"""Which device renders what, round by round: driven here by a clock of the test's own, without rendering."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from woodcock.contract import Piece
from woodcock.film import Film
from woodcock.pace import RANGE_SECONDS
from woodcock.scene import Scene
from woodcock_server import rounds
from woodcock_server.ranges import length, turn_of
from woodcock_server.rounds import AT_A_TIME, Rounds

Make = Callable[..., dict[str, Any]]


def film(start: int, stop: int, size: int = 4) -> Film:
    zeros = np.zeros((size, size, 1))
    count = np.full((size, size), stop - start, np.uint32)
    return Film(count, zeros, zeros, ("Y",), ((start, stop),))


@pytest.fixture
def scene(make_scene: Make) -> Callable[..., Scene]:
    return lambda **stop: Scene.model_validate(make_scene(size=4, stop=stop))


def drive(given: Rounds, speeds: dict[str, float], held: Film | None = None) -> tuple[float, dict[str, list[Piece]]]:
    """Renders one piece after the other on each device, at so many paths per second, merged at once; when it ended."""
    free, whole = dict.fromkeys(speeds, 0.0), held or Film.empty(4, 4, ("Y",))
    rendered, queues = ({device: list[Piece]() for device in speeds} for _ in range(2))
    now = 0.0
    while True:
        for device, queue in queues.items():
            while piece := given.take(device, now):
                if not queue:
                    free[device] = now
                queue.append(piece)
        ends = {device: free[device] + paths(queue[0]) / speeds[device] for device, queue in queues.items() if queue}
        if not ends:
            return now, rendered
        device = min(ends, key=lambda each: ends[each])
        piece, seconds = queues[device].pop(0), ends[device] - free[device]
        now = free[device] = ends[device]
        rendered[device].append(piece)
        given.rendered(device, seconds)
        whole = whole.merge(film(piece.start, piece.stop))
        if given.merged():
            given.begin(whole)


def paths(piece: Piece) -> int:
    return (piece.stop - piece.start) * (16 if piece.pixels is None else piece.pixels.size)


def samples(pieces: list[Piece]) -> list[int]:
    return [sample for piece in pieces for sample in range(piece.start, piece.stop)]


@pytest.mark.parametrize("held", [None, film(0, 700), film(300, 500), film(0, 2000)])
def test_every_sample_that_is_missing_is_rendered_once(scene: Callable[..., Scene], held: Film | None) -> None:
    given = Rounds(scene(kind="samples", samples=2000), ("a", "b"), held)
    end, rendered = drive(given, {"a": 1600, "b": 6400}, held)
    done = {sample for first, stop in (held.ranges if held else ()) for sample in range(first, stop)}
    assert sorted(samples(rendered["a"] + rendered["b"])) == [sample for sample in range(2000) if sample not in done]
    assert given.over
    share = len(samples(rendered["a"])) / max(1, 2000 - len(done))
    if not done:
        assert share == pytest.approx(0.2, abs=0.05)
        assert end == pytest.approx(2000 * 16 / 8000, rel=0.1), "both end at the same time"


def test_a_device_has_one_piece_to_render_and_one_that_waits(scene: Callable[..., Scene]) -> None:
    given = Rounds(scene(kind="samples", samples=2000), ("a",), None)
    taken = [given.take("a", 0.0) for _ in range(5)]
    assert [piece is not None for piece in taken] == [True] * AT_A_TIME + [False] * (5 - AT_A_TIME)
    assert not given.merged()


@pytest.mark.parametrize(("speed", "expected"), [(1600, 10 * 100), (1.6e6, 10 * 100_000), (0.1, 1)])
def test_seconds_end_by_the_clock_and_not_without_a_sample(
    scene: Callable[..., Scene], speed: float, expected: int
) -> None:
    given = Rounds(scene(kind="seconds", seconds=10), ("a",), None)
    end, rendered = drive(given, {"a": speed})
    assert len(samples(rendered["a"])) == pytest.approx(expected, rel=0.02)
    assert end == pytest.approx(max(10, 16 / speed), rel=0.02)
    assert given.timed_out
    assert not given.over


def test_seconds_that_are_spent_are_not_spent_again(scene: Callable[..., Scene]) -> None:
    given = Rounds(scene(kind="seconds", seconds=10), ("a",), film(0, 5))
    assert given.take("a", 10.5) is None
    assert given.timed_out
    assert (piece := given.take("a", 5.0)) is not None
    assert piece.start == 5


def test_a_round_waits_for_all_of_its_pieces(scene: Callable[..., Scene], monkeypatch: pytest.MonkeyPatch) -> None:
    """And the next is made of the film as it is then."""
    few = np.array([3, 5], np.int32)
    seen: list[int] = []

    def next_round(_stop: object, held: Film | None) -> list[Piece]:
        seen.append(held.samples if held else 0)
        return {0: [Piece(0, 2, None)], 2: [Piece(2, 4, few)], 4: []}[seen[-1]]

    monkeypatch.setattr(rounds, "next_round", next_round)
    given = Rounds(scene(kind="relative_error", relative_error=0.1), ("a", "b"), None)
    a, b = given.take("a", 0.0), given.take("b", 0.0)
    assert a is not None
    assert b is not None
    assert (a.stop, b.stop) == (1, 2)
    given.rendered("a", 0.1)
    assert not given.merged()
    assert given.take("a", 0.1) is None
    assert not given.timed_out, "it is another device that it waits for"
    given.rendered("b", 0.2)
    assert given.merged()
    given.begin(film(0, 2))
    assert not given.over
    third = given.take("a", 0.2)
    assert third is not None
    assert third.pixels is few
    assert (third.start, third.stop) == (2, 4), "few pixels take little time"
    given.rendered("a", 0.1)
    assert given.merged()
    given.begin(film(0, 4))
    assert given.over
    assert seen == [0, 2, 4]


def test_a_range_of_few_pixels_takes_as_long_as_one_of_all(
    scene: Callable[..., Scene], monkeypatch: pytest.MonkeyPatch
) -> None:
    few = np.arange(4, dtype=np.int32)
    monkeypatch.setattr(rounds, "next_round", lambda _stop, held: [Piece(held.samples if held else 0, 1 << 20, few)])
    given = Rounds(scene(kind="relative_error", relative_error=0.1), ("a",), film(0, 1))
    for _ in range(20):
        piece = given.take("a", 0.0)
        assert piece is not None
        given.rendered("a", paths(piece) / 1600)
        given.merged()
    assert paths(piece) / 1600 == pytest.approx(RANGE_SECONDS, rel=0.05)


@pytest.mark.parametrize("stop", [{"kind": "samples", "samples": 1 << 20}, {"kind": "seconds", "seconds": 1000}])
def test_ranges_grow_with_what_merging_them_takes(scene: Callable[..., Scene], stop: dict[str, Any]) -> None:
    given = Rounds(scene(**stop), ("a", "b"), None)
    for _ in range(20):
        piece = given.take("a", 0.0)
        assert piece is not None
        given.rendered("a", paths(piece) / 1600)
        given.merged(1.0)
    assert paths(piece) / 1600 == pytest.approx(length(turn_of(2, 1.0)), rel=0.05)


def test_what_a_device_had_is_rendered_by_others(scene: Callable[..., Scene]) -> None:
    given = Rounds(scene(kind="samples", samples=40), ("a", "b"), None)
    lost = [given.take("a", 0.0), given.take("a", 0.0)]
    kept = given.take("b", 0.0)
    assert kept is not None
    given.leave("a")
    given.rendered("b", 1.0)
    assert not given.merged()
    rest = []
    while piece := given.take("b", 0.0):
        given.rendered("b", 1.0)
        assert not given.over
        rest.append(piece)
        given.merged()
    assert all(piece is not None for piece in lost)
    assert sorted(samples([kept, *rest])) == list(range(40))
    given.join("a")
    assert given.take("a", 0.0) is None


def test_seconds_do_not_end_by_a_device_that_left_without_a_sample(scene: Callable[..., Scene]) -> None:
    given = Rounds(scene(kind="seconds", seconds=10), ("a",), None)
    assert given.take("a", 0.0) is not None
    given.leave("a")
    given.join("a")
    assert given.take("a", 60.0) is not None
