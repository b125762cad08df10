"""The README's examples, run as they stand (the scene with fewer pixels) against the real service."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.server.conftest import Service

from woodcock.image import read_exr
from woodcock.scene import parse

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "client" / "woodcock_client" / "examples"


def blocks(path: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", path.read_text(), re.DOTALL)


def small_scene() -> str:
    (scene,) = blocks(ROOT / "README.md", "json")
    return scene.replace("256", "32").replace("192", "24")


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text()
    targets = re.findall(r"^make ([\w-]+)", (ROOT / "README.md").read_text(), re.MULTILINE)
    assert {"demo", "test"} <= set(targets)
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


@pytest.mark.skipif(not shutil.which("curl"), reason="curl is missing: apt install curl")
def test_http_examples(tmp_path: Path) -> None:
    (tmp_path / "scene.json").write_text(small_scene())
    shutil.copy(EXAMPLES / "fireball.vdb", tmp_path)
    service = Service(tmp_path / "data")
    service.start()
    try:
        _, submit, upload = blocks(ROOT / "README.md", "sh")
        for script in (submit, upload):
            script = "set -eu\n" + script.replace("http://127.0.0.1:8000", str(service.http.base_url).rstrip("/"))
            done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=120)
            assert done.returncode == 0, done.stderr
    finally:
        service.stop()
    layers, _ = read_exr(tmp_path / "block.exr")
    assert (layers["samples.count"] == 64).all()
    assert json.loads((tmp_path / "block.report.json").read_text())["samples"] == 64
    assert json.loads(done.stdout)["id"].startswith("sha256:")


def test_kernels_example(tmp_path: Path) -> None:
    (tmp_path / "scene.json").write_text(small_scene())
    (example,) = blocks(ROOT / "kernels" / "README.md", "python")
    done = subprocess.run(
        [sys.executable, "-c", example], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=True
    )
    assert done.stdout.startswith("64 0.")
    assert read_exr(tmp_path / "scene.exr")[0]["R"].shape == (24, 32)


@pytest.mark.parametrize("path", sorted(EXAMPLES.rglob("*.json")), ids=lambda path: path.stem)
def test_examples_are_scenes(path: Path) -> None:
    parse(path.read_text())
