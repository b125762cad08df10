"""The child process that reads an uploaded file: what it may take, and what is said of one that dies."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from woodcock_server.volumes import contents
from woodcock_server.volumes.contents import UnreadableFile
from woodcock_server.volumes.parser import MOST_BYTES, Parser
from woodcock_server.volumes.schemas import GridSummary

from .conftest import Instead
from .files import npy
from .hostile import instances

CONFINED = """
import json, resource, sys
from woodcock_server.volumes.contents import confine
confine(1 << 30, 7)
limits = [resource.getrlimit(getattr(resource, f"RLIMIT_{kind}")) for kind in ("DATA", "CPU", "FSIZE", "CORE")]
caught = []
for act in (lambda: bytearray(1 << 30), lambda: open(sys.argv[1], "w").write("x" * 9999)):
    try:
        act()
    except (MemoryError, OSError) as error:
        caught.append(type(error).__name__)
print(json.dumps([limits, caught]))
"""


def fault(parser: Parser, path: Path) -> str:
    with pytest.raises(UnreadableFile) as error:
        parser.read(path)
    return str(error.value)


def test_a_file_is_read_in_a_child(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(npy([[[1.0, 2.0]]]))
    found = Parser(1 << 30, 60).read(tmp_path / "a")
    assert (found.type, found.triangles) == ("volume", None)
    assert found.grids == [GridSummary(name="density", type="float32", shape=(2, 1, 1), voxels=2)]
    (tmp_path / "a").write_bytes(b"nothing")
    assert fault(Parser(1 << 30, 60), tmp_path / "a") == contents.UNREADABLE


def test_the_child_is_confined(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", CONFINED, str(tmp_path / "a")], capture_output=True, text=True, check=True
    )
    limits, caught = json.loads(done.stdout)
    assert limits == [[1 << 30, 1 << 30], [7, 8], [0, 0], [0, 0]]
    assert caught == ["MemoryError", "OSError"]
    assert (tmp_path / "a").read_bytes() == b""


def test_memory_is_limited(tmp_path: Path) -> None:
    # Text of 9 MB, glTF by how it begins, that takes 200 MB once it is understood
    (tmp_path / "a").write_bytes(b'{"nodes":[' + b"[]," * 3_000_000 + b"[]]}")
    says = "takes more than 256 MiB of memory to read, the most that a file may take here"
    assert fault(Parser(1 << 28, 60), tmp_path / "a") == says


def test_time_is_limited(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(instances(9000))
    began = time.monotonic()
    assert (
        fault(Parser(1 << 30, 1), tmp_path / "a") == "takes more than 1 s to read, the most that a file may take here"
    )
    assert time.monotonic() - began < 10


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("exec sleep 60", "takes more than 1 s to read, the most that a file may take here"),
        ("kill -SEGV $$", "cannot be read: its reader ended by SIGSEGV"),
        ("kill -XCPU $$", "takes more than 1 s to read, the most that a file may take here"),
        ("exit 3", "cannot be read: its reader ended with code 3"),
        ("echo nonsense", "cannot be read: its reader ended with code 0"),
        ("""echo '{"contents": {"type": "recipe"}}'""", "cannot be read: its reader ended with code 0"),
        ("exec yes", f"holds grids whose names and sizes take more than {MOST_BYTES} bytes"),
    ],
)
def test_a_child_that_does_not_answer_is_told_in_a_sentence(
    tmp_path: Path, instead: Instead, script: str, says: str
) -> None:
    instead(script)
    assert fault(Parser(1 << 30, 1 if "1 s" in says else 60), tmp_path / "a") == says


def test_a_crash_refuses_the_file_and_nothing_else(
    client: TestClient, data: Path, instead: Instead, monkeypatch: pytest.MonkeyPatch
) -> None:
    instead("kill -ABRT $$")
    answer = client.post("/api/v1/volumes?name=a.npy", content=npy([[[1.0]]]))
    monkeypatch.undo()
    assert answer.status_code == 422
    assert answer.json()["detail"] == "a.npy: cannot be read: its reader ended by SIGABRT"
    assert not any((data / "volumes").iterdir())
    assert client.post("/api/v1/volumes?name=a.npy", content=npy([[[1.0]]])).status_code == 201
