"""The page of one render: what its report says, with the pictures that show it."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from woodcock.film import Film
from woodcock.pages import words
from woodcock.pages.chart import Chart, Curve, Dot, Fit
from woodcock.pages.document import document
from woodcock.pages.figure import Figure, figure
from woodcock.pages.flip_book import frames
from woodcock.pages.metrics import of_report
from woodcock.pages.svg import add, drawing, written
from woodcock.scene import Scene

if TYPE_CHECKING:
    from woodcock.reference import Reference

SIGNS = {"passed": "✓", "failed": "✗", "stated": "·", "not checked": "?"}
#: Pictures smaller than this, pixels, are magnified by pixels and not smoothed.
SMALL = 512


def report_page(report: dict[str, Any], scene: Scene, film: Film, reference: Reference | None, title: str) -> str:
    """One HTML text that fetches nothing. report: of `report.build`; reference: what the film was held against."""
    certificate = report["certificate"]["lines"]
    values = {
        "size": _size(report),
        "error": _error(report),
        "contract": report.get("contract"),
        "cautions": [line["says"] for line in certificate if line["status"] == "failed"],
        "frames": frames(film, reference),
        "pixels": max(film.width, film.height) < SMALL,
        "chart": _chart(report),
        "slope": (report.get("slope") or {}).get("says"),
        "metrics": list(of_report(report)),
        "split": _split(report["seconds"]),
        "utilisation": _utilisation(report),
        "program": _program(report),
        "certificate": [{**line, "sign": SIGNS[line["status"]]} for line in certificate],
        "provenance": _provenance(report, scene),
        "command": _command(report),
        "note": _note(scene, film),
        "scene": scene.model_dump_json(indent=2, exclude_none=True),
        "version": report["version"],
    }
    return document("report.html", title, **values)


def _samples(report: Mapping[str, Any]) -> str:
    mean = report.get("mean_samples")
    if mean is None or mean == report["samples"]:
        return f"{words.samples(report['samples'])} per pixel"
    return f"{words.samples(round(mean, 1))} per pixel on average, {words.count(report['samples'])} at most"


def _size(report: Mapping[str, Any]) -> str:
    seconds = words.duration(report["seconds"]["render"])
    return f"{report['width']} × {report['height']} pixels, {_samples(report)}, {seconds} of rendering"


def _error(report: Mapping[str, Any]) -> str:
    relative, rmse = report.get("relative_rmse"), report.get("rmse")
    if rmse is None:
        return "How far its pixels are off is not known: that takes two samples of each."
    size = f"{words.percent(relative)} of the mean luminance" if relative is not None else words.number(rmse)
    if report["deterministic"]:
        return f"It has no noise: a pixel is off by at most {size}, root mean square."
    return f"A pixel is off by {size}, root mean square, as its own samples tell."


# Error against time


def _chart(report: Mapping[str, Any]) -> Figure | None:
    points, mean = report["error"], report["mean_luminance"]
    if not points or not mean > 0:
        return None
    slope = report.get("slope") or {}
    goal = report.get("contract") or {}
    curves = [_curve("estimated", points, 0, mean, lambda point: point["rmse"], slope)]
    against = [point for point in points if (point.get("against") or {}).get("mse", 0) > 0]
    if against:
        true = _curve(
            "true", against, 1, mean, lambda point: point["against"]["mse"] ** 0.5, slope.get("against") or {}
        )
        curves.append(true)
    chart = Chart(
        curves,
        "rendering time of the devices",
        "error of a pixel, of the mean luminance",
        f"The estimated error fell from {curves[0].dots[0].says} to {curves[0].dots[-1].says}.",
        goal["asked"] if goal.get("kind") == "relative_error" else None,
    )
    head = ["seconds", "samples per pixel", "estimated error", *(["true error"] if against else [])]
    rows = [
        [
            words.number(_time(point)),
            words.number(point["samples"]),
            words.percent(point["rmse"] / mean),
            *([words.percent(point["against"]["mse"] ** 0.5 / mean)] if against else []),
        ]
        for point in (against or points)
    ]
    return figure(chart, head, rows)


def _time(point: Mapping[str, Any]) -> float:
    return float(point.get("device_seconds") or point["seconds"])


def _curve(name: str, points: Sequence[Any], look: int, mean: float, error: Any, fit: Mapping[str, Any]) -> Curve:
    dots = [
        Dot(
            _time(point),
            error(point) / mean,
            f"{words.percent(error(point) / mean)} after {words.duration(_time(point))}, "
            f"{words.samples(point['samples'])} per pixel",
        )
        for point in points
        if _time(point) > 0 and error(point) > 0
    ]
    known = None if fit.get("slope") is None else Fit(fit["slope"], fit["low"], fit["high"])
    return Curve(name, dots, look, known)


# Where the time went


def _split(seconds: Mapping[str, float]) -> dict[str, Any]:
    known = {name: spent for name, spent in seconds.items() if spent is not None and spent >= 0}
    total = sum(known.values())
    says = ", ".join(f"{name} {words.duration(spent)}" for name, spent in known.items())
    bar, at = drawing(1000, 14, f"Where the time went: {says}", "split"), 0.0
    bar.set("preserveAspectRatio", "none")
    parts = []
    for look, (name, spent) in enumerate(known.items()):
        share = spent / total if total > 0 else 0.0
        add(bar, "rect", x=at, y=0, width=1000 * share, height=14, css=f"look-{look % 8}")
        at += 1000 * share
        shown = f"{100 * share:.0f} %" if share >= 0.01 else "< 1 %"
        parts.append({"name": name, "value": words.duration(spent), "share": shown, "look": look % 8})
    return {"bar": written(bar), "parts": parts}


def _utilisation(report: Mapping[str, Any]) -> str | None:
    if (share := report.get("utilisation")) is None:
        return None
    devices = "The device was" if len(report["devices"]) == 1 else f"The {len(report['devices'])} devices were"
    return f"{devices} busy for {words.percent(share)} of the rendering."


# What was compiled


def _program(report: Mapping[str, Any]) -> dict[str, Any] | None:
    if (program := report.get("program")) is None:
        return None
    sizes = [
        ("text", f"{words.count(program['source_lines'])} lines of code, {words.count(program['bytes'])} bytes"),
        ("built", None if program["binary_bytes"] is None else f"{words.count(program['binary_bytes'])} bytes"),
        (
            "private",
            None
            if program["private_bytes"] is None
            else f"{words.count(program['private_bytes'])} bytes of a work item",
        ),
        ("registers", None if program["registers"] is None else f"{program['registers']} of a work item"),
    ]
    left_out = sum(program["left_out"].values())
    share = left_out / max(left_out + program["source_lines"], 1)
    sizes.append(("left out", f"{words.count(left_out)} lines, {words.percent(share)} of the renderer’s device code"))
    if gain := report.get("gain"):
        known = f"{words.number(gain['low'])} to {words.number(gain['high'])}"
        sizes.append(
            ("gain", f"{words.number(gain['ratio'])} × as fast as with everything in it (95 % interval {known})")
        )
    names = {
        key: [f"{file} {words.count(lines)}" for file, lines in program[key].items()]
        for key in ("remained", "left_out")
    }
    return {"facts": [(name, text) for name, text in sizes if text is not None], **names}


# How to make it again


def _provenance(report: Mapping[str, Any], scene: Scene) -> list[tuple[str, str | Markup]]:
    ranges = ", ".join(f"{start} to {stop - 1}" for start, stop in report["sample_ranges"])
    kinds = "; ".join(f"{concept}: {', '.join(names) or 'none'}" for concept, names in report["kinds"].items())
    facts: list[tuple[str, str | Markup]] = [
        ("seed", str(scene.seed)),
        ("samples", ranges or "none"),
        ("program", Markup("<code>{}</code>").format(report["program_hash"])),
        ("kinds", kinds),
    ]
    for use in report["devices"]:
        precise = ", in double precision" if use["precision"] == "double" else ""
        lanes = f"{use['lanes']} paths in lockstep{precise}"
        facts.append(("device", f"{use['name']} ({use['id']}), {lanes}; {use['platform']}, {use['driver']}"))
    if reference := report.get("reference"):
        facts.append(("reference", reference))
    return [*facts, ("version", report["version"])]


def _command(report: Mapping[str, Any]) -> str:
    devices = {use["id"] for use in report["devices"]}
    chosen = f" --device {shlex.quote(min(devices))}" if len(devices) == 1 else ""
    return f"woodcock render scene.json -o picture.exr{chosen}"


def _note(scene: Scene, film: Film) -> str | None:
    """What else it takes; contracts of samples and of an error render the same samples anywhere."""
    if scene.stop.kind != "seconds":
        return None
    stop = f'"stop": {{"kind": "samples", "samples": {film.samples}}}'
    return f"How many samples fit into the time depends on the machine; with {stop} it is this picture again."
