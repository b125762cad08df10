"""Programs hold what a scene uses and nothing else; numbers never change them; structs match on every device.

`WOODCOCK_UPDATE_GOLDEN=1 pytest tests/kernels/test_program.py` writes the golden texts anew.
"""

from __future__ import annotations

import copy
import json
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.formats import Grid
from woodcock.layout import Layout
from woodcock.plan import lay_out
from woodcock.program import ROOT, compose, flatten
from woodcock.scene import parse

GOLDEN = Path(__file__).parent / "golden"
PERSPECTIVE = {"kind": "perspective", "origin": [0, 0, 5], "target": [0, 0, 0]}
ORTHOGRAPHIC = {"kind": "orthographic", "origin": [0, 0, 5], "target": [0, 0, 0], "height": 2}
FORWARD = {"kind": "henyey_greenstein", "g": 0.5}
SKY = {"kind": "constant", "radiance": 1}
SUN = {"kind": "directional", "direction": [0, -1, 0], "irradiance": [3, 2, 1]}
BOX = {"kind": "constant", "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}, "sigma_t": 1, "albedo": 0.5}
ONE_BOUND = {"majorant": {"kind": "global"}}
SCENES: dict[str, dict[str, Any]] = {
    "cloud": ONE_BOUND
    | {"camera": ORTHOGRAPHIC, "volumes": [{"kind": "grid", "file": "x", "albedo": 0.9}], "lights": [SKY]},
    "sunset": ONE_BOUND
    | {
        "camera": PERSPECTIVE,
        "volumes": [{"kind": "grid", "file": "x", "albedo": [0.9, 0.8, 0.7], "phase": FORWARD}],
        "lights": [SKY, SUN, SUN],
    },
    "fog": {"camera": PERSPECTIVE, "volumes": [BOX | {"phase": FORWARD}], "lights": [SUN | {"irradiance": 2}]},
}
scenes = pytest.mark.parametrize("name", SCENES)
#: What these scenes do not use costs them nothing: their texts never grow, whatever kinds come.
MOST_BYTES = {"cloud": 28159, "sunset": 38424, "fog": 34786}


def layout_of(scene: dict[str, Any]) -> Layout:
    grid = Grid("density", np.arange(60, dtype=np.uint8).reshape(3, 4, 5), np.eye(4), placed=False)

    def read(file: str, name: str | None) -> Grid:
        return grid

    return lay_out(parse(json.dumps(scene)), read)


@scenes
def test_golden_text(name: str) -> None:
    text = compose(layout_of(SCENES[name]), 8).text
    path = GOLDEN / f"{name}.cl"
    if os.environ.get("WOODCOCK_UPDATE_GOLDEN"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    assert text == path.read_text()
    assert len(text.encode()) <= MOST_BYTES[name]


@scenes
def test_only_files_in_use_are_in_the_text(name: str) -> None:
    layout = layout_of(SCENES[name])
    text = compose(layout, 8).text
    files = set(re.findall(r'#line \d+ "(\w+/\w+\.\w+)"', text))
    kinds = {f"{concept}/{kind}.h" for concept, kinds in layout.kinds.items() for kind in kinds}
    for path in ROOT.glob("*/*.h"):
        file = f"{path.parent.name}/{path.name}"
        if path.name.startswith("lobe_"):  # what phase functions share
            continue
        if path.parent.name in ("camera", "phase", "light", "majorant") or path.name in ("grid.h", "constant.h"):
            assert (file in files) == (file in kinds), file
    assert ("integrator/next_event.h" in files) == any(
        light["kind"] == "directional" for light in SCENES[name]["lights"]
    )
    assert ("core/spectrum_3.h" in files) == (name == "sunset")
    assert "#include" not in text
    assert "#if" not in text


@scenes
def test_numbers_upload_and_do_not_recompile(name: str) -> None:
    scene = copy.deepcopy(SCENES[name])
    scene["camera"]["origin"] = [1, 2, 7]
    scene["volumes"][0] |= {"albedo": [0.1, 0.2, 0.3] if name == "sunset" else 0.2}
    scene["lights"][0] |= {"radiance": 3} if scene["lights"][0]["kind"] == "constant" else {"irradiance": 7}
    scene["film"] = {"width": 64, "height": 640}
    scene["seed"] = 99
    before, after = layout_of(SCENES[name]), layout_of(scene)
    assert compose(before, 4).hash == compose(after, 4).hash
    assert not np.array_equal(before.pack(), after.pack())
    assert compose(before, 4).hash != compose(before, 8).hash


@scenes
def test_structs_lie_on_the_device_as_they_are_packed(context: Context, name: str) -> None:
    layout = layout_of(SCENES[name])
    offsets = layout.offsets()
    assert layout.pack().nbytes == offsets[-1]
    members = [
        f"(float)(int)((__constant char *)&s->{record.member} - (__constant char *)s)" for record in layout.records
    ]
    parts = ["core/rng.h", "core/vector.h", f"core/spectrum_{layout.channels}.h", layout.structs()]
    zeros = f"__constant uint zeros[{offsets[-1] // 4}] = {{0}};\n"
    got = evaluate(
        context,
        [*members, "(float)sizeof(struct scene)"],
        {"x": np.zeros(1, np.float32)},
        lanes=1,
        parts=[*parts, zeros],
        body="__constant const struct scene *s = (__constant const struct scene *)zeros;",
    )
    assert got[:, 0].astype(int).tolist() == offsets


@scenes
def test_only_a_contract_that_leaves_pixels_out_takes_a_list_of_them(name: str) -> None:
    relative = SCENES[name] | {"stop": {"kind": "relative_error", "relative_error": 0.01}}
    timed = SCENES[name] | {"stop": {"kind": "seconds", "seconds": 1}}
    plain, listed = (compose(layout_of(scene), 8) for scene in (SCENES[name], relative))
    assert compose(layout_of(timed), 8) == plain
    assert (plain.listed, listed.listed) == (False, True)
    assert "int *pixels" not in plain.text
    assert len(listed.text) < len(plain.text) + 100
    assert listed.text.replace(", __global const int *pixels", "").count("pixels,") == plain.text.count("pixels,") + 1


def test_flatten_marks_every_line(tmp_path: Path) -> None:
    """A compiler's complaint names the file and line that we wrote."""
    for part in flatten(["integrator/volumetric_path.cl"]).split("#line ")[1:]:
        mark, _, text = part.partition("\n")
        number, name = mark.split(" ", 1)
        lines = (ROOT / name.strip('"')).read_text().splitlines()
        for index, line in enumerate(text.splitlines()):
            source = lines[int(number) - 1 + index]
            # A file that came before leaves an empty line in place of its include.
            assert line == ("" if source.startswith("#include") else source)


def test_no_string_of_a_scene_reaches_the_compiler() -> None:
    scene = copy.deepcopy(SCENES["cloud"])
    scene["volumes"][0] |= {"file": 'evil"); system("rm', "grid": "evil"}
    assert "evil" not in compose(layout_of(scene), 1).text
