"""The figure: six panels, logarithmic. Colours are Okabe & Ito's, and every method has a marker of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.stiff.measure import OURS, RADAU, STABILITY, STIFF, WANTED, Numbers, Point

STYLES: dict[str, dict[str, Any]] = {
    "explicit Euler": {"color": "#E69F00", "marker": "o", "markersize": 8, "fillstyle": "none"},
    "RK4": {"color": "#D55E00", "marker": "s"},
    "implicit Euler": {"color": "#56B4E9", "marker": "^"},
    "ray marching": {"color": "#009E73", "marker": "D"},
    "ray marching, opacity": {"color": "#CC79A7", "marker": "v"},
    RADAU: {"color": "#777777", "marker": "x"},
    OURS: {"color": "#000000", "marker": "*", "markersize": 9, "linewidth": 2},
}
#: Errors beyond these lie on the panels' edges: below is rounding, above a method that blew up.
FLOOR, CEILING = 1e-16, 1e6
LIMITS = (FLOOR / 10, CEILING * 1e3)
BOUND: dict[str, Any] = {
    "color": "#000000",
    "marker": "_",
    "markersize": 10,
    "linestyle": "none",
    "markeredgewidth": 1.5,
}
#: Of the random runs.
SHOWN = ("delta, constant σ_t = 1e-02", "delta, constant σ_t = 1e+02", "delta, constant σ_t = 1e+08")
SHOWN += ("delta, ramp, majorant of 256 cells", "ratio, foil of σ_t = 16", "ratio, foil of σ_t = 4096")
TITLES = {
    "jumps": "c   Jumps: eight layers, $\\sigma_t = 10^{-3}$ and $10^8$",
    "foils": "d   Seven foils of optical depth ½, $\\sigma_t = 3\\cdot 10^4$",
    "ramp": "e   Ramp: $\\sigma_t$ from 1 to $10^8$",
}


def draw(numbers: Numbers, file: Path) -> None:
    rules = {"svg.hashsalt": "stiff", "font.size": 9, "axes.titlesize": 10, "axes.titlelocation": "left"}
    with mpl.rc_context(rules | {"lines.markersize": 4.5}):
        figure = Figure(figsize=(13, 8.6), facecolor="white", layout="constrained")
        axes = figure.subplots(2, 3).flatten()
        _stability(axes[0], numbers)
        _reached(axes[1], numbers)
        for panel, (name, title) in zip(axes[2:5], TITLES.items(), strict=True):
            _curves(panel, numbers, name, title)
        _random(axes[5], numbers)
        handles = [Line2D([], [], label=method, **style) for method, style in STYLES.items()]
        handles.append(Line2D([], [], label="the bound it states", **BOUND))
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=9.5)
        figure.savefig(file, metadata={"Date": None} if file.suffix == ".svg" else None)


def _panel(panel: Any, title: str, x: str, y: str) -> None:
    panel.set(title=title, xlabel=x, ylabel=y, xscale="log", yscale="log")
    panel.grid(color="#dddddd", linewidth=0.5)
    panel.set_axisbelow(True)


def _errors(panel: Any) -> None:
    panel.set_ylim(*LIMITS)
    panel.set_yticks([10.0**k for k in range(-15, 7, 3)])
    panel.axhspan(CEILING, LIMITS[1], color="#eeeeee", zorder=0)
    panel.text(0.02, CEILING * 60, "beyond", transform=panel.get_yaxis_transform(), color="#555555", fontsize=8)


def _clipped(values: Any) -> Any:
    return np.clip(values, FLOOR, CEILING * 3)


def _stability(panel: Any, numbers: Numbers) -> None:
    _panel(panel, f"a   Stability: constant $\\sigma_t = {_power(STIFF)}$", "step × $\\sigma_t$", "relative error")
    for method, errors in numbers.stability.items():
        panel.plot(STABILITY, _clipped(errors), **STYLES[method])
    for limit, name, side in ((2, "2  ", "right"), (2.785, "  2.785", "left")):
        panel.axvline(limit, color="#999999", linestyle=":")
        panel.annotate(name, (limit, 1e-8), ha=side, va="center", color="#555555")
    panel.set(xticks=(0.5, 1, 2, 4), xticklabels=("0.5", "1", "2", "4"))
    panel.minorticks_off()
    _errors(panel)


def _reached(panel: Any, numbers: Numbers) -> None:
    title = f"b   Cost of a relative error of ${_power(WANTED)}$: constant $\\sigma_t$"
    _panel(panel, title, "$\\sigma_t$", "evaluations of ($\\sigma_t$, q)")
    for method, style in STYLES.items():
        known = [(s, n) for s, n in zip(numbers.effort.decades, numbers.reached[method], strict=True) if n is not None]
        panel.plot(*zip(*known, strict=True), **style)
    most = numbers.effort.steps[-1]
    panel.set_ylim(0.5, 20 * most)
    panel.axhspan(most, 20 * most, color="#eeeeee", zorder=0)
    panel.text(0.02, 3 * most, "not tried", transform=panel.get_yaxis_transform(), color="#555555", fontsize=8)


def _curves(panel: Any, numbers: Numbers, name: str, title: str) -> None:
    _panel(panel, title, "evaluations of ($\\sigma_t$, q)", "relative error")
    for method, style in STYLES.items():
        points: list[Point] = numbers.curves[name][method]
        panel.plot([p.evaluations for p in points], _clipped([p.error for p in points]), **style)
    ours = numbers.curves[name][OURS]
    panel.plot([p.evaluations for p in ours], [p.bound for p in ours], **BOUND)
    _errors(panel)


def _random(panel: Any, numbers: Numbers) -> None:
    _panel(panel, "f   Random estimators: by number of paths", "paths", "standard error, relative")
    colours = ["#000000", "#E69F00", "#56B4E9", "#009E73", "#0072B2", "#D55E00"]
    most = 0
    for label, colour, marker in zip(SHOWN, colours, "os^v<>", strict=True):
        exact, found = numbers.random[label]
        x, y = [r.samples for r in found], [r.error / exact for r in found]
        named = label.replace("σ_t", "$\\sigma_t$")
        panel.plot(x, y, color=colour, marker=marker, label=named, markersize=7, fillstyle="none")
        most = max(most, x[-1])
    x = np.array([2e3, most])
    panel.plot(x, 3 / np.sqrt(x), "k--", linewidth=0.8, label="$N^{-1/2}$")
    panel.set_ylim(1e-7, 0.2)
    panel.legend(fontsize=8, loc="lower left", frameon=False)


def _power(value: float) -> str:
    return f"10^{{{round(np.log10(value))}}}"
