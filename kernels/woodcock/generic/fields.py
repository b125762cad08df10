"""Where fields are stored: one after another in a buffer of their storage, so that any fields make one program."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from woodcock.volume.field import CHUNK, STORED, Buffer, Field

STORAGES = tuple(STORED)
#: Which voxels of which chunk are a field's: those of brick b lie in chunk + (b >> shift), from first + that brick's
#: place there on. channels: 0 where there is no field.
PLACE = {
    "storage": "int",
    "channels": "int",
    "nearest": "int",
    "chunk": "int",
    "shift": "int",
    "bricks": "int",
    "first": "int",
}
#: Shifts every brick of a field into its first chunk.
ONE = 31


class Fields:
    """Fields as they are added. Those of a storage share one chunk as far as they fit it."""

    def __init__(self) -> None:
        self._chunks: dict[str, list[list[Buffer]]] = {storage: [[]] for storage in STORAGES}

    def add(self, field: Field) -> dict[str, Any]:
        """The field's place."""
        chunks, shift = self._chunks[field.storage], field.shift(CHUNK)
        parts = field.chunks(shift)
        place = {
            "storage": STORAGES.index(field.storage),
            "channels": field.channels,
            "nearest": int(field.nearest),
        }
        if len(parts) > 1:
            at, first = len(chunks), 0
            chunks += [[part] for part in parts]
            return {**place, "chunk": at, "shift": shift, "bricks": (1 << shift) - 1, "first": first}
        sizes = [sum(part.nbytes for part in chunk) for chunk in chunks]
        at = next((i for i, size in enumerate(sizes) if size + parts[0].nbytes <= CHUNK), len(chunks))
        if at == len(chunks):
            chunks.append([])
        first = sum(part.size for part in chunks[at])
        chunks[at] += parts
        return {**place, "chunk": at, "shift": ONE, "bricks": (1 << ONE) - 1, "first": first}

    def buffers(self) -> dict[str, Buffer]:
        return {
            name: _joined(STORED[storage], chunk)
            for storage, chunks in self._chunks.items()
            for name, chunk in zip(_names(storage, len(chunks)), chunks, strict=True)
        }

    def text(self) -> str:
        """`field_number`, a stored number by storage, chunk and index."""
        cases = []
        for number, (storage, chunks) in enumerate(self._chunks.items()):
            names = _names(storage, len(chunks))
            if len(names) == 1:
                cases.append(f"    if (storage == {number}) return field_{storage}(world->{names[0]}, index);\n")
                continue
            body = "".join(
                f"        here = test(chunk == {i});\n"
                f"        if (some(here)) value = pick(value, field_{storage}(world->{name}, {_INDEX}), here);\n"
                for i, name in enumerate(names)
            )
            cases.append(f"    if (storage == {number}) {{\n        mask here;\n{body}    }}\n")
        return f"""\
static inline real field_number(const struct world *world, int storage, integer chunk, integer index) {{
    real value = (real)0.f;
{"".join(cases)}    return value;
}}
"""


_INDEX = "pick((integer)0, index, here)"


def _names(storage: str, count: int) -> list[str]:
    return [f"voxels_{storage}" + f"_{i}" * (i > 0) for i in range(count)]


def _joined(dtype: np.dtype[Any], parts: list[Buffer]) -> Buffer:
    kept: np.dtype[Any] = np.dtype(np.uint16) if dtype == np.float16 else dtype
    if not parts:
        return Buffer.of(np.zeros(1, kept))
    size = sum(part.size for part in parts)
    return Buffer(kept, size, lambda: itertools.chain.from_iterable(part.pieces() for part in parts))
