"""SVG as elements: what every figure is drawn with. Text is escaped by the serialiser."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from markupsafe import Markup

NAMESPACE = "http://www.w3.org/2000/svg"
#: Colours (classes look-0 to look-7 of style.css) and markers, so many each.
LOOKS = 8
#: Mean width of a letter in the figures' size of text.
LETTER = 7.0


def drawing(width: float, height: float, says: str, css: str) -> Element:
    """An empty figure; says: what it shows, for those who do not see it."""
    box = f"0 0 {width:g} {height:g}"
    return Element("svg", {"viewBox": box, "width": f"{width:g}", "role": "img", "aria-label": says, "class": css})


def add(parent: Element, tag: str, text: str | None = None, **attributes: float | str) -> Element:
    """A child; underscores in names of attributes stand for hyphens, and `css` for class."""
    names = {name: "class" if name == "css" else name.replace("_", "-") for name in attributes}
    written = {names[name]: _text(value) for name, value in attributes.items()}
    child = ElementTree.SubElement(parent, tag, written)
    child.text = text
    return child


def fitted(text: str, width: float) -> str:
    """Text cut to about so much room."""
    most = max(2, int(width / LETTER))
    return text if len(text) <= most else f"{text[: most - 1]}…"


def path(points: Sequence[tuple[float, float]], closed: bool = False) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + ("Z" if closed else "")


def marker(parent: Element, look: int, x: float, y: float, size: float = 4.0) -> Element:
    """A curve's marker around a point; with the colours there are 64 looks, each of its own."""
    colour, shape = look % LOOKS, (look + look // LOOKS) % LOOKS
    corners = {1: (4, 45.0), 2: (3, -90.0), 3: (4, 0.0), 4: (3, 90.0), 5: (5, -90.0)}
    if shape in corners:
        count, turn = corners[shape]
        radius = size * (1.35 if count == 3 else 1.25)
        angles = [math.radians(turn + 360 * k / count) for k in range(count)]
        d = path([(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles], closed=True)
    elif shape == 0:
        d = f"M{x - size:.1f} {y:.1f}a{size} {size} 0 1 0 {2 * size} 0a{size} {size} 0 1 0 {-2 * size} 0Z"
    else:
        turn = 0.0 if shape == 6 else 45.0
        d = "".join(
            path([(x + size * math.cos(a), y + size * math.sin(a)), (x - size * math.cos(a), y - size * math.sin(a))])
            for a in (math.radians(turn), math.radians(turn + 90))
        )
    return add(parent, "path", d=d, css=f"marker look-{colour}{' open' if shape in (6, 7) else ''}")


def written(figure: Element) -> Markup:
    """The figure as it stands in a page."""
    return Markup(ElementTree.tostring(figure, encoding="unicode", short_empty_elements=True))


def file(figure: Element, style: str) -> str:
    """The figure as a file of its own, with its style inside."""
    inside = Element("style")
    inside.text = style
    figure.insert(0, inside)
    figure.set("xmlns", NAMESPACE)
    return ElementTree.tostring(figure, encoding="unicode") + "\n"


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.1f}".rstrip("0").rstrip(".")
