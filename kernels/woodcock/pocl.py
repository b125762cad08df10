"""PoCL on processors that its LLVM does not know: it names them `generic`, a name that its compiler does not take for
x86, and can build nothing. No option or variable changes that, so the name is put right where PoCL keeps it.
"""

from __future__ import annotations

import ctypes
import platform
from functools import cache
from pathlib import Path
from typing import Any

UNKNOWN = "generic"
#: The least that each of PoCL's libraries of builtins was built for, best first, and what a processor needs for it.
PROCESSORS = (
    ("skylake-avx512", {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}),
    ("haswell", {"avx2", "fma", "bmi1", "bmi2", "f16c"}),
    ("x86-64", set[str]()),
)
#: Bytes of PoCL's record of a device in which the name is looked for; the next device's begins after some 3000.
RECORD = 2048

#: The names, which PoCL reads as long as the process lives.
_kept: dict[str, Any] = {}


def correct_processor(device: Any) -> str | None:
    """Name the processor of a device (pyopencl's) that PoCL does not know; returns the name, None where nothing was to
    be done or could be."""
    if not device.version.strip().endswith(f"-{UNKNOWN}") or platform.machine() != "x86_64":
        return None
    field = _field_of(device.int_ptr, UNKNOWN.encode())
    if field is None:
        return None
    name = _processor()
    text = _kept.setdefault(name, ctypes.create_string_buffer(name.encode()))
    ctypes.c_void_p.from_address(field).value = ctypes.addressof(text)
    return name


@cache
def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    flags = next((set(line.split()) for line in lines if line.startswith("flags")), set[str]())
    return next(name for name, needed in PROCESSORS if needed <= flags)


def _field_of(record: int, text: bytes) -> int | None:
    """The address of the pointer in a record that leads to a C string. What is no pointer is found out by reading
    through the kernel, which answers with an error where a direct look would end the process."""
    wanted, size = text + b"\0", ctypes.sizeof(ctypes.c_void_p)
    with Path("/proc/self/mem").open("rb", buffering=0) as memory:

        def read(address: int, count: int) -> bytes:
            try:
                memory.seek(address)
                return memory.read(count)
            except (OSError, OverflowError):
                return b""

        block = read(record, RECORD)
        for offset in range(0, len(block) - size + 1, size):
            pointer = int.from_bytes(block[offset : offset + size], "little")
            if 0 < pointer < 1 << 62 and read(pointer, len(wanted)) == wanted:
                return record + offset
    return None
