"""Devices are listed, checked in child processes, and what is missing is said in a sentence."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from woodcock.device import WIDTHS, Context, Device, DeviceError, devices, find
from woodcock.evaluate import evaluate
from woodcock.probe import Probe, best_lanes, check, probe


def test_devices_have_distinct_ids() -> None:
    found = devices()
    assert len({device.id for device in found}) == len(found)
    assert all(find(device.id) == device for device in found)
    assert find() == found[0]


def test_an_unknown_device_names_the_known() -> None:
    with pytest.raises(DeviceError, match=r"there is no device 'gpu77'; there are .*cpu0"):
        find("gpu77")


def test_probe_finds_widths_that_work(device: Device) -> None:
    result = probe(device)
    assert result.fault is None
    assert 1 in result.lanes
    assert list(result.lanes) == sorted(set(result.lanes) & set(WIDTHS))
    assert best_lanes(device, result) in result.lanes
    assert best_lanes(replace(device, native_lanes=4), Probe((1, 4, 8), None)) == 4
    with pytest.raises(DeviceError, match="broken"):
        best_lanes(device, Probe((), "broken"))


def test_the_check_notices_a_wrong_builtin(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(*arguments: object, **keys: object) -> np.ndarray:
        return evaluate(*arguments, **keys) * np.float32(1.001)  # type: ignore[arg-type]

    check(device, 1)
    monkeypatch.setattr("woodcock.probe.evaluate", wrong)
    with pytest.raises(DeviceError, match="is wrong on"):
        check(device, 1)


def test_a_program_that_does_not_build_is_a_device_error(context: Context) -> None:
    with pytest.raises(DeviceError, match="cannot build the program"):
        context.build("__kernel void broken() { nonsense; }", (), "broken")
    with pytest.raises(DeviceError, match="cannot build the program"):
        context.build("__kernel void here() {}", (), "there")


def test_a_buffer_too_large_is_refused_before_the_driver_sees_it(device: Device) -> None:
    small = Context.on(replace(device, max_allocation=1 << 20))
    with pytest.raises(DeviceError, match="takes 1 MiB in one piece; the volume needs 2 MiB"):
        small.upload(np.zeros(1 << 21, np.uint8))


def python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.usefixtures("pocl")
def test_without_a_linker_the_sentence_says_what_to_install(tmp_path: Path) -> None:
    """PoCL would take the process with it."""
    done = python("from woodcock.probe import *; print(probe(find()).fault)", PATH=str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "PoCL needs a linker" in done.stdout
    assert "apt install" in done.stdout


@pytest.mark.usefixtures("pocl")
def test_without_the_libraries_to_link_with(tmp_path: Path) -> None:
    """A linker that says what the real one does then; PoCL aborts its process."""
    linker = tmp_path / "ld"
    linker.write_text("#!/bin/sh\necho '/usr/bin/ld: cannot find -lgcc: No such file or directory' >&2\nexit 1\n")
    linker.chmod(0o755)
    done = python(
        "from woodcock.probe import *; print(probe(find()).fault)",
        PATH=f"{tmp_path}:{os.environ['PATH']}",
        XDG_CACHE_HOME=str(tmp_path),
        POCL_CACHE_DIR=str(tmp_path),
    )
    sentence = "PoCL cannot link kernels, for `ld` does not find libgcc: apt install gcc libc6-dev"
    assert done.stdout.strip().endswith(sentence)


def test_without_a_platform_the_sentence_says_what_to_install(tmp_path: Path) -> None:
    done = python(
        "import pyopencl as cl; cl.get_platforms = lambda: []\n"
        "from woodcock.device import *\ntry: find()\nexcept DeviceError as e: print(e)"
    )
    assert done.stdout.startswith("no OpenCL platform was found: pip install")


def test_a_home_that_cannot_be_written_does_not_matter(tmp_path: Path) -> None:
    done = python(
        "from woodcock.device import cache_folder; f = cache_folder(); (f / 'x').touch(); (f / 'x').unlink(); print(f)",
        HOME="/proc/none",
        XDG_CACHE_HOME="/proc/none",
        TMPDIR=str(tmp_path),
    )
    assert done.stdout.strip().startswith(str(tmp_path)), done.stderr
