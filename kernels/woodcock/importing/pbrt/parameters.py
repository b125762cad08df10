"""The parameters of a pbrt directive: values by name, each with its type, and a record of which were read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from woodcock.importing import colour
from woodcock.importing.colour import Colour
from woodcock.importing.pbrt.tokens import Tokens
from woodcock.importing.report import Report, SourceError, integer, number, shown
from woodcock.importing.transforms import Array

TYPES = (
    *("integer", "float", "bool", "string", "texture", "spectrum", "rgb", "blackbody"),
    *("point", "point2", "point3", "vector", "vector2", "vector3", "normal", "normal3"),
)
#: pbrt's names of white, and of a blackbody of 2856 K.
D65, A = "stdillum-D65", "stdillum-A"


@dataclass
class Parameter:
    type: str
    values: list[str]
    where: str


@dataclass(frozen=True)
class Texture:
    """A named texture: its class, and the parameters of the directive that makes it."""

    kind: str
    parameters: Parameters


@dataclass
class Parameters:
    """Nothing is dropped in silence: `leftovers` lists what nobody read.

    A `definition` (of a material, say) only matters once something has `used` it.
    """

    owner: str
    where: str
    folder: Path
    report: Report
    found: dict[str, Parameter] = field(default_factory=dict)
    textures: Mapping[str, Texture] = field(default_factory=dict)
    read: set[str] = field(default_factory=set)
    definition: bool = False
    used: bool = False

    def parse(self, tokens: Tokens) -> Parameters:
        while (token := tokens.peek()) and token.quoted:
            where = tokens.here
            declared = tokens.string().split()
            if len(declared) != 2 or declared[0] not in TYPES:
                raise SourceError(
                    f'{where}: a parameter must be "type name", with a known type, not {shown(token.text)}'
                )
            self.found[declared[1]] = Parameter(declared[0], tokens.values(), where)
        return self

    def __contains__(self, name: str) -> bool:
        return name in self.found

    def at(self, name: str) -> str:
        return self.found[name].where if name in self.found else self.where

    def passed_over(self, *names: str) -> None:
        """Parameters that change nothing in the picture's mean."""
        self.read.update(names)

    def leftovers(self) -> None:
        if self.definition and not self.used:
            return
        for name, parameter in self.found.items():
            if name not in self.read:
                self.report.note(parameter.where, f"{shown(name)} of {self.owner} is not carried over")

    def _values(self, name: str, *types: str) -> Parameter | None:
        parameter = self.found.get(name)
        if parameter is None:
            return None
        self.read.add(name)
        if parameter.type not in types:
            raise SourceError(f"{parameter.where}: {shown(name)} must be of type {types[0]}, not {parameter.type}")
        return parameter

    def _one(self, name: str, *types: str) -> tuple[str, str] | None:
        if (parameter := self._values(name, *types)) is None:
            return None
        if len(parameter.values) != 1:
            raise SourceError(f"{parameter.where}: {shown(name)} must be one value, not {len(parameter.values)}")
        return parameter.values[0], parameter.where

    def number(self, name: str, default: float) -> float:
        """Of a constant texture, its value; of any other the default, and it is listed."""
        if name in self.found and self.found[name].type == "texture":
            texture = self._texture(name)
            return default if texture is None else texture.number("value", 1.0)
        found = self._one(name, "float", "integer")
        return default if found is None else number(*found, shown(name))

    def integer(self, name: str, default: int) -> int:
        found = self._one(name, "integer")
        return default if found is None else integer(*found, shown(name))

    def boolean(self, name: str, default: bool) -> bool:
        found = self._one(name, "bool")
        if found is not None and found[0] not in ("true", "false"):
            raise SourceError(f"{found[1]}: {shown(name)} must be true or false, not {shown(found[0])}")
        return default if found is None else found[0] == "true"

    def string(self, name: str, default: str) -> str:
        found = self._one(name, "string")
        return default if found is None else found[0]

    def numbers(self, name: str, *types: str) -> Array | None:
        """(n,)"""
        if (parameter := self._values(name, *(types or ("float", "integer")))) is None:
            return None
        try:
            values = np.array(parameter.values, dtype=np.float64)
        except ValueError:
            values = np.array([np.nan])
        if not np.isfinite(values).all():
            raise SourceError(f"{parameter.where}: {shown(name)} must hold finite numbers alone")
        return values

    def points(self, name: str) -> Array | None:
        """(n, 3)"""
        values = self.numbers(name, "point3", "point", "normal", "normal3", "vector", "vector3")
        if values is not None and values.size % 3:
            raise SourceError(f"{self.at(name)}: {shown(name)} must hold three numbers each, not {values.size} in all")
        return None if values is None else values.reshape(-1, 3)

    def point(self, name: str, default: tuple[float, float, float]) -> Array:
        values = self.points(name)
        if values is not None and len(values) != 1:
            raise SourceError(f"{self.at(name)}: {shown(name)} must be one point, not {len(values)}")
        return np.array(default) if values is None else values[0]

    def spectrum(self, name: str, default: Colour) -> Colour:
        """Of what reflects, absorbs or scatters."""
        if name in self.found and self.found[name].type == "texture":
            texture = self._texture(name)
            return default if texture is None else texture.spectrum("value", 1.0)
        if (rgb := self._rgb(name)) is not None:
            return colour.simple(rgb)
        samples = self._samples(name)
        return default if samples is None else colour.of_samples(*samples, emitted=False)

    def light(self, name: str, default: Colour) -> Colour:
        """Of light: pbrt brings every spectrum to a luminance of 1, but for a colour's own brightness."""
        if (rgb := self._rgb(name)) is not None:
            return colour.simple(rgb)
        kelvin: float | None = None
        if name in self.found and self.found[name].type == "blackbody":
            kelvin = number(*self._one(name, "blackbody") or ("", ""), shown(name))
        elif name in self.found and self.found[name].values[:1] == [A]:
            self.read.add(name)
            kelvin = 2856.0
        if kelvin is not None:
            if not kelvin > 0:
                raise SourceError(f"{self.at(name)}: {shown(name)} must be more than 0 kelvin")
            emitted = colour.blackbody(kelvin)
        elif (samples := self._samples(name)) is not None:
            emitted = colour.triple(colour.of_samples(*samples, emitted=True))
        else:
            return default
        brightness = colour.luminance(emitted)
        return colour.simple(emitted / brightness) if brightness > 0 else 0.0

    def _rgb(self, name: str) -> Array | None:
        if name not in self.found or self.found[name].type not in ("rgb", "float"):
            return None
        values = self.numbers(name, "rgb", "float")
        assert values is not None
        if values.size != (3 if self.found[name].type == "rgb" else 1):
            raise SourceError(f"{self.at(name)}: {shown(name)} must hold three numbers, not {values.size}")
        return np.broadcast_to(values, (3,))

    def _samples(self, name: str) -> tuple[list[float], list[float]] | None:
        """Wavelengths and values; None where there are none, or in a file or a table of pbrt's own."""
        if (parameter := self._values(name, "spectrum", "rgb", "blackbody", "float", "texture")) is None:
            return None
        try:
            values = [float(value) for value in parameter.values]
        except ValueError:
            if parameter.values[0] != D65:
                self.report.note(parameter.where, f"the spectrum {shown(parameter.values[0])} is not carried over")
            return None
        if not values or len(values) % 2 or not np.isfinite(values).all():
            raise SourceError(f"{parameter.where}: {shown(name)} must hold pairs of a wavelength and a value")
        if len(set(values[1::2])) > 1:
            self.report.note(parameter.where, f"the spectrum of {shown(name)} is approximated by a colour")
        return values[::2], values[1::2]

    def _texture(self, name: str) -> Parameters | None:
        named = self._one(name, "texture")
        assert named is not None
        texture = self.textures.get(named[0])
        if texture is not None and texture.kind == "constant":
            texture.parameters.used = True
            return texture.parameters
        self.report.note(
            named[1], f"the texture {shown(named[0])} is not carried over; {shown(name)} keeps its default"
        )
        return None
