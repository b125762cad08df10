"""The page: its text, with the numbers of a run filled in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from studies.series.measure import Numbers, Run
from woodcock.convergence import Fit
from woodcock.series import Slope


def page(n: Numbers) -> str:
    """page.md, filled in."""
    effort, plain, clamped = n.effort, n.plain, n.clamped
    values = {
        "device": n.device,
        "size": f"{effort.width} × {effort.height}",
        "samples": str(effort.samples),
        "reference_samples": str(effort.reference),
        "noise": _percent(plain.noise, plain),
        "series": _series(plain),
        "metrics": _metrics({"as it is": plain, "clamped": clamped, "a lamp": n.lamp}),
        "clamp": f"{effort.clamp:g}",
        "lost": _percent(-clamped.against["bias"], clamped),
        "better": f"{plain.series[-1]['rmse'] / clamped.series[-1]['rmse']:.1f}",
        "worse": f"{(clamped.against['mse'] / plain.against['mse']) ** 0.5:.1f}",
        "runs": str(effort.runs),
        "band_size": f"{effort.band} × {effort.band}",
        "coverage": _coverage(n),
    }
    for name, run in (("plain", plain), ("clamped", clamped), ("lamp", n.lamp)):
        found = run.slope
        values |= {name: _fit(found), f"{name}_true": _fit(found["against"]), f"{name}_says": found["says"]}
        values[f"{name}_verdict"] = found["verdict"]
    return (Path(__file__).parent / "page.md").read_text().format(**values)


def _series(run: Run) -> str:
    """Every third point."""
    rows = []
    for one, worth in [*zip(run.series, run.worth, strict=True)][::3]:
        found = one["against"]
        assert found is not None
        errors = _percent(one["rmse"], run), _percent(found["mse"] ** 0.5, run)
        rows.append([f"{one['device_seconds']:.3g}", f"{one['samples']:.0f}", *errors, f"{worth * run.mean**2:.3g}"])
    return _table(["device seconds", "samples", "rmse", "√mse", "efficiency"], rows)


def _metrics(runs: dict[str, Run]) -> str:
    rows = []
    for name, run in runs.items():
        found, last = run.against, run.series[-1]
        assert found["bias_error"] is not None
        rows.append(
            [
                name,
                _percent(last["rmse"], run),
                _percent(found["mse"] ** 0.5, run),
                f"{last['rel_mse']:.2g}",
                f"{found['rel_mse']:.2g}",
                f"{found['smape']:.3f}",
                f"{100 * found['bias'] / run.mean:.2f} ± {100 * found['bias_error'] / run.mean:.2f} %",
                "–" if found["flip"] is None else f"{found['flip']:.3f}",
            ]
        )
    head = ["render", "rmse", "√mse", "relMSE by the samples", "relMSE", "SMAPE", "bias ± its error", "HDR-FLIP"]
    return _table(head, rows)


def _coverage(n: Numbers) -> str:
    rows = [
        [str(c.points), *(f"{100 * share:.0f} %" for share in (c.estimated, c.true, c.ordinary)), str(c.flagged)]
        for c in n.coverage
    ]
    return _table(["points", "estimated error", "true error", "an ordinary line", "flagged"], rows)


def _fit(found: Fit | Slope | None) -> str:
    """A slope with its band."""
    if found is None or found["slope"] is None:
        return "not known"
    return f"{found['slope']:.3f} [{found['low']:.3f}, {found['high']:.3f}]"


def _percent(value: float, run: Run) -> str:
    return f"{100 * value / run.mean:.3g} %"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows))
