"""Mitsuba scenes: nothing is dropped in silence, and what cannot be read says why."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import mitsuba

from woodcock.importing import Report, SourceError, convert

NOTHING = '<shape type="sphere"/>'


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('<shape type="cylinder"/>',
         ['left out: the shape "cylinder"; sphere, rectangle, disk, cube, ply and obj are known']),
        ('<shape type="sphere"><transform name="to_world"><scale x="2"/></transform></shape>',
         ["left out: a sphere that is scaled to an ellipsoid"]),
        ('<shape type="disk"><transform name="to_world"><scale x="2"/></transform></shape>',
         ["left out: a disk that is scaled to an ellipse"]),
        ('<shape type="sphere"><float name="wobble" value="1"/></shape>',
         ['<float> "wobble" of <shape type="sphere"> is not carried over']),
        ('<shape type="sphere"><bsdf type="null"/></shape>',
         ["left out: a boundary that lets everything pass and holds no medium"]),
        ('<shape type="sphere"><bsdf type="plastic"/></shape>',
         ['the bsdf "plastic" is not carried over; a diffuse surface stands for it']),
        ('<shape type="sphere"><bsdf type="conductor"><string name="material" value="Au"/></bsdf></shape>',
         ['the bsdf "conductor" is not carried over; a diffuse surface stands for it']),
        ('<shape type="sphere"><bsdf type="diffuse"><texture name="reflectance" type="bitmap">'
         '<string name="filename" value="a.png"/></texture></bsdf></shape>',
         ['the texture "bitmap" is not carried over; 0.5 stands for it']),
        ('<shape type="sphere"><bsdf type="roughdielectric"/></shape>',
         ["the microfacets are GGX's here, not Beckmann's, of the same alpha"]),
        ('<shape type="rectangle"/>', ["reflects on both sides here; from behind Mitsuba's is black"]),
        ('<shape type="rectangle"><bsdf type="null"/><medium name="interior" type="homogeneous"/></shape>',
         ["the medium inside is left out: the shape is not closed"]),
        ('<shape type="sphere"><emitter type="area"/><bsdf type="diffuse"/></shape>',
         ["reflects nothing here, because its shape shines"]),
        ('<shape type="sphere"><bsdf type="null"/><medium name="interior" type="homogeneous"/>'
         '<medium name="exterior" type="homogeneous"/></shape>',
         ["the medium outside goes on inside this shape: where media overlap, they add"]),
        ('<shape type="sphere"><bsdf type="null"/><medium name="interior" type="homogeneous">'
         '<phase type="sggx"/></medium></shape>',
         ['the phase function "sggx" is not carried over; isotropic stands for it']),
        ('<shape type="sphere"><bsdf type="null"/><medium name="interior" type="fractal"/></shape>',
         ['left out: the medium "fractal"; homogeneous and heterogeneous are known']),
        ('<emitter type="directionalarea"/>', ['left out: the emitter "directionalarea"']),
        ('<emitter type="envmap"><string name="filename" value="no.exr"/></emitter>',
         ['the file "no.exr" is not there; the scene refers to it all the same']),
        ('<shape type="sphere"><bsdf type="diffuse"><spectrum name="reflectance" value="400:1 700:0"/>'
         "</bsdf></shape>", ["the spectrum of reflectance is approximated by 0.219 0.519 0.875"]),
        ('<sensor type="thinlens"/>', ["left out: a scene has one camera, and the first sensor is taken"]),
        ('<shape type="ply"><string name="filename" value="../no.ply"/></shape>',
         ['the file "../no.ply" is not there; the scene refers to it all the same',
          'refers to a file outside the scene\'s folder: "../no.ply"',
          "reflects on both sides here; from behind Mitsuba's is black"]),
    ],
)  # fmt: skip
def test_what_cannot_be_carried_over_is_listed(imported: Import, body: str, expected: list[str]) -> None:
    _, notes = imported(mitsuba(f'{NOTHING}<shape type="cube"/>\n{body}'))
    assert [note for note in notes if not note.startswith("scene.xml:2: ")] == [
        f"scene.xml:3: {what}" for what in expected
    ]


@pytest.mark.parametrize(
    ("sensor", "expected"),
    [
        ('<float name="near_clip" value="1"/>', "near_clip is not carried over: everything before the camera is seen"),
        ('<float name="principal_point_offset_x" value=".1"/>',
         "principal_point_offset_x is not carried over: the picture's middle is the axis"),
        ('<film type="hdrfilm"><integer name="crop_width" value="3"/></film>',
         '<integer> "crop_width" of <film type="hdrfilm"> is not carried over'),
        ('<film type="hdrfilm"><rfilter type="lanczos"/></film>',
         'the filter "lanczos" is not carried over; a gaussian of deviation 0.5 stands for it'),
        ('<ref id="m"/><medium id="m" type="homogeneous"/>',
         '<ref> "m" of <sensor type="perspective"> is not carried over'),
    ],
)  # fmt: skip
def test_what_a_sensor_loses_is_listed(imported: Import, sensor: str, expected: str) -> None:
    _, notes = imported(mitsuba(NOTHING, f'<sensor type="perspective">{sensor}</sensor>'))
    assert f"scene.xml:1: {expected}" in notes


def test_layers_and_integrators(imported: Import) -> None:
    text = mitsuba(NOTHING).replace(
        '<integrator type="volpath"/>',
        '<integrator type="aov"><string name="aovs" value="dd.y:depth,nn:sh_normal,uv:uv"/>'
        '<integrator type="path"><integer name="max_depth" value="9"/></integrator></integrator>',
    )
    scene, notes = imported(text)
    assert scene["layers"] == ["depth", "normal"]
    assert notes == [
        'scene.xml:1: left out: the layer "uv:uv"',
        'scene.xml:1: the integrator "path" becomes volumetric_path',
        "scene.xml:1: max_depth is not carried over: paths have any length",
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<scene", r"scene\.xml:1: is no XML: unclosed token"),
        ("<scene><shape></scene>", r"scene\.xml:1: is no XML: mismatched tag"),
        ("<shape/>", r"scene\.xml:1: the outermost element must be <scene>, not <shape>"),
        ('<!DOCTYPE scene [<!ENTITY a "b">]><scene/>', r"scene\.xml:1: a DOCTYPE is not allowed"),
        ("<scene/>", r"scene\.xml: has no <sensor>; a scene needs a camera"),
        (mitsuba(""), r"scene\.xml: holds no medium and no surface that can be carried over"),
        (mitsuba("hello"), r'scene\.xml:\d: text between elements means nothing: "hello"'),
        (mitsuba('<ref id="a"/>'), r'scene\.xml:2: refers to "a", but nothing has this id'),
        (mitsuba('<shape id="a" type="sphere"/>\n<shape id="a" type="sphere"/>'),
         r'scene\.xml:3: the id "a" is there already, at scene\.xml:2'),
        (mitsuba('<bsdf id="a" type="twosided"><ref id="a"/></bsdf>'), r"scene\.xml:2: references run in a circle"),
        (mitsuba('<shape type="$what"/>'), r'scene\.xml:2: "\$what" has no <default name="what" value="…"/>'),
        (mitsuba('<include filename="scene.xml"/>'), r"scene\.xml:2: files include each other in a circle"),
        (mitsuba('<include filename="no.xml"/>'), r'scene\.xml:2: "no\.xml" cannot be read: No such file'),
        (mitsuba('<shape type="sphere"><float name="radius" value="big"/></shape>'),
         r'scene\.xml:2: radius must be a finite number, not "big"'),
        (mitsuba('<shape type="sphere"><string name="radius" value="1"/></shape>'),
         r'scene\.xml:2: "radius" must be <float>, not <string>'),
        (mitsuba('<shape type="sphere"><transform name="to_world"><scale value="0"/></transform></shape>'),
         r"scene\.xml:2: a transform must not be singular"),
        (mitsuba('<shape type="sphere"><transform name="to_world"><shear/></transform></shape>'),
         r"scene\.xml:2: <shear> is no transform; known are"),
        (mitsuba('<emitter type="constant"><rgb name="radiance" value="1 2"/></emitter>'),
         r"scene\.xml:2: radiance must hold one number or three, not 2"),
        (mitsuba('<shape type="ply"/>'), r'scene\.xml:2: <shape type="ply"> needs <string name="filename">'),
        (mitsuba(NOTHING, '<sensor type="radiancemeter"/>'), r'scene\.xml:1: the sensor "radiancemeter" cannot be'),
        (mitsuba(NOTHING, '<sensor type="perspective"><float name="fov" value="180"/></sensor>'),
         r"scene\.xml:1: fov must be between 0 and 180, not 180"),
        (mitsuba('<emitter type="constant"><float name="radiance" value="-1"/></emitter>' + NOTHING),
         r"scene\.xml: lights\[0\]\.radiance: must be one number or three"),
    ],
)  # fmt: skip
def test_a_scene_that_cannot_be_read_says_why_in_one_sentence(tmp_path: Path, text: str, message: str) -> None:
    source = tmp_path / "scene.xml"
    source.write_text(text)
    with pytest.raises(SourceError, match=message) as caught:
        convert(source, tmp_path / "out.json", Report())
    assert "\n" not in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scene.xml"]


def test_defaults_cannot_grow_without_bounds(tmp_path: Path) -> None:
    lines = ['<default name="a0" value="ha"/>']
    lines += [f'<default name="a{i + 1}" value="{"$a" + str(i) + " "}{"$a" + str(i)}"/>' for i in range(64)]
    (tmp_path / "scene.xml").write_text(mitsuba("\n".join(lines)))
    with pytest.raises(SourceError, match="a value is longer than"):
        convert(tmp_path / "scene.xml", tmp_path / "out.json", Report())
