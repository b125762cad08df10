"""Pages of made-up numbers, with names that would break a page that does not escape them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from woodcock.compare import Row, Slice, Verdict, winner
from woodcock.compare.agreement import Mean, means
from woodcock.compare.efficiency import efficiency
from woodcock.compare.page import page
from woodcock.film import Film
from woodcock.pages import report_page
from woodcock.reference import Reference
from woodcock.scene import Scene

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)> \" ' & {{ 7 * 7 }} {% raw %}"
SAMPLES = 64

SCENE: dict[str, Any] = {
    "camera": {"kind": "perspective", "origin": [0, 0, -4], "target": [0, 0, 0]},
    "volumes": [{"kind": "grid", "file": f"{HOSTILE}.vdb", "grid": HOSTILE, "albedo": 0.9}],
    "lights": [{"kind": "constant", "radiance": 1.0}],
    "film": {"width": 48, "height": 32},
    "stop": {"kind": "relative_error", "relative_error": 0.02},
}


def scene() -> Scene:
    return Scene.model_validate(SCENE)


def truth() -> np.ndarray[Any, np.dtype[np.float64]]:
    """(32, 48, 3), a bright spot before a dim ground."""
    y, x = np.mgrid[0:32, 0:48]
    spot = np.exp(-((x - 30) ** 2 + (y - 12) ** 2) / 60)
    return 0.1 + spot[..., None] * np.array([1.0, 0.7, 0.4])


def film(deviation: float = 0.5, seed: int = 1) -> Film:
    """As random paths would give it: samples of a deviation in units of the radiance; one half has twice as many."""
    random, mean = np.random.default_rng(seed), truth()
    count = np.full(mean.shape[:2], SAMPLES, np.uint32)
    count[:, :24] //= 2
    n = count[..., None]
    values = mean * (1 + deviation * random.standard_normal(mean.shape) / np.sqrt(n))
    return Film(count, values, (deviation * mean) ** 2 * (n - 1), ("R", "G", "B"), ((0, SAMPLES),))


def reference() -> Reference:
    return Reference(truth(), np.full((32, 48, 3), 1e-8), HOSTILE)


def against(mse: float) -> dict[str, Any]:
    return {
        "mse": mse,
        "rel_mse": 0.004,
        "smape": 0.031,
        "bias": -1.2e-4,
        "bias_error": 2.1e-4,
        "flip": 0.043,
        "reference_mse": 1e-8,
    }


def points(rmse: float, known: bool = True, speed: float = 1.0) -> list[dict[str, Any]]:
    """A series that falls as it should, to this error at the end."""
    found = []
    for step in range(12):
        n = 2 ** (step / 2 + 0.5)
        error = rmse * math.sqrt(2**6 / n) * (1 + 0.05 * math.sin(3 * step))
        found.append(
            {
                "seconds": 0.11 * n / speed,
                "device_seconds": 0.1 * n / speed,
                "samples": n,
                "rmse": error,
                "rel_mse": error**2,
                "against": against((1.1 * error) ** 2) if known else None,
            }
        )
    return found


def report(picture: Film, known: bool = True) -> dict[str, Any]:
    """Every key of a report that the page shows."""
    rmse, mean = picture.rmse(), picture.mean_luminance()
    lines = [
        ("standard error", "passed", "The mean luminance is known to 0.21 % by how 9 launches differ."),
        ("samples", "failed", f"3 of 98304 samples count as 0: {HOSTILE}."),
        ("majorant", "stated", "Nothing is tracked under a majorant."),
        ("rounding", "not checked", "The paths were not compared with ones in double precision."),
    ]
    program = {
        "source_lines": 812,
        "bytes": 26391,
        "remained": {"core/rng.h": 52, "phase/isotropic.h": 12, "generated": 99},
        "left_out": {"surface/mesh.h": 84, "light/sun.h": 33},
        "binary_bytes": 419023,
        "private_bytes": 1024,
        "registers": None,
    }
    device = {
        "id": "cpu0",
        "name": HOSTILE,
        "platform": "Portable Computing Language",
        "driver": "7.1",
        "lanes": 8,
        "precision": "float",
    }
    return {
        "version": "0.1.0",
        "width": picture.width,
        "height": picture.height,
        "channels": 3,
        "samples": picture.samples,
        "mean_samples": picture.mean_samples,
        "sample_ranges": picture.ranges,
        "contract": {
            "kind": "relative_error",
            "asked": 0.02,
            "reached": rmse / mean,
            "met": False,
            "says": "The root mean square error is 7.2 % of the mean luminance; 2 % was asked for.",
        },
        "seconds": {
            "read": 0.02,
            "build": 1.4,
            "upload": 0.004,
            "render": 6.4,
            "merge": 0.1,
            "check": 0.9,
            "write": 0.05,
        },
        "utilisation": 0.943,
        "rmse": rmse,
        "relative_rmse": rmse / mean,
        "rel_mse": 0.0052,
        "efficiency": 1 / (rmse**2 * 6.4),
        "deterministic": False,
        "mean_luminance": mean,
        "certificate": {
            "failed": ["samples"],
            "not_checked": ["rounding"],
            "lines": [{"name": name, "status": status, "says": says, "values": {}} for name, status, says in lines],
        },
        "error": points(rmse, known),
        "slope": {
            "slope": -0.49,
            "low": -0.53,
            "high": -0.45,
            "expected": -0.5,
            "points": 12,
            "verdict": "as expected",
            "says": "The error falls as the power −0.49 of time (95 % band −0.53 to −0.45), as independent samples do.",
            "against": {"slope": -0.48, "low": -0.55, "high": -0.41, "points": 12} if known else None,
        },
        "reference": HOSTILE if known else None,
        "against": against((1.1 * rmse) ** 2) if known else None,
        "program_hash": "031e9437f0cecdc649a98c5ced25a2aba4251677e447b4361a31010464be5b7d",
        "program": program,
        "gain": {"lean": 1e-7, "full": 2e-7, "ratio": 2.03, "low": 1.98, "high": 2.09},
        "kinds": {"camera": ["perspective"], "light": []},
        "devices": [device],
    }


def sample_report() -> str:
    picture = film()
    return report_page(report(picture), scene(), picture, reference(), HOSTILE)


def row(label: str, picture: Film, speed: float, *, default: bool = False, known: bool = True) -> Row:
    """A variant so many times as fast as another one, by turns that differ a little."""
    variance = picture.rmse() ** 2 * picture.mean_samples
    times = 0.1 / speed * (1 + 0.04 * np.sin(np.arange(16) * (2 + len(label))))
    slices = [Slice(float(t), 4, variance) for t in times]
    series: list[Any] = points(picture.rmse(), known, speed)
    return {
        "label": label,
        "choices": {"majorant": label},
        "default": default,
        "seconds": float(times.sum()),
        "build_seconds": 1.4,
        "samples": 64.0,
        "rmse": picture.rmse(),
        "deterministic": False,
        "efficiency": efficiency(slices),
        "slices": slices,
        "means": means(picture),
        "against": against(picture.rmse() ** 2) if known else None,
        "series": series,
    }


LABELS = [
    f"{flight}, {transmittance}, {majorant}"
    for flight in ("delta", "decomposition")
    for transmittance in ("ratio", "residual_ratio", "ray_marching")
    for majorant in ("global", "grid")
]


def rows() -> tuple[list[Row], dict[str, Film]]:
    """A dozen variants, one of them wrong, one with a hostile name."""
    labels = [*LABELS[:-1], HOSTILE]
    films = {label: film(0.3 + 0.1 * index, index) for index, label in enumerate(labels)}
    found = [row(label, each, 1 + index / 4, default=index == 1) for index, (label, each) in enumerate(films.items())]
    found[3]["means"] = [Mean(2 * mean.value, mean.error, mean.bound) for mean in found[3]["means"]]
    return found, films


def sample_comparison() -> str:
    found, films = rows()
    verdict: Verdict = winner(found)
    measured = [("device", HOSTILE), ("time", "10 s of rendering for each")]
    return page(
        HOSTILE,
        found,
        verdict,
        films,
        scene(),
        measured,
        {HOSTILE: "delta, ratio, grid", "another": "delta, ratio, grid"},
    )
