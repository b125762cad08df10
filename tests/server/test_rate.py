"""How often one may ask, and how long one may stand still."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from starlette.testclient import TestClient

from woodcock_server import app as application
from woodcock_server.access import rate
from woodcock_server.access.rate import RateLimit
from woodcock_server.config import Settings

from .conftest import ADDRESS, Service


@pytest.fixture
def http(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[TestClient]:
    monkeypatch.setattr(application, "discover", list)
    with TestClient(application.create_app(Settings(data=tmp_path, request_rate=0.5)), ADDRESS) as http:
        yield http


def test_who_asks_too_often_is_told_when_to_come_again(http: TestClient) -> None:
    answers = [http.get("/healthz") for _ in range(6)]
    assert [answer.status_code for answer in answers] == [200] * 5 + [429]
    refused = answers[-1]
    assert refused.headers["content-type"] == "application/problem+json"
    assert refused.headers["retry-after"] in ("1", "2")
    assert refused.json()["detail"] == "More than 0.5 requests a second came from this address for a while."


def test_each_address_has_its_own_bucket_which_fills_again_and_few_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rate, "REMEMBERED", 3)
    limit = RateLimit(lambda *_: None, 1.0)  # type: ignore[arg-type,return-value]
    one, other = ("192.0.2.1", 5), ("192.0.2.2", 5)
    assert [limit._wait(one, 100.0) for _ in range(10)] == [0] * 10
    assert limit._wait(one, 100.25) == pytest.approx(0.75)
    assert limit._wait(one, 100.5) == pytest.approx(0.5), "to be refused costs nothing"
    assert limit._wait(other, 100.5) == 0
    assert limit._wait(one, 101.25) == 0
    assert [limit._wait(one, 1000.0) for _ in range(11)] == [0] * 10 + [1]
    for number in range(5):
        limit._wait((f"192.0.2.{10 + number}", 5), 1000.0)
    assert len(limit._buckets) == 3


def test_a_reader_that_stands_still_is_dropped(own_service: Service) -> None:
    service = own_service
    service.program = "import woodcock_server.command as c\nc.SILENT_SECONDS = 2\n" + service.program
    service.start()
    assert service.process is not None
    address = service.http.base_url
    server = psutil.Process(service.process.pid)
    with socket.socket() as reader:
        reader.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        reader.connect((address.host, address.port))
        here = reader.getsockname()[1]

        def held() -> bool:
            return any(each.raddr and each.raddr.port == here for each in server.net_connections())

        while not held():  # until the service has taken it from the kernel
            time.sleep(0.01)
        request = f"GET /openapi.json HTTP/1.1\r\nHost: 127.0.0.1:{address.port}\r\n\r\n".encode()
        reader.setblocking(False)
        for _ in range(300):  # answers for more than the kernel buffers
            try:
                reader.send(request)
            except OSError:
                break
        end = time.monotonic() + 60
        while held():
            assert time.monotonic() < end, "it reads nothing, and is still waited for"
            time.sleep(0.2)
    assert service.http.get("/healthz").status_code == 200
