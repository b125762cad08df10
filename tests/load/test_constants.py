"""The constants behind the plan for larger services (server/scale.md): what a film costs whoever merges it, and what
the database takes with ever more jobs (`make load`; nothing else should run)."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
from distributed.core import connect, send_recv
from sqlalchemy import Connection, Engine, func, select, text
from tests.server.conftest import Service

from woodcock.film import Film
from woodcock_server import certificate
from woodcock_server.database import open_database
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs import listing, repository
from woodcock_server.ranges import FILM
from woodcock_server.tables import jobs

from .test_load import POINT, Make

pytestmark = [pytest.mark.load, pytest.mark.timeout(1200)]

T = TypeVar("T")
TIMES = 9

#: A process that has a film, and gives it to whoever asks.
GIVES = """\
import asyncio, sys
from pathlib import Path
import numpy as np
from distributed.core import Server
from distributed.protocol import to_serialize
from woodcock.film import Film
from woodcock_server import certificate

async def give():
    made = to_serialize(Film.load(Path(sys.argv[1])))
    async def film():
        return made
    server = Server({"film": film})
    secure = certificate.of(Path(sys.argv[2]))
    await server.listen("tls://127.0.0.1:0", **secure.get_listen_args("scheduler"))
    print(server.address, flush=True)
    await server.finished()

asyncio.run(give())
"""


def film(width: int, height: int, start: int) -> Film:
    values = np.random.default_rng(start)
    shape = height, width, 3
    count = np.full(shape[:2], 64, np.uint32)
    return Film(count, values.random(shape), values.random(shape), ("R", "G", "B"), ((start, start + 64),))


def least(do: Callable[[], object]) -> float:
    """Processor seconds of this process, the least of some times."""
    taken = []
    for _ in range(TIMES):
        began = time.process_time()
        do()
        taken.append(time.process_time() - began)
    return min(taken)


@pytest.mark.parametrize(("width", "height"), [(256, 256), (1920, 1080)])
def test_what_a_film_costs(width: int, height: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Merging it, and taking it from a worker over TLS."""
    mine, its = film(width, height, 0), film(width, height, 64)
    its.save(tmp_path / "film.npz")
    certificate.write(tmp_path / "farm", certificate.VALID)
    secure = certificate.of(tmp_path / "farm")
    command = [sys.executable, "-c", GIVES, str(tmp_path / "film.npz"), str(tmp_path / "farm")]

    async def taken(address: str) -> float:
        comm = await connect(address, **secure.get_connection_args("client"))  # type: ignore[no-untyped-call]
        times = []
        for _ in range(TIMES):
            began = time.process_time()
            assert isinstance(await send_recv(comm, op="film"), Film)
            times.append(time.process_time() - began)
        await comm.close()
        return min(times)

    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as giver:
        assert giver.stdout is not None
        receiving = asyncio.run(taken(giver.stdout.readline().strip()))
        giver.kill()
    merging, saving = least(lambda: mine.merge(its)), least(lambda: mine.save(tmp_path / "saved.npz"))
    megabytes = (mine.count.nbytes + mine.mean.nbytes + mine.m2.nbytes) / 1e6
    with capsys.disabled():
        print(
            f"\n{width} × {height}: {megabytes:.1f} MB; merging {1e3 * merging:.1f} ms, receiving "
            f"{1e3 * receiving:.1f} ms, saving {1e3 * saving:.1f} ms of the processor"
        )
    assert merging + receiving < 1.3 * FILM * merging


def test_what_a_job_costs(tmp_path: Path, make_scene: Make, capsys: pytest.CaptureFixture[str]) -> None:
    """The least of all jobs, of one sample, one after the other: a dispatcher renders one at a time."""
    service = Service(tmp_path / "data", POCL_DEVICES="pthread")
    service.start()

    def render(count: int) -> float:
        began = time.monotonic()
        ids = [service.submit(make_scene(size=16, samples=1, seed=seed)) for seed in range(count)]
        service.wait(ids[-1], lambda job: job["state"] == "succeeded", 120)
        return (time.monotonic() - began) / count

    render(3)  # builds what they need
    taken = render(40)
    service.stop()
    with capsys.disabled():
        print(f"\na job of 16 × 16 pixels and one sample: {1e3 * taken:.0f} ms")
    assert taken < 2


