"""The renderer's commands as a user runs them."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tests.statistics import accept_z

from woodcock import flip
from woodcock.image import read_exr
from woodcock.report_schema import Report


def woodcock(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "woodcock_client.cli", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


@pytest.fixture
def scene(tmp_path: Path, box: dict[str, Any]) -> Path:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(box | {"stop": {"kind": "samples", "samples": 37}}))
    return path


def test_render_writes_picture_and_report(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.exr"
    done = woodcock("render", scene, "-o", out)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(tmp_path / f"out.{suffix}") for suffix in ("exr", "report.json", "report.html")]
    layers, header = read_exr(out)
    assert (layers["samples.count"] == 37).all()
    assert json.loads(header["scene"])["seed"] == 7
    assert header["sampleRanges"] == "[[0, 37]]"
    report = json.loads((tmp_path / "out.report.json").read_text())
    assert report["samples"] == report["error"][-1]["samples"] == 37
    assert report["certificate"]["failed"] == []
    assert "rounding" not in report["certificate"]["not_checked"]
    assert set(report["seconds"]) == {"read", "build", "upload", "render", "merge", "check", "write"}
    assert report["program_hash"] == header["programHash"]
    assert report["kinds"]["volume"] == ["constant"]
    Report.model_validate(report)
    assert 0 < report["utilisation"] <= 1
    assert float(header["rmse"]) == pytest.approx(report["rmse"])
    assert float(header["samples"]) == 37
    assert report["rmse"] == pytest.approx(float(layers["variance.Y"].mean()) ** 0.5, rel=1e-5)


def test_the_header_renders_the_same_picture_again(scene: Path, tmp_path: Path) -> None:
    assert woodcock("render", scene, "-o", tmp_path / "one.exr").returncode == 0
    layers, header = read_exr(tmp_path / "one.exr")
    scene.write_text(header["scene"])
    assert woodcock("render", scene, "-o", tmp_path / "two.exr").returncode == 0
    assert (read_exr(tmp_path / "two.exr")[0]["Y"] == layers["Y"]).all()


def test_a_reference(scene: Path, tmp_path: Path) -> None:
    """With a seed of its own, of 11 times the samples: what the samples tell is what the reference tells."""
    described = json.loads(scene.read_text())
    scene.write_text(json.dumps(described | {"seed": 8, "stop": {"kind": "samples", "samples": 400}}))
    assert woodcock("render", scene, "-o", tmp_path / "long.exr").returncode == 0
    scene.write_text(json.dumps(described))
    done = woodcock("render", scene, "-o", tmp_path / "out.exr", "--reference", tmp_path / "long.exr")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "out.report.json").read_text())
    Report.model_validate(report)
    found, mine, long = report["against"], report["rmse"] ** 2, float(read_exr(tmp_path / "long.exr")[1]["rmse"]) ** 2
    assert report["reference"] == "long.exr"
    assert found["reference_mse"] == pytest.approx(long, rel=1e-5)
    # Squares of 1024 normal deviations: their mean is known to 1 / √512.
    accept_z((found["mse"] / mine - 1) * math.sqrt(512) / (1 + long / mine), exact=False)
    accept_z(found["bias"] / found["bias_error"], exact=False)
    if flip.flip_evaluator is not None:
        assert 0 < found["flip"] < 0.5
    assert {key: report["error"][-1]["against"][key] for key in ("mse", "bias")} == {
        key: found[key] for key in ("mse", "bias")
    }


def test_a_reference_with_the_same_samples_is_not_taken_for_independent(scene: Path, tmp_path: Path) -> None:
    for name, more in (("one", ()), ("two", ("--reference", tmp_path / "one.exr"))):
        assert woodcock("render", scene, "-o", tmp_path / f"{name}.exr", *more).returncode == 0
    report = json.loads((tmp_path / "two.report.json").read_text())
    assert report["against"]["reference_mse"] is None
    assert report["against"]["mse"] < 1e-9 * report["rmse"] ** 2


def test_bad_references(scene: Path, tmp_path: Path) -> None:
    described = json.loads(scene.read_text())
    scene.write_text(json.dumps(described | {"film": {"width": 8, "height": 4}}))
    assert woodcock("render", scene, "-o", tmp_path / "small.exr").returncode == 0
    scene.write_text(json.dumps(described))
    for file, message in (
        ("small.exr", "--reference small.exr: is 8 × 4 pixels; a reference must be 32 × 32, as the film is"),
        ("none.exr", "none.exr: No such file or directory"),
        ("scene.json", "scene.json: is no picture that can be read"),
    ):
        done = woodcock("render", scene, "-o", tmp_path / "out.exr", "--reference", tmp_path / file)
        assert done.returncode == 2
        assert message in done.stderr
        assert "Traceback" not in done.stderr
        assert not (tmp_path / "out.exr").exists()


def test_seconds_contract(scene: Path, tmp_path: Path) -> None:
    described = json.loads(scene.read_text())
    described["stop"] = {"kind": "seconds", "seconds": 0.5}
    scene.write_text(json.dumps(described))
    assert woodcock("render", scene, "-o", tmp_path / "out.exr").returncode == 0
    report = json.loads((tmp_path / "out.report.json").read_text())
    assert report["samples"] > 1
    assert 0.2 < report["seconds"]["render"] < 2


def test_relative_error_contract(scene: Path, tmp_path: Path) -> None:
    """Of a picture with two empty tiles; and from its header it is rendered again, the same decisions included."""
    described = json.loads(scene.read_text()) | {"film": {"width": 96, "height": 32}}
    described["stop"] = {"kind": "relative_error", "relative_error": 0.03, "per": "tile"}
    scene.write_text(json.dumps(described))
    done = woodcock("render", scene, "-o", tmp_path / "one.exr")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "one.report.json").read_text())
    assert report["contract"]["met"]
    assert 0.02 < report["contract"]["reached"] <= 0.03
    assert report["certificate"]["failed"] == []
    layers, header = read_exr(tmp_path / "one.exr")
    assert report["mean_samples"] == pytest.approx(layers["samples.count"].mean())
    assert layers["samples.count"].min() < report["mean_samples"] < report["samples"]
    scene.write_text(header["scene"])
    assert woodcock("render", scene, "-o", tmp_path / "two.exr").returncode == 0
    again, _ = read_exr(tmp_path / "two.exr")
    assert (again["samples.count"] == layers["samples.count"]).all()
    assert (again["Y"] == layers["Y"]).all()


@pytest.mark.parametrize(
    ("change", "code", "message"),
    [
        ({"seed": -1}, 2, "scene.json: seed: input should be greater than or equal to 0 (got -1)"),
        ({"volumes": [{"kind": "grid", "file": "none.vdb", "albedo": 1}]}, 2, "none.vdb: No such file or directory"),
        ({"surfaces": [{"kind": "mesh", "file": "none.ply"}]}, 2, "none.ply: No such file or directory"),
        ({"lights": [{"kind": "image", "file": "none.exr"}]}, 2, "none.exr: No such file or directory"),
        ({"lights": [{"kind": "image", "file": "scene.json"}]}, 2, "scene.json: is no picture that can be read"),
    ],
)
def test_bad_scenes(scene: Path, tmp_path: Path, change: dict[str, Any], code: int, message: str) -> None:
    scene.write_text(json.dumps(json.loads(scene.read_text()) | change))
    done = woodcock("render", scene, "-o", tmp_path / "out.exr")
    assert done.returncode == code
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out.exr").exists()


def test_denoising_fails_before_rendering_where_its_extra_is_missing(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mitsuba_oidn.py").write_text("raise ImportError('none here')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    scene.write_text(json.dumps(json.loads(scene.read_text()) | {"denoise": True}))
    done = woodcock("render", scene, "-o", tmp_path / "out.exr")
    assert done.returncode == 1
    assert "pip install 'woodcock[denoise]'" in done.stderr
    assert not (tmp_path / "out.exr").exists()


def test_bad_arguments(scene: Path, tmp_path: Path) -> None:
    for arguments, message in (
        (("-o", tmp_path / "out.png"), "must end in .exr"),
        (("-o", tmp_path / "none" / "out.exr"), "is not a folder"),
        (("-o", tmp_path / "out.exr", "--device", "gpu77"), "there is no device 'gpu77'"),
    ):
        done = woodcock("render", scene, *arguments)
        assert done.returncode in (1, 2)
        assert message in done.stderr


def test_devices_and_schema() -> None:
    listed = woodcock("devices")
    assert listed.returncode == 0
    assert "cpu0" in listed.stdout
    assert json.loads(woodcock("schema").stdout)["title"] == "Scene"
    assert json.loads(woodcock("schema", "report").stdout)["title"] == "Report"
