"""Which programs a device has compiled before: no driver tells what is in its cache, so that is noted beside it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from woodcock.device import Device, cache_folder
from woodcock.launch import work_items
from woodcock.program import Program

#: PoCL compiles a program once more for launches of so many work items.
WIDE = 1 << 16


def is_wide(pixels: int, lanes: int) -> bool:
    """Is a launch over so many pixels one for which a program is compiled once more?"""
    return work_items(pixels, lanes) >= WIDE


def is_built(device: Device, program: Program, pixels: int = 1) -> bool:
    """Would the program start at once in a picture of so many pixels? Where the driver's cache was emptied since, it is
    merely slower.
    """
    return _marker(device, program, pixels).exists()


def built(device: Device, program: Program, pixels: int = 1) -> None:
    """Note that the program was compiled for a picture of so many pixels, its first launch included."""
    marker = _marker(device, program, pixels)
    if not marker.exists():
        marker.parent.mkdir(exist_ok=True)
        marker.touch()


def _marker(device: Device, program: Program, pixels: int) -> Path:
    key = f"{program.hash}|{device.identity}|{is_wide(pixels, program.lanes)}"
    return cache_folder() / "programs" / hashlib.sha256(key.encode()).hexdigest()[:32]
