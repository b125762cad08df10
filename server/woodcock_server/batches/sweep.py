"""Sweeps: the same scene with other values at some of its fields, at every combination of them (pure).

Paths name fields as a scene's faults do: `volumes[0].sigma_t`, `camera.origin[1]`. A scene is JSON with its defaults
filled in.
"""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from itertools import product as combinations
from typing import Any, TypeAlias

#: Path -> values, in their order.
Axes: TypeAlias = Mapping[str, Sequence[Any]]
#: Path -> value.
Point: TypeAlias = dict[str, Any]
#: Where in a request a fault is: ("product", "volumes[0].sigma_t", 2).
Location: TypeAlias = tuple[str | int, ...]
Steps: TypeAlias = tuple[str | int, ...]

#: Jobs that one request may make.
MOST = 1000
#: Bytes of JSON that their scenes may have together.
LARGEST = 32 << 20
#: Characters of a value in a label.
SHOWN = 40

_NAME, _ITEM = r"[A-Za-z_][A-Za-z0-9_]*", r"\[(?:0|[1-9][0-9]{0,8})\]"
_PATH = re.compile(rf"{_NAME}(?:{_ITEM})*(?:\.{_NAME}(?:{_ITEM})*)*")
_STEP = re.compile(rf"{_NAME}|[0-9]+")


@dataclass(frozen=True)
class Axis:
    """What changes together: in each row a value for each path. group: `zip` or `product`, as it was asked for."""

    group: str
    paths: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


def axes(product: Axes, zipped: Axes) -> list[Axis]:
    """The zipped paths as one axis, then each of the product."""
    grouped = [Axis("zip", tuple(zipped), tuple(zip(*zipped.values(), strict=True)))] if zipped else []
    return grouped + [Axis("product", (path,), tuple((value,) for value in values)) for path, values in product.items()]


def positions(swept: Sequence[Axis]) -> Iterator[tuple[int, ...]]:
    """Of every point the row of each axis; the last axis changes fastest."""
    return combinations(*(range(len(axis.rows)) for axis in swept))


def point(swept: Sequence[Axis], position: Sequence[int]) -> Point:
    return {
        path: value
        for axis, row in zip(swept, position, strict=True)
        for path, value in zip(axis.paths, axis.rows[row], strict=True)
    }


def placed(scene: Mapping[str, Any], at: Point) -> Any:
    """The scene with the values of a point; what is the same is shared."""
    changed: Any = scene
    for path, value in at.items():
        steps = _steps(path)
        assert steps, f"{path} was not checked"
        changed = _with(changed, steps, value)
    return changed


def _with(value: Any, steps: Steps, new: Any) -> Any:
    first, *rest = steps
    changed = copy(value)
    changed[first] = _with(value[first], tuple(rest), new) if rest else new
    return changed


def label(at: Point) -> str:
    """A point for people: `sigma_t=2, fov=35`. Fields go by their last name, where no other one has it."""
    last = {path: path.rpartition(".")[2] for path in at}
    often = Counter(last.values())
    return ", ".join(f"{path if often[last[path]] > 1 else last[path]}={_shown(value)}" for path, value in at.items())


def _shown(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    if not text.isprintable():  # Names are one line.
        text = json.dumps(value)
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 1]}…"


# What is no sweep


def check(scene: Mapping[str, Any], product: Axes, zipped: Axes) -> list[tuple[Location, str]]:
    """What is wrong with a sweep of a scene, before any of its scenes is made: where, and what would be right."""
    return (
        _check_lengths(product, zipped)
        or _check_size(scene, axes(product, zipped))
        or _check_paths(scene, {"zip": zipped, "product": product})
    )


def _check_lengths(product: Axes, zipped: Axes) -> list[tuple[Location, str]]:
    if not product and not zipped:
        return [(("product",), "must name a field and its values, or `zip` must")]
    groups = (("product", product), ("zip", zipped))
    empty = [(group, path) for group, named in groups for path, values in named.items() if not values]
    if empty:
        return [(where, "must hold one value at least") for where in empty]
    lengths = {path: len(values) for path, values in zipped.items()}
    first = next(iter(lengths), "")
    return [
        (("zip", path), f"must hold as many values as {first} does, {lengths[first]}, not {length}")
        for path, length in lengths.items()
        if length != lengths[first]
    ]


def _check_size(scene: Mapping[str, Any], swept: Sequence[Axis]) -> list[tuple[Location, str]]:
    group = swept[-1].group
    jobs = math.prod(len(axis.rows) for axis in swept)
    if jobs > MOST:
        count = str(jobs) if jobs < 10**9 else "more than a billion"
        return [((group,), f"must make {MOST} jobs at most; this makes {count}")]
    size = jobs * _size(scene) + sum(jobs // len(axis.rows) * _size(axis.rows) for axis in swept)
    if size > LARGEST:
        says = f"must make scenes of {LARGEST >> 20} MiB at most, in all; this makes {-(-size >> 20)} MiB of JSON"
        return [((group,), says)]
    return []


def _size(value: Any) -> int:
    return len(json.dumps(value))


def _check_paths(scene: Mapping[str, Any], groups: Mapping[str, Axes]) -> list[tuple[Location, str]]:
    faults = list[tuple[Location, str]]()
    good = dict[Steps, Location]()
    for group, named in groups.items():
        for path in named:
            steps = _steps(path)
            if steps is None:
                why: str | None = "must be the path of a field, such as volumes[0].sigma_t"
            elif steps in good:
                why = "must not be in `zip` too"
            else:
                why = _hindrance(scene, steps)
            if why:
                faults.append(((group, path), why))
            elif steps:
                good[steps] = (group, path)
    for steps, where in good.items():
        outer = next((good[steps[:end]][-1] for end in range(1, len(steps)) if steps[:end] in good), None)
        if outer is not None:
            faults.append((where, f"must not lie within {outer}, which varies too"))
    return faults


def _steps(path: str) -> Steps | None:
    """`volumes[0].sigma_t` as ("volumes", 0, "sigma_t"); None for what is no path."""
    if not _PATH.fullmatch(path):
        return None
    return tuple(int(step) if step.isdecimal() else step for step in _STEP.findall(path))


def _hindrance(scene: Mapping[str, Any], steps: Steps) -> str | None:
    """Why nothing can be put there; None if something can, whether the scene then is valid or not."""
    if steps[-1] == "kind":
        return "must be what has the kind, with objects for values: fields differ from kind to kind"
    value: Any = scene
    for position, step in enumerate(steps):
        where = _written(steps[:position]) or "the scene"
        if isinstance(step, int):
            if not isinstance(value, list):
                return f"must lead to a field: {where} is {_kind(value)} and has no items"
            if step >= len(value):
                return f"must lead to a field: {where} has no item [{step}], it holds {len(value)}"
        elif not isinstance(value, dict):
            return f"must lead to a field: {where} is {_kind(value)} and has no fields"
        elif step not in value:
            if position == len(steps) - 1:
                return None  # perhaps the scene knows it
            return f"must lead to a field: {where} has no {step}"
        value = value[step]
    return None


def _written(steps: Steps) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps).removeprefix(".")


def _kind(value: Any) -> str:
    match value:
        case None:
            return "not set"
        case bool():
            return "true or false"
        case int() | float():
            return "a number"
        case str():
            return "a text"
        case list():
            return "a list"
        case _:
            return "an object"
