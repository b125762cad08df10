"""What a render says of itself: the EXR's header, from which it can be rendered again, and report.json."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from woodcock import __version__
from woodcock.certificate import certify
from woodcock.film import Film
from woodcock.scene import Scene

if TYPE_CHECKING:
    from woodcock.evidence import Evidence

#: Samples from one point of the error series to the next.
SERIES_GROWTH = math.sqrt(2)


class Facts(TypedDict):
    """A scene on a device. lanes: paths in lockstep; kinds: compiled in; seconds: of read, build and upload.
    precision: of the kernel's numbers; media: how each is stored, and the largest error of that, relative to its
    largest value.

    norm: at least ‖K‖, how much of any radiance one more order of scattering can hold; unscattered: at least L⁰, in
    every direction everywhere; None where no such bound is known.
    """

    id: str
    name: str
    kind: str
    platform: str
    platform_version: str
    version: str
    driver: str
    lanes: int
    program_hash: str
    kinds: dict[str, list[str]]
    precision: Literal["float", "double"]
    norm: float | None
    unscattered: float | None
    media: list[dict[str, Any]]
    seconds: dict[str, float]


class Use(Facts):
    """A device's part in a render. samples: rendered there, per pixel; render_seconds: spent on them; evidence: for the
    certificate, None until it is gathered or where the device could not.
    """

    samples: int
    render_seconds: float
    evidence: Evidence | None


class Point(TypedDict):
    """A point of the error series: rmse is the estimated root mean square error of a pixel's value."""

    seconds: float
    samples: int
    rmse: float


def point(seconds: float, film: Film) -> Point | None:
    """The error after so many seconds; None while it cannot be estimated, with fewer than two samples a pixel.

    Without noise too: there is one error then, and nothing that falls.
    """
    rmse = math.nan if film.deterministic else film.rmse()
    return {"seconds": seconds, "samples": film.samples, "rmse": rmse} if math.isfinite(rmse) else None


def header(scene: Scene, film: Film, uses: Sequence[Use]) -> dict[str, str]:
    """What the EXR's header must say so that the image can be rendered again."""
    return {
        "scene": scene.model_dump_json(),
        "seed": str(scene.seed),
        "sampleRanges": json.dumps(film.ranges),
        "programHash": ", ".join(dict.fromkeys(use["program_hash"] for use in uses)),
        "version": __version__,
        "device": "; ".join(use["name"] for use in uses),
        "driver": "; ".join(f"{use['platform']}, {use['driver']}" for use in uses),
    }


def build(
    film: Film, uses: Sequence[Use], series: Sequence[Point], render: float, check: float, write: float
) -> dict[str, Any]:
    """The report. uses: not empty; render, check, write: wall seconds of rendering, of gathering evidence, and of
    writing the pictures.

    Without noise `rmse` is at most that. Devices read, build and upload side by side: the longest seconds count.
    """
    seconds = {part: max(use["seconds"][part] for use in uses) for part in ("read", "build", "upload")}
    rmse, mean = film.rmse(), film.mean_luminance()
    orders = _orders(film, uses[0]["norm"], uses[0]["unscattered"])
    return {
        "version": __version__,
        "width": film.width,
        "height": film.height,
        "channels": film.channels,
        "samples": film.samples,
        "sample_ranges": film.ranges,
        "seconds": {**seconds, "render": render, "check": check, "write": write},
        "rmse": _known(rmse),
        "relative_rmse": rmse / mean if math.isfinite(rmse) and mean > 0 else None,
        "deterministic": film.deterministic,
        "bound": _bound(film),
        "mean_luminance": mean,
        "orders": orders,
        "certificate": certify(film, uses, orders),
        "error": list(series),
        "rejected_samples": film.rejected,
        "majorant_violations": film.violations,
        "program_hash": uses[0]["program_hash"],
        "kinds": uses[0]["kinds"],
        "devices": list(uses),
    }


def _bound(film: Film) -> dict[str, float | None] | None:
    """Of a film without noise, how far a channel of a pixel may be off: at most, and root mean square by luminance."""
    if film.bound is None:
        return None
    return {"largest": _known(float(film.bound.max())), "rms": _known(film.rmse())}


def _orders(film: Film, norm: float | None, unscattered: float | None) -> dict[str, float | int | None] | None:
    """What cutting the Neumann series after its last order of its own would leave out of the mean luminance.

    Measured, with its standard error, and bounded a priori: ‖K L⁰ + …‖ from order n + 1 on is ‖K‖ⁿ⁺¹ / (1 - ‖K‖) ‖L⁰‖
    at most.
    """
    layers = [layer for layer in film.layers if layer.startswith("order.")]
    if not layers:
        return None
    last, rest = len(layers) - 2, film.layer("order.rest")
    bound = None
    if norm is not None and norm < 1 and unscattered is not None:
        bound = norm ** (last + 1) / (1 - norm) * unscattered
    return {
        "last": last,
        "rest": rest.mean_luminance(),
        "rest_error": _known(rest.mean_luminance_error()),
        "norm": norm,
        "rest_bound": bound,
    }


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
