"""/metrics: what is counted, by whom, and that no label can be made from outside."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from prometheus_client.parser import text_string_to_metric_families
from sqlalchemy.exc import OperationalError
from starlette.testclient import TestClient

from woodcock_server import app as application
from woodcock_server.config import Settings
from woodcock_server.jobs import listing

from .conftest import ADDRESS, Service

Make = Callable[..., dict[str, Any]]
Values = dict[tuple[str, ...], float]


def values(http: Any) -> Values:
    """Sample name and its labels' values, in the order of the labels' names -> value."""
    answer = http.get("/metrics")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/plain; version=")
    return {
        (sample.name, *(value for _, value in sorted(sample.labels.items()))): sample.value
        for family in text_string_to_metric_families(answer.text)
        for sample in family.samples
    }


@pytest.fixture
def client(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[TestClient]:
    """A service of its own for a test: its counters begin at 0."""
    monkeypatch.setattr(application, "discover", list)
    with TestClient(application.create_app(Settings(data=tmp_path)), ADDRESS, raise_server_exceptions=False) as client:
        yield client


def test_requests_are_counted_by_route_never_by_path(client: TestClient, make_scene: Make) -> None:
    job = client.post("/api/v1/jobs", json={"scene": make_scene()}).json()
    for path in (
        job["links"]["self"],
        "/api/v1/jobs/a",
        "/api/v1/jobs/b",
        "/api/v1/jobs/%0A%22",
        "/x",
        "/y/z",
        "/docs",
    ):
        client.get(path)
    client.get("/web/app.js")
    client.get("/web/nothing.js")
    client.get("/renders/one")
    client.delete("/api/v1/jobs")
    client.post("/api/v1/jobs", content=b"{")
    counted = {key[1:]: value for key, value in _of(values(client), "woodcock_http_requests_total")}
    assert counted == {
        ("/api/v1/jobs", "201"): 1,
        ("/api/v1/jobs", "405"): 1,
        ("/api/v1/jobs", "422"): 1,
        ("/api/v1/jobs/{id}", "200"): 1,
        ("/api/v1/jobs/{id}", "404"): 3,
        ("/docs", "200"): 1,
        ("/renders/{id}", "200"): 1,
        ("/web", "200"): 1,
        ("/web", "404"): 1,
        ("none", "404"): 2,
    }
    assert values(client)["woodcock_http_requests_total", "/metrics", "200"] == 1, "the one before"


def _of(found: Values, name: str) -> list[tuple[tuple[str, ...], float]]:
    return [(key, value) for key, value in found.items() if key[0] == name]


def test_an_answer_that_broke_off_is_counted(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: Any) -> None:
        raise ValueError

    monkeypatch.setattr(listing, "page", broken)
    assert client.get("/api/v1/jobs").status_code == 500
    assert values(client)["woodcock_http_requests_total", "/api/v1/jobs", "500"] == 1


def test_jobs_are_those_of_the_database(client: TestClient, make_scene: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    for count in (0, 1, 2):
        found = dict(_of(values(client), "woodcock_jobs"))
        assert found == {
            ("woodcock_jobs", "queued"): count,
            **{("woodcock_jobs", state): 0 for state in ("running", "cancelling", "succeeded", "failed", "cancelled")},
        }
        client.post("/api/v1/jobs", json={"scene": make_scene()})

    def away(_: Any) -> None:
        raise OperationalError("SELECT", {}, Exception())

    monkeypatch.setattr(listing, "states", away)
    found = values(client)
    assert not _of(found, "woodcock_jobs"), "rather nothing than what was"
    assert _of(found, "woodcock_http_requests_total"), "the server's own are there"


def test_every_application_counts_for_itself(client: TestClient, tmp_path: Path) -> None:
    client.get("/readyz")
    with TestClient(application.create_app(Settings(data=tmp_path)), ADDRESS) as other:
        assert not _of(values(other), "woodcock_http_requests_total")
    assert values(client)["woodcock_http_requests_total", "/readyz", "503"] == 1


def test_the_readme_names_every_metric(client: TestClient) -> None:
    readme = (Path(__file__).parents[2] / "server" / "README.md").read_text()
    families = {family.name: family for family in text_string_to_metric_families(client.get("/metrics").text)}
    shown = {f"{name}_total" if family.type == "counter" else name for name, family in families.items()}
    assert len(shown) > 12
    named = {name for name in shown if re.search(rf"`{name}[`{{]", readme)}
    assert {name for name in shown - named if not name.endswith("_created")} == set()


def test_a_job_is_counted(service: Service, make_scene: Make) -> None:
    before = values(service.http)
    job_id = service.submit(make_scene(size=16, samples=500))
    service.wait(job_id, lambda job: bool(job["state"] == "succeeded"))
    report = service.http.get(f"/api/v1/jobs/{job_id}/report.json").json()
    after = values(service.http)
    grew = {key: value - before.get(key, 0) for key, value in after.items()}
    assert grew["woodcock_jobs_finished_total", "succeeded"] == 1
    assert grew["woodcock_jobs_finished_total", "failed"] == 0
    assert grew["woodcock_jobs", "succeeded"] == 1
    for use in report["devices"]:
        assert grew["woodcock_samples_total", use["id"]] == use["samples"] * 16 * 16
        assert grew["woodcock_render_seconds_total", use["id"]] == pytest.approx(use["render_seconds"])
        assert 0 < after["woodcock_device_utilisation_ratio", use["id"]] <= 1.01
    for stage in ("merge", "check", "write"):
        assert grew["woodcock_stage_seconds_total", stage] >= report["seconds"][stage] > 0
    for stage in ("read", "build", "upload"):
        assert grew["woodcock_stage_seconds_total", stage] >= report["seconds"][stage]
    for histogram in ("queue_wait_seconds", "first_preview_seconds", "relative_error_ratio", "efficiency"):
        assert grew[f"woodcock_{histogram}_count",] == 1
    assert grew["woodcock_relative_error_ratio_sum",] == pytest.approx(report["relative_rmse"])
    assert grew["woodcock_efficiency_sum",] == pytest.approx(report["efficiency"], rel=1e-6)
    assert grew["woodcock_slope_flagged_total",] == (report["slope"]["verdict"] == "flagged")
    lines = {key[1] for key in grew if key[0] == "woodcock_certificate_lines_failed_total" and grew[key]}
    assert lines == set(report["certificate"]["failed"])


def test_a_job_that_failed_is_counted_as_that(service: Service, make_scene: Make) -> None:
    before = values(service.http)
    stream = io.BytesIO()
    np.save(stream, np.full((4, 4, 4), -1, np.float32))
    volume = service.http.post("/api/v1/volumes?name=negative.npy", content=stream.getvalue()).json()
    job_id = service.submit(make_scene(volumes=[{"kind": "grid", "file": volume["id"], "albedo": 0.5}]))
    with pytest.raises(AssertionError):
        service.wait(job_id, lambda job: bool(job["state"] == "succeeded"))
    grew = {key: value - before.get(key, 0) for key, value in values(service.http).items()}
    assert grew["woodcock_jobs_finished_total", "failed"] == 1
    assert grew["woodcock_jobs_finished_total", "succeeded"] == 0
