"""The page of a comparison: who wins and by how much, error against time, the pictures at equal time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from woodcock import __version__
from woodcock.compare.judge import Row, Verdict, twins
from woodcock.film import Film, weights
from woodcock.image import white_of
from woodcock.pages import words
from woodcock.pages.chart import Chart, Curve, Dot
from woodcock.pages.document import document
from woodcock.pages.figure import Figure, figure, swatch
from woodcock.pages.flip_book import Frame, coloured_frame, radiance_frame
from woodcock.pages.intervals import Group, Span, draw
from woodcock.pages.pictures import decades
from woodcock.pages.svg import written
from woodcock.scene import Scene

#: Longest side of a picture, pixels: there may be many.
LARGEST = 640
#: Pictures smaller than this are magnified by pixels and not smoothed.
SMALL = 512


def page(
    title: str,
    rows: Sequence[Row],
    verdict: Verdict,
    films: Mapping[str, Film],
    scene: Scene,
    measured: Sequence[tuple[str, str]],
    same: Mapping[str, str],
) -> str:
    """One HTML text that fetches nothing. films: by label, of equal size, as many as there are to show; measured: how,
    as names and texts; same: variants that were left out, each with the one it is the same program as.
    """
    by_label = {row["label"]: row for row in rows}
    ranked = [by_label[label] for label in verdict["order"]]
    looks = {row["label"]: index for index, row in enumerate(rows)}
    values = {
        "verdict": verdict,
        "rows": [_cells(row, verdict, looks[row["label"]]) for row in ranked],
        "reference": any(row["against"] for row in rows),
        "chart": _chart(ranked, looks),
        "spans": _spans(ranked, verdict, looks),
        "frames": _frames(ranked, films),
        "errors": _errors(ranked, films),
        "pixels": max(scene.film.width, scene.film.height) < SMALL,
        "measured": measured,
        "twins": twins(same),
        "size": f"{scene.film.width} × {scene.film.height} pixels, {len(rows)} variants",
        "scene": scene.model_dump_json(indent=2, exclude_none=True),
        "version": __version__,
    }
    return document("compare.html", title, **values)


def mean_of(row: Row) -> float:
    return row["means"][0].value


def standing(row: Row, verdict: Verdict) -> str:
    """In a word or two: what the verdict says of a row."""
    if row["label"] in verdict["disagree"]:
        return "another picture"
    if row["label"] == verdict["winner"]:
        return "winner"
    return "may be the best" if row["label"] in verdict["draw"] else ""


def efficiency_text(row: Row) -> str:
    if row["deterministic"]:
        return "no noise"
    return "not known" if row["efficiency"] is None else words.number(row["efficiency"])


def ratio_text(row: Row, verdict: Verdict) -> tuple[str, str]:
    """The ratio to the worst, and its interval."""
    ratio = verdict["ratios"].get(row["label"])
    if ratio is None:
        return "", ""
    low, high = ratio["low"], ratio["high"]
    unknown = low is None or high is None or row["label"] == verdict["worst"]
    interval = "" if unknown else f"{words.number(low or 0.0)} to {words.number(high or 0.0)}"
    return f"{words.number(ratio['value'])} ×", interval


def error_text(row: Row) -> str:
    if row["rmse"] is None:
        return "not known"
    relative = words.percent(row["rmse"] / mean_of(row)) if mean_of(row) > 0 else words.number(row["rmse"])
    return f"≤ {relative}" if row["deterministic"] else relative


def _cells(row: Row, verdict: Verdict, look: int) -> dict[str, Any]:
    ratio, interval = ratio_text(row, verdict)
    against, mean = row["against"], row["means"][0]
    return {
        "swatch": swatch(look),
        "label": row["label"],
        "default": row["default"],
        "standing": standing(row, verdict),
        "wins": row["label"] == verdict["winner"],
        "differs": row["label"] in verdict["disagree"],
        "ratio": ratio,
        "interval": interval,
        "efficiency": efficiency_text(row),
        "error": error_text(row),
        "samples": words.count(row["samples"]),
        "seconds": words.duration(row["seconds"]),
        "build": words.duration(row["build_seconds"]),
        "mean": f"{words.number(mean.value, 5)} ± {words.number(math.hypot(mean.error, mean.bound), 2)}",
        "true": None if against is None else words.number(against["mse"]),
        "bias": None if against is None else bias_text(against),
    }


def bias_text(against: Mapping[str, Any]) -> str:
    """With its standard error."""
    error = against["bias_error"]
    return words.number(against["bias"], 2) + ("" if error is None else f" ± {words.number(error, 2)}")


def _chart(ranked: Sequence[Row], looks: Mapping[str, int]) -> Figure | None:
    curves, table = [], []
    for row in ranked:
        mean = mean_of(row)
        dots = [
            Dot(
                point["device_seconds"],
                point["rmse"] / mean,
                f"{row['label']}: {words.percent(point['rmse'] / mean)} after "
                f"{words.duration(point['device_seconds'])}, {words.samples(point['samples'])} per pixel",
            )
            for point in row["series"]
            if point["rmse"] > 0 and mean > 0
        ]
        curves.append(Curve(row["label"], dots, looks[row["label"]]))
        table += [
            [row["label"], words.number(dot.x), words.number(point["samples"]), words.percent(dot.y)]
            for dot, point in zip(dots, row["series"], strict=False)
        ]
    names = ", ".join(row["label"] for row in ranked)
    says = f"The estimated error against time of {len(ranked)} variants, from the best to the worst: {names}."
    chart = Chart(curves, "rendering time", "estimated error of a pixel, of the mean luminance", says)
    return figure(chart, ["variant", "seconds", "samples per pixel", "estimated error"], table)


def spans(ranked: Sequence[Row], verdict: Verdict, looks: Mapping[str, int]) -> list[Span]:
    """The rows whose ratio is known, for a figure."""
    found = []
    for row in ranked:
        if ratio := verdict["ratios"].get(row["label"]):
            low, high = (None, None) if row["label"] == verdict["worst"] else (ratio["low"], ratio["high"])
            doubted = row["label"] in verdict["disagree"]
            found.append(Span(row["label"], ratio["value"], low, high, looks[row["label"]], doubted))
    return found


def _spans(ranked: Sequence[Row], verdict: Verdict, looks: Mapping[str, int]) -> Figure | None:
    if not (found := spans(ranked, verdict, looks)):
        return None
    x_name = "efficiency, over that of the worst"
    says = "Efficiencies: " + "; ".join(f"{span.name} {words.number(span.value)} times" for span in found)
    wide, narrow = (draw([Group("", found)], x_name, says, narrow) for narrow in (False, True))
    return Figure(written(wide), written(narrow), [], [], [])


def _frames(ranked: Sequence[Row], films: Mapping[str, Film]) -> list[Frame]:
    """The pictures at one exposure, that of the first."""
    shown = [row for row in ranked if row["label"] in films]
    if not shown:
        return []
    white = white_of(films[shown[0]["label"]].layer("").mean)
    return [
        radiance_frame(
            row["label"],
            f"{words.samples(row['samples'])} per pixel in {words.duration(row['seconds'])}, error {error_text(row)}.",
            films[row["label"]].layer("").mean,
            white,
            LARGEST,
        )
        for row in shown
    ]


def _errors(ranked: Sequence[Row], films: Mapping[str, Film]) -> list[Frame]:
    """The standard errors, of one scale for all."""
    squares = {}
    for row in ranked:
        film = films.get(row["label"])
        if film is not None and not film.deterministic and np.isfinite(variance := film.layer("").variance()).all():
            squares[row["label"]] = variance @ weights(film.channels)
    if not squares:
        return []
    scale = decades(np.sqrt(np.concatenate([each.ravel() for each in squares.values()])), "radiance")
    mean = mean_of(ranked[0])
    return [
        coloured_frame(label, "Standard error of each pixel’s mean.", each, scale, mean, root=True, largest=LARGEST)
        for label, each in squares.items()
    ]
