"""Dry runs: what a job would compile, take and last, and that nothing comes of asking."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from woodcock.device import devices
from woodcock.predict import Memory
from woodcock.probe import Probe
from woodcock.scene import load
from woodcock_client import Client
from woodcock_server import app as application
from woodcock_server.config import Settings
from woodcock_server.devices.service import Found
from woodcock_server.jobs import check as dry_run

from .conftest import ADDRESS, Service
from .test_rendering import succeeded

Make = Callable[..., dict[str, Any]]
NOT_KNOWN = ("seconds", "low", "high", "samples", "error", "build_seconds", "read_seconds")


def check(service: Service, scene: dict[str, Any], device: str = "any") -> dict[str, Any]:
    answer = service.http.post("/api/v1/jobs/check", json={"scene": scene, "device": device})
    assert answer.status_code == 200, answer.text
    told: dict[str, Any] = answer.json()
    return told


@pytest.mark.parametrize(
    "body",
    [
        {"scene": {"camera": {"kind": "none"}}},
        {"scene": "sunset", "device": "any"},
        {"device": "cpu9"},
        {"reference": "nobody"},
        {"colour": "blue"},
    ],
)
def test_what_cannot_be_submitted_cannot_be_checked(client: TestClient, make_scene: Make, body: dict[str, Any]) -> None:
    asked = {"scene": make_scene(), **body}
    submitted, checked = (client.post(f"/api/v1/jobs{end}", json=asked) for end in ("", "/check"))
    assert submitted.status_code == 422
    assert (checked.status_code, checked.json()) == (422, submitted.json())


def test_without_devices_nothing_is_known(client: TestClient, make_scene: Make) -> None:
    told = client.post("/api/v1/jobs/check", json={"scene": make_scene(samples=3)}).json()
    assert told == {"contract": {"kind": "samples", "samples": 3}, "program": None, "memory": None, "devices": []}
    assert client.get("/api/v1/jobs").json()["items"] == []


def test_a_device_that_cannot_be_used_says_why(
    tmp_path: Path, make_scene: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = [Found(replace(devices()[0], id="gpu0"), Probe((), "gpu0 is on fire"), "a" * 64)]
    monkeypatch.setattr(application, "discover", lambda: found)
    with TestClient(application.create_app(Settings(data=tmp_path)), ADDRESS) as client:
        (told,) = client.post("/api/v1/jobs/check", json={"scene": make_scene()}).json()["devices"]
    assert (told["id"], told["fits"], told["reason"]) == ("gpu0", False, "gpu0 is on fire")
    assert {told[key] for key in NOT_KNOWN} == {None}


def test_a_scene_may_be_too_large_in_one_piece_or_in_all() -> None:
    device = replace(devices()[0], memory=8 << 20, max_allocation=2 << 20)
    assert dry_run.too_large(Memory(device=8 << 20, largest=2 << 20, host=1 << 40), device) is None
    told = dry_run.too_large(Memory(device=8 << 20, largest=(2 << 20) + 1, host=0), device)
    assert told == "It has 2 MiB of memory in one piece; the scene needs 3 MiB."
    told = dry_run.too_large(Memory(device=(8 << 20) + 1, largest=1, host=0), device)
    assert told == "It has 8 MiB of memory in all; the scene needs 9 MiB."


def test_a_dry_run_tells_what_submitting_does(service: Service, make_scene: Make) -> None:
    scene = make_scene(size=64, samples=600)
    before = service.http.get("/api/v1/jobs").json()["items"]
    told = check(service, scene)
    assert service.http.get("/api/v1/jobs").json()["items"] == before, "nothing is queued"
    assert told["contract"] == scene["stop"]
    assert [device["id"] for device in told["devices"]] == ["cpu0", "cpu1"]
    for device in told["devices"]:
        assert (device["fits"], device["reason"]) == (True, None), device
        assert device["samples"] == 600
        assert 0 < device["low"] < device["seconds"] < device["high"]
        assert 0 < device["error"] < 1
        assert device["build_seconds"] > 0
        assert device["read_seconds"] > 0
    pixels = 64 * 64
    assert told["memory"]["device"] > pixels * 4 * (4 + 7), "four sums of a grey pixel, and its audit"
    assert told["memory"]["host"] > 3 * pixels * (4 + 16), "three films"

    job = service.wait(service.submit(scene, "cpu0"), succeeded, 120)
    report = service.http.get(job["links"]["report"]).json()
    program = told["program"]
    assert (program["hash"], program["kinds"]) == (report["program_hash"], report["kinds"])
    assert program["source_lines"] == report["program"]["source_lines"]
    assert (program["remained"], program["left_out"]) == (report["program"]["remained"], report["program"]["left_out"])
    expected = told["devices"][0]["error"]
    assert report["relative_rmse"] == pytest.approx(expected, rel=0.2)
    assert check(service, scene)["program"]["built"], "the dry run built it, if nobody had"


def test_a_device_that_renders_is_left_in_peace(service: Service, make_scene: Make) -> None:
    busy = service.submit(make_scene(size=32, stop={"kind": "seconds", "seconds": 6}), "cpu0")
    service.wait(busy, lambda job: job["samples"] > 0)
    first, second = check(service, make_scene())["devices"]
    assert first["says"] == "It renders a job; ask again when that has ended."
    assert (first["fits"], second["fits"]) == (True, True), "what the other found out holds for both"
    assert {first[key] for key in NOT_KNOWN} == {None}
    assert second["seconds"] > 0
    (alone,) = check(service, make_scene(), "cpu0")["devices"]
    if service.job(busy)["state"] == "running":
        assert (alone["fits"], alone["seconds"]) == (None, None), "nobody was free to find out"
    service.wait(busy, succeeded)


def test_a_file_that_cannot_be_used_is_why_it_does_not_fit(service: Service, make_scene: Make) -> None:
    uploaded = service.http.post(
        "/api/v1/volumes?name=thin.obj", content=b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    ).json()
    volume = {"kind": "constant", "shape": {"kind": "mesh", "file": uploaded["id"]}, "sigma_t": 1, "albedo": 0.5}
    (told, _) = check(service, make_scene(volumes=[volume]))["devices"]
    assert told["fits"] is False
    assert uploaded["id"] in told["reason"]
    assert {told[key] for key in NOT_KNOWN} == {None}


def test_the_client_shows_a_dry_run(service: Service, make_scene: Make, tmp_path: Path) -> None:
    (tmp_path / "cube.json").write_text(json.dumps(make_scene()))
    address = str(service.http.base_url)
    with Client(address) as client:
        told = client.check(load(tmp_path / "cube.json"), device="cpu0")
    (device,) = told.devices
    assert (device.id, device.fits, told.contract.kind) == ("cpu0", True, "samples")
    command = [sys.executable, "-m", "woodcock_client.cli", "submit", str(tmp_path / "cube.json"), "--check"]
    done = subprocess.run([*command, "--server", address], capture_output=True, text=True, timeout=100, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert told.program is not None
    for said in ("cpu0", "cpu1", "95 % interval", "By a pilot of", f"program {told.program.hash[:12]}", "memory: "):
        assert said in done.stdout
    refused = subprocess.run([*command, "--vary", "majorant=global,grid"], capture_output=True, text=True, check=False)
    assert (refused.returncode, refused.stderr) == (2, "woodcock: --check, --vary, --sweep and -o exclude each other\n")
