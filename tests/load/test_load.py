"""Many clients at once, on this machine's loopback: nothing fails, answers stay quick, memory stays flat (`make load`).

Times are of two idle cores, of which this process takes one: no device renders meanwhile, and nothing else should run.
"""

from __future__ import annotations

import asyncio
import gc
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import psutil
import pytest
from sqlalchemy import text, update
from tests.server.conftest import NO_DEVICES, Service

from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs import repository
from woodcock_server.storage import Storage
from woodcock_server.tables import jobs

pytestmark = [pytest.mark.load, pytest.mark.timeout(1200)]

Make = Callable[..., dict[str, Any]]

STORED, JOBS, CLIENTS, READERS = 10_000, 1000, 32, 200
#: Between two jobs of one client, seconds: all together ask for some twenty a second.
PAUSE = 1.5
#: Largest 99th percentile of an answer's time, seconds.
SLOWEST = 0.1

POINT = {"samples": 8, "seconds": 0.5, "device_seconds": 0.9, "rmse": 0.01, "relative_rmse": 0.02}


def stored(database: str, scene: dict[str, Any], count: int) -> None:
    """Jobs that have ended."""
    engine = open_database(database)
    now = datetime.now(UTC)
    with engine.begin() as connection:
        for number in range(count):
            then = now - timedelta(seconds=count - number)
            asked = {"name": f"cloud {number}", "scene": scene, "device": ANY, "tags": ["sky", f"day{number % 30}"]}
            repository.add(connection, asked, then)
        ended = {
            "state": "succeeded",
            "started_at": now,
            "finished_at": now,
            "series": [POINT] * 20,
            "samples": 8,
            "size": 9,
        }
        connection.execute(update(jobs).values(**ended))
    if engine.dialect.name == "postgresql":  # or it would tidy up after so many rows while times are taken
        with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.execute(text("VACUUM ANALYZE"))
    engine.dispose()


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "postgresql":
        make: Callable[[], str] = request.getfixturevalue("postgres")
        return make()
    return Settings(data=Storage(tmp_path / "data").root).database


@pytest.fixture
def busy(tmp_path: Path, database: str, make_scene: Make) -> Iterator[Service]:
    """A service without devices, with ten thousand jobs that have ended."""
    stored(database, make_scene(size=64), STORED)
    limits = {"WOODCOCK_REQUEST_RATE": "1e6", "WOODCOCK_OWNER_JOBS": "100000"}
    service = Service(tmp_path / "data", NO_DEVICES, WOODCOCK_DATABASE_URL=database, **limits)
    service.start()
    yield service
    service.stop()


class Clock:
    """How long answers took, seconds, by what was asked."""

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = {}

    async def answer(self, what: str, asked: Awaitable[httpx2.Response]) -> httpx2.Response:
        began = time.perf_counter()
        answer = await asked
        self.times.setdefault(what, []).append(time.perf_counter() - began)
        assert answer.is_success, answer.text
        return answer

    def quantile(self, what: str, part: float) -> float:
        return float(np.quantile(self.times[what], part))

    def told(self) -> str:
        rows = [
            f"{what:24} {len(times):6} {1e3 * self.quantile(what, 0.5):8.1f} {1e3 * self.quantile(what, 0.99):8.1f}"
            for what, times in sorted(self.times.items())
        ]
        return "\n".join([f"{'':24} {'number':>6} {'50 %':>8} {'99 %, ms':>8}", *rows])


@asynccontextmanager
async def readers(http: httpx2.AsyncClient, ids: list[str], seen: list[str]) -> AsyncIterator[None]:
    """Each follows a job; every event's name is noted."""

    async def read(job_id: str) -> None:
        async with http.stream("GET", f"/api/v1/jobs/{job_id}/events") as stream:
            assert stream.status_code == 200
            async for line in stream.aiter_lines():
                if line.startswith("event: "):
                    seen.append(f"{job_id} {line.removeprefix('event: ')}")

    tasks = [asyncio.create_task(read(job_id)) for job_id in ids]
    try:
        yield
    finally:
        done, _ = await asyncio.wait(tasks, timeout=0.1)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for task in done:
            task.result()


