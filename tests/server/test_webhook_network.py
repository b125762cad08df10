"""No webhook reaches what is internal, by its address, by a name, or by a name that means one and then another."""

from __future__ import annotations

import asyncio
import datetime
import socket
import ssl
from collections.abc import Callable
from ipaddress import ip_address, ip_network
from pathlib import Path
from typing import Any

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

from woodcock_server.webhooks.network import permitted
from woodcock_server.webhooks.sending import Sender, Undelivered

from .receiver import Receiver

#: Stands for a public address, as 127.0.0.1 does for an internal one: both are connected to indeed.
PUBLIC = "127.0.0.2"
NO_PUBLIC = "No answer: {} has no public address, and WOODCOCK_WEBHOOK_NETWORKS allows none that it has."

Resolver = Callable[..., list[str]]


@pytest.fixture
def resolver(monkeypatch: pytest.MonkeyPatch) -> Resolver:
    """What a name means, one time after the other; returns the names that were asked for."""

    def means(*answers: list[str]) -> list[str]:
        asked: list[str] = []

        def getaddrinfo(host: str, port: int, *_: Any, **__: Any) -> list[Any]:
            asked.append(host)
            found = answers[min(len(asked), len(answers)) - 1]
            return [(socket.AF_INET6 if ":" in each else socket.AF_INET, 1, 6, "", (each, port)) for each in found]

        monkeypatch.setattr(socket, "getaddrinfo", getaddrinfo)
        return asked

    return means


def post(url: str, *allowed: str, times: int = 1) -> list[int | str]:
    """What comes of so many attempts: a status, or why not."""

    async def run() -> list[int | str]:
        sender = Sender([ip_network(each) for each in allowed], 5.0)
        outcomes: list[int | str] = []
        for _ in range(times):
            try:
                outcomes.append(await sender.post(url, {}, b"{}"))
            except Undelivered as error:
                outcomes.append(str(error))
        sender.close()
        return outcomes

    return asyncio.run(run())


@pytest.mark.parametrize(
    "address",
    ["0.0.0.0", "10.0.0.1", "100.64.0.1", "100.100.100.200", "127.0.0.1", "127.255.255.255", "168.63.129.16",
     "169.254.169.254", "172.16.0.1", "172.31.255.255", "192.0.0.192", "192.0.2.1", "192.168.1.1", "198.18.0.1",
     "198.51.100.1", "203.0.113.1", "224.0.0.1", "239.255.255.255", "240.0.0.1", "255.255.255.255", "::", "::1",
     "::7f00:1", "::ffff:127.0.0.1", "::ffff:169.254.169.254", "::ffff:10.0.0.1", "64:ff9b::7f00:1",
     "64:ff9b::a9fe:a9fe", "64:ff9b:1::1", "100::1", "2001::1", "2001:db8::1", "2002:7f00:1::", "3fff::1", "5f00::1",
     "fc00::1", "fd00:ec2::254", "fe80::1", "fe80::1%eth0", "fec0::1", "ff02::1", "ff0e::1"],
)  # fmt: skip
def test_what_is_internal(address: str) -> None:
    assert not permitted(ip_address(address), ())


@pytest.mark.parametrize(
    "address",
    ["1.1.1.1", "172.15.0.1", "172.32.0.1", "193.0.0.1", "2606:4700::1111", "::ffff:1.1.1.1", "64:ff9b::101:101"],
)
def test_what_is_public(address: str) -> None:
    assert permitted(ip_address(address), ())


def test_internal_networks_that_are_allowed() -> None:
    allowed = [ip_network("10.1.0.0/16"), ip_network("fd00::/8")]
    for address in ("10.1.2.3", "::ffff:10.1.2.3", "fd00::1"):
        assert permitted(ip_address(address), allowed)
    for address in ("10.2.0.1", "127.0.0.1", "fc00::1", "fe80::1"):
        assert not permitted(ip_address(address), allowed)


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "[::ffff:127.0.0.1]", "127.1", "2130706433", "0.0.0.0"])
def test_what_is_internal_is_not_connected_to(host: str) -> None:
    with Receiver(host="0.0.0.0") as receiver:
        (outcome,) = post(f"http://{host}:{receiver.port}/")
    assert outcome == NO_PUBLIC.format(host.strip("[]"))
    assert receiver.connections == 0


