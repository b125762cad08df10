"""Which estimators win on the project's own scenes: writes estimators.md and estimators.svg beside this file.

python -m studies.estimators [--seconds 10] [--data folder] [--out folder]
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from woodcock.compare import CompareError, Ratio, Row, Verdict, kinds, ratio, variants, winner
from woodcock.compare.page import error_text, standing
from woodcock.compare.run import Outcome, run
from woodcock.device import Device, DeviceError, find
from woodcock.pages import words
from woodcock.pages.document import figure_style
from woodcock.pages.intervals import Group, Span, draw
from woodcock.pages.svg import file
from woodcock.scene import Scene, files, load

EXAMPLES = Path(__file__).parents[2] / "client" / "woodcock_client" / "examples"
#: What varies, in the order of the labels.
VARY = {field: list(kinds(field)) for field in ("free_flight", "transmittance", "majorant")}
LABELS = [", ".join(choices) for choices in product(*VARY.values())]
#: Longest side of the pictures, pixels: noise per sample hardly depends on it, and small ones give more turns.
SIZE = 192

PAGE = """# Which estimator wins

Written by `make studies`, on {device}: every variant of a scene
rendered for {seconds} s, in turns, {size} pixels on the longest side. Efficiency is 1 / (variance × time); a ratio
comes with its 95 % interval, and a winner is above every other with that confidence. `woodcock compare` does the same
for any scene.

![Efficiencies, scene by scene](estimators.svg)

## The program's choices

{defaults}

Where a scene leaves `free_flight`, `transmittance` and `majorant` out, as all of these do, the program chooses: delta
and ratio tracking, and the majorant by which paths should take fewer steps.

{winners}

## One choice alone

Geometric means of the ratio of efficiencies, over all scenes and all other choices, where that choice makes another
program.

{choices}

## Every variant

Geometric mean over the scenes of the efficiency over that of the program's choice.

{variants}

{scenes}
"""


@dataclass(frozen=True)
class Found:
    """A scene's outcome. `at` gives the row of any label, of its twin where it compiles to the same program."""

    name: str
    outcome: Outcome
    verdict: Verdict

    def at(self, label: str) -> Row | None:
        rows = {row["label"]: row for row in self.outcome.rows}
        return rows.get(self.outcome.same.get(label, label))

    @property
    def default(self) -> Row | None:
        """What the program chooses."""
        return next((row for row in self.outcome.rows if row["default"]), None)

    def believed(self, row: Row) -> bool:
        return row["label"] not in self.verdict["disagree"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0, help="rendering time of every variant")
    parser.add_argument("--data", type=Path, help="folder with the files of the larger examples")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder of the page and its figure")
    given = parser.parse_args()
    device = find()
    found, nothing = measure(scenes(given.data), device, given.seconds, lambda line: print(line, flush=True))
    (given.out / "estimators.svg").write_text(figure(found))
    (given.out / "estimators.md").write_text(page(found, nothing, device, given.seconds))


def scenes(data: Path | None) -> Iterator[tuple[str, Scene]]:
    """The examples, small; those of the folder `data` as far as their files lie there."""
    for path in sorted(EXAMPLES.glob("*.json")):
        yield path.stem, small(load(path))
    for path in sorted((EXAMPLES / "data").glob("*.json")) if data else ():
        scene = load(path, data)
        if all(Path(name).is_file() for name in files(scene)):
            yield path.stem, small(scene)


def small(scene: Scene) -> Scene:
    film = scene.film
    scale = min(1.0, SIZE / max(film.width, film.height))
    size = {"width": max(1, round(film.width * scale)), "height": max(1, round(film.height * scale))}
    return scene.model_copy(update={"film": film.model_copy(update=size)})


def measure(
    wanted: Iterable[tuple[str, Scene]], device: Device, seconds: float, say: Callable[[str], None]
) -> tuple[list[Found], list[str]]:
    """What was found, and the names of scenes whose variants are all the same program."""
    found, nothing = list[Found](), list[str]()
    for name, scene in wanted:
        try:
            outcome = run(scene, variants(scene, VARY), device, seconds)
        except CompareError:
            nothing.append(name)
            say(f"{name}: nothing to choose")
            continue
        except DeviceError as error:
            say(f"{name}: left out, {error}")
            continue
        verdict = winner(outcome.rows)
        say(f"{name}: {verdict['says']}")
        found.append(Found(name, outcome, verdict))
    return found, nothing


# What follows from it


def mean_ratio(found: Sequence[Found], field: str, kind: str, over: str) -> tuple[float, float, float, int] | None:
    """Geometric mean, least and largest ratio of efficiencies over the scenes and over the other choices, where the one
    choice alone differs and makes another program; and how many there are."""
    logs = []
    for each in found:
        for label in LABELS:
            choices = dict(zip(VARY, label.split(", "), strict=True))
            if choices[field] != kind:
                continue
            a, b = each.at(label), each.at(", ".join((choices | {field: over}).values()))
            if a is None or b is None or a is b or not (each.believed(a) and each.believed(b)):
                continue
            if a["efficiency"] and b["efficiency"]:
                logs.append(math.log(a["efficiency"] / b["efficiency"]))
    if not logs:
        return None
    return math.exp(sum(logs) / len(logs)), math.exp(min(logs)), math.exp(max(logs)), len(logs)


