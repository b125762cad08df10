"""`woodcock serve`: what it says when it cannot start, and how it ends."""

from __future__ import annotations

import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from woodcock_server.command import serve
from woodcock_server.config import Settings

from .conftest import Service

app = typer.Typer()
app.command()(serve)


def run(*arguments: object, **environment: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], env=environment)
    return result.exit_code, result.stderr


def test_a_port_that_is_taken_is_named(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert run("--port", port, "--data", tmp_path) == (
            2,
            f"Port {port} of 127.0.0.1 is taken; choose another with --port.\n",
        )
    assert not list(tmp_path.iterdir())


def test_a_host_that_is_not_there_is_named(tmp_path: Path) -> None:
    status, said = run("--host", "203.0.113.1", "--port", 0, "--data", tmp_path)
    assert status == 2
    assert said.startswith("Cannot listen on 203.0.113.1: ")


@pytest.mark.parametrize(
    ("arguments", "environment", "says"),
    [
        (("--port", 70000), {}, "WOODCOCK_PORT (or --port): "),
        ((), {"WOODCOCK_UPLOAD_LIMIT": "much"}, "WOODCOCK_UPLOAD_LIMIT: "),
    ],
)
def test_a_bad_setting_is_named(arguments: tuple[object, ...], environment: dict[str, str], says: str) -> None:
    status, said = run(*arguments, **environment)
    assert status == 2
    assert said.startswith(says)
    assert said.count("\n") == 1


def test_a_data_folder_that_is_a_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    status, said = run("--port", 0, "--data", tmp_path / "file")
    assert status == 2
    assert said.splitlines()[-1] == f"The data folder {tmp_path / 'file'} cannot be used: Not a directory."


def test_a_database_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    (tmp_path / "woodcock.sqlite").write_text("this is no database, and it is long enough to tell" * 100)
    status, said = run("--port", 0, "--data", tmp_path)
    assert status == 2
    assert said.splitlines()[-1].startswith("The database sqlite:///")
    assert "file is not a database" in said.splitlines()[-1]


def test_those_who_follow_a_job_do_not_hold_up_the_end(
    own_service: Service, make_scene: Callable[..., dict[str, Any]]
) -> None:
    own_service.start()
    job_id = own_service.submit(make_scene(size=64, samples=1 << 30))
    with own_service.http.stream("GET", f"/api/v1/jobs/{job_id}/events") as stream:
        lines = stream.iter_lines()
        assert next(lines) == "event: state"
        assert own_service.process is not None
        own_service.process.terminate()
        assert "event: end" not in list(lines), "the stream closes; the job has not ended"
    assert own_service.process.wait(30) in (-15, 143)
    assert "timeout" not in own_service.log.read_text()


def test_every_setting_is_in_the_readme() -> None:
    readme = (Path(__file__).parents[2] / "server" / "README.md").read_text()
    for name in Settings.model_fields:
        assert f"| `WOODCOCK_{name.upper()}` |" in readme