@pytest.mark.parametrize("answers", [["127.0.0.1"], ["::1"], ["::ffff:127.0.0.1"], ["10.0.0.1", "169.254.169.254"]])
def test_a_name_that_means_what_is_internal(resolver: Resolver, answers: list[str]) -> None:
    asked = resolver(answers)
    with Receiver(host="0.0.0.0") as receiver:
        outcomes = post(f"http://receiver.test:{receiver.port}/", f"{PUBLIC}/32")
    assert outcomes == [NO_PUBLIC.format("receiver.test")]
    assert (receiver.connections, asked) == (0, ["receiver.test"])


def test_a_name_that_means_something_else_the_next_time(resolver: Resolver) -> None:
    """Rebinding: it is asked for once in an attempt, and connected to is what was looked at."""
    asked = resolver([PUBLIC], ["127.0.0.1"])
    with Receiver(host="0.0.0.0") as receiver:
        outcomes = post(f"http://receiver.test:{receiver.port}/", f"{PUBLIC}/32", times=2)
    assert outcomes == [200, NO_PUBLIC.format("receiver.test")]
    assert [heard.at for heard in receiver.heard] == [PUBLIC]
    assert (receiver.connections, len(asked)) == (1, 2)


def test_of_several_addresses_the_public_ones_are_tried(resolver: Resolver) -> None:
    resolver(["127.0.0.1", "127.0.0.3", PUBLIC])
    with Receiver(host=PUBLIC) as receiver:
        outcomes = post(f"http://receiver.test:{receiver.port}/", f"{PUBLIC}/32", "127.0.0.3/32")
    assert outcomes == [200]
    assert [heard.at for heard in receiver.heard] == [PUBLIC]


def test_a_peer_that_is_another_than_was_asked_for_gets_nothing() -> None:
    """To connect to 0.0.0.0 is to reach 127.0.0.1."""
    with Receiver() as receiver:
        (outcome,) = post(f"http://0.0.0.0:{receiver.port}/", "0.0.0.0/32")
    assert outcome == NO_PUBLIC.format("0.0.0.0")
    assert receiver.heard == []


@pytest.mark.parametrize("host", ["no.such.host.invalid", "a" * 64 + ".test", "a..test"])
def test_a_name_that_means_nothing(host: str) -> None:
    assert post(f"http://{host}/") == [f"No answer: {host} cannot be resolved."]


# TLS


def certify(folder: Path, name: str) -> ssl.SSLContext:
    """A server's context whose certificate is for this name and signed by itself, which `folder / "ca.pem"` trusts."""
    key, now = ec.generate_private_key(ec.SECP256R1()), datetime.datetime.now(datetime.UTC)
    subject = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "a test")])
    certificate = (
        x509.CertificateBuilder(subject, subject, key.public_key(), x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(hours=1))
        .not_valid_after(now + datetime.timedelta(hours=1))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName(name)]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    (folder / "ca.pem").write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    (folder / "key.pem").write_bytes(
        key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    )
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / "ca.pem", folder / "key.pem")
    return context


@pytest.mark.parametrize(("certified", "outcome"), [("receiver.test", "200"), ("other.test", "CERTIFICATE_VERIFY")])
def test_the_name_is_proven_though_an_address_is_connected_to(
    tmp_path: Path, resolver: Resolver, monkeypatch: pytest.MonkeyPatch, certified: str, outcome: str
) -> None:
    resolver(["127.0.0.1"])
    with Receiver() as receiver:
        receiver.speak_tls(certify(tmp_path, certified))
        monkeypatch.setenv("SSL_CERT_FILE", str(tmp_path / "ca.pem"))
        (got,) = post(f"https://receiver.test:{receiver.port}/", "127.0.0.0/8")
    assert outcome in str(got)
    assert len(receiver.heard) == (got == 200)
