"""The service with its files in an S3 bucket, on a real server that may be away."""

from __future__ import annotations

import json
import re
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from woodcock.image import read_exr

from .conftest import Service
from .s3_server import S3Server
from .test_volumes import npy

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]

Make = Callable[..., dict[str, Any]]
#: How long the store is away, seconds.
OUTAGE = 60
FILES = {"image.exr", "preview.png", "thumbnail.webp", "report.json", "report.html"}


@pytest.fixture
def pair(tmp_path: Path, postgres: Callable[[], str], s3: S3Server) -> Iterator[list[Service]]:
    """Two services that share a database and a bucket, and no folder."""
    shared = {"WOODCOCK_DATABASE_URL": postgres(), "WOODCOCK_LEASE_SECONDS": "2", **s3.environment}
    services = [Service(tmp_path / name, **shared) for name in ("one", "other")]
    for each in services:
        each.start()
    yield services
    for each in services:
        if each.process is not None:
            each.stop()


def succeeded(job: dict[str, Any]) -> bool:
    return bool(job["state"] == "succeeded")


def check_picture(service: Service, tmp_path: Path, job_id: str, samples: int) -> None:
    """Every sample is in the picture, once."""
    path = tmp_path / "image.exr"
    path.write_bytes(service.http.get(f"/api/v1/jobs/{job_id}/image.exr").raise_for_status().content)
    layers, header = read_exr(path)
    assert json.loads(str(header["sampleRanges"])) == [[0, samples]]
    assert (layers["samples.count"] == samples).all()
    report = service.http.get(f"/api/v1/jobs/{job_id}/report.json").raise_for_status().json()
    assert sum(use["samples"] for use in report["devices"]) == samples


def test_services_share_what_is_in_the_bucket_and_nothing_else(
    pair: list[Service], s3: S3Server, tmp_path: Path, make_scene: Make
) -> None:
    one, other = pair
    headers = {"content-type": "application/octet-stream"}
    uploaded = one.http.post("/api/v1/volumes?name=fog", content=npy((40, 40, 40), 2.0), headers=headers)
    file = uploaded.raise_for_status().json()["id"]
    again = other.http.post("/api/v1/volumes?name=fog", content=npy((40, 40, 40), 2.0), headers=headers)
    assert again.status_code == 200
    grid = {"kind": "grid", "file": file, "albedo": 0.5}
    jobs = [one.submit(make_scene(volumes=[grid], samples=64)) for _ in range(6)]
    for job_id in jobs:
        other.wait(job_id, succeeded)
    assert "job claimed" in one.log.read_text()
    assert "job claimed" in other.log.read_text()
    for each in pair:
        check_picture(each, tmp_path, jobs[0], 64)
        for path in ("preview.png", "thumbnail.webp", "report.html", "layers", "layers/beauty"):
            assert each.http.get(f"/api/v1/jobs/{jobs[0]}/{path}").status_code == 200
        assert each.http.get(f"/api/v1/volumes/{file}/slice.png?axis=z&position=5").status_code == 200
    longer = other.http.post(f"/api/v1/jobs/{jobs[0]}/extend", json={"stop": {"kind": "samples", "samples": 96}})
    longer_id = longer.raise_for_status().json()["id"]
    one.wait(longer_id, succeeded)
    check_picture(one, tmp_path, longer_id, 96)
    held = one.submit(make_scene(volumes=[grid], samples=8), reference=jobs[1])
    other.wait(held, succeeded)

    kept = {*jobs, longer_id, held}
    for job_id in jobs[2:]:
        one.http.delete(f"/api/v1/jobs/{job_id}").raise_for_status()
        kept.remove(job_id)
    found = s3.found() - {"probe"}
    assert {key for key in found if key.startswith("volumes/")} == {f"volumes/{file.removeprefix('sha256:')}"}
    of_jobs = [key.split("/") for key in found if key.startswith("jobs/")]
    assert {job_id for _, job_id, _, _ in of_jobs} == kept
    for job_id in kept:
        names = [name for _, its, _, name in of_jobs if its == job_id]
        assert {name for name in names if not name.startswith("film-")} == FILES
        assert len(names) == len(FILES) + 1, "one Film, to be gone on from"


def test_what_a_killed_server_rendered_another_goes_on_with(
    pair: list[Service], s3: S3Server, tmp_path: Path, make_scene: Make
) -> None:
    job_id = pair[0].submit(make_scene(size=256, samples=20_000))
    first = None
    while first is None:
        first = next((each for each in pair if "job claimed" in each.log.read_text()), None)
        time.sleep(0.05)
    pair[0].wait(job_id, lambda job: any("film-1" in key for key in s3.found()) and job["samples"] > 0)
    first.stop(signal.SIGKILL)
    (other,) = (each for each in pair if each is not first)
    other.wait(job_id, succeeded, 300)
    check_picture(other, tmp_path, job_id, 20_000)
    (kept,) = re.findall(r"samples_kept=(\d+)", re.sub(r"\x1b\[[0-9;]*m", "", other.log.read_text()))
    assert int(kept) > 0, "its checkpoint is there"


@pytest.mark.parametrize("how", ["refuses", "hangs"])
def test_an_outage_costs_no_sample(tmp_path: Path, s3: S3Server, make_scene: Make, how: str) -> None:
    """In the middle of a render, and at the end of one."""
    service = Service(tmp_path / "data", WOODCOCK_LEASE_SECONDS="2", **s3.environment)
    service.start()
    try:
        scene = make_scene(size=64, stop={"kind": "seconds", "seconds": OUTAGE + 20})
        during = service.submit(scene)
        service.wait(during, lambda job: job["samples"] > 0)
        before = service.job(during)["samples"]
        s3.stop() if how == "refuses" else s3.hang()
        time.sleep(OUTAGE)
        ready = service.http.get("/readyz")
        assert (ready.status_code, ready.json()["detail"][:34]) == (503, "The object store does not answer; ")
        assert service.http.get(f"/api/v1/jobs/{during}").status_code == 200
        s3.start() if how == "refuses" else s3.go_on()
        end = time.monotonic() + 15
        while service.http.get("/readyz").status_code != 200:
            assert time.monotonic() < end, service.log.read_text()
            time.sleep(0.1)
        job = service.wait(during, succeeded)
        assert job["samples"] > before
        check_picture(service, tmp_path, during, job["samples"])

        at_end = service.submit(make_scene(size=64, stop={"kind": "seconds", "seconds": 4}))
        service.wait(at_end, lambda job: job["samples"] > 0)
        s3.stop() if how == "refuses" else s3.hang()
        time.sleep(OUTAGE)
        assert service.job(at_end)["state"] == "running", "it has no picture yet, and does not fail for it"
        s3.start() if how == "refuses" else s3.go_on()
        job = service.wait(at_end, succeeded)
        check_picture(service, tmp_path, at_end, job["samples"])
    finally:
        service.stop()
