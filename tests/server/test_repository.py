"""Leases and tokens: who may claim a job, and who may write to it."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from sqlalchemy import Engine

from woodcock_server.devices.choice import ANY
from woodcock_server.identifiers import PATTERN, new_id
from woodcock_server.jobs import repository
from woodcock_server.jobs.states import State

from .conftest import SCENE

NOW = datetime(2030, 1, 2, 3, 4, 5, tzinfo=UTC)
LEASE = timedelta(seconds=10)


def add(engine: Engine, device: str = ANY) -> str:
    with engine.begin() as connection:
        return repository.add(connection, {"name": "", "scene": SCENE, "device": device}, NOW)


def claim(engine: Engine, job_id: str, holder: str, now: datetime = NOW) -> int | None:
    with engine.begin() as connection:
        row = repository.claim(connection, job_id, holder, now, LEASE)
    return None if row is None else int(row["token"])


def write(engine: Engine, job_id: str, token: int, **values: object) -> bool:
    with engine.begin() as connection:
        return repository.write_held(connection, job_id, token, values)


def claimable(engine: Engine, now: datetime = NOW, devices: tuple[str, ...] = (ANY, "cpu0")) -> str | None:
    with engine.connect() as connection:
        return repository.next_claimable(connection, now, devices)


def test_the_oldest_job_is_next(engine: Engine) -> None:
    assert claimable(engine) is None
    first, second = add(engine), add(engine)
    assert claimable(engine) == first
    assert claim(engine, first, "a") == 1
    assert claimable(engine) == second


def test_a_job_is_next_where_the_device_is_that_it_asks_for(engine: Engine) -> None:
    add(engine, "gpu0")
    named, whichever = add(engine, "cpu0"), add(engine)
    assert claimable(engine) == named
    assert claimable(engine, devices=(ANY, "cpu1")) == whichever
    assert claimable(engine, devices=("cpu1",)) is None
    assert claimable(engine, devices=()) is None


def test_a_job_is_claimed_by_one(engine: Engine) -> None:
    job = add(engine)
    assert claim(engine, job, "a") == 1
    assert claim(engine, job, "b") is None


def test_a_lease_that_ran_out_is_free_and_the_former_holder_writes_nothing(engine: Engine) -> None:
    job = add(engine)
    assert claim(engine, job, "a") == 1
    assert claim(engine, job, "b", NOW + LEASE) is None
    later = NOW + LEASE + timedelta(seconds=1)
    assert claimable(engine, later) == job
    assert claim(engine, job, "b", later) == 2
    assert not write(engine, job, 1, samples=5)
    assert not write(engine, job, 1, state=State.SUCCEEDED)
    assert write(engine, job, 2, samples=7)
    with engine.connect() as connection:
        row = repository.get(connection, job)
    assert row is not None
    assert (row["samples"], row["holder"], row["state"]) == (7, "b", State.RUNNING)
    assert row["started_at"] == NOW, "the first start counts"


def test_a_renewed_lease_holds(engine: Engine) -> None:
    job = add(engine)
    claim(engine, job, "a")
    assert write(engine, job, 1, lease_until=NOW + 2 * LEASE)
    assert claim(engine, job, "b", NOW + 1.5 * LEASE) is None


def test_nobody_writes_to_a_finished_job(engine: Engine) -> None:
    job = add(engine)
    claim(engine, job, "a")
    assert write(engine, job, 1, state=State.FAILED)
    assert not write(engine, job, 1, state=State.QUEUED)
    assert claimable(engine, NOW + 100 * LEASE) is None


def test_asking_twice_takes_a_job_from_nobody(engine: Engine) -> None:
    """Who renders it lets go of it himself, for he still writes its files."""
    job = add(engine)
    claim(engine, job, "a")
    with engine.begin() as connection:
        assert repository.cancel(connection, job, NOW)
    with engine.begin() as connection:
        assert not repository.cancel(connection, job, NOW)
        row = repository.get(connection, job)
    assert row is not None
    assert (row["state"], row["holder"]) == (State.CANCELLING, "a")
    with engine.begin() as connection:
        assert repository.let_go(connection, job, 1, NOW)


def test_jobs_that_are_added_together_are_as_those_that_are_added_alone(engine: Engine) -> None:
    asked = {"name": "a", "scene": SCENE, "device": ANY, "tags": ["x"]}
    with engine.begin() as connection:
        alone = repository.add(connection, asked, NOW)
        repository.add_all(connection, {"1": asked, "2": {**asked, "tags": []}}, NOW)
    with engine.connect() as connection:
        rows = {job: dict(repository.get(connection, job) or {}) for job in (alone, "1", "2")}
        events = {job: [event["state"] for event in repository.events(connection, job, 0)] for job in rows}
    assert rows["1"] == {**rows[alone], "id": "1"}
    assert rows["2"] == {**rows[alone], "id": "2", "tags": []}
    assert events == {job: [State.QUEUED] for job in rows}


def test_identifiers_sort_by_time() -> None:
    made = [new_id() for _ in range(2000)]
    assert made == sorted(set(made))
    import re

    assert all(re.fullmatch(PATTERN, one) for one in made)
