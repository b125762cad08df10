"""The scene as a whole: what to render, by which integrator, and when to stop."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from woodcock.scene.basics import Count, Flag, LayerName, Model, Number, length
from woodcock.scene.camera import Camera, Film
from woodcock.scene.light import MAX_LIGHTS, Light
from woodcock.scene.surface import MAX_SURFACES, Surface
from woodcock.scene.tracking import FreeFlight, Transmittance
from woodcock.scene.volume import Majorant, Volume

MAX_VOLUMES = 8
MAX_ORDERS = 16

# Integrators


class TransmittanceIntegrator(Model):
    """Absorption only, L = exp(-∫σ_t) L_e: deterministic, in closed form."""

    kind: Literal["transmittance"] = "transmittance"


class EmissionAbsorptionIntegrator(Model):
    """Absorption and emission, L′ + σ_t L = ε: deterministic, by an exponential integrator."""

    kind: Literal["emission_absorption"] = "emission_absorption"
    tolerance: Annotated[Number, Field(ge=1e-6, le=0.1)] = Field(
        default=1e-4, description="Largest error of a ray's radiance, relative to it, that the steps may leave."
    )


class VolumetricPathIntegrator(Model):
    """Everything, L = L⁰ + K L⁰ + K² L⁰ + …, by random paths."""

    kind: Literal["volumetric_path"] = "volumetric_path"


Integrator = Annotated[
    TransmittanceIntegrator | EmissionAbsorptionIntegrator | VolumetricPathIntegrator, Field(discriminator="kind")
]

# Stop contracts


class SamplesStop(Model):
    """Exactly so many samples in every pixel."""

    kind: Literal["samples"] = "samples"
    samples: Count = Field(ge=1, le=1 << 31, description="Samples per pixel.")


class SecondsStop(Model):
    """As many samples as fit into so much rendering time; at least one."""

    kind: Literal["seconds"] = "seconds"
    seconds: Annotated[Number, Field(gt=0, le=30 * 86400)] = Field(description="Wall time of rendering, seconds.")


class RelativeErrorStop(Model):
    """As many samples as it takes: until the root mean square standard error of a pixel is small beside the picture's
    mean luminance.

    Channels are weighted by luminance. Asked of every tile, tiles get as many samples as they need (`contract.py`).
    """

    kind: Literal["relative_error"] = "relative_error"
    relative_error: Annotated[Number, Field(ge=1e-6, le=1)] = Field(
        description="Root mean square of the standard error of a pixel's mean, over the picture's mean luminance."
    )
    per: Literal["image", "tile"] = Field(
        default="image", description="Over which pixels the mean square is: the image, or every tile of 32 × 32 pixels."
    )


Stop = Annotated[SamplesStop | SecondsStop | RelativeErrorStop, Field(discriminator="kind")]


class Scene(Model):
    """What to render, and when to stop."""

    camera: Camera
    volumes: Annotated[tuple[Volume, ...], length(0, MAX_VOLUMES)] = Field(
        default=(), description="Participating media; where they overlap, their coefficients add."
    )
    surfaces: Annotated[tuple[Surface, ...], length(0, MAX_SURFACES)] = Field(
        default=(), description="Surfaces, the boundary of the equation."
    )
    lights: Annotated[tuple[Light, ...], length(0, MAX_LIGHTS)] = Field(
        default=(), description="What shines and is no surface."
    )
    film: Film = Film()
    integrator: Integrator | None = Field(
        default=None,
        description="How the equation is solved; by default the cheapest that is right: deterministic where nothing "
        "scatters.",
    )
    majorant: Majorant | None = Field(
        default=None,
        description="Bound on σ_t of media that are grids; by default the one by which paths take fewer steps.",
    )
    free_flight: FreeFlight | None = Field(
        default=None, description="How flights through grids find collisions; by default the program chooses."
    )
    transmittance: Transmittance | None = Field(
        default=None, description="How transmittance through grids is estimated; by default the program chooses."
    )
    orders: Annotated[Count, Field(ge=0, le=MAX_ORDERS)] | None = Field(
        default=None,
        description="Writes the Neumann series as layers: `order.0` to `order.n`, and `order.rest`.",
    )
    layers: tuple[LayerName, ...] = Field(
        default=(), description="Layers beside the beauty: what camera rays meet first."
    )
    denoise: Flag = Field(default=False, description="Adds a denoised layer beside the raw one.")
    seed: Count = Field(default=0, ge=0, le=(1 << 32) - 1, description="Seed of the random numbers.")
    stop: Stop = SamplesStop(samples=64)

    @model_validator(mode="after")
    def _holds_something(self) -> Scene:
        if not self.volumes and not self.surfaces:
            raise ValueError("volumes or surfaces must hold something to render")
        if len(set(self.layers)) < len(self.layers):
            raise ValueError("layers must name each layer once")
        return self
