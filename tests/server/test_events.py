"""Publish and subscribe within the process."""

from __future__ import annotations

import asyncio
import time
from datetime import UTC, datetime

import pytest
from sqlalchemy import Engine

from woodcock_server.devices.choice import ANY
from woodcock_server.events import Changes, wait
from woodcock_server.jobs import repository, watching

from .conftest import SCENE


def test_a_subscriber_learns_of_its_job_alone() -> None:
    async def scenario() -> None:
        changes = Changes()
        with changes.subscribe("a") as a, changes.subscribe("a") as again, changes.subscribe("b") as b:
            changes.publish("a")
            assert (a.is_set(), again.is_set(), b.is_set()) == (True, True, False)
            await wait(a, 10)
            assert not a.is_set(), "a change is told once"
            changes.publish("nobody waits for this one")

    asyncio.run(scenario())


def test_what_another_server_changes_is_told_too(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watching, "LOOK_EVERY", 0.02)
    asked = {"name": "", "scene": SCENE, "device": ANY}
    with engine.begin() as connection:
        one, other = (repository.add(connection, asked, datetime.now(UTC)) for _ in range(2))

    async def scenario() -> None:
        changes = Changes()
        with changes.subscribe(one) as first, changes.subscribe(other) as second:
            async with watching.running(engine, changes):
                for event in (first, second):  # they may have changed since their followers looked
                    await asyncio.wait_for(event.wait(), 10)
                    event.clear()
                await asyncio.sleep(0.2)
                assert not first.is_set()
                with engine.begin() as connection:
                    repository.change(connection, one, {"priority": 5})
                await asyncio.wait_for(first.wait(), 10)
                assert not second.is_set()
                with engine.begin() as connection:
                    repository.cancel(connection, other, datetime.now(UTC))
                await asyncio.wait_for(second.wait(), 10)
                first.clear()
                with engine.begin() as connection:
                    repository.cancel(connection, one, datetime.now(UTC))
                    assert repository.remove(connection, one)
                await asyncio.wait_for(first.wait(), 10)

    asyncio.run(scenario())


def test_waiting_ends_with_its_time() -> None:
    async def scenario() -> None:
        began = time.monotonic()
        await wait(asyncio.Event(), 0.05)
        assert 0.04 < time.monotonic() - began < 5

    asyncio.run(scenario())


def test_closing_wakes_everyone() -> None:
    async def scenario() -> None:
        changes = Changes()
        with changes.subscribe("a") as a, changes.subscribe("b") as b:
            changes.close()
            assert changes.closed
            await wait(a, 10)
            await wait(b, 10)

    asyncio.run(scenario())
