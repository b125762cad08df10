"""Programs of the integrators without random numbers: numbers in double precision, and films with bounds.

exp(-τ) is to be right to 1e-5 at any τ where float32 can express it: at τ = 87 that asks for τ to 1e-7, which float32
cannot hold. So where a device has doubles, these programs run on lanes of doubles, and every number of the scene's
record is eight bytes wide; elsewhere they run on floats, and the bound says what that costs.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from woodcock.film import Film
from woodcock.layout import WIDTHS, Layout
from woodcock.program import Program, entry, flatten, world
from woodcock.space import Array

#: C types of a record's members, in a program of floats and in one of doubles.
WIDE = {"float": "double", "int": "long", "uint": "ulong"}


def lanes_of(lanes: int, *, precise: bool) -> int:
    """Lanes of a program on a device that runs `lanes` of floats: doubles are twice as wide."""
    return lanes // 2 if precise and lanes > 4 else lanes


def compose(layout: Layout, lanes: int, *, precise: bool) -> Program:
    """The program of a layout for a width of lanes, of doubles if precise."""
    parts = [
        f"core/lanes_{lanes}_double.h" if precise else f"core/lanes_{lanes}.h",
        f"core/precision_{'double' if precise else 'float'}.h",
        *("core/rng.h", "core/vector.h", f"core/spectrum_{layout.channels}.h"),
        structs(layout, precise=precise),
        *layout.before_world,
        world(layout),
        *layout.after_world,
        f"integrator/{layout.integrator}.cl",
        entry(layout),
    ]
    return Program(flatten(parts), lanes)


def structs(layout: Layout, *, precise: bool) -> str:
    """`Layout.structs`, its members eight bytes wide if precise. vector3, affine and colour follow `number`."""
    text = layout.structs()
    return re.sub(r"\b(float|int|uint)\b", lambda name: WIDE[name[0]], text) if precise else text


def pack(layout: Layout, *, precise: bool) -> NDArray[np.generic]:
    """`Layout.pack`, the numbers unrounded if precise."""
    if not precise:
        return layout.pack()
    words: list[NDArray[np.uint64]] = []
    for record in layout.records:
        for name, ctype in record.fields.items():
            kind = {"int": np.int64, "uint": np.uint64}.get(ctype, np.float64)
            flat = np.asarray(record.values[name], kind).reshape(-1)
            size = layout.channels if ctype == "colour" else WIDTHS[ctype]
            words.append(np.broadcast_to(flat, size).copy().view(np.uint64))
    return np.concatenate(words)


def film(
    sums: NDArray[np.float32],
    samples: tuple[int, int],
    size: tuple[int, int],
    names: tuple[str, ...],
    exponents: Array,
    rejected: int,
) -> Film:
    """The Film of a launch of the samples [start, stop).

    sums: (channels, 4, at least pixels), as the kernel leaves them: a pair of the sum of values and one of the sum of
    bounds on their errors; size: (height, width); exponents: of two, of the channels' units.
    """
    (height, width), (start, stop) = size, samples
    pairs = sums[..., : width * height].astype(np.float64)
    value, bound = ((pairs[:, plane] + pairs[:, plane + 1]).T.reshape(height, width, -1) for plane in (0, 2))
    stored = value * 2.0**-24 + 2.0**-149  # what a picture of floats leaves of a number
    mean, bound = (np.ldexp(total / (stop - start), exponents) for total in (value, bound + stored))
    count = np.full((height, width), stop - start, np.uint32)
    return Film(count, mean, np.zeros(mean.shape), names, (samples,), rejected, bound=bound)
