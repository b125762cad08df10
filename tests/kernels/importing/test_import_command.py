"""The command `import` as a user runs it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from tests.kernels.importing.scenes import mitsuba, pbrt


def woodcock(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "woodcock_client.cli", "import", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def test_a_scene_is_written_and_what_it_loses_is_said(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(mitsuba('<shape type="cube"/><shape type="sphere"/>\n<shape type="hair"/>'))
    done = woodcock(tmp_path / "scene.xml", "-o", tmp_path / "out.json")
    assert done.returncode == 0
    assert done.stdout.split() == [str(tmp_path / "out.json"), str(tmp_path / "out.cube.ply")]
    assert done.stderr == (
        'woodcock: scene.xml:3: left out: the shape "hair"; sphere, rectangle, disk, cube, ply and obj are known\n'
    )
    assert json.loads((tmp_path / "out.json").read_text())["surfaces"][1]["kind"] == "sphere"


@pytest.mark.parametrize("text", [mitsuba(""), pbrt('Shape "curve"'), "hello"])
def test_what_is_no_scene_is_one_sentence(tmp_path: Path, text: str) -> None:
    (tmp_path / "scene").write_text(text)
    done = woodcock(tmp_path / "scene", "-o", tmp_path / "out.json")
    assert done.returncode == 2
    assert done.stdout == ""
    assert all(line.startswith("woodcock: ") for line in done.stderr.splitlines())
    assert not (tmp_path / "out.json").exists()


def test_bad_usage(tmp_path: Path) -> None:
    (tmp_path / "scene.pbrt").write_text(pbrt('Shape "sphere"'))
    for source, output, message in (
        ("scene.pbrt", "out.txt", "the name must end in .json"),
        ("scene.pbrt", "no/out.json", "no is not a folder"),
        ("no.pbrt", "out.json", "No such file or directory"),
    ):
        done = woodcock(tmp_path / source, "-o", tmp_path / output)
        assert done.returncode == 2
        assert message in done.stderr


def test_files_are_named_from_where_the_scene_is_written(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    ball = '<shape type="obj"><string name="filename" value="ball.obj"/></shape>'
    (tmp_path / "in" / "scene.xml").write_text(mitsuba(ball))
    (tmp_path / "in" / "ball.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n")
    done = woodcock(tmp_path / "in" / "scene.xml", "-o", tmp_path / "out" / "scene.json")
    assert done.stderr == "woodcock: scene.xml:2: reflects on both sides here; from behind Mitsuba's is black\n"
    scene = json.loads((tmp_path / "out" / "scene.json").read_text())
    assert scene["surfaces"][0]["file"] == "../in/ball.obj"
