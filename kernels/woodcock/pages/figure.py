"""A chart on a page: drawn twice, for wide screens and for phones, with its key and its points as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from woodcock.pages.chart import Chart, draw
from woodcock.pages.svg import drawing, marker, written


@dataclass(frozen=True)
class Figure:
    """key: marker and name of every curve; head, rows: the table."""

    wide: Markup
    narrow: Markup
    key: Sequence[tuple[Markup, str]]
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def figure(chart: Chart, head: Sequence[str], rows: Sequence[Sequence[str]]) -> Figure | None:
    """None where there is nothing to draw."""
    wide, narrow = draw(chart), draw(chart, narrow=True)
    if wide is None or narrow is None:
        return None
    key = [(swatch(curve.look), curve.name) for curve in chart.curves if curve.dots]
    return Figure(written(wide), written(narrow), key, head, rows)


def swatch(look: int) -> Markup:
    """A curve's marker in a line of text."""
    mark = drawing(14, 14, "", "swatch")
    del mark.attrib["aria-label"], mark.attrib["role"]
    mark.set("aria-hidden", "true")
    marker(mark, look, 7, 7)
    return written(mark)
