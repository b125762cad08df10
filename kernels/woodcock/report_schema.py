"""What report.json holds: every number with its unit and formula. `woodcock schema report` prints it as JSON Schema.

I is a pixel's value, var I the estimated variance of it, R the reference's value; ⟨ ⟩ is the mean over pixels, with
channels weighted by luminance (.2126, .7152, .0722).
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field


class Part(BaseModel):
    """A key that is not described here is an error: what is written and what is described stay the same."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Seconds(Part):
    """Wall seconds. Devices read, build and upload side by side: the longest count. The service merges, checks and
    writes while devices render, so that its parts may add up to more than what passed."""

    read: float = Field(description="Reading the scene's files and laying the scene out.")
    build: float = Field(description="Compiling the program, or finding it compiled.")
    upload: float = Field(description="Moving the scene to the device.")
    render: float = Field(description="Rendering.")
    merge: float = Field(description="Adding ranges of samples to the film.")
    check: float = Field(description="Measuring errors, and gathering evidence for the certificate.")
    write: float = Field(description="Writing pictures; the service's previews and checkpoints too.")


class Contract(Part):
    """What the scene asks for, and what was reached."""

    kind: str = Field(description="samples, seconds or relative_error.")
    asked: float = Field(description="Samples per pixel, wall seconds, or RMS standard error over mean luminance.")
    reached: float | None = Field(description="In the same unit; null where it is not known.")
    met: bool
    says: str


class Against(Part):
    """The picture against a reference. Where one of the two is grey it counts as three equal channels."""

    mse: float = Field(
        description="⟨(I - R)²⟩ - ⟨var R⟩, radiance², and 0 at least. A reference that does not state its variance "
        "counts as exact; of one with the scene's own seed, which shares samples, it is not subtracted."
    )
    rel_mse: float = Field(
        description="⟨((I - R)² - var R) / (R² + ε)⟩, and 0 at least; ε = 0.01 × (mean luminance of R)²."
    )
    smape: float = Field(
        description="⟨|I - R| / (|I| + |R|)⟩, 0 to 1, with 0 / 0 = 0; the reference's noise adds to it."
    )
    bias: float = Field(description="⟨I - R⟩, radiance: of noise alone, 0 within its standard error.")
    bias_error: float | None = Field(
        description="Standard error of the bias, radiance: √Σ (deviation of a pixel's luminance)² / pixels, of picture "
        "and reference together; at most this, for channels are taken to err together. Null for fewer than two samples "
        "of a pixel."
    )
    flip: float | None = Field(
        description="Mean HDR-FLIP (Andersson et al. 2021) at 67 pixels a degree, 0 to 1: exposures from the "
        "reference's maximum at white to its median at white. Null where the package flip-evaluator is not installed, "
        "and in points of the series for which there was no time: FLIP takes less than a tenth of it."
    )
    reference_mse: float | None = Field(description="⟨var R⟩, radiance²: what was subtracted; null where nothing was.")


class Point(Part):
    """A point of the error series; points are √2 apart in samples, or a range of them."""

    seconds: float = Field(description="Wall seconds since rendering began.")
    device_seconds: float = Field(description="Seconds of rendering, of all devices.")
    samples: float = Field(description="Per pixel, on average.")
    rmse: float = Field(description="√⟨var I⟩, radiance, by the samples: hides a bias.")
    rel_mse: float = Field(
        description="⟨var I / (I² + ε)⟩ with ε = 0.01 × (mean luminance of I)², by the samples; off by a share of "
        "about its own size, and of no pixel above 1: fireflies count for too little."
    )
    against: Against | None = Field(description="Against the reference; null without one.")


class Fit(Part):
    """A line through the points of the series, log error over log device seconds."""

    slope: float = Field(description="d log √mse / d log device_seconds.")
    low: float = Field(description="Lower end of the 95 % band.")
    high: float = Field(description="Upper end of the 95 % band.")
    points: int = Field(description="That it is through.")


