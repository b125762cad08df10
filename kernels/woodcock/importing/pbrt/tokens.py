"""pbrt's text as tokens that know their line."""

from __future__ import annotations

import bisect
import re
from dataclasses import dataclass
from pathlib import Path

from woodcock.importing.report import SourceError, shown

MAX_BYTES = 256 << 20

_TOKEN = re.compile(r'"(?:[^"\\\n]|\\[^\n])*"|[\[\]]|#[^\n]*|[^\s"\[\]#]+|"')
_ESCAPES = {"n": "\n", "t": "\t", "r": "\r", "b": "\b", "f": "\f"}


@dataclass(frozen=True)
class Token:
    """`quoted` tokens are strings, without their quotes."""

    text: str
    quoted: bool
    start: int


class Tokens:
    """A file's tokens, one after the other."""

    def __init__(self, path: Path, name: str, where: str) -> None:
        try:
            with path.open("rb") as file:
                data = file.read(MAX_BYTES + 1)
        except (OSError, ValueError) as error:
            raise SourceError(f"{where}: {shown(name)} cannot be read: {getattr(error, 'strerror', error)}") from None
        if len(data) > MAX_BYTES:
            raise SourceError(f"{name}: is larger than {MAX_BYTES >> 20} MiB")
        if b"\0" in data[:4096]:
            raise SourceError(f"{name}: is neither Mitsuba's XML nor pbrt's text")
        text = data.decode("utf-8", errors="replace")
        self.name, self.size = name, len(data)
        self._text, self._position = text, 0
        self._lines = [match.start() for match in re.finditer("\n", text)]
        self._next = self._read()

    def _read(self) -> Token | None:
        match = _TOKEN.search(self._text, self._position)
        while match is not None and match[0][0] == "#":
            match = _TOKEN.search(self._text, match.end())
        if match is None:
            return None
        text, self._position = match[0], match.end()
        if text == '"':
            raise SourceError(f"{self.at(match.start())}: a string has no end on its line")
        if text[0] != '"':
            return Token(text, False, match.start())
        return Token(re.sub(r"\\(.)", lambda m: _ESCAPES.get(m[1], m[1]), text[1:-1]), True, match.start())

    def at(self, start: int) -> str:
        return f"{self.name}:{bisect.bisect_left(self._lines, start) + 1}"

    @property
    def here(self) -> str:
        """Where the next token is, or the end."""
        return self.at(self._next.start) if self._next else f"{self.name}:{len(self._lines) + 1}"

    def peek(self) -> Token | None:
        return self._next

    def take(self) -> Token:
        token = self._next
        if token is None:
            raise SourceError(f"{self.here}: ends in the middle of a directive")
        self._next = self._read()
        return token

    def string(self) -> str:
        where, token = self.here, self.take()
        if not token.quoted:
            raise SourceError(f"{where}: expected a string in quotes, not {shown(token.text)}")
        return token.text

    def values(self) -> list[str]:
        """One value, or those between brackets."""
        where, token = self.here, self.take()
        if token.quoted or token.text not in "[]":
            return [token.text]
        end = self._text.find("]", token.start + 1)
        plain = self._text[token.start + 1 : end] if token.text == "[" and end >= 0 else '"'
        if not re.search(r'["#\[]', plain):  # bare numbers, of which there may be millions
            self._position = end + 1
            self._next = self._read()
            return plain.split()
        found = []
        while token.text != "]" or token.quoted:
            if self.peek() is None or token.text == "]":
                raise SourceError(f"{where}: a list has no end")
            token = self.take()
            if token.text == "[" and not token.quoted:
                raise SourceError(f"{where}: a list begins inside a list")
            found.append(token.text)
        return found[:-1]
