"""Contracts of a relative error, and pictures held against references, by the service as a process on two devices."""

from __future__ import annotations

import io
import json
import signal
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.batches import TILE, tiles
from woodcock.film import Film
from woodcock.image import read_exr, write_exr
from woodcock.report_schema import Report

from .conftest import Service

Make = Callable[..., dict[str, Any]]


def succeeded(job: dict[str, Any]) -> bool:
    return bool(job["state"] == "succeeded")


def error(asked: float, per: str = "image") -> dict[str, Any]:
    return {"kind": "relative_error", "relative_error": asked, "per": per}


def report_of(service: Service, job: dict[str, Any]) -> dict[str, Any]:
    """As its schema describes it."""
    report: dict[str, Any] = service.http.get(job["links"]["report"]).raise_for_status().json()
    Report.model_validate(report)
    return report


def layers_of(service: Service, job: dict[str, Any], tmp_path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    path = tmp_path / "image.exr"
    path.write_bytes(service.http.get(job["links"]["image"]).raise_for_status().content)
    return read_exr(path)


def test_an_image_is_rendered_to_its_error(service: Service, make_scene: Make, tmp_path: Path) -> None:
    job_id = service.submit(make_scene(size=64, stop=error(0.02)))
    job = service.wait(job_id, succeeded)
    report = report_of(service, job)
    contract = report["contract"]
    assert (contract["kind"], contract["asked"], contract["met"]) == ("relative_error", 0.02, True)
    assert 0.01 < contract["reached"] <= 0.02
    layers, header = layers_of(service, job, tmp_path)
    found = np.sqrt(layers["variance.Y"].mean(dtype=np.float64)) / layers["Y"].mean(dtype=np.float64)
    assert found == pytest.approx(contract["reached"], rel=1e-3), "as the picture itself says"
    assert np.unique(layers["samples.count"]).tolist() == [job["samples"]]
    assert json.loads(header["sampleRanges"]) == [[0, job["samples"]]]
    assert sum(use["samples"] for use in report["devices"]) == job["samples"] == report["mean_samples"]
    assert job["fraction"] == 1


def test_tiles_get_what_they_need(service: Service, make_scene: Make, tmp_path: Path) -> None:
    """A cube that fills the middle: tiles at the edge see nothing but light, which has no noise."""
    camera = {"kind": "orthographic", "origin": [0.5, 0.5, -2], "target": [0.5, 0.5, 0.5], "height": 4}
    job_id = service.submit(make_scene(size=5 * TILE, camera=camera, stop=error(0.02, "tile")))
    seen: list[float] = []
    job = service.wait(job_id, lambda job: seen.append(job["fraction"]) or succeeded(job))  # type: ignore[func-returns-value]
    assert seen == sorted(seen)
    report = report_of(service, job)
    assert report["contract"]["met"]
    layers, _ = layers_of(service, job, tmp_path)
    counts, mean = layers["samples.count"], layers["Y"].mean(dtype=np.float64)
    assert counts.max() == job["samples"] == report["samples"]
    assert counts.mean(dtype=np.float64) == pytest.approx(report["mean_samples"])
    assert counts[:TILE, :TILE].max() < 0.5 * counts.max()
    assert counts[2 * TILE : 3 * TILE, 2 * TILE : 3 * TILE].max() == counts.max()
    worst = np.sqrt(tiles(layers["variance.Y"].astype(np.float64)).max()) / mean
    assert worst == pytest.approx(report["contract"]["reached"], rel=1e-3)
    assert worst <= 0.02


@pytest.mark.slow
def test_a_relative_error_goes_on_after_a_crash(own_service: Service, make_scene: Make, tmp_path: Path) -> None:
    service = own_service
    service.start()
    camera = {"kind": "orthographic", "origin": [0.5, 0.5, -2], "target": [0.5, 0.5, 0.5], "height": 2}
    job_id = service.submit(make_scene(size=6 * TILE, camera=camera, stop=error(0.004, "tile")))
    checkpoint = service.data / "jobs" / job_id / "film-1.npz"
    service.wait(job_id, lambda _: checkpoint.exists() and Film.load(checkpoint).samples > 40)
    service.stop(signal.SIGKILL)
    held = Film.load(checkpoint)
    tear(service.data / "woodcock.sqlite", held)
    service.start()
    job = service.wait(job_id, succeeded, seconds=200)
    report = report_of(service, job)
    assert report["contract"]["met"]
    layers, header = layers_of(service, job, tmp_path)
    assert (layers["samples.count"] >= held.count).all(), "what was rendered is there"
    ranges = json.loads(header["sampleRanges"])
    assert sum(stop - start for start, stop in ranges) == report["samples"] == layers["samples.count"].max()
    assert sum(use["samples"] for use in report["devices"]) == report["samples"]
    points = report["error"]
    times = [point["device_seconds"] for point in points]
    assert times == sorted(times)
    before = [point for point in points if point["samples"] <= held.mean_samples]
    assert before, "points survive"
    rates = [point["samples"] / point["device_seconds"] for point in points[len(points) // 2 :]]
    assert max(rates) < 4 * min(rates), "time of the former attempt is there, and once"


def tear(database: Path, held: Film) -> None:
    """As a crash leaves the books that came after they were written and before the Film was."""
    connection = sqlite3.connect(database)
    usage, series, kept = map(json.loads, connection.execute("SELECT usage, series, kept FROM jobs").fetchone())
    if kept is None or kept["samples"] != held.mean_samples:
        kept = {"samples": held.mean_samples, "usage": usage, "series": series}
    late = {
        device: {**use, "samples": use["samples"] + 1000, "render_seconds": use["render_seconds"] + 1000}
        for device, use in usage.items()
    }
    with connection:
        connection.execute("UPDATE jobs SET usage = ?, kept = ?", (json.dumps(late), json.dumps(kept)))
    connection.close()


def test_a_picture_is_held_against_a_job(service: Service, make_scene: Make) -> None:
    reference = service.submit(make_scene(size=32, samples=4000, seed=5))
    service.wait(reference, succeeded)
    job_id = service.submit(make_scene(size=32, samples=500), reference=reference)
    job = service.wait(job_id, succeeded)
    assert job["reference"] == reference
    report = report_of(service, job)
    assert report["reference"] == reference
    against = report["against"]
    assert abs(against["bias"]) < 5 * against["bias_error"]
    assert against["reference_mse"] > 0
    assert against["mse"] == pytest.approx(report["rmse"] ** 2, rel=0.3), "the true error is the estimated one"
    assert all(point["against"]["mse"] >= 0 for point in report["error"])
    assert report["error"][-1]["against"]["mse"] < report["error"][0]["against"]["mse"]


def test_a_bias_shows_against_an_upload(service: Service, make_scene: Make, tmp_path: Path) -> None:
    values = np.full((16, 16, 1), 10.0)
    write_exr(tmp_path / "ten.exr", Film(np.full((16, 16), 9, np.uint32), values, 0 * values, ("Y",), ((0, 9),)), {})
    content = (tmp_path / "ten.exr").read_bytes()
    upload = service.http.post("/api/v1/volumes?name=ten.exr", content=content).json()["id"]
    job = service.wait(service.submit(make_scene(samples=100), reference=upload), succeeded)
    report = report_of(service, job)
    assert report["reference"] == upload
    assert report["against"]["bias"] == pytest.approx(report["mean_luminance"] - 10)
    assert report["against"]["flip"] > 0


def test_a_reference_that_cannot_be_held_against_fails_the_job(
    service: Service, make_scene: Make, tmp_path: Path
) -> None:
    """It is grey: that this picture is in colour its first samples tell. Or its file has gone since."""
    values = np.full((16, 16, 1), 1.0)
    write_exr(tmp_path / "grey.exr", Film(np.full((16, 16), 9, np.uint32), values, 0 * values, ("Y",), ((0, 9),)), {})
    content = (tmp_path / "grey.exr").read_bytes()
    upload = service.http.post("/api/v1/volumes?name=grey.exr", content=content).json()["id"]
    lights = [{"kind": "constant", "radiance": [1, 0.5, 0.2]}]
    job_id = service.submit(make_scene(lights=lights), reference=upload)
    with pytest.raises(AssertionError, match="is grey"):
        service.wait(job_id, succeeded)
    assert service.job(job_id)["error"].startswith(f"{upload}: is grey; ")

    stream = io.BytesIO()
    np.save(stream, np.ones((4, 4, 4), np.float32))
    blocking = service.submit(make_scene(size=64, stop={"kind": "seconds", "seconds": 2}))
    job_id = service.submit(make_scene(), reference=upload)
    (service.data / "volumes" / upload.removeprefix("sha256:")).unlink()
    service.wait(blocking, succeeded)
    with pytest.raises(AssertionError, match="No such file"):
        service.wait(job_id, succeeded)
    assert service.job(job_id)["error"].startswith(f"{upload}: ")
