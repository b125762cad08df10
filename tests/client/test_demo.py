"""The demo: as `make demo` runs it, and what it says when it cannot go on."""

from __future__ import annotations

import json
import os
import secrets
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from woodcock.scene import load
from woodcock_client import Client
from woodcock_client.demo import EXAMPLES, render

if TYPE_CHECKING:
    from .service import Service

COMMAND = [sys.executable, "-m", "woodcock_client.demo"]
MARK = "WOODCOCK_TEST_MARK"


@pytest.fixture
def environment() -> Iterator[dict[str, str]]:
    """For the demo's process; no process that inherits it may be left when the test ends."""
    mark = secrets.token_hex(8)
    yield {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "COLUMNS": "200", MARK: mark}
    left = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={mark}".encode() in (process / "environ").read_bytes():
                left.append((process / "cmdline").read_bytes().replace(b"\0", b" "))
        except OSError:  # another user's, or gone
            continue
    assert left == []


@pytest.fixture
def arguments(tmp_path: Path, scene_json: dict[str, Any]) -> list[str]:
    """A tiny scene of a volume to upload, and one without."""
    scenes = tmp_path / "scenes"
    scenes.mkdir()
    small = {**scene_json, "film": {"width": 16, "height": 16}, "stop": {"kind": "samples", "samples": 4}}
    (scenes / "box.json").write_text(json.dumps(small))
    values = b"\x93NUMPY\x01\x00" + (118).to_bytes(2, "little")
    header = "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 2)}"
    (scenes / "cube.npy").write_bytes(values + header.ljust(117).encode() + b"\n" + bytes(range(8)))
    cube = {"kind": "grid", "file": "cube.npy", "albedo": 0.5}
    (scenes / "cube.json").write_text(json.dumps({**small, "volumes": [cube]}))
    return ["--scenes", str(scenes), "--folder", str(tmp_path / "demo")]


def run(arguments: list[str], environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    command = [*COMMAND, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment, check=False)


def test_renders_every_scene_and_ends(arguments: list[str], environment: dict[str, str], tmp_path: Path) -> None:
    done = run([*arguments, "--once"], environment)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("succeeded 100%") == 2
    for name in ("box", "cube"):
        assert (tmp_path / f"demo/{name}.exr").read_bytes().startswith(b"v/1\x01")
        assert (tmp_path / f"demo/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert json.loads((tmp_path / f"demo/{name}.report.json").read_text())
        assert str(tmp_path / f"demo/{name}.exr") in done.stdout


def test_scenes_whose_data_is_there_are_rendered_too(
    arguments: list[str], environment: dict[str, str], tmp_path: Path
) -> None:
    scenes, data = tmp_path / "scenes/data", tmp_path / "mine"
    scenes.mkdir()
    data.mkdir()
    (tmp_path / "scenes/box.json").unlink()
    cube = json.loads((tmp_path / "scenes/cube.json").read_text())
    (tmp_path / "scenes/cube.npy").rename(data / "cube.npy")
    (tmp_path / "scenes/cube.json").rename(scenes / "here.json")
    fire = {**cube["volumes"][0], "file": "fire.vdb", "albedo_grid": {"file": "cube.npy"}}
    sky = {"kind": "image", "file": "sky.exr"}
    (scenes / "there.json").write_text(json.dumps({**cube, "volumes": [fire], "lights": [sky]}))
    done = run([*arguments, "--once", "--data", str(data)], environment)
    assert done.returncode == 0, done.stderr
    left_out = [line for line in done.stdout.splitlines() if "left out" in line]
    assert left_out == [f"there is left out, for there is no {data}/fire.vdb and no {data}/sky.exr."]
    assert {path.name for path in (tmp_path / "demo").glob("*.exr")} == {"here.exr"}


def test_data_must_be_a_folder(arguments: list[str], environment: dict[str, str], tmp_path: Path) -> None:
    done = run([*arguments, "--data", str(tmp_path / "none")], environment)
    assert (done.returncode, done.stderr) == (2, f"demo: --data {tmp_path}/none: is not a folder\n")
    assert not (tmp_path / "demo").exists()


def test_examples_have_names_of_their_own() -> None:
    names = [path.stem for path in EXAMPLES.rglob("*.json")]
    assert len(set(names)) == len(names)


def test_serves_until_it_is_interrupted(arguments: list[str], environment: dict[str, str]) -> None:
    command = [*COMMAND, *arguments]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        last = next(line for line in process.stdout if "until Ctrl-C" in line)
        with Client(last.split()[4]) as client:
            assert {job.state for job in client.jobs()} == {"succeeded"}
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 0
        assert "Traceback" not in process.stderr.read()


def test_says_what_is_missing_to_render(arguments: list[str], environment: dict[str, str], tmp_path: Path) -> None:
    done = run([*arguments, "--once"], {**environment, "PATH": str(tmp_path)})
    assert done.returncode == 1
    assert done.stderr.startswith("demo: there is nothing to render on: PoCL needs a linker and found no `ld`")


def test_a_bad_scene_starts_nothing(arguments: list[str], environment: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "scenes/bad.json").write_text("{}")
    done = run(arguments, environment)
    assert done.returncode == 2
    assert done.stderr.startswith(f"demo: {tmp_path}/scenes/bad.json: camera: is required\n")
    assert not (tmp_path / "demo").exists()


def test_a_failed_render_is_told_of_and_the_others_go_on(
    renders: Service, scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    add = renders.add

    def failing(scene: dict[str, Any], name: str = "") -> str:
        if name != "bad":
            return add(scene, name)
        id = type(renders).add(renders, scene, name)
        threading.Timer(0.1, renders.update, [id], {"state": "failed", "error": "the compiler gave up"}).start()
        return id

    renders.add = failing  # type: ignore[method-assign]
    with Client(renders.url) as client:
        assert not render(client, {"bad": load(scene_file), "good": load(scene_file)}, tmp_path)
        assert "bad failed: the compiler gave up" in capsys.readouterr().err
        assert (tmp_path / "good.exr").exists()
        assert not (tmp_path / "bad.exr").exists()
