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
from woodcock_server.ranges import FILM, HANDING_SECONDS, LONGEST_SECONDS, length, turn_of

from .harness import Farm
from .simulation import Costs, efficiency
from .test_farm import ended

#: Seconds that a range takes, and samples that it has.
RANGE, PIECE = 1.0, 64
#: For each device.
RANGES = 30

PIECES = f"from woodcock_server import rounds\nrounds.share = lambda *_: {PIECE}\n"

#: Devices that sleep in place of rendering, for as long as the samples take that they are asked for.
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
    time.sleep({RANGE / PIECE} * (stop - start))
    seconds, film = time.perf_counter() - began, json.loads(scene)["film"]
    mean = np.ones((film["height"], film["width"], 1))
    count = np.full(mean.shape[:2], stop - start, np.uint32)
    return Film(count, mean, 0.1 * mean, ("Y",), ((start, stop),)), seconds, "simulated"

def certify(scene, device_id):
    raise RuntimeError("a simulated device has no evidence")

command.discover = discover
for function in (prepare, render_range, certify):
    setattr(functions, function.__name__, function)
    function.__module__ = functions.__name__
"""


def rendered(
    farm: Farm, scene: dict[str, Any], workers: int, prelude: str, seconds: float = RANGES * RANGE
) -> tuple[float, float, float]:
    """The scene, by so many simulated devices on up to four hosts, each for so many seconds: which part of its time a
    device renders, and how many seconds of processor time service and scheduler take."""
    scene["stop"] = {"kind": "samples", "samples": round(seconds / RANGE) * PIECE * workers}
    facts = json.dumps(Renderer(parse(json.dumps(scene)), find()).facts())
    service = farm.start_service(prelude=prelude)
    nodes = [f"node{number}" for number in range(1, min(workers, 4) + 1)]
    each = workers // len(nodes)
    for node in nodes:
        farm.start_worker(node, SIMULATED, SIMULATED=str(each), FACTS=facts)
    devices = (f"cpu{number}@{node}" for node in nodes for number in range(each))
    farm.wait_for(service, *devices, seconds=400)
    assert service.process is not None
    processes = [psutil.Process(pid) for pid in (service.process.pid, farm.scheduler.process.pid)]
    before = [sum(process.cpu_times()[:2]) for process in processes]
    job_id = service.submit(scene)
    job = service.wait(job_id, ended, 300)
    assert job["state"] == "succeeded"
    taken = [sum(process.cpu_times()[:2]) - each for process, each in zip(processes, before, strict=True)]
    report = service.http.get(f"/api/v1/jobs/{job_id}/report.json").json()
    assert report["sample_ranges"] == [[0, scene["stop"]["samples"]]]
    return seconds / report["seconds"]["render"], taken[0], taken[1]


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize(("workers", "least"), [(1, 0.95), (2, 0.95), (4, 0.95), (64, 0.85)])
def test_a_farm_uses_its_devices(
    hosts: Farm,
    make_scene: Callable[..., dict[str, Any]],
    workers: int,
    least: float,
    capsys: pytest.CaptureFixture[str],
) -> None:
    reached, *taken = rendered(hosts, make_scene(), workers, PIECES)
    with capsys.disabled():
        service, scheduler = (1e3 * each / (RANGES * workers) for each in taken)
        print(f"\n{workers} workers: efficiency {reached:.3f}; ", end="")
        print(f"a range takes {service:.2f} ms of the service's processor, {scheduler:.2f} ms of the scheduler's")
    assert reached >= least


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("longest", [RANGE, LONGEST_SECONDS])
def test_ranges_get_longer_for_large_pictures(
    hosts: Farm, make_scene: Callable[..., dict[str, Any]], longest: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """With ranges of a second the dispatcher would be busy with films of so many pixels all the time."""
    scene = make_scene()
    scene["film"] |= {"width": 1920, "height": 1080}
    fixed = f"from woodcock_server import rendering\nrendering.LONGEST_SECONDS = {longest}\n"
    reached, service, _ = rendered(hosts, scene, 16, fixed, seconds=120.0)
    with capsys.disabled():
        print(f"\n16 workers, 1920 × 1080, ranges of at most {longest:g} s: efficiency {reached:.3f}, {service:.0f} s")
    assert reached < 0.85 if longest == RANGE else reached > 0.85


# By simulation

#: Seconds that merging a film takes: of the smallest pictures, and of 1920 × 1080 pixels ("Scale" in server/scale.md).
SMALL, LARGE = 0.0, 0.045


def costs(devices: int, merging: float, seconds: float | None = None) -> Costs:
    """As a dispatcher has them that serves so many devices; seconds: of a range, if not of its own choice."""
    return Costs(seconds or length(turn_of(devices, merging)), HANDING_SECONDS, FILM * merging)


def test_a_simulated_farm_without_costs_wastes_nothing() -> None:
    assert efficiency(100, 10, Costs(1.0, 0.0, 0.0)) == 1.0


@pytest.mark.parametrize(("merging", "most"), [(SMALL, 167), (LARGE, 8)])
def test_the_dispatcher_is_the_bottleneck_of_short_ranges(merging: float, most: int) -> None:
    """It serves as many devices as it has ranges' worth of time; beyond them throughput stays."""
    assert efficiency(most * 9 // 10, 30, costs(most, merging, 1.0)) > 0.9
    reached = 10 * most * efficiency(10 * most, 30, costs(most, merging, 1.0))
    assert reached == pytest.approx(most, rel=0.1)


@pytest.mark.parametrize(("merging", "devices"), [(SMALL, 5000), (LARGE, 250)])
def test_longer_ranges_serve_as_many_as_a_minute_allows(merging: float, devices: int) -> None:
    assert efficiency(devices, 30, costs(devices, merging)) > 0.9
    assert length(turn_of(devices, merging)) == pytest.approx(LONGEST_SECONDS, rel=0.05)


@pytest.mark.parametrize("merging", [SMALL, LARGE])
def test_a_tree_of_merges_serves_ten_thousand_devices(merging: float) -> None:
    large = merging == LARGE
    assert efficiency(10_000, 30, costs(10_000, merging)) < (0.1 if large else 0.97)
    assert efficiency(10_000, 30, costs(10_000, merging), fan_in=16) > 0.95
