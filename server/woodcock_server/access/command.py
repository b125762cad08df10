"""`woodcock token`"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Annotated

import typer
from sqlalchemy import Connection

from woodcock_server.access import tokens
from woodcock_server.access.tokens import Scope
from woodcock_server.database import open_database
from woodcock_server.usable import Data, settings_of, usable

app = typer.Typer(
    help="Make, list and revoke the tokens that a service asks for once there is one.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@contextmanager
def _database(data: Path | None) -> Iterator[Connection]:
    settings = settings_of(data=data)
    with usable(settings):
        settings.data.mkdir(parents=True, exist_ok=True)
        engine = open_database(settings.database)
        with engine.execution_options(immediate=True).begin() as connection:
            yield connection
        engine.dispose()


@app.command()
def create(
    name: Annotated[str, typer.Argument(help="Whose it is, or what for.")],
    owner: Annotated[
        str | None, typer.Option(help="Whose jobs it makes; limits and turns are by owner.", show_default="NAME")
    ] = None,
    scope: Annotated[Scope, typer.Option(help="What it is good for.")] = Scope.WRITE,
    days: Annotated[int | None, typer.Option(min=1, max=3650, help="Until it expires.", show_default="never")] = None,
    data: Data = None,
) -> None:
    """Make a token and print it: the only time that it is shown."""
    now = datetime.now(UTC)
    with _database(data) as connection:
        _, text = tokens.create(
            connection, name, owner or name, scope, now, now + timedelta(days=days) if days else None
        )
    typer.echo(text)


@app.command("list")
def show(data: Data = None) -> None:
    """All tokens, without what they are."""
    with _database(data) as connection:
        for row in tokens.every(connection):
            made = f"{row['id']}  {row['scope']:5}  made {row['created_at']:%Y-%m-%d}  {row['owner']}"
            typer.echo(f"{made}  {_end(row):18}  {row['name']}".rstrip())


def _end(row: tokens.Row) -> str:
    if row["revoked_at"]:
        return f"revoked {row['revoked_at']:%Y-%m-%d}"
    return f"until {row['expires_at']:%Y-%m-%d}" if row["expires_at"] else ""


@app.command()
def revoke(id: Annotated[str, typer.Argument(help="As `woodcock token list` has it.")], data: Data = None) -> None:
    """Let a token be good for nothing, from now on."""
    with _database(data) as connection:
        if not tokens.revoke(connection, id, datetime.now(UTC)):
            typer.echo(f"There is no token {id} that could be revoked; `woodcock token list` has all.", err=True)
            raise typer.Exit(2)
