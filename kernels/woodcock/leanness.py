"""What a program holds of all that the renderer knows, and what of it a scene did without."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import Any, TypedDict

from woodcock.device import Context, opencl
from woodcock.program import ROOT, Program

LINE_MARK = re.compile(r'#line \d+ "(.+)"\n')
#: What NVIDIA's compiler says of a kernel in its log (device.py asks it to).
REGISTERS = re.compile(r"Used (\d+) registers")


class Contents(TypedDict):
    """A program as text and as built. source_lines, bytes: of its text; comments and blank lines are no source lines.

    remained, left_out: lines of every file of device code that is in the text, and that is not; `generated` is what
    was written for the scene. binary_bytes: of the built program; private_bytes: memory of a work item beyond
    registers; registers: of a work item. The last three as the device tells them, None where it does not.
    """

    source_lines: int
    bytes: int
    remained: dict[str, int]
    left_out: dict[str, int]
    binary_bytes: int | None
    private_bytes: int | None
    registers: int | None


def contents(program: Program, context: Context, kernel: Any) -> Contents:
    """kernel: the program's, built on the context's device."""
    cl = opencl()
    (device,) = context.context.devices
    built = kernel.get_info(cl.kernel_info.PROGRAM)

    def told(question: Callable[[], Any]) -> Any:
        try:
            return question()
        except cl.Error:
            return None

    binaries = told(lambda: built.get_info(cl.program_info.BINARY_SIZES))
    log = told(lambda: built.get_build_info(device, cl.program_build_info.LOG)) or ""
    private = told(lambda: kernel.get_work_group_info(cl.kernel_work_group_info.PRIVATE_MEM_SIZE, device))
    remained, left_out = parts(program)
    return {
        "source_lines": sum(remained.values()),
        "bytes": len(program.text.encode()),
        "remained": remained,
        "left_out": left_out,
        "binary_bytes": int(binaries[0]) if binaries else None,
        "private_bytes": private,
        "registers": max((int(count) for count in REGISTERS.findall(log)), default=None),
    }


def parts(program: Program) -> tuple[dict[str, int], dict[str, int]]:
    """`remained` and `left_out` of a program, built or not."""
    remained = by_file(program.text)
    return remained, {file: lines for file, lines in _all_files().items() if file not in remained}


def by_file(text: str) -> dict[str, int]:
    """Lines of code in a program's text by the file they come from, sorted; blank ones and comments do not count."""
    lines: dict[str, int] = {}
    _, *pieces = LINE_MARK.split(text)
    for file, part in zip(pieces[::2], pieces[1::2], strict=True):
        lines[file] = lines.get(file, 0) + _lines_of_code(part)
    return dict(sorted(lines.items()))


def _lines_of_code(text: str) -> int:
    stripped = (line.strip() for line in text.splitlines())
    return sum(1 for line in stripped if line and not line.startswith("//") and not line.startswith("#include"))


@cache
def _all_files() -> dict[str, int]:
    """Every file of device code, but for vocabularies of other widths and precisions: a program has one of those."""
    files = sorted([*ROOT.rglob("*.h"), *ROOT.rglob("*.cl")])
    names = {file.relative_to(ROOT).as_posix(): file for file in files}
    return {
        name: _lines_of_code(file.read_text())
        for name, file in names.items()
        if not name.startswith(("core/lanes_", "core/precision_"))
    }
