"""An object of a Mitsuba scene: its properties by name, each with its type, and a record of which were read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from woodcock.importing import colour, transforms
from woodcock.importing.colour import Colour
from woodcock.importing.mitsuba.xml import Document, Node
from woodcock.importing.report import Report, SourceError, integer, number, shown
from woodcock.importing.transforms import Array

#: Elements that are values and no objects.
VALUES = ("float", "integer", "boolean", "string", "rgb", "vector", "point", "transform")

#: Objects of a scene that only matter where others refer to them.
DEFINITIONS = ("bsdf", "medium", "phase", "volume", "texture", "spectrum", "rfilter", "sampler", "film")


class Element:
    """Nothing of an element is dropped in silence: `leftovers` lists what nobody read or passed over on purpose."""

    def __init__(self, node: Node, document: Document, report: Report, seen: dict[int, Element]) -> None:
        self.tag, self.where, self.folder = node.tag, node.where, node.folder
        self.kind = node.attributes.get("type", "")
        self.id = node.attributes.get("id", "")
        self._document, self._report, self._seen = document, report, seen
        self._values: dict[str, Node] = {}
        self._objects: list[tuple[str, Node]] = []
        self._read: set[int] = set()
        self.used = False
        for child in node.children:
            name = child.attributes.get("name", "")
            if child.tag in VALUES or (child.tag == "spectrum" and "value" in child.attributes):
                if name in self._values:
                    raise SourceError(f"{child.where}: {shown(name)} is given twice")
                self._values[name] = child
            else:
                self._objects.append((name, child))
        seen[id(node)] = self

    def _of(self, node: Node) -> Element:
        if node.tag == "ref":
            node = self._document.find(node.attributes.get("id", ""), node.where)
        return self._seen.get(id(node)) or Element(node, self._document, self._report, self._seen)

    def __contains__(self, name: str) -> bool:
        return name in self._values or any(name == known for known, _ in self._objects)

    def at(self, name: str) -> str:
        return self._values[name].where if name in self._values else self.where

    def objects(self, *tags: str) -> Iterator[tuple[str, Element]]:
        """The objects of these tags inside, with the names that they have here."""
        for name, node in self._objects:
            element = self._of(node)
            if element.tag in tags:
                self._read.add(id(node))
                element.used = True
                yield name, element

    def object(self, name: str, *tags: str) -> Element | None:
        return next((element for known, element in self.objects(*tags) if known == name), None)

    def passed_over(self, *names: str) -> None:
        """Properties that change nothing in the picture's mean."""
        for name in names:
            if name in self._values:
                self._read.add(id(self._values[name]))

    def left_out(self) -> None:
        """What is inside goes with the object, which is listed itself."""
        self._read.update(map(id, self._values.values()), (id(node) for _, node in self._objects))

    def leftovers(self) -> None:
        named = f"<{self.tag} type={shown(self.kind)}>" if self.kind else f"<{self.tag}>"
        for node in [*self._values.values(), *(node for _, node in self._objects)]:
            if id(node) not in self._read and not (self.tag == "scene" and node.tag in DEFINITIONS):
                what = node.attributes.get("name") or node.attributes.get("type") or node.attributes.get("id", "")
                self._report.note(node.where, f"<{node.tag[:40]}> {shown(what)} of {named} is not carried over")

    # Values

    def _value(self, name: str, *tags: str) -> Node | None:
        node = self._values.get(name)
        if node is not None:
            self._read.add(id(node))
            if node.tag not in tags:
                raise SourceError(f"{node.where}: {shown(name)} must be <{tags[0]}>, not <{node.tag}>")
        return node

    def _text(self, name: str, *tags: str) -> tuple[str, str] | None:
        node = self._value(name, *tags)
        if node is None:
            return None
        if "value" not in node.attributes:
            raise SourceError(f"{node.where}: <{node.tag}> needs the attribute value")
        return node.attributes["value"].strip(), node.where

    def number(self, name: str, default: float) -> float:
        found = self._text(name, "float", "integer")
        return default if found is None else number(*found, name)

    def integer(self, name: str, default: int) -> int:
        found = self._text(name, "integer")
        return default if found is None else integer(*found, name)

    def boolean(self, name: str, default: bool) -> bool:
        found = self._text(name, "boolean")
        if found is None:
            return default
        if found[0].lower() not in ("true", "false"):
            raise SourceError(f"{found[1]}: {name} must be true or false, not {shown(found[0])}")
        return found[0].lower() == "true"

    def string(self, name: str, default: str | None = None) -> str:
        found = self._text(name, "string")
        if found is None:
            if default is None:
                raise SourceError(f'{self.where}: <{self.tag} type={shown(self.kind)}> needs <string name="{name}">')
            return default
        return found[0]

    def vector(self, name: str) -> Array | None:
        node = self._value(name, "vector", "point")
        return None if node is None else _vector(node, 0.0)

    def spectrum(self, name: str, default: Colour, emitted: bool = False) -> Colour:
        """A value or a <spectrum> that has one; textures and the like leave the default, and are listed.

        An even <spectrum> that is `emitted` is not grey, because white is D65.
        """
        node = self._value(name, "rgb", "spectrum", "float", "integer")
        if node is not None:
            return self._colour(node, name, emitted)
        if (inner := self.object(name, "spectrum", "texture", "volume")) is None:
            return default
        return inner.as_spectrum(default)

    def as_spectrum(self, default: Colour) -> Colour:
        """This object as a colour."""
        match self.kind:
            case "uniform" | "constvolume" | "rgb" | "srgb" | "d65":
                found = self.spectrum("color" if self.kind in ("rgb", "srgb", "d65") else "value", 1.0)
                scale = self.number("scale", 1.0) if self.kind == "d65" else 1.0
                return colour.simple(scale * colour.triple(found))
        self._report.note(
            self.where, f"the {self.tag} {shown(self.kind)} is not carried over; {_written(default)} stands for it"
        )
        self.left_out()
        return default

    def _colour(self, node: Node, name: str, emitted: bool) -> Colour:
        text = node.attributes.get("value", "").strip()
        if node.tag == "rgb" and re.fullmatch(r"#[0-9a-fA-F]{6}", text):
            return colour.simple([colour.from_srgb(int(text[i : i + 2], 16)) for i in (1, 3, 5)])
        if node.tag == "spectrum" and ":" in text:
            pairs = [pair.split(":", 1) for pair in re.split(r"[\s,]+", text) if pair]
            if not all(len(pair) == 2 for pair in pairs):
                raise SourceError(f"{node.where}: {name} must be wavelength:value pairs, not {shown(text)}")
            wavelengths, values = ([number(pair[i], node.where, name) for pair in pairs] for i in (0, 1))
            found = colour.of_samples(wavelengths, values, emitted)
            if len(set(values)) > 1:
                self._report.note(node.where, f"the spectrum of {name} is approximated by {_written(found)}")
            return found
        values = [number(part, node.where, name) for part in re.split(r"[\s,]+", text)]
        if len(values) not in ((1, 3) if node.tag == "rgb" else (1,)):
            raise SourceError(f"{node.where}: {name} must hold one number or three, not {len(values)}")
        if node.tag == "spectrum":
            return colour.of_samples([0.0], values, emitted)
        return colour.simple(values if len(values) == 3 else values * 3)

    def transform(self, name: str = "to_world") -> Array:
        node = self._value(name, "transform")
        matrix = transforms.identity()
        for step in node.children if node is not None else []:
            matrix = _step(step) @ matrix
        return matrix if node is None else transforms.check(matrix, node.where)

    def file(self, name: str = "filename") -> tuple[str, Path, str]:
        """Name, folder that it is relative to, and where it says so."""
        return self.string(name), self.folder, self.at(name)


