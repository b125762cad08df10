"""A farm on hosts with networks of their own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import psutil
import pytest
from tests.server.conftest import Service

from woodcock.image import read_exr

from .harness import PIECES, SLOWLY, Farm
from .network import Network, fault
from .test_farm import ended

Make = Callable[..., dict[str, Any]]

pytestmark = pytest.mark.slow

SAMPLES = 64 * 24


def picture(service: Service, job_id: str) -> dict[str, np.ndarray]:
    """Layers, after a look at what the report says of samples."""
    report = service.http.get(f"/api/v1/jobs/{job_id}/report.json").json()
    assert (report["samples"], report["sample_ranges"]) == (SAMPLES, [[0, SAMPLES]])
    assert sum(use["samples"] for use in report["devices"]) == SAMPLES
    layers, _ = read_exr(service.data / "jobs" / job_id / "image.exr")
    return layers


def alike(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> None:
    """The same samples, each once; only the order in which sums were added up may differ, in double precision."""
    assert one.keys() == other.keys()
    for name, layer in one.items():
        np.testing.assert_allclose(layer, other[name], rtol=1e-6, err_msg=name)


@pytest.fixture
def scene(make_scene: Make) -> dict[str, Any]:
    return make_scene(size=32, samples=SAMPLES)


@pytest.fixture
def running(hosts: Farm, scene: dict[str, Any]) -> Service:
    """Two worker hosts, and programs that are built."""
    service = hosts.start_service(prelude=PIECES)
    for name in ("node1", "node2"):
        hosts.start_worker(name, SLOWLY)
    hosts.wait_for(service, "cpu0@node1", "cpu0@node2", seconds=90)
    for name in ("node1", "node2"):
        service.wait(service.submit({**scene, "stop": {"kind": "samples", "samples": 1}}, f"cpu0@{name}"), ended, 120)
    return service


def test_the_machines_own_network_stays_as_it_is() -> None:
    """Browsers, for one, break off what they do where it changes."""
    if reason := fault():
        pytest.skip(f"separate hosts cannot be had here: {reason}")
    before, network = psutil.net_if_addrs(), Network("one", "other")
    with network.made():
        assert psutil.net_if_addrs() == before
        with network.being("one"):
            assert psutil.net_if_addrs()["eth0"][0].address == network.addresses["one"]
    assert psutil.net_if_addrs() == before


def test_two_hosts_render_the_picture_of_one(hosts: Farm, running: Service, scene: dict[str, Any]) -> None:
    one, two = (running.submit(scene, device) for device in ("cpu0@node1", "any"))
    assert running.wait(one, ended, 120)["devices"] == ["cpu0@node1"]
    assert set(running.wait(two, ended, 120)["devices"]) == {"cpu0@node1", "cpu0@node2"}
    alike(picture(running, two), picture(running, one))
