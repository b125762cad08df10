"""Stability checks: what one does to a device, to its jobs, and to the service; and that its outcome lasts."""

from __future__ import annotations

import json
import math
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from woodcock.device import Device, devices
from woodcock.probe import Probe
from woodcock.stability import Row
from woodcock.stability.cases import CASES
from woodcock_server import app as application
from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.devices import repository
from woodcock_server.devices.schemas import StabilityRow
from woodcock_server.devices.service import Found, fingerprints

from .conftest import ADDRESS, Service
from .test_rendering import succeeded

Make = Callable[..., dict[str, Any]]

#: In place of the sweep, in the service's workers: what `answer` says, as soon as it says it.
STAND_IN = """
import json, os, pathlib, time
from woodcock import stability

def check(device):
    answer = pathlib.Path(__file__).with_name(f"{device.id}.json")
    while not answer.exists():
        time.sleep(0.02)
    rows = json.loads(answer.read_text())
    if rows is None:
        os.abort()
    answer.unlink()
    return {"rows": rows}

stability.check = check
"""


def row(says: str = "", **replaced: Any) -> dict[str, Any]:
    verdict = "failed" if says else "passed"
    case = {"group": "albedo", "case": "1", "expected": 1.0, "got": 1.5, "deviation": 9.0, "limit": 5.0}
    return {**case, "unit": "roundings", "verdict": verdict, "says": says, "seconds": 0.1, **replaced}


#: Devices of the service.
BOTH = ("cpu0", "cpu1")

BROKEN = [row(), row("off", got=float("nan")), *(row(f"off {number}") for number in range(5))]


# What outcomes depend on


@pytest.fixture
def device() -> Device:
    return devices()[0]


