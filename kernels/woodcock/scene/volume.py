"""Participating media: where they are, what they absorb, scatter and emit."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from woodcock.scene.basics import (
    FILE,
    IDENTITY,
    Albedo,
    Coefficient,
    File,
    Flag,
    Fraction,
    Matrix,
    Model,
    Positive,
    Radiance,
    Vector,
    box_has_a_volume,
)
from woodcock.scene.phase import IsotropicPhase, Phase

# Where a homogeneous medium is


class BoxShape(Model):
    """A box, axis-aligned before `to_world`."""

    kind: Literal["box"] = "box"
    min: Vector = Field(description="Lower corner, scene units.")
    max: Vector = Field(description="Upper corner, scene units.")
    to_world: Matrix = Field(default=IDENTITY, description="Affine placement in the scene.")

    @model_validator(mode="after")
    def _has_a_volume(self) -> BoxShape:
        box_has_a_volume(self.min, self.max)
        return self


class SphereShape(Model):
    """A ball."""

    kind: Literal["sphere"] = "sphere"
    center: Vector = Field(default=(0.0, 0.0, 0.0), description="Centre, scene units.")
    radius: Positive = Field(description="Radius, scene units.")


class MeshShape(Model):
    """The inside of a closed triangle mesh."""

    kind: Literal["mesh"] = "mesh"
    file: File = Field(description=f"PLY, OBJ or glTF file, {FILE}")
    to_world: Matrix = Field(default=IDENTITY, description="Affine placement in the scene.")


Shape = Annotated[BoxShape | SphereShape | MeshShape, Field(discriminator="kind")]


# What a medium emits


class ConstantEmission(Model):
    """One emission coefficient everywhere in the medium."""

    kind: Literal["constant"] = "constant"
    epsilon: Radiance = Field(description="ε, radiance per scene unit: one number or red, green, blue.")


class GridEmission(Model):
    """An emission coefficient from a grid of numbers or of colours: ε = scale × value."""

    kind: Literal["grid"] = "grid"
    file: File = Field(description=f"Volume file, {FILE}")
    grid: str | None = Field(default=None, description="Name of the grid in the file; by default the only one.")
    scale: Radiance = Field(default=1.0, description="ε of a voxel of value 1, radiance per scene unit.")


class BlackbodyEmission(Model):
    """Thermal emission, ε = σ_a B(T): Planck's law, through the CIE 1931 observer to linear Rec. 709."""

    kind: Literal["blackbody"] = "blackbody"
    file: File | None = Field(default=None, description=f"Volume file of the temperature, {FILE}")
    grid: str | None = Field(default=None, description="Name of the grid in the file; by default `temperature`.")
    kelvin: Positive = Field(
        description="Temperature in kelvin; with a grid, the kelvin of a voxel of value 1.",
    )
    reference: Positive = Field(default=2000.0, description="Temperature in kelvin whose B has the luminance below.")
    luminance: Radiance = Field(default=1.0, description="Luminance of B at `reference`, in the scene's radiance.")


# Emissions of the two kinds of volumes
UniformEmission = Annotated[ConstantEmission | BlackbodyEmission, Field(discriminator="kind")]
Emission = Annotated[ConstantEmission | GridEmission | BlackbodyEmission, Field(discriminator="kind")]


class _Medium(Model):
    albedo: Albedo = Field(description="Single-scattering albedo σ_s / σ_t: one number or red, green, blue.")
    phase: Phase = Field(default=IsotropicPhase(), description="Phase function.")


class ConstantVolume(_Medium):
    """A homogeneous medium."""

    kind: Literal["constant"] = "constant"
    shape: Shape = Field(description="Where the medium is.")
    sigma_t: Coefficient = Field(
        description="Extinction coefficient, inverse scene units: one number or red, green, blue."
    )
    emission: UniformEmission | None = Field(default=None, description="What the medium emits.")

    @model_validator(mode="after")
    def _emits_uniformly(self) -> ConstantVolume:
        if isinstance(self.emission, BlackbodyEmission) and self.emission.file is not None:
            raise ValueError("the emission of a constant volume has one temperature: leave its `file` out")
        return self


class GridFile(Model):
    file: File = Field(description=f"Volume file, {FILE}")
    grid: str | None = Field(default=None, description="Name of the grid in the file; by default the only one.")


class GridVolume(_Medium):
    """Density on a regular grid; σ_t = scale × density. A grid of colours gives σ_t for red, green and blue.

    A file with a transform of its own is placed by it; any other fills the unit cube. `to_world` follows.
    """

    kind: Literal["grid"] = "grid"
    file: File = Field(description=f"Volume file, {FILE}")
    grid: str | None = Field(
        default=None, description="Name of the grid in the file; by default `density`, or the only one there is."
    )
    scale: Coefficient = Field(
        default=1.0, description="σ_t of a voxel of density 1, inverse scene units: one number or red, green, blue."
    )
    albedo_grid: GridFile | None = Field(
        default=None, description="A grid of numbers or colours from 0 to 1 that multiplies the albedo."
    )
    emission: Emission | None = Field(default=None, description="What the medium emits.")
    interpolation: Literal["trilinear", "nearest"] = Field(
        default="trilinear", description="How values between voxels' middles follow from them."
    )
    storage_error: Fraction = Field(
        default=0.0,
        description="Largest error of a stored density, relative to the largest; the narrowest of 8-bit, half and "
        "float that keeps it is used.",
    )
    to_world: Matrix = Field(
        default=IDENTITY, description="Affine placement in the scene: four rows, applied to column vectors."
    )


Volume = Annotated[ConstantVolume | GridVolume, Field(discriminator="kind")]


# How far a free flight goes between looks at the density


class GlobalMajorant(Model):
    """One bound for everything."""

    kind: Literal["global"] = "global"


class GridMajorant(Model):
    """A bound for every cell of a coarse grid; empty cells are skipped."""

    kind: Literal["grid"] = "grid"
    resolution: Annotated[int, Field(strict=True, ge=1, le=256)] = Field(
        default=32, description="Cells along the longest side."
    )
    blocks: Flag = Field(
        default=False,
        description="Blocks of cells are crossed at once, under a common bound, where that costs little: for what is "
        "small and dense. Not under a control, as decomposition, residual ratio tracking and ray marching have one.",
    )


Majorant = Annotated[GlobalMajorant | GridMajorant, Field(discriminator="kind")]