class Slope(Part):
    """How fast the error falls. Generalised least squares with the covariance of points that share their samples."""

    slope: float | None = Field(description="d log rmse / d log device_seconds; null for fewer than three points.")
    low: float | None = Field(description="Lower end of its 95 % band.")
    high: float | None = Field(description="Upper end of its 95 % band.")
    expected: float = Field(description="-1/2: of independent samples with a variance.")
    points: int = Field(description="That it is through.")
    verdict: Literal["as expected", "flagged", "not known"] = Field(
        description="Of the error's fall with samples, which the speed of devices does not change. Chance flags one "
        "series in ten thousand; a heavy tail shows in the samples' own error, a bias against the reference alone."
    )
    says: str
    against: Fit | None = Field(description="Of √mse, over the points where it exceeds the reference's noise.")


class Bound(Part):
    """How far a picture without noise may be off, radiance; null where there is no bound."""

    largest: float | None = Field(description="Of a channel of a pixel.")
    rms: float | None = Field(description="√⟨bound²⟩.")


class Orders(Part):
    """What cutting the Neumann series after order n would leave out of the mean luminance."""

    last: int = Field(description="n: the last order with a layer of its own.")
    rest: float = Field(description="Mean luminance of the orders beyond, radiance, as measured.")
    rest_error: float | None = Field(description="Its standard error, at most, radiance.")
    norm: float | None = Field(
        description="At least ‖K‖: what one more order holds of any radiance; null if not known."
    )
    rest_bound: float | None = Field(description="‖K‖ⁿ⁺¹ / (1 - ‖K‖) sup L⁰, radiance; null where ‖K‖ may be 1.")


class CertificateLine(Part):
    name: str
    status: Literal["passed", "failed", "stated", "not checked"]
    says: str
    values: dict[str, Any] = Field(description="The numbers that it says so by.")


class Certificate(Part):
    """What is known of the picture's error, line by line."""

    failed: list[str] = Field(description="Names of the lines that failed.")
    not_checked: list[str] = Field(description="Names of the lines for which evidence is missing.")
    lines: list[CertificateLine]


class Contents(Part):
    """The program as text and as built; what a device does not tell is null."""

    source_lines: int = Field(description="Without comments and blank lines.")
    bytes: int = Field(description="Of its text.")
    remained: dict[str, int] = Field(description="Lines of every file of device code that is in it.")
    left_out: dict[str, int] = Field(description="Lines of every file of device code that is not.")
    binary_bytes: int | None = Field(description="Of the built program.")
    private_bytes: int | None = Field(description="Memory of a work item beyond registers.")
    registers: int | None = Field(description="Of a work item.")


class Gain(Part):
    """What leaving out gains against the program with everything switched on."""

    lean: float = Field(description="Seconds per sample of a pixel.")
    full: float = Field(description="Seconds per sample of a pixel.")
    ratio: float = Field(description="full / lean.")
    low: float = Field(description="Lower end of the ratio's 95 % interval.")
    high: float = Field(description="Upper end of the ratio's 95 % interval.")


class Drift(Part):
    """What float32 does to the picture: the same paths in float64."""

    relative: float = Field(description="(float32 - float64) / float64 of the mean over pixels and channels.")
    error: float = Field(description="Standard error of it.")
    largest: float = Field(description="Of a pixel, relative to the mean.")
    turned: float = Field(description="Share of the pixels in which a decision turned.")
    paths: int = Field(description="That were compared.")


class Check(Part):
    """A law that the program was asked to keep on the device."""

    name: str
    law: str
    status: Literal["passed", "failed", "not checked"]
    deviation: float | None = Field(description="From what the law says, in `unit`.")
    unit: Literal["standard errors", "relative"]
    limit: float | None = Field(description="Largest deviation that passes, in `unit`.")
    reason: str


