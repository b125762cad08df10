"""Ratios with their intervals: a row each, a dot on a whisker, on a logarithmic axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from woodcock.pages import words
from woodcock.pages.axis import Axis
from woodcock.pages.svg import LETTER, add, drawing, fitted, marker, path

ROW = 22.0
#: Height of the axis with its numbers and its name, and what is above the rows.
FOOT, HEAD = 48.0, 26.0


@dataclass(frozen=True)
class Span:
    """A ratio. low, high: its interval, None where it is not known; hollow: not to be believed."""

    name: str
    value: float
    low: float | None
    high: float | None
    look: int
    hollow: bool = False


@dataclass(frozen=True)
class Group:
    """Rows under a heading, which may be empty."""

    heading: str
    spans: Sequence[Span]


def draw(groups: Sequence[Group], x_name: str, says: str, narrow: bool = False) -> Element:
    """At least one row. In a narrow figure names stand above their rows."""
    width = 340.0 if narrow else 760.0
    names = max(len(span.name) for group in groups for span in group.spans)
    left = 12.0 if narrow else min(LETTER * names + 34, 0.4 * width)
    row = 1.6 * ROW if narrow else ROW
    headings = sum(bool(group.heading) for group in groups)
    rows = sum(len(group.spans) for group in groups)
    base = 10 + rows * row + headings * HEAD
    values = [each for group in groups for span in group.spans for each in (span.value, span.low, span.high) if each]
    x = Axis.over([*values, 1.0], left, width - 20)
    figure = drawing(width, base + FOOT, says, f"chart {'narrow' if narrow else 'wide'}")
    for tick in x.ticks(56):
        add(figure, "line", x1=x.at(tick), x2=x.at(tick), y1=6, y2=base, css="grid")
        add(figure, "text", f"{words.tick(tick)} ×", x=x.at(tick), y=base + 16, text_anchor="middle")
    add(figure, "line", x1=x.at(1), x2=x.at(1), y1=6, y2=base, css="guide")
    add(figure, "path", d=path([(left, base), (width - 20, base)]), css="axis")
    room = width if narrow else width - left
    add(
        figure,
        "text",
        fitted(x_name, room),
        x=(left + width - 20) / 2,
        y=base + 38,
        text_anchor="middle",
        css="axis-name",
    )
    at = 10.0
    for group in groups:
        if group.heading:
            add(figure, "text", group.heading, x=2, y=at + 19, css="heading")
            at += HEAD
        for span in group.spans:
            _row(figure, span, x, at, row, narrow)
            at += row
    return figure


def _row(figure: Element, span: Span, x: Axis, top: float, height: float, narrow: bool) -> None:
    y = top + height - ROW / 2
    group = add(figure, "g", css=f"look-{span.look % 8}{' hollow' if span.hollow else ''}")
    name_y, name_x = (y - 12, 12.0) if narrow else (y + 4, 24.0)
    if not narrow:
        marker(group, span.look, 9, y, 3.6)
    room = x.stop if narrow else x.start - name_x
    add(group, "text", fitted(span.name, room), x=name_x, y=name_y, css="name")
    text = f"{span.name}: {words.number(span.value)} ×"
    if span.low is not None and span.high is not None:
        ends = [(x.at(span.low), y), (x.at(span.high), y)]
        add(group, "path", d=path(ends), css="whisker")
        for end, _ in ends:
            add(group, "line", x1=end, x2=end, y1=y - 3.5, y2=y + 3.5, css="whisker")
        text += f", 95 % interval {words.number(span.low)} to {words.number(span.high)}"
    add(marker(group, span.look, x.at(span.value), y, 4.0), "title", text)
