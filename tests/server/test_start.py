"""What a service does about compilers: the generic program is built in the background, and begins where the scene's own
is not built; the report names both.
"""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from woodcock.image import read_exr

from .conftest import Service

Make = Callable[..., dict[str, Any]]


@pytest.fixture
def fresh(tmp_path: Path) -> dict[str, str]:
    """Caches of one test, with nothing in them, and one device."""
    (tmp_path / "pocl").mkdir()
    return {
        "XDG_CACHE_HOME": str(tmp_path), "POCL_CACHE_DIR": str(tmp_path / "pocl"), "POCL_DEVICES": "pthread",
        "WOODCOCK_PREPARE": "1",
    }  # fmt: skip


def builds(service: Service) -> list[psutil.Process]:
    assert service.process is not None
    found = psutil.Process(service.process.pid).children(recursive=True)
    return [child for child in found if "woodcock.start" in child.cmdline()]


@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGKILL])
def test_no_build_outlives_its_service(tmp_path: Path, fresh: dict[str, str], sent: signal.Signals) -> None:
    service = Service(tmp_path / "data", **fresh)
    service.start()
    deadline = time.monotonic() + 60
    while not (under_way := builds(service)):
        assert time.monotonic() < deadline, service.log.read_text()
        time.sleep(0.05)
    began = time.monotonic()
    service.stop(sent)
    gone, _ = psutil.wait_procs(under_way, timeout=20)
    assert gone == under_way
    assert time.monotonic() - began < 20
    assert "Traceback" not in service.log.read_text()


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_picture_that_the_generic_program_began(tmp_path: Path, fresh: dict[str, str], make_scene: Make) -> None:
    service = Service(tmp_path / "data", **fresh)
    service.start()
    try:
        deadline = time.monotonic() + 600
        while "generic program ready" not in service.log.read_text():
            assert time.monotonic() < deadline, service.log.read_text()
            time.sleep(0.1)
        mirror = {"kind": "disk", "center": [0.5, 1, 0.5], "normal": [0, -1, 0], "radius": 2}
        scene = make_scene(size=128, stop={"kind": "seconds", "seconds": 40}, surfaces=[mirror])
        job = service.wait(service.submit(scene), lambda job: job["state"] == "succeeded", 300)
        again = service.wait(service.submit(scene | {"seed": 9, "stop": {"kind": "samples", "samples": 8}}),
                             lambda job: job["state"] == "succeeded", 300)  # fmt: skip
        first, second = (service.http.get(one["links"]["report"]).raise_for_status().json() for one in (job, again))
        picture = service.http.get(job["links"]["image"]).raise_for_status().content
    finally:
        service.stop()
    (use,) = first["devices"]
    assert len(use["programs"]) == 2
    assert sum(use["programs"].values()) == first["samples"] == job["samples"]
    assert use["program_hash"] == list(use["programs"])[1], "the scene's own came second"
    assert use["evidence"]["checks"]
    build = next(line for line in first["certificate"]["lines"] if line["name"] == "build")
    assert "the generic program rendered" in build["says"]
    path = tmp_path / "image.exr"
    path.write_bytes(picture)
    layers, header = read_exr(path)
    assert (layers["samples.count"] == job["samples"]).all()
    assert np.isfinite(layers["Y"]).all()
    assert str(header["programHash"]).split(", ") == list(use["programs"])
    assert json.loads(str(header["sampleRanges"])) == [[0, job["samples"]]]
    assert list(second["devices"][0]["programs"]) == [use["program_hash"]], "it is built now"
