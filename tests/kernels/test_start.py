"""Markers of what is built, builds in child processes, and the swap from the generic program to the scene's own."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import time
import weakref
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import pytest
from tests.analytic.scenes import same
from tests.conftest import Picture, described

from woodcock import markers
from woodcock.device import Device
from woodcock.markers import built, is_built, is_wide
from woodcock.plan import lay_out
from woodcock.probe import best_lanes, probe
from woodcock.program import Program
from woodcock.render import Renderer, program_of, read_file
from woodcock.start import Build, Start

Scene = dict[str, Any]
TEXT = Program("__kernel void render() {}", 8)


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """No markers of this process; those of child processes, and the driver's cache, stay where they are."""
    monkeypatch.setattr(markers, "cache_folder", lambda: tmp_path)
    return tmp_path


@pytest.fixture
def clouds(box: Scene) -> Scene:
    """Two media: too much for the small loop."""
    medium = box["volumes"][0] | {"albedo": 0.8}
    other = medium | {"shape": {"kind": "sphere", "center": [0.5] * 3, "radius": 0.4}}
    return box | {"volumes": [medium, other]}


def program(scene: Scene, device: Device) -> Program:
    layout = lay_out(described(scene), read_file)
    return program_of(layout, device, best_lanes(device, probe(device)))[0]


# Markers


def test_a_program_counts_as_built_once_it_was_launched(box: Scene, device: Device, fresh: Path) -> None:
    own = program(box, device)
    assert not is_built(device, own)
    assert Renderer(described(box), device).program_hash == own.hash
    assert is_built(device, own)
    assert is_built(device, program(box | {"seed": 8}, device)), "numbers make no program"


def test_a_marker_is_of_a_program_on_a_device(device: Device, fresh: Path) -> None:
    built(device, TEXT)
    built(device, TEXT)
    assert is_built(device, TEXT)
    assert not is_built(device, replace(TEXT, text=TEXT.text + "\n"))
    assert not is_built(replace(device, driver="another"), TEXT)
    assert is_built(replace(device, id="cpu7"), TEXT), "devices of one make share their driver's cache"


def test_large_pictures_have_markers_of_their_own(device: Device, fresh: Path) -> None:
    large = 1 << 20
    assert is_wide(large, 8)
    assert not is_wide(512 * 512, 8)
    built(device, TEXT, 512 * 512)
    assert is_built(device, TEXT)
    assert not is_built(device, TEXT, large)
    built(device, TEXT, large)
    assert is_built(device, TEXT, large)


