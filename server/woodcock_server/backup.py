"""`woodcock backup`: a copy of everything the service keeps, taken while it runs, which is a data folder itself."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Collection
from contextlib import closing, suppress
from pathlib import Path
from typing import Annotated

import typer
from sqlalchemy import make_url

from woodcock_server.config import Settings
from woodcock_server.storage import Storage
from woodcock_server.usable import Data, settings_of


class BackupError(RuntimeError):
    """There is no backup; the text says why."""


def backup(
    target: Annotated[Path, typer.Argument(help="A folder that does not exist yet.")],
    data: Data = None,
) -> None:
    """Copy everything that a service keeps; it may go on meanwhile. To restore it, serve the copy.

    Renders that had not ended begin anew there.
    """
    try:
        copy(settings_of(data=data), target)
    except BackupError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(2) from None
    except OSError as error:
        typer.echo(f"The backup was not made: {error.filename or target}: {error.strerror}.", err=True)
        raise typer.Exit(1) from None


def copy(settings: Settings, target: Path) -> None:
    """The whole appears under its name or not at all. Raises BackupError, OSError."""
    if settings.store is not None:
        raise BackupError(
            f"The files are in {settings.store}: back up the database first, by its own means, and the bucket after it."
        )
    database = make_url(settings.database)
    if database.get_backend_name() != "sqlite" or not database.database:
        raise BackupError(
            "The database is no file: back it up by its own means (pg_dump), and the data folder after it."
        )
    if not Path(database.database).is_file():
        raise BackupError(f"There is no service's data in {settings.data}.")
    if target.exists():
        raise BackupError(f"{target} exists already; name a folder that does not.")
    part = target.with_name(f"{target.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    kept = Storage(part)
    try:
        # The rows first: what they name is complete by then, and files are never changed, only deleted after their row.
        ended = _copy_database(Path(database.database), part / "woodcock.sqlite")
        _copy_files(settings.data / "volumes", kept.volumes)
        for folder in sorted((settings.data / "jobs").glob("*")):
            # Films of jobs that had not ended are newer than their rows.
            _copy_files(folder, kept.jobs / folder.name, () if folder.name in ended else ("film-*",))
        part.rename(target)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def _copy_database(source: Path, target: Path) -> set[str]:
    """As of one moment, whoever writes meanwhile; returns the jobs that had ended."""
    try:
        with (
            closing(sqlite3.connect(f"file:{source}?mode=ro", uri=True)) as old,
            closing(sqlite3.connect(target)) as new,
        ):
            old.backup(new)
            return {id for (id,) in new.execute("SELECT id FROM jobs WHERE finished_at IS NOT NULL")}
    except sqlite3.Error as error:
        raise BackupError(f"The database {source} cannot be copied: {error}.") from None


def _copy_files(source: Path, target: Path, without: Collection[str] = ()) -> None:
    """But not what is being written, nor what disappears meanwhile. without: patterns of names."""
    target.mkdir(exist_ok=True)
    for path in sorted(source.glob("*")):
        if not any(path.match(pattern) for pattern in (".*", *without)):
            with suppress(FileNotFoundError):
                shutil.copy2(path, target)
