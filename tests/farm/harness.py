"""A farm of processes: a scheduler, worker hosts and a service, all on this machine's network or each on its own."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from tests.server.conftest import Service

from woodcock_server import certificate

from .network import Network

PROGRAM = """\
import typer
from woodcock_server.farm.command import {command}
if __name__ == '__main__': typer.run({command})
"""

# Preludes

#: Ranges of one size in a service: sums of floats are the same only where they are of the same samples.
PIECES = "from woodcock_server import rounds\nrounds.share = lambda *_: 64\n"
#: And each takes a while, in a worker.
SLOWLY = """\
import time
from woodcock_server import worker
render = worker.render_range
def render_range(*args):
    time.sleep(0.4)
    return render(*args)
worker.render_range = render_range
render_range.__module__, render_range.__qualname__ = worker.__name__, "render_range"
"""


def wait_until(reached: Callable[[], Any], seconds: float, log: Callable[[], str] = str) -> None:
    end = time.monotonic() + seconds
    while not reached():
        assert time.monotonic() < end, f"it took too long\n{log()}"
        time.sleep(0.05)


def free_ports(count: int) -> list[int]:
    """Of the loopback; nobody has them yet."""
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


class Part:
    """A command of a farm as a process. within: the command that runs it elsewhere."""

    def __init__(
        self,
        folder: Path,
        command: str,
        *options: str,
        prelude: str = "",
        within: Sequence[str] = (),
        **environment: str,
    ) -> None:
        folder.mkdir(exist_ok=True)
        program = folder / "program.py"
        program.write_text(prelude + PROGRAM.format(command=command))
        self.log = folder / "log.txt"
        self._command = [*within, sys.executable, str(program), *options]
        self._environment = {**os.environ, "WOODCOCK_PREPARE": "0", **environment}
        self.start()

    def start(self) -> None:
        with self.log.open("a") as log:
            self.process = subprocess.Popen(
                self._command,
                stdout=subprocess.PIPE,
                stderr=log,
                env=self._environment,
                start_new_session=True,
                text=True,
            )

    def said(self, pattern: str) -> str:
        """What its first line of output has of this."""
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        found = re.search(pattern, line)
        assert found, f"{line}{self.log.read_text()}"
        return found[0]

    def stop(self, sent: signal.Signals = signal.SIGTERM) -> int:
        """Returns the exit status. SIGKILL is for all of its processes, as when a machine fails."""
        with self.process as process, suppress(ProcessLookupError):
            if sent is signal.SIGKILL:
                os.killpg(process.pid, sent)
            else:
                process.send_signal(sent)
        return int(process.returncode)


class Farm:
    """within: host's name -> the command that runs something there."""

    def __init__(self, folder: Path, within: Callable[[str], Sequence[str]] = lambda _: ()) -> None:
        self.folder, self._within = folder, within
        self.certificates = folder / "certificates"
        certificate.write(self.certificates, certificate.VALID)
        self.environment = {"WOODCOCK_CERTIFICATES": str(self.certificates), "POCL_DEVICES": "pthread"}
        self.workers: dict[str, Part] = {}
        self.services: list[Service] = []

    def start_scheduler(self, host: str = "127.0.0.1", port: int = 0, on: str = "head") -> None:
        options = ("--host", host, "--port", str(port))
        within = self._within(on)
        self.scheduler = Part(self.folder / "scheduler", "scheduler", *options, within=within, **self.environment)
        self.environment["WOODCOCK_SCHEDULER"] = self.scheduler.said(r"tls://\S+")

    def start_worker(self, name: str, prelude: str = "", **environment: str) -> Part:
        """Its own cache; compiled programs are shared."""
        environment = {**self.environment, "WOODCOCK_CACHE": str(self.folder / name / "files"), **environment}
        within = self._within(name)
        part = Part(self.folder / name, "worker", "--name", name, prelude=prelude, within=within, **environment)
        self.workers[name] = part
        return part

    def start_service(self, name: str = "service", on: str = "head", prelude: str = "", **environment: str) -> Service:
        service = Service(self.folder / name, prelude, **{**self.environment, **environment})
        service.within = list(self._within(on))
        service.start()
        self.services.append(service)
        return service

    def wait_for(self, service: Service, *devices: str, seconds: float = 60) -> None:
        """Until the service has these devices, and no others."""

        def there() -> bool:
            return {each["id"] for each in service.http.get("/api/v1/devices").json()["items"]} == set(devices)

        wait_until(there, seconds, self.logs)

    def logs(self) -> str:
        return "\n".join(f"--- {log.parent.name}\n{log.read_text()[-3000:]}" for log in self.folder.glob("*/log.txt"))

    def close(self) -> None:
        for service in self.services:
            if service.process is not None:
                service.stop(signal.SIGKILL)
        for part in [*self.workers.values(), self.scheduler]:
            if part.process.poll() is None:
                part.stop(signal.SIGKILL)


def on_hosts(folder: Path, network: Network) -> Farm:
    """A farm on separate hosts; the scheduler, and whoever starts it, are on head."""
    farm = Farm(folder, network.within)
    # A cable that is pulled out is noticed within 12 s, the least that Dask takes, not half a minute.
    farm.environment["DASK_DISTRIBUTED__COMM__TIMEOUTS__TCP"] = "12s"
    farm.start_scheduler(network.addresses["head"], port=8786)
    return farm
