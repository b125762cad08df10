"""What a render says of itself: the EXR's header, from which it can be rendered again, and report.json."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from woodcock import __version__
from woodcock.certificate import certify
from woodcock.contract import outcome
from woodcock.film import Film
from woodcock.leanness import Contents
from woodcock.metrics import estimated_rel_mse
from woodcock.reference import Reference
from woodcock.scene import Scene
from woodcock.series import Point, against, efficiency, slope

if TYPE_CHECKING:
    from woodcock.evidence import Evidence
    from woodcock.generic.gain import Gain


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
    program: Contents


class Use(Facts):
    """A device's part in a render. samples: rendered there, per pixel; programs: mean samples per pixel by the hash of
    the program that rendered them; render_seconds: spent on them; evidence: for the certificate, None until it is
    gathered or where the device could not.

    The generic program took part where the scene's own, of which all other facts are, was still being built.
    """

    samples: int
    programs: dict[str, float]
    render_seconds: float
    evidence: Evidence | None


def header(
    scene: Scene, film: Film, uses: Sequence[Use], series: Sequence[Point], seconds: Mapping[str, float]
) -> dict[str, str]:
    """What the EXR's header must say so that the image can be rendered again, and how large its error is.

    Numbers as text, those of them that are known; as `build` has them.
    """
    numbers = {
        "samples": film.mean_samples,
        "seconds": wall(series, seconds),
        "rmse": _known(film.rmse()),
        "relativeRmse": relative_rmse(film),
        "relMse": _rel_mse(film),
        "efficiency": efficiency(film, wall(series, seconds)),
        "slope": slope(series)["slope"],
    }
    return {
        "scene": scene.model_dump_json(),
        "seed": str(scene.seed),
        "sampleRanges": json.dumps(film.ranges),
        "programHash": ", ".join(dict.fromkeys(name for use in uses for name in use["programs"])),
        "version": __version__,
        "device": "; ".join(use["name"] for use in uses),
        "driver": "; ".join(f"{use['platform']}, {use['driver']}" for use in uses),
        **{name: f"{number:.9g}" for name, number in numbers.items() if number is not None},
    }


def build(
    film: Film,
    uses: Sequence[Use],
    series: Sequence[Point],
    seconds: Mapping[str, float],
    *,
    scene: Scene,
    reference: Reference | None = None,
) -> dict[str, Any]:
    """The report; `report_schema.Report` says what its numbers are. uses: not empty.

    seconds: wall seconds of rendering, of merging, of checking (measuring errors and gathering evidence) and of writing
    the pictures: render, merge, check, write. Devices read, build and upload side by side: the longest seconds count.
    """
    first = {part: max(use["seconds"][part] for use in uses) for part in ("read", "build", "upload")}
    after, lasted = {part: seconds[part] for part in ("render", "merge", "check", "write")}, wall(series, seconds)
    rendered = sum(use["render_seconds"] for use in uses)
    orders = _orders(film, uses[0]["norm"], uses[0]["unscattered"])
    fall = slope(series, uniform=int(film.count.min()) == int(film.count.max()))
    reached = outcome(scene.stop, film, lasted)
    return {
        "version": __version__,
        "width": film.width,
        "height": film.height,
        "channels": film.channels,
        "samples": film.samples,
        "mean_samples": film.mean_samples,
        "sample_ranges": film.ranges,
        "contract": reached,
        "seconds": {**first, **after},
        "utilisation": rendered / (lasted * len(uses)) if lasted > 0 else None,
        "rmse": _known(film.rmse()),
        "relative_rmse": relative_rmse(film),
        "rel_mse": _rel_mse(film),
        "efficiency": efficiency(film, lasted),
        "deterministic": film.deterministic,
        "bound": _bound(film),
        "mean_luminance": film.mean_luminance(),
        "orders": orders,
        "certificate": certify(film, uses, orders, fall, reached),
        "error": list(series),
        "slope": fall,
        "reference": None if reference is None else reference.name,
        "against": None if reference is None else against(film, reference),
        "rejected_samples": film.rejected,
        "majorant_violations": film.violations,
        "program_hash": uses[0]["program_hash"],
        "program": uses[0]["program"],
        "gain": _gain(uses),
        "kinds": uses[0]["kinds"],
        "devices": list(uses),
    }


def _gain(uses: Sequence[Use]) -> Gain | None:
    """Of the first device that measured it."""
    evidence = (use["evidence"] for use in uses)
    return next((gain for one in evidence if one and (gain := one.get("gain"))), None)


def wall(series: Sequence[Point], seconds: Mapping[str, float]) -> float:
    """Seconds from the first range of samples to the last merge: the last point's, else those of rendering."""
    return max(seconds["render"], series[-1]["seconds"] if series else 0.0)


def relative_rmse(film: Film) -> float | None:
    """Root mean square error over the mean luminance; without noise at most that. None where it is not known."""
    rmse, mean = film.rmse(), film.mean_luminance()
    return rmse / mean if math.isfinite(rmse) and mean > 0 else None


def _rel_mse(film: Film) -> float | None:
    """By the samples' own variances; None where they are not known, and without noise."""
    beauty = film.layer("")
    return None if film.deterministic else _known(estimated_rel_mse(beauty.mean, beauty.variance()))


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
