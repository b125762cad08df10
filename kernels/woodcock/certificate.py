"""The certificate of a picture: what is known of its error, line by line, and on which evidence.

A line passed or failed by a test of its own, states what cannot fail, or was not checked: missing evidence never reads
"passed".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

import numpy as np

from woodcock.batches import TILE, tiles
from woodcock.contract import Contract
from woodcock.convergence import Slope
from woodcock.film import Film, weights

if TYPE_CHECKING:
    from woodcock.report import Use

Status = Literal["passed", "failed", "stated", "not checked"]

#: From the best to the worst.
ORDER: tuple[Status, ...] = ("passed", "stated", "not checked", "failed")

#: A line fails at a deviation that chance brings once in 3.5 million times.
STANDARD_ERRORS = 5.0

#: What rounding may move the mean by, relative to it.
MOST_DRIFT = 1e-5


class Line(TypedDict):
    name: str
    status: Status
    says: str
    values: dict[str, Any]


class Certificate(TypedDict):
    """failed, not_checked: names of the lines that read so."""

    failed: list[str]
    not_checked: list[str]
    lines: list[Line]


def certify(
    film: Film, uses: Sequence[Use], orders: dict[str, Any] | None, slope: Slope, contract: Contract
) -> Certificate:
    """uses: of the devices that rendered the film; orders: what the report says of the series, if the scene asks;
    slope, contract: as the report has them.
    """
    lines = [
        _bound(film) if film.deterministic else _standard_error(film),
        _worst_tile(film),
        _convergence(film, slope),
        _contract(contract),
        _samples(film),
        _majorant(film, uses),
        _series(film, orders),
        _rounding(film, uses),
        _build(uses),
        *_laws(uses),
    ]
    failed, not_checked = ([line["name"] for line in lines if line["status"] == each] for each in ORDER[:1:-1])
    return {"failed": failed, "not_checked": not_checked, "lines": lines}


def _line(name: str, status: Status, says: str, **values: Any) -> Line:
    finite = {key: None if isinstance(v, float) and not math.isfinite(v) else v for key, v in values.items()}
    return {"name": name, "status": status, "says": says, "values": finite}


# The error of the picture


def _standard_error(film: Film) -> Line:
    """The launches' means against the pixels' variances: both are right only if samples, pixels and launches are
    independent. (count - 1) × the ratio's square is χ² then, made normal by its cube root (Wilson & Hilferty 1931).

    They are compared as they would be with one sample of every pixel, for pixels may have had more than launches."""
    batches, mean = film.batches, film.mean_luminance()
    launches, pixels, by_variances = batches.deviation(), film.mean_luminance_deviation(), film.mean_luminance_error()
    by_batches = launches * (by_variances / pixels if pixels > 0 else film.mean_samples**-0.5)
    values = {
        "launches": batches.count,
        "mean_luminance": mean,
        "by_launches": by_batches,
        "by_variances": by_variances,
        "relative": by_batches / mean if mean > 0 else math.nan,
    }
    name = "standard error"
    if not (math.isfinite(by_batches) and math.isfinite(by_variances)):
        return _line(name, "not checked", "It takes two launches to know how much they differ.", **values)
    freedom = 2 / (9 * (batches.count - 1))
    square = (by_batches / by_variances) ** 2 if by_variances > 0 else (math.inf if by_batches > 0 else 1.0)
    score = (math.cbrt(square) - (1 - freedom)) / math.sqrt(freedom) if math.isfinite(square) else math.inf
    said = f"The mean luminance is known to {_share(by_batches, mean)} by how {batches.count} launches differ"
    if score > STANDARD_ERRORS:
        why = "samples are not independent, or a few outweigh the rest"
        text = f"{said}, but to {_share(by_variances, mean)} by the pixels' variances: {why}."
        return _line(name, "failed", text, score=score, **values)
    return _line(
        name, "passed", f"{said}; by the pixels' variances, to {_share(by_variances, mean)}.", score=score, **values
    )


def _bound(film: Film) -> Line:
    assert film.bound is not None
    largest, mean = float(film.bound.max()), film.mean_luminance()
    if not math.isfinite(largest):
        return _line("bound", "failed", "There is no bound on the error of some pixels.", largest=largest)
    text = f"No radiance that was sampled is off by more than {_share(largest, mean)} of the mean luminance."
    return _line("bound", "stated", text, largest=largest, mean_luminance=mean)


def _worst_tile(film: Film) -> Line:
    """The tile with the largest RMS of its pixels' standard errors, or bounds."""
    name = "worst tile"
    squares = film.layer("").variance() if film.bound is None else film.bound**2
    errors = np.sqrt(tiles(squares @ weights(film.channels)))
    if not np.isfinite(errors).all():
        return _line(name, "not checked", "It takes two samples of a pixel to know its error.")
    row, column = np.unravel_index(int(np.argmax(errors)), errors.shape)
    x, y, error, mean = int(column) * TILE, int(row) * TILE, float(errors.max()), film.mean_luminance()
    width, height = min(TILE, film.width - x), min(TILE, film.height - y)
    kind = "standard error" if film.bound is None else "bound"
    where = f"the {width} × {height} pixels from ({x}, {y})"
    text = f"A pixel's {kind} is largest in {where}: {_share(error, mean)} of the mean luminance."
    relative = error / mean if mean > 0 else math.nan
    return _line(name, "stated", text, x=x, y=y, width=width, height=height, rmse=error, relative_rmse=relative)


