"""The page: its text, with the numbers of a run filled in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from scipy.stats import norm

from studies.stiff.device import Result
from studies.stiff.measure import OURS, RADAU, STABILITY, STIFF, TOLERANCES, WANTED, Curves, Numbers, Point
from studies.stiff.methods import METHODS

#: Evaluations of the fixed steps that table 3 shows.
BUDGETS = (100, 10_000, 1_000_000)


def page(n: Numbers) -> str:
    """page.md, filled in."""
    ours = [p for points in n.curves.values() for p in points[OURS]]
    slopes = [slope for _, found in n.random.values() if (slope := _slope(found)) is not None]
    z = [(found[-1].value - exact) / found[-1].error for exact, found in n.random.values()]
    values = {
        "platform": n.platform,
        "precision": n.precision,
        "reference": _error(max(n.reference.values())),
        "references": "; ".join(n.reference),
        "radau": RADAU,
        "ours": OURS,
        "ours_begins": OURS.capitalize(),
        "stiff": f"{STIFF:.0e}",
        "stability": stability_table(n),
        "wanted": f"{WANTED:.0e}",
        "most": str(n.effort.steps[-1]),
        "reached": _table(
            ["σ_t", *(f"{s:.0e}" for s in n.effort.decades)], ([m, *map(_count, c)] for m, c in n.reached.items())
        ),
        "spent": _range([p.evaluations for p in n.constant]),
        "constant_error": _error(max(p.error for p in n.constant)),
        "constant_bound": _error(max(p.bound for p in n.constant)),
        "curves": "\n\n".join(_budgets(name, found) for name, found in n.curves.items()),
        "worst": f"{max(p.error / p.bound for p in ours):.1g}",
        "orders": _table(["method", *n.orders], ([m, *(_order(n.orders[p][m]) for p in n.orders)] for m in METHODS)),
        "clear": _table(
            ["σ_t", "float32", "float64", OURS],
            ([f"{s:.0e}", _error(a), _error(b), _error(p.error)] for s, a, b, p in n.clear),
        ),
        "random": _table(
            ["estimator", "paths", "evaluations a path", "L", "exact", "standard error", "off by", "power of N"],
            _random(n),
        ),
        "slopes": f"{_signed(min(slopes))} to {_signed(max(slopes))}",
        "runs": str(len(z)),
        "furthest": f"{max(map(abs, z)):.1f}",
        "chance": f"{_chance(z):.2f}",
        "walked": f"{n.walked[0]:.8g}",
        "walked_compensated": f"{n.walked[1]:.8g}",
        "walked_right": f"{n.walked[2]:.8g}",
        "behind": _table(["σ_t", "random paths, float32", "± one standard error", f"{OURS}, error"], _behind(n)),
    }
    return (Path(__file__).parent / "page.md").read_text().format(**values)


def stability_table(n: Numbers) -> str:
    return _table(["h σ_t", *(f"{z:g}" for z in STABILITY)], ([m, *map(_error, e)] for m, e in n.stability.items()))


def row(method: str, tolerance: float, p: Point) -> list[str]:
    """Of an adaptive method's table."""
    bound = "" if np.isnan(p.bound) else _error(p.bound)
    return [method, f"{tolerance:.0e}", str(p.evaluations), _error(p.error), bound]


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *rows])


def _error(value: float) -> str:
    """Two digits; what is mere rounding differs from machine to machine, and is not told apart."""
    if np.isnan(value):
        return "0 / 0"
    if value < 1e-12:
        return "< 1e-12"
    return f"{value:.1e}" if value < 1e20 else "blows up"


def _count(value: int | None) -> str:
    return "–" if value is None else str(value)


def _range(values: Sequence[int]) -> str:
    low, high = min(values), max(values)
    return f"{low} evaluations" if low == high else f"{low} to {high} evaluations"


def _order(value: float) -> str:
    return "–" if np.isnan(value) else "exact" if np.isinf(value) else f"{abs(value):.1f}"


def _signed(value: float) -> str:
    return f"−{-value:.2f}" if value < 0 else f"{value:.2f}"


def _budgets(name: str, curves: Curves) -> str:
    def at(points: Sequence[Point], budget: int) -> str:
        within = [p for p in points if p.evaluations <= 1.1 * budget]
        return _error(within[-1].error)

    rows = [[m, *(at(curves[m], budget) for budget in BUDGETS)] for m in METHODS]
    steps = _table([name, *(f"{budget:.0e} evaluations" for budget in BUDGETS)], rows)
    adaptive = [
        row(method, tolerance, p)
        for method in (RADAU, OURS)
        for tolerance, p in list(zip(TOLERANCES, curves[method], strict=True))[::2]
    ]
    return f"{steps}\n\n{_table([name, 'tolerance', 'evaluations', 'error', 'stated bound'], adaptive)}"


def _slope(found: Sequence[Result]) -> float | None:
    """The power of N by which standard errors of runs go, None for fewer than three."""
    if len(found) < 3:
        return None
    paths, errors = np.log(np.array([(r.samples, r.error) for r in found])).T
    return float(np.polyfit(paths, errors, 1)[0])


def _random(n: Numbers) -> Iterable[list[str]]:
    for label, (exact, found) in n.random.items():
        last, slope = found[-1], _slope(found)
        off = f"{(last.value - exact) / last.error:+.1f} standard errors"
        numbers = [f"{last.evaluations / last.samples:.3g}", f"{last.value:.5g}", f"{exact:.5g}", f"{last.error:.1e}"]
        yield [label, str(last.samples), *numbers, off, "" if slope is None else _signed(slope)]


def _chance(z: Sequence[float]) -> float:
    """Of so large a deviation among so many (Šidák 1967)."""
    return float(-np.expm1(len(z) * np.log1p(-2 * norm.sf(max(map(abs, z))))))


def _behind(n: Numbers) -> Iterable[list[str]]:
    for sigma, value, error, step in n.behind:
        yield [f"{sigma:.0e}", f"{value:.4f}", f"{error:.4f}", _error(step.error)]
