"""The expansion of sweeps, against loops and assignments that share nothing with it."""

from __future__ import annotations

import copy
import itertools
import json
from functools import reduce
from operator import getitem
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from woodcock_server.batches import sweep

SCENE: dict[str, Any] = {
    "camera": {"kind": "perspective", "origin": [0, 1, 4], "fov": 35},
    "volumes": [{"sigma_t": 5, "albedo": [0.9, 0.8, 0.7]}, {"sigma_t": 1, "phase": {"kind": "isotropic"}}],
    "majorant": None,
    "film": {"width": 8, "height": 8},
    "seed": 0,
}
#: Paths none of which lies in another, and the keys by which Python gets there.
LEAVES: dict[str, tuple[Any, ...]] = {
    "seed": ("seed",),
    "orders": ("orders",),
    "camera.fov": ("camera", "fov"),
    "camera.origin[1]": ("camera", "origin", 1),
    "camera.origin[2]": ("camera", "origin", 2),
    "volumes[0].sigma_t": ("volumes", 0, "sigma_t"),
    "volumes[0].albedo": ("volumes", 0, "albedo"),
    "volumes[1]": ("volumes", 1),
    "film": ("film",),
    "majorant": ("majorant",),
}
values = st.one_of(st.none(), st.integers(-9, 9), st.text(max_size=3), st.lists(st.integers(0, 3), max_size=2))


@st.composite
def sweeps(draw: st.DrawFn) -> tuple[dict[str, list[Any]], dict[str, list[Any]]]:
    """product and zip, of 144 points at most."""
    paths = draw(st.lists(st.sampled_from(sorted(LEAVES)), unique=True, min_size=1, max_size=5))
    zipped = paths[: draw(st.integers(0, min(3, len(paths))))]
    rows = draw(st.integers(1, 4))
    product = {path: draw(st.lists(values, min_size=1, max_size=3)) for path in paths[len(zipped) :][:3]}
    return product, {path: draw(st.lists(values, min_size=rows, max_size=rows)) for path in zipped}


def scenes(product: dict[str, list[Any]], zipped: dict[str, list[Any]]) -> list[tuple[dict[str, Any], Any]]:
    """Every point and its scene, as a batch makes them."""
    swept = sweep.axes(product, zipped)
    points = [sweep.point(swept, position) for position in sweep.positions(swept)]
    return [(point, sweep.placed(SCENE, point)) for point in points]


@settings(max_examples=80, deadline=None, derandomize=True)
@given(sweeps())
def test_every_combination_comes_once_and_changes_what_it_names(
    asked: tuple[dict[str, list[Any]], dict[str, list[Any]]],
) -> None:
    product, zipped = asked
    before = copy.deepcopy(SCENE)
    assert sweep.check(SCENE, product, zipped) == []
    expected = []
    for row in range(len(next(iter(zipped.values()))) if zipped else 1):
        for combination in itertools.product(*product.values()):
            point = {path: zipped[path][row] for path in zipped} | dict(zip(product, combination, strict=True))
            scene = copy.deepcopy(before)
            for path, value in point.items():
                *outer, last = LEAVES[path]
                reduce(getitem, outer, scene)[last] = value
            expected.append((point, scene))
    found = scenes(product, zipped)
    assert found == expected
    assert [list(point) for point, _ in found] == [[*zipped, *product]] * len(expected)
    assert before == SCENE, "the scene itself stays as it was"


def test_the_last_axis_changes_fastest() -> None:
    points = [tuple(point.values()) for point, _ in scenes({"seed": [1, 2], "camera.fov": [3, 4]}, {"orders": [5, 6]})]
    assert points == [(5, 1, 3), (5, 1, 4), (5, 2, 3), (5, 2, 4), (6, 1, 3), (6, 1, 4), (6, 2, 3), (6, 2, 4)]


