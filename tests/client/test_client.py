"""The client against a real socket: what it sends, what it makes of refusals, and what it does when things break."""

from __future__ import annotations

import ast
import hashlib
import socket
import threading
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from pydantic import ValidationError

import woodcock_client
from woodcock.scene import Scene, SceneError, files, with_files
from woodcock_client import Client, ServiceError, Unreachable, Webhook, client

if TYPE_CHECKING:
    from .service import Service


@pytest.fixture
def talk(service: Service) -> Iterator[Client]:
    with Client(service.url, timeout=5) as talk:
        yield talk


@pytest.fixture
def scene(scene_json: dict[str, Any]) -> Scene:
    return Scene.model_validate(scene_json)


@pytest.fixture
def grid_scene(scene: Scene, tmp_path: Path) -> Scene:
    (tmp_path / "cloud.vdb").write_bytes(b"voxels" * 50_000)
    grid = {"kind": "grid", "file": str(tmp_path / "cloud.vdb"), "albedo": 0.9}
    return Scene.model_validate({**scene.model_dump(), "volumes": [grid]})


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "RECONNECT", (0.01, 0.02))


@pytest.fixture
def nowhere() -> str:
    """An address where nothing listens."""
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return f"http://127.0.0.1:{s.getsockname()[1]}"


# What is imported


def test_client_imports_the_scene_and_nothing_else_of_the_house() -> None:
    for path in Path(woodcock_client.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or "."] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                foreign = name.split(".")[0] in ("woodcock", "woodcock_server") and name != "woodcock.scene"
                assert not foreign, f"{path.name} imports {name}"


# Jobs


def test_a_submitted_scene_comes_back(talk: Client, scene: Scene) -> None:
    job = talk.submit(scene, name="box <b>")
    assert (job.state, job.name, job.scene, job.target) == ("queued", "box <b>", scene, scene.stop)
    assert talk.job(job.id) == job
    assert isinstance(job.created_at, datetime)
    assert job.created_at.tzinfo == UTC


def test_a_webhook_is_asked_for(service: Service, talk: Client, scene: Scene) -> None:
    assert talk.submit(scene).webhook is None
    job = talk.submit(scene, webhook="https://example.org/", webhook_secret="whsec_a")
    assert job.webhook == Webhook(url="https://example.org/", state="waiting", attempts=0)
    assert service.secrets == {"job0000": None, job.id: "whsec_a"}


def test_answers_are_frozen(talk: Client, scene: Scene) -> None:
    job = talk.submit(scene)
    with pytest.raises(ValidationError, match="frozen"):
        job.samples = 3  # type: ignore[misc]


def test_keys_of_a_newer_service_are_ignored(service: Service, talk: Client, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json)
    service.update(id, priority=7, links={**service.jobs[id]["links"], "denoised": "/x"})
    assert talk.job(id).id == id


