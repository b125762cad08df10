"""The stages of a job's way at which faults strike. `install` is run in the service and its workers, before anything
else: it wraps the function of each stage, which waits there, once, if it is told to. The product knows nothing of
it."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any

#: Stage -> at which of its visits it is held. From the third piece of a job on there is a checkpoint of the first.
STAGES = {
    "claim": 1,  # the claim is committed, nothing else done
    "build": 1,  # in the worker, worker.prepare
    "mid-range": 4,  # in the worker, worker.render_range
    "merged": 2,  # the Film has the piece; neither preview, row nor checkpoint
    "kept": 2,  # the checkpoint is written, what follows not done
    "exr": 1,  # image.exr is written under its temporary name
    "ended": 1,  # the end is committed, what follows not done
}
#: Those that are after a checkpoint was written and before the last time it may be read.
WITH_CHECKPOINT = ("mid-range", "merged", "kept", "exr")

PRELUDE = f"import runpy; runpy.run_path({__file__!r})['install']()\n"
#: Samples of a piece, always: sums of floats are the same only if they are made in the same order.
PIECE = 64
#: How long a stage waits for the test at most, seconds.
PATIENCE = 120.0


class Gates:
    """A folder by which the test and the processes of a service talk: files in it are armed, reached, opened."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(exist_ok=True)

    # In the test

    def arm(self, stage: str) -> None:
        """Hold whoever comes to the stage for the so many-th time."""
        for path in self.folder.iterdir():
            path.unlink()
        (self.folder / f"{stage}.{STAGES[stage]}").touch()

    def reached(self, stage: str, seconds: float = 90) -> str:
        """Wait until somebody is held; returns the name of the service, or of a farm's worker host."""
        held = self.folder / f"{stage}.0"
        end = time.monotonic() + seconds
        while not (held.exists() and (name := held.read_text())):
            assert time.monotonic() < end, f"nobody came to the stage {stage}"
            time.sleep(0.01)
        return name

    def open(self) -> None:
        """Let go of whoever is held."""
        self.ask("open")

    def passed(self, stage: str) -> bool:
        """Nobody is held there any more."""
        return not (self.folder / f"{stage}.0").exists()

    def ask(self, what: str) -> None:
        (self.folder / what).touch()

    # In the service

    def asked(self, what: str) -> bool:
        """Once."""
        try:
            (self.folder / what).unlink()
        except FileNotFoundError:
            return False
        return True

    def held(self, stage: str) -> Iterator[None]:
        """Yields for as long as this visit of the stage is held."""
        for left in range(STAGES[stage], 0, -1):
            try:
                held = (self.folder / f"{stage}.{left}").rename(self.folder / f"{stage}.{left - 1}")
            except FileNotFoundError:
                continue
            if left == 1:
                held.write_text(os.environ["CHAOS_NAME"])
                end = time.monotonic() + PATIENCE
                while not (self.folder / "open").exists() and time.monotonic() < end:
                    yield
                held.unlink(missing_ok=True)
            return

    def hold(self, stage: str) -> None:
        for _ in self.held(stage):
            time.sleep(0.01)

    async def hold_loop(self, stage: str) -> None:
        """The same in a coroutine."""
        for _ in self.held(stage):
            await asyncio.sleep(0.01)


def install() -> None:
    """Wrap the stages, and have pieces of one size, each of which is written down."""
    from woodcock import image
    from woodcock_server import claim, database, dispatcher, rendering, rounds, worker
    from woodcock_server.farm import remote

    gates = Gates(Path(os.environ["CHAOS_GATES"]))

    def wrap(owner: Any, name: str) -> Callable[[Callable[..., Any]], None]:
        """The decorated function gets the original before its arguments."""

        def put(function: Callable[..., Any]) -> None:
            original = getattr(owner, name)
            if asyncio.iscoroutinefunction(original):

                @wraps(original)
                async def wrapped(*args: Any, **kwargs: Any) -> Any:
                    return await function(original, *args, **kwargs)
            else:

                @wraps(original)
                def wrapped(*args: Any, **kwargs: Any) -> Any:
                    return function(original, *args, **kwargs)

            setattr(owner, name, wrapped)

        return put

    @wrap(dispatcher.Dispatcher, "_claim")
    def _(original: Any, *args: Any) -> Any:
        claimed = original(*args)
        if claimed is not None:
            gates.hold("claim")
        return claimed

    @wrap(worker, "prepare")
    def _(original: Any, *args: Any) -> Any:
        gates.hold("build")
        return original(*args)

    @wrap(worker, "render_range")
    def _(original: Any, *args: Any) -> Any:
        rendered = original(*args)
        gates.hold("mid-range")
        return rendered

    @wrap(rendering.Rendering, "_record")
    async def _(original: Any, *args: Any) -> None:
        await gates.hold_loop("merged")
        await original(*args)

    @wrap(claim.Claim, "keep")
    async def _(original: Any, *args: Any) -> None:
        await original(*args)
        await gates.hold_loop("kept")

    @wrap(claim.Claim, "_write")
    def _(original: Any, self: Any, values: dict[str, Any], *more: Any) -> bool:
        written: bool = original(self, values, *more)
        if written and values.get("state") == "succeeded":
            gates.hold("ended")
        return written

    replacing = image.replacing

    @contextmanager
    def held(path: Path) -> Iterator[Path]:
        with replacing(path) as temporary:
            yield temporary
            if path.name == "image.exr":
                gates.hold("exr")

    image.replacing = held

    # What the test asks of a process.

    @wrap(dispatcher.Dispatcher, "_run")
    async def _(original: Any, *args: Any) -> None:
        task, loop = asyncio.current_task(), asyncio.get_running_loop()
        assert task is not None

        def look() -> None:
            if gates.asked("cancel"):
                task.cancel()
            loop.call_later(0.01, look)

        look()
        await original(*args)

    @wrap(dispatcher.Dispatcher, "_renew")
    def _(original: Any, *args: Any) -> bool:
        if gates.asked("raise"):
            raise RuntimeError("can't start new thread")
        renewed: bool = original(*args)
        return renewed

    # A cell need not last as long as these do in the product.

    @wrap(database, "_configure_sqlite")
    def _(original: Any, connection: Any, record: Any) -> None:
        original(connection, record)
        connection.execute("PRAGMA busy_timeout=500")

    remote.AWAY_SECONDS = 5.0

    rounds.share = lambda *_: PIECE
    rendering.PROGRESS_SECONDS = rendering.CHECKPOINT_SECONDS = -1e9
