"""Devices of worker hosts that hang, or take all memory: as on one machine (tests/server/test_lost_devices.py)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.server.test_lost_devices import PRELUDE, device, ended, failure

from .harness import Farm

Make = Callable[..., dict[str, Any]]

pytestmark = pytest.mark.slow


def test_a_remote_device_that_hangs_is_killed_and_quarantined(farm: Farm, make_scene: Make, tmp_path: Path) -> None:
    fault = tmp_path / "fault"
    service = farm.start_service(WOODCOCK_RANGE_SECONDS="45")
    farm.start_worker("node1", PRELUDE, POCL_DEVICES="pthread basic", FAULT=str(fault))
    farm.wait_for(service, "cpu0@node1", "cpu1@node1")
    for id in ("cpu0@node1", "cpu1@node1"):
        service.wait(service.submit(make_scene(samples=1), id), ended, 180)
    for number in (1, 2):
        fault.write_text("hang")
        says = failure(service, service.submit(make_scene(samples=8), "cpu1@node1"))
        fault.unlink()
        assert says == "cpu1@node1 did not end rendering samples 0 to 0 within 45 s, and its process was killed."
        if number == 1:
            assert device(service, "cpu1@node1")["state"] == "ready", "the job may have been at fault itself"
    assert device(service, "cpu1@node1")["state"] == "distrusted"
    after = service.wait(service.submit(make_scene(samples=4)), ended)
    assert after["devices"] == ["cpu0@node1"]
    # It is checked by itself, in a new process.
    service.wait(after["id"], lambda _: device(service, "cpu1@node1")["state"] == "ready", 90)
    service.wait(service.submit(make_scene(samples=4), "cpu1@node1"), ended, 120)


def test_a_remote_worker_that_takes_too_much_memory_says_how_much_its_host_allows(farm: Farm, make_scene: Make) -> None:
    service = farm.start_service()
    farm.start_worker("node1", WOODCOCK_WORKER_MEMORY="700MiB")
    farm.wait_for(service, "cpu0@node1")
    says = failure(service, service.submit(make_scene(size=8192, samples=1), "cpu0@node1"))
    assert says.startswith("The process that renders on cpu0@node1 died 4 times")
    assert says.endswith("It is killed when it takes more than 700 MiB.")
