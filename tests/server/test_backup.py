"""A copy of what a service keeps is a data folder: another service goes on from it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from woodcock_client.cli import build
from woodcock_server.backup import BackupError, copy
from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.storage import Storage

from .conftest import Service

MakeScene = Callable[..., dict[str, Any]]


def ended(job: dict[str, Any]) -> bool:
    return bool(job["finished_at"])


@pytest.mark.slow
def test_another_service_goes_on_from_a_backup(own_service: Service, tmp_path: Path, make_scene: MakeScene) -> None:
    own_service.start()
    done = own_service.submit(make_scene(), name="done")
    own_service.wait(done, ended)
    upload = (
        own_service.http.post("/api/v1/volumes", params={"name": "x.ply"}, content=TRIANGLE).raise_for_status().json()
    )
    scene = make_scene(size=64, samples=300)
    running = own_service.submit(scene, name="running")
    own_service.wait(running, lambda job: job["samples"] > 0)
    target = tmp_path / "backup"
    made = CliRunner().invoke(build(["backup"]), ["backup", str(target), "--data", str(own_service.data)])
    assert made.exit_code == 0, made.output
    own_service.wait(running, ended)
    pictures = [own_service.http.get(f"/api/v1/jobs/{job}/image.exr").content for job in (done, running)]
    assert [path.parent.name for path in target.rglob("film-*")] == [done]
    assert {path.name for path in target.iterdir()} == {"woodcock.sqlite", "volumes", "jobs", "scratch"}

    other = Service(target, WOODCOCK_LEASE_SECONDS="1")
    other.start()
    try:
        assert other.job(done)["state"] == "succeeded"
        assert other.http.get(f"/api/v1/jobs/{done}/image.exr").content == pictures[0]
        assert other.http.get(f"/api/v1/volumes/{upload['id']}").json() == upload
        again = other.wait(running, ended)
        assert (again["state"], again["samples"]) == ("succeeded", 300)
        counts = [point["samples"] for point in other.http.get(again["links"]["report"]).json()["error"]]
        assert counts == sorted(set(counts)), "the error series is this attempt's"
    finally:
        other.stop()


def test_a_service_that_never_ran_is_backed_up(tmp_path: Path) -> None:
    """It may have tokens."""
    data = tmp_path / "data"
    open_database(Settings(data=Storage(data).root).database).dispose()
    for folder in ("volumes", "jobs", "scratch"):
        (data / folder).rmdir()
    copy(Settings(data=data), tmp_path / "to")
    assert (tmp_path / "to" / "woodcock.sqlite").is_file()


def test_what_cannot_be_backed_up_is_told(tmp_path: Path) -> None:
    with pytest.raises(BackupError, match="There is no service's data in"):
        copy(Settings(data=tmp_path / "none"), tmp_path / "to")
    with pytest.raises(BackupError, match="pg_dump"):
        copy(Settings(data=tmp_path, database_url="postgresql://here/renders"), tmp_path / "to")
    (tmp_path / "woodcock.sqlite").write_bytes(b"no database")
    with pytest.raises(BackupError, match="exists already"):
        copy(Settings(data=tmp_path), tmp_path)
    with pytest.raises(BackupError, match="cannot be copied: file is not a database"):
        copy(Settings(data=tmp_path), tmp_path.with_name("to"))
    assert not list(tmp_path.parent.glob("to*")), "nothing is left of a backup that was not made"


TRIANGLE = b"""ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""
