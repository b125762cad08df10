"""Whoever asked for it hears of a job's end: signed, again if need be, once if all goes well."""

from __future__ import annotations

import asyncio
import json
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler
from ipaddress import ip_network
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, text

from woodcock_server.database import open_database
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs import repository as jobs
from woodcock_server.webhooks import deliveries, repository, signature
from woodcock_server.webhooks.deliveries import Deliveries

from .receiver import SECRET, Receiver, answer

MakeScene = Callable[..., dict[str, Any]]
EndedJob = Callable[..., str]

LOOPBACK = (ip_network("127.0.0.0/8"),)
AT_ONCE = (0.0, 0.0)
URL = "sqlite:///{}"


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[Engine]:
    engine = open_database(URL.format(tmp_path / "test.sqlite"))
    yield engine
    engine.dispose()


@pytest.fixture
def ended_job(engine: Engine, make_scene: MakeScene) -> EndedJob:
    """A job that was cancelled, and of whose end a URL is to be told."""

    def make(url: str) -> str:
        now = datetime.now(UTC)
        asked = {"name": "cube", "scene": make_scene(), "device": ANY, "webhook": {"url": url, "secret": SECRET}}
        with engine.begin() as connection:
            job = jobs.add(connection, asked, now)
            assert jobs.cancel(connection, job, now)
        return job

    return make


def send(engine: Engine, times: int = 1, pauses: Sequence[float] = AT_ONCE, limit: float = 10.0) -> None:
    """What a server does that looks at the outbox so often."""

    async def run() -> None:
        server = Deliveries(engine, LOOPBACK, limit, pauses)
        for _ in range(times):
            await server.send_due()

    asyncio.run(run())


def stands(engine: Engine, job: str) -> tuple[str, int, str | None]:
    with engine.connect() as connection:
        found = repository.of_jobs(connection, [job])[job]
    assert "secret" not in found
    return found["state"], found["attempts"], found["error"]


def due_in(engine: Engine, job: str) -> float | None:
    """Seconds."""
    with engine.connect() as connection:
        due: str | None = connection.scalar(text("SELECT due_at FROM webhooks WHERE job_id = :job"), {"job": job})
    return due and (datetime.fromisoformat(due).replace(tzinfo=UTC) - datetime.now(UTC)).total_seconds()


# What is sent


def test_the_signature_is_the_specifications() -> None:
    """Its libraries sign this so."""
    headers = signature.headers("msg_p5jXN8AQM9LWM0D4loKWxJek", 1614265330, b'{"test": 2432232314}', SECRET)
    assert headers["webhook-signature"] == "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="


def test_the_end_of_a_job_is_told(engine: Engine, ended_job: EndedJob) -> None:
    with Receiver() as receiver:
        job = ended_job(receiver.url)
        send(engine, 3)
    (heard,) = receiver.heard
    assert stands(engine, job) == ("delivered", 1, None)
    assert due_in(engine, job) is None
    assert heard.proven()
    assert not heard.proven("whsec_" + "A" * 32)
    assert (heard.path, heard.headers["Host"]) == ("/hook?of=test", f"127.0.0.1:{receiver.port}")
    assert (heard.headers["webhook-id"], heard.headers["Content-Type"]) == (job, "application/json")
    said = json.loads(heard.body)
    assert (said["type"], said["timestamp"]) == ("job.cancelled", said["data"]["finished_at"])
    assert (said["data"]["id"], said["data"]["name"], said["data"]["state"]) == (job, "cube", "cancelled")
    assert not {"scene", "webhook"} & said["data"].keys()
    assert SECRET.encode() not in heard.body


