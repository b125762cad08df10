"""Cameras, pixel filters and the film."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from woodcock.scene.basics import Count, Model, Number, Positive, Vector, cross

MAX_PIXELS = 1 << 26


class _Pose(Model):
    origin: Vector = Field(description="Position of the camera, scene units.")
    target: Vector = Field(description="Point in the middle of the picture, scene units.")
    up: Vector = Field(default=(0.0, 1.0, 0.0), description="Direction that is up in the picture; any length.")

    @model_validator(mode="after")
    def _has_a_frame(self) -> _Pose:
        forward = (self.target[0] - self.origin[0], self.target[1] - self.origin[1], self.target[2] - self.origin[2])
        length = math.hypot(*forward)
        if not 0 < length < math.inf:
            raise ValueError("target must differ from origin")
        sine = math.hypot(*cross(forward, self.up)) / length
        if not sine > 1e-6 * math.hypot(*self.up):
            raise ValueError("up must not be zero or parallel to the view direction")
        return self


FieldOfView = Annotated[Number, Field(gt=0, lt=180)]


class PerspectiveCamera(_Pose):
    """A pinhole."""

    kind: Literal["perspective"] = "perspective"
    fov: FieldOfView = Field(default=40.0, description="Vertical field of view, degrees.")


class ThinLensCamera(_Pose):
    """A lens without thickness: what lies at the focus distance is sharp."""

    kind: Literal["thin_lens"] = "thin_lens"
    fov: FieldOfView = Field(default=40.0, description="Vertical field of view, degrees.")
    aperture_radius: Positive = Field(description="Radius of the lens, scene units.")
    focus_distance: Positive | None = Field(
        default=None, description="Distance of the plane in focus along the view direction; by default the target's."
    )


class OrthographicCamera(_Pose):
    """Parallel rays."""

    kind: Literal["orthographic"] = "orthographic"
    height: Positive = Field(description="Height of the picture, scene units; the width follows from the film.")


class SphericalCamera(_Pose):
    """Every direction around a point: longitude across the picture, latitude down; the target lies in the middle."""

    kind: Literal["spherical"] = "spherical"


Camera = Annotated[
    PerspectiveCamera | ThinLensCamera | OrthographicCamera | SphericalCamera, Field(discriminator="kind")
]


# Pixel filters: samples are placed by the filter, so that every sample counts once.

Radius = Annotated[Number, Field(gt=0, le=8)]


class BoxFilter(Model):
    """The mean over a square; radius 0.5 is the pixel itself."""

    kind: Literal["box"] = "box"
    radius: Radius = Field(default=0.5, description="Half the side, pixels.")


class TentFilter(Model):
    """Falls linearly from the pixel's middle."""

    kind: Literal["tent"] = "tent"
    radius: Radius = Field(default=1.0, description="Where it reaches 0, pixels.")


class GaussianFilter(Model):
    """A Gaussian, cut off at four standard deviations."""

    kind: Literal["gaussian"] = "gaussian"
    deviation: Radius = Field(default=0.5, description="Standard deviation, pixels.")


Filter = Annotated[BoxFilter | TentFilter | GaussianFilter, Field(discriminator="kind")]


class Film(Model):
    """The picture's size, and how samples lie around a pixel."""

    width: Count = Field(default=512, ge=1, le=1 << 16, description="Pixels.")
    height: Count = Field(default=512, ge=1, le=1 << 16, description="Pixels.")
    filter: Filter = Field(default=BoxFilter(), description="Pixel filter.")

    @model_validator(mode="after")
    def _fits(self) -> Film:
        if self.width * self.height > MAX_PIXELS:
            raise ValueError(f"width × height must not exceed {MAX_PIXELS} pixels")
        return self
