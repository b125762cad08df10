"""Files that are kept in a bucket: each under a key of its own, never written to again; rows say which is which."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import structlog
from sqlalchemy import Connection, Engine, delete, func, insert, select

from woodcock.scene import UPLOADED
from woodcock_server.copies import Copies
from woodcock_server.identifiers import new_id
from woodcock_server.storage import Collected, Storage, StoreAway, film_name, token_of
from woodcock_server.store import LARGEST_COPY, Found, Store
from woodcock_server.tables import objects, volumes

log = structlog.get_logger()

VOLUMES, JOBS = "volumes/", "jobs/"
#: How often what no row names is looked for, seconds, and how long it has been there before it goes.
COLLECT_EVERY, GRACE = 86400.0, timedelta(days=1)
#: Of an uploaded file.
LOST = "the object store has it no more"
#: A file takes another one's place while it is fetched.
TRIES = 3


def volume_key(volume_id: str) -> str:
    """Of the file `sha256:<64 hex>`."""
    return VOLUMES + volume_id.removeprefix(UPLOADED)


class BucketStorage(Storage):
    """The data folder has what is on its way out, and copies."""

    def __init__(self, root: Path, engine: Engine, store: Store, room: int) -> None:
        """room: bytes that copies may take. Raises OSError."""
        self.copies = Copies(root / "copies", room)  # first: only one service passes here
        self._engine, self._store = engine, store
        self._collect_at = time.monotonic()
        leaving = root / "scratch" / "leaving"
        shutil.rmtree(leaving, ignore_errors=True)
        super().__init__(root, leaving)

    def close(self) -> None:
        self.copies.close()

    def try_writing(self) -> None:
        super().try_writing()
        self._store.try_writing()

    # Volumes

    @contextmanager
    def bringing_volume(self, upload: Path, volume_id: str) -> Iterator[Callable[[], None]]:
        key = volume_key(volume_id)
        self._store.put(key, upload)  # beforehand: while the row is being written others wait

        def keep() -> None:
            if self._store.size(key) is None:
                raise Collected

        yield keep
        self.copies.adopt(key, upload)

    def has_volume(self, volume_id: str) -> bool:
        return self._store.size(volume_key(volume_id)) is not None

    def volume_file(self, volume_id: str) -> Path:
        key = volume_key(volume_id)
        try:
            return self.copies.get(key, partial(self._fetch_volume, volume_id))
        except FileNotFoundError as error:
            log.error("an uploaded file is lost", file=volume_id, reason=str(error))
            return self.copies.path(key)

    def _fetch_volume(self, volume_id: str, path: Path) -> None:
        """Raises FileNotFoundError for one that is not what it was."""
        found = self._store.fetch(volume_key(volume_id), path)
        if UPLOADED + found != volume_id:
            raise FileNotFoundError(f"The object store holds other bytes, of SHA-256 {found}.")

    @contextmanager
    def volume_files(self, volume_ids: Iterable[str]) -> Iterator[dict[str, Path]]:
        wanted = set(volume_ids)
        with self.copies.holding([volume_key(each) for each in wanted]):
            yield {each: self.volume_file(each) for each in wanted}

    def volume_source(self, volume_id: str) -> tuple[int, str | None]:
        key = volume_key(volume_id)
        size = self._store.size(key)
        if size is None:
            raise FileNotFoundError(LOST)
        return size, self._store.url(key)

    def read_volume(self, volume_id: str, offset: int, length: int) -> bytes:
        try:
            return self._store.read(volume_key(volume_id), offset, length)
        except FileNotFoundError:
            raise FileNotFoundError(LOST) from None

    def drop_volume(self, volume_id: str) -> None:
        key = volume_key(volume_id)
        self._store.delete([key])
        self.copies.drop(key)

    def by_id(self, sentence: str) -> str:
        return super().by_id(sentence.replace(str(self.copies.path(VOLUMES)), UPLOADED))

    # Jobs

    def job_file(self, job_id: str, name: str) -> Path:
        for _ in range(TRIES):
            with self._engine.connect() as connection:
                mine = objects.c.job_id == job_id, objects.c.name == name
                key = connection.execute(select(objects.c.key).where(*mine)).scalar()
            if key is None:
                break
            try:
                return self.copies.get(key, partial(self._store.fetch, key))
            except FileNotFoundError as error:  # Another one took its place; or it is lost.
                log.warning("an object is gone", job=job_id, name=name, reason=str(error))
        return self.jobs / job_id / name

    def open_job(self, job_id: str) -> None:
        shutil.rmtree(self.jobs / job_id, ignore_errors=True)

    def stage(self, job_id: str, token: int) -> Path:
        (self.jobs / job_id).mkdir(exist_ok=True)
        return super().stage(job_id, token)

    @contextmanager
    def publishing(self, job_id: str, token: int) -> Iterator[Callable[[Connection], None]]:
        # Under new keys, beforehand: whoever lost the lease has written what nobody names.
        made = {path: _new_key(job_id, path.name) for path in self._made(job_id, token)}
        for path, key in made.items():
            self._store.put(key, path)
        replaced: list[str] | None = None

        def publish(connection: Connection) -> None:
            nonlocal replaced
            replaced = _name(connection, job_id, {path.name: (key, path.stat().st_size) for path, key in made.items()})

        yield publish
        # Not where the block raised: nobody knows then which of both the rows name.
        if replaced is None:
            self._forget(list(made.values()))
        else:
            for path, key in made.items():
                self.copies.adopt(key, path)
            self._forget(replaced)
        self.unstage(job_id, token)

    def unstage(self, job_id: str, token: int) -> None:
        super().unstage(job_id, token)
        with suppress(OSError):  # It is not there, or another holder's is.
            (self.jobs / job_id).rmdir()

    def remove_job(self, job_id: str) -> None:
        with self._engine.begin() as connection:
            gone = delete(objects).where(objects.c.job_id == job_id).returning(objects.c.key)
            keys = list(connection.execute(gone).scalars())
        self._forget(keys)
        super().remove_job(job_id)

    def size(self, job_id: str) -> int:
        with self._engine.connect() as connection:
            taken = select(func.coalesce(func.sum(objects.c.size), 0)).where(objects.c.job_id == job_id)
            return int(connection.execute(taken).scalar_one())

    def folders(self) -> set[str]:
        with self._engine.connect() as connection:
            return set(connection.execute(select(objects.c.job_id).distinct()).scalars())

    def write_text(self, job_id: str, name: str, text: str) -> None:
        content, key = text.encode(), _new_key(job_id, name)
        self._store.put(key, content)
        with self._engine.begin() as connection:
            replaced = _name(connection, job_id, {name: (key, len(content))})
        self._forget(replaced)

    def newest_checkpoint(self, job_id: str) -> Path | None:
        films = self._films(job_id)
        path = self.job_file(job_id, max(films, key=token_of)) if films else None
        return path if path is not None and path.exists() else None

    def drop_checkpoints(self, job_id: str, before: int) -> None:
        old = [name for name in self._films(job_id) if token_of(name) < before]
        if old:
            with self._engine.begin() as connection:
                mine = objects.c.job_id == job_id, objects.c.name.in_(old)
                keys = list(connection.execute(delete(objects).where(*mine).returning(objects.c.key)).scalars())
            self._forget(keys)

    def hand_on(self, old: str, new: str) -> bool:
        with self._engine.connect() as connection:
            mine = select(objects.c.name, objects.c.key, objects.c.size).where(objects.c.job_id == old)
            found: dict[str, Any] = {row.name: row for row in connection.execute(mine)}
        film = max(found, key=token_of, default="")
        if token_of(film) < 0:
            return False
        handed = dict[str, tuple[str, int]]()
        for name in {film, "preview.png", "thumbnail.webp"} & found.keys():
            key, size = _new_key(new, name), found[name].size
            try:
                if size <= LARGEST_COPY:
                    self._store.copy(found[name].key, key)
                else:
                    self._store.put(key, self.job_file(old, name))
            except FileNotFoundError:  # It was deleted just now.
                return False
            handed[film_name(0) if name == film else name] = key, size
        with self._engine.begin() as connection:
            _name(connection, new, handed)
        return True

    def _films(self, job_id: str) -> list[str]:
        with self._engine.connect() as connection:
            names = connection.execute(select(objects.c.name).where(objects.c.job_id == job_id)).scalars()
            return [name for name in names if token_of(name) >= 0]

    # What no row names

    def _forget(self, keys: Sequence[str]) -> None:
        """What cannot be deleted now is collected later."""
        for key in keys:
            self.copies.drop(key)
        try:
            self._store.delete(keys)
        except StoreAway as error:
            log.warning("objects not deleted yet", objects=len(keys), reason=str(error))

    def collect(self) -> None:
        """A server that was killed, or did not reach the store, left objects that no row names: once a day they go."""
        if time.monotonic() < self._collect_at:
            return
        before, count = datetime.now(UTC) - GRACE, 0
        for prefix, unnamed in ((VOLUMES, self._unnamed_volumes), (JOBS, self._unnamed)):
            for page in self._store.list(prefix):
                keys = unnamed([each for each in page if each.modified < before])
                self._store.delete(keys)
                count += len(keys)
        self._collect_at = time.monotonic() + COLLECT_EVERY
        log.info("objects that nothing names deleted", objects=count)

    def _unnamed(self, found: Sequence[Found]) -> list[str]:
        keys = {each.key for each in found}
        with self._engine.connect() as connection:
            return sorted(keys - {*connection.execute(select(objects.c.key).where(objects.c.key.in_(keys))).scalars()})

    def _unnamed_volumes(self, found: Sequence[Found]) -> list[str]:
        keys = {UPLOADED + each.key.removeprefix(VOLUMES): each.key for each in found}
        with self._engine.connect() as connection:
            known = {*connection.execute(select(volumes.c.id).where(volumes.c.id.in_(keys))).scalars()}
        return [key for volume_id, key in keys.items() if volume_id not in known]


def _new_key(job_id: str, name: str) -> str:
    return f"{JOBS}{job_id}/{new_id()}/{name}"


def _name(connection: Connection, job_id: str, made: dict[str, tuple[str, int]]) -> list[str]:
    """A job's files are under these keys from now on, name -> key and bytes; returns those that they were under."""
    if not made:
        return []
    mine = objects.c.job_id == job_id, objects.c.name.in_(made)
    replaced = list(connection.execute(delete(objects).where(*mine).returning(objects.c.key)).scalars())
    rows = [{"job_id": job_id, "name": name, "key": key, "size": size} for name, (key, size) in made.items()]
    connection.execute(insert(objects), rows)
    return replaced
