"""What a comparison found: benchmarks.json, benchmarks.md and a figure of error against time for every scene."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tests.benchmarks.peers.judge import Shot, efficiency, geometric_mean, mse, rows
from tests.benchmarks.peers.run import Shots
from tests.benchmarks.peers.scenes import Case

Record = dict[str, Any]


def record(case: Case, made: Sequence[Shots], error: float | None = None) -> Record:
    """Numbers of a scene, ours first. error: of Woodcock's picture, relative, where it has no noise."""
    shot = {shots.adapter.peer: Shot(np.array(shots.images), shots.seconds) for shots in made if not shots.skipped}
    ours, *others = shot
    judged = rows(shot[ours].images, shot[ours], {name: shot[name] for name in others})
    return {
        "scene": case.name,
        "says": case.says,
        "mean": float(shot[ours].images.mean()),
        "error": error,
        "renderers": [_renderer(shots, judged.get(shots.adapter.peer, {})) for shots in made],
    }


def _renderer(shots: Shots, judged: Mapping[str, Any]) -> Record:
    said = {"peer": shots.adapter.peer, "skipped": shots.skipped, "failed": shots.failed, **shots.described}
    if shots.skipped:
        return said
    parts = [(samples, *part) for samples, part in shots.parts.items()]
    taken = [*parts, (shots.samples, shots.images, shots.seconds)]
    series = [
        {"samples": samples, "seconds": float(np.mean(seconds)), "rmse": mse(np.array(images)) ** 0.5}
        for samples, images, seconds in taken
    ]
    return said | {
        "samples": shots.samples,
        "rounds": len(shots.images),
        "seconds": series[-1]["seconds"],
        "rmse": series[-1]["rmse"],
        "efficiency": efficiency(Shot(np.array(shots.images), shots.seconds)),
        "series": series,
        **{name: judged.get(name) for name in ("ratio", "differs", "bias", "bias_error")},
    }


def ratios(records: Sequence[Record]) -> dict[str, dict[str, float]]:
    """Woodcock's efficiency over its own, by peer and scene."""
    found: dict[str, dict[str, float]] = {}
    for each in records:
        for row in each["renderers"]:
            if row.get("ratio"):
                found.setdefault(row["peer"], {})[each["scene"]] = row["ratio"]["value"]
    return found


def write(folder: Path, records: Sequence[Record]) -> None:
    """All files, into a folder that is made."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "benchmarks.json").write_text(json.dumps(records, indent=1, default=float) + "\n")
    for each in records:
        figure(folder / f"{each['scene']}.svg", each)
    (folder / "benchmarks.md").write_text(text(records))


def text(records: Sequence[Record]) -> str:
    lines = ["# Woodcock and its peers", ""]
    ours = records[0]["renderers"][0]
    lines += [f"On {ours['device']} ({ours['driver']}). Efficiency is 1 / (mean square error × seconds of rendering);"]
    lines += ["a ratio is Woodcock's over the peer's, with its 95 % interval, where both show the same picture.", ""]
    for each in records:
        lines += [f"## {each['scene']}", "", f"{each['says'].capitalize()}.", "", f"![error]({each['scene']}.svg)", ""]
        lines += [
            "| renderer | ratio | efficiency | samples | seconds | error | bias |",
            "|---|--:|--:|--:|--:|--:|--:|",
        ]
        lines += [_line(row, each) for row in each["renderers"]] + [""]
    lines += ["## Geometric means", ""]
    for peer, scenes in ratios(records).items():
        lines += [f"- {peer}: {geometric_mean(list(scenes.values())):.3g} over {len(scenes)} scenes"]
    lines += ["", "## Settings", ""]
    for peer, version, settings in _settings(records):
        lines += [f"- {peer} {version}: {settings}"]
    return "\n".join(lines) + "\n"


def _line(row: Record, each: Record) -> str:
    if row["skipped"]:
        return f"| {row['peer']} | {row['skipped']} | | | | | |"
    exact = each["error"] is not None
    ratio, ours = row["ratio"], row is each["renderers"][0]
    if row["differs"]:
        said = row["differs"]
    elif ratio:
        interval = "" if ratio["low"] is None else f" ({ratio['low']:.3g} to {ratio['high']:.3g})"
        said = f"**{ratio['value']:.3g}**{interval}"
    else:
        said = "" if ours and not exact else "no noise" if ours else "Woodcock has no noise"
    error = each["error"] if ours and exact else row["rmse"] / each["mean"]
    bias = "" if row["bias"] is None else f"{row['bias']:+.2%} ± {row['bias_error']:.2%}"
    known = "" if row["efficiency"] is None else f"{row['efficiency']:.3g}"
    numbers = f"{known} | {row['samples']} | {row['seconds']:.3g} | {_error(error)} | {bias}"
    return f"| {row['peer']} | {said} | {numbers} |"


def _error(relative: float) -> str:
    return f"{relative:.2%}" if relative > 1e-4 else f"{relative:.1e}"


def _settings(records: Sequence[Record]) -> list[tuple[str, str, str]]:
    """Each that was used, once."""
    rows = (row for each in records for row in each["renderers"] if not row["skipped"])
    return sorted({(row["peer"], row["version"], row["settings"]) for row in rows})


def figure(path: Path, each: Record) -> None:
    """Error of an image, relative to the picture's mean, against seconds of rendering."""
    from matplotlib.figure import Figure

    drawn = Figure(figsize=(6, 4), layout="constrained")
    axes = drawn.add_subplot()
    for row in each["renderers"]:
        if row["skipped"]:
            continue
        exact = each["error"] is not None and row is each["renderers"][0]
        points = [(row["seconds"], each["error"])] if exact else []
        points = points or [(one["seconds"], one["rmse"] / each["mean"]) for one in row["series"]]
        axes.plot(*zip(*sorted(points), strict=True), marker="o", label=row["peer"])
    axes.set(xscale="log", yscale="log", xlabel="seconds of rendering", ylabel="error of an image, of its mean")
    axes.set_title(each["scene"])
    axes.grid(alpha=0.3, which="both")
    axes.legend()
    drawn.savefig(path)