class Evidence(Part):
    options: list[str] = Field(description="Of the compiler.")
    drift: Drift | None
    checks: list[Check]
    gain: Gain | None


class Storage(Part):
    kind: str = Field(description="uint8, half or float.")
    error: float = Field(description="Largest error of a stored value, relative to the largest value.")


class Medium(Part):
    """A medium as it is on the device."""

    kind: str
    sigma_t: list[float] = Field(description="Largest σ_t, 1 / length; one number, or red, green and blue.")
    storage: dict[str, Storage] = Field(description="Of its density, albedo and emission, as far as they are grids.")
    emits: bool
    scatters: bool
    coloured: bool


class BuildSeconds(Part):
    """As in `seconds`, of one device."""

    read: float = Field(description="Wall seconds.")
    build: float = Field(description="Wall seconds.")
    upload: float = Field(description="Wall seconds.")


class Device(Part):
    """A device's part in the render."""

    id: str
    name: str
    kind: str
    platform: str
    platform_version: str
    version: str
    driver: str
    lanes: int = Field(description="Paths in lockstep.")
    program_hash: str
    kinds: dict[str, list[str]] = Field(description="Kinds that are compiled in, by concept.")
    precision: Literal["float", "double"]
    norm: float | None = Field(description="As `orders.norm`.")
    unscattered: float | None = Field(description="At least L⁰ anywhere, radiance; null if not known.")
    media: list[Medium]
    seconds: BuildSeconds
    program: Contents
    samples: int = Field(description="Per pixel, rendered there.")
    programs: dict[str, float] = Field(
        description="Mean samples per pixel by the hash of the program that rendered them: the generic one may have "
        "rendered while the scene's own was being built."
    )
    render_seconds: float = Field(description="Seconds that it rendered.")
    evidence: Evidence | None


class Report(Part):
    """What a render says of itself."""

    version: str = Field(description="Of the program.")
    width: int = Field(description="Pixels.")
    height: int = Field(description="Pixels.")
    channels: int = Field(description="Of the beauty: 1 or 3.")
    samples: int = Field(description="Of a pixel that has all of them.")
    mean_samples: float = Field(description="Per pixel, on average.")
    sample_ranges: list[tuple[int, int]] = Field(description="Samples [start, stop) that the picture holds.")
    contract: Contract | None
    seconds: Seconds
    utilisation: float | None = Field(
        description="Σ devices.render_seconds / (devices × wall seconds from the first range of samples to the last)."
    )
    rmse: float | None = Field(
        description="√⟨var I⟩, radiance; without noise √⟨bound²⟩. Null for fewer than two samples."
    )
    relative_rmse: float | None = Field(description="rmse / mean_luminance.")
    rel_mse: float | None = Field(description="As that of the series' points; null without noise.")
    efficiency: float | None = Field(
        description="1 / (rmse² × wall seconds from the first range of samples to the last), 1 / (radiance² s): twice "
        "as large is as good as half of the time. Null without noise."
    )
    deterministic: bool = Field(description="Without noise: a bound takes the place of variances.")
    bound: Bound | None = Field(description="Null with noise.")
    mean_luminance: float = Field(description="⟨I⟩, radiance.")
    orders: Orders | None = Field(description="Null unless the scene asks for orders.")
    certificate: Certificate
    error: list[Point] = Field(description="The error series; empty without noise.")
    slope: Slope
    reference: str | None = Field(description="Name of the picture that errors are measured against.")
    against: Against | None = Field(description="The picture against it.")
    rejected_samples: int = Field(description="Samples that count as 0, for they were no radiance.")
    majorant_violations: int = Field(description="Tentative collisions where σ_t exceeded its majorant.")
    program_hash: str
    program: Contents
    gain: Gain | None = Field(description="Null where it was not measured.")
    kinds: dict[str, list[str]] = Field(description="Kinds that are compiled in, by concept.")
    devices: list[Device]
