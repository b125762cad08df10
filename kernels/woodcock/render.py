"""A scene on a device: reads, builds, uploads once; then renders any range of samples into a Film."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from woodcock import deterministic
from woodcock.device import Context, Device
from woodcock.film import Film
from woodcock.formats import Grid, read_grid
from woodcock.layers import exponents, layer_names
from woodcock.plan import lay_out
from woodcock.probe import best_lanes, probe
from woodcock.program import OPTIONS, compose
from woodcock.report import Facts
from woodcock.scene import Scene

#: A launch's sums are pairs of floats; this many samples keep them exact to float64 rounding of the merge.
LARGEST_LAUNCH = 1 << 16
#: Work items of a group: a warp of a GPU, and on a CPU few enough that no core waits long for the others.
GROUP = 32


class Renderer:
    """A scene made ready on a device. seconds: of read, build and upload; kinds: compiled in, by concept.

    Raises VolumeError for a volume that cannot be read, DeviceError for a device that cannot do it.
    """

    def __init__(self, scene: Scene, device: Device, *, lanes: int | None = None) -> None:
        self.device = device
        self.lanes = lanes or best_lanes(device, probe(device))
        self.seconds: dict[str, float] = {}
        self._film = scene.film

        start = time.perf_counter()
        layout = lay_out(scene, _read)
        self.kinds = {concept: list(kinds) for concept, kinds in layout.kinds.items()}
        self.names = layer_names(scene, layout.channels)
        space = layout.space
        self._exponents = np.array(exponents(self.names, space.radiance_exponent, space.length_exponent))
        self.seconds["read"] = (read := time.perf_counter()) - start

        self._deterministic, precise = layout.deterministic, layout.deterministic and device.doubles
        self._precision: Literal["float", "double"] = "double" if precise else "float"
        if layout.deterministic:
            self.lanes = deterministic.lanes_of(self.lanes, precise=precise)
            program, numbers = (
                deterministic.compose(layout, self.lanes, precise=precise),
                deterministic.pack(layout, precise=precise),
            )
        else:
            program, numbers = compose(layout, self.lanes), layout.pack()
        self._facts = layout.facts
        self.program_hash = program.hash
        self._context = Context.on(device)
        self._kernel = self._context.build(program.text, OPTIONS, "render")
        self.seconds["build"] = (built := time.perf_counter()) - read

        self._inputs = [self._context.upload(array) for array in (numbers, *layout.buffers.values())]
        self.seconds["upload"] = (uploaded := time.perf_counter()) - built
        # Some drivers compile at the first launch, for the size of its groups; that is no rendering.
        self._run(1, 0, 1)
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
            "norm": self._facts.get("norm"),
            "unscattered": self._facts.get("unscattered"),
            "media": self._facts.get("media", []),
            "seconds": self.seconds,
        }

    def render(self, start: int, stop: int) -> Film:
        """Exactly the samples [start, stop) of every pixel."""
        film = Film.empty(self._film.width, self._film.height, self.names)
        for first in range(start, stop, LARGEST_LAUNCH):
            film = film.merge(self._launch(first, min(stop, first + LARGEST_LAUNCH)))
        return film

    def _launch(self, first: int, stop: int) -> Film:
        width, height, samples = self._film.width, self._film.height, stop - first
        sums, faults = self._run(-(-width * height // (self.lanes * GROUP)), first, samples)
        size = (height, width)
        if self._deterministic:
            rejected = int(faults[0, : width * height].sum(dtype=np.uint64))
            return deterministic.film(sums, (first, stop), size, self.names, self._exponents, rejected)
        mean, m2 = _statistics(sums[..., : width * height], samples)
        rejected, violations = faults[:, : width * height].sum(axis=1, dtype=np.uint64)
        return Film(
            np.full((height, width), samples, np.uint32),
            np.ldexp(mean.reshape(height, width, -1), self._exponents),
            np.ldexp(m2.reshape(height, width, -1), 2 * self._exponents),
            self.names,
            ((first, stop),),
            int(rejected),
            int(violations),
        )

    def _run(self, groups: int, first: int, samples: int) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """The kernel's sums (names, 4, lanes) and faults (2, lanes) of so many groups."""
        items = groups * GROUP
        sums = np.zeros((len(self.names), 4, items * self.lanes), np.float32)
        faults = np.zeros((2, items * self.lanes), np.uint32)
        outputs = [self._context.output(array) for array in (sums, faults)]
        numbers = np.uint32(first), np.uint32(samples)
        self._kernel(self._context.queue, (items,), (GROUP,), *self._inputs, *outputs, *numbers)
        for array, buffer in zip((sums, faults), outputs, strict=True):
            self._context.download(array, buffer)
        return sums, faults


def _statistics(sums: NDArray[np.float32], samples: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and M2, (pixels, names), of the kernel's pairs (names, 4, pixels)."""
    pairs = sums.astype(np.float64)
    total, squares = pairs[:, 0] + pairs[:, 1], pairs[:, 2] + pairs[:, 3]
    mean = total / samples
    return mean.T, np.maximum(squares - total * mean, 0).T


def _read(file: str, name: str | None) -> Grid:
    return read_grid(Path(file), name)
