"""Every operation that the service describes, asked in many ways by a tool that knows its description alone."""

from __future__ import annotations

import re
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

import pytest

from woodcock_server.access import tokens
from woodcock_server.access.tokens import Scope
from woodcock_server.config import Settings
from woodcock_server.database import open_database

from .conftest import NO_DEVICES, Service

#: What JSON Schema cannot say is a 422, too: a scene that does not add up, a file that was not uploaded.
CONFIG = """
[checks.positive_data_acceptance]
expected-statuses = ["2xx", 401, 403, 404, 409, 422]
"""


@pytest.fixture
def described(own_service: Service) -> Service:
    """A service that asks for a token; without devices, for what is submitted would be rendered."""
    own_service.program = NO_DEVICES + own_service.program
    own_service.environment["WOODCOCK_REQUEST_RATE"] = "1e6"
    own_service.start()
    return own_service


def asked(service: Service, folder: Path, *how: str) -> None:
    """All of the tool's checks hold, and the service had no trouble."""
    with open_database(Settings(data=service.data).database).begin() as connection:
        _, token = tokens.create(connection, "a", "a", Scope.ADMIN, datetime.now(UTC), None)
    config = folder / "schemathesis.toml"
    config.write_text(CONFIG)
    command = [
        *(str(Path(sys.executable).parent / "schemathesis"), "--config-file", str(config)),
        *("run", f"{service.http.base_url}openapi.json", "--checks", "all", "--seed", "7", *how),
        *("--header", f"Authorization: Bearer {token}", "--request-timeout", "10", "--no-color"),
        *("--exclude-path", "/readyz"),  # without a device it is not, and says so with a 503
        *("--generation-database", "none", "--report-dir", str(folder)),
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False)
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}\n{service.log.read_text()[-5000:]}"
    assert re.search(r"Test cases:\n +\d{3,} generated", done.stdout), done.stdout
    assert "[error" not in service.log.read_text()


def test_nothing_is_answered_that_is_not_described(described: Service, tmp_path: Path) -> None:
    asked(described, tmp_path, "--phases", "fuzzing,stateful", "--max-examples", "3")


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_nothing_is_answered_that_is_not_described_however_it_is_asked(described: Service, tmp_path: Path) -> None:
    asked(described, tmp_path, "--max-examples", "20")
