"""What an import says: what could not be carried over, each with its place; and the fault that ends an import."""

from __future__ import annotations

import math
from dataclasses import dataclass, field


class SourceError(ValueError):
    """A scene of another renderer that cannot be read; the text names the file, the line and what would be right."""


@dataclass(frozen=True)
class Note:
    """Something that the new scene has otherwise or not at all: `where` is `file:line`."""

    where: str
    what: str

    def __str__(self) -> str:
        return f"{self.where}: {self.what}"


@dataclass
class Report:
    """Everything that was not carried over exactly, in the order of finding, each once."""

    notes: list[Note] = field(default_factory=list)

    def note(self, where: str, what: str) -> None:
        note = Note(where, what)
        if note not in self.notes:
            self.notes.append(note)


def number(text: str, where: str, what: str) -> float:
    """A finite number. Raises SourceError."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SourceError(f"{where}: {what} must be a finite number, not {shown(text)}")
    return value


def integer(text: str, where: str, what: str) -> int:
    """A whole number. Raises SourceError."""
    value = number(text, where, what)
    if value != int(value):
        raise SourceError(f"{where}: {what} must be a whole number, not {shown(text)}")
    return int(value)


def shown(text: str) -> str:
    """A text out of a file, fit for a message: short and on one line."""
    clean = "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text[:60])
    return f'"{clean}"' if len(text) <= 60 else f'"{clean}…"'
