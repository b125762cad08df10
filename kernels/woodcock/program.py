"""Layout -> the text of a program made for it: only files of the kinds in use, their includes inlined with `#line`
marks (OpenCL's caches miss edits in included files), and generated calls that dispatch between them.

No string of a scene ever reaches the compiler: kinds are enumerated, numbers are uploaded.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from woodcock.layout import Layout, element

ROOT = Path(__file__).parent
OPTIONS = ("-cl-std=CL1.2",)
INCLUDE = re.compile(r'#include "(.+)"\n')


@dataclass(frozen=True)
class Program:
    """text: OpenCL C, self-contained; lanes: paths in lockstep of one work item; listed: it takes a list of pixels."""

    text: str
    lanes: int
    listed: bool = False

    @cached_property
    def hash(self) -> str:
        """sha256 of everything of ours that decides what is computed: the text and the options."""
        return hashlib.sha256("\n".join([*OPTIONS, self.text]).encode()).hexdigest()


def flatten(parts: list[str]) -> str:
    """Joins parts, each a file of this package or, where it holds a line break, generated text; a file comes once."""
    seen: set[str] = set()

    def inline(name: str) -> str:
        if name in seen:
            return ""
        seen.add(name)
        text, out, line = (ROOT / name).read_text(), [f'#line 1 "{name}"\n'], 1
        for piece in text.splitlines(keepends=True):
            line += 1
            include = INCLUDE.fullmatch(piece)
            if not include:
                out.append(piece)
            elif inlined := inline(include[1]):
                out.append(f'{inlined}#line {line} "{name}"\n')
            else:
                out.append("\n")
        return "".join(out)

    return "".join(f'#line 1 "generated"\n{part}' if "\n" in part else inline(part) for part in parts)


def compose(layout: Layout, lanes: int, *, precise: bool = False) -> Program:
    """The program of a layout for a width of lanes: 1, 4, 8 or 16; precise: of doubles."""
    parts = [
        f"core/lanes_{lanes}_double.h" if precise else f"core/lanes_{lanes}.h",
        f"core/precision_{'double' if precise else 'float'}.h",
        *("core/rng.h", "core/vector.h", f"core/spectrum_{layout.channels}.h"),
        layout.structs(precise=precise),
        *layout.before_world,
        world(layout),
        *layout.after_world,
        f"integrator/{layout.integrator}.cl",
        entry(layout),
    ]
    return Program(flatten(parts), lanes, layout.listed)


def file_of(concept: str, kind: str) -> str:
    """The file of a kind's device code."""
    if concept == "storage":
        return f"volume/grid_{kind}.h"
    return f"{'tracking' if concept in ('free_flight', 'transmittance') else concept}/{kind}.h"


def _buffers(layout: Layout) -> list[str]:
    return [f"__global const {element(array)} *{name}" for name, array in layout.buffers.items()]


def world(layout: Layout) -> str:
    members = "".join(f" {buffer};" for buffer in _buffers(layout))
    return f"struct world {{ __constant const struct scene *scene;{members} }};\n"


def entry(layout: Layout) -> str:
    arguments = [
        "__constant const struct scene *scene",
        *_buffers(layout),
        *(("__global const int *pixels",) if layout.listed else ()),
        "__global float *film",
        "__global uint *faults",
        "uint first",
        "uint samples",
    ]
    members = "".join(f", {name}" for name in layout.buffers)
    lane = "(int)get_global_id(0) * LANES + lane_index()"
    pixel = f", gather(int, pixels, {lane})" if layout.listed else f", {lane}"
    return f"""
__kernel void render({", ".join(arguments)}) {{
    const struct world world = {{scene{members}}};
    {layout.integrator}(&world, film, faults, first, samples{"" if layout.deterministic else pixel});
}}
"""
