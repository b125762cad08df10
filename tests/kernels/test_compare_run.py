"""Comparisons on the device, the command line, and the study of the examples."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import typer
from tests.conftest import described
from tests.kernels.made_rows import entry
from typer.testing import CliRunner

from studies.estimators import SIZE, Found, figure, mean_ratio, page, scenes, to_the_default
from woodcock.compare import CompareError, variants, winner
from woodcock.compare.agreement import of_reference
from woodcock.compare.command import compare
from woodcock.compare.judge import twins
from woodcock.compare.run import Outcome, run
from woodcock.device import Device, find
from woodcock.reference import Reference
from woodcock.render import Renderer

COMMAND = typer.Typer()
COMMAND.command()(compare)

# A real one


@pytest.fixture
def cloud(box: dict[str, Any], grid: Callable[..., dict[str, Any]]) -> dict[str, Any]:
    """A dense middle in thin air: one majorant for all is a poor bound."""
    values = np.full((12, 12, 12), 0.02, np.float32)
    values[4:8, 4:8, 4:8] = 40
    return box | {"volumes": [grid(values)], "film": {"width": 16, "height": 16}}


def test_a_comparison_on_the_device(cloud: dict[str, Any], device: Device) -> None:
    scene = described(cloud)
    told: list[tuple[float, float]] = []
    found = run(
        scene,
        variants(scene, {"majorant": ["global", "grid"]}),
        device,
        0.6,
        progress=lambda done, total: told.append((done, total)),
    )
    assert [row["label"] for row in found.rows] == ["global", "grid"]
    assert [row["default"] for row in found.rows] == [False, True]
    assert told[-1][1] == pytest.approx(1.2)
    for row in found.rows:
        film = found.films[row["label"]]
        assert film.samples == row["samples"] == sum(each.samples for each in row["slices"])
        assert row["seconds"] == pytest.approx(sum(each.seconds for each in row["slices"]))
        assert row["series"][-1]["samples"] == film.samples
        # The pooled efficiency is that of the whole film, whose variance holds the same squares
        assert row["efficiency"] == pytest.approx(1 / (film.rmse() ** 2 * row["seconds"]), rel=0.05)
        assert row["build_seconds"] > 0
    verdict = winner(found.rows)
    assert verdict["disagree"] == []
    assert verdict["ratios"].keys() == {"global", "grid"}
    assert not np.array_equal(found.films["global"].mean, found.films["grid"].mean)


def test_what_compiles_to_the_same_program_is_left_out(box: dict[str, Any], device: Device) -> None:
    scene = described(box | {"volumes": [], "surfaces": [{"kind": "sphere", "center": [0, 0, 0], "radius": 1}]})
    with pytest.raises(CompareError, match="compile to the same program"):
        run(scene, variants(scene, {"majorant": ["global", "grid"]}), device, 0.1)


def test_twins_are_told_by_what_was_rendered() -> None:
    assert twins({"b": "a", "d": "c", "e": "a"}) == {"a": ["b", "e"], "c": ["d"]}


def test_seeds_are_independent(cloud: dict[str, Any], device: Device) -> None:
    """Of each other, and of the reference's: its samples would count twice."""
    scene = described(cloud | {"seed": 5})
    reference = Reference(np.full((16, 16, 1), 0.5), np.full((16, 16, 1), 1e-6), "made up", seed=5)
    chosen = variants(scene, {"majorant": ["global", "grid"]})
    found = run(scene, chosen, device, 0.1, reference)
    again = Renderer(chosen[0].scene.model_copy(update={"seed": 6}), device).render(0, found.films["global"].samples)
    assert again.mean == pytest.approx(found.films["global"].mean, rel=1e-5)
    assert all(row["against"] for row in found.rows)
    assert set(winner(found.rows, of_reference(reference))["disagree"]) == {"global", "grid"}


