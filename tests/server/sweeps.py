"""What tests of batches share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from starlette.testclient import TestClient

from woodcock_server.services import Services

#: Asks for a batch.
Sweep = Callable[..., Any]
PATH = "/api/v1/batches"
PRODUCT = {"volumes[0].sigma_t": [1, 2], "camera.fov": [20, 35]}


def made(answer: Any) -> dict[str, Any]:
    assert answer.status_code == 201, answer.text
    batch: dict[str, Any] = answer.json()
    return batch


def problem(answer: Any, status: int) -> str:
    assert answer.status_code == status, answer.text
    assert answer.headers["Content-Type"] == "application/problem+json"
    return str(answer.json()["detail"])


def services(client: TestClient) -> Services:
    found: Services = client.app.state.services  # type: ignore[attr-defined]
    return found
