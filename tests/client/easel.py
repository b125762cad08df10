"""A service that renders nothing, with pictures that tests put there as another server that renders would."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from sqlalchemy import Engine

from woodcock.film import Film
from woodcock.image import write_exr
from woodcock.scene import Scene
from woodcock_server import results
from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.jobs import repository
from woodcock_server.jobs.states import State
from woodcock_server.storage import Storage, film_name

from .real import serving

NO_DEVICES = "import woodcock_server.app\nwoodcock_server.app.discover = list\n"
TOKEN = 1  # of the first holder


@dataclass(frozen=True)
class Easel:
    address: str
    engine: Engine
    storage: Storage

    def begin(self, scene: dict[str, Any], film: Film, name: str = "") -> str:
        """A job that another server renders, up to this film."""
        whole = {**scene, "film": {"width": film.width, "height": film.height}}
        asked = {"name": name, "scene": Scene.model_validate(whole).model_dump(mode="json"), "device": "any"}
        now = datetime.now(UTC)
        with self.engine.begin() as connection:
            job = repository.add(connection, asked, now)
            assert repository.claim(connection, job, "another", now, timedelta(days=1))
        self.storage.open_job(job)
        self.go_on(job, film)
        return job

    def go_on(self, job: str, film: Film) -> None:
        results.preview(self.storage.job_file(job, ""), film)
        film.save(self.storage.job_file(job, film_name(TOKEN)))
        self._write(job, samples=film.samples, seconds=film.samples / 10)

    def finish(self, job: str, film: Film) -> None:
        results.preview(self.storage.job_file(job, ""), film)
        write_exr(self.storage.job_file(job, "image.exr"), film, {})
        self.storage.write_text(job, "report.json", "{}")
        ended = {"state": State.SUCCEEDED, "finished_at": datetime.now(UTC), **repository.NOBODY}
        self._write(job, samples=film.samples, **ended)

    def hang(self, scene: dict[str, Any], film: Film, name: str = "") -> str:
        """A job that is done."""
        job = self.begin(scene, film, name)
        self.finish(job, film)
        return job

    def _write(self, job: str, **values: Any) -> None:
        with self.engine.begin() as connection:
            assert repository.write_held(connection, job, TOKEN, values)


@contextmanager
def standing(folder: Path) -> Iterator[Easel]:
    data = folder / "data"
    with serving(folder, NO_DEVICES) as address:
        engine = open_database(Settings(data=data).database)
        yield Easel(address, engine, Storage(data))
        engine.dispose()