@pytest.mark.usefixtures("pocl")
def test_a_large_picture_compiles_nothing_when_it_renders(box: Scene, device: Device, tmp_path: Path) -> None:
    """The reason for those: PoCL has a program of its own for large launches."""
    lanes = best_lanes(device, probe(device))
    scene = box | {"film": {"width": 1024, "height": 64 * lanes}, "lights": []}
    code = (
        "import sys\nfrom pathlib import Path\nfrom woodcock.device import find\nfrom woodcock.render import Renderer\n"
        "from woodcock.scene import parse\n"
        "def files(): return sorted(path.name for path in Path(sys.argv[1]).rglob('*goffs*'))\n"
        f"renderer = Renderer(parse(sys.stdin.read()), find({device.id!r}))\n"
        "before = files()\nrenderer.render(0, 1)\nassert before == files() != [], (before, files())\nprint(before)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, tmp_path],
        input=json.dumps(scene),
        env={**os.environ, "POCL_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


# Child processes


def ended(build: Build) -> str | None:
    build.wait(120)
    assert not build.running
    return build.fault()


def test_a_child_builds_what_another_process_finds_built(box: Scene, device: Device) -> None:
    assert ended(Build(device, described(box))) is None
    assert is_built(device, program(box, device))


def test_a_child_that_fails_says_why(
    box: Scene, device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fault = ended(Build(replace(device, id="gpu77"), described(box)))
    assert fault
    assert fault.startswith("the build failed (exit 1): there is no device 'gpu77'")
    lost = described(box | {"volumes": [{"kind": "grid", "file": str(tmp_path / "lost.npy"), "albedo": 0.5}]})
    assert "lost.npy" in (ended(Build(device, lost)) or "")
    monkeypatch.setenv("PATH", str(tmp_path))
    if "Portable Computing Language" in device.platform:
        assert "PoCL needs a linker" in (ended(Build(device, described(box))) or "")


def test_a_child_that_is_killed_has_failed(box: Scene, device: Device) -> None:
    build = Build(device, described(box))
    (child,) = children()
    child.send_signal(signal.SIGKILL)
    assert ended(build) == "the build failed (ended by SIGKILL): no message"


def test_a_child_that_takes_too_long_is_ended(device: Device) -> None:
    build = Build(device, None)
    build.wait(0.01)
    assert not build.running
    assert build.fault() == "the build failed (ended by SIGKILL): no message"


def test_a_child_ends_with_what_asked_for_it(device: Device) -> None:
    build = Build(device, None)
    (child,) = children()
    del build
    assert not child.is_running()


def test_no_child_outlives_a_process_that_is_killed(device: Device, tmp_path: Path) -> None:
    """In the middle of the longest build there is, with nothing in any cache."""
    code = (
        "import sys, time\nfrom woodcock.device import find\nfrom woodcock.start import Build\n"
        f"build = Build(find({device.id!r}), None)\nprint('begun', flush=True)\ntime.sleep(600)"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path), "POCL_CACHE_DIR": str(tmp_path)}
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, env=environment) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == b"begun\n"
        (child,) = psutil.Process(parent.pid).children()
        time.sleep(5)  # it compiles now
        assert child.is_running()
        parent.kill()
    gone, _ = psutil.wait_procs([child], timeout=20)
    assert gone


def children() -> list[psutil.Process]:
    return [child for child in psutil.Process().children() if "woodcock.start" in child.cmdline()]


# The swap


def test_without_a_ready_generic_program_the_own_one_begins(clouds: Scene, device: Device, fresh: Path) -> None:
    start = Start(described(clouds), device)
    assert start.own
    assert not start.swap()
    assert start.settled() is start.renderer
    assert start.renderer.program_hash == program(clouds, device).hash
    assert children() == []


@pytest.fixture
def generic(clouds: Scene, device: Device, fresh: Path) -> str:
    """The generic program is built, and nothing else; its hash."""
    return Renderer(described(clouds), device, full=True).program_hash


@pytest.mark.slow
def test_small_programs_are_not_waited_for(box: Scene, device: Device, generic: str) -> None:
    assert Start(described(box), device).own


@pytest.mark.slow
def test_the_own_program_is_swapped_in(clouds: Scene, device: Device, generic: str, picture: Picture) -> None:
    start = Start(described(clouds), device)
    assert not start.own
    assert start.renderer.program_hash == generic
    began = weakref.ref(start.renderer)
    film = start.renderer.render(0, 16)
    deadline = time.monotonic() + 240
    while not start.swap():
        assert time.monotonic() < deadline, "the build does not end"
        time.sleep(0.1)
    assert start.own
    assert began() is None, "its memory on the device is free again"
    assert start.renderer.program_hash == program(clouds, device).hash != generic
    assert set(start.renderer.seconds) == {"read", "build", "upload"}
    film = film.merge(start.renderer.render(16, 64))
    assert film.ranges == ((0, 64),)
    assert (film.count == 64).all()
    same(film, picture(clouds | {"seed": 8}, 256))
    assert not start.swap()
    assert Start(described(clouds), device).own, "it is known now"


@pytest.mark.slow
@pytest.mark.usefixtures("pocl")
def test_where_the_own_program_cannot_be_built_the_generic_one_goes_on(
    clouds: Scene,
    device: Device,
    generic: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    start = Start(described(clouds), device)
    with monkeypatch.context() as patch, caplog.at_level(logging.WARNING):
        patch.setenv("PATH", str(tmp_path))
        with pytest.raises(RuntimeError, match="did not build the scene's own program"):
            start.settled()
    assert "goes on with the generic program: the build failed (exit 1): PoCL needs a linker" in caplog.text
    assert not start.own
    assert not start.swap()
    assert start.renderer.program_hash == generic
    assert (start.renderer.render(0, 4).count == 4).all()
