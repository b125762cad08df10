"""Mitsuba's lights: what becomes what, to the letter."""

from __future__ import annotations

from typing import Any

import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import mitsuba

NOTHING = '<shape type="sphere"/>'


@pytest.mark.parametrize(
    ("emitter", "expected"),
    [
        ('<emitter type="constant"/>', {"kind": "constant", "radiance": 1}),
        # Mitsuba 3.9.1: an even spectrum is (3.61438, 2.84487, 2.72675)
        ('<emitter type="constant"><spectrum name="radiance" value="3"/></emitter>',
         {"kind": "constant", "radiance": pytest.approx([3.61438, 2.84487, 2.72675], rel=1e-4)}),
        ('<emitter type="constant"><spectrum name="radiance" type="d65"><float name="scale" value="2"/></spectrum>'
         "</emitter>", {"kind": "constant", "radiance": 2}),
        ('<emitter type="directional"><transform name="to_world"><rotate x="1" angle="90"/></transform>'
         '<rgb name="irradiance" value="1 2 3"/></emitter>',
         {"kind": "directional", "direction": [0, -1, 0], "irradiance": [1, 2, 3]}),
        ('<emitter type="point"><point name="position" value="1 2 3"/><float name="intensity" value="4"/></emitter>',
         {"kind": "point", "position": [1, 2, 3], "intensity": 4}),
        ('<emitter type="point"><transform name="to_world"><translate x="1"/></transform></emitter>',
         {"kind": "point", "position": [1, 0, 0], "intensity": 1}),
    ],
)  # fmt: skip
def test_lights(imported: Import, emitter: str, expected: dict[str, Any]) -> None:
    scene, notes = imported(mitsuba(NOTHING + emitter))
    assert notes == []
    assert scene["lights"] == [expected]


def test_spectra_are_seen_as_by_mitsuba(imported: Import) -> None:
    """Mitsuba 3.9.1 makes (2.14, 1.40424, 1.01714) of light, (.742853, .48114, .208325) of a reflectance."""
    light = '<emitter type="constant"><spectrum name="radiance" value="400:1, 700:2"/></emitter>'
    bsdf = '<bsdf type="diffuse"><spectrum name="reflectance" value="400:.1, 700:.9"/></bsdf>'
    scene, _ = imported(mitsuba(f'{light}<shape type="sphere">{bsdf}</shape>'))
    assert scene["lights"][0]["radiance"] == pytest.approx([2.14, 1.40424, 1.01714], rel=0.01)
    # Ours sees it by even light, Mitsuba's by D65
    assert scene["surfaces"][0]["material"]["reflectance"] == pytest.approx([0.742853, 0.48114, 0.208325], abs=0.03)


def test_spot(imported: Import) -> None:
    look = '<transform name="to_world"><lookat origin="0 3 0" target="0 0 0" up="0 0 1"/></transform>'
    scene, notes = imported(
        mitsuba(f'{NOTHING}<emitter type="spot"><float name="cutoff_angle" value="40"/>{look}</emitter>')
    )
    assert notes == [
        "scene.xml:2: between beam and cutoff this spot falls off smoothly in the cosine, not linearly in the angle"
    ]
    spot = {"kind": "spot", "position": [0, 3, 0], "target": [0, 2, 0], "intensity": 1, "cutoff": 40, "beam": 30}
    assert scene["lights"] == [spot]


def test_a_shape_that_shines(imported: Import) -> None:
    area = '<emitter type="area"><rgb name="radiance" value="1 2 3"/></emitter>'
    scene, notes = imported(mitsuba(f'<shape type="rectangle">{area}</shape>'))
    assert notes == []
    assert scene["surfaces"] == [{"kind": "rectangle", "material": {"kind": "emissive", "radiance": [1, 2, 3]}}]