def test_the_readme_tells_how_to_verify(engine: Engine, ended_job: EndedJob) -> None:
    readme = (Path(__file__).parents[2] / "server" / "README.md").read_text()
    (example,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    told: dict[str, Any] = {}
    exec(example, told)
    with Receiver() as receiver:
        ended_job(receiver.url)
        send(engine)
    (heard,) = receiver.heard
    assert told["verified"](heard.headers, heard.body, SECRET)
    assert not told["verified"](heard.headers, heard.body + b" ", SECRET)
    heard.headers.replace_header("webhook-timestamp", str(int(time.time()) - 3600))
    assert not told["verified"](heard.headers, heard.body, SECRET)


# Again


def test_what_fails_is_tried_again_until_it_is_heard(engine: Engine, ended_job: EndedJob) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
    job = ended_job(f"http://127.0.0.1:{port}/")
    send(engine)
    says = f"No answer: 127.0.0.1 takes no connection on port {port}."
    assert stands(engine, job) == ("waiting", 1, says)
    with Receiver(answer(500), port=port) as receiver:
        send(engine)
        assert stands(engine, job) == ("waiting", 2, "The receiver answered 500.")
        send(engine, 3)
    assert stands(engine, job) == ("delivered", 3, None)
    first, second = receiver.heard
    assert (first.headers["webhook-id"], first.body) == (second.headers["webhook-id"], second.body)
    assert first.proven()
    assert second.proven()


def test_pauses_grow_and_have_an_end(engine: Engine, ended_job: EndedJob, capsys: pytest.CaptureFixture[str]) -> None:
    assert list(deliveries.PAUSES) == sorted(deliveries.PAUSES)
    with Receiver(*[answer(503)] * 9) as receiver:
        job = ended_job(receiver.url)
        send(engine, 2, (100.0, 200.0))
        assert len(receiver.heard) == 1, "the pause is kept"
        assert due_in(engine, job) == pytest.approx(100, abs=10)
        make_due(engine)
        send(engine, 1, (100.0, 200.0))
        assert due_in(engine, job) == pytest.approx(200, abs=10)
        make_due(engine)
        send(engine, 3, (100.0, 200.0))
    assert len(receiver.heard) == 3
    assert stands(engine, job) == ("given up", 3, "The receiver answered 503.")
    assert due_in(engine, job) is None
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "webhook given up" in line]
    assert job in line


def make_due(engine: Engine) -> None:
    """Time goes by."""
    with engine.begin() as connection:
        connection.execute(text("UPDATE webhooks SET due_at = :now"), {"now": "2020-01-01 00:00:00.000000"})


def test_who_is_gone_is_left_alone(engine: Engine, ended_job: EndedJob) -> None:
    with Receiver(answer(410)) as receiver:
        job = ended_job(receiver.url)
        send(engine, 2)
    assert len(receiver.heard) == 1
    assert stands(engine, job) == ("given up", 1, "The receiver answered 410.")


