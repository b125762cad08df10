"""A farm whose service keeps its files in an S3 bucket, on a real server: worker hosts fetch them there."""

from __future__ import annotations

import re
import shutil
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.server.conftest import Service
from tests.server.s3_server import S3Server

from .harness import Farm
from .test_cache import kept
from .test_farm import ended

Make = Callable[..., dict[str, Any]]

pytestmark = pytest.mark.slow

#: What reads an object on a worker host, and in a service.
HOST, SERVICE = "Python-urllib", "object_store"
#: What is said where a URL is.
SIGNED = re.compile("X-Amz|Signature")


class Grid:
    """An uploaded file, of which the service has no copy. id: its own; key: in the bucket; scene: of it."""

    def __init__(self, farm: Farm, s3: S3Server, folder: Path, make_scene: Make) -> None:
        service = farm.start_service(**s3.environment)
        np.save(folder / "grid.npy", np.random.default_rng(1).random((120, 100, 100), np.float32))
        content = (folder / "grid.npy").read_bytes()
        answer = service.http.post("/api/v1/volumes", params={"name": "grid.npy"}, content=content)
        self.id = answer.raise_for_status().json()["id"]
        self.key = f"volumes/{self.id.removeprefix('sha256:')}"
        self.scene = make_scene(volumes=[{"kind": "grid", "file": self.id, "albedo": 0.5}])
        service.stop(signal.SIGTERM)
        shutil.rmtree(service.data / "copies")


@pytest.fixture
def grid(farm: Farm, s3: S3Server, tmp_path: Path, make_scene: Make) -> Iterator[Grid]:
    yield Grid(farm, s3, tmp_path, make_scene)
    assert not SIGNED.search(farm.logs())


@pytest.fixture
def service(farm: Farm, s3: S3Server, grid: Grid) -> Service:
    return farm.start_service(**s3.environment)


def start_host(farm: Farm, service: Service, **environment: str) -> None:
    """A host with two devices."""
    farm.start_worker("node1", **{"POCL_DEVICES": "pthread basic", **environment})
    farm.wait_for(service, "cpu0@node1", "cpu1@node1")


def render(service: Service, grid: Grid, samples: int = 8) -> None:
    """On both devices."""
    scene = {**grid.scene, "stop": {"kind": "samples", "samples": samples}}
    for job_id in [service.submit(scene, f"cpu{number}@node1") for number in (0, 1)]:
        service.wait(job_id, ended, 180)


def copied(service: Service) -> list[Path]:
    return list((service.data / "copies").glob("volumes-*"))


def test_a_host_fetches_a_file_from_the_bucket_once(farm: Farm, s3: S3Server, grid: Grid, service: Service) -> None:
    """And the service does not, neither for itself nor for others."""
    start_host(farm, service)
    render(service, grid)
    assert s3.readers(grid.key) == [HOST]
    assert copied(service) == []
    assert kept(farm.folder / "node1" / "files") == {grid.id}
    check = service.http.post("/api/v1/jobs/check", json={"scene": grid.scene}, timeout=60).json()
    assert check["devices"][0]["fits"], check
    assert s3.readers(grid.key) == [HOST]
    assert "out of reach" not in farm.logs()


def test_a_host_that_does_not_reach_the_bucket_reads_through_the_service(
    farm: Farm, s3: S3Server, grid: Grid, service: Service
) -> None:
    """In parts, of which it keeps nothing."""
    start_host(farm, service, http_proxy="http://127.0.0.1:9")
    render(service, grid)
    assert s3.readers(grid.key) == [SERVICE, SERVICE], "4.8 MB in parts of 4 MiB"
    assert copied(service) == []
    assert farm.logs().count("object store out of reach; reading through the service") == 1, "once a host"


def test_a_file_that_is_lost_or_altered_fails_the_job(farm: Farm, s3: S3Server, grid: Grid, service: Service) -> None:
    def failure() -> str:
        job_id = service.submit(grid.scene, "cpu0@node1")
        end = time.monotonic() + 120
        while (job := service.job(job_id))["state"] != "failed":
            assert time.monotonic() < end, farm.logs()
            time.sleep(0.05)
        return str(job["error"])

    start_host(farm, service)
    path = s3.folder / "farm" / grid.key
    content = path.read_bytes()
    path.write_bytes(content[:-1] + b"x")
    assert failure() == f"{grid.id}: what came has another content"
    path.unlink()
    assert failure() == f"{grid.id} was not fetched: the object store has it no more"
    assert kept(farm.folder / "node1" / "files") == set(), "nothing half-written stays"
    answer = service.http.post("/api/v1/volumes", params={"name": "grid.npy"}, content=content)
    assert answer.raise_for_status().json()["id"] == grid.id
    render(service, grid)


def test_jobs_wait_for_a_bucket_that_is_away_as_they_begin(
    farm: Farm, s3: S3Server, grid: Grid, service: Service
) -> None:
    """Also for longer than a worker waits."""
    start_host(farm, service)
    s3.stop()
    job_id = service.submit(grid.scene, "cpu0@node1")
    service.wait(job_id, lambda _: "device left the job" in service.log.read_text(), 120)
    assert service.job(job_id)["state"] == "running"
    s3.start()
    service.wait(job_id, ended, 120)
