"""Uploads made to harm, over HTTP: refused in a sentence, and nothing stays of them but a service that goes on."""

from __future__ import annotations

import hashlib
import json
import urllib.parse
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

from .files import npy
from .test_hostile_files import archive, array, exr, gltf, nrrd, pickles


def upload(client: TestClient, content: bytes, name: str = "file") -> Any:
    return client.post("/api/v1/volumes", params={"name": name}, content=content)


def kept(data: Path) -> dict[str, bytes]:
    """Everything in the folders of uploads, with what is in it."""
    paths = [path for folder in ("volumes", "scratch") for path in (data / folder).rglob("*")]
    return {str(path): path.read_bytes() if path.is_file() else b"" for path in paths}


def test_files_made_to_harm_leave_nothing(client: TestClient, data: Path, tmp_path: Path) -> None:
    marker = tmp_path / "marker"
    neighbours = [data / folder / "neighbour" for folder in ("volumes", "scratch")]
    for path in neighbours:
        path.write_bytes(bytes(64))
    files = {
        "pickle": pickles(marker)["npz"],
        "zip bomb": archive(("a.npy", array("(2, 2, 2)", bytes(1 << 24)))),
        "vast picture": exr(0, 0, (1 << 31) - 1, (1 << 31) - 1),
        "volume of a neighbour": nrrd(more="data file: neighbour", values=b""),
        "mesh of a neighbour": gltf(buffers=[{"byteLength": 36, "uri": "neighbour"}]),
    }
    before = kept(data)
    for name, content in files.items():
        assert len(content) < 100_000
        answer = upload(client, content, name)
        assert (answer.status_code, answer.headers["content-type"]) == (422, "application/problem+json"), name
        detail = answer.json()["detail"]
        assert detail.startswith(f"{name}: ")
        assert detail.isprintable()
        assert str(data) not in answer.text
        assert kept(data) == before, name
    assert not marker.exists()
    for path in neighbours:
        path.unlink()
    assert client.get("/healthz").json()["status"] == "ok"
    assert upload(client, npy(np.ones((2, 2, 2)))).status_code == 201


def test_a_link_in_the_place_of_a_file_is_replaced_not_followed(client: TestClient, data: Path, tmp_path: Path) -> None:
    content, victim = npy(np.full((2, 2, 2), 7.0)), tmp_path / "victim"
    victim.write_bytes(b"precious")
    place = data / "volumes" / hashlib.sha256(content).hexdigest()
    place.symlink_to(victim)
    assert upload(client, content).status_code == 201
    assert victim.read_bytes() == b"precious"
    assert not place.is_symlink()
    assert place.read_bytes() == content


@pytest.mark.parametrize("name", ["a\0b", "a\nb", "a\r\nSet-Cookie: b", "\x1b[2Ja", "a\x7f", "a\x85b", "a\u2028b"])
def test_a_name_with_control_characters_is_refused(client: TestClient, name: str) -> None:
    answer = upload(client, npy([[[1.0]]]), name)
    assert answer.status_code == 422
    (fault,) = answer.json()["errors"]
    assert fault["field"] == "name"
    assert fault["message"].startswith("must not have control characters or line breaks")


def test_a_name_is_shown_as_it_was_given(client: TestClient) -> None:
    names = ["../../etc/passwd", "a\"b'c<script>%00", "Wölkchen ☁ 云", "x" * 200]
    for value, name in enumerate(names):
        answer = upload(client, npy([[[float(value + 1)]]]), name)
        assert answer.status_code == 201, answer.text
        assert answer.json()["name"] == name
        assert client.get(answer.headers["location"]).json()["name"] == name
    shown = [volume["name"] for volume in client.get("/api/v1/volumes").json()["items"]]
    assert set(names) <= set(shown)
    assert upload(client, npy([[[1.0]]]), "x" * 201).status_code == 422
    # What is no UTF-8 becomes text that is, so that it can be told again.
    answer = client.post("/api/v1/volumes?name=%ff%fe", content=npy([[[0.5]]]))
    assert json.loads(answer.content)["name"] == "\N{REPLACEMENT CHARACTER}" * 2


def test_names_of_jobs_and_tags_are_lines(client: TestClient, make_scene: Any) -> None:
    for faulty, field in (({"name": "a\0b"}, "name"), ({"tags": ["a\nb"]}, "tags[0]")):
        answer = client.post("/api/v1/jobs", json={"scene": make_scene(), **faulty})
        assert answer.status_code == 422
        assert [fault["field"] for fault in answer.json()["errors"]] == [field]
    assert client.get("/api/v1/jobs", params={"text": "\0"}).status_code == 422


@pytest.mark.parametrize("part", ["image.exr", "preview.png", "thumbnail.webp", "report.json", "report.html"])
def test_an_id_is_no_path(client: TestClient, data: Path, part: str) -> None:
    (data / "jobs" / part).write_bytes(b"secret")
    for name in (".", "..", "../jobs", "../../jobs", str(data / "jobs")):
        answer = client.get(f"/api/v1/jobs/{urllib.parse.quote(name, safe='')}/{part}")
        assert answer.status_code == 404, name
        assert b"secret" not in answer.content
