"""What a program holds, and what a scene did without."""

from __future__ import annotations

import json
from typing import Any

import pytest

from woodcock.device import Device
from woodcock.leanness import REGISTERS, Contents, by_file
from woodcock.program import ROOT, flatten
from woodcock.render import Renderer
from woodcock.scene import parse

CAMERA = {"kind": "perspective", "origin": [0, 0, 5], "target": [0, 0, 0]}
BOX = {
    "kind": "constant",
    "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
    "sigma_t": 1,
    "albedo": 0,
}
FOG = {
    "camera": CAMERA,
    "film": {"width": 8, "height": 8},
    "volumes": [BOX],
    "lights": [{"kind": "constant", "radiance": 1}],
}


def contents_of(device: Device, scene: dict[str, Any]) -> Contents:
    return Renderer(parse(json.dumps(scene)), device, lanes=1).facts()["program"]


def test_every_line_of_code_is_counted_once_under_its_file() -> None:
    (folder := ROOT / "core").is_dir()
    text = flatten(["core/box.h", "int generated;\n\n// why\nint twice;\n", "core/angle.h"])
    found = by_file(text)
    code = [
        line
        for file in found
        if file != "generated"
        for line in (folder.parent / file).read_text().splitlines()
        if line.strip() and not line.strip().startswith(("//", "#include"))
    ]
    assert found["generated"] == 2
    assert {"core/box.h", "core/angle.h", "core/vector.h"} <= found.keys()
    assert sum(found.values()) == len(code) + 2


def test_what_a_scene_uses_remains_and_all_else_is_left_out(device: Device) -> None:
    held = contents_of(device, FOG | {"volumes": [BOX | {"albedo": 0.5}]})
    every = {path.relative_to(ROOT).as_posix() for path in (*ROOT.rglob("*.h"), *ROOT.rglob("*.cl"))}
    assert {"phase/isotropic.h", "light/constant.h", "tracking/analytic.h", "generated"} <= held["remained"].keys()
    assert {"phase/draine.h", "surface/mesh.h", "light/spot.h", "tracking/delta.h"} <= held["left_out"].keys()
    assert not held["remained"].keys() & held["left_out"].keys()
    named = held["remained"].keys() | held["left_out"].keys()
    assert {name for name in every - named if not name.startswith(("core/lanes_", "core/precision_"))} == set()
    assert held["source_lines"] == sum(held["remained"].values()) > 200
    assert held["bytes"] > 10_000
    assert held["binary_bytes"] or "Portable Computing Language" in device.platform


def test_absorption_alone_leaves_out_random_numbers_scattering_and_light_sampling(device: Device) -> None:
    left_out = contents_of(device, FOG)["left_out"]
    assert {"phase/isotropic.h", "integrator/volumetric_path.cl", "integrator/full/next_event.h"} <= left_out.keys()


LOG = """ptxas info    : Compiling entry function 'render' for 'sm_90'
ptxas info    : Used 96 registers, 400 bytes cmem[0]"""


@pytest.mark.parametrize(("log", "registers"), [(LOG, ["96"]), ("", [])], ids=["told", "silent"])
def test_registers_are_read_from_the_compilers_log(log: str, registers: list[str]) -> None:
    assert REGISTERS.findall(log) == registers
