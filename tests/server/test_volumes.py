"""/api/v1/volumes"""

from __future__ import annotations

import hashlib
import io
import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

from .conftest import Service


def npy(shape: tuple[int, ...] = (2, 3, 4), value: float = 1.0) -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.full(shape, value, np.float32))
    return stream.getvalue()


def upload(client: TestClient, content: Any, name: str = "cloud.npy") -> Any:
    headers = {"content-type": "application/octet-stream"}
    return client.post("/api/v1/volumes", params={"name": name}, content=content, headers=headers)


def files(data: Path) -> set[str]:
    return {path.name for folder in ("volumes", "scratch") for path in (data / folder).iterdir() if path.is_file()}


def test_a_volume_is_stored_under_its_hash_once(client: TestClient, data: Path) -> None:
    content = npy()
    digest = hashlib.sha256(content).hexdigest()
    first = upload(client, content)
    assert first.status_code == 201
    volume = first.json()
    assert first.headers["location"] == f"/api/v1/volumes/{volume['id']}"
    assert (volume["id"], volume["name"], volume["size"]) == (f"sha256:{digest}", "cloud.npy", len(content))
    assert volume["grids"] == [{"name": "density", "type": "float32", "shape": [4, 3, 2], "voxels": 24}]
    again = upload(client, content, "another.npy")
    assert (again.status_code, again.json()) == (200, volume)
    assert client.get(first.headers["location"]).json() == volume
    assert (data / "volumes" / digest).read_bytes() == content
    assert files(data) == {digest}


def test_a_file_that_is_no_volume_leaves_nothing(client: TestClient, data: Path) -> None:
    before = files(data)
    for content in (b"", b"not a volume", npy()[:-8]):
        answer = upload(client, content, "broken.npy")
        problem = answer.json()
        assert (answer.status_code, answer.headers["content-type"]) == (422, "application/problem+json")
        assert problem["detail"].startswith("broken.npy: ")
        assert str(data) not in answer.text
        assert "\n" not in problem["detail"]
    assert files(data) == before


@pytest.mark.parametrize("announced", [True, False])
def test_a_file_that_is_too_large_leaves_nothing(client: TestClient, data: Path, announced: bool) -> None:
    before = files(data)
    content = npy((50, 50, 50))
    answer = upload(client, content if announced else iter([content[:60_000], content[60_000:]]))
    assert (answer.status_code, answer.headers["content-type"]) == (413, "application/problem+json")
    assert "100000 bytes" in answer.json()["detail"]
    assert files(data) == before


def test_an_upload_needs_a_name(client: TestClient) -> None:
    answer = client.post("/api/v1/volumes", content=npy())
    assert answer.status_code == 422
    assert answer.json()["errors"] == [{"field": "name", "message": "is required"}]


def test_pages_hold_every_volume_once_newest_first(client: TestClient) -> None:
    for value in (2.0, 3.0, 4.0):
        upload(client, npy(value=value), f"{value}.npy")
    seen, cursor = [], None
    while True:
        page = client.get("/api/v1/volumes", params={"limit": 2, **({"cursor": cursor} if cursor else {})}).json()
        seen += [volume["name"] for volume in page["items"]]
        if (cursor := page["next"]) is None:
            break
    assert seen[:3] == ["4.0.npy", "3.0.npy", "2.0.npy"]
    assert len(seen) == len(set(seen))


def test_a_scene_may_use_an_uploaded_volume_and_its_grids(
    client: TestClient, make_scene: Callable[..., dict[str, Any]]
) -> None:
    volume = upload(client, npy(value=5.0)).json()
    for grid, status in ((None, 201), ("density", 201), ("fire", 422)):
        placed = {"kind": "grid", "file": volume["id"], "albedo": 1, "grid": grid}
        answer = client.post("/api/v1/jobs", json={"scene": make_scene(volumes=[placed])})
        assert answer.status_code == status, answer.text
    assert answer.json()["errors"] == [
        {"field": "scene.volumes[0].grid", "message": 'cloud.npy has no grid "fire"; it has "density"'}
    ]


def test_an_upload_that_breaks_off_leaves_nothing(service: Service) -> None:
    address = (service.http.base_url.host, service.http.base_url.port or 0)
    with socket.create_connection(address) as connection:
        connection.sendall(
            b"POST /api/v1/volumes?name=a.npy HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000\r\n\r\nhalf"
        )
        scratch = service.data / "scratch"
        _until(lambda: any(scratch.glob("upload-*")))
    _until(lambda: not any(scratch.glob("upload-*")))
    assert "request failed" not in service.log.read_text()


def _until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 10
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)
