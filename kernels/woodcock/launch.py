"""A built program with what it reads: one launch renders a range of samples of every pixel."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.device import Context
from woodcock.faults import PLANES
from woodcock.program import OPTIONS, Program
from woodcock.space import Array


def group(lanes: int) -> int:
    """Work items of a group: a warp of a GPU, and on a CPU so few that no core waits long for the others at the end."""
    return 32 if lanes == 1 else 4


def work_items(pixels: int, lanes: int) -> int:
    """How many a launch over so many pixels takes: whole groups."""
    return -(-pixels // (lanes * group(lanes))) * group(lanes)


class Launcher:
    """inputs: on the device, by name; first the scene's record, then the program's buffers in order."""

    def __init__(self, context: Context, program: Program, channels: int, inputs: Mapping[str, Any]) -> None:
        """channels: of the film. Raises DeviceError for a program that the device cannot build."""
        self.context, self.lanes, self.listed, self.inputs = context, program.lanes, program.listed, dict(inputs)
        self._channels = channels
        self.kernel = context.build(program.text, OPTIONS, "render")

    def with_inputs(self, arrays: Mapping[str, Any]) -> Launcher:
        """The same program, reading other arrays by these names."""
        other = copy(self)
        other.inputs = dict(self.inputs)
        other.upload(arrays)
        return other

    def upload(self, arrays: Mapping[str, Any]) -> None:
        """Raises DeviceError for an array that is larger than the device takes."""
        for name, array in arrays.items():
            self.inputs[name] = self.context.upload(array)

    def run(
        self, pixels: int | NDArray[np.int32], first: int, samples: int
    ) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """Samples [first, first + samples) of the first so many pixels, or, by a program that takes a list, of those
        with these indices: sums (channels, 4, pixels), faults (PLANES, pixels)."""
        indices = np.arange(pixels, dtype=np.int32) if isinstance(pixels, int) else pixels
        pixels = indices.size
        items = work_items(pixels, self.lanes)
        sums = np.zeros((self._channels, 4, items * self.lanes), np.float32)
        faults = np.zeros((PLANES, items * self.lanes), np.uint32)
        outputs = [self.context.output(array) for array in (sums, faults)]
        numbers = np.uint32(first), np.uint32(samples)
        # Lanes beyond the list render some of its pixels once more.
        lists = [self.context.upload(np.resize(indices, items * self.lanes))] if self.listed else []
        self.kernel(
            self.context.queue, (items,), (group(self.lanes),), *self.inputs.values(), *lists, *outputs, *numbers
        )
        for array, buffer in zip((sums, faults), outputs, strict=True):
            self.context.download(array, buffer)
        return sums[..., :pixels], faults[:, :pixels]


def statistics(sums: NDArray[np.float32], samples: int) -> tuple[Array, Array]:
    """Mean and M2, (pixels, channels), of a launch's pairs (channels, 4, pixels)."""
    total, squares = (np.add(sums[:, part], sums[:, part + 1], dtype=np.float64) for part in (0, 2))
    mean = total / samples
    total *= mean
    squares -= total
    np.maximum(squares, 0, out=squares)
    # A square below 2^-126 may count as 0: so much is added where that is not nothing beside the rest.
    squares[(mean > 0) & (mean < 2.0**-50)] += samples * 2.0**-126
    return mean.T, squares.T
