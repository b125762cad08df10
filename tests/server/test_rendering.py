"""Jobs rendered by the service as a process, on two devices: the results, and that nothing that dies loses a sample."""

from __future__ import annotations

import io
import json
import math
import re
import signal
import sqlite3
import time
from collections.abc import Callable
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from woodcock.film import Film
from woodcock.image import read_exr

from .conftest import Service

Make = Callable[..., dict[str, Any]]


def succeeded(job: dict[str, Any]) -> bool:
    return bool(job["state"] == "succeeded")


def renders(worker: psutil.Process) -> bool:
    """Whether it has come so far as to load OpenCL."""
    with suppress(psutil.NoSuchProcess, psutil.ZombieProcess):
        return any("pocl" in mapped.path for mapped in worker.memory_maps())
    return False


def check_picture(service: Service, tmp_path: Path, job_id: str, samples: int) -> dict[str, Any]:
    """The EXR holds exactly so many samples in every pixel; returns its header."""
    answer = service.http.get(f"/api/v1/jobs/{job_id}/image.exr").raise_for_status()
    assert answer.headers["content-type"] == "image/x-exr"
    path = tmp_path / "image.exr"
    path.write_bytes(answer.content)
    layers, header = read_exr(path)
    assert json.loads(str(header["sampleRanges"])) == [[0, samples]]
    assert np.isfinite(layers["Y"]).all()
    assert (layers["samples.count"] == samples).all()
    return header


