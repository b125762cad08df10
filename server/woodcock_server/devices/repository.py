"""Rows of the table of stability checks."""

from __future__ import annotations

from collections.abc import Collection
from datetime import datetime
from typing import Any

from sqlalchemy import ColumnElement, Connection, RowMapping, func, insert, select

from woodcock import __version__
from woodcock_server.devices.service import Found
from woodcock_server.identifiers import new_id
from woodcock_server.tables import stability_checks as checks


def add(
    connection: Connection, device: Found, started: datetime, finished: datetime, rows: list[dict[str, Any]]
) -> None:
    """An outcome; the device's newest from now on."""
    connection.execute(
        insert(checks).values(
            id=new_id(),
            fingerprint=device.fingerprint,
            identity=device.device.identity,
            version=__version__,
            passed=all(row["verdict"] != "failed" for row in rows),
            started_at=started,
            finished_at=finished,
            rows=rows,
        )
    )


def newest(connection: Connection, fingerprints: Collection[str]) -> dict[str, RowMapping]:
    """The newest outcome of each that has one."""
    found = connection.execute(select(checks).where(_newest(fingerprints))).mappings()
    return {row["fingerprint"]: row for row in found}


def failed(connection: Connection, fingerprints: Collection[str]) -> set[str]:
    """Those whose newest outcome is a failure; reads no rows of cases."""
    query = select(checks.c.fingerprint).where(_newest(fingerprints), checks.c.passed.is_(False))
    return set(connection.scalars(query))


def _newest(fingerprints: Collection[str]) -> ColumnElement[bool]:
    last = select(func.max(checks.c.id)).where(checks.c.fingerprint.in_(fingerprints)).group_by(checks.c.fingerprint)
    return checks.c.id.in_(last)
