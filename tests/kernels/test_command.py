"""The renderer's commands as a user runs them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from woodcock.image import read_exr


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
    assert done.stdout.split() == [str(out), str(tmp_path / "out.report.json")]
    layers, header = read_exr(out)
    assert (layers["samples.count"] == 37).all()
    assert json.loads(header["scene"])["seed"] == 7
    assert header["sampleRanges"] == "[[0, 37]]"
    report = json.loads((tmp_path / "out.report.json").read_text())
    assert report["samples"] == report["error"][-1]["samples"] == 37
    assert report["certificate"]["failed"] == []
    assert "rounding" not in report["certificate"]["not_checked"]
    assert set(report["seconds"]) == {"read", "build", "upload", "render", "check", "write"}
    assert report["program_hash"] == header["programHash"]
    assert report["kinds"]["volume"] == ["constant"]
    assert report["rmse"] == pytest.approx(float(layers["variance.Y"].mean()) ** 0.5, rel=1e-5)


def test_the_header_renders_the_same_picture_again(scene: Path, tmp_path: Path) -> None:
    assert woodcock("render", scene, "-o", tmp_path / "one.exr").returncode == 0
    layers, header = read_exr(tmp_path / "one.exr")
    scene.write_text(header["scene"])
    assert woodcock("render", scene, "-o", tmp_path / "two.exr").returncode == 0
    assert (read_exr(tmp_path / "two.exr")[0]["Y"] == layers["Y"]).all()


def test_seconds_contract(scene: Path, tmp_path: Path) -> None:
    described = json.loads(scene.read_text())
    described["stop"] = {"kind": "seconds", "seconds": 0.5}
    scene.write_text(json.dumps(described))
    assert woodcock("render", scene, "-o", tmp_path / "out.exr").returncode == 0
    report = json.loads((tmp_path / "out.report.json").read_text())
    assert report["samples"] > 1
    assert 0.2 < report["seconds"]["render"] < 2


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
