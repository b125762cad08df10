"""Lets everything pass: only a boundary of the index-matched kind."""

from __future__ import annotations

from woodcock.scene.surface import NullMaterial
from woodcock.space import Array, Space

FIELDS: dict[str, str] = {}
DELTA = True


def record(material: NullMaterial, space: Space) -> dict[str, Array]:
    return {}