def to_the_default(found: Sequence[Found], label: str) -> tuple[float, int] | None:
    """Geometric mean over the scenes of a variant's efficiency over the default's; and how many scenes there are."""
    logs = []
    for each in found:
        row, own = each.at(label), each.default
        if row and own and row["efficiency"] and own["efficiency"] and each.believed(row):
            logs.append(math.log(row["efficiency"] / own["efficiency"]))
    return (math.exp(sum(logs) / len(logs)), len(logs)) if logs else None


def over_default(each: Found, row: Row) -> Ratio | None:
    return None if each.default is None else ratio(row["slices"], each.default["slices"])


# The page


def figure(found: Sequence[Found]) -> str:
    groups = [Group(each.name, list(_spans(each))) for each in found if any(_spans(each))]
    drawn = draw(
        groups, "efficiency, over that of the program’s choice", "Efficiencies of all variants, scene by scene"
    )
    drawn.set("class", f"{drawn.get('class')} file")
    return file(drawn, figure_style())


def _spans(each: Found) -> Iterator[Span]:
    rows = {row["label"]: row for row in each.outcome.rows}
    for label in each.verdict["order"]:
        row = rows[label]
        if found := over_default(each, row):
            low, high = (None, None) if row["default"] else (found["low"], found["high"])
            yield Span(label, found["value"], low, high, LABELS.index(label), not each.believed(row))


def page(found: Sequence[Found], nothing: Sequence[str], device: Device, seconds: float) -> str:
    won = [each.name for each in found if each.default and _best(each, each.default)]
    lost = [each.name for each in found if each.default and each.name not in won]
    values = {
        "device": f"{device.name} ({device.platform}, {device.driver})",
        "seconds": words.number(seconds),
        "size": SIZE,
        "defaults": _defaults(won, lost, nothing),
        "winners": _table(
            ["scene", "program's choice", "best", "best over the program's choice", "verdict"], _winners(found)
        ),
        "choices": _table(["choice", "ratio", "least", "largest", "pairs"], _choices(found)),
        "variants": _table(["variant", "over the program's choice", "scenes"], _variants(found)),
        "scenes": "\n\n".join(f"## {each.name}\n\n{_scene(each)}" for each in found),
    }
    return PAGE.format(**values)


def _best(each: Found, row: Row) -> bool:
    return row["label"] == each.verdict["winner"] or row["label"] in each.verdict["draw"]


def _defaults(won: Sequence[str], lost: Sequence[str], nothing: Sequence[str]) -> str:
    parts = []
    if won:
        parts.append(f"No variant is surely better than the program's choice on {', '.join(won)}.")
    if lost:
        parts.append(f"It is beaten on {', '.join(lost)}.")
    if nothing:
        parts.append(f"There is nothing to choose, for all variants are one program, on {', '.join(nothing)}.")
    return "\n".join(parts)


def _winners(found: Sequence[Found]) -> Iterator[list[str]]:
    for each in found:
        rows = {row["label"]: row for row in each.outcome.rows}
        best, own = rows[each.verdict["order"][0]], each.default
        lead = None if own is best else over_default(each, best)
        draw = len(each.verdict["draw"])
        verdict = "wins" if each.verdict["winner"] else f"a draw of {draw}" if draw else "nobody wins"
        yield [each.name, own["label"] if own else "–", best["label"], _interval(lead) or "–", verdict]


def _choices(found: Sequence[Found]) -> Iterator[list[str]]:
    for field, chosen in VARY.items():
        for kind in chosen[1:]:
            if mean := mean_ratio(found, field, kind, chosen[0]):
                value, least, largest, pairs = mean
                numbers = [words.number(each) for each in (value, least, largest)]
                yield [f"{field}: {kind} over {chosen[0]}", *numbers, str(pairs)]


def _variants(found: Sequence[Found]) -> Iterator[list[str]]:
    means = [(label, mean) for label in LABELS if (mean := to_the_default(found, label))]
    for label, (value, scenes) in sorted(means, key=lambda item: -item[1][0]):
        yield [label, words.number(value), str(scenes)]


def _scene(each: Found) -> str:
    rows = {row["label"]: row for row in each.outcome.rows}
    return f"{each.verdict['says']}\n\n" + _table(
        ["variant", "over the program's choice", "error of a pixel", "samples", "build, s", ""],
        (
            [
                f"**{label}**" if label == each.verdict["winner"] else label,
                "1, the program's choice" if rows[label]["default"] else _interval(over_default(each, rows[label])),
                error_text(rows[label]),
                words.count(rows[label]["samples"]),
                words.number(rows[label]["build_seconds"]),
                standing(rows[label], each.verdict),
            ]
            for label in each.verdict["order"]
        ),
    )


def _interval(found: Ratio | None) -> str:
    if found is None:
        return ""
    value, low, high = found["value"], found["low"], found["high"]
    known = "" if low is None or high is None else f" ({words.number(low)} to {words.number(high)})"
    return words.number(value) + known


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *rows])


if __name__ == "__main__":
    main()
