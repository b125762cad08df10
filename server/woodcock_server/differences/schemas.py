"""How far two pictures differ, as the API says it."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

#: What can be mapped; of each channel, but FLIP, which has one value a pixel.
Map = Literal["difference", "absolute", "relative", "smape", "flip", "z"]


class Part(BaseModel):
    """Of the picture, pixels from its top left."""

    x: int
    y: int
    width: int
    height: int
    bias: float = Field(description="⟨I - R⟩ over the part, radiance.")
    deviation: float | None = Field(description="The size of that in standard errors; null where these are 0.")


class Scatter(BaseModel):
    """Of the z-scores (I - R) / √(var I + var R), of the channels of pixels that have noise."""

    pixels: float = Field(description="Share of the pixels that have noise.")
    mean_square: float = Field(description="Mean z²: about 1 of noise.")
    error: float = Field(description="Standard error of the mean z².")
    expected: float | None = Field(description="Mean z² of noise of so few samples, at most; null where it may be any.")
    beyond_2: float = Field(description="Share of |z| > 2; of a normal distribution .0455.")
    beyond_3: float = Field(description="Share of |z| > 3; of a normal distribution .0027.")


class Verdict(BaseModel):
    """Noise or bias? By means over the picture and over its parts, and by differences of neighbouring pixels."""

    kind: Literal["same", "noise", "bias", "unclear"]
    says: str
    shared: bool = Field(
        description="The pictures use the same random numbers (one seed and the same samples), so that variances do "
        "not tell how far they should differ: there are no z-scores, and errors are those that the differences "
        "themselves scatter by."
    )
    parts: list[Part] = Field(description="The whole, and 4 × 4 parts of it, row by row.")
    limit: float = Field(description="Standard errors that the largest of all deviations exceeds by chance in 0.1 %.")
    scatter: Scatter | None = Field(description="Null where there are no z-scores.")
    coherence: float | None = Field(
        description="Correlation of a pixel's difference with its right and its lower neighbour's: 0 of noise."
    )
    coherence_deviation: float | None = Field(description="That of the correlation from 0, in standard errors.")
    bias_error: float | None = Field(description="Standard error of ⟨I - R⟩, radiance; null without noise.")
    detectable: float | None = Field(description="The bias of the whole that would have shown, radiance.")


class Difference(BaseModel):
    """I is the job's picture, R the other one's, the reference; ⟨ ⟩ is the mean over pixels, with channels weighted by
    luminance (.2126, .7152, .0722). Where one is grey it counts as three equal channels."""

    model_config = ConfigDict(allow_inf_nan=False)

    job: str
    reference: str
    mse: float = Field(
        description="⟨(I - R)²⟩ - ⟨var R⟩, radiance², and 0 at least; nothing is subtracted where both share random "
        "numbers."
    )
    rel_mse: float | None = Field(
        description="⟨((I - R)² - var R) / (R² + ε)⟩, and 0 at least; ε = 0.01 × (mean luminance of R)². Null where "
        "R is black."
    )
    smape: float = Field(description="⟨|I - R| / (|I| + |R|)⟩, 0 to 1, with 0 / 0 = 0; noise of both adds to it.")
    flip: float | None = Field(
        description="Mean HDR-FLIP (Andersson et al. 2021) at 67 pixels a degree, 0 to 1. Null where it was not asked "
        "for, or cannot be told: R is black, they are too large, or flip-evaluator is not installed."
    )
    bias: float = Field(description="⟨I - R⟩, radiance.")
    noise: float | None = Field(description="⟨var I⟩, radiance²: what of the MSE is noise of I; null if not known.")
    reference_noise: float | None = Field(
        description="⟨var R⟩, radiance²: what was subtracted; null where nothing was."
    )
    reference_mean: float = Field(description="Mean luminance of R, radiance.")
    verdict: Verdict
    maps: dict[Map, str] = Field(description="Where the maps are that there can be.")
