"""A scene on a device: reads, builds, uploads once; then renders any range of samples into a Film."""

from __future__ import annotations

import time
from copy import copy
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from woodcock import deterministic
from woodcock.batches import Batches
from woodcock.device import Context, Device
from woodcock.drift import Drift, drift
from woodcock.faults import audited
from woodcock.film import Film
from woodcock.formats import Grid, read_grid
from woodcock.generic import is_widened, widen
from woodcock.launch import Launcher, statistics
from woodcock.layers import exponents
from woodcock.layout import Layout, Read
from woodcock.leanness import contents
from woodcock.markers import built, is_wide
from woodcock.plan import lay_out
from woodcock.probe import best_lanes, probe
from woodcock.program import Program, compose
from woodcock.repair import MOST_ROUNDS, is_bound, raised
from woodcock.report import Facts
from woodcock.scene import Scene

#: A launch's sums are pairs of floats; this many samples keep them exact to float64 rounding of the merge.
LARGEST_LAUNCH = 1 << 16


#: Indices of pixels; None for all.
Pixels: TypeAlias = NDArray[np.int32] | None
T = TypeVar("T", bound=np.generic)


def read_file(file: str, name: str | None) -> Grid:
    return read_grid(Path(file), name)


def program_of(layout: Layout, device: Device, lanes: int) -> tuple[Program, bool]:
    """A layout's program for a device that runs so many lanes of floats; and is it of doubles?"""
    if not layout.deterministic:
        return compose(layout, lanes), False
    width = deterministic.lanes_of(lanes, precise=device.doubles)
    return compose(layout, width, precise=device.doubles), device.doubles


class Renderer:
    """A scene made ready on a device. seconds: of read, build and upload; kinds: compiled in, by concept; full: by the
    program with everything switched on.

    Raises VolumeError for a volume that cannot be read, DeviceError for a device that cannot do it.
    """

    def __init__(
        self,
        scene: Scene,
        device: Device,
        *,
        lanes: int | None = None,
        read: Read = read_file,
        full: bool = False,
        layout: Layout | None = None,
    ) -> None:
        """read: gives the scene's grids, by file and name; full: by the program with everything switched on; layout: of
        the scene, where there is one already.
        """
        self.device = device
        self.lanes = lanes or best_lanes(device, probe(device))
        self.seconds: dict[str, float] = {}
        self._film = scene.film

        start = time.perf_counter()
        layout = layout or (widen if full else lay_out)(scene, read)
        self.kinds = {concept: list(kinds) for concept, kinds in layout.kinds.items()}
        self.names, self.full = layout.names, is_widened(layout)
        space = layout.space
        self._exponents = np.array(exponents(self.names, space.radiance_exponent, space.length_exponent))
        self.seconds["read"] = (read_at := time.perf_counter()) - start

        program, precise = program_of(layout, device, self.lanes)
        self._precision: Literal["float", "double"] = "double" if precise else "float"
        self.lanes, self.program_hash = program.lanes, program.hash
        self._launcher = Launcher(Context.on(device), program, len(self.names), {})
        self._contents = contents(program, self._launcher.context, self._launcher.kernel)
        self.seconds["build"] = (built_at := time.perf_counter()) - read_at

        self._launcher.upload({"scene": layout.pack(precise=precise), **layout.buffers})
        self._layout = _without_volumes(layout)
        self.seconds["upload"] = (uploaded := time.perf_counter()) - built_at
        # Some drivers compile at the first launch, for the size of its groups; that is no rendering.
        pixels = scene.film.width * scene.film.height
        self._launcher.run(pixels if is_wide(pixels, self.lanes) else 1, 0, 1)
        built(device, program, pixels)
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
            "program": self._contents,
        }

    def render(self, start: int, stop: int, pixels: Pixels = None) -> Film:
        """Exactly the samples [start, stop) of every pixel, or of those with these indices y × width + x."""
        firsts = range(start, stop, LARGEST_LAUNCH)
        films = (self._launch(first, min(stop, first + LARGEST_LAUNCH), pixels) for first in firsts)
        film = next(films, None) or Film.empty(self._film.width, self._film.height, self.names)
        return reduce(Film.merge, films, film)

    @property
    def size(self) -> tuple[int, int]:
        """Of its pictures, width and height."""
        return self._film.width, self._film.height

    @property
    def listed(self) -> bool:
        """Does rendering some pixels cost less than rendering all?"""
        return self._launcher.listed

    def through(self, width: int, height: int) -> Renderer:
        """The same view through so many pixels, by the same program; what it learns of majorants stays its own."""
        other = copy(self)
        other._film = self._film.model_copy(update={"width": width, "height": height})
        other._layout = self._layout.through(width, height)
        other._launcher = self._launcher.with_inputs({"scene": other._layout.pack(precise=self._precision == "double")})
        return other

    def drift(self) -> Drift | None:
        """What float32 does to the picture; None where it has none, or the device has no doubles to tell by."""
        return None if self.deterministic or not self.device.doubles else drift(self._layout, self._launcher)

    @property
    def deterministic(self) -> bool:
        """Does it render without random numbers?"""
        return self._layout.deterministic

    def _launch(self, first: int, stop: int, pixels: Pixels) -> Film:
        width, height, samples = self._film.width, self._film.height, stop - first
        sums, planes = self._run(first, samples, pixels)
        found, excess = audited(planes)
        for _ in range(MOST_ROUNDS):
            if not excess:
                break
            self._raise_majorant(excess)
            sums, planes = self._run(first, samples, pixels)
            again, excess = audited(planes)
            found = replace(again, repaired=found.repaired + found.violations)
        if self.deterministic:
            return deterministic.film(sums, (first, stop), (height, width), self.names, self._exponents, found)
        mean, m2 = statistics(sums, samples)
        film = Film(
            self._placed(np.full((len(mean), 1), samples, np.uint32), pixels)[..., 0],
            self._placed(mean * 2.0**self._exponents, pixels),
            self._placed(m2 * 4.0**self._exponents, pixels),
            self.names,
            ((first, stop),),
            found,
        )
        return replace(film, batches=Batches(1, 0.0, samples, film.mean_luminance())) if pixels is None else film

    def _run(self, first: int, samples: int, pixels: Pixels) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        everything = self._film.width * self._film.height
        if pixels is None or self._launcher.listed:
            return self._launcher.run(everything if pixels is None else pixels, first, samples)
        sums, planes = self._launcher.run(everything, first, samples)
        return sums[..., pixels], planes[:, pixels]

    def _placed(self, values: NDArray[T], pixels: Pixels) -> NDArray[T]:
        """Values (pixels, channels) in the picture, 0 elsewhere."""
        picture = values
        if pixels is not None:
            picture = np.zeros((self._film.height * self._film.width, values.shape[1]), values.dtype)
            picture[pixels] = values
        return picture.reshape(self._film.height, self._film.width, -1)

    def _raise_majorant(self, excess: float) -> None:
        self._layout = raised(self._layout, excess)
        bounds = {name: array for name, array in self._layout.buffers.items() if is_bound(name)}
        self._launcher.upload({"scene": self._layout.pack(), **bounds})


def _without_volumes(layout: Layout) -> Layout:
    """The layout without the arrays that only the device needs: of those, an empty one tells the type."""
    kept = {name: array if is_bound(name) else np.empty(0, array.dtype) for name, array in layout.buffers.items()}
    return replace(layout, buffers=kept)
