"""Surfaces, the boundary condition of the equation, and what they are made of."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from woodcock.scene.basics import (
    FILE,
    IDENTITY,
    Albedo,
    Direction,
    File,
    Flag,
    Matrix,
    Model,
    Number,
    Positive,
    Radiance,
    Vector,
)

MAX_SURFACES = 256


class DiffuseMaterial(Model):
    """Lambert's law, on both sides."""

    kind: Literal["diffuse"] = "diffuse"
    reflectance: Albedo = Field(default=0.5, description="Albedo: one number or red, green, blue.")


class MirrorMaterial(Model):
    """Reflects without spreading, on both sides."""

    kind: Literal["mirror"] = "mirror"
    reflectance: Albedo = Field(default=1.0, description="Share that is reflected: one number or red, green, blue.")


RefractiveIndex = Annotated[Number, Field(ge=0.2, le=5)]


class DielectricMaterial(Model):
    """A smooth boundary between two transparent materials: Fresnel's and Snell's laws."""

    kind: Literal["dielectric"] = "dielectric"
    ior: RefractiveIndex = Field(
        default=1.5, description="Refractive index of the inside (behind the normal) over that of the outside."
    )


class RoughDielectricMaterial(Model):
    """A rough boundary between two transparent materials: Walter et al. (2007), GGX, visible normals."""

    kind: Literal["rough_dielectric"] = "rough_dielectric"
    ior: RefractiveIndex = Field(
        default=1.5, description="Refractive index of the inside (behind the normal) over that of the outside."
    )
    roughness: Annotated[Number, Field(ge=0.001, le=1)] = Field(default=0.1, description="GGX's α.")


class EmissiveMaterial(Model):
    """Shines on the normal's side and reflects nothing."""

    kind: Literal["emissive"] = "emissive"
    radiance: Radiance = Field(description="Radiance: one number or red, green, blue.")
    two_sided: Flag = Field(default=False, description="Shines on both sides.")


class NullMaterial(Model):
    """Lets everything pass: only a boundary of the index-matched kind."""

    kind: Literal["null"] = "null"


Material = Annotated[
    DiffuseMaterial | MirrorMaterial | DielectricMaterial | RoughDielectricMaterial | EmissiveMaterial | NullMaterial,
    Field(discriminator="kind"),
]


class _Surface(Model):
    material: Material = Field(default=DiffuseMaterial(), description="What the surface is made of.")


class SphereSurface(_Surface):
    """A sphere; its normal points outwards."""

    kind: Literal["sphere"] = "sphere"
    center: Vector = Field(default=(0.0, 0.0, 0.0), description="Centre, scene units.")
    radius: Positive = Field(description="Radius, scene units.")


class RectangleSurface(_Surface):
    """The square from -1 to 1 of the x–y plane, placed by `to_world`; its normal is +z's image."""

    kind: Literal["rectangle"] = "rectangle"
    to_world: Matrix = Field(default=IDENTITY, description="Affine placement in the scene.")


class DiskSurface(_Surface):
    """A disk."""

    kind: Literal["disk"] = "disk"
    center: Vector = Field(default=(0.0, 0.0, 0.0), description="Centre, scene units.")
    normal: Direction = Field(default=(0.0, 0.0, 1.0), description="Direction that it faces; any length but zero.")
    radius: Positive = Field(description="Radius, scene units.")


class MeshSurface(_Surface):
    """Triangles; a face's normal is that of its corners' order, counter-clockwise seen from outside."""

    kind: Literal["mesh"] = "mesh"
    file: File = Field(description=f"PLY, OBJ or glTF file, {FILE}")
    smooth: Flag = Field(default=True, description="Uses the file's vertex normals, where it has some, for shading.")
    to_world: Matrix = Field(default=IDENTITY, description="Affine placement in the scene.")


Surface = Annotated[SphereSurface | RectangleSurface | DiskSurface | MeshSurface, Field(discriminator="kind")]