def _convergence(film: Film, slope: Slope) -> Line:
    """Does the error fall as that of independent samples with a variance, and has it no more than they tell?"""
    if film.deterministic:
        return _line("convergence", "stated", "Without noise there is one error: nothing falls.")
    statuses: dict[str, Status] = {"as expected": "passed", "flagged": "failed", "not known": "not checked"}
    values = {key: slope[key] for key in ("slope", "low", "high", "expected", "points")}
    return _line("convergence", statuses[slope["verdict"]], slope["says"], **values)


def _contract(contract: Contract) -> Line:
    """Was rendered what the scene asks for?"""
    status: Status = "not checked" if contract["reached"] is None else "passed" if contract["met"] else "failed"
    values = {key: contract[key] for key in ("kind", "asked", "reached")}
    return _line("contract", status, contract["says"], **values)


# What may have gone wrong


def _samples(film: Film) -> Line:
    found = film.faults
    counts = {
        "rejected": found.rejected,
        "nan": found.nan,
        "infinite": found.infinite,
        "negative": found.negative,
        "unfinished": found.unfinished,
        "clamped": 0,  # there is no clamp
    }
    if not found.rejected:
        return _line("samples", "passed", "Every sample was a finite radiance; none was rejected or clamped.", **counts)
    parts = [f"{counts[kind]} {kind}" for kind in ("nan", "infinite", "negative", "unfinished") if counts[kind]]
    total = int(film.count.sum(dtype=np.uint64))
    text = f"{found.rejected} of {total} samples count as 0: {', '.join(parts)}."
    return _line("samples", "failed", text, **counts)


def _majorant(film: Film, uses: Sequence[Use]) -> Line:
    found, name = film.faults, "majorant"
    if not any("majorant" in use["kinds"] for use in uses):
        return _line(name, "stated", "Nothing is tracked under a majorant.")
    paths = max(int(film.count.sum(dtype=np.uint64)), 1)
    values = {
        "violations": found.violations,
        "weight": found.touched / paths,
        "repaired": found.repaired,
    }
    if found.violations:
        text = (
            f"σ_t exceeded its majorant {found.violations} times, in paths with {values['weight']:.2g} of all weight."
        )
        return _line(name, "failed", text, **values)
    text = "σ_t never exceeded its majorant."
    if found.repaired:
        text = (
            f"σ_t exceeded its majorant {found.repaired} times; it was raised, and those samples were rendered again."
        )
    return _line(name, "passed", text, **values)


