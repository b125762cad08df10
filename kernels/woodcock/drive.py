"""One renderer, asked for range after range until the scene's contract is met."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Protocol

from woodcock.contract import Piece, next_round
from woodcock.film import Film
from woodcock.pace import RANGE_SECONDS, Pace, fit
from woodcock.reference import Reference
from woodcock.render import Pixels
from woodcock.scene import Scene, SecondsStop
from woodcock.series import Point, due, measure

#: Told before every range: how much of the way is done, from 0 to 1, the film, and its error series so far.
OnProgress = Callable[[float, Film, Sequence[Point]], None]


class Renders(Protocol):
    """What is driven: a Renderer, or what stands for one."""

    @property
    def names(self) -> tuple[str, ...]: ...

    def render(self, start: int, stop: int, pixels: Pixels = None) -> Film: ...


def drive(
    renderer: Renders, scene: Scene, on_progress: OnProgress, reference: Reference | None = None
) -> tuple[Film, list[Point], dict[str, float]]:
    """The film, its error series (against the reference, if any), and the wall seconds of render, merge and check.

    Contracts of a relative error are rounds, and know the work of each only when it begins: what is done counts of all
    that is known.
    """
    stop, pace, series = scene.stop, Pace(), list[Point]()
    film = Film.empty(scene.film.width, scene.film.height, renderer.names)
    everything = film.count.size
    pieces: list[Piece] = []
    seconds = dict.fromkeys(("render", "merge", "check"), 0.0)
    began = time.perf_counter()
    while pieces or (pieces := next_round(stop, film)):
        elapsed, pixels = time.perf_counter() - began, pieces[0].width(everything)
        if isinstance(stop, SecondsStop):
            count, done = fit(pace, stop.seconds - elapsed, film.samples == 0, pixels), elapsed / stop.seconds
        else:
            held = int(film.count.sum())
            left = sum((piece.stop - piece.start) * piece.width(everything) for piece in pieces)
            count, done = pace.size(RANGE_SECONDS, pixels), held / (held + left)
        if count == 0:
            break
        on_progress(min(done, 1.0), film, series)
        piece, rest = pieces.pop(0).cut(count)
        pieces = rest + pieces
        start = time.perf_counter()
        part = renderer.render(piece.start, piece.stop, piece.pixels)
        rendered = time.perf_counter()
        film = film.merge(part)
        del part  # it would be held while the next is rendered
        merged = time.perf_counter()
        pace.measured(piece.stop - piece.start, rendered - start, pixels)
        seconds["render"] += rendered - start
        seconds["merge"] += merged - rendered
        if due(series, film) and (point := measure(film, merged - began, seconds["render"], reference)):
            series.append(point)
        seconds["check"] += time.perf_counter() - merged
    ended = time.perf_counter() - began
    if not series or film.mean_samples > series[-1]["samples"]:
        series += [point] if (point := measure(film, ended, seconds["render"], reference)) else []
    return film, series, seconds
