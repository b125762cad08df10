"""The legend of false colour: a bar with numbers below it, and above it as shares of the mean luminance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree.ElementTree import Element

from markupsafe import Markup

from woodcock.pages import words
from woodcock.pages.axis import Axis
from woodcock.pages.pictures import Scale
from woodcock.pages.svg import add, drawing, written

WIDTH, EDGE, BAR = 288.0, 22.0, 10.0
#: Rectangles that the bar is made of.
STEPS = 64


def legend(scale: Scale, mean: float = 0.0) -> Markup:
    """mean: 1 of the shares; 0 where they mean nothing."""
    shares = mean > 0
    top = 30.0 if shares else 6.0
    says = f"Scale from {words.number(scale.low)} to {words.number(scale.high)} {scale.unit}"
    figure = drawing(WIDTH, top + 42, says, "legend")
    start, stop = EDGE, WIDTH - EDGE
    width = (stop - start) / STEPS
    for step, colour in enumerate(scale.ramp(STEPS)):
        # A little wider than a step, so that no seam shows.
        add(figure, "rect", x=start + step * width, y=top, width=width + 0.4, height=BAR, fill=_hex(colour))
    for value in _ticks(scale, start, stop):
        _tick(figure, _at(scale, value, start, stop), top + BAR, words.tick(value), 1)
    add(figure, "text", scale.unit, x=WIDTH / 2, y=top + BAR + 30, text_anchor="middle", css="axis-name")
    if shares:
        of_mean = Scale(scale.low / mean, scale.high / mean, "", scale.logarithmic, scale.diverging)
        for value in _ticks(of_mean, start, stop):
            _tick(figure, _at(of_mean, value, start, stop), top, f"{words.tick(round(100 * value, 12))} %", -1)
        add(figure, "text", "of the mean luminance", x=WIDTH / 2, y=8, text_anchor="middle", css="axis-name")
    return written(figure)


def _tick(figure: Element, x: float, y: float, text: str, side: int) -> None:
    add(figure, "line", x1=x, x2=x, y1=y, y2=y + 3 * side, css="axis")
    add(figure, "text", text, x=x, y=y + (15 if side > 0 else -6), text_anchor="middle")


def _ticks(scale: Scale, start: float, stop: float) -> Sequence[float]:
    if scale.logarithmic:
        return Axis(scale.low, scale.high, start, stop).ticks(52)
    step = _round_step((scale.high - scale.low) / 4)
    first, last = math.ceil(scale.low / step - 1e-9), math.floor(scale.high / step + 1e-9)
    return [k * step for k in range(first, last + 1)]


def _round_step(wanted: float) -> float:
    power = 10.0 ** math.floor(math.log10(wanted))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= wanted * (1 - 1e-9))


def _at(scale: Scale, value: float, start: float, stop: float) -> float:
    if scale.logarithmic:
        return Axis(scale.low, scale.high, start, stop).at(value)
    return start + (value - scale.low) / (scale.high - scale.low) * (stop - start)


def _hex(colour: Sequence[float]) -> str:
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour)
