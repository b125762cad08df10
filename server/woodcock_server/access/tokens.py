"""Tokens: who may do what, until when. What is kept of one is its hash, so that whoever reads the database has none.

A token is 256 random bits: no guess finds one, so the hash need not be slow, and looking for it tells nothing.
"""

from __future__ import annotations

import hashlib
import secrets
from datetime import datetime
from enum import StrEnum
from typing import TypeAlias

from sqlalchemy import Connection, RowMapping, insert, select, update

from woodcock_server.identifiers import new_id
from woodcock_server.tables import tokens

Row: TypeAlias = RowMapping

#: What tokens begin with, so that tools which look for secrets in the wrong places find them.
PREFIX = "woodcock_"


class Scope(StrEnum):
    """What a token is good for; each holds those before it."""

    READ = "read"  # see jobs, pictures, devices
    WRITE = "write"  # submit, change, cancel and delete jobs, upload files
    ADMIN = "admin"  # check devices

    def holds(self, other: Scope) -> bool:
        order = list(Scope)
        return order.index(self) >= order.index(other)


def create(
    connection: Connection, name: str, owner: str, scope: Scope, now: datetime, until: datetime | None
) -> tuple[str, str]:
    """A new token: its id and its text, which nobody can tell again."""
    id, text = new_id(), PREFIX + secrets.token_hex(32)
    values = {"id": id, "name": name, "owner": owner, "digest": _digest(text), "scope": scope}
    connection.execute(insert(tokens).values(created_at=now, expires_at=until, **values))
    return id, text


def find(connection: Connection, text: str, now: datetime) -> Row | None:
    """The token of a text, if it is good for anything."""
    row = connection.execute(select(tokens).where(tokens.c.digest == _digest(text))).mappings().one_or_none()
    return row if row and _good(row, now) else None


def every(connection: Connection) -> list[Row]:
    """All that were ever made, oldest first."""
    return list(connection.execute(select(tokens).order_by(tokens.c.id)).mappings())


def made(connection: Connection) -> bool:
    """Was any ever made? Then requests need one, also once all have expired."""
    return connection.execute(select(tokens.c.id).limit(1)).first() is not None


def usable(connection: Connection, now: datetime) -> bool:
    """Is any good for something?"""
    return any(_good(row, now) for row in every(connection))


def revoke(connection: Connection, id: str, now: datetime) -> bool:
    """False if there is none, or it is revoked."""
    found = update(tokens).where(tokens.c.id == id, tokens.c.revoked_at.is_(None)).values(revoked_at=now)
    return connection.execute(found).rowcount == 1


def _good(row: Row, now: datetime) -> bool:
    return row["revoked_at"] is None and (row["expires_at"] is None or row["expires_at"] > now)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
