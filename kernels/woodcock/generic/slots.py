"""Places for what a scene may hold: arrays of one length whatever the scene, and kinds in one order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, get_args

import numpy as np

from woodcock.layout import WIDTHS, Record

Values = Mapping[str, Any]


def kinds(union: Any) -> tuple[str, ...]:
    """The kinds of a union of the scene's models; a kind's number on the device is its position."""
    return tuple(model.model_fields["kind"].default for model in get_args(get_args(union)[0]))


def nothing(fields: Mapping[str, str]) -> dict[str, Any]:
    """Values of what is not there: zeros."""
    return {name: 0 if ctype in ("int", "uint") else np.zeros(WIDTHS.get(ctype, 1)) for name, ctype in fields.items()}


def single(concept: str, kind: str, member: str, fields: Mapping[str, str], values: Values | None) -> Record:
    """A record that may be empty."""
    return Record(concept, kind, member, fields, nothing(fields) if values is None else values)


def array(
    concept: str, kind: str, member: str, fields: Mapping[str, str], rows: Sequence[Values | None], room: int
) -> Record:
    """At least two and `room` elements; None and what is beyond the rows is empty."""
    padded = [*rows, *[None] * (max(room, 2) - len(rows))]
    first, *others = (nothing(fields) if row is None else row for row in padded)
    return Record(concept, kind, member, fields, first, tuple(others))
