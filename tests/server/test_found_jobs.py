"""Jobs are found by what rendered them, and counted by all by which they are found, in either database."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Any

from sqlalchemy import Engine
from starlette.testclient import TestClient

from woodcock_server.jobs import listing, repository
from woodcock_server.jobs.listing import Filter
from woodcock_server.tables import job_devices, job_tags, jobs

from .conftest import SCENE

NOW = datetime(2030, 1, 2, tzinfo=UTC)
ASKED = {"name": "", "scene": SCENE, "device": "any"}


def use(integrator: str) -> dict[str, Any]:
    """As much of what a device says as listings need."""
    return {"kinds": {"integrator": [integrator]}}


def rendered(engine: Engine, tags: list[str], *usages: dict[str, Any]) -> str:
    """A job that a dispatcher claims, and whose usage it writes; its id."""
    with engine.begin() as connection:
        job = repository.add(connection, {**ASKED, "tags": tags}, NOW)
        claimed = repository.claim(connection, job, "a", NOW, timedelta(seconds=1))
        assert claimed is not None
    for usage in usages:
        with engine.begin() as connection:
            assert repository.write_held(connection, job, claimed["token"], {"usage": usage})
    return job


def found(engine: Engine, **meant: Any) -> list[str]:
    with engine.connect() as connection:
        return [row["id"] for row in listing.page(connection, 10, None, Filter(**meant))[0]]


def test_jobs_are_found_by_what_rendered_them(engine: Engine) -> None:
    path, shadow = use("volumetric_path"), use("transmittance")
    one = rendered(engine, [], {"gpu1": path}, {"gpu1": path, "cpu0": path})
    two = rendered(engine, [], {"cpu0": shadow})
    rendered(engine, [])
    assert found(engine, device="cpu0") == [two, one]
    assert found(engine, device="gpu1") == [one]
    assert found(engine, device="gpu") == []
    assert found(engine, integrator="transmittance") == [two]
    assert found(engine, device="gpu1", integrator="transmittance") == []
    with engine.connect() as connection:
        rows = {row["id"]: row for row in listing.page(connection, 10, None, Filter())[0]}
        whole = repository.get(connection, one)
    assert whole is not None
    assert rows[one] == {name: value for name, value in whole.items() if name not in listing.LONG}
    assert (rows[one]["devices"], rows[one]["integrator"]) == (["cpu0", "gpu1"], "volumetric_path")


def test_what_goes_on_from_another_was_rendered_by_its_devices(engine: Engine) -> None:
    with engine.begin() as connection:
        job = repository.add(connection, {**ASKED, "usage": {"cpu0": use("transmittance")}}, NOW)
    assert found(engine, device="cpu0") == found(engine, integrator="transmittance") == [job]


def test_jobs_have_all_tags_that_are_asked_for(engine: Engine) -> None:
    one, two = rendered(engine, ["a", "b"]), rendered(engine, ["b", "c"])
    assert found(engine, tags=["b"]) == [two, one]
    assert found(engine, tags=["b", "a"]) == [one]
    assert found(engine, tags=["a", "c"]) == []


def test_all_are_counted_by_what_they_are_found_by(engine: Engine) -> None:
    first = rendered(engine, ["b", "a"], {"cpu0": use("transmittance")})
    rendered(engine, ["a"], {"cpu0": use("volumetric_path"), "gpu0": use("volumetric_path")})
    rendered(engine, [])

    def counted() -> tuple[dict[str, int], ...]:
        with engine.connect() as connection:
            columns = (job_tags.c.tag, job_devices.c.device, jobs.c.integrator)
            return tuple(listing.counted(connection, column) for column in columns)

    assert counted() == ({"a": 2, "b": 1}, {"cpu0": 2, "gpu0": 1}, {"transmittance": 1, "volumetric_path": 1})
    with engine.begin() as connection:
        repository.cancel(connection, first, NOW)
        assert repository.let_go(connection, first, 1, NOW)
        assert repository.remove(connection, first)
    assert counted() == ({"a": 1}, {"cpu0": 1, "gpu0": 1}, {"volumetric_path": 1})


def test_only_what_most_jobs_have_is_counted(engine: Engine) -> None:
    rendered(engine, ["most", *(f"tag {number:03}" for number in range(listing.MOST_COUNTED))])
    rendered(engine, ["most", "tag 199"])
    with engine.connect() as connection:
        found = listing.counted(connection, job_tags.c.tag)
    assert list(found) == ["most", *(f"tag {number:03}" for number in range(listing.MOST_COUNTED - 2)), "tag 199"]


def test_the_service_counts_its_jobs(client: TestClient, make_scene: Callable[..., dict[str, Any]]) -> None:
    before = client.get("/api/v1/jobs/counts").json()
    for _ in range(2):
        client.post("/api/v1/jobs", json={"scene": make_scene(), "tags": ["counted"]}).raise_for_status()
    counts = client.get("/api/v1/jobs/counts").json()
    assert counts == {
        "states": {**before["states"], "queued": before["states"]["queued"] + 2},
        "tags": {**before["tags"], "counted": 2},
        "devices": {},
        "integrators": {},
    }
    assert set(counts["states"]) == {"queued", "running", "cancelling", "succeeded", "failed", "cancelled"}
    page = client.get("/api/v1/jobs", params={"tag": ["counted", "other"]}).json()
    assert page["items"] == client.get("/api/v1/jobs", params={"device": "cpu0"}).json()["items"] == []
    assert client.get("/api/v1/jobs", params={"integrator": "transmittance", "tag": "counted"}).json()["items"] == []
