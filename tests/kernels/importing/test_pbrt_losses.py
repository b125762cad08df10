"""pbrt scenes: nothing is dropped in silence, and what cannot be read says why."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import filled, pbrt, read

from woodcock.importing import Report, SourceError, convert

SPHERE = 'Shape "sphere"'
TRIANGLE = '"point3 P" [0 0 0  1 0 0  0 1 0]'


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('Shape "curve"',
         ['left out: the shape "curve"; sphere, disk, trianglemesh, bilinearmesh and plymesh are known']),
        ('Shape "sphere" "float zmax" .5', ["zmax is not carried over: the sphere is whole"]),
        ('Shape "sphere" "float alpha" .5', ['"alpha" of Shape "sphere" is not carried over']),
        ('Scale 1 2 1 Shape "sphere"', ["left out: a sphere that is scaled to an ellipsoid"]),
        ('Material "interface" Shape "sphere"', ["left out: a boundary that lets everything pass and holds no medium"]),
        ('Material "coateddiffuse" Shape "sphere"',
         ['the material "coateddiffuse" is not carried over; a diffuse surface stands for it']),
        ('Material "dielectric" "spectrum eta" "glass-BK7" Shape "sphere"',
         ['"glass-BK7" has one refractive index here, no dispersion']),
        ('Texture "t" "spectrum" "imagemap" Material "diffuse" "texture reflectance" "t" Shape "sphere"',
         ['the texture "t" is not carried over; "reflectance" keeps its default']),
        ('MakeNamedMedium "c" "string type" "cloud" MediumInterface "c" "" Shape "sphere"',
         ['left out: the medium "cloud"; homogeneous, uniformgrid, rgbgrid and nanovdb are known']),
        ('MakeNamedMedium "c" "string type" "homogeneous" "string preset" "Skin1" '
         'MediumInterface "c" "" Shape "sphere"',
         ['the preset "Skin1" is not carried over']),
        ('MakeNamedMedium "c" "string type" "homogeneous" MediumInterface "c" "" Shape "trianglemesh" ' + TRIANGLE,
         ["the medium inside is left out: the shape is not closed"]),
        ('MakeNamedMedium "a" "string type" "homogeneous" Material "interface" MediumInterface "a" "b" Shape "sphere"',
         ["the medium outside goes on inside this shape: where media overlap, they add"]),
        ('Material "diffuse" "texture displacement" "t" Shape "sphere"',
         ['"displacement" of Material "diffuse" is not carried over']),
        ('Material "diffuse" "texture displacement" "t" Material "diffuse" Shape "sphere"', []),
        ('ObjectBegin "o" Shape "sphere" "float alpha" .5 ObjectEnd', []),
        ('ObjectBegin "o" AreaLightSource "diffuse" Shape "sphere" ObjectEnd ObjectInstance "o"',
         ["an object that is placed again does not shine"]),
        ('Attribute "light" "rgb L" [1 2 3] AreaLightSource "diffuse" Shape "sphere"',
         ["reflects nothing here, because it shines"]),
        ('LightSource "goniometric"', ['left out: the light "goniometric"']),
        ('LightSource "infinite" "spectrum L" "metal-Au-eta"', ['the spectrum "metal-Au-eta" is not carried over']),
        ('LightSource "infinite" "string filename" "no.exr"',
         ['the file "no.exr" is not there; the scene refers to it all the same',
          "left out: an environment without its picture"]),
        ('ColorSpace "rec2020"', ['the color space "rec2020" is not carried over: colours are Rec. 709\'s']),
        ("ActiveTransform EndTime", ['ActiveTransform "EndTime": nothing moves here, all transforms count']),
    ],
)  # fmt: skip
def test_what_cannot_be_carried_over_is_listed(imported: Import, body: str, expected: list[str]) -> None:
    _, notes = read(imported, f"{SPHERE}\n{body}")
    assert notes == [f"scene.pbrt:3: {what}" for what in expected]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ('Film "rgb" "float iso" 200', "the exposure is not carried over: pbrt's picture is 2 times as bright"),
        ('Film "gbuffer"', 'the film "gbuffer" is not carried over: a picture has red, green, blue'),
        ('Film "rgb" "string sensor" "canon_eos_100d"', '"sensor" of Film "rgb" is not carried over'),
        ('PixelFilter "mitchell"',
         'the filter "mitchell" is not carried over; a gaussian of deviation 0.5 stands for it'),
        ('Integrator "path"', 'the integrator "path" sees no media; volumetric_path does'),
        ('Camera "perspective" "float screenwindow" [0 1 -1 1]', "the screen window is brought to the middle"),
        ('Option "bool pixelstats" true', '"pixelstats" of Option is not carried over'),
        ('MakeNamedMedium "a" "string type" "homogeneous" MediumInterface "a" "a" Camera "perspective"',
         'the medium "a" around the camera has no bounds, and is not carried over'),
    ],
)  # fmt: skip
def test_what_options_lose_is_listed(imported: Import, options: str, expected: str) -> None:
    _, notes = imported(pbrt(f'MediumInterface "" "" {SPHERE}', options), "scene.pbrt")
    assert f"scene.pbrt:1: {expected}" in notes


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"scene\.pbrt: has no WorldBegin: it is no scene of pbrt-v4"),
        ("\0\1\2", r"scene\.pbrt: is neither Mitsuba's XML nor pbrt's text"),
        ("Hello", r'scene\.pbrt:1: "Hello" is no directive of pbrt-v4'),
        ('Camera "perspective', r"scene\.pbrt:1: a string has no end on its line"),
        ('"Camera"', r'scene\.pbrt:1: expected a directive, not the string "Camera"'),
        ("Camera perspective", r'scene\.pbrt:1: expected a string in quotes, not "perspective"'),
        ('Camera "perspective" "fov" 3', r'scene\.pbrt:1: a parameter must be "type name"'),
        ('Camera "perspective" "float fov" [3', r"scene\.pbrt:1: a list has no end"),
        ('Camera "perspective" "float fov"', r"scene\.pbrt:1: ends in the middle of a directive"),
        ("Translate 1 2", r"scene\.pbrt:1: ends in the middle of a directive"),
        ("Translate 1 2 x", r'scene\.pbrt:1: every number of Translate must be a finite number, not "x"'),
        ("Scale 0 1 1", r"scene\.pbrt:1: a transform must not be singular"),
        ("LookAt 0 0 0 0 0 0 0 1 0", r"scene\.pbrt:1: the way from origin to target must not be zero"),
        (pbrt(""), r"scene\.pbrt: holds no medium and no surface"),
        (pbrt(SPHERE, 'Camera "realistic"'), r'scene\.pbrt:1: the camera "realistic" cannot be carried over'),
        (pbrt('Camera "perspective"'), r"scene\.pbrt:2: Camera must stand before WorldBegin"),
        (SPHERE, r"scene\.pbrt:1: Shape must stand after WorldBegin"),
        (pbrt("AttributeEnd"), r"scene\.pbrt:2: AttributeEnd ends what no AttributeBegin begins"),
        (pbrt("AttributeBegin"), r"scene\.pbrt: ends before the end of what AttributeBegin begins"),
        (pbrt('ObjectInstance "o"'), r'scene\.pbrt:2: there is no object "o" here'),
        (pbrt(f'MediumInterface "m" "" {SPHERE}'), r'scene\.pbrt:2: there is no medium "m"'),
        (pbrt(f'NamedMaterial "m" {SPHERE}'), r'there is no material "m"'),
        (pbrt('Include "scene.pbrt"'), r"scene\.pbrt:2: files include each other in a circle"),
        (pbrt('Shape "sphere" "float radius" [1 2]'), r'scene\.pbrt:2: "radius" must be one value, not 2'),
        (pbrt('Shape "sphere" "string radius" "a"'), r'scene\.pbrt:2: "radius" must be of type float, not string'),
        (pbrt('Shape "trianglemesh" "point3 P" [0 0 0] "integer indices" [0 0 1]'), r"indices must be from 0 to 0"),
        (pbrt('Shape "trianglemesh" "point3 P" [0 0] '), r"must hold three numbers each, not 2 in all"),
        (pbrt(filled('"string type" "uniformgrid" "float density" [1 2] "integer nx" 3')),
         r'scene\.pbrt:2: "density" must hold 3 × 1 × 1 numbers, not 2'),
        (pbrt(filled('"string type" "homogeneous" "float g" 1')), r"scene\.pbrt:2: g must be between -1 and 1"),
    ],
)  # fmt: skip
def test_a_scene_that_cannot_be_read_says_why_in_one_sentence(tmp_path: Path, text: str, message: str) -> None:
    source = tmp_path / "scene.pbrt"
    source.write_text(text)
    with pytest.raises(SourceError, match=message) as caught:
        convert(source, tmp_path / "out.json", Report())
    assert "\n" not in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scene.pbrt"]
