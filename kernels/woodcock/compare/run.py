"""The rendering of a comparison: every variant for equal time, in turns, so that a machine's moods hit all alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache

from woodcock import series
from woodcock.compare.efficiency import Slice
from woodcock.compare.judge import Row, row
from woodcock.compare.vary import CompareError, Variant, seeded
from woodcock.device import Device
from woodcock.film import Film
from woodcock.pace import Pace
from woodcock.plan import lay_out
from woodcock.probe import best_lanes, probe
from woodcock.reference import Reference
from woodcock.render import Renderer, program_of, read_file
from woodcock.scene import Scene

#: Turns that every variant gets, if its samples are quick enough.
TURNS = 20
#: Samples of a turn, at least: fewer have no variance.
LEAST_SAMPLES = 2

#: Tells of progress: seconds rendered of all variants, and how many there will be.
Progress = Callable[[float, float], None]


@dataclass(frozen=True)
class Outcome:
    """rows, films: by the order of the variants, and by label. same: labels that were left out, each with the one that
    compiles to the same program."""

    rows: list[Row]
    films: dict[str, Film]
    same: dict[str, str]


@dataclass
class Racer:
    """A variant on the device. seconds: of its rendering so far."""

    variant: Variant
    renderer: Renderer
    default: bool
    film: Film
    pace: Pace = field(default_factory=Pace)
    slices: list[Slice] = field(default_factory=list)
    points: list[series.Point] = field(default_factory=list)
    seconds: float = 0.0

    def turn(self, seconds: float, reference: Reference | None) -> None:
        """Renders for so long. The turns before say how many samples that takes, never what this one does: to drop the
        slow ones would be a bias."""
        samples = max(LEAST_SAMPLES, self.pace.size(seconds))
        start = time.perf_counter()
        film = self.renderer.render(self.film.samples, self.film.samples + samples)
        spent = time.perf_counter() - start
        self.pace.measured(samples, spent)
        self.seconds += spent
        self.slices.append(Slice(spent, samples, film.rmse() ** 2 * samples))
        self.film = self.film.merge(film)
        if series.due(self.points, self.film):
            self.note(reference)

    def note(self, reference: Reference | None) -> None:
        """A point of the error series, unless there is one of as many samples."""
        if self.points and self.points[-1]["samples"] == self.film.mean_samples:
            return
        if (point := series.measure(self.film, self.seconds, self.seconds, reference)) is not None:
            self.points.append(point)


def run(
    scene: Scene,
    variants: Sequence[Variant],
    device: Device,
    seconds: float,
    reference: Reference | None = None,
    progress: Progress | None = None,
) -> Outcome:
    """Renders every variant of the scene for so many seconds; reading and building do not count.

    Variants have seeds of their own, so that their errors are independent, of those of the reference too. Raises
    CompareError where all compile to one program, DeviceError, and what `lay_out` raises.
    """
    racers, same = _prepare(scene, variants, device, None if reference is None else reference.seed)
    if len(racers) < 2:
        raise CompareError("there is nothing to compare: all variants of this scene compile to the same program")
    total = seconds * len(racers)
    while waiting := [racer for racer in racers if racer.seconds < (1 - 0.5 / TURNS) * seconds]:
        for racer in waiting:
            racer.turn(min(seconds / TURNS, seconds - racer.seconds), reference)
            if progress:
                progress(sum(min(each.seconds, seconds) for each in racers), total)
    rows = [_row(racer, reference) for racer in racers]
    return Outcome(rows, {racer.variant.label: racer.film for racer in racers}, same)


def _prepare(
    scene: Scene, variants: Sequence[Variant], device: Device, taken: int | None
) -> tuple[list[Racer], dict[str, str]]:
    """The variants on the device, and warm: what a first launch costs beside is not counted. The second as Outcome has
    it. taken: a seed that none may have."""
    read = cache(read_file)
    own, _ = program_of(lay_out(scene, read), device, best_lanes(device, probe(device)))
    racers, hashes, same = list[Racer](), dict[str, str](), dict[str, str]()
    for variant in seeded(variants, scene.seed, taken):
        renderer = Renderer(variant.scene, device, read=read)
        if renderer.program_hash in hashes:
            same[variant.label] = hashes[renderer.program_hash]
            continue
        hashes[renderer.program_hash] = variant.label
        film = Film.empty(scene.film.width, scene.film.height, renderer.names)
        racer = Racer(variant, renderer, renderer.program_hash == own.hash, film)
        start = time.perf_counter()
        renderer.render(0, LEAST_SAMPLES)
        racer.pace.measured(LEAST_SAMPLES, time.perf_counter() - start)
        racers.append(racer)
    return racers, same


def _row(racer: Racer, reference: Reference | None) -> Row:
    racer.note(reference)
    return row(
        racer.variant.label,
        racer.variant.choices,
        racer.film,
        racer.slices,
        racer.points,
        build_seconds=sum(racer.renderer.seconds.values()),
        default=racer.default,
        against=None if reference is None else series.against(racer.film, reference),
    )
