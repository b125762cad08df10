"""What pbrt's directives leave behind."""

from __future__ import annotations

from dataclasses import dataclass, field

from woodcock.importing import transforms
from woodcock.importing.pbrt.parameters import Parameters, Texture
from woodcock.importing.transforms import Array


@dataclass(frozen=True)
class Directive:
    """A directive that makes something: its name, its parameters, and where it stands in the world."""

    kind: str
    parameters: Parameters
    to_world: Array

    @property
    def where(self) -> str:
        return self.parameters.where


@dataclass(frozen=True)
class Graphics:
    to_world: Array = field(default_factory=transforms.identity)
    reverse: bool = False
    material: Directive | str | None = None
    inside: str = ""
    outside: str = ""
    area_light: Directive | None = None
    attributes: tuple[tuple[str, Parameters], ...] = ()


@dataclass(frozen=True)
class Shape:
    directive: Directive
    graphics: Graphics


@dataclass
class World:
    """What is there once all directives have run."""

    options: dict[str, Directive] = field(default_factory=dict)
    camera_medium: str = ""
    shapes: list[Shape] = field(default_factory=list)
    lights: list[Directive] = field(default_factory=list)
    materials: dict[str, Directive] = field(default_factory=dict)
    media: dict[str, Directive] = field(default_factory=dict)
    textures: dict[str, Texture] = field(default_factory=dict)
    parameters: list[Parameters] = field(default_factory=list)
