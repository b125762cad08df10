"""Who may come in: tokens, scopes, cookies, names, sites; and that every route asks."""

from __future__ import annotations

import asyncio
import re
import ssl
from collections.abc import Callable, Iterable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from fastapi.routing import APIRoute
from starlette.testclient import TestClient
from typer.testing import CliRunner

from woodcock_server import app as application
from woodcock_server.access import guard, tokens
from woodcock_server.access.command import app as program
from woodcock_server.access.tokens import Scope
from woodcock_server.cluster import embedded
from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.jobs.schemas import Job

from .conftest import ADDRESS, Service

NOW = datetime(2026, 1, 2, tzinfo=UTC)
#: Routes that tell nothing of anybody's work.
PAGES = {"/", "/renders/{id}", "/batches/{id}", "/compare", "/submit", "/fleet"}
PUBLIC = {*PAGES, "/healthz", "/readyz"}
SESSION = "/api/v1/session"


@pytest.fixture
def app(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FastAPI:
    monkeypatch.setattr(application, "discover", list)
    return application.create_app(Settings(data=tmp_path))


@pytest.fixture
def http(app: FastAPI) -> Iterator[TestClient]:
    with TestClient(app, ADDRESS, raise_server_exceptions=False) as client:
        yield client


@pytest.fixture
def token(tmp_path: Path, http: TestClient) -> Callable[..., str]:
    """Makes a token in the service's database."""
    engine = open_database(Settings(data=tmp_path).database)

    def make(scope: Scope = Scope.WRITE, days: float = 1) -> str:
        with engine.begin() as connection:
            now = datetime.now(UTC)
            return tokens.create(connection, f"{scope}'s", "ann", scope, now, now + timedelta(days=days))[1]

    return make


def test_a_bad_setting_is_a_sentence_to_every_command(tmp_path: Path) -> None:
    for command in (["list"], ["create", "a"]):
        done = CliRunner().invoke(program, [*command, "--data", str(tmp_path)], env={"WOODCOCK_PORT": "many"})
        assert done.exit_code == 2
        assert done.stderr.startswith("WOODCOCK_PORT: Input should be a valid integer")
        assert done.stderr.count("\n") == 1


def bearer(token: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {token}"}


# Tokens


def test_tokens_expire_and_are_revoked_and_only_their_hash_is_kept(tmp_path: Path) -> None:
    with open_database(Settings(data=tmp_path).database).begin() as connection:
        assert not tokens.made(connection)
        id, text = tokens.create(connection, "a", "ann", Scope.READ, NOW, NOW + timedelta(days=1))
        other, lasting = tokens.create(connection, "b", "bob", Scope.ADMIN, NOW, None)
        assert re.fullmatch("woodcock_[0-9a-f]{64}", text)
        assert not any(text in str(value) for row in tokens.every(connection) for value in row.values())
        found = tokens.find(connection, text, NOW)
        assert found
        assert (found["id"], found["name"], found["scope"]) == (id, "a", "read")
        assert tokens.find(connection, text, NOW + timedelta(days=1)) is None
        assert tokens.find(connection, text[:-1], NOW) is None
        assert tokens.revoke(connection, other, NOW)
        assert not tokens.revoke(connection, other, NOW)
        assert tokens.find(connection, lasting, NOW) is None
        assert tokens.usable(connection, NOW)
        assert not tokens.usable(connection, NOW + timedelta(days=2))
        assert tokens.made(connection)


def test_tokens_are_made_listed_and_revoked_by_command(tmp_path: Path) -> None:
    run, data = CliRunner().invoke, ["--data", str(tmp_path / "new")]
    made = run(program, ["create", "the farm", "--scope", "read", "--days", "3", *data])
    assert (made.exit_code, made.stdout[:9]) == (0, "woodcock_")
    (line,) = run(program, ["list", *data]).stdout.splitlines()
    assert "read" in line
    assert line.endswith("the farm")
    assert made.stdout.strip() not in line
    assert run(program, ["revoke", line.split()[0], *data]).exit_code == 0
    assert "revoked" in run(program, ["list", *data]).stdout
    (tmp_path / "woodcock.sqlite").write_bytes(b"no database")
    broken = run(program, ["list", "--data", str(tmp_path)])
    assert broken.exit_code == 2
    assert broken.output.endswith("file is not a database.\n")
    again = run(program, ["revoke", line.split()[0], *data])
    assert again.exit_code == 2
    assert "no token" in again.output


# Routes


def every(routes: Iterable[Any]) -> Iterator[Any]:
    """Those of included routers, too."""
    for route in routes:
        yield from every(route.original_router.routes) if hasattr(route, "original_router") else (route,)


def test_every_route_asks_who_is_there(app: FastAPI, http: TestClient, token: Callable[..., str]) -> None:
    token()
    found = list(every(app.routes))
    asked = [(method, route.path) for route in found if isinstance(route, APIRoute) for method in route.methods]
    assert len(asked) > 25
    assert {path for _, path in asked} >= app.openapi()["paths"].keys()
    for method, path in asked:
        status = http.request(method, path.replace("{id}", "some")).status_code
        assert path == SESSION or (status == 401) != (path in PUBLIC), f"{method} {path}: {status}"
    assert http.get(SESSION).status_code == http.post(SESSION, json={"token": "none"}).status_code == 401
    others = {route.path for route in found if not isinstance(route, APIRoute)}
    assert others == {"/openapi.json", "/docs", "/docs/oauth2-redirect", "/redoc", "/web", "/examples"}


def test_nobody_needs_a_token_before_there_is_one(
    http: TestClient, token: Callable[..., str], make_scene: Callable[..., dict[str, Any]]
) -> None:
    assert http.post("/api/v1/jobs", json={"scene": make_scene()}).status_code == 201
    assert http.get("/api/v1/session").json() == {"name": None, "owner": "", "scope": "admin"}
    token(days=-1)  # has expired
    answer = http.get("/api/v1/jobs")
    assert (answer.status_code, answer.headers["www-authenticate"]) == (401, "Bearer")
    assert answer.headers["content-type"] == "application/problem+json"
    assert "asks for a token" in answer.json()["detail"]
    assert http.get("/").status_code == http.get("/web/app.js").status_code == 200


def test_tokens_are_good_for_their_scope(
    http: TestClient, token: Callable[..., str], make_scene: Callable[..., dict[str, Any]]
) -> None:
    read, write, admin = (bearer(token(scope)) for scope in Scope)
    body = {"scene": make_scene()}
    for headers, statuses in ((read, (200, 403, 403)), (write, (200, 201, 403)), (admin, (200, 201, 404))):
        found = (
            http.get("/api/v1/jobs", headers=headers).status_code,
            http.post("/api/v1/jobs", json=body, headers=headers).status_code,
            http.post("/api/v1/devices/none/stability", headers=headers).status_code,
        )
        assert found == statuses
    refused = http.post("/api/v1/jobs", json=body, headers=read)
    assert refused.json()["detail"] == "The token read's is good for `read`; this needs `write`."
    unknown = http.get("/api/v1/jobs", headers=bearer("woodcock_" + "0" * 64))
    assert (unknown.status_code, unknown.json()["detail"]) == (401, "The token is unknown or revoked, or has expired.")


def test_browsers_keep_their_token_in_a_cookie(http: TestClient, token: Callable[..., str]) -> None:
    text = token()
    assert http.post("/api/v1/session", json={"token": "wrong"}).status_code == 401
    assert not http.cookies
    answer = http.post("/api/v1/session", json={"token": text})
    assert answer.json() == {"name": "write's", "owner": "ann", "scope": "write"}
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert 86000 < int(re.findall(r"max-age=(\d+)", cookie)[0]) <= 86400  # no longer than it is valid
    assert "secure" not in cookie  # or it would not come back over http
    assert http.get("/api/v1/jobs").status_code == 200
    assert http.get("/api/v1/session").json()["name"] == "write's"
    assert http.delete("/api/v1/session").status_code == 204
    assert http.get("/api/v1/jobs").status_code == 401


# Sites and names


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 201),
        ({"Origin": ADDRESS, "Sec-Fetch-Site": "same-origin"}, 201),
        ({"Origin": "http://127.0.0.1:8001"}, 403),  # another service of the same machine
        ({"Origin": "https://elsewhere.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Sec-Fetch-Site": "cross-site"}, 403),
    ],
)
def test_pages_of_other_sites_change_nothing(
    http: TestClient, make_scene: Callable[..., dict[str, Any]], headers: dict[str, str], status: int
) -> None:
    assert http.post("/api/v1/jobs", json={"scene": make_scene()}, headers=headers).status_code == status
    assert http.get("/api/v1/jobs", headers=headers).status_code == 200