def test_an_outcome_is_of_a_device_its_driver_and_this_version(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    (print_,) = fingerprints([device])
    assert len(print_) == 64
    assert fingerprints([replace(device, id="cpu7")]) == [print_], "not of its number"
    for other in ("driver", "name", "platform", "version", "platform_version"):
        assert fingerprints([replace(device, **{other: "another"})]) != [print_]
    first, second = fingerprints([device, device])
    assert first == print_ != second, "of two of the same make one may be broken"
    monkeypatch.setattr("woodcock_server.devices.service.__version__", "1.2.3")
    assert fingerprints([device]) != [print_]


def test_the_newest_outcome_counts(tmp_path: Path, device: Device) -> None:
    engine = open_database(f"sqlite:///{tmp_path / 'test.sqlite'}")
    one, other = (Found(device, Probe((1,), None), name * 64) for name in "ab")
    now = datetime.now(UTC)
    with engine.begin() as connection:
        assert repository.newest(connection, []) == {}
        for found, rows in ((one, BROKEN), (other, [row()]), (one, [row()]), (other, BROKEN)):
            repository.add(connection, found, now, now, [{**each, "got": None} for each in rows])
        assert repository.failed(connection, ["a" * 64, "b" * 64, "c" * 64]) == {"b" * 64}
        newest = repository.newest(connection, ["a" * 64, "b" * 64, "c" * 64])
    engine.dispose()
    assert {name: outcome["passed"] for name, outcome in newest.items()} == {"a" * 64: True, "b" * 64: False}


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_not_kept_as_a_number(value: float) -> None:
    kept = StabilityRow.model_validate(row("off", expected=value, got=value, deviation=value, limit=value))
    assert (kept.expected, kept.got, kept.deviation, kept.limit) == (None, None, None, None), "JSON has none such"


# Devices that there are not


def test_a_device_that_there_is_not_is_not_checked(client: TestClient) -> None:
    for ask in (client.get, client.post):
        answer = ask("/api/v1/devices/cpu0/stability")
        assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json")
        assert answer.json()["detail"] == "There is no device cpu0; there are: none."


def test_a_job_cannot_ask_for_a_device_that_there_is_not(client: TestClient, make_scene: Make) -> None:
    answer = client.post("/api/v1/jobs", json={"scene": make_scene(), "device": "cpu0"})
    assert answer.status_code == 422
    message = "must be any, or the kind or id of a device of this server: there is none"
    assert answer.json()["errors"] == [{"field": "device", "message": message}]


def test_a_device_that_cannot_be_used_is_neither_checked_nor_asked_for(
    tmp_path: Path, device: Device, make_scene: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = [Found(replace(device, id=id), Probe((), f"{id} is on fire"), id * 16) for id in ("gpu0", "gpu1")]
    monkeypatch.setattr(application, "discover", lambda: found)
    with TestClient(application.create_app(Settings(data=tmp_path)), ADDRESS) as client:
        (shown, _) = client.get("/api/v1/devices").json()["items"]
        assert (shown["state"], shown["fault"], shown["stability"]) == ("failed", "gpu0 is on fire", "not checked")
        answer = client.post("/api/v1/devices/gpu0/stability")
        assert answer.status_code == 409
        assert answer.json()["detail"] == "gpu0 cannot be used: gpu0 is on fire"
        for asked, says in (
            ("gpu0", "gpu0 cannot be used: gpu0 is on fire"),
            ("cpu3", "must be any, or the kind or id of a device of this server: cpu, gpu0, gpu1"),
        ):
            answer = client.post("/api/v1/jobs", json={"scene": make_scene(), "device": asked})
            assert answer.status_code == 422
            assert answer.json()["errors"] == [{"field": "device", "message": says}]


# Kinds


def test_a_job_may_ask_for_a_kind(service: Service, make_scene: Make) -> None:
    job = service.wait(
        service.submit(make_scene(size=64, stop={"kind": "seconds", "seconds": 1}), "cpu"), succeeded, 120
    )
    assert (job["device"], set(job["devices"])) == ("cpu", {"cpu0", "cpu1"})
    for device in service.http.get("/api/v1/devices").json()["items"]:
        assert device["speed"] > 1000
    answer = service.http.post("/api/v1/jobs", json={"scene": make_scene(), "device": "gpu"})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["message"].endswith("a device of this server: cpu, cpu0, cpu1")


# A service whose sweeps say what a test tells them to


@pytest.fixture(scope="module")
def checked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    service = Service(tmp_path_factory.mktemp("checked"), STAND_IN, WOODCOCK_LEASE_SECONDS="1")
    service.start()
    yield service
    if service.process is not None:
        service.stop()


def answer(service: Service, device_id: str, rows: list[dict[str, Any]] | None) -> None:
    """Let the device's sweep end with these rows; None: take its process with it, again and again."""
    hidden = service.data / "answer"
    hidden.write_text(json.dumps(rows))
    hidden.rename(service.data / f"{device_id}.json")


def ask(service: Service, device_id: str) -> dict[str, Any]:
    answer = service.http.post(f"/api/v1/devices/{device_id}/stability")
    assert answer.status_code == 202, answer.text
    assert answer.headers["location"] == f"/api/v1/devices/{device_id}/stability"
    state: dict[str, Any] = answer.json()
    return state


def ended(
    service: Service, device_id: str, reached: Callable[[dict[str, Any]], bool] | None = None, seconds: float = 30
) -> dict[str, Any]:
    """The device's check as soon as it has ended, or is as wanted."""
    end = time.monotonic() + seconds
    while True:
        state: dict[str, Any] = service.http.get(f"/api/v1/devices/{device_id}/stability").raise_for_status().json()
        if reached(state) if reached else state["state"] != "running":
            return state
        assert time.monotonic() < end, f"{state}\n{service.log.read_text()}"
        time.sleep(0.05)


def shown(service: Service, device_id: str) -> dict[str, Any]:
    items = service.http.get("/api/v1/devices").raise_for_status().json()["items"]
    return next(device for device in items if device["id"] == device_id)


def test_a_check_waits_for_the_job_in_hand_and_the_next_job_for_the_check(checked: Service, make_scene: Make) -> None:
    before = shown(checked, "cpu0")
    assert (before["state"], before["stability"], before["checked_at"]) == ("ready", "not checked", None)
    assert (before["failures"], before["links"]) == ([], {"stability": None})
    never = checked.http.get("/api/v1/devices/cpu0/stability")
    assert never.status_code == 404
    assert never.json()["detail"] == "cpu0 is not checked; a POST to /api/v1/devices/cpu0/stability checks it."

    in_hand = checked.submit(make_scene(size=64, stop={"kind": "seconds", "seconds": 1.5}))
    checked.wait(in_hand, lambda job: job["samples"] > 0)
    assert [(shown(checked, each)["job"], shown(checked, each)["waiting"]) for each in BOTH] == 2 * [(in_hand, 0)]
    asked = ask(checked, "cpu0")
    assert (asked["device"], asked["state"], asked["started_at"], asked["rows"]) == ("cpu0", "running", None, [])
    assert shown(checked, "cpu0")["stability"] == "running"
    assert set(checked.wait(in_hand, succeeded)["devices"]) == {"cpu0", "cpu1"}, "it is not disturbed"
    running = ended(checked, "cpu0", lambda state: state["started_at"] is not None)
    assert running["state"] == "running"
    assert ask(checked, "cpu0") == running, "not begun a second time"
    assert shown(checked, "cpu0")["links"]["stability"] == "/api/v1/devices/cpu0/stability"

    named = checked.submit(make_scene(samples=4), "cpu0")
    whichever = checked.submit(make_scene(samples=4))
    assert checked.wait(whichever, succeeded)["devices"] == ["cpu1"], "a device that is checked renders nothing"
    waits = checked.job(named)
    assert (waits["state"], waits["waiting"]) == ("queued", "It waits for the stability check of cpu0.")
    assert waits["device"] == "cpu0"
    listed = {job["id"]: job["waiting"] for job in checked.http.get("/api/v1/jobs").json()["items"]}
    assert (listed[named], listed[whichever]) == (waits["waiting"], None)
    assert [(shown(checked, each)["job"], shown(checked, each)["waiting"]) for each in BOTH] == [(None, 1), (None, 0)]

    answer(checked, "cpu0", [row(), row(verdict="not expressible", says="nothing can express it", got=None)])
    outcome = ended(checked, "cpu0")
    assert (outcome["state"], outcome["started_at"]) == ("passed", running["started_at"])
    assert outcome["started_at"] < outcome["finished_at"]
    assert outcome["rows"][0] == row()
    after = shown(checked, "cpu0")
    assert (after["state"], after["stability"], after["failures"]) == ("ready", "passed", [])
    assert after["checked_at"] == outcome["finished_at"]
    job = checked.wait(named, succeeded)
    assert (job["devices"], job["waiting"]) == (["cpu0"], None)


@pytest.mark.slow
def test_a_device_that_failed_renders_only_what_asks_for_it(checked: Service, make_scene: Make) -> None:
    ask(checked, "cpu0")
    answer(checked, "cpu0", BROKEN)
    outcome = ended(checked, "cpu0")
    assert outcome["state"] == "failed"
    assert [each["got"] for each in outcome["rows"]] == [1.5, None, *5 * [1.5]], "NaN is no JSON"
    failed = shown(checked, "cpu0")
    assert (failed["state"], failed["stability"], failed["fault"]) == ("distrusted", "failed", None)
    assert failed["failures"] == ["albedo, 1: off", "albedo, 1: off 0", "albedo, 1: off 1"]
    assert (shown(checked, "cpu1")["state"], checked.http.get("/readyz").json()["devices"]) == ("ready", 1)
    assert checked.wait(checked.submit(make_scene(samples=4)), succeeded)["devices"] == ["cpu1"]

    ask(checked, "cpu1")
    answer(checked, "cpu1", BROKEN)
    ended(checked, "cpu1")
    health = checked.http.get("/readyz")
    assert health.status_code == 503
    assert health.json()["detail"].startswith("Every device that is ready failed its stability check, and renders only")
    waits = checked.submit(make_scene(samples=5))
    assert shown(checked, "cpu0")["waiting"] == 0, "it does not ask for this device"
    for device_id in ("cpu0", "cpu1"):
        named = checked.wait(checked.submit(make_scene(samples=4), device_id), succeeded)
        assert named["devices"] == [device_id]
    job = checked.job(waits)
    assert (job["state"], job["waiting"]) == ("queued", health.json()["detail"])

    # The service is killed: what failed has failed, and what was under way was not.
    ask(checked, "cpu1")
    ended(checked, "cpu1", lambda state: state["started_at"] is not None)
    again = shown(checked, "cpu1")
    assert (again["state"], again["stability"]) == ("distrusted", "running"), "it is trusted again when it has passed"
    checked.stop(signal.SIGKILL)
    checked.start()
    assert ended(checked, "cpu0") == outcome
    assert {shown(checked, device_id)["stability"] for device_id in ("cpu0", "cpu1")} == {"failed"}
    assert checked.job(waits)["state"] == "queued"

    ask(checked, "cpu1")
    answer(checked, "cpu1", [row()])
    assert ended(checked, "cpu1")["state"] == "passed"
    assert checked.wait(waits, succeeded)["devices"] == ["cpu1"]
    assert checked.http.get("/readyz").status_code == 200


@pytest.mark.slow
def test_a_check_whose_process_dies_has_failed(checked: Service, make_scene: Make) -> None:
    answer(checked, "cpu1", None)
    ask(checked, "cpu1")
    outcome = ended(checked, "cpu1", seconds=60)
    (checked.data / "cpu1.json").unlink()
    assert outcome["state"] == "failed"
    (only,) = outcome["rows"]
    assert (only["verdict"], only["says"]) == ("failed", "The process that checks cpu1 died 4 times.")
    assert shown(checked, "cpu1")["failures"] == ["check, as a whole: The process that checks cpu1 died 4 times."]
    job = checked.wait(checked.submit(make_scene(samples=4), "cpu1"), succeeded)
    assert job["devices"] == ["cpu1"], "the service itself is well"


def test_a_check_that_cannot_be_carried_out_has_failed(checked: Service) -> None:
    answer(checked, "cpu1", [row(seconds="long")])
    ask(checked, "cpu1")
    (only,) = ended(checked, "cpu1")["rows"]
    assert only["says"].startswith("The check could not be carried out: ")


def test_a_check_does_not_hold_up_the_end(checked: Service) -> None:
    ask(checked, "cpu0")
    ended(checked, "cpu0", lambda state: state["started_at"] is not None)
    said = checked.log.read_text()
    began = time.monotonic()
    assert checked.stop() == 130
    assert time.monotonic() - began < 15
    assert "Traceback" not in checked.log.read_text().removeprefix(said)


# The sweep itself


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_this_machine_passes_its_check(service: Service, make_scene: Make) -> None:
    ask(service, "cpu0")
    assert service.wait(service.submit(make_scene(samples=4)), succeeded)["devices"] == ["cpu1"]
    outcome = ended(service, "cpu0", seconds=1700)
    assert [(each["group"], each["case"]) for each in outcome["rows"]] == [(case.group, case.name) for case in CASES]
    assert set(outcome["rows"][0]) == set(Row.__annotations__)
    assert outcome["state"] == "passed", [each for each in outcome["rows"] if each["verdict"] == "failed"]
    assert set(service.wait(service.submit(make_scene(samples=4)), succeeded)["devices"]) == {"cpu0", "cpu1"}
