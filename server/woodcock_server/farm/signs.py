"""Signs of life of a process of the farm, which nobody could ask for them without the farm's certificate: files."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager, suppress
from pathlib import Path

#: The process gives them while its event loop turns.
ALIVE = "alive"
#: All devices of a worker host are with the scheduler.
CONNECTED = "connected"

#: How often they are given, seconds.
BEAT_SECONDS = 5.0


@asynccontextmanager
async def given(signs: Callable[[], Iterable[str]]) -> AsyncIterator[Path]:
    """Touch files of these names again and again, in a folder for this process's working files, which is yielded and
    removed at the end: `woodcock-*` in the temporary one."""
    with tempfile.TemporaryDirectory(prefix="woodcock-") as name:
        beating = asyncio.create_task(_beat(Path(name), signs))
        try:
            yield Path(name)
        finally:
            beating.cancel()


async def _beat(folder: Path, signs: Callable[[], Iterable[str]]) -> None:
    while True:
        for sign in signs():
            with suppress(OSError):  # Who looks for it learns of it.
                (folder / sign).touch()
        await asyncio.sleep(BEAT_SECONDS)