def test_only_json_is_taken_for_json(http: TestClient, make_scene: Callable[..., dict[str, Any]]) -> None:
    """A page of another site could send text without asking first."""
    body = str({"scene": make_scene()}).replace("'", '"')
    for kind in ("text/plain", "application/x-www-form-urlencoded"):
        assert http.post("/api/v1/jobs", content=body, headers={"Content-Type": kind}).status_code == 422
    assert http.post("/api/v1/jobs", content=body, headers={"Content-Type": "application/json"}).status_code == 201


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("127.0.0.1:8000", 200), ("localhost", 200), ("LOCALHOST:1", 200), ("[::1]:8000", 200),
        ("rebound.example", 421), ("127.0.0.1.example", 421), ("a@127.0.0.1", 421), ("", 421), ("[", 421),
    ],
)  # fmt: skip
def test_the_service_goes_by_its_own_names(http: TestClient, host: str, status: int) -> None:
    answer = http.get("/api/v1/jobs", headers={"Host": host})
    assert answer.status_code == status
    if status == 421:
        assert "WOODCOCK_NAMES" in answer.json()["detail"]


def test_names_can_be_added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(application, "discover", list)
    with TestClient(application.create_app(Settings(data=tmp_path, names="renders.example,b")), ADDRESS) as http:
        for host, status in (("Renders.example:80", 200), ("b", 200), ("localhost", 200), ("c", 421)):
            assert http.get("/api/v1/jobs", headers={"Host": host}).status_code == status