async def crowd(address: str, scene: dict[str, Any], clock: Clock) -> tuple[list[str], list[str]]:
    """32 clients submit a thousand jobs while 200 follow some and the gallery turns pages. Returns ids and events."""
    limits = httpx2.Limits(max_connections=None, max_keepalive_connections=None)
    async with httpx2.AsyncClient(base_url=address, timeout=60, limits=limits) as http:
        made: list[str] = []
        seen: list[str] = []
        numbers = iter(range(JOBS))

        async def submit(delay: float) -> None:
            await asyncio.sleep(delay)
            for number in numbers:
                body = {"scene": scene, "name": f"job {number}", "tags": ["load"]}
                answer = await clock.answer("POST jobs", http.post("/api/v1/jobs", json=body))
                made.append(answer.json()["id"])
                await asyncio.sleep(PAUSE)

        async def turn() -> None:
            path = "/api/v1/jobs"
            while True:
                answer = await clock.answer("GET jobs", http.get(path))
                path = answer.links.get("next", {}).get("url", "/api/v1/jobs")
                await asyncio.sleep(0.1)

        first = [(await http.post("/api/v1/jobs", json={"scene": scene})).json()["id"] for _ in range(READERS)]
        async with readers(http, first, seen):
            while len(seen) < 2 * READERS:  # its state and how far it is
                await asyncio.sleep(0.05)
            clock.times.clear()
            turning = [asyncio.create_task(turn()) for _ in range(2)]
            async with asyncio.TaskGroup() as group:
                for number in range(CLIENTS):
                    group.create_task(submit(number * PAUSE / CLIENTS))
                for job_id in first:
                    group.create_task(_cancel(http, clock, job_id))
            for task in turning:
                task.cancel()
            await asyncio.gather(*turning, return_exceptions=True)
            end = time.monotonic() + 30
            while sum(event.endswith(" end") for event in seen) < READERS and time.monotonic() < end:
                await asyncio.sleep(0.05)
        for query in ("?state=succeeded", "?tag=day3", "?text=9999", "?limit=200"):
            for _ in range(20):
                await clock.answer(f"GET jobs{query}", http.get(f"/api/v1/jobs{query}"))
    return made, seen


async def _cancel(http: httpx2.AsyncClient, clock: Clock, job_id: str) -> None:
    """Some time within the crowd."""
    await asyncio.sleep(int(job_id[-6:], 16) % 1000 / 1000 * PAUSE * JOBS / CLIENTS)
    await clock.answer("POST cancel", http.post(f"/api/v1/jobs/{job_id}/cancel"))


def test_a_crowd_is_served_quickly_and_nothing_fails(
    busy: Service, make_scene: Make, capsys: pytest.CaptureFixture[str], request: pytest.FixtureRequest
) -> None:
    clock = Clock()
    gc.collect()
    gc.freeze()  # or this process would stop now and then, and blame the service
    made, seen = asyncio.run(crowd(str(busy.http.base_url), make_scene(size=64), clock))
    with capsys.disabled():
        print(
            f"\n{request.node.callspec.id}: {STORED} jobs stored, {CLIENTS} clients, {READERS} readers\n{clock.told()}"
        )
    assert len(set(made)) == JOBS
    followed = {event.split()[0] for event in seen if event.endswith(" end")}
    assert len(followed) == READERS, "every reader learned of the end"
    assert "error" not in busy.log.read_text()
    for what in ("POST jobs", "GET jobs"):
        assert clock.quantile(what, 0.99) < SLOWEST


async def rush(address: str, scene: dict[str, Any], count: int) -> None:
    """As many jobs as 32 clients can submit, made and cancelled."""
    limits = httpx2.Limits(max_connections=None, max_keepalive_connections=None)
    async with httpx2.AsyncClient(base_url=address, timeout=60, limits=limits) as http:
        numbers = iter(range(count))

        async def submit() -> None:
            for number in numbers:
                answer = await http.post("/api/v1/jobs", json={"scene": scene, "name": f"job {number}"})
                assert answer.status_code == 201, answer.text
                path = answer.json()["links"]["self"]
                assert (await http.get(path)).status_code == 200
                assert (await http.post(f"{path}/cancel")).status_code == 202

        async with asyncio.TaskGroup() as group:
            for _ in range(CLIENTS):
                group.create_task(submit())


def test_memory_is_flat_over_thousands_of_jobs(
    busy: Service, make_scene: Make, capsys: pytest.CaptureFixture[str], request: pytest.FixtureRequest
) -> None:
    assert busy.process is not None
    process, address, scene = psutil.Process(busy.process.pid), str(busy.http.base_url), make_scene(size=64)
    taken, rates = [], []
    for _ in range(6):
        began = time.perf_counter()
        asyncio.run(rush(address, scene, 1000))
        rates.append(3000 / (time.perf_counter() - began))
        taken.append(process.memory_info().rss / 2**20)
    with capsys.disabled():
        sizes = ", ".join(f"{each:.0f}" for each in taken)
        print(f"\n{request.node.callspec.id}: {np.median(rates):.0f} requests/s; MiB after each thousand jobs: {sizes}")
    # The first thousand fill caches and pools.
    growth = np.polyfit(range(5), taken[1:], 1)[0]
    assert growth < 2, f"{growth:.1f} MiB for every thousand jobs: {taken}"
