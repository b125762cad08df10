"""Commands that use what a service keeps: where that is, and what they say where it cannot be used."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import ValidationError
from sqlalchemy import make_url
from sqlalchemy.exc import SQLAlchemyError

from woodcock_server.config import Settings

Data = Annotated[
    Path | None,
    typer.Option(help="The service's data folder.", show_default="WOODCOCK_DATA, else the user's data folder"),
]


def settings_of(**given: Any) -> Settings:
    """Of options; those that are None are left to the environment. Ends the command with a sentence for each fault."""
    try:
        return Settings(**{name: value for name, value in given.items() if value is not None})
    except ValidationError as error:
        for one in error.errors():
            name = str(one["loc"][0])
            option = f" (or --{name.removeprefix('worker_')})" if name in given else ""
            typer.echo(f"WOODCOCK_{name.upper()}{option}: {one['msg']}", err=True)
        raise typer.Exit(2) from None


@contextmanager
def usable(settings: Settings) -> Iterator[None]:
    """Ends the command with a sentence for a data folder or a database that cannot be used."""
    try:
        yield
    except OSError as error:
        typer.echo(f"The data folder {settings.data} cannot be used: {error.strerror}.", err=True)
        raise typer.Exit(2) from None
    except SQLAlchemyError as error:
        typer.echo(f"The database {make_url(settings.database)!r} cannot be used: {reason(error)}.", err=True)
        raise typer.Exit(2) from None


def reason(error: SQLAlchemyError) -> str:
    """What the driver says, in one line; SQLAlchemy adds the statement and an address."""
    return " ".join(str(getattr(error, "orig", None) or error).split())
