"""Error against time, both logarithmic: curves with markers, a fitted line in its band, the slope -1/2, a goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from woodcock.pages import words
from woodcock.pages.axis import Axis
from woodcock.pages.svg import LETTER, add, drawing, fitted, marker, path

#: Width and least height of a figure on a page, and of one on a phone.
WIDE, NARROW = (760.0, 400.0), (340.0, 280.0)
LINE_HEIGHT = 16.0


@dataclass(frozen=True)
class Dot:
    """x: seconds; y: relative error; says: in words, shown when it is pointed at."""

    x: float
    y: float
    says: str


@dataclass(frozen=True)
class Fit:
    """A slope of log y over log x, drawn through the last dot, which is known best; low, high: its 95 % band."""

    slope: float
    low: float
    high: float


@dataclass(frozen=True)
class Curve:
    """dots: by rising x; look: its colour and marker; fit: drawn in place of a line from dot to dot."""

    name: str
    dots: Sequence[Dot]
    look: int = 0
    fit: Fit | None = None


@dataclass(frozen=True)
class Chart:
    """says: what it shows, for those who do not see it; goal: an error to reach."""

    curves: Sequence[Curve]
    x_name: str
    y_name: str
    says: str
    goal: float | None = None


def draw(chart: Chart, narrow: bool = False) -> Element | None:
    """None where there is no dot to draw."""
    curves = [curve for curve in chart.curves if curve.dots]
    if not curves:
        return None
    width, height = NARROW if narrow else WIDE
    names = len(curves) > 1 and not narrow
    if names:
        height = max(height, LINE_HEIGHT * len(curves) + 80)
    right = 24.0 + (LETTER * max(len(curve.name) for curve in curves) if names else 0.0)
    right = min(right, 0.36 * width)
    left, top, bottom = (50.0, 30.0, 44.0) if narrow else (64.0, 14.0, 48.0)
    goal = [] if chart.goal is None else [chart.goal]
    x = Axis.over((dot.x for curve in curves for dot in curve.dots), left, width - right)
    y = Axis.over([*(dot.y for curve in curves for dot in curve.dots), *goal], height - bottom, top)
    figure = drawing(width, height, chart.says, f"chart {'narrow' if narrow else 'wide'}")
    _axes(figure, chart, x, y, narrow)
    for curve in curves:
        _curve(figure, curve, x, y, narrow, shaded=curve is curves[0])
    _guide(figure, curves[0], x, y)
    if chart.goal is not None:
        at = y.at(chart.goal)
        add(figure, "line", x1=x.start, x2=x.stop, y1=at, y2=at, css="goal")
        add(figure, "text", f"goal {words.percent(chart.goal)}", x=x.start + 6, y=at - 5, css="goal-name")
    if names:
        _names(figure, curves, x, y, width)
    return figure


def _axes(figure: Element, chart: Chart, x: Axis, y: Axis, narrow: bool) -> None:
    base, left = y.start, x.start
    for value in y.ticks(34):
        add(figure, "line", x1=left, x2=x.stop, y1=y.at(value), y2=y.at(value), css="grid")
        add(figure, "text", f"{words.tick(100 * value)} %", x=left - 7, y=y.at(value) + 4, text_anchor="end")
    for value in x.ticks(48 if narrow else 64):
        add(figure, "line", x1=x.at(value), x2=x.at(value), y1=y.stop, y2=base, css="grid")
        add(figure, "text", f"{words.tick(value)} s", x=x.at(value), y=base + 16, text_anchor="middle")
    add(figure, "path", d=path([(left, y.stop), (left, base), (x.stop, base)]), css="axis")
    add(figure, "text", chart.x_name, x=(left + x.stop) / 2, y=base + 36, text_anchor="middle", css="axis-name")
    if narrow:
        add(figure, "text", chart.y_name, x=2, y=y.stop - 16, css="axis-name")
        return
    middle = (y.stop + base) / 2
    turned = f"rotate(-90 12 {middle:.1f})"
    add(figure, "text", chart.y_name, x=12, y=middle, text_anchor="middle", transform=turned, css="axis-name")


def _guide(figure: Element, curve: Curve, x: Axis, y: Axis) -> None:
    """The slope -1/2 through the curve's last dot, as far as the picture goes."""
    last = curve.dots[-1]

    def height(at: float) -> float:
        return last.y * math.sqrt(last.x / at)

    from_, to = max(x.low, last.x * (last.y / y.high) ** 2), min(x.high, last.x * (last.y / y.low) ** 2)
    ends = [(x.at(at), y.at(height(at))) for at in (from_, to)]
    add(figure, "path", d=path(ends), css="guide")
    (x1, y1), (x2, y2) = ends
    angle = math.degrees(math.atan2(y2 - y1, x2 - x1))
    at_x, at_y = x1 + 0.06 * (x2 - x1), y1 + 0.06 * (y2 - y1)
    turned = f"rotate({angle:.1f} {at_x:.1f} {at_y:.1f})"
    add(figure, "text", "slope −½", x=at_x, y=at_y - 6, transform=turned, css="guide-name")