def _series(film: Film, orders: dict[str, Any] | None) -> Line:
    name = "series"
    if film.deterministic:
        return _line(name, "stated", "Nothing scatters: the series ends with its first term.", truncation=0.0)
    text = "The series is not cut: paths end by roulette, which keeps the mean."
    if orders is None:
        return _line(name, "stated", text, truncation=0.0)
    mean = film.mean_luminance()
    text += f" Orders beyond {orders['last']} hold {_share(orders['rest'], mean)} of the mean luminance"
    if orders["rest_bound"] is not None:
        text += f", and at most {_share(orders['rest_bound'], mean)}"
    return _line(name, "stated", f"{text}.", truncation=0.0, **orders)


def _rounding(film: Film, uses: Sequence[Use]) -> Line:
    name = "rounding"
    if film.deterministic:
        widths = " and ".join(sorted({use["precision"] for use in uses}))
        return _line(name, "stated", f"Computed in {widths} precision; the bound holds its rounding.")
    evidence = [use.get("evidence") for use in uses]
    drifts = [one["drift"] for one in evidence if one and one["drift"]]
    if len(drifts) < len(uses):
        return _line(name, "not checked", "The paths were not compared with ones in double precision.")
    worst = max(drifts, key=lambda drift: abs(drift["relative"]))
    off = abs(worst["relative"]) > MOST_DRIFT + STANDARD_ERRORS * worst["error"]
    text = (
        f"Float32 moves the mean by {worst['relative']:.1e} ± {worst['error']:.1e} of it, "
        f"by {worst['paths']} paths traced in double precision too."
    )
    return _line(name, "failed" if off else "passed", text, **worst)


# By what it was made


def _build(uses: Sequence[Use]) -> Line:
    evidence = [one for use in uses if (one := use.get("evidence"))]
    values = {
        "program_hash": sorted({use["program_hash"] for use in uses}),
        "devices": [use["name"] for use in uses],
        "drivers": [use["driver"] for use in uses],
        "precision": sorted({use["precision"] for use in uses}),
    }
    if len(evidence) < len(uses):
        return _line("build", "not checked", "A device did not say how its program was built.", **values)
    options = sorted({option for one in evidence for option in one["options"]})
    relaxed = [option for option in options if "math" in option or "denorm" in option or "mad" in option]
    mode = "relaxed" if relaxed else "certified"
    text = (
        f"Built with {' '.join(relaxed)}, which trade accuracy."
        if relaxed
        else "Built without flags that trade accuracy."
    )
    others = sum(n for use in uses for name, n in use.get("programs", {}).items() if name != use["program_hash"])
    if others:
        text += f" While it was being built, the generic program rendered {others:.6g} samples per pixel."
    return _line("build", "stated", text, mode=mode, options=options, generic_samples=others, **values)


def _laws(uses: Sequence[Use]) -> list[Line]:
    """A line a law, by the device that keeps it worst."""
    evidence = [use.get("evidence") for use in uses]
    if not all(evidence):
        return [_line("laws", "not checked", "The program was not asked to keep the laws that it must.")]
    found: dict[str, Line] = {}
    for use, one in zip(uses, evidence, strict=True):
        for check in one["checks"] if one else ():
            values = {key: check[key] for key in ("deviation", "unit", "limit")} | {"device": use["id"]}
            text = check["law"] if check["status"] == "passed" else f"{check['law']} {_sentence(check['reason'])}"
            line = _line(check["name"], check["status"], text, **values)
            before = found.get(check["name"])
            if before is None or ORDER.index(line["status"]) > ORDER.index(before["status"]):
                found[check["name"]] = line
    return list(found.values())


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def _share(value: float, mean: float) -> str:
    return f"{100 * value / mean:.2g} %" if mean > 0 else f"{value:.2g}"
