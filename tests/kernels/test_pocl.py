"""PoCL's record of a device whose processor it does not know, made by hand, for few machines have such a processor."""

from __future__ import annotations

import ctypes
import platform
from dataclasses import dataclass

import pytest

from woodcock import pocl
from woodcock.pocl import PROCESSORS, correct_processor

NAMES = [name for name, _ in PROCESSORS]


class Record(ctypes.Structure):
    _fields_ = (
        ("number", ctypes.c_uint64),
        ("wild", ctypes.c_void_p),  # leads nowhere
        ("vendor", ctypes.c_char_p),
        ("processor", ctypes.c_char_p),
        ("rest", ctypes.c_char * pocl.RECORD),
    )


@dataclass
class Named:
    """As pyopencl shows a device."""

    version: str
    int_ptr: int


def named(record: Record, version: str) -> Named:
    return Named(f"OpenCL 3.0 PoCL HSTR: pthread-x86_64-unknown-linux-gnu-{version}", ctypes.addressof(record))


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the names are of x86-64 processors")
def test_an_unknown_processor_gets_a_name_that_the_compiler_knows() -> None:
    record = Record(7, 0x1234_5678_9000, b"generic but longer", b"generic")
    assert correct_processor(named(record, "generic")) in NAMES
    assert record.processor.decode() in NAMES
    assert (record.number, record.vendor) == (7, b"generic but longer")


def test_a_processor_that_is_known_keeps_its_name() -> None:
    record = Record(7, 0, b"AMD", b"generic")
    assert correct_processor(named(record, "znver3")) is None
    assert record.processor == b"generic"


def test_a_record_without_the_name_is_left_alone() -> None:
    record = Record(7, 0x1234_5678_9000, b"AMD", b"znver3")
    before = bytes(record)
    assert correct_processor(named(record, "generic")) is None
    assert bytes(record) == before
