"""How the `woodcock` program ends."""

from __future__ import annotations

from typing import NoReturn

import typer

#: Exit codes, beside 0.
FAILED, BAD_INPUT, UNREACHABLE, INTERRUPTED = 1, 2, 3, 130


def fail(message: str, code: int) -> NoReturn:
    typer.echo(f"woodcock: {message}", err=True)
    raise SystemExit(code)
