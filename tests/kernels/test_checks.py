"""Laws asked of a picture's own program: right programs keep them, wrong ones do not, and rounding is measured."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.conftest import described

from woodcock import checks, drift, render
from woodcock.checks import Check, checked
from woodcock.device import Device
from woodcock.layout import Layout
from woodcock.program import Program, compose
from woodcock.render import Renderer, read_file

Scene = dict[str, Any]
Grid = Callable[..., dict[str, Any]]
FORWARD = {"kind": "henyey_greenstein", "g": 0.8}
SUN = {"kind": "directional", "direction": [0.3, 1, 0.5], "irradiance": [3, 2, 1]}
GLASS = {"kind": "sphere", "center": [0.5] * 3, "radius": 0.4, "material": {"kind": "dielectric"}}
FLOOR = {"kind": "disk", "center": [0.5, 1, 0.5], "normal": [0, -1, 0], "radius": 3}
LAMP = FLOOR | {"center": [0.5, -1, 0.5], "material": {"kind": "emissive", "radiance": 5}}
GLOWING = {"sigma_t": 2, "albedo": 0.25, "emission": {"kind": "constant", "epsilon": 3}}
HOT = {"kind": "blackbody", "kelvin": 1800}


@pytest.fixture(autouse=True)
def fresh_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(checks, "cache_folder", lambda: tmp_path)
    return tmp_path


def check(scene: Scene, device: Device) -> dict[str, Check]:
    parsed = described(scene)
    found = checked(parsed, device, Renderer(parsed, device).program_hash, read_file)
    return {one["name"]: one for one in found}


def statuses(scene: Scene, device: Device) -> dict[str, str]:
    return {name: one["status"] for name, one in check(scene, device).items()}


def test_random_paths_keep_their_laws(box: Scene, grid: Grid, device: Device) -> None:
    """Small loop and full one, grey and coloured, with numbers far from those that laws are asked by."""
    box["lights"].append(SUN)
    kept = {
        "white furnace": "passed",
        "isothermal furnace": "not checked",
        "darkness": "passed",
        "absorption": "passed",
    }
    values = np.random.default_rng(1).random((60, 70, 50), dtype=np.float32)
    cloud = grid(values, scale=[900, 800, 1000], albedo=[1, 0.5, 0.3], phase=FORWARD)
    for volumes in ([box["volumes"][0] | {"sigma_t": 1e4, "phase": FORWARD}], [cloud], [grid(values, scale=1e4)]):
        assert statuses(box | {"volumes": volumes}, device) == kept


def test_media_that_glow_are_asked_for_equilibrium(box: Scene, device: Device) -> None:
    glowing = box["volumes"][0] | GLOWING
    assert set(statuses(box | {"volumes": [glowing]}, device).values()) == {"passed"}
    black = glowing | {"albedo": 0, "emission": HOT}
    white = {"kind": "constant", "radiance": [1, 1, 1]}
    still = box | {"volumes": [black], "lights": [white], "integrator": None}
    assert Renderer(described(still), device).kinds["integrator"] == ["emission_absorption"]
    assert set(statuses(still, device).values()) == {"passed"}


def test_surfaces_are_made_to_lose_nothing(box: Scene, device: Device) -> None:
    found = check(box | {"surfaces": [GLASS, FLOOR, LAMP]}, device)
    assert found["white furnace"]["status"] == found["darkness"]["status"] == "passed"
    assert "no surfaces" in found["absorption"]["reason"]


def test_what_cannot_be_asked_is_not_checked(box: Scene, device: Device) -> None:
    found = check(box | {"lights": [SUN]}, device)
    for name in ("white furnace", "absorption"):
        assert found[name]["status"] == "not checked"
        assert found[name]["reason"] == "the scene has no constant environment"
    assert found["darkness"]["status"] == "passed"


def test_nothing_is_said_of_another_program(box: Scene, device: Device) -> None:
    """Where the numbers of a law make another program, it is not asked."""
    found = checked(described(box), device, "the hash of another one", read_file)
    assert {one["status"] for one in found} == {"not checked"}
    assert sum("another one" in one["reason"] for one in found) == 3


BUGS = {
    "albedo lost": (
        "spectrum_multiply(p.throughput, albedo), collide",
        "spectrum_scale(p.throughput, (real)1.01f), collide",
    ),
    "short flights": ("depth = -log(unit_fine(w.x))", "depth = -0.9f * log(unit_fine(w.x))"),
    "light in the dark": ("moments_add(&sums[c], pick((real)0.f, ", "moments_add(&sums[c], 1e-3f + pick((real)0.f, "),
}


def sinful(old: str, new: str) -> Callable[..., Program]:
    def compose_wrongly(layout: Layout, lanes: int, *, precise: bool = False) -> Program:
        program = compose(layout, lanes, precise=precise)
        return replace(program, text=program.text.replace(old, new))

    return compose_wrongly


@pytest.mark.parametrize(
    ("bug", "law"),
    [
        ("albedo lost", "white furnace"),
        ("short flights", "absorption"),
        ("light in the dark", "darkness"),
    ],
)
def test_a_wrong_program_breaks_a_law(
    box: Scene, grid: Grid, device: Device, monkeypatch: pytest.MonkeyPatch, bug: str, law: str
) -> None:
    old, new = BUGS[bug]
    box["volumes"] = [grid(np.random.default_rng(1).random((6, 7, 5), dtype=np.float32), scale=3, albedo=0.9)]
    assert old in compose(render.lay_out(described(box), read_file), 1).text
    monkeypatch.setattr(render, "compose", sinful(old, new))
    found = check(box, device)
    assert found[law]["status"] == "failed"
    assert found[law]["reason"].startswith("off by")


def test_checks_are_made_once_a_program_and_device(
    box: Scene, device: Device, fresh_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = check(box, device)
    assert len(list((fresh_cache / "checks").iterdir())) == 1
    monkeypatch.setattr(checks, "_all", lambda *_: pytest.fail("made again"))
    assert check(box | {"seed": 99}, device) == first
    (kept,) = (fresh_cache / "checks").iterdir()
    kept.write_text(json.dumps(list(first.values()))[:-5])
    with pytest.raises(pytest.fail.Exception):
        check(box, device)


def test_float32_hardly_moves_a_picture(box: Scene, grid: Grid, device: Device) -> None:
    """The same paths in doubles: hardly a decision turns, and the mean moves by some roundings."""
    values = np.random.default_rng(1).random((6, 7, 5), dtype=np.float32)
    cloud = {"volumes": [grid(values, scale=30, albedo=[0.99, 0.9, 0.8])], "surfaces": [FLOOR]}
    for scene in (box, box | cloud):
        found = Renderer(described(scene), device).drift()
        assert found is not None
        assert abs(found["relative"]) < 1e-6 + 5 * found["error"]
        assert found["error"] < 1e-4
        assert found["turned"] < 0.02
        assert found["paths"] >= 1024


def test_no_drift_without_random_paths(box: Scene, device: Device) -> None:
    box["volumes"][0]["albedo"] = 0
    assert Renderer(described(box | {"integrator": None}), device).drift() is None
    assert Renderer(described(box | {"lights": []}), device).drift() is None


def test_a_float32_that_drifts_is_found(box: Scene, device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    """Flights that are longer by a twentieth in floats alone."""
    monkeypatch.setattr(
        render, "compose", sinful("depth = -log(unit_fine(w.x))", "depth = -1.05f * log(unit_fine(w.x))")
    )
    found = Renderer(described(box), device).drift()
    assert found is not None
    assert abs(found["relative"]) > 1e-5 + 5 * found["error"]
    assert drift.compared(np.full((4, 1), 1.0), np.full((4, 1), 2.0), 4) == {
        "relative": -0.5, "error": 0.0, "largest": 0.5, "turned": 1.0, "paths": 4,
    }  # fmt: skip
