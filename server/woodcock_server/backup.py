"""`woodcock backup`: a copy of everything the service keeps, taken while it runs, which is a data folder itself."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Annotated

import typer
from sqlalchemy import make_url

from woodcock_server.config import Settings
from woodcock_server.storage import Storage


class BackupError(RuntimeError):
    """There is no backup; the text says why."""


def backup(
    target: Annotated[Path, typer.Argument(help="A folder that does not exist yet.")],
    data: Annotated[
        Path | None,
        typer.Option(help="The service's data folder.", show_default="WOODCOCK_DATA, else the user's data folder"),
    ] = None,
) -> None:
    """Copy everything that a service keeps; it may go on meanwhile. To restore, serve the copy: `woodcock serve --data`.

    Renders that had not ended begin anew there.
    """
    settings = Settings(data=data) if data else Settings()
    try:
        copy(settings, target)
    except BackupError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(2) from None
    except OSError as error:
        typer.echo(f"The backup was not made: {error.filename or target}: {error.strerror}.", err=True)
        raise typer.Exit(1) from None


def copy(settings: Settings, target: Path) -> None:
    """The whole appears under its name or not at all. Raises BackupError, OSError."""
    database = make_url(settings.database)
    if database.get_backend_name() != "sqlite" or not database.database:
        raise BackupError("The database is no file: back it up by its own means (pg_dump), and the data folder after it.")
    if not Path(database.database).is_file():
        raise BackupError(f"There is no service's data in {settings.data}.")
    if target.exists():
        raise BackupError(f"{target} exists already; name a folder that does not.")
    part = target.with_name(f"{target.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    kept = Storage(part)
    try:
        # The rows first: whatever they name is complete by then, and files are never changed, only deleted after their row.
        _copy_database(Path(database.database), part / "woodcock.sqlite")
        _copy_files(settings.data / "volumes", kept.volumes)
        _copy_files(settings.data / "jobs", kept.jobs)
        part.rename(target)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def _copy_database(source: Path, target: Path) -> None:
    """As of one moment, whoever writes meanwhile."""
    try:
        with closing(sqlite3.connect(f"file:{source}?mode=ro", uri=True)) as old, closing(sqlite3.connect(target)) as new:
            old.backup(new)
    except sqlite3.Error as error:
        raise BackupError(f"The database {source} cannot be copied: {error}.") from None


def _copy_files(source: Path, target: Path) -> None:
    """Without checkpoints, which are newer than the rows, and what disappears meanwhile."""
    for path in sorted(source.rglob("*")):
        to = target / path.relative_to(source)
        if path.is_dir():
            to.mkdir(parents=True, exist_ok=True)
        elif not path.match("film-*.npz") and not path.name.startswith("."):
            try:
                shutil.copy2(path, to)
            except FileNotFoundError:
                continue
