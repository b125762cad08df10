"""Random words in the orders a render takes them in, made by the device code: what batteries of tests read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from woodcock.device import Context
from woodcock.program import OPTIONS, flatten

Words = NDArray[np.uint32]

#: Addresses at a time: 64 MiB of words.
CHUNK = 1 << 22


@dataclass(frozen=True)
class Stream:
    """The address of the i-th step as C expressions of the word i, and which of its four words are read.

    `hashed` makes the words; `packed` turns words (n, of step) into those a battery reads.
    """

    pixel: str
    sample: str
    dimension: str
    seed: str = "7u"
    parts: str = "xyzw"
    hashed: str = "rng_next(&at, (mask)-1)"
    packed: Callable[[Words], Words] = np.ravel


def high_bits(words: Words) -> Words:
    """The 24 bits that `unit` takes of a word, one after the other."""
    return np.ascontiguousarray(words.reshape(-1, 1).view(np.uint8)[:, 1:]).reshape(-1).view(np.uint32)


def low_bits(words: Words) -> Words:
    """The 8 bits that it leaves."""
    return np.ascontiguousarray(words.reshape(-1, 1).view(np.uint8)[:, 0]).view(np.uint32)


def reversed_bits(words: Words) -> Words:
    """The lowest bit first: batteries look at high bits harder."""
    octets = np.packbits(np.unpackbits(np.arange(256, dtype=np.uint8)), bitorder="little")
    return octets[words.reshape(-1).view(np.uint8)].view(np.uint32).byteswap()


def words(context: Context, stream: Stream, lanes: int, start: int = 0) -> Iterator[Words]:
    """The stream's words from the step `start` on, in pieces; 2³² steps at most."""
    store = "\n".join(
        f"    lanes_store(v.{part}, result + {index * CHUNK}u + step);" for index, part in enumerate(stream.parts)
    )
    text = f"""
__kernel void stream(__global uint *result, uint first) {{
    const uint step = (uint)get_global_id(0) * LANES;
    word i = (word)(first + step) + integer_as_word(lane_index());
    rng_address at = {{{stream.pixel}, {stream.sample}, {stream.dimension}, {stream.seed}}};
    words v = {stream.hashed};
{store}
}}
"""
    kernel = context.build(flatten([f"core/lanes_{lanes}.h", "core/rng.h", text]), OPTIONS, "stream")
    made = np.zeros((len(stream.parts), CHUNK), np.uint32)
    buffer = context.output(made)
    for first in range(start, 1 << 32, CHUNK):
        kernel(context.queue, (CHUNK // lanes,), None, buffer, np.uint32(first))
        context.download(made, buffer)
        yield stream.packed(np.ascontiguousarray(made.T))
