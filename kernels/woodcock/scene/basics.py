"""What every part of a scene is made of: numbers with bounds, spectra, matrices, and the base of all models."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Vector = tuple[Number, Number, Number]
Row = tuple[Number, Number, Number, Number]
NonNegative = Annotated[Number, Field(ge=0)]
Positive = Annotated[Number, Field(gt=0)]
Fraction = Annotated[Number, Field(ge=0, le=1)]
Count = Annotated[int, Field(strict=True)]
Flag = Annotated[bool, Field(strict=True)]


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
Coefficient = Annotated[NonNegative | tuple[NonNegative, NonNegative, NonNegative], _one_or_three("0 or more")]
Spectrum = float | tuple[float, float, float]


def _affine(rows: tuple[Row, Row, Row, Row]) -> tuple[Row, Row, Row, Row]:
    if rows[3] != (0, 0, 0, 1):
        raise ValueError("the last row must be [0, 0, 0, 1]")
    x, y, z = ((row[0], row[1], row[2]) for row in rows[:3])
    lengths = [math.hypot(*row) for row in (x, y, z)]
    determinant = math.fsum(a * b for a, b in zip(x, cross(y, z), strict=True))
    if not abs(determinant) > 1e-9 * math.prod(lengths) or not math.prod(lengths) > 0:
        raise ValueError("must not be singular")
    return rows


#: An affine placement: four rows, applied to column vectors.
Matrix = Annotated[tuple[Row, Row, Row, Row], AfterValidator(_affine)]
IDENTITY = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))


class Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


#: A file that a scene names: relative to the scene file, or over HTTP `sha256:…` of an uploaded one.
File = Annotated[str, Field(min_length=1)]
FILE = "relative to the scene file; over HTTP `sha256:…` of an uploaded file."

#: What a picture may hold beside its beauty; see `Scene.layers`.
LayerName = Literal["albedo", "normal", "depth", "optical_depth", "transmittance", "position"]


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def has_direction(value: Vector) -> Vector:
    if not 0 < math.hypot(*value) < math.inf:
        raise ValueError("must not be zero")
    return value


Direction = Annotated[Vector, AfterValidator(has_direction)]


def length(least: int, most: int) -> AfterValidator:
    """Bounds the number of items, with a sentence of its own."""

    def check(value: tuple[Any, ...]) -> tuple[Any, ...]:
        if not least <= len(value) <= most:
            bound = f"exactly {most}" if least == most else f"{least} to {most}"
            raise ValueError(f"must hold {bound}, not {len(value)}")
        return value

    return AfterValidator(check)


def box_has_a_volume(low: Vector, high: Vector) -> None:
    for axis, a, b in zip("xyz", low, high, strict=True):
        if not a < b:
            raise ValueError(f"max must exceed min along {axis} (min {a:g}, max {b:g})")
