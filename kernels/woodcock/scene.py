"""The one description of a render, shared by the kernels, the service and the client.

Every model is frozen and forbids unknown keys; unions are tagged by `kind`, and a kind is the name of the file that
implements it. Lengths are in the scene's unit of length, coefficients in its inverse, angles in degrees, radiance in
any one unit (linear, Rec. 709 primaries where it has three channels). Directions are directions of travel.

This module needs pydantic and nothing else, so that a client can validate a scene without a renderer installed.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Vector = tuple[Number, Number, Number]
Row = tuple[Number, Number, Number, Number]
Matrix = tuple[Row, Row, Row, Row]
NonNegative = Annotated[Number, Field(ge=0)]
Positive = Annotated[Number, Field(gt=0)]
Fraction = Annotated[Number, Field(ge=0, le=1)]
Count = Annotated[int, Field(strict=True)]


def _one_or_three(bound: str) -> WrapValidator:
    """One message where the union would give one for each of its members."""

    def check(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
        try:
            return handler(value)
        except ValidationError:
            raise ValueError(f"must be one number or three (red, green, blue), each {bound}") from None

    return WrapValidator(check)


# Spectra: one number in a grey scene, three (red, green, blue) in a coloured one.
Power = Annotated[Number, Field(ge=0, le=1e30)]  # ends where a picture of float32 would
Radiance = Annotated[Power | tuple[Power, Power, Power], _one_or_three("from 0 to 1e30")]
Albedo = Annotated[Fraction | tuple[Fraction, Fraction, Fraction], _one_or_three("from 0 to 1")]

MAX_PIXELS = 1 << 26
MAX_LIGHTS = 16
#: How the id of a volume that was uploaded to a service begins.
UPLOADED = "sha256:"
IDENTITY: Matrix = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))


class SceneError(ValueError):
    """A scene that cannot be rendered; the text names the field and what would be right."""


class Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


# Cameras


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


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
        sine = math.hypot(*_cross(forward, self.up)) / length
        if not sine > 1e-6 * math.hypot(*self.up):
            raise ValueError("up must not be zero or parallel to the view direction")
        return self


class PerspectiveCamera(_Pose):
    """A pinhole."""

    kind: Literal["perspective"] = "perspective"
    fov: Annotated[Number, Field(gt=0, lt=180)] = Field(default=40.0, description="Vertical field of view, degrees.")


class OrthographicCamera(_Pose):
    """Parallel rays."""

    kind: Literal["orthographic"] = "orthographic"
    height: Positive = Field(description="Height of the picture, scene units; the width follows from the film.")


Camera = Annotated[PerspectiveCamera | OrthographicCamera, Field(discriminator="kind")]


# Phase functions


class IsotropicPhase(Model):
    """p = 1 / 4π."""

    kind: Literal["isotropic"] = "isotropic"


class HenyeyGreensteinPhase(Model):
    """Henyey & Greenstein (1941)."""

    kind: Literal["henyey_greenstein"] = "henyey_greenstein"
    g: Annotated[Number, Field(gt=-1, lt=1)] = Field(description="Mean cosine; positive scatters forward.")


Phase = Annotated[IsotropicPhase | HenyeyGreensteinPhase, Field(discriminator="kind")]


# Volumes


class _Medium(Model):
    albedo: Albedo = Field(description="Single-scattering albedo σ_s / σ_t: one number or red, green, blue.")
    phase: Phase = Field(default=IsotropicPhase(), description="Phase function.")


class ConstantVolume(_Medium):
    """A homogeneous medium in an axis-aligned box."""

    kind: Literal["constant"] = "constant"
    min: Vector = Field(description="Lower corner of the box, scene units.")
    max: Vector = Field(description="Upper corner of the box, scene units.")
    sigma_t: NonNegative = Field(description="Extinction coefficient, inverse scene units.")

    @model_validator(mode="after")
    def _has_a_volume(self) -> ConstantVolume:
        for axis, low, high in zip("xyz", self.min, self.max, strict=True):
            if not low < high:
                raise ValueError(f"max must exceed min along {axis} (min {low:g}, max {high:g})")
        return self


class GridVolume(_Medium):
    """Density on a regular grid, interpolated trilinearly; σ_t = scale × density.

    A file with a transform of its own (OpenVDB) is placed by it; any other fills the unit cube. `to_world` follows.
    """

    kind: Literal["grid"] = "grid"
    file: str = Field(
        min_length=1,
        description="Volume file, relative to the scene file; over HTTP `sha256:…` of an uploaded volume.",
    )
    grid: str | None = Field(
        default=None, description="Name of the grid in the file; by default `density`, or the only one there is."
    )
    scale: NonNegative = Field(default=1.0, description="σ_t of a voxel of density 1, inverse scene units.")
    to_world: Matrix = Field(
        default=IDENTITY, description="Affine placement in the scene: four rows, applied to column vectors."
    )

    @model_validator(mode="after")
    def _is_placed(self) -> GridVolume:
        if self.to_world[3] != (0, 0, 0, 1):
            raise ValueError("the last row of to_world must be [0, 0, 0, 1]")
        x, y, z = ((row[0], row[1], row[2]) for row in self.to_world[:3])
        lengths = [math.hypot(*row) for row in (x, y, z)]
        determinant = math.fsum(a * b for a, b in zip(x, _cross(y, z), strict=True))
        if not abs(determinant) > 1e-9 * math.prod(lengths) or not math.prod(lengths) > 0:
            raise ValueError("to_world must not be singular")
        return self


Volume = Annotated[ConstantVolume | GridVolume, Field(discriminator="kind")]


# Lights


class ConstantLight(Model):
    """An environment of one radiance in every direction."""

    kind: Literal["constant"] = "constant"
    radiance: Radiance = Field(description="Radiance: one number or red, green, blue.")


class DirectionalLight(Model):
    """Parallel light from infinitely far away."""

    kind: Literal["directional"] = "directional"
    direction: Vector = Field(description="Direction in which the light travels; any length but zero.")
    irradiance: Radiance = Field(
        description="Irradiance on a surface facing the light: one number or red, green, blue."
    )

    @model_validator(mode="after")
    def _has_a_direction(self) -> DirectionalLight:
        if not 0 < math.hypot(*self.direction) < math.inf:
            raise ValueError("direction must not be zero")
        return self


Light = Annotated[ConstantLight | DirectionalLight, Field(discriminator="kind")]


# Film and stop contract


class Film(Model):
    width: Count = Field(default=512, ge=1, le=1 << 16, description="Pixels.")
    height: Count = Field(default=512, ge=1, le=1 << 16, description="Pixels.")

    @model_validator(mode="after")
    def _fits(self) -> Film:
        if self.width * self.height > MAX_PIXELS:
            raise ValueError(f"width × height must not exceed {MAX_PIXELS} pixels")
        return self


class SamplesStop(Model):
    """Exactly so many samples in every pixel."""

    kind: Literal["samples"] = "samples"
    samples: Count = Field(ge=1, le=1 << 31, description="Samples per pixel.")


class SecondsStop(Model):
    """As many samples as fit into so much rendering time; at least one."""

    kind: Literal["seconds"] = "seconds"
    seconds: Annotated[Number, Field(gt=0, le=30 * 86400)] = Field(description="Wall time of rendering, seconds.")


Stop = Annotated[SamplesStop | SecondsStop, Field(discriminator="kind")]


def _length(least: int, most: int) -> AfterValidator:
    def check(value: tuple[Any, ...]) -> tuple[Any, ...]:
        if not least <= len(value) <= most:
            bound = f"exactly {most}" if least == most else f"{least} to {most}"
            raise ValueError(f"must hold {bound}, not {len(value)}")
        return value

    return AfterValidator(check)


class Scene(Model):
    """What to render, and when to stop."""

    camera: Camera
    volumes: Annotated[tuple[Volume, ...], _length(1, 1)] = Field(description="Participating media; one for now.")
    lights: Annotated[tuple[Light, ...], _length(0, MAX_LIGHTS)] = Field(default=(), description="What shines.")
    film: Film = Film()
    seed: Count = Field(default=0, ge=0, le=(1 << 32) - 1, description="Seed of the random numbers.")
    stop: Stop = SamplesStop(samples=64)


# Reading and writing


def parse(text: str | bytes) -> Scene:
    """A scene from JSON. Raises SceneError, one line per fault."""
    try:
        return Scene.model_validate_json(text)
    except ValidationError as error:
        raise SceneError(explain(error.errors(include_url=False))) from None


def load(path: Path) -> Scene:
    """A scene from a JSON file; volume files, but for ids of uploaded ones, are resolved against its folder.

    Raises SceneError.
    """
    try:
        scene = parse(path.read_bytes())
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}") from None
    except SceneError as error:
        raise SceneError("\n".join(f"{path}: {line}" for line in str(error).splitlines())) from None
    return with_volume_files(scene, lambda file: file if file.startswith(UPLOADED) else str(path.parent / file))


def with_volume_files(scene: Scene, rename: Callable[[str], str]) -> Scene:
    """The same scene with every volume's `file` renamed."""
    volumes = tuple(
        volume.model_copy(update={"file": rename(volume.file)}) if isinstance(volume, GridVolume) else volume
        for volume in scene.volumes
    )
    return scene.model_copy(update={"volumes": volumes})


