"""Uploaded files on a worker host."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.formats import VolumeError
from woodcock_server.farm.cache import Cache, NoRoomError

from .harness import Farm
from .test_farm import ended


class Counting:
    """Has files of one letter each; counts what it is asked for."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.asked: list[str] = []

    def add(self, letter: str, size: int) -> str:
        content = letter.encode() * size
        file_id = f"sha256:{hashlib.sha256(content).hexdigest()}"
        self.files[file_id] = content
        return file_id

    def size(self, file_id: str) -> int:
        return len(self.files[file_id])

    def chunks(self, file_id: str) -> Iterator[bytes]:
        self.asked.append(file_id)
        content = self.files[file_id]
        yield content[:3]
        yield content[3:]


def kept(folder: Path) -> set[str]:
    return {f"sha256:{path.name}" for path in folder.iterdir() if path.name != "lock"}


def test_what_nobody_held_for_longest_goes_first(tmp_path: Path) -> None:
    source, cache = Counting(), Cache(tmp_path, 20)
    first, second, third, fourth = (source.add(letter, 8) for letter in "abcd")
    held = cache.fetch(first, source)
    cache.fetch(second, source)
    assert held.path.read_bytes() == b"aaaaaaaa"
    assert kept(tmp_path) == {first, second}
    cache.fetch(third, source)
    assert kept(tmp_path) == {first, third}, "the first is held, however old"
    del held
    cache.fetch(first, source)
    assert source.asked == [first, second, third], "what is there is not fetched again"
    cache.fetch(fourth, source)
    assert kept(tmp_path) == {first, fourth}, "it was used more lately"


def test_what_does_not_fit_is_told(tmp_path: Path) -> None:
    source, cache = Counting(), Cache(tmp_path, 20)
    held = cache.fetch(source.add("a", 8), source)
    with pytest.raises(NoRoomError, match="WOODCOCK_CACHE_SIZE"):
        cache.fetch(source.add("b", 16), source)
    del held
    cache.fetch(source.add("b", 16), source)


def test_what_came_wrong_or_in_part_is_not_kept(tmp_path: Path) -> None:
    source, cache = Counting(), Cache(tmp_path, 20)
    file_id = source.add("a", 8)
    source.files[file_id] = b"aaaaaaab"
    with pytest.raises(VolumeError, match="another content"):
        cache.fetch(file_id, source)
    assert not kept(tmp_path)
    (tmp_path / "0.part").write_bytes(bytes(30))  # of a process that was killed
    source.add("a", 8)
    assert cache.fetch(file_id, source).path.read_bytes() == b"aaaaaaaa"
    assert kept(tmp_path) == {file_id}


@pytest.mark.slow
def test_workers_fetch_a_scenes_files(farm: Farm, make_scene: Callable[..., dict[str, Any]], tmp_path: Path) -> None:
    file = tmp_path / "grid.npy"
    np.save(file, np.random.default_rng(1).random((120, 100, 100), np.float32))  # 4.8 MB: more than is sent at a time
    service = farm.start_service()
    farm.start_worker("node1")
    farm.wait_for(service, "cpu0@node1")
    volume = service.http.post("/api/v1/volumes", params={"name": "grid.npy"}, content=file.read_bytes()).json()["id"]
    scene = make_scene(volumes=[{"kind": "grid", "file": volume, "albedo": 0.5}])
    check = service.http.post("/api/v1/jobs/check", json={"scene": scene}, timeout=60).json()
    assert check["devices"][0]["fits"], check
    job = service.wait(service.submit(scene), ended, 120)
    assert job["state"] == "succeeded"
    assert kept(farm.folder / "node1" / "files") == {volume}
