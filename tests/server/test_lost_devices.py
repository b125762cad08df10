"""Devices that hang, crash or take all memory cost a job and no more; one that does so again is quarantined."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import psutil
import pytest

from woodcock_server.cluster import Cluster, ask, embedded
from woodcock_server.config import Settings
from woodcock_server.errands import DeviceLostError, Errands

from .conftest import Service

Make = Callable[..., dict[str, Any]]

#: What the file that FAULT names says befalls cpu1 when it renders: a kernel that does not end, or the process's death.
#: A stability check ends well after a moment.
PRELUDE = """
import os, signal, time
from woodcock_server import worker
from woodcock.render import Renderer

END = \"\"\"__kernel void wait(__global volatile int *a) { while (a[0] == 0); }\"\"\"
render = Renderer.render


def hang(device):
    import numpy as np
    import pyopencl as cl
    from woodcock.device import Context

    context = Context.on(device)
    flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
    buffer = cl.Buffer(context.context, flags, hostbuf=np.zeros(1, np.int32))
    kernel = context.build(END, (), "wait")
    kernel(context.queue, (1,), None, buffer)
    context.queue.finish()


def rendering(self, *args, **kwargs):
    if self.device.id == "cpu1" and os.path.exists(os.environ["FAULT"]):
        hang(self.device) if open(os.environ["FAULT"]).read() == "hang" else os.kill(os.getpid(), signal.SIGKILL)
    return render(self, *args, **kwargs)


Renderer.render = rendering


def check(device):
    time.sleep(2)
    row = {"group": "a", "case": "b", "expected": 1.0, "got": 1.0, "deviation": 0.0, "unit": "roundings", "limit": 1.0}
    return {"rows": [{**row, "verdict": "passed", "says": "", "seconds": 0.0}]}


worker.stability.check = check
"""


def ended(job: dict[str, Any]) -> bool:
    return job["state"] in ("succeeded", "failed")


def failure(service: Service, job_id: str) -> str:
    """The sentence that the job fails with."""
    end = time.monotonic() + 200
    while not ended(job := service.job(job_id)):
        assert time.monotonic() < end, service.log.read_text()
        time.sleep(0.05)
    assert job["state"] == "failed"
    return str(job["error"])


def device(service: Service, id: str) -> dict[str, Any]:
    items: list[dict[str, Any]] = service.http.get("/api/v1/devices").json()["items"]
    return next(item for item in items if item["id"] == id)


@pytest.fixture
def fault(tmp_path: Path) -> Path:
    return tmp_path / "fault"


@pytest.fixture
def frail(tmp_path: Path, fault: Path, make_scene: Make) -> Iterator[Service]:
    """A service whose programs are built."""
    service = Service(tmp_path / "data", PRELUDE, FAULT=str(fault), WOODCOCK_RANGE_SECONDS="45")
    service.start()
    for id in ("cpu0", "cpu1"):
        service.wait(service.submit(make_scene(samples=1), id), ended, 120)
    yield service
    service.stop()


async def late(scratch: Path) -> list[int]:
    """Process ids of a worker before and after it was sent on an errand that takes too long."""
    hasty, patient = (Settings(data=scratch, range_seconds=seconds) for seconds in (0.5, 50))
    async with embedded(["cpu0"], scratch, 4 << 30) as client:
        cluster = Cluster(client, [], nullcontext)
        before = await ask(client, "cpu0", "first", os.getpid)
        errands, others = Errands(cluster, "job", hasty), Errands(cluster, "other", patient)
        errands.scene = others.scene = "{}"
        with pytest.raises(DeviceLostError, match=r"cpu0 did not end a long one within 0\.5 s, and its process was"):
            await errands.in_time("cpu0", errands.send("cpu0", "a long one", sleep))
        await errands.kill("cpu0")
        assert await others.in_time("cpu0", others.send("cpu0", "a short one", described)) == "{} on cpu0"
        return [before, await ask(client, "cpu0", "second", os.getpid)]


def sleep(_scene: str, _device: str) -> None:
    time.sleep(600)


def described(scene: str, device: str) -> str:
    return f"{scene} on {device}"


def test_what_takes_too_long_is_killed(tmp_path: Path) -> None:
    before, after = asyncio.run(asyncio.wait_for(late(tmp_path), 60))
    assert before != after
    assert not psutil.pid_exists(before)


@pytest.mark.slow
def test_a_kernel_that_hangs_is_killed_and_its_device_quarantined(
    frail: Service, fault: Path, make_scene: Make
) -> None:
    for number in (1, 2):
        fault.write_text("hang")
        says = failure(frail, frail.submit(make_scene(samples=8), "cpu1"))
        fault.unlink()
        assert says == "cpu1 did not end rendering samples 0 to 0 within 45 s, and its process was killed."
        if number == 1:
            assert device(frail, "cpu1")["state"] == "ready", "the job may have been at fault itself"
            assert frail.wait(frail.submit(make_scene(samples=4), "cpu0"), ended)["state"] == "succeeded"
    shown = device(frail, "cpu1")
    assert (shown["state"], shown["stability"]) == ("distrusted", "running"), "it is checked by itself"
    assert len(shown["failures"]) == 2
    assert shown["failures"][0].startswith("jobs, ")
    assert "did not end rendering samples 0 to 0 within 45 s" in shown["failures"][0]
    after = frail.wait(frail.submit(make_scene(samples=4)), ended)
    assert after["devices"] == ["cpu0"]
    frail.wait(after["id"], lambda _: device(frail, "cpu1")["state"] == "ready", 60)
    again = frail.wait(frail.submit(make_scene(samples=4), "cpu1"), ended)
    assert again["state"] == "succeeded"


@pytest.mark.slow
def test_a_device_that_crashes_over_two_jobs_is_quarantined_unless_one_between_ends_well(
    frail: Service, fault: Path, make_scene: Make
) -> None:
    def crash() -> None:
        fault.write_text("crash")
        job_id = frail.submit(make_scene(samples=8), "cpu1")
        assert failure(frail, job_id).startswith("The process that renders on cpu1 died 4 times while rendering")
        fault.unlink()

    crash()
    assert frail.wait(frail.submit(make_scene(samples=4), "cpu1"), ended)["state"] == "succeeded"
    crash()
    assert device(frail, "cpu1")["state"] == "ready"
    crash()
    assert device(frail, "cpu1")["state"] == "distrusted"


@pytest.mark.slow
def test_a_worker_that_takes_too_much_memory_is_killed_and_the_job_says_so(
    own_service: Service, make_scene: Make
) -> None:
    service = own_service
    service.environment["WOODCOCK_WORKER_MEMORY"] = "700MiB"
    service.start()
    says = failure(service, service.submit(make_scene(size=8192, samples=1), "cpu0"))
    assert says.startswith("The process that renders on cpu0 died 4 times")
    assert says.endswith("It is killed when it takes more than 700 MiB.")
    assert service.wait(service.submit(make_scene(samples=4), "cpu0"), ended, 120)["state"] == "succeeded"