#: Of a job that has ended, copies of the one that there is: of a hundred owners, spread over a day.
ENDED = """\
INSERT INTO jobs (id, owner, state, created_at, started_at, finished_at, seconds, samples, size, series, {same})
SELECT '0' || lpad(n::text, 35, '0'), 'owner' || n % 100, 'succeeded', at, at, at, 0.5, 64, 100000,
    CAST(:series AS json), {same}
FROM jobs, generate_series(1, :count) n, LATERAL (SELECT now() - n * interval '1 day' / :count AS at) AS ended
"""
EVENTS = """\
INSERT INTO job_events (job_id, state, at)
SELECT id, unnest(array['queued', 'running', 'succeeded']), created_at FROM jobs WHERE state = 'succeeded'
"""
REPLACED = {"id", "owner", "state", "created_at", "started_at", "finished_at", "seconds", "samples", "size", "series"}


def stored(url: str, scene: dict[str, Any], count: int) -> Engine:
    """A database of jobs that have ended, and one that waits for its turn."""
    engine = open_database(url)
    with engine.begin() as connection:
        submit(connection, scene, "ann")
        same = ", ".join(column.name for column in jobs.c if column.name not in REPLACED)
        series = json.dumps([POINT] * 20)
        connection.execute(text(ENDED.format(same=same)), {"count": count, "series": series})
        connection.execute(text(EVENTS))
    with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
        connection.execute(text("VACUUM ANALYZE"))
    return engine


def submit(connection: Connection, scene: dict[str, Any], owner: str) -> str:
    asked = {"name": "cloud", "scene": scene, "device": ANY, "tags": ["sky"], "owner": owner}
    return repository.add(connection, asked, datetime.now(UTC))


@pytest.mark.parametrize("count", [10_000, 100_000, 1_000_000])
def test_what_the_database_takes(
    count: int, postgres: Callable[[], str], make_scene: Make, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each as the service does it, transaction and all."""
    scene = make_scene(size=64)
    engine = stored(postgres(), scene, count)
    times: dict[str, list[float]] = {}

    def timed(what: str, do: Callable[[Connection], T]) -> T:
        began = time.perf_counter()
        with engine.begin() as connection:
            done = do(connection)
        times.setdefault(what, []).append(time.perf_counter() - began)
        return done

    for number in range(TIMES):
        now, lease = datetime.now(UTC), timedelta(seconds=10)
        timed("submit", partial(submit, scene=scene, owner=f"owner{number}"))
        timed("submit", partial(submit, scene=scene, owner=f"owner{number + 1}"))
        job_id = timed("look", partial(repository.next_claimable, now=now, devices={ANY}))
        assert job_id
        row = timed("claim", partial(repository.claim, job_id=job_id, holder="test", now=now, lease=lease))
        assert row
        held = partial(repository.write_held, job_id=job_id, token=row["token"], values={"lease_until": now + lease})
        assert timed("renew", held)
        timed("list", partial(listing.page, limit=50, cursor=None, meant=listing.Filter()))
        timed("count", listing.states)
    with engine.connect() as connection:
        size = sum(
            connection.execute(select(func.pg_total_relation_size(name))).scalar_one()
            for name in ("jobs", "job_events")
        )
    engine.dispose()
    with capsys.disabled():
        told = ", ".join(f"{what} {1e3 * float(np.median(each)):.1f} ms" for what, each in times.items())
        print(f"\n{count} jobs within a day: {told}; {size / count:.0f} bytes a job")
    assert np.median(times["renew"]) < 0.05, "what a dispatcher does all the time does not get slower"