def test_jobs_are_listed_newest_first_over_pages(
    service: Service, talk: Client, scene_json: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(client, "PAGE", 2)
    ids = [service.add(scene_json) for _ in range(5)]
    service.finish(ids[1])
    assert [job.id for job in talk.jobs()] == ids[::-1]
    assert [job.id for job in talk.jobs(state="succeeded")] == [ids[1]]


def test_devices(talk: Client) -> None:
    (device,) = talk.devices()
    assert (device.id, device.lanes, device.state) == ("cpu0", (1, 4, 8), "ready")
    assert (device.stability, device.checked_at) == ("passed", datetime(2025, 1, 1, tzinfo=UTC))


def test_a_device_is_checked(service: Service, talk: Client) -> None:
    with pytest.raises(ServiceError) as caught:
        talk.stability("cpu0")
    assert caught.value.status == 404
    asked = talk.check_device("cpu0")
    assert (asked.device, asked.state, asked.started_at, asked.rows) == ("cpu0", "running", None, ())
    row = {"group": "albedo", "case": "1", "unit": "roundings", "verdict": "failed", "says": "off", "seconds": 1.5}
    at = {"started_at": "2025-01-01T00:00:00Z", "finished_at": "2025-01-01T00:01:00Z"}
    numbers = {"expected": 1.0, "got": None, "deviation": None, "limit": 5.0}
    service.checks["cpu0"] |= {"state": "failed", **at, "rows": [{**row, **numbers}]}
    outcome = talk.stability("cpu0")
    assert (outcome.state, outcome.finished_at) == ("failed", datetime(2025, 1, 1, 0, 1, tzinfo=UTC))
    (case,) = outcome.rows
    assert (case.group, case.verdict, case.says, case.expected, case.got) == ("albedo", "failed", "off", 1.0, None)
    with pytest.raises(ServiceError, match=r"There is no device gpu\?0"):
        talk.check_device("gpu?0")


def test_a_job_asks_for_a_device(service: Service, talk: Client, scene: Scene) -> None:
    assert talk.submit(scene).device == "any"
    job = talk.submit(scene, device="cpu0")
    assert (job.device, job.waiting) == ("cpu0", None)
    service.update(job.id, waiting="It waits for the stability check of cpu0.")
    assert talk.job(job.id).waiting == "It waits for the stability check of cpu0."
    with pytest.raises(ServiceError, match=r"\ndevice: must be any, or the kind or id of a device$"):
        talk.submit(scene, device="gpu0")


# Refusals


def test_a_refusal_carries_its_fields(talk: Client, grid_scene: Scene) -> None:
    unknown = with_files(grid_scene, lambda file: f"sha256:{0:064}")
    with pytest.raises(ServiceError) as caught:
        talk.submit(unknown)
    assert caught.value.status == 422
    assert str(caught.value) == "the scene is not valid\nscene.volumes[0].file: must be sha256:… of an upload"
    assert caught.value.errors[0].field == "scene.volumes[0].file"


def test_an_unknown_job_is_a_404(talk: Client) -> None:
    with pytest.raises(ServiceError, match=r"nothing at /api/v1/jobs/no/../such") as caught:
        talk.job("no/../such")
    assert caught.value.status == 404


def test_a_proxys_page_is_told_by_its_status(service: Service, talk: Client) -> None:
    service.broken = (502, "text/html", b"<h1>Bad gateway</h1>")
    with pytest.raises(ServiceError, match=f"^{service.url} answered 502 Bad Gateway$"):
        talk.devices()


def test_another_kind_of_service_is_recognised(service: Service, talk: Client) -> None:
    service.broken = (200, "text/html", b"<h1>Welcome</h1>")
    with pytest.raises(ServiceError, match="did not answer as a Woodcock service"):
        talk.devices()


def test_nobody_there(nowhere: str) -> None:
    with Client(nowhere) as talk, pytest.raises(Unreachable, match=f"^no answer from the service at {nowhere}: "):
        talk.devices()


@pytest.mark.parametrize("address", ["", "localhost:8000", "ftp://farm", "http://", "http://farm:port", "/tmp"])
def test_an_address_must_be_http(address: str) -> None:
    with pytest.raises(ValueError, match=r"must look like http://127.0.0.1:8000"):
        Client(address)


# Files


def test_a_volume_is_uploaded_once(service: Service, talk: Client, grid_scene: Scene, tmp_path: Path) -> None:
    digest = hashlib.sha256((tmp_path / "cloud.vdb").read_bytes()).hexdigest()
    for _ in range(2):
        job = talk.submit(grid_scene)
        assert job.scene.volumes[0].file == f"sha256:{digest}"  # type: ignore[union-attr]
    assert service.requests.count(("POST", "/api/v1/volumes")) == 1
    assert service.volumes[f"sha256:{digest}"]["name"] == "cloud.vdb"
    assert service.volumes[f"sha256:{digest}"]["size"] == 300_000


def test_a_volume_named_by_digest_is_not_uploaded(service: Service, talk: Client, grid_scene: Scene) -> None:
    there = talk.submit(grid_scene).scene
    service.requests.clear()
    assert talk.submit(there).scene == there
    assert service.requests == [("POST", "/api/v1/jobs")]


def test_every_file_that_a_scene_names_is_uploaded_once(
    service: Service, talk: Client, scene_json: dict[str, Any], tmp_path: Path
) -> None:
    for name in ("cloud.vdb", "heat.vdb", "cube.obj", "sky.exr"):
        (tmp_path / name).write_text(name)
    cloud, heat, cube, sky = (str(tmp_path / name) for name in ("cloud.vdb", "heat.vdb", "cube.obj", "sky.exr"))
    scene_json["volumes"] = [
        {**scene_json["volumes"][0], "shape": {"kind": "mesh", "file": cube}},
        {
            "kind": "grid",
            "file": cloud,
            "albedo": 0.9,
            "albedo_grid": {"file": cloud, "grid": "tint"},
            "emission": {"kind": "blackbody", "file": heat, "kelvin": 3000},
        },
    ]
    scene_json["surfaces"] = [{"kind": "mesh", "file": cube}]
    scene_json["lights"] = [{"kind": "image", "file": sky}]
    job = talk.submit(Scene.model_validate(scene_json))
    assert set(files(job.scene)) == set(service.volumes)
    assert service.requests.count(("POST", "/api/v1/volumes")) == 4
    found = {volume["name"]: talk.volume(id) for id, volume in service.volumes.items()}
    assert [found[name].type for name in ("cloud.vdb", "cube.obj", "sky.exr")] == ["volume", "mesh", "picture"]
    assert (found["cube.obj"].triangles, found["sky.exr"].width, found["cloud.vdb"].triangles) == (12, 4, None)


def test_a_missing_volume_file_is_named(talk: Client, grid_scene: Scene, tmp_path: Path) -> None:
    (tmp_path / "cloud.vdb").unlink()
    with pytest.raises(SceneError, match=r"^\S+cloud.vdb: No such file or directory$"):
        talk.submit(grid_scene)


def test_a_failing_service_is_not_taken_for_a_missing_volume(service: Service, talk: Client, grid_scene: Scene) -> None:
    service.broken = (503, "application/problem+json", b'{"title":"Unavailable","detail":"no database"}')
    with pytest.raises(ServiceError, match=r"^no database$"):
        talk.submit(grid_scene)
    assert [method for method, _ in service.requests] == ["GET"]


# Following


def test_follow_tells_each_change_and_ends(service: Service, talk: Client, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json)
    seen = []
    for job in talk.follow(id):
        seen.append((job.state, job.samples))
        if job.samples < 64:
            service.advance(id, job.samples + 32)
        elif job.state == "running":
            service.finish(id)
    assert seen == [("queued", 0), ("running", 32), ("running", 64), ("succeeded", 64)]


@pytest.mark.usefixtures("hasty")
def test_follow_picks_up_a_broken_stream(service: Service, talk: Client, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json)
    service.streams_to_cut = 3
    seen = []
    for job in talk.follow(id):
        seen.append(job.samples)
        service.advance(id, job.samples + 16) if job.samples < 64 else service.finish(id)
    assert seen == [0, 16, 32, 48, 64, 64]  # none twice, none missed
    assert service.streams_to_cut == 0


@pytest.mark.usefixtures("hasty")
def test_follow_without_streams_reads_the_state(service: Service, talk: Client, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json)
    service.streams_to_cut = 1 << 30
    timer = threading.Timer(0.2, service.finish, [id])
    timer.start()
    assert [job.state for job in talk.follow(id)] == ["queued", "succeeded"]
    timer.join()


@pytest.mark.usefixtures("hasty")
def test_follow_waits_out_an_outage(service: Service, talk: Client, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json)
    service.broken = (503, "text/plain", b"starting")

    def recover() -> None:
        service.broken = None
        service.finish(id)

    timer = threading.Timer(0.2, recover)
    timer.start()
    assert [job.state for job in talk.follow(id)][-1] == "succeeded"
    timer.join()


@pytest.mark.usefixtures("hasty")
def test_follow_gives_up_when_the_outage_lasts(nowhere: str) -> None:
    with Client(nowhere, timeout=0.1) as talk, pytest.raises(Unreachable):
        list(talk.follow("job"))


def test_follow_of_an_unknown_job_fails_at_once(talk: Client) -> None:
    with pytest.raises(ServiceError, match="nothing at"):
        list(talk.follow("nope"))


# Fetching


def test_fetch_saves_the_whole_file(service: Service, talk: Client, scene_json: dict[str, Any], tmp_path: Path) -> None:
    id = service.add(scene_json)
    service.finish(id)
    (tmp_path / "out.exr").write_bytes(b"older")
    talk.fetch(id, "image.exr", tmp_path / "out.exr")
    assert (tmp_path / "out.exr").read_bytes() == service.artifacts[id, "image.exr"]
    assert [path.name for path in tmp_path.iterdir()] == ["out.exr"]


def test_fetch_of_a_cut_answer_leaves_the_old_file(
    service: Service, talk: Client, scene_json: dict[str, Any], tmp_path: Path
) -> None:
    id = service.add(scene_json)
    service.finish(id)
    service.truncate = True
    (tmp_path / "out.exr").write_bytes(b"older")
    with pytest.raises(Unreachable):
        talk.fetch(id, "image.exr", tmp_path / "out.exr")
    assert (tmp_path / "out.exr").read_bytes() == b"older"
    assert [path.name for path in tmp_path.iterdir()] == ["out.exr"]


def test_fetch_before_there_is_anything(
    service: Service, talk: Client, scene_json: dict[str, Any], tmp_path: Path
) -> None:
    with pytest.raises(ServiceError, match=r"preview.png does not exist yet"):
        talk.fetch(service.add(scene_json), "preview.png", tmp_path / "p.png")
    assert list(tmp_path.iterdir()) == []