def check_books(report: dict[str, Any]) -> None:
    """Every sample was rendered once, by one device, in time that counts once."""
    assert sum(use["samples"] for use in report["devices"]) == report["samples"]
    errors = report["error"]
    assert len(errors) > 3
    for earlier, later in pairwise(errors):
        for key in ("samples", "seconds", "device_seconds"):
            assert earlier[key] < later[key]
    assert errors[-1]["samples"] == report["mean_samples"]
    rendering = sum(use["render_seconds"] for use in report["devices"])
    assert errors[-1]["device_seconds"] == pytest.approx(rendering)
    rates = [point["samples"] / point["device_seconds"] for point in errors[len(errors) // 2 :]]
    assert max(rates) < 4 * min(rates), "time of former attempts is there, and once"


@pytest.fixture(scope="session")
def samples_in(service: Service, make_scene: Make) -> Callable[[float], int]:
    """How many samples of the cube, 256 pixels wide, take so many seconds on this machine."""
    for device in ("cpu0", "cpu1"):  # until its program is built, a slower one renders
        service.wait(service.submit(make_scene(size=256, samples=1), device), succeeded)
    job_id = service.submit(make_scene(size=256, stop={"kind": "seconds", "seconds": 2}))
    job = service.wait(job_id, succeeded)
    rate = job["samples"] / job["seconds"]
    return lambda seconds: math.ceil(rate * seconds)


def test_a_job_from_its_submission_to_its_picture(service: Service, tmp_path: Path, make_scene: Make) -> None:
    for device in ("cpu0", "cpu1"):  # which builds the program: neither must wait for it while the other renders all
        service.wait(service.submit(make_scene(size=64, samples=2), device), succeeded)
    scene = make_scene(size=64, samples=1500)
    job_id = service.submit(scene, name="a cube")
    seen = []
    with service.http.stream("GET", f"/api/v1/jobs/{job_id}/events") as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        for line in stream.iter_lines():
            if line.startswith("event: "):
                event = line.removeprefix("event: ")
            elif line.startswith("data: "):
                seen.append((event, json.loads(line.removeprefix("data: "))))
    assert [data["state"] for event, data in seen if event == "state"] == ["queued", "running", "succeeded"]
    seen = [(event, data) for event, data in seen if event != "state"]
    assert [event for event, _ in seen] == ["progress"] * (len(seen) - 1) + ["end"]
    counts = [data["samples"] for _, data in seen]
    assert counts == sorted(counts)
    job = service.job(job_id)
    job.pop("scene")
    assert seen[-1][1] == job
    assert (job["state"], job["samples"], job["fraction"], job["error"]) == ("succeeded", 1500, 1, None)
    assert {"cpu0", "cpu1"} <= set(job["devices"])
    assert job["seconds"] > 0
    assert 0 < job["relative_rmse"] < 0.1
    assert job["started_at"] < job["finished_at"]

    header = check_picture(service, tmp_path, job_id, 1500)
    assert json.loads(str(header["scene"]))["volumes"][0]["sigma_t"] == 4
    report = service.http.get(job["links"]["report"]).raise_for_status().json()
    assert (report["samples"], report["sample_ranges"], report["rejected_samples"]) == (1500, [[0, 1500]], 0)
    assert {"cpu0", "cpu1"} <= {use["id"] for use in report["devices"] if use["samples"] > 0}
    assert sum(use["samples"] for use in report["devices"]) == 1500
    assert report["rmse"] == job["rmse"]
    assert report["seconds"]["render"] == job["seconds"]
    check_books(report)
    assert report["error"][-1]["rmse"] < report["error"][0]["rmse"]
    assert 0 < report["utilisation"] <= 1
    assert report["contract"]["met"]
    assert set(report["seconds"]) == {"read", "build", "upload", "render", "merge", "check", "write"}
    assert all(report["seconds"][part] > 0 for part in ("render", "merge", "check", "write"))
    page = service.http.get(job["links"]["report_page"]).raise_for_status()
    assert page.headers["content-type"].startswith("text/html")
    assert "<title>a cube" in page.text
    preview = service.http.get(job["links"]["preview"]).raise_for_status()
    assert (preview.content[:8], preview.headers["content-type"]) == (b"\x89PNG\r\n\x1a\n", "image/png")
    assert {path.name for path in (service.data / "jobs" / job_id).iterdir()} == {
        "film-1.npz",
        "image.exr",
        "preview.png",
        "thumbnail.webp",
        "report.json",
        "report.html",
    }


def test_an_event_stream_of_a_finished_job_ends_at_once(service: Service, make_scene: Make) -> None:
    job_id = service.submit(make_scene(samples=1))
    service.wait(job_id, succeeded)
    text = service.http.get(f"/api/v1/jobs/{job_id}/events").text
    assert re.findall(r"^event: (\w+)", text, re.MULTILINE) == ["state", "state", "state", "end"]


def test_seconds_are_kept(service: Service, make_scene: Make) -> None:
    job_id = service.submit(make_scene(size=64, stop={"kind": "seconds", "seconds": 3}))
    middle = service.wait(job_id, lambda job: job["samples"] > 0)
    assert 0 < middle["fraction"] <= 1
    assert service.http.get(middle["links"]["preview"]).status_code == 200, "there is a preview while it renders"
    job = service.wait(job_id, succeeded)
    assert 2.5 < job["seconds"] < 10
    assert job["samples"] > 10


def test_an_uploaded_volume_is_rendered(service: Service, tmp_path: Path, make_scene: Make) -> None:
    stream = io.BytesIO()
    np.save(stream, np.linspace(0, 1, 64, dtype=np.float32).reshape(4, 4, 4))
    volume = service.http.post("/api/v1/volumes?name=ramp.npy", content=stream.getvalue()).raise_for_status().json()
    scene = make_scene(samples=4, volumes=[{"kind": "grid", "file": volume["id"], "albedo": 0.5, "scale": 5}])
    job_id = service.submit(scene)
    service.wait(job_id, succeeded)
    header = check_picture(service, tmp_path, job_id, 4)
    assert json.loads(str(header["scene"]))["volumes"][0]["file"] == volume["id"], "no path of the server's"

    # The file vanishes behind the service's back: the next job fails, with a sentence.
    (service.data / "volumes" / volume["id"].removeprefix("sha256:")).unlink()
    job_id = service.submit({**scene, "seed": 7})
    with pytest.raises(AssertionError, match="No such file"):
        service.wait(job_id, succeeded)
    job = service.job(job_id)
    assert (job["state"], job["samples"], job["links"]["image"]) == ("failed", 0, None)
    assert job["error"].startswith(f"{volume['id']}: No such file"), "the volume's id, no path of the server's"

    # Uploaded again, it is there again.
    assert service.http.post("/api/v1/volumes?name=ramp.npy", content=stream.getvalue()).status_code == 200
    service.wait(service.submit({**scene, "seed": 7}), succeeded)


def test_a_scene_that_is_no_longer_understood_fails_its_job_alone(service: Service, make_scene: Make) -> None:
    blocking = service.submit(make_scene(size=64, stop={"kind": "seconds", "seconds": 1}))
    job_id = service.submit(make_scene(samples=4))
    connection = sqlite3.connect(service.data / "woodcock.sqlite", timeout=10)
    with connection:
        connection.execute("UPDATE jobs SET scene = json_set(scene, '$.fog', 1) WHERE id = ?", (job_id,))
    connection.close()
    service.wait(blocking, succeeded)
    after = service.submit(make_scene(samples=4))
    service.wait(after, succeeded)
    items = service.http.get("/api/v1/jobs").json()["items"]
    job = next(job for job in items if job["id"] == job_id)
    assert (job["state"], job["error"]) == ("failed", "fog: is not a known key (got 1)")


def test_a_worker_that_is_killed_costs_no_sample(
    service: Service, tmp_path: Path, make_scene: Make, samples_in: Callable[[float], int]
) -> None:
    samples = samples_in(4)
    job_id = service.submit(make_scene(size=256, samples=samples))
    service.wait(job_id, lambda job: job["samples"] > 0)
    before = service.workers()
    assert len(before) >= 2
    before[0].kill()
    job = service.wait(job_id, succeeded)
    assert job["samples"] == samples
    check_picture(service, tmp_path, job_id, samples)
    after = service.workers()
    assert len(after) == len(before)
    assert before[0] not in after


@pytest.mark.slow
def test_a_worker_that_dies_again_and_again_fails_the_job(service: Service, make_scene: Make) -> None:
    job_id = service.submit(make_scene(size=256, samples=1 << 20))
    deadline = time.monotonic() + 60
    while (job := service.job(job_id))["state"] != "failed":
        assert time.monotonic() < deadline, service.log.read_text()
        for worker in service.workers()[:1]:
            if renders(worker):
                worker.kill()
        time.sleep(0.1)
    assert re.fullmatch(
        r"The process that renders on cpu\d died 4 times while (rendering samples \d+ to \d+|preparing the scene)\. "
        r"It is killed when it takes more than \d+ MiB\.",
        job["error"],
    )
    after = service.submit(make_scene(samples=4))
    assert service.wait(after, succeeded)["samples"] == 4, "the service itself is well"


def test_a_dispatcher_that_lost_its_lease_writes_nothing_more(
    service: Service, tmp_path: Path, make_scene: Make, samples_in: Callable[[float], int]
) -> None:
    samples = samples_in(4)
    job_id = service.submit(make_scene(size=256, samples=samples))
    checkpoint = service.data / "jobs" / job_id / "film-1.npz"
    service.wait(job_id, lambda _: checkpoint.exists())
    # What another dispatcher's claim does; it is never heard of again.
    connection = sqlite3.connect(service.data / "woodcock.sqlite", timeout=10)
    with connection:
        connection.execute("UPDATE jobs SET token = token + 1, holder = 'another' WHERE id = ?", (job_id,))
    connection.close()
    job = service.wait(job_id, succeeded)
    assert job["samples"] == samples
    check_picture(service, tmp_path, job_id, samples)
    log = service.log.read_text()
    assert re.search(rf"job lost to another dispatcher\s+job={job_id}", log)
    assert re.search(rf"job claimed\s+job={job_id} samples_kept=[1-9]\d* token=3", log)


def test_a_service_that_is_killed_goes_on_from_its_checkpoint(
    own_service: Service, tmp_path: Path, make_scene: Make, samples_in: Callable[[float], int]
) -> None:
    service = own_service
    service.start()
    samples = samples_in(8)
    job_id = service.submit(make_scene(size=256, samples=samples))
    checkpoint = service.data / "jobs" / job_id / "film-1.npz"
    service.wait(job_id, lambda job: job["samples"] > 0 and checkpoint.exists() and Film.load(checkpoint).samples > 10)
    left = service.workers()
    service.stop(signal.SIGKILL)
    _, alive = psutil.wait_procs(left, timeout=10)
    assert not alive, "workers end with their service"
    held = Film.load(checkpoint).samples
    assert 0 < held < samples

    service.start()
    job = service.wait(job_id, succeeded)
    assert job["samples"] == samples
    check_picture(service, tmp_path, job_id, samples)
    check_books(service.http.get(job["links"]["report"]).raise_for_status().json())
    log = service.log.read_text()
    assert re.search(rf"job claimed\s+job={job_id} samples_kept={held} token=2", log)
    assert re.search(rf"job succeeded\s+job={job_id} samples={samples} samples_rendered={samples - held}\b", log)


def test_a_service_that_is_stopped_puts_its_job_back(own_service: Service, make_scene: Make) -> None:
    service = own_service
    service.start()
    job_id = service.submit(make_scene(size=256, samples=1 << 20))
    service.wait(job_id, lambda job: job["samples"] > 0)
    began = time.monotonic()
    assert service.stop() == 130
    assert time.monotonic() - began < 15
    assert "Traceback" not in service.log.read_text()
    connection = sqlite3.connect(service.data / "woodcock.sqlite")
    state, holder, samples = connection.execute("SELECT state, holder, samples FROM jobs").fetchone()
    connection.close()
    assert (state, holder) == ("queued", None)
    assert Film.load(service.data / "jobs" / job_id / "film-1.npz").samples == samples > 0
