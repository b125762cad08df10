"""Who wins: the rows of a comparison, and the verdict on them. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

from woodcock.compare.agreement import Mean, disagreeing, means
from woodcock.compare.efficiency import Ratio, Slice, efficiency, ratio
from woodcock.film import Film


class Row(TypedDict):
    """A variant's result. seconds: of rendering; build_seconds: of read, build and upload, which do not count.

    samples: per pixel; rmse: estimated, of a pixel; without noise the RMS of its bound. efficiency: None without noise,
    or where it is not known. means: of the whole picture and of its parts. default: is it what the program chooses for
    the scene as it stands? against: the reference, if there is one. series: points of error against time.
    """

    label: str
    choices: dict[str, str]
    default: bool
    seconds: float
    build_seconds: float
    samples: float
    rmse: float | None
    deterministic: bool
    efficiency: float | None
    slices: list[Slice]
    means: list[Mean]
    against: Mapping[str, Any] | None
    series: list[Mapping[str, Any]]


def row(
    label: str,
    choices: Mapping[str, str],
    film: Film,
    slices: Sequence[Slice],
    series: Sequence[Mapping[str, Any]],
    *,
    build_seconds: float,
    default: bool = False,
    against: Mapping[str, Any] | None = None,
) -> Row:
    """Of a film that was rendered in those slices; `efficiency.of_series` makes slices of a series that has none."""
    rmse = film.rmse()
    return {
        "label": label,
        "choices": dict(choices),
        "default": default,
        "seconds": sum(each.seconds for each in slices),
        "build_seconds": build_seconds,
        "samples": film.mean_samples,
        "rmse": rmse if math.isfinite(rmse) else None,
        "deterministic": film.deterministic,
        "efficiency": None if film.deterministic else efficiency(slices),
        "slices": list(slices),
        "means": means(film),
        "against": against,
        "series": list(series),
    }


class Verdict(TypedDict):
    """winner: its label; None where nobody wins. draw: labels of those that may each be the best, two or more, where
    there is no winner. disagree: labels of those whose picture is not the others', or not the reference's.

    order: all labels, best first. ratios: efficiency over that of `worst`, by label. runner_up, lead: whom the winner
    beats, and by which ratio. says: all of it in a sentence or two.
    """

    winner: str | None
    draw: list[str]
    disagree: list[str]
    order: list[str]
    worst: str | None
    ratios: dict[str, Ratio]
    runner_up: str | None
    lead: Ratio | None
    says: str


def winner(rows: Sequence[Row], truth: Sequence[Mean] | None = None) -> Verdict:
    """The verdict. truth: means of a reference whose own error is known.

    A row without noise wins over all with noise. Else a winner is more efficient than every other with 95 % confidence,
    of each pair. Whoever disagrees cannot win.
    """
    doubted = disagreeing([row["means"] for row in rows], truth)
    sound = [row for index, row in enumerate(rows) if index not in doubted]
    exact = [row for row in sound if row["deterministic"]]
    racing = sorted((row for row in sound if row["efficiency"]), key=lambda row: -(row["efficiency"] or 0))
    ranked = [row["label"] for row in [*exact, *racing]]
    worst = racing[-1] if racing else None
    ratios = {
        row["label"]: found for row in rows if worst and (found := ratio(row["slices"], worst["slices"])) is not None
    }
    best, lead = (exact, None) if exact else _best(racing)
    runner_up = next((row for row in racing if row is not best[0]), None) if len(best) == 1 else None
    verdict: Verdict = {
        "winner": best[0]["label"] if len(best) == 1 else None,
        "draw": [row["label"] for row in best] if len(best) > 1 else [],
        "disagree": [rows[index]["label"] for index in doubted],
        "order": [*ranked, *(row["label"] for row in rows if row["label"] not in ranked)],
        "worst": worst["label"] if worst else None,
        "ratios": ratios,
        "runner_up": runner_up["label"] if runner_up else None,
        "lead": lead,
        "says": "",
    }
    verdict["says"] = _sentence(verdict, without_noise=bool(exact), known=truth is not None)
    return verdict


def _best(racing: Sequence[Row]) -> tuple[list[Row], Ratio | None]:
    """Those that no other is surely better than, of rows by falling efficiency; and the lead over the second."""
    if not racing:
        return [], None
    first, *others = racing
    leads = [(row, ratio(first["slices"], row["slices"])) for row in others]
    best = [first, *(row for row, lead in leads if lead is None or lead["low"] is None or lead["low"] <= 1)]
    return best, leads[0][1] if leads and len(best) == 1 else None


def _sentence(verdict: Verdict, without_noise: bool, known: bool) -> str:
    if len(verdict["disagree"]) == len(verdict["order"]):
        why = "none of the pictures is the reference's" if known else "no more than half of the pictures are the same"
        return f"No winner: {why}."
    parts = []
    if verdict["winner"] and without_noise:
        parts.append(f"“{verdict['winner']}” wins: it has no noise, and a bound on its error.")
    elif verdict["winner"] and (lead := verdict["lead"]):
        interval = f" (95 % interval {lead['low']:.3g} to {lead['high']:.3g})" if lead["low"] and lead["high"] else ""
        parts.append(
            f"“{verdict['winner']}” wins: {lead['value']:.3g} times as efficient as “{verdict['runner_up']}”, "
            f"the next best{interval}."
        )
    elif verdict["winner"]:
        parts.append(f"“{verdict['winner']}” is the only one left to win.")
    elif verdict["draw"]:
        why = "none has noise" if without_noise else "their efficiencies cannot be told apart with 95 % confidence"
        parts.append(f"A draw between {_list([f'“{label}”' for label in verdict['draw']])}: {why}.")
    else:
        parts.append("No winner: no variant has two samples a pixel to know its error by.")
    if verdict["disagree"]:
        whose = "the reference's" if known else "the others'"
        doubted = _list([f"“{label}”" for label in verdict["disagree"]])
        parts.append(f"Not believed, because the picture is not {whose}: {doubted}.")
    return " ".join(parts)


def _list(labels: Sequence[str]) -> str:
    return labels[0] if len(labels) == 1 else f"{', '.join(labels[:-1])} and {labels[-1]}"


def twins(same: Mapping[str, str]) -> dict[str, list[str]]:
    """By the label that was rendered, those that were left out because they are the same program."""
    return {label: [each for each, other in same.items() if other == label] for label in dict.fromkeys(same.values())}