def test_answers_forbid_what_browsers_need_not_do(http: TestClient) -> None:
    for path in ("/", "/api/v1/jobs", "/web/app.js", "/nothing"):
        headers = http.get(path).headers
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["content-security-policy"] == "frame-ancestors 'none'"
        assert headers["cross-origin-resource-policy"] == "same-origin"


# The address


def test_other_machines_need_a_token(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(application, "discover", list)
    for host in ("0.0.0.0", "::"):
        with pytest.raises(guard.Exposed, match=r"woodcock token create"):
            application.create_app(Settings(data=tmp_path, host=host))
    with TestClient(application.create_app(Settings(data=tmp_path, host="0.0.0.0", insecure=True)), ADDRESS) as http:
        assert http.get("/api/v1/jobs", headers={"Host": "any.example"}).status_code == 200
    with open_database(Settings(data=tmp_path).database).begin() as connection:
        id, _ = tokens.create(connection, "a", "ann", Scope.READ, datetime.now(UTC), None)
    with TestClient(application.create_app(Settings(data=tmp_path, host="0.0.0.0")), ADDRESS) as http:
        assert http.get("/api/v1/jobs").status_code == 401
    with open_database(Settings(data=tmp_path).database).begin() as connection:
        tokens.revoke(connection, id, datetime.now(UTC))
    with pytest.raises(guard.Exposed):
        application.create_app(Settings(data=tmp_path, host="0.0.0.0"))


def test_a_job_by_token_from_end_to_end(own_service: Service, make_scene: Callable[..., dict[str, Any]]) -> None:
    own_service.data.mkdir()
    made = CliRunner().invoke(program, ["create", "a", "--data", str(own_service.data)])
    own_service.start()
    assert own_service.http.get("/api/v1/jobs").status_code == 401
    own_service.http.headers.update(bearer(made.stdout.strip()))
    job = own_service.wait(own_service.submit(make_scene()), lambda job: Job.model_validate(job).state.final)
    assert job["state"] == "succeeded"
    assert made.stdout.strip() not in own_service.log.read_text()


# The cluster's own ports


async def greeted(port: int, context: ssl.SSLContext | None) -> bool:
    """Does who connects hear what Dask says first to whom it speaks with?"""
    try:
        reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=context)
        try:
            return bool(await asyncio.wait_for(reader.read(1), 5))
        finally:
            writer.transport.abort()
    except OSError:
        return False


async def who_is_greeted(scratch: Path) -> list[bool]:
    async with embedded(["one"], scratch, 4 << 30) as client:
        own = client.security.get_connection_args("client")["ssl_context"]
        anybody = ssl.create_default_context()
        anybody.check_hostname, anybody.verify_mode = False, ssl.CERT_NONE
        port = int(client.scheduler.address.rpartition(":")[2])  # type: ignore[union-attr]
        return [await greeted(port, context) for context in (own, anybody, None)]


def test_strangers_cannot_speak_to_the_cluster(tmp_path: Path) -> None:
    """Nor can who speaks TLS without the certificate of this start, nor who speaks none."""
    assert asyncio.run(who_is_greeted(tmp_path)) == [True, False, False]