def _curve(figure: Element, curve: Curve, x: Axis, y: Axis, narrow: bool, shaded: bool) -> None:
    """shaded: with the band of its fit, which one curve alone can have without hiding others."""
    group = add(figure, "g", css=f"curve look-{curve.look % 8}")
    if curve.fit is not None and len(curve.dots) > 2:
        steep, middle, flat = _fan(curve.dots, curve.fit, x, y)
        corner = [(x.at(curve.dots[0].x), y.stop)] if steep[0][0] > flat[0][0] else []
        if shaded:
            add(group, "path", d=path([steep[1], steep[0], *corner, flat[0]], closed=True), css="band")
        add(group, "path", d=path(middle), css="fit")
    else:
        add(group, "path", d=path([(x.at(dot.x), y.at(dot.y)) for dot in curve.dots]), css="line")
    for dot in curve.dots:
        add(marker(group, curve.look, x.at(dot.x), y.at(dot.y), 2.8 if narrow else 3.6), "title", dot.says)


def _fan(dots: Sequence[Dot], fit: Fit, x: Axis, y: Axis) -> list[list[tuple[float, float]]]:
    """The lines of the least, the fitted and the largest slope, from the first dot's time to the last dot."""
    first, last = dots[0], dots[-1]
    lines = []
    for slope in (fit.low, fit.slope, fit.high):
        begins = max(first.x, last.x * (y.high / last.y) ** (1 / slope)) if slope < 0 else first.x
        height = last.y * (begins / last.x) ** slope
        lines.append([(x.at(begins), y.clipped(height)), (x.at(last.x), y.at(last.y))])
    return lines


def _names(figure: Element, curves: Sequence[Curve], x: Axis, y: Axis, width: float) -> None:
    """Every curve's name at its end, moved apart where they would overlap, with a line to the end that it is of."""
    order = sorted(curves, key=lambda curve: y.at(curve.dots[-1].y))
    wanted = [y.at(curve.dots[-1].y) for curve in order]
    places = spread(wanted, LINE_HEIGHT, y.stop + 4, y.start)
    for curve, end, place in zip(order, wanted, places, strict=True):
        start = x.at(curve.dots[-1].x) + 5
        leader = path([(start, end), (x.stop + 2, place), (x.stop + 8, place)])
        add(figure, "path", d=leader, css=f"leader look-{curve.look % 8}")
        add(figure, "text", fitted(curve.name, width - x.stop - 12), x=x.stop + 12, y=place + 4, css="name")


def spread(wanted: Sequence[float], room: float, low: float, high: float) -> list[float]:
    """Places in rising order, at least `room` apart and within [low, high], as near as may be to the wanted ones.

    Neighbours that are too close become a block around their mean, and blocks that meet become one.
    """
    blocks: list[tuple[float, int]] = []  # sum of what the first member would want, count

    def first(block: tuple[float, int]) -> float:
        most = high - (block[1] - 1) * room
        return max(low, min(block[0] / block[1], most))

    for place in wanted:
        blocks.append((place, 1))
        while len(blocks) > 1 and first(blocks[-1]) < first(blocks[-2]) + blocks[-2][1] * room:
            total, count = blocks.pop()
            before, already = blocks.pop()
            blocks.append((before + total - count * already * room, already + count))
    return [first(block) + k * room for block in blocks for k in range(block[1])]
