"""What a deliberate bug is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Sin:
    """A mistake of one line, as somebody might make it: the program still builds and its pictures look plausible.

    name: what is wrong; file: from the repository's root; old: part of one line of it, found there exactly once, which
    `new` replaces; tests: node ids of those that should notice, without parameters where all may.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def fault(self, root: Path) -> str | None:
        """What is wrong with the list: the line is no longer there, or more than once."""
        count = (root / self.file).read_text().count(self.old)
        return None if count == 1 else f"{self.name}: {self.file} has {count} times {self.old!r}"

    def commit(self, root: Path) -> None:
        """Puts the mistake into a copy of the tree. Raises ValueError where it does not fit."""
        if fault := self.fault(root):
            raise ValueError(fault)
        path = root / self.file
        path.write_text(path.read_text().replace(self.old, self.new))


def device(path: str) -> str:
    """A file of the renderer."""
    return f"kernels/woodcock/{path}"