def volume_files(scene: Scene) -> tuple[str, ...]:
    """The volume files that a scene names, in order, each once."""
    return tuple(dict.fromkeys(volume.file for volume in scene.volumes if isinstance(volume, GridVolume)))


def explain(errors: Sequence[Mapping[str, Any]]) -> str:
    """Pydantic's errors as text, a line each: `field: what is wrong (got value)`."""
    return "\n".join(f"{field_path(error['loc']) or 'scene'}: {fault(error)}" for error in errors)


def fault(error: Mapping[str, Any]) -> str:
    """What one of pydantic's errors says is wrong, without the field: `what is wrong (got value)`."""
    match error["type"]:
        case "extra_forbidden":
            message = "is not a known key"
        case "missing":
            message = "is required"
        case "union_tag_not_found":
            message = "needs a `kind`"
        case "union_tag_invalid":
            message = f"unknown kind; known are {error['ctx']['expected_tags']}"
        case _:
            message = error["msg"].removeprefix("Value error, ")
    got = error["input"]
    shown = json.dumps(got) if isinstance(got, int | float | str) and error["type"] != "json_invalid" else ""
    if shown:
        message += f" (got {shown if len(shown) <= 60 else shown[:60] + '…'})"
    return f"{message[:1].lower()}{message[1:]}"


def field_path(loc: Sequence[int | str]) -> str:
    """The path as the scene is written: `volumes[0].sigma_t` of pydantic's ("volumes", 0, "constant", "sigma_t")."""
    path = ""
    tagged = False
    for position, part in enumerate(loc):
        if isinstance(part, int):
            path += f"[{part}]"
        elif not tagged:
            path += f".{part}" if path else part
        before = loc[position - 1] if isinstance(part, int) and position else part
        # Unions are tagged by kind: the part after one of these is the kind, not a key of the scene.
        tagged = not tagged and before in (
            ("volumes", "lights") if isinstance(part, int) else ("camera", "phase", "stop")
        )
    return path
