"""The loop that knows everything holds the parts that a scene uses, builds without a warning at every width, and gives
the same picture at each."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.device import Context, Device
from woodcock.formats import Grid
from woodcock.layout import Layout
from woodcock.plan import lay_out
from woodcock.program import OPTIONS, compose
from woodcock.render import Renderer
from woodcock.scene import parse

CAMERA = {"kind": "perspective", "origin": [0, 0, 5], "target": [0, 0, 0]}
GRID = {"kind": "grid", "file": "x", "albedo": 0.9}
BALL = {"kind": "constant", "shape": {"kind": "sphere", "radius": 1}, "sigma_t": 2, "albedo": 0.8}
SKY = {"kind": "constant", "radiance": 1}
POINT = {"kind": "point", "position": [0, 2, 0], "intensity": 3}
FLOOR = {"kind": "rectangle", "to_world": [[3, 0, 0, 0], [0, 0, 3, -2], [0, -3, 0, 0], [0, 0, 0, 1]]}
LAMP = {
    "kind": "disk",
    "center": [0, 3, 0],
    "normal": [0, -1, 0],
    "radius": 1,
    "material": {"kind": "emissive", "radiance": 5},
}

#: Scenes, and which of the loop's parts come in two forms they need.
SCENES: dict[str, tuple[dict[str, Any], set[str]]] = {
    "grid": (
        {"volumes": [GRID | {"interpolation": "nearest"}], "majorant": {"kind": "grid"}, "lights": [SKY]},
        {"grids", "grey"},
    ),
    "two media": ({"volumes": [GRID, BALL], "lights": [SKY]}, {"grids", "grey"}),
    "colour": ({"volumes": [BALL | {"sigma_t": [1, 2, 3]}], "lights": [SKY]}, {"spectral_mis"}),
    "fog": ({"volumes": [BALL], "lights": [POINT]}, {"grey", "next_event", "equiangular"}),
    "lamp": ({"volumes": [BALL], "surfaces": [FLOOR, LAMP]}, {"grey", "next_event", "surfaces"}),
    "layers": ({"volumes": [BALL], "lights": [SKY], "orders": 1, "layers": ["depth"]}, {"grey", "layers"}),
    "fire": (
        {"volumes": [GRID | {"emission": {"kind": "blackbody", "file": "x", "kelvin": 20}}]},
        {"grids", "grey", "emission_at_events"},
    ),
    "glow": (
        {"volumes": [GRID | {"scale": 0.01, "emission": {"kind": "constant", "epsilon": 20}}], "lights": [SKY]},
        {"grids", "grey", "emission_along"},
    ),
    "everything": (
        {
            "camera": CAMERA | {"kind": "thin_lens", "aperture_radius": 0.1},
            "volumes": [
                GRID | {"scale": [1, 2, 3], "emission": {"kind": "constant", "epsilon": 1}},
                GRID | {"interpolation": "nearest", "phase": {"kind": "rayleigh"}},
                BALL | {"phase": {"kind": "two_lobe", "g1": 0.5, "g2": -0.3, "weight": 0.5}},
            ],
            "surfaces": [FLOOR, LAMP],
            "lights": [SKY, POINT, {"kind": "sun", "direction": [0, -1, 0], "irradiance": 1}],
            "film": {"width": 16, "height": 16, "filter": {"kind": "gaussian"}},
            "majorant": {"kind": "grid", "resolution": 4},
            "orders": 2,
            "layers": ["albedo", "normal", "depth", "optical_depth", "transmittance", "position"],
        },
        {"grids", "spectral_mis", "next_event", "surfaces", "layers", "emission_at_events"},
    ),
}
FORMS = {"grids", "grey", "spectral_mis", "next_event", "equiangular", "surfaces", "layers"}
FORMS |= {"emission_along", "emission_at_events"}
scenes = pytest.mark.parametrize("name", SCENES)


def layout_of(name: str) -> Layout:
    grid = Grid("density", np.arange(60, dtype=np.uint8).reshape(3, 4, 5), np.diag([0.2, 0.25, 0.3, 1]), placed=False)
    return lay_out(parse(json.dumps({"camera": CAMERA, **SCENES[name][0]})), lambda file, grid_name: grid)


@scenes
def test_only_parts_in_use_are_in_the_text(name: str) -> None:
    text = compose(layout_of(name), 8).text
    files = set(re.findall(r'#line \d+ "integrator/full/(\w+)\.h"', text))
    assert files & FORMS == SCENES[name][1]
    assert "#include" not in text
    assert "#if" not in text


def test_everything_builds_without_a_warning(context: Context, lanes: int) -> None:
    context.build(compose(layout_of("everything"), lanes).text, (*OPTIONS, "-Werror"), "render")


def test_everything_is_the_same_at_every_width(device: Device, lanes: int, tmp_path: Path) -> None:
    np.save(tmp_path / "x.npy", np.arange(60, dtype=np.uint8).reshape(3, 4, 5))
    text = json.dumps({"camera": CAMERA, **SCENES["everything"][0]}).replace('"x"', json.dumps(str(tmp_path / "x.npy")))
    film, scalar = (Renderer(parse(text), device, lanes=width).render(0, 4) for width in (lanes, 1))
    assert film.rejected == film.violations == 0
    assert np.isfinite(film.mean).all()
    # One rounding apart may send a path another way; nearly all go the same.
    same = np.isclose(film.mean, scalar.mean, rtol=1e-3, atol=1e-4 * scalar.mean.max(axis=(0, 1))).all(axis=-1)
    assert same.mean() > 0.9
