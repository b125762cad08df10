"""Cases that do what cases may do, and the child that serves them."""

from __future__ import annotations

import os
import time
from pathlib import Path

from woodcock.device import Device
from woodcock.stability.case import Case
from woodcock.stability.children import serve
from woodcock.stability.judging import Finding


def passes(device: Device, folder: Path) -> Finding:
    print("chatter of a driver")
    return Finding(1.0, 1.0, 0.0, "roundings", 4.0)


def hangs(device: Device, folder: Path) -> Finding:
    time.sleep(600)
    raise AssertionError


def aborts(device: Device, folder: Path) -> Finding:
    os.write(2, b"ld: cannot find -lgcc\n")
    os.abort()


def leaves(device: Device, folder: Path) -> Finding:
    os._exit(3)


def raises(device: Device, folder: Path) -> Finding:
    raise ValueError("a fault\nof two lines")


def lies(device: Device, folder: Path) -> Finding:
    return Finding(1.0, 2.0, 1e7, "roundings", 4.0, "failed", "the picture is off by more than 4 roundings")


CASES = tuple(
    Case("fakes", measure.__name__, measure)
    for measure in (passes, hangs, passes, aborts, leaves, passes, raises, lies, passes)
)

if __name__ == "__main__":
    serve(CASES)
