"""How much of its devices' time a farm uses: with real processes and devices that take a fixed time, and beyond these
by simulation.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import psutil
import pytest

from woodcock.device import find
from woodcock.render import Renderer
from woodcock.scene import parse

from .harness import Farm
from .simulation import Costs, efficiency
from .test_farm import ended

#: Seconds that a range takes, and samples that it has.
RANGE, PIECE = 1.0, 64
#: For each device.
RANGES = 30

PIECES = f"from woodcock_server import rounds\nrounds.share = lambda *_: {PIECE}\n"

#: Devices that sleep in place of rendering.
SIMULATED = f"""\
import json, os, time
import numpy as np
from woodcock.device import Device
from woodcock.film import Film
from woodcock.probe import Probe
from woodcock_server import worker as functions
from woodcock_server.devices.service import Found
from woodcock_server.farm import command

def discover(host):
    names = dict.fromkeys(("name", "platform", "platform_version", "version", "driver"), "simulated")
    numbers = dict.fromkeys(("compute_units", "memory", "max_allocation", "native_lanes"), 1 << 30)
    devices = (Device(id=f"cpu{{n}}", kind="cpu", doubles=True, **names, **numbers)
               for n in range(int(os.environ["SIMULATED"])))
    return [Found(device, Probe((1,), None), device.id.zfill(64), host) for device in devices]

def prepare(scene, device_id, own):
    return json.loads(os.environ["FACTS"]), "cached"

def render_range(scene, device_id, start, stop, pixels):
    began = time.perf_counter()
    time.sleep({RANGE})
    mean = np.ones((16, 16, 1))
    film = Film(np.full((16, 16), stop - start, np.uint32), mean, 0.1 * mean, ("Y",), ((start, stop),))
    return film, time.perf_counter() - began, "simulated"

def certify(scene, device_id):
    raise RuntimeError("a simulated device has no evidence")

command.discover = discover
for function in (prepare, render_range, certify):
    setattr(functions, function.__name__, function)
    function.__module__ = functions.__name__
"""


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize(("workers", "least"), [(1, 0.95), (2, 0.95), (4, 0.95), (64, 0.85)])
def test_a_farm_uses_its_devices(
    farm: Farm,
    make_scene: Callable[..., dict[str, Any]],
    workers: int,
    least: float,
    capsys: pytest.CaptureFixture[str],
) -> None:
    scene = make_scene(samples=PIECE * RANGES * workers)
    facts = json.dumps(Renderer(parse(json.dumps(scene)), find()).facts())
    service = farm.start_service(prelude=PIECES)
    farm.start_worker("node", SIMULATED, SIMULATED=str(workers), FACTS=facts)
    farm.wait_for(service, *(f"cpu{number}@node" for number in range(workers)), seconds=400)
    assert service.process is not None
    before = sum(psutil.Process(service.process.pid).cpu_times()[:2])
    job_id = service.submit(scene)
    job = service.wait(job_id, ended, 300)
    took = sum(psutil.Process(service.process.pid).cpu_times()[:2]) - before
    report = service.http.get(f"/api/v1/jobs/{job_id}/report.json").json()
    assert report["sample_ranges"] == [[0, scene["stop"]["samples"]]]
    reached = RANGES * RANGE / report["seconds"]["render"]
    with capsys.disabled():
        cost = 1e3 * took / (RANGES * workers)
        print(f"\n{workers} workers: efficiency {reached:.3f}, {cost:.2f} ms of the service's processor a range")
    assert job["state"] == "succeeded"
    assert reached >= least


# By simulation

#: The sum is what 64 workers took, "Beyond one machine" in server/README.md; the share of merging is assumed.
MEASURED = Costs(range=1.0, handing=0.0062, merging=0.0005)


def test_a_simulated_farm_without_costs_wastes_nothing() -> None:
    assert efficiency(100, 10, Costs(1.0, 0.0, 0.0)) == 1.0


def test_the_dispatcher_is_the_bottleneck() -> None:
    """It serves as many devices as it has ranges' worth of time; beyond them throughput stays."""
    assert efficiency(100, 30, MEASURED) > 0.95
    most = MEASURED.range / (MEASURED.handing + MEASURED.merging)
    reached = 1000 * efficiency(1000, 30, MEASURED)
    assert 0.9 * most < reached < 1.1 * most


def test_a_tree_of_merges_serves_ten_thousand_devices() -> None:
    assert efficiency(10_000, 10, MEASURED) < 0.03
    assert efficiency(10_000, 30, MEASURED, fan_in=16) > 0.95
