"""A scene on a device: reads, builds, uploads once; then renders any range of samples into a Film."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from woodcock import deterministic
from woodcock.batches import Batches
from woodcock.device import Context, Device
from woodcock.drift import Drift, drift
from woodcock.faults import audited
from woodcock.film import Film
from woodcock.formats import Grid, read_grid
from woodcock.launch import Launcher, statistics
from woodcock.layers import exponents, layer_names
from woodcock.layout import Layout, Read
from woodcock.plan import lay_out
from woodcock.probe import best_lanes, probe
from woodcock.program import Program, compose
from woodcock.repair import MOST_ROUNDS, is_bound, raised
from woodcock.report import Facts
from woodcock.scene import Scene

#: A launch's sums are pairs of floats; this many samples keep them exact to float64 rounding of the merge.
LARGEST_LAUNCH = 1 << 16


def read_file(file: str, name: str | None) -> Grid:
    return read_grid(Path(file), name)


def program_of(layout: Layout, device: Device, lanes: int) -> tuple[Program, bool]:
    """A layout's program for a device that runs so many lanes of floats; and is it of doubles?"""
    if not layout.deterministic:
        return compose(layout, lanes), False
    width = deterministic.lanes_of(lanes, precise=device.doubles)
    return compose(layout, width, precise=device.doubles), device.doubles


class Renderer:
    """A scene made ready on a device. seconds: of read, build and upload; kinds: compiled in, by concept.

    Raises VolumeError for a volume that cannot be read, DeviceError for a device that cannot do it.
    """

    def __init__(self, scene: Scene, device: Device, *, lanes: int | None = None, read: Read = read_file) -> None:
        """read: gives the scene's grids, by file and name."""
        self.device = device
        self.lanes = lanes or best_lanes(device, probe(device))
        self.seconds: dict[str, float] = {}
        self._film = scene.film

        start = time.perf_counter()
        layout = lay_out(scene, read)
        self.kinds = {concept: list(kinds) for concept, kinds in layout.kinds.items()}
        self.names = layer_names(scene, layout.channels)
        space = layout.space
        self._exponents = np.array(exponents(self.names, space.radiance_exponent, space.length_exponent))
        self.seconds["read"] = (read_at := time.perf_counter()) - start

        program, precise = program_of(layout, device, self.lanes)
        self._precision: Literal["float", "double"] = "double" if precise else "float"
        self.lanes, self.program_hash = program.lanes, program.hash
        self._launcher = Launcher(Context.on(device), program, len(self.names), {})
        self.seconds["build"] = (built := time.perf_counter()) - read_at

        self._launcher.upload({"scene": layout.pack(precise=precise), **layout.buffers})
        self._layout = _without_volumes(layout)
        self.seconds["upload"] = (uploaded := time.perf_counter()) - built
        # Some drivers compile at the first launch, for the size of its groups; that is no rendering.
        self._launcher.run(1, 0, 1)
        self.seconds["build"] += time.perf_counter() - uploaded

    def facts(self) -> Facts:
        """What a report says of the scene on this device."""
        return {
            "id": self.device.id,
            "name": self.device.name,
            "kind": self.device.kind,
            "platform": self.device.platform,
            "platform_version": self.device.platform_version,
            "version": self.device.version,
            "driver": self.device.driver,
            "lanes": self.lanes,
            "program_hash": self.program_hash,
            "kinds": self.kinds,
            "precision": self._precision,
            "norm": self._layout.facts.get("norm"),
            "unscattered": self._layout.facts.get("unscattered"),
            "media": self._layout.facts.get("media", []),
            "seconds": self.seconds,
        }

    def render(self, start: int, stop: int) -> Film:
        """Exactly the samples [start, stop) of every pixel."""
        film = Film.empty(self._film.width, self._film.height, self.names)
        for first in range(start, stop, LARGEST_LAUNCH):
            film = film.merge(self._launch(first, min(stop, first + LARGEST_LAUNCH)))
        return film

    def drift(self) -> Drift | None:
        """What float32 does to the picture; None where it has none, or the device has no doubles to tell by."""
        return drift(self._layout, self._launcher) if self._random and self.device.doubles else None

    @property
    def _random(self) -> bool:
        return not self._layout.deterministic

    def _launch(self, first: int, stop: int) -> Film:
        width, height, samples = self._film.width, self._film.height, stop - first
        sums, planes = self._launcher.run(width * height, first, samples)
        found, excess = audited(planes)
        for _ in range(MOST_ROUNDS):
            if not excess:
                break
            self._raise_majorant(excess)
            sums, planes = self._launcher.run(width * height, first, samples)
            again, excess = audited(planes)
            found = replace(again, repaired=found.repaired + found.violations)
        if not self._random:
            return deterministic.film(sums, (first, stop), (height, width), self.names, self._exponents, found)
        mean, m2 = statistics(sums, samples)
        return Film(
            np.full((height, width), samples, np.uint32),
            np.ldexp(mean.reshape(height, width, -1), self._exponents),
            np.ldexp(m2.reshape(height, width, -1), 2 * self._exponents),
            self.names,
            ((first, stop),),
            found,
            Batches(1),
        )

    def _raise_majorant(self, excess: float) -> None:
        self._layout = raised(self._layout, excess)
        bounds = {name: array for name, array in self._layout.buffers.items() if is_bound(name)}
        self._launcher.upload({"scene": self._layout.pack(), **bounds})


def _without_volumes(layout: Layout) -> Layout:
    """The layout without the arrays that only the device needs: of those, an empty one tells the type."""
    kept = {name: array if is_bound(name) else np.empty(0, array.dtype) for name, array in layout.buffers.items()}
    return replace(layout, buffers=kept)
