"""Which devices a job asks for: all, those of a kind, or a single one."""

from __future__ import annotations

from collections.abc import Iterable

from woodcock_server.devices.service import Found

#: What a job asks for that leaves its device to the service; no device's id.
ANY = "any"
#: And what stands for all devices of a kind; an id has a number besides.
KINDS = ("cpu", "gpu", "accelerator")


def leaves_a_choice(asked: str) -> bool:
    """Of several devices, of which only those that are trusted are taken."""
    return asked == ANY or asked in KINDS


def meant(asked: str, devices: Iterable[Found]) -> list[Found]:
    """Those that a job asks for."""
    return [device for device in devices if asked in (ANY, device.device.kind, device.id)]
