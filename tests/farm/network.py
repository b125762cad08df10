"""Hosts of a farm as network namespaces with addresses of their own, on a bridge in one more; the machine's own
interfaces stay as they are."""

from __future__ import annotations

import ctypes
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SUBNET = "10.213.77"
#: Of Linux; Python has `os.setns` from 3.12 on.
CLONE_NEWNET = 0x40000000


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


class Network:
    """addresses: host's name -> its address."""

    def __init__(self, *hosts: str) -> None:
        self._id = f"wk{os.getpid() % 100000}"
        self.addresses = {host: f"{SUBNET}.{number}" for number, host in enumerate(hosts, 1)}

    def within(self, host: str) -> list[str]:
        """What runs a command on a host."""
        return ["ip", "netns", "exec", self._space(host)]

    @contextmanager
    def being(self, host: str) -> Iterator[None]:
        """Whatever this thread connects to or starts, it does so on a host."""
        with Path("/proc/thread-self/ns/net").open() as before, Path("/run/netns", self._space(host)).open() as there:
            _enter(there.fileno())
            try:
                yield
            finally:
                _enter(before.fileno())

    def link(self, host: str, up: bool) -> None:
        """Plug a host's cable in, or pull it out."""
        _ip("-n", self._switch, "link", "set", host, "up" if up else "down")

    @contextmanager
    def made(self) -> Iterator[None]:
        spaces = [self._switch, *map(self._space, self.addresses)]
        try:
            for space in spaces:
                _ip("netns", "add", space)
            _ip("-n", self._switch, "link", "add", "bridge", "type", "bridge")
            _ip("-n", self._switch, "link", "set", "bridge", "up")
            for host, address in self.addresses.items():
                space = self._space(host)
                _ip("-n", self._switch, "link", "add", host, "type", "veth", "peer", "name", "eth0", "netns", space)
                _ip("-n", self._switch, "link", "set", host, "master", "bridge", "up")
                _ip("-n", space, "addr", "add", f"{address}/24", "dev", "eth0")
                for name in ("lo", "eth0"):
                    _ip("-n", space, "link", "set", name, "up")
            yield
        finally:
            for space in spaces:
                subprocess.run(["ip", "netns", "del", space], capture_output=True)

    @property
    def _switch(self) -> str:
        return f"{self._id}-switch"

    def _space(self, host: str) -> str:
        return f"{self._id}-{host}"


def _enter(space: int) -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.setns(space, CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), "setns")


def fault() -> str | None:
    """Why hosts cannot be made here; None if they can."""
    try:
        with Network("trial").made():
            pass
    except FileNotFoundError:
        return "there is no `ip`: apt install iproute2"
    except subprocess.CalledProcessError as error:
        return f"network namespaces cannot be made: {error.stderr.strip()}"
    return None
