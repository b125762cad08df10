"""Which addresses webhooks may reach, and connections to these alone.

Whoever asks for a webhook makes this server connect to a host of his choice. What a name means may change between two
questions, and a public name may mean an internal address: so a name is asked for once, and what counts is the address
that is connected to.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from ipaddress import IPv4Address, IPv4Network, IPv6Address, IPv6Network, ip_address, ip_network
from typing import TypeAlias

import httpcore2

Address: TypeAlias = IPv4Address | IPv6Address
Network: TypeAlias = IPv4Network | IPv6Network

#: The part of IPv6 that is given out for global unicast.
UNICAST = ip_network("2000::/3")
#: IPv6 addresses that mean the IPv4 address in their last four bytes, to a translator.
NAT64 = ip_network("64:ff9b::/96")
#: Networks that `ipaddress` takes for global, in some of its versions or in all.
NOT_PUBLIC = (
    ip_network("192.0.0.0/24"),  # protocol assignments, a cloud's metadata among them
    ip_network("168.63.129.16/32"),  # inside Azure: the host of the machine that asks
    ip_network("2002::/16"),  # 6to4: an IPv4 address inside
    ip_network("3fff::/20"),  # documentation
)

#: One address may take this long to connect to, before the next one is tried, seconds.
CONNECT_SECONDS = 5.0
#: Names that are asked for at the same time.
RESOLVERS = 4


def permitted(address: Address, allowed: Sequence[Network]) -> bool:
    """Is it public, or in a network that is allowed nevertheless?"""
    address = _meant(address)
    return any(address in network for network in allowed) or _public(address)


def _meant(address: Address) -> Address:
    """The IPv4 address that an IPv6 address stands for, if it stands for one."""
    if isinstance(address, IPv6Address):
        if address.ipv4_mapped is not None:
            return address.ipv4_mapped
        if address in NAT64:
            return IPv4Address(int(address) & 0xFFFFFFFF)
    return address


def _public(address: Address) -> bool:
    if address.version == 6 and address not in UNICAST:
        return False
    return address.is_global and not address.is_multicast and not any(address in network for network in NOT_PUBLIC)


class PublicNetwork(httpcore2.AsyncNetworkBackend):
    """TCP to public addresses and those of the allowed networks. Raises httpcore2.ConnectError."""

    def __init__(self, allowed: Sequence[Network]) -> None:
        self._allowed = allowed
        self._tcp = httpcore2.AnyIOBackend()
        # Of their own: names that nobody answers for must not take the threads that renders need.
        self._resolvers = ThreadPoolExecutor(RESOLVERS, "webhook-resolver")

    def close(self) -> None:
        self._resolvers.shutdown(wait=False, cancel_futures=True)

    async def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,
        local_address: str | None = None,
        socket_options: Iterable[httpcore2.SOCKET_OPTION] | None = None,
    ) -> httpcore2.AsyncNetworkStream:
        fault = f"{host} has no public address, and WOODCOCK_WEBHOOK_NETWORKS allows none that it has"
        for address in await self._resolve(host, port):
            if not permitted(address, self._allowed):
                continue
            try:
                stream = await self._tcp.connect_tcp(str(address), port, CONNECT_SECONDS)
            except (httpcore2.ConnectError, httpcore2.ConnectTimeout):
                fault = f"{host} takes no connection on port {port}"
                continue
            # Whoever is at the other end by now: before a byte is sent.
            peer, *_ = stream.get_extra_info("server_addr")
            if permitted(ip_address(peer), self._allowed):
                return stream
            await stream.aclose()
        raise httpcore2.ConnectError(fault)

    async def _resolve(self, host: str, port: int) -> list[Address]:
        """Once each, in the system's order of preference."""
        loop = asyncio.get_running_loop()
        try:
            found = await loop.run_in_executor(
                self._resolvers, lambda: socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
            )
        except (OSError, UnicodeError) as error:
            raise httpcore2.ConnectError(f"{host} cannot be resolved") from error
        return list(dict.fromkeys(ip_address(str(address[0])) for *_, address in found))
