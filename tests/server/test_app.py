"""Health, devices, gallery, and what the API says of itself."""

from __future__ import annotations

import pytest
from starlette.testclient import TestClient

from .conftest import Service


def test_a_service_without_devices_is_not_well(client: TestClient) -> None:
    answer = client.get("/readyz")
    assert (answer.status_code, answer.headers["content-type"]) == (503, "application/problem+json")
    assert answer.json()["detail"] == "No OpenCL device is ready; /api/v1/devices says why."
    assert client.get("/api/v1/devices").json() == {"items": []}
    assert client.get("/healthz").json()["status"] == "ok"  # the process is


def test_a_service_that_cannot_write_is_not_well(service: Service) -> None:
    scratch = service.data / "scratch"
    scratch.rename(service.data / "away")
    try:
        answer = service.http.get("/readyz")
    finally:
        (service.data / "away").rename(scratch)
    assert answer.status_code == 503
    assert answer.json()["detail"] == "The data folder cannot be written: No such file or directory."


def test_devices_say_what_they_are(service: Service) -> None:
    assert service.http.get("/readyz").json()["status"] == "ok"
    devices = service.http.get("/api/v1/devices").json()["items"]
    assert {"cpu0", "cpu1"} <= {device["id"] for device in devices if device["kind"] == "cpu"}
    for device in devices:
        assert (device["state"], device["fault"]) == ("ready", None)
        assert 1 in device["lanes"]
        assert device["memory"] > 0
        assert set(device) == {
            "id", "host", "name", "platform", "driver", "kind", "compute_units", "memory", "lanes", "speed", "state",
            "fault", "stability", "checked_at", "failures", "job", "waiting", "links",
        }  # fmt: skip


@pytest.mark.parametrize(
    "path", ["/", "/renders/any", "/batches/any", "/compare", "/submit", "/fleet", "/web/index.html"]
)
def test_the_gallery_is_served(client: TestClient, path: str) -> None:
    answer = client.get(path)
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")


def test_nothing_but_the_gallery_is_served(client: TestClient) -> None:
    assert client.get("/web/../cli.py").status_code == 404
    assert client.get("/web/%2e%2e/cli.py").status_code == 404


def test_the_api_describes_itself(client: TestClient) -> None:
    paths = client.get("/openapi.json").json()["paths"]
    assert set(paths) == {
        "/api/v1/batches", "/api/v1/batches/{id}", "/api/v1/batches/{id}/cancel",
        "/api/v1/comparisons", "/api/v1/comparisons/{id}", "/api/v1/comparisons/{id}/report.html",
        "/api/v1/jobs", "/api/v1/jobs/check", "/api/v1/jobs/counts", "/api/v1/jobs/delete",
        "/api/v1/jobs/{id}", "/api/v1/jobs/{id}/events",
        "/api/v1/jobs/{id}/cancel", "/api/v1/jobs/{id}/retry",
        "/api/v1/jobs/{id}/extend", "/api/v1/jobs/{id}/image.exr",
        "/api/v1/jobs/{id}/preview.png", "/api/v1/jobs/{id}/thumbnail.webp", "/api/v1/jobs/{id}/report.json",
        "/api/v1/jobs/{id}/report.html",
        "/api/v1/jobs/{id}/differences/{other}", "/api/v1/jobs/{id}/differences/{other}/{map}",
        "/api/v1/jobs/{id}/layers", "/api/v1/jobs/{id}/layers/{name}", "/api/v1/jobs/{id}/pixels",
        "/api/v1/jobs/validate",
        "/api/v1/volumes", "/api/v1/volumes/{id}", "/api/v1/volumes/{id}/range", "/api/v1/volumes/{id}/slice.png",
        "/api/v1/examples", "/api/v1/devices", "/api/v1/devices/{id}/stability",
        "/api/v1/retention", "/api/v1/session", "/healthz", "/readyz", "/metrics",
    }  # fmt: skip
    checks = paths["/api/v1/devices/{id}/stability"]
    assert {"202", "404", "409"} <= set(checks["post"]["responses"])
    assert {"200", "404"} <= set(checks["get"]["responses"])
    for operations in paths.values():
        for operation in operations.values():
            for status, response in operation["responses"].items():
                if status >= "400":
                    assert set(response["content"]) == {"application/problem+json"}, "errors are problems"
    assert client.get("/docs").status_code == 200
