"""pbrt's directives: what they do to the graphics state, and the scene that they leave behind."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from woodcock.importing import transforms
from woodcock.importing.pbrt.parameters import Parameters, Texture
from woodcock.importing.pbrt.tokens import Tokens
from woodcock.importing.pbrt.world import Directive, Graphics, Shape, World
from woodcock.importing.report import Report, SourceError, number, shown
from woodcock.importing.transforms import Array

MAX_INCLUDES = 15
MAX_NESTED = 1 << 12
MAX_BYTES = 512 << 20

#: How many numbers follow.
NUMBERS = {"Translate": 3, "Scale": 3, "Rotate": 4, "LookAt": 9, "Transform": 16, "ConcatTransform": 16}
#: A name and parameters follow: of what stands before the world,
OPTIONS = ("Camera", "Film", "Sampler", "Integrator", "PixelFilter", "Accelerator")
#: and in it, with the target that `Attribute` has for it.
TARGETS = {
    "Shape": "shape",
    "LightSource": "light",
    "AreaLightSource": "light",
    "Material": "material",
    "MakeNamedMaterial": "material",
    "MakeNamedMedium": "medium",
}


class Reader:
    """Runs the directives of a file and of those that it includes."""

    def __init__(self, path: Path, report: Report) -> None:
        self.world, self._report, self._top = World(), report, path.parent
        self._graphics = Graphics()
        self._pushed: list[tuple[str, Graphics]] = []
        self._systems: dict[str, Array] = {}
        self._objects: dict[str, list[Shape]] = {}
        self._object: list[Shape] | None = None
        self._in_world = False
        self._files: list[Path] = []
        self._bytes = 0
        self._file(path, str(path))
        if not self._in_world:
            raise SourceError(f"{path}: has no WorldBegin: it is no scene of pbrt-v4")
        if self._pushed:
            raise SourceError(f"{path}: ends before the end of what {self._pushed[-1][0]} begins")

    def _file(self, path: Path, where: str) -> None:
        if path in self._files or len(self._files) > MAX_INCLUDES:
            raise SourceError(f"{where}: files include each other in a circle, or more than {MAX_INCLUDES} deep")
        tokens = Tokens(path, path.name if path.parent == self._top else str(path), where)
        self._bytes += tokens.size
        if self._bytes > MAX_BYTES:
            raise SourceError(f"{where}: the scene is larger than {MAX_BYTES >> 20} MiB")
        self._files.append(path)
        while tokens.peek() is not None:
            where, token = tokens.here, tokens.take()
            if token.quoted:
                raise SourceError(f"{where}: expected a directive, not the string {shown(token.text)}")
            self._directive(token.text, tokens, where)
        self._files.pop()

    def _directive(self, name: str, tokens: Tokens, where: str) -> None:
        if name in NUMBERS:
            self._transform(name, tokens, where)
        elif name in OPTIONS:
            self._option(name, tokens, where)
        elif name in TARGETS:
            self._make(name, tokens, where)
        elif name == "Option":
            self._parameters("Option", where, tokens).passed_over(
                "seed", "disablepixeljitter", "quiet", "msereferenceout"
            )
        elif (
            (method := getattr(self, f"_do_{name.lower()}", None)) is not None and name.isalpha() and name[0].isupper()
        ):
            method(tokens, where)
        else:
            raise SourceError(f"{where}: {shown(name)} is no directive of pbrt-v4")

    def _parameters(self, owner: str, where: str, tokens: Tokens, target: str = "") -> Parameters:
        parameters = Parameters(owner, where, self._files[-1].parent, self._report, textures=self.world.textures)
        for aim, attribute in self._graphics.attributes:
            if aim == target:
                parameters.found |= attribute.found
                attribute.read.update(attribute.found)
        self.world.parameters.append(parameters)
        return parameters.parse(tokens)

    def _transform(self, name: str, tokens: Tokens, where: str) -> None:
        values: list[float] = []
        while len(values) < NUMBERS[name]:
            values += [number(text, where, f"every number of {name}") for text in tokens.values()]
        if len(values) != NUMBERS[name]:
            raise SourceError(f"{where}: {name} needs {NUMBERS[name]} numbers, not {len(values)}")
        v = np.array(values)
        match name:
            case "Translate":
                step = transforms.translate(*values)
            case "Scale":
                step = transforms.scale(*values)
            case "Rotate":
                step = transforms.rotate(v[1:], values[0], where)
            case "LookAt":
                step = transforms.inverse(transforms.look_at(v[:3], v[3:6], v[6:], where), where)
            case _:  # given column after column
                step = v.reshape(4, 4).T
        matrix = step if name == "Transform" else self._graphics.to_world @ step
        self._graphics = replace(self._graphics, to_world=transforms.check(matrix, where))

    def _option(self, name: str, tokens: Tokens, where: str) -> None:
        if self._in_world:
            raise SourceError(f"{where}: {name} must stand before WorldBegin")
        kind = tokens.string()
        made = Directive(kind, self._parameters(f"{name} {shown(kind)}", where, tokens), self._graphics.to_world)
        self.world.options[name] = made
        if name == "Camera":
            to_world = transforms.inverse(self._graphics.to_world, where)
            self.world.options[name] = replace(made, to_world=to_world)
            self._systems["camera"] = to_world
            self.world.camera_medium = self._graphics.outside

    def _make(self, name: str, tokens: Tokens, where: str) -> None:
        kind = tokens.string()
        parameters = self._parameters(f"{name} {shown(kind)}", where, tokens, TARGETS[name])
        parameters.definition = name not in ("Shape", "LightSource") or self._object is not None
        made = Directive(kind, parameters, self._graphics.to_world)
        if name in ("Shape", "LightSource", "AreaLightSource") and not self._in_world:
            raise SourceError(f"{where}: {name} must stand after WorldBegin")
        match name:
            case "Shape":
                (self.world.shapes if self._object is None else self._object).append(Shape(made, self._graphics))
            case "LightSource":
                self.world.lights.append(made)
            case "AreaLightSource":
                self._graphics = replace(self._graphics, area_light=made)
            case "Material":
                self._graphics = replace(self._graphics, material=made)
            case _:
                typed = replace(made, kind=parameters.string("type", "diffuse" if name != "MakeNamedMedium" else ""))
                (self.world.materials if name == "MakeNamedMaterial" else self.world.media)[kind] = typed

    # Directives of their own kind

    def _do_worldbegin(self, tokens: Tokens, where: str) -> None:
        self._in_world = True
        self._graphics = replace(self._graphics, to_world=transforms.identity())
        self._systems["world"] = transforms.identity()

    def _do_identity(self, tokens: Tokens, where: str) -> None:
        self._graphics = replace(self._graphics, to_world=transforms.identity())

    def _do_reverseorientation(self, tokens: Tokens, where: str) -> None:
        self._graphics = replace(self._graphics, reverse=not self._graphics.reverse)

    def _do_coordinatesystem(self, tokens: Tokens, where: str) -> None:
        self._systems[tokens.string()] = self._graphics.to_world

    def _do_coordsystransform(self, tokens: Tokens, where: str) -> None:
        name = tokens.string()
        if name not in self._systems:
            raise SourceError(f"{where}: there is no coordinate system {shown(name)}")
        self._graphics = replace(self._graphics, to_world=self._systems[name])

    def _push(self, what: str, where: str) -> None:
        if len(self._pushed) > MAX_NESTED:
            raise SourceError(f"{where}: more than {MAX_NESTED} of {what} are open")
        self._pushed.append((what, self._graphics))

    def _pop(self, what: str, end: str, where: str) -> None:
        if not self._pushed or self._pushed[-1][0] != what:
            raise SourceError(f"{where}: {end} ends what no {what} begins")
        before = self._pushed.pop()[1]
        if what == "TransformBegin":
            before = replace(self._graphics, to_world=before.to_world)
        self._graphics = before

    def _do_attributebegin(self, tokens: Tokens, where: str) -> None:
        self._push("AttributeBegin", where)

    def _do_attributeend(self, tokens: Tokens, where: str) -> None:
        self._pop("AttributeBegin", "AttributeEnd", where)

    def _do_transformbegin(self, tokens: Tokens, where: str) -> None:
        self._push("TransformBegin", where)

    def _do_transformend(self, tokens: Tokens, where: str) -> None:
        self._pop("TransformBegin", "TransformEnd", where)

    def _do_objectbegin(self, tokens: Tokens, where: str) -> None:
        name = tokens.string()
        if self._object is not None:
            raise SourceError(f"{where}: ObjectBegin inside of another object")
        self._push("ObjectBegin", where)
        self._object = self._objects.setdefault(name, [])

    def _do_objectend(self, tokens: Tokens, where: str) -> None:
        self._pop("ObjectBegin", "ObjectEnd", where)
        self._object = None

    def _do_objectinstance(self, tokens: Tokens, where: str) -> None:
        """The object's shapes once more, each with a placement of its own."""
        name = tokens.string()
        if name not in self._objects or self._object is not None:
            raise SourceError(f"{where}: there is no object {shown(name)} here")
        for shape in self._objects[name]:
            if shape.graphics.area_light is not None:
                self._report.note(shape.graphics.area_light.where, "an object that is placed again does not shine")
            matrix = transforms.check(self._graphics.to_world @ shape.directive.to_world, where)
            placed = replace(shape.directive, to_world=matrix)
            self.world.shapes.append(Shape(placed, replace(shape.graphics, area_light=None)))

    def _do_mediuminterface(self, tokens: Tokens, where: str) -> None:
        inside = outside = tokens.string()
        if (token := tokens.peek()) and token.quoted:
            outside = tokens.string()
        self._graphics = replace(self._graphics, inside=inside, outside=outside)

    def _do_namedmaterial(self, tokens: Tokens, where: str) -> None:
        self._graphics = replace(self._graphics, material=tokens.string())

    def _do_texture(self, tokens: Tokens, where: str) -> None:
        name, _, kind = (tokens.string() for _ in range(3))
        parameters = self._parameters(f"Texture {shown(name)}", where, tokens, "texture")
        parameters.definition = True
        self.world.textures[name] = Texture(kind, parameters)

    def _do_attribute(self, tokens: Tokens, where: str) -> None:
        target = tokens.string()
        parameters = self._parameters(f"Attribute {shown(target)}", where, tokens)
        self._graphics = replace(self._graphics, attributes=(*self._graphics.attributes, (target, parameters)))

    def _do_include(self, tokens: Tokens, where: str) -> None:
        name = tokens.string()
        if not name or "\0" in name:
            raise SourceError(f"{where}: {shown(name)} is no name of a file")
        self._file(self._files[-1].parent / name, where)

    def _do_import(self, tokens: Tokens, where: str) -> None:
        """As an include, but for its changes of the graphics state, which end with it."""
        before = self._graphics
        self._do_include(tokens, where)
        self._graphics = before

    def _do_colorspace(self, tokens: Tokens, where: str) -> None:
        if (name := tokens.string()) != "srgb":
            self._report.note(where, f"the color space {shown(name)} is not carried over: colours are Rec. 709's")

    def _do_activetransform(self, tokens: Tokens, where: str) -> None:
        if (name := tokens.take().text) != "All":
            self._report.note(where, f"ActiveTransform {shown(name)}: nothing moves here, all transforms count")

    def _do_transformtimes(self, tokens: Tokens, where: str) -> None:
        for _ in range(2):
            number(tokens.take().text, where, "every number of TransformTimes")
        self._report.note(where, "TransformTimes is not carried over: nothing moves")
