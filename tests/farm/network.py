"""Hosts of a farm as network namespaces with addresses of their own, on a bridge that the test is on, too."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

SUBNET = "10.213.77"


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


class Network:
    """addresses: host's name -> its address."""

    def __init__(self, *hosts: str) -> None:
        self._id = f"wk{os.getpid() % 100000}"
        self.addresses = {host: f"{SUBNET}.{number}" for number, host in enumerate(hosts, 2)}

    def within(self, host: str) -> list[str]:
        """What runs a command on a host."""
        return ["ip", "netns", "exec", f"{self._id}-{host}"]

    def link(self, host: str, up: bool) -> None:
        """Plug a host's cable in, or pull it out."""
        _ip("link", "set", self._cable(host), "up" if up else "down")

    def _cable(self, host: str) -> str:
        return f"{self._id}v{list(self.addresses).index(host)}"

    @contextmanager
    def made(self) -> Iterator[None]:
        try:
            _ip("link", "add", self._id, "type", "bridge")
            _ip("addr", "add", f"{SUBNET}.1/24", "dev", self._id)
            _ip("link", "set", self._id, "up")
            for host, address in self.addresses.items():
                space, cable = f"{self._id}-{host}", self._cable(host)
                _ip("netns", "add", space)
                _ip("link", "add", cable, "type", "veth", "peer", "name", "eth0", "netns", space)
                _ip("link", "set", cable, "master", self._id, "up")
                _ip("-n", space, "addr", "add", f"{address}/24", "dev", "eth0")
                for name in ("lo", "eth0"):
                    _ip("-n", space, "link", "set", name, "up")
            yield
        finally:
            for host in self.addresses:
                subprocess.run(["ip", "netns", "del", f"{self._id}-{host}"], capture_output=True)
            subprocess.run(["ip", "link", "del", self._id], capture_output=True)


def fault() -> str | None:
    """Why hosts cannot be made here; None if they can."""
    try:
        _ip("netns", "add", "woodcock-trial")
        _ip("netns", "del", "woodcock-trial")
        _ip("link", "add", "wktrial", "type", "bridge")
        _ip("link", "del", "wktrial")
    except FileNotFoundError:
        return "there is no `ip`: apt install iproute2"
    except subprocess.CalledProcessError as error:
        return f"network namespaces cannot be made: {error.stderr.strip()}"
    return None
