"""What a report's numbers mean: their formulas and a sentence each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from woodcock.pages import words


@dataclass(frozen=True)
class Metric:
    name: str
    value: str
    formula: str
    says: str


def of_report(report: Mapping[str, Any]) -> Iterator[Metric]:
    """Of the keys that a report has, those whose value is known."""
    mean, without_noise = report["mean_luminance"], report["deterministic"]
    known = "at most, by the integrator’s bound" if without_noise else "estimated from the samples"
    if (relative := report.get("relative_rmse")) is not None:
        yield Metric(
            "Relative error",
            words.percent(relative),
            "RMSE ∕ Ȳ",
            f"Root mean square error of a pixel over the mean luminance, {known}.",
        )
    if (rmse := report.get("rmse")) is not None:
        formula = "√( mean Σ w b² )" if without_noise else "√( mean Σ w Var[Ī] )"
        yield Metric(
            "RMSE",
            words.number(rmse),
            formula,
            f"Root mean square error of a pixel, in the scene’s unit of radiance, {known}; "
            "w are the channels’ weights in luminance, the mean is over the pixels.",
        )
    if (relative := report.get("rel_mse")) is not None:
        yield Metric(
            "relMSE",
            words.number(relative),
            "mean Σ w Var[Ī] ∕ (Ī² + 0.01 Ȳ²)",
            "Relative mean square error, estimated from the samples: dark pixels count as much as bright ones.",
        )
    yield Metric(
        "Mean luminance", words.number(mean), "Ȳ = mean Σ w Ī", "Of all pixels, in the scene’s unit of radiance."
    )
    if (efficiency := report.get("efficiency")) is not None:
        yield Metric(
            "Efficiency",
            words.number(efficiency),
            "1 ∕ (RMSE² × seconds)",
            "What a second of rendering is worth: of two ways to render a scene on one machine, the one of twice the "
            "efficiency has the same error in half the time.",
        )
    if (against := report.get("against")) is not None:
        yield from _of_reference(against, mean)


def _of_reference(against: Mapping[str, Any], mean: float) -> Iterator[Metric]:
    yield Metric(
        "True MSE",
        words.number(against["mse"]),
        "mean Σ w (I − R)² − mean Σ w Var[R]",
        "Mean square difference from the reference, less what the reference’s own noise adds where that is known.",
    )
    yield Metric(
        "True relMSE",
        words.number(against["rel_mse"]),
        "mean Σ w (I − R)² ∕ (R² + 0.01 R̄²)",
        "The same, relative to the reference’s pixels.",
    )
    yield Metric(
        "SMAPE",
        words.percent(against["smape"]),
        "mean |I − R| ∕ (|I| + |R|)",
        "Symmetric mean absolute percentage error, 0 to 100 %; few fireflies move it little.",
    )
    error = against.get("bias_error")
    known = "" if error is None else f" ± {words.number(error, 2)}"
    share = f" Relative to the mean luminance: {words.percent(against['bias'] / mean)}." if mean > 0 else ""
    yield Metric(
        "Bias",
        words.number(against["bias"]) + known,
        "mean Σ w (I − R) ± √(Σ Var) ∕ pixels",
        f"How much too bright the picture is on average, with its standard error: within three of those it is no more "
        f"than chance.{share}",
    )
    if (flip := against.get("flip")) is not None:
        yield Metric(
            "HDR-FLIP",
            words.number(flip),
            "mean over pixels of max over exposures of FLIP",
            "How far an observer sees two pictures differ who flips between them, 0 to 1 (Andersson et al. 2021).",
        )