def test_without_noise_there_is_a_bound(cloud: dict[str, Any], device: Device) -> None:
    for volume in cloud["volumes"]:
        volume["albedo"] = 0
    scene = described(cloud)
    found = run(scene, variants(scene, {"integrator": ["transmittance", "volumetric_path"]}), device, 0.3)
    verdict = winner(found.rows)
    assert verdict["winner"] == "transmittance"
    assert "no noise" in verdict["says"]


# The command line


def woodcock(*arguments: object) -> Any:
    return CliRunner().invoke(COMMAND, [str(each) for each in arguments])


@pytest.fixture
def file(cloud: dict[str, Any], tmp_path: Path) -> Path:
    path = tmp_path / "cloud <b>.json"
    path.write_text(json.dumps(cloud))
    return path


def test_compare_prints_a_table_and_writes_a_page(file: Path, tmp_path: Path) -> None:
    done = woodcock(file, "--vary", "majorant=global,grid", "--seconds", 0.3, "-o", tmp_path / "page.html")
    assert done.exit_code == 0, done.output
    assert "grid (default)" in done.stdout
    assert "over the worst" in done.stdout
    assert re.search(r"“(global|grid)” wins|A draw between", done.stdout)
    page = (tmp_path / "page.html").read_text()
    assert "cloud &lt;b&gt;" in page
    assert '<h2 id="how">How it was measured</h2>' in page


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--vary", "majorant=octree,grid"], "majorant has no kind octree; it has global, grid"),
        (["--vary", "light=sun"], "light cannot vary"),
        (["--vary", "majorant=global,grid", "--reference", "none.exr"], "none.exr"),
        (["--vary", "majorant=global,grid", "--device", "gpu9"], "gpu9"),
        (["--vary", "majorant=global,grid", "-o", "page.txt"], "-o page.txt: the name must end in .html"),
    ],
)
def test_compare_says_what_is_wrong(file: Path, arguments: list[str], said: str) -> None:
    done = woodcock(file, *arguments)
    assert done.exit_code in (1, 2)
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert done.stdout == ""


# The study


def made(name: str, speeds: dict[str, float], same: dict[str, str], default: str) -> Found:
    rows = [entry(label, speed) | {"default": label == default} for label, speed in speeds.items()]
    return Found(name, Outcome(rows, {}, same), winner(rows))


def test_the_study_compares_choices_by_geometric_means() -> None:
    """Of made-up scenes in which the grid's bound is four times as good, or makes no other program."""
    first = made(
        "first",
        {"delta, ratio, global": 1.0, "delta, ratio, grid": 4.0, "decomposition, ratio, grid": 2.0},
        {"decomposition, ratio, global": "delta, ratio, global"},
        "delta, ratio, global",
    )
    second = made(
        "second",
        {"delta, ratio, global": 1.0, "decomposition, ratio, global": 9.0},
        {"delta, ratio, grid": "delta, ratio, global"},
        "delta, ratio, global",
    )
    mean = mean_ratio([first, second], "majorant", "grid", "global")
    assert mean is not None
    # 4 of delta and 2 of decomposition, of the first scene alone
    assert mean == pytest.approx((math.sqrt(8), 2, 4, 2), rel=0.05)
    assert mean_ratio([first, second], "transmittance", "ray_marching", "ratio") is None
    over = to_the_default([first, second], "delta, ratio, grid")
    assert over is not None
    assert over == pytest.approx((2.0, 2), rel=0.05)  # √(4 × 1): its twin counts for it
    text = page([first, second], ["fog"], find(), 10)
    assert "It is beaten on first, second." in text
    assert "There is nothing to choose, for all variants are one program, on fog." in text
    assert "| first | delta, ratio, global | delta, ratio, grid |" in text
    drawn = ElementTree.fromstring(figure([first, second]))
    assert [each.text for each in drawn.iter() if each.get("class") == "heading"] == ["first", "second"]


def test_the_study_finds_the_examples() -> None:
    found = dict(scenes(None))
    assert {"block", "fireball", "fog"} <= set(found)
    assert all(max(scene.film.width, scene.film.height) == SIZE for scene in found.values())
