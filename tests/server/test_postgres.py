"""The service on PostgreSQL: the same promises, and two servers that share one queue."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psycopg
import pytest

from .conftest import Service

Make = Callable[..., dict[str, Any]]


def ended(job: dict[str, Any]) -> bool:
    return job["state"] in ("succeeded", "failed", "cancelled")


def claimed(service: Service) -> list[str]:
    """Ids of the jobs that a server took, once for each time."""
    return re.findall(r"job claimed .*?job=(\S+)", re.sub(r"\x1b\[[0-9;]*m", "", service.log.read_text()))


@pytest.fixture
def pair(tmp_path: Path, postgres: Callable[[], str]) -> Any:
    """Two servers with one database and one data folder; and the database's URL."""
    url, data = postgres(), tmp_path / "data"
    services = [
        Service(data, log=f"log-{number}.txt", WOODCOCK_DATABASE_URL=url, WOODCOCK_LEASE_SECONDS="2")
        for number in range(2)
    ]
    for service in services:
        service.start()
    yield *services, url
    for service in services:
        if service.process is not None:
            service.stop()


def test_two_servers_share_a_queue_and_take_no_job_twice(pair: tuple[Service, Service, str], make_scene: Make) -> None:
    one, other, url = pair
    jobs = [server.submit(make_scene(samples=2)) for _ in range(10) for server in (one, other)]
    for job_id in jobs:
        assert other.wait(job_id, ended)["state"] == "succeeded"
    taken = claimed(one) + claimed(other)
    assert sorted(taken) == sorted(jobs)
    assert claimed(one)
    assert claimed(other)
    with psycopg.connect(url) as connection:
        assert connection.execute("SELECT DISTINCT token FROM jobs").fetchall() == [(1,)]
        told = connection.execute("SELECT state, count(*) FROM job_events GROUP BY state ORDER BY state").fetchall()
    assert told == [("queued", 20), ("running", 20), ("succeeded", 20)]


@pytest.mark.slow
def test_what_a_killed_server_rendered_another_goes_on_with(
    pair: tuple[Service, Service, str], make_scene: Make
) -> None:
    one, other, _ = pair
    job_id = one.submit(make_scene(size=64, stop={"kind": "seconds", "seconds": 4}))
    one.wait(job_id, lambda job: job["samples"] > 0)
    holder, left = (one, other) if job_id in claimed(one) else (other, one)
    assert holder.process is not None
    holder.process.kill()
    job = left.wait(job_id, ended)
    assert job["state"] == "succeeded"
    events = left.http.get(f"/api/v1/jobs/{job_id}/events").text
    assert re.findall(r'"state":"(\w+)"', events)[:4] == ["queued", "running", "running", "succeeded"]