def _written(value: Colour) -> str:
    return " ".join(f"{part:.3g}" for part in ([value] if isinstance(value, float | int) else value))


def _vector(node: Node, default: float) -> Array:
    attributes = node.attributes
    if "value" in attributes:
        parts = re.split(r"[\s,]+", attributes["value"].strip())
        if len(parts) not in (1, 3):
            raise SourceError(f"{node.where}: <{node.tag}> must hold one number or three, not {len(parts)}")
        values = [number(part, node.where, "value") for part in parts]
        return np.array(values * 3 if len(values) == 1 else values)
    return np.array([number(attributes[a], node.where, a) if a in attributes else default for a in "xyz"])


def _triple(node: Node, name: str) -> Array:
    if name not in node.attributes:
        raise SourceError(f"{node.where}: <{node.tag}> needs the attribute {name}")
    parts = re.split(r"[\s,]+", node.attributes[name].strip())
    if len(parts) != 3:
        raise SourceError(f"{node.where}: {name} must hold three numbers, not {len(parts)}")
    return np.array([number(part, node.where, name) for part in parts])


def _any_up(forward: Array, where: str) -> Array:
    """The direction that Mitsuba takes where none is given: Duff et al. (2017), Building an Orthonormal Basis."""
    x, y, z = transforms.unit(forward, where, "the way from origin to target")
    sign = np.copysign(1.0, z)
    a = -1 / (sign + z)
    return np.array([sign * x * x * a + 1, sign * x * y * a, -sign * x])


def _step(node: Node) -> Array:
    match node.tag:
        case "translate":
            return transforms.translate(*_vector(node, 0.0))
        case "scale":
            return transforms.scale(*_vector(node, 1.0))
        case "rotate":
            angle = number(node.attributes.get("angle", "0"), node.where, "angle")
            return transforms.rotate(_vector(node, 0.0), angle, node.where)
        case "lookat":
            origin, target = _triple(node, "origin"), _triple(node, "target")
            up = _triple(node, "up") if "up" in node.attributes else _any_up(target - origin, node.where)
            return transforms.look_at(origin, target, up, node.where)
        case "matrix":
            parts = re.split(r"[\s,]+", node.attributes.get("value", "").strip())
            values = [number(part, node.where, "matrix") for part in parts]
            matrix = np.eye(4)
            if len(values) == 16:
                matrix = np.array(values).reshape(4, 4)
            elif len(values) == 9:
                matrix[:3, :3] = np.array(values).reshape(3, 3)
            else:
                raise SourceError(f"{node.where}: <matrix> must hold 16 numbers, or 9, not {len(values)}")
            return matrix
    raise SourceError(
        f"{node.where}: <{node.tag[:40]}> is no transform; known are translate, scale, rotate, lookat and matrix"
    )
