"""The figure: error against seconds of the three renders, and the other metrics of the first."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from studies.series.measure import Numbers, Run
from woodcock.series import Against

#: Okabe & Ito's.
ESTIMATED: dict[str, Any] = {"color": "#0072B2", "marker": "o", "fillstyle": "none", "label": "by the samples: rmse"}
TRUE: dict[str, Any] = {"color": "#D55E00", "marker": "s", "label": "against the reference: √mse"}
OTHERS = (
    ("rel_mse", "relMSE", "#009E73", "^"),
    ("smape", "SMAPE", "#CC79A7", "D"),
    ("flip", "HDR-FLIP", "#E69F00", "v"),
)


def draw(numbers: Numbers, file: Path) -> None:
    rules = {"svg.hashsalt": "series", "font.size": 9, "axes.titlesize": 10, "axes.titlelocation": "left"}
    with mpl.rc_context(rules | {"lines.markersize": 4.5}):
        figure = Figure(figsize=(11, 8), facecolor="white", layout="constrained")
        (first, second), (third, fourth) = figure.subplots(2, 2)
        _curves(first, numbers.plain, "a   As expected")
        _curves(second, numbers.clamped, f"b   Biased: samples clamped at {numbers.effort.clamp:g} × the mean")
        _curves(third, numbers.lamp, "c   A heavy tail: a lamp in fog")
        _others(fourth, numbers.plain)
        figure.savefig(file, metadata={"Date": None} if file.suffix == ".svg" else None)


def _panel(panel: Any, title: str, y: str) -> None:
    panel.set(title=title, xlabel="device seconds", ylabel=y, xscale="log", yscale="log")
    panel.grid(color="#dddddd", linewidth=0.5)
    panel.set_axisbelow(True)


def _curves(panel: Any, run: Run, title: str) -> None:
    _panel(panel, title, "error of a pixel / mean luminance")
    seconds = np.array([one["device_seconds"] for one in run.series])
    estimated = np.array([one["rmse"] for one in run.series]) / run.mean
    true = np.sqrt([one["mse"] for one in _against(run)]) / run.mean
    panel.plot(seconds, estimated[0] * np.sqrt(seconds[0] / seconds), color="#999999", linewidth=1, label="slope -1/2")
    panel.plot(seconds, estimated, **ESTIMATED)
    panel.plot(seconds[true > 0], true[true > 0], **TRUE)
    panel.axhline(run.noise / run.mean, color="#999999", linestyle=":", label="noise of the reference")
    panel.legend(frameon=False, fontsize=8, loc="lower left")


def _others(panel: Any, run: Run) -> None:
    _panel(panel, "d   Other metrics of a", "")
    for key, label, color, marker in OTHERS:
        known = [
            (p["device_seconds"], value) for p, a in zip(run.series, _against(run), strict=True) if (value := a[key])
        ]  # type: ignore[literal-required]
        panel.plot(*np.array(known).T, color=color, marker=marker, label=label)
    own = np.array([(one["device_seconds"], one["rel_mse"]) for one in run.series])
    panel.plot(*own.T, color="#009E73", linestyle="--", linewidth=1, label="relMSE by the samples")
    panel.legend(frameon=False, fontsize=8, loc="lower left")


def _against(run: Run) -> list[Against]:
    return [one["against"] for one in run.series if one["against"]]