@pytest.mark.parametrize(
    ("path", "says"),
    [
        *((path, "must be the path of a field") for path in ("", "0", ".a", "a.", "a..b", "a.[0]", "seed ", "é")),
        *((path, "must be the path of a field") for path in ("[0]", "a[-1]", "a[01]", "a[0]b", "a[1", "a[1234567890]")),
        ("volumes[2].sigma_t", "must lead to a field: volumes has no item [2], it holds 2"),
        ("camera.origin[3]", "must lead to a field: camera.origin has no item [3], it holds 3"),
        ("volumes[0].sigma_t.x", "must lead to a field: volumes[0].sigma_t is a number and has no fields"),
        ("seed[0]", "must lead to a field: seed is a number and has no items"),
        ("volumes.sigma_t", "must lead to a field: volumes is a list and has no fields"),
        ("camera[0]", "must lead to a field: camera is an object and has no items"),
        ("majorant.resolution", "must lead to a field: majorant is not set and has no fields"),
        ("volumes[1].emission.epsilon", "must lead to a field: volumes[1] has no emission"),
        ("nothing.at.all", "must lead to a field: the scene has no nothing"),
        ("camera.kind", "must be what has the kind, with objects for values: fields differ from kind to kind"),
    ],
)  # fmt: skip
def test_what_is_no_path(path: str, says: str) -> None:
    ((where, message),) = sweep.check(SCENE, {path: [1]}, {})
    assert where == ("product", path)
    assert message.startswith(says)


def test_paths_exclude_each_other() -> None:
    product = {"volumes[0].albedo[1]": [1], "seed": [1], "volumes[0]": [1], "film.width": [1]}
    found = sweep.check(SCENE, product, {"seed": [1], "film": [1]})
    assert dict(found) == {
        ("product", "seed"): "must not be in `zip` too",
        ("product", "volumes[0].albedo[1]"): "must not lie within volumes[0], which varies too",
        ("product", "film.width"): "must not lie within film, which varies too",
    }
    assert sweep.check(SCENE, {"volumes[1].sigma_t": [1], "volumes[0]": [1]}, {}) == []


def test_lengths_fit() -> None:
    assert sweep.check(SCENE, {}, {}) == [(("product",), "must name a field and its values, or `zip` must")]
    assert sweep.check(SCENE, {"seed": []}, {"orders": []}) == [
        (("product", "seed"), "must hold one value at least"),
        (("zip", "orders"), "must hold one value at least"),
    ]
    assert sweep.check(SCENE, {}, {"seed": [1, 2], "orders": [1], "film": [1, 2]}) == [
        (("zip", "orders"), "must hold as many values as seed does, 2, not 1")
    ]


def test_there_is_an_end_to_it() -> None:
    """Before anything is expanded: the largest of these would take longer than the universe has lasted."""
    thousand = list(range(sweep.MOST))
    assert sweep.check(SCENE, {"seed": thousand}, {}) == []
    assert sweep.check(SCENE, {"orders": [1]}, {"seed": thousand, "camera.fov": thousand}) == []
    for product, zipped, group, says in (
        ({"seed": thousand, "orders": [1, 2]}, {}, "product", "2000"),
        ({}, {"seed": [*thousand, 1]}, "zip", "1001"),
        ({"orders": [1, 2]}, {"seed": thousand}, "product", "2000"),
        ({f"a{n}": thousand for n in range(10)}, {}, "product", "more than a billion"),
        ({f"a{n}": [1, 2] for n in range(20_000)}, {}, "product", "more than a billion"),
    ):
        ((where, message),) = sweep.check(SCENE, product, zipped)
        assert where == (group,)
        assert message == f"must make 1000 jobs at most; this makes {says}"


def test_scenes_are_no_larger_than_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    product = {"seed": [1, 2, 3], "film": ["x" * 1000, ""]}
    made = sum(len(json.dumps(scene)) for _, scene in scenes(product, {}))
    monkeypatch.setattr(sweep, "LARGEST", made + 1000)  # some brackets and names are counted twice
    assert sweep.check(SCENE, product, {}) == []
    monkeypatch.setattr(sweep, "LARGEST", made - 1)
    ((where, message),) = sweep.check(SCENE, product, {})
    assert where == ("product",)
    assert "must make scenes of" in message


def test_points_have_labels() -> None:
    point = {"volumes[0].sigma_t": 2, "camera.origin[1]": 0.5, "film": {"width": 8}, "seed": "a, b"}
    assert sweep.label(point) == 'sigma_t=2, origin[1]=0.5, film={"width": 8}, seed=a, b'
    point = {"volumes[0].sigma_t": 2, "volumes[1].sigma_t": [1, 2, 3], "orders": None}
    assert sweep.label(point) == "volumes[0].sigma_t=2, volumes[1].sigma_t=[1, 2, 3], orders=null"
    assert sweep.label({"a": "ρ", "b": "x\ny", "c": ["\0"]}) == r'a=ρ, b="x\ny", c=["\u0000"]'
    assert sweep.label({"volumes[0].file": "sha256:" + "0" * 64}) == f"file=sha256:{'0' * 32}…"