def test_no_redirect_is_followed_and_no_proxy_asked(
    engine: Engine, ended_job: EndedJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Receiver() as other, Receiver(answer(307, Location=other.url)) as receiver:
        for name in ("http_proxy", "HTTP_PROXY", "all_proxy"):
            monkeypatch.setenv(name, f"http://127.0.0.1:{other.port}")
        job = ended_job(receiver.url)
        send(engine)
    assert (len(receiver.heard), other.connections) == (1, 0)
    assert stands(engine, job) == ("waiting", 1, "The receiver answered 307.")


def test_a_job_that_is_deleted_is_not_told_of(engine: Engine, ended_job: EndedJob) -> None:
    with Receiver() as receiver:
        job = ended_job(receiver.url)
        with engine.begin() as connection:
            assert jobs.remove(connection, job)
            assert repository.of_jobs(connection, [job]) == {}
        send(engine)
    assert receiver.connections == 0


# Receivers that misbehave


def nothing(handler: BaseHTTPRequestHandler, more: Callable[[bytes], bool]) -> None:
    while more(b""):
        time.sleep(0.02)


def endless_head(handler: BaseHTTPRequestHandler, more: Callable[[bytes], bool]) -> None:
    more(b"HTTP/1.1 200 OK\r\n")
    while more(b"X: " + b"x" * 1000 + b"\r\n"):
        pass


def endless_hints(handler: BaseHTTPRequestHandler, more: Callable[[bytes], bool]) -> None:
    while more(b"HTTP/1.1 103 Early Hints\r\n\r\n"):
        time.sleep(0.001)


def endless_answer(handler: BaseHTTPRequestHandler, more: Callable[[bytes], bool]) -> None:
    more(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n")
    while more(b"1000\r\n" + b"x" * 4096 + b"\r\n"):
        pass


def slow_answer(handler: BaseHTTPRequestHandler, more: Callable[[bytes], bool]) -> None:
    more(b"HTTP/1.1 200 OK\r\nContent-Length: 1000000\r\n\r\n")
    while more(b"x"):
        time.sleep(0.02)


@pytest.mark.parametrize(
    ("misbehave", "state", "says"),
    [
        (nothing, "waiting", "No answer in time."),
        (endless_head, "waiting", "No answer: "),
        (endless_hints, "waiting", "No answer in time."),
        (endless_answer, "delivered", ""),
        (slow_answer, "delivered", ""),
    ],
)
def test_a_receiver_takes_bounded_time_and_memory(
    engine: Engine, ended_job: EndedJob, misbehave: Callable[..., None], state: str, says: str
) -> None:
    sent = 0

    def go_on(handler: BaseHTTPRequestHandler) -> None:
        def more(data: bytes) -> bool:
            nonlocal sent
            handler.wfile.write(data)
            sent += len(data)
            return not receiver.closing.is_set() and sent < 100e6

        misbehave(handler, more)

    with Receiver(go_on) as receiver:
        job = ended_job(receiver.url)
        began = time.monotonic()
        send(engine, limit=0.5)
        assert time.monotonic() - began < 5
    found, _, error = stands(engine, job)
    assert (found, (error or "").startswith(says)) == (state, True)
    assert sent < 50e6, "what the two sockets hold, and what was heard"


# Several servers, and such that die


def test_servers_that_share_a_database_send_each_once(engine: Engine, ended_job: EndedJob) -> None:
    async def share() -> None:
        servers = [Deliveries(engine, LOOPBACK, 10.0, AT_ONCE) for _ in range(3)]
        await asyncio.gather(*(server.send_due() for server in servers))

    with Receiver() as receiver:
        told = {ended_job(receiver.url) for _ in range(20)}
        asyncio.run(share())
    assert len(receiver.heard) == 20
    assert {heard.headers["webhook-id"] for heard in receiver.heard} == told


SERVER = """
import asyncio, sys
from ipaddress import ip_network
from woodcock_server.database import open_database
from woodcock_server.webhooks.deliveries import Deliveries
asyncio.run(Deliveries(open_database(sys.argv[1]), [ip_network("127.0.0.0/8")]).send_due())
"""


def test_what_a_killed_server_was_sending_is_sent_by_the_next(
    engine: Engine, ended_job: EndedJob, tmp_path: Path
) -> None:
    def silence(_: BaseHTTPRequestHandler) -> None:
        receiver.closing.wait(30)

    with Receiver(silence) as receiver:
        job = ended_job(receiver.url)
        command = [sys.executable, "-c", SERVER, URL.format(tmp_path / "test.sqlite")]
        with subprocess.Popen(command) as killed:
            receiver.wait(1)
            killed.send_signal(signal.SIGKILL)
        send(engine)
        assert stands(engine, job) == ("waiting", 1, None)
        assert len(receiver.heard) == 1, "it is the other one's until its lease has run out"
        assert due_in(engine, job) == pytest.approx(60, abs=15)
        make_due(engine)
        send(engine)
        assert stands(engine, job) == ("delivered", 2, None)
    first, second = receiver.heard
    assert (first.headers["webhook-id"], first.body) == (second.headers["webhook-id"], second.body)


def test_an_outcome_that_cannot_be_written_costs_a_repetition(
    engine: Engine, ended_job: EndedJob, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As on a disk that is full: the task goes on, and so do the others' messages."""
    monkeypatch.setattr(deliveries, "LOOK_EVERY", 0.02)

    async def run() -> None:
        async with Deliveries(engine, LOOPBACK, 0.1, AT_ONCE).running():
            await asyncio.to_thread(receiver.wait, 3)
            with engine.begin() as connection:
                connection.execute(text("DROP TRIGGER full"))
            while stands(engine, job)[0] != "delivered":
                await asyncio.sleep(0.02)

    with Receiver() as receiver:
        job, other = ended_job(receiver.url), ended_job(receiver.url)
        with engine.begin() as connection:
            connection.execute(
                text(
                    f"CREATE TRIGGER full BEFORE UPDATE OF state ON webhooks WHEN old.job_id = '{job}' "
                    "BEGIN SELECT RAISE(ABORT, 'disk is full'); END"
                )
            )
        asyncio.run(asyncio.wait_for(run(), 20))
    assert stands(engine, other) == ("delivered", 1, None)
    assert "disk is full" in capsys.readouterr().out


def test_an_outcome_of_an_attempt_that_others_have_repeated_is_not_written(engine: Engine, ended_job: EndedJob) -> None:
    job, now = ended_job("http://127.0.0.1:9/"), datetime.now(UTC)
    with engine.begin() as connection:
        (first,) = repository.take(connection, now, now, 10)
        (second,) = repository.take(connection, now, now + timedelta(seconds=9), 10)
        assert not repository.take(connection, now, now, 10)
        assert not repository.write_taken(connection, job, first["attempts"], state="given up")
        assert repository.write_taken(connection, job, second["attempts"], state="delivered", due_at=None)
    assert stands(engine, job) == ("delivered", 2, None)
