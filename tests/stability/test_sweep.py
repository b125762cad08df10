"""The sweep itself on the device, and that it finds what is wrong with a picture."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.device import Device
from woodcock.faults import Faults
from woodcock.film import Film
from woodcock.plan import lay_out
from woodcock.render import Renderer, read_file
from woodcock.scene import parse
from woodcock.stability import check, judging
from woodcock.stability.cases import CASES, depth, scale
from woodcock.stability.children import row_of
from woodcock.stability.outcome import Row
from woodcock.stability.scenes import FULL, LOOPS, PATHS

#: What may be refused, or said to be beyond float32.
LIMITS = {"optical depth", "denormals and limits"}


def wrong(rows: list[Row]) -> list[str]:
    return [f"{row['group']}: {row['case']}: {row['says']}" for row in rows if row["verdict"] == "failed"]


def test_a_part_of_all_cases(device: Device) -> None:
    """Every seventeenth: of every subject, by every integrator."""
    rows = [row_of(case, device) for case in CASES[::17]]
    assert wrong(rows) == []
    assert {row["group"] for row in rows if row["verdict"] == "not expressible"} <= LIMITS
    assert {row["unit"] for row in rows} == {"standard errors", "roundings"}


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_all_cases(device: Device) -> None:
    outcome = check(device)
    assert wrong(outcome["rows"]) == []
    assert outcome["passed"]
    assert [row["case"] for row in outcome["rows"]] == [case.name for case in CASES]
    assert {row["group"] for row in outcome["rows"] if row["verdict"] == "not expressible"} <= LIMITS
    if device.doubles:
        # A bound that covers anything says nothing; where it is an ulp of what is stored, it is as good as exact.
        bounds = [row["limit"] for row in outcome["rows"] if row["unit"] == "roundings" and row["limit"]]
        assert np.quantile(bounds, 0.9) < 10


def test_every_subject_has_cases_of_its_own_name() -> None:
    names = [(case.group, case.name) for case in CASES]
    assert len(set(names)) == len(names)
    assert len({case.group for case in CASES}) == 11


@pytest.mark.parametrize("loop", LOOPS)
def test_the_loops_are_two(tmp_path: Path, loop: str) -> None:
    """Under cells a grid is the small loop's, what is uniform the other's."""
    scenes = (scale._uniform(1.0, 1.0, LOOPS[loop], tmp_path), scale._uneven(1.0, 1.0, LOOPS[loop], tmp_path))
    layouts = [lay_out(parse(json.dumps(scene)), read_file) for scene in scenes]
    many = LOOPS[loop] is FULL
    assert [layout.integrator for layout in layouts] == ["volumetric_path" + "_full" * many, "volumetric_path"]
    assert layouts[1].kinds["majorant"] == ("grid" if many else "global",)


# What a device may get wrong


@pytest.fixture
def film(device: Device, tmp_path: Path) -> Callable[..., Film]:
    def render(keys: dict[str, Any], samples: int) -> Film:
        return Renderer(parse(json.dumps(depth._cube(1.0, keys, tmp_path))), device).render(0, samples)

    return render


THROUGH = float(np.exp(-1.0))


def test_a_value_beyond_its_bound_is_found(film: Callable[..., Film]) -> None:
    exact = film({}, 1)
    assert judging.within_bound(exact, THROUGH).verdict == "passed"
    mean = exact.mean.copy()
    mean[3, 2] *= 1 + 3e-7
    found = judging.within_bound(replace(exact, mean=mean), THROUGH)
    assert found.verdict == "failed"
    assert found.deviation == pytest.approx(3e-7 / 2**-24, rel=1e-3)
    assert "bound" in found.says


def test_a_bias_of_hits_is_found(film: Callable[..., Film]) -> None:
    noisy = film(PATHS, 1024)
    assert judging.by_hits(noisy, THROUGH).verdict == "passed"
    assert judging.by_hits(noisy, THROUGH + 0.015).verdict == "failed"
    assert judging.by_chance(noisy, THROUGH).verdict == "passed"
    assert judging.by_chance(noisy, THROUGH - 0.015).verdict == "failed"


def test_a_speck_in_a_furnace_is_found(film: Callable[..., Film]) -> None:
    white = replace(film({}, 1), mean=np.ones((8, 8, 1)))
    assert judging.everywhere(white, 1.0).verdict == "passed"
    white.mean[7, 0] = 1 - 1e-6
    assert judging.everywhere(white, 1.0).verdict == "failed"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"faults": Faults(nan=3)}, "3 of 64 samples"),
        ({"faults": Faults(violations=2)}, "exceeded its majorant 2 times"),
        ({"mean": np.full((8, 8, 1), np.nan)}, "NaN or infinite"),
        ({"mean": np.full((8, 8, 1), np.inf)}, "NaN or infinite"),
        ({"mean": np.full((8, 8, 1), -1e-30)}, "negative"),
        ({"m2": np.full((8, 8, 1), np.nan)}, "variance"),
    ],
    ids=["rejected", "violations", "NaN", "infinite", "negative", "variance"],
)
def test_what_no_picture_may_hold_is_found(film: Callable[..., Film], changes: dict[str, Any], says: str) -> None:
    found = judging.within_bound(replace(film({}, 1), **changes), THROUGH)
    assert found.verdict == "failed"
    assert says in found.says


def drift(relative: float, error: float = 1e-3) -> Any:
    return {"relative": relative, "error": error, "largest": 1.0, "turned": 0.5, "paths": 4096}


def test_only_what_double_precision_explains_is_beyond_float32() -> None:
    off = judging.Finding(0.5, 0.47, -8.0, "standard errors", 5.0, "failed", "off")
    assert judging.explained(off, drift(-0.06), "it").verdict == "not expressible"
    assert "-6.0%" in judging.explained(off, drift(-0.06), "it").says
    assert judging.explained(off, drift(-0.2), "it") is off
    assert judging.explained(off, drift(0.0), "it") is off
    assert judging.explained(off, None, "it") is off
