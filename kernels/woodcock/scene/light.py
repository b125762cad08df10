"""Lights that are no surface."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from woodcock.scene.basics import FILE, IDENTITY, Direction, File, Matrix, Model, Number, Radiance, Vector

MAX_LIGHTS = 64


class ConstantLight(Model):
    """An environment of one radiance in every direction."""

    kind: Literal["constant"] = "constant"
    radiance: Radiance = Field(description="Radiance: one number or red, green, blue.")


class ImageLight(Model):
    """An environment from a picture of all directions: longitude across, latitude down, +y up, -z in the middle."""

    kind: Literal["image"] = "image"
    file: File = Field(description=f"EXR or HDR picture, twice as wide as high, {FILE}")
    scale: Radiance = Field(default=1.0, description="Multiplies the picture.")
    to_world: Matrix = Field(default=IDENTITY, description="Turns the picture; only its rotation counts.")


class DirectionalLight(Model):
    """Parallel light from infinitely far away; `sun` has a disk."""

    kind: Literal["directional"] = "directional"
    direction: Direction = Field(description="Direction in which the light travels; any length but zero.")
    irradiance: Radiance = Field(
        description="Irradiance on a surface facing the light: one number or red, green, blue."
    )


class SunLight(Model):
    """Directional light with an angular radius: a disk of one radiance in the sky, seen by the camera too."""

    kind: Literal["sun"] = "sun"
    direction: Direction = Field(description="Direction in which the light of the disk's middle travels.")
    irradiance: Radiance = Field(description="Irradiance on a surface facing the disk's middle.")
    angular_radius: Annotated[Number, Field(ge=0.001, le=60)] = Field(
        default=0.2665, description="Angular radius of the disk, degrees."
    )


class PointLight(Model):
    """Light from one point into every direction alike."""

    kind: Literal["point"] = "point"
    position: Vector = Field(description="Position, scene units.")
    intensity: Radiance = Field(description="Radiant intensity (radiance × area): one number or red, green, blue.")


class SpotLight(Model):
    """Light from one point into a cone; smooth between `beam` and `cutoff` (smoothstep in the angle's cosine)."""

    kind: Literal["spot"] = "spot"
    position: Vector = Field(description="Position, scene units.")
    target: Vector = Field(description="A point on the cone's axis.")
    intensity: Radiance = Field(description="Radiant intensity on the axis.")
    cutoff: Annotated[Number, Field(gt=0, le=89.9)] = Field(
        default=20.0, description="Half angle at which the cone ends, degrees."
    )
    beam: Annotated[Number, Field(ge=0, lt=89.9)] | None = Field(
        default=None, description="Half angle up to which it has full intensity, degrees; by default ¾ of the cutoff."
    )

    @model_validator(mode="after")
    def _is_a_cone(self) -> SpotLight:
        if self.position == self.target:
            raise ValueError("target must differ from position")
        if self.beam is not None and not self.beam < self.cutoff:
            raise ValueError(f"beam must be less than the cutoff of {self.cutoff:g} degrees")
        return self


Light = Annotated[
    ConstantLight | ImageLight | DirectionalLight | SunLight | PointLight | SpotLight, Field(discriminator="kind")
]
