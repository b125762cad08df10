"""Controls for the cells of a majorant: the least of every medium, and a bound on what σ_t is above the sum of these.

A control holds where its majorant does: for every value that a lookup at any position of the cell may give, and a
little beyond its faces. Cells that lie partly outside a medium have 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from woodcock.majorant.grid import Bounded, Floats, bounds, combined
from woodcock.space import Array

#: Of the majorant, beyond the residual bound: what float32 rounds sums of σ_t by.
ROUNDING = 2.0**-21


@dataclass(frozen=True)
class Stored:
    """What controls need of a grid medium.

    channels: of what is stored of it, each with its numbers for values and a scale of 1; scale: (1,) or (3,), σ_t of a
    stored number of 1, in the scene.
    """

    channels: tuple[Bounded, ...]
    scale: Array


@dataclass(frozen=True)
class Control:
    """least: by medium and channel, [z][y][x] of stored numbers, float32; residual: [z][y][x], at least
    Σ (σ_t - control) in every channel, scene units."""

    least: tuple[tuple[Floats, ...], ...]
    residual: Array

    @classmethod
    def of(
        cls,
        media: Sequence[Stored],
        cells: tuple[int, int, int],
        box: tuple[Array, Array] | None,
        error: float,
        majorant: Array,
    ) -> Control:
        """box: low and high corner of the cells in the scene; None: the voxels of the only medium. majorant: [z][y][x],
        scene units; error: of positions, a length in the scene."""

        def extreme(channel: Bounded, of: np.ufunc) -> Array:
            if box is None:
                return bounds(channel, cells, error, of)
            return combined([channel], cells, *box, error, of)

        residual, every = np.zeros(cells[::-1]), []
        for medium in media:
            least = tuple(extreme(channel, np.minimum) for channel in medium.channels)
            spread = [extreme(channel, np.maximum) - low for channel, low in zip(medium.channels, least, strict=True)]
            count = max(len(medium.scale), len(spread))  # one may be grey and the other not
            pairs = zip(np.resize(medium.scale, count), (spread * count)[:count], strict=True)
            residual += np.max([scale * between for scale, between in pairs], axis=0)
            every.append(tuple(low.astype(np.float32) for low in least))
        return cls(tuple(every), np.where(residual > 0, residual + ROUNDING * majorant, 0.0))
