"""`woodcock serve`: what it says when it cannot start, and how it ends."""

from __future__ import annotations

import json
import re
import socket
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil
import pytest
import typer
from alembic import command
from sqlalchemy import text
from typer.testing import CliRunner

from woodcock_server import check_config
from woodcock_server.command import serve
from woodcock_server.config import Settings
from woodcock_server.database import alembic_config, open_database

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


def test_a_database_of_a_newer_version_is_left_alone(tmp_path: Path) -> None:
    engine = open_database(Settings(data=tmp_path).database)
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    engine.dispose()
    for arguments in ((), ("--check-config",)):
        status, said = run("--port", 0, "--data", tmp_path, *arguments)
        assert status == 2
        assert "it is of a newer version of Woodcock, whose revision 9999 this one does not know." in said


@pytest.fixture
def no_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_config, "discover", list)


def check(*arguments: object, **environment: str) -> tuple[int, list[str]]:
    result = CliRunner().invoke(app, ["--check-config", "--port", "0", *map(str, arguments)], env=environment)
    return result.exit_code, result.output.splitlines()


@pytest.mark.usefixtures("no_devices")
def test_a_configuration_is_checked_and_nothing_is_made(tmp_path: Path) -> None:
    data = tmp_path / "new" / "data"
    status, (folder, database) = check("--data", data)
    assert status == 0
    assert folder == f"The data folder is {data}, which will be made."
    assert database.startswith("The database is sqlite:///")
    assert database.endswith(", which will be made.")
    assert not list(tmp_path.iterdir())

    engine = open_database(Settings(data=tmp_path).database)
    with engine.begin() as connection:
        config = alembic_config()
        config.attributes["connection"] = connection
        command.downgrade(config, "0007")
    engine.dispose()
    status, (folder, database) = check("--data", tmp_path)
    assert (status, folder) == (0, f"The data folder is {tmp_path}.")
    assert re.search(r", revision 0007, to be brought to \d{4}\.$", database)


@pytest.mark.usefixtures("no_devices")
def test_what_would_not_start_is_told_together(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    status, said = check("--data", tmp_path / "file", "--host", "0.0.0.0")
    assert status == 2
    assert said[0] == f"The data folder {tmp_path / 'file'} cannot be used: {tmp_path / 'file'} is no folder."
    assert said[-1].startswith("0.0.0.0 can be reached from other machines, and no token is valid: ")
    nowhere = "postgresql://nobody@127.0.0.1:9/nothing"
    status, said = check("--data", tmp_path, WOODCOCK_DATABASE_URL=nowhere)
    assert status == 2
    assert said[1].startswith("The database postgresql://nobody@127.0.0.1:9/nothing cannot be used: ")


def test_the_devices_are_checked_too(tmp_path: Path) -> None:
    status, said = check("--data", tmp_path)
    assert status == 0
    assert re.fullmatch(r"Device cpu0 is ready: .*, lanes 1.*\.", said[-1])


def test_logs_can_be_json_and_name_their_job(own_service: Service, make_scene: Callable[..., dict[str, Any]]) -> None:
    own_service.environment["WOODCOCK_LOG_FORMAT"] = "json"
    own_service.start()
    job_id = own_service.submit(make_scene(samples=1))
    own_service.wait(job_id, lambda job: job["state"] == "succeeded")
    own_service.stop()
    lines = [json.loads(line) for line in own_service.log.read_text().splitlines()]
    about = [line for line in lines if line["event"].startswith("job ")]
    assert [line["event"] for line in about] == ["job claimed", "job succeeded"]
    assert {line["job"] for line in about} == {job_id}
    assert all({"event", "level", "timestamp"} <= set(line) for line in lines)


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


def test_a_stop_is_obeyed_while_devices_are_tried(own_service: Service, tmp_path: Path) -> None:
    own_service.environment["XDG_CACHE_HOME"] = str(tmp_path)  # nothing is known of any device

    def trials() -> list[psutil.Process]:
        found = psutil.Process(own_service.process.pid).children() if own_service.process else []
        return [child for child in found if "woodcock.probe" in child.cmdline()]

    with ThreadPoolExecutor(1) as pool:
        starting = pool.submit(own_service.start)
        while not (under_way := trials()):
            time.sleep(0.02)
        for trial in under_way:
            trial.suspend()  # as one that hangs
        assert own_service.process is not None
        with own_service.process as process:
            process.terminate()
            assert process.wait(10) in (-15, 143)
            own_service.process = None
            with pytest.raises(AssertionError):  # It never was ready.
                starting.result()
    for trial in under_way:
        with suppress(psutil.NoSuchProcess):
            trial.resume()
    _, left = psutil.wait_procs(under_way, timeout=10)
    assert not left, "trials end with the service"
    assert "Traceback" not in own_service.log.read_text()


def test_every_setting_is_in_the_readme() -> None:
    readme = (Path(__file__).parents[2] / "server" / "README.md").read_text()
    for name in Settings.model_fields:
        assert f"| `WOODCOCK_{name.upper()}` |" in readme
