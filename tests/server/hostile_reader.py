"""`python -m tests.server.hostile_reader FOLDER`: what the child process of the service would say of each file in a
folder, a line of JSON each. No file may take two seconds, or have another one opened."""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import Any

from woodcock_server.volumes.contents import UnreadableFile, confine, read

SECONDS = 2.0
#: Where modules are imported from, and what they ask of the machine.
OWN = (sys.prefix, sys.base_prefix, str(Path(__file__).parents[2]), "/proc/")

opened: set[str] = set()


def watch(event: str, arguments: tuple[Any, ...]) -> None:
    if event == "open" and isinstance(arguments[0], str | bytes):
        opened.add(os.fsdecode(arguments[0]))


def outcome(path: Path) -> str:
    """`volume`, `mesh` or `picture`; else the sentence. What must not be is an exception."""
    opened.clear()
    began = time.process_time()
    try:
        said = str(read(path)["type"])
    except UnreadableFile as error:
        said = str(error)
        assert said.isprintable(), said
        assert len(said) < 2000, said
    except MemoryError:
        said = "memory"
    took = time.process_time() - began
    assert took < SECONDS, f"took {took} s and said {said}"
    others = {name for name in opened if name != str(path) and not name.startswith(OWN)}
    assert not others, f"opened {others} and said {said}"
    return said


if __name__ == "__main__":
    confine(2 << 30, 500)
    sys.addaudithook(watch)
    for path in sorted(Path(sys.argv[1]).iterdir()):
        try:
            said = outcome(path)
        except Exception as error:
            said = f"failed: {error!r}"
        print(json.dumps([path.name, said]), flush=True)
