"""pbrt scenes: what becomes what, to the letter; and that nothing is dropped in silence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import DEPTH, pbrt

from woodcock.formats.mesh import read_mesh
from woodcock.importing import Report, SourceError, convert

SPHERE = 'Shape "sphere"'
GREY = {"kind": "diffuse", "reflectance": 0.5}
SQUARE = '"point3 P" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]'
TRIANGLE = '"point3 P" [0 0 0  1 0 0  0 1 0]'
#: A closed box from -1 to 1
BOX = (
    '"point3 P" [-1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1  -1 -1 1  1 -1 1  -1 1 1  1 1 1] '
    '"integer indices" [0 2 3 0 3 1 4 5 7 4 7 6 0 1 5 0 5 4 2 6 7 2 7 3 0 4 6 0 6 2 1 3 7 1 7 5]'
)


def read(imported: Import, body: str, options: str = 'Camera "perspective"') -> tuple[dict[str, Any], list[str]]:
    """The scene, and what it loses beside the length of paths."""
    scene, notes = imported(pbrt(body, options), "scene.pbrt")
    assert notes[0] == DEPTH
    return scene, notes[1:]


def filled(medium: str, shape: str = SPHERE) -> str:
    return f'MakeNamedMedium "m" {medium}\nMaterial "interface" MediumInterface "m" "" {shape}'


def test_a_whole_scene(imported: Import) -> None:
    scene, notes = read(
        imported,
        """MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [1 2 3] "rgb sigma_s" [1 1 1] "float g" .5
AttributeBegin  # a ball of fog
  Translate 1 0 0
  Material "interface"
  MediumInterface "fog" ""
  Shape "sphere" "float radius" 2
AttributeEnd
LightSource "distant" "point3 from" [0 1 0] "point3 to" [0 0 0] "rgb L" [1 2 3] "float scale" 2
Shape "disk" "float radius" 10
""",
        """Film "rgb" "integer xresolution" 200 "integer yresolution" [ 100 ] "string filename" "x.exr"
Sampler "halton" "integer pixelsamples" 32 "integer seed" 7
LookAt 0 1 -5  0 1 0  0 1 0
Camera "perspective" "float fov" 30""",
    )
    assert notes == []
    assert scene == {
        "camera": {"kind": "perspective", "origin": [0, 1, -5], "target": [0, 1, -4], "up": [0, 1, 0], "fov": 30},
        "volumes": [
            {
                "kind": "constant",
                "shape": {"kind": "sphere", "center": [-1, 0, 0], "radius": 2},
                "sigma_t": [2, 3, 4],
                "albedo": [0.5, 0.333333333333, 0.25],
                "phase": {"kind": "henyey_greenstein", "g": 0.5},
            }
        ],
        "surfaces": [{"kind": "disk", "center": [0, 0, 0], "normal": [0, 0, 1], "radius": 10, "material": GREY}],
        "lights": [{"kind": "directional", "direction": [0, -1, 0], "irradiance": [2, 4, 6]}],
        "film": {"width": 200, "height": 100, "filter": {"kind": "box", "radius": 0.5}},
        "seed": 7,
        "stop": {"kind": "samples", "samples": 32},
        "integrator": {"kind": "volumetric_path"},
    }


def test_what_pbrt_takes_where_nothing_is_said(imported: Import) -> None:
    scene, notes = imported("WorldBegin " + SPHERE, "scene.pbrt")
    assert [note.split(": ", 1)[1] for note in notes] == [
        "the gaussian filter ends at 2 pixels, not at 1.5",
        DEPTH.split(": ", 1)[1],
    ]
    assert scene["camera"] == {
        "kind": "perspective", "origin": [0, 0, 0], "target": [0, 0, 1], "up": [0, 1, 0], "fov": 90
    }  # fmt: skip
    assert scene["film"] == {"width": 1280, "height": 720, "filter": {"kind": "gaussian", "deviation": 0.5}}
    assert scene["stop"] == {"kind": "samples", "samples": 16}


@pytest.mark.parametrize(
    ("medium", "expected"),
    [
        ('"string type" "homogeneous"', {"sigma_t": 2, "albedo": 0.5}),
        ('"string type" "homogeneous" "spectrum sigma_a" [300 2 800 2] "float scale" 3', {"sigma_t": 9, "albedo": 1 / 3}),
        ('"string type" "homogeneous" "rgb sigma_s" [0 0 0] "rgb Le" [1 2 3] "float Lescale" 2',
         {"sigma_t": 1, "albedo": 0, "emission": {"kind": "constant", "epsilon": [2, 4, 6]}}),
    ],
)  # fmt: skip
def test_homogeneous(imported: Import, medium: str, expected: dict[str, Any]) -> None:
    scene, notes = read(imported, filled(medium))
    assert notes == []
    volume = scene["volumes"][0]
    assert {key: volume.get(key) for key in expected} == pytest.approx(expected) or volume["emission"] == expected[
        "emission"
    ]


def test_a_uniform_grid(imported: Import, tmp_path: Path) -> None:
    density = np.zeros((4, 3, 5))
    density[1:-1, 1:-1, 1:-1] = np.arange(6).reshape(2, 1, 3)
    numbers = " ".join(map(str, density.ravel()))
    box = '"integer nx" 5 "integer ny" 3 "integer nz" 4 "point3 p0" [-1 -1 -1] "point3 p1" [1 1 1]'
    glow = '"rgb Le" [1 2 3] "spectrum sigma_a" [300 .5 800 .5]'
    scene, notes = read(
        imported,
        filled(f'"string type" "uniformgrid" "float density" [{numbers}] {box} {glow}', f'Shape "trianglemesh" {BOX}'),
    )
    assert notes == []
    assert scene["volumes"] == [
        {
            "kind": "grid",
            "file": "out.m.npy",
            "scale": 1.5,
            "albedo": 0.666666666667,
            "phase": {"kind": "isotropic"},
            "emission": {"kind": "grid", "file": "out.m.npy", "scale": [0.5, 1, 1.5]},
            # Mirrored, as all of the world
            "to_world": [[-2, 0, 0, 1], [0, 2, 0, -1], [0, 0, 2, -1], [0, 0, 0, 1]],
        }
    ]
    np.testing.assert_array_equal(np.load(tmp_path / "out.m.npy"), density)


def test_a_grid_that_glows_by_its_temperature(imported: Import, tmp_path: Path) -> None:
    grid = '"float density" [2] "float temperature" [5000] "rgb sigma_s" [0 0 0]'
    scene, notes = read(imported, filled(f'"string type" "uniformgrid" {grid}', 'Shape "sphere" "float radius" 3'))
    emission = scene["volumes"][0]["emission"]
    assert emission == {"kind": "grid", "file": "out.m-emission.npy", "scale": 1}
    red, green, blue = np.load(tmp_path / emission["file"])[0, 0, 0]
    # Planck's law at 5000 K: x = .3451, y = .3516 (CIE 15); the peak is 1, near the middle of the visible
    assert 0.2126 * red + 0.7152 * green + 0.0722 * blue == pytest.approx(2 * 106.857, rel=0.02)
    assert np.array([red, green, blue]) / green == pytest.approx([1.2541, 1, 0.7911], rel=0.01)
    assert len(notes) == 2  # of the grid's faces, and of what is interpolated


def test_an_rgb_grid(imported: Import, tmp_path: Path) -> None:
    grid = '"rgb sigma_a" [1 1 1  0 0 0] "rgb sigma_s" [1 2 3  0 0 0] "integer nx" 2 "rgb Le" [1 1 1  1 1 1]'
    scene, notes = read(imported, filled(f'"string type" "rgbgrid" {grid}', 'Shape "sphere" "float radius" 3'))
    volume = scene["volumes"][0]
    assert volume["albedo"] == pytest.approx([0.5, 2 / 3, 0.75], rel=1e-6)
    np.testing.assert_array_equal(np.load(tmp_path / "out.m.npy")[0, 0], [[2, 3, 4], [0, 0, 0]])
    assert volume["emission"] == {"kind": "grid", "file": "out.m-emission.npy", "scale": 106.856895}
    np.testing.assert_array_equal(np.load(tmp_path / "out.m-emission.npy"), [[[1, 0]]])
    assert len(notes) == 2
    varied = '"rgb sigma_a" [1 1 1  0 0 0] "rgb sigma_s" [1 2 3  1 1 1] "integer nx" 2'
    scene, notes = read(imported, filled(f'"string type" "rgbgrid" {varied}', 'Shape "sphere" "float radius" 3'))
    assert scene["volumes"][0]["albedo_grid"] == {"file": "out.m-albedo.npy"}
    assert notes[-1] == "scene.pbrt:2: between voxels albedo and sigma_t are interpolated, not sigma_s"


def test_nanovdb_is_referred_to(imported: Import) -> None:
    scene, notes = read(imported, filled('"string type" "nanovdb" "string filename" "a.nvdb" "float scale" 4'))
    assert scene["volumes"][0] == {
        "kind": "grid",
        "file": "a.nvdb",
        "grid": "density",
        "scale": 8,
        "albedo": 0.5,
        "phase": {"kind": "isotropic"},
        "to_world": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    }
    assert [note.split(":")[2].strip() for note in notes] == [
        'the file "a.nvdb" is not there; the scene refers to it all the same',
        "the grids are not checked, and nothing glows",
        "not checked that the shape holds all of the grid of its medium, which is not cut",
    ]


@pytest.mark.parametrize(
    ("material", "expected"),
    [
        ("", GREY),
        ('Material "diffuse" "rgb reflectance" [.1 .2 .3]', {"kind": "diffuse", "reflectance": [0.1, 0.2, 0.3]}),
        ('Texture "t" "spectrum" "constant" "rgb value" [.1 .2 .3] Material "diffuse" "texture reflectance" "t"',
         {"kind": "diffuse", "reflectance": [0.1, 0.2, 0.3]}),
        ('MakeNamedMaterial "a" "string type" "dielectric" "float eta" 1.3 NamedMaterial "a"',
         {"kind": "dielectric", "ior": 1.3}),
        ('Material "dielectric" "float roughness" .25', {"kind": "rough_dielectric", "ior": 1.5, "roughness": 0.5}),
        ('Material "dielectric" "float roughness" .25 "bool remaproughness" false',
         {"kind": "rough_dielectric", "ior": 1.5, "roughness": 0.25}),
        ('ReverseOrientation Material "dielectric" "float eta" 2', {"kind": "dielectric", "ior": 0.5}),
        ('Scale 1 1 -1 Material "dielectric" "float eta" 2', {"kind": "dielectric", "ior": 0.5}),
        ('AttributeBegin Material "dielectric" AttributeEnd', GREY),
        ('Attribute "material" "rgb reflectance" [1 0 0] Material "diffuse"',
         {"kind": "diffuse", "reflectance": [1, 0, 0]}),
    ],
)  # fmt: skip
def test_materials(imported: Import, material: str, expected: dict[str, Any]) -> None:
    scene, notes = read(imported, f"{material} {SPHERE}")
    assert notes == []
    assert scene["surfaces"][0]["material"] == expected


@pytest.mark.parametrize(
    ("light", "expected"),
    [
        ('LightSource "infinite"', {"kind": "constant", "radiance": 1}),
        ('LightSource "infinite" "float illuminance" 3.141592653589793', {"kind": "constant", "radiance": 1}),
        ('Attribute "light" "rgb L" [1 2 3] LightSource "infinite"', {"kind": "constant", "radiance": [1, 2, 3]}),
        ('Translate 1 2 3 LightSource "point" "float power" 12.566370614359172',
         {"kind": "point", "position": [-1, 2, 3], "intensity": 1}),
        ('LightSource "spot" "point3 from" [1 2 3] "point3 to" [1 0 3] "rgb I" [1 2 3] "float scale" 2',
         {"kind": "spot", "position": [-1, 2, 3], "target": [-1, 0, 3], "intensity": [2, 4, 6],
          "cutoff": 30, "beam": 25}),
    ],
)  # fmt: skip
def test_lights(imported: Import, light: str, expected: dict[str, Any]) -> None:
    scene, notes = read(imported, f"{SPHERE} {light}")
    assert notes == []
    assert scene["lights"] == [expected]


def test_a_blackbody_has_a_luminance_of_one(imported: Import) -> None:
    scene, _ = read(imported, f'{SPHERE} LightSource "infinite" "blackbody L" 2856 "float scale" 2')
    red, green, blue = scene["lights"][0]["radiance"]
    assert 0.2126 * red + 0.7152 * green + 0.0722 * blue == pytest.approx(2, rel=1e-3)
    # Illuminant A: x = .44757, y = .40745 (CIE 15)
    assert np.array([red, green, blue]) / 2 == pytest.approx([1.8246, 0.8548, 0.2198], abs=0.02)


def test_area_lights_face_as_in_pbrt(imported: Import) -> None:
    """A parallelogram is a rectangle, with cross(p10 - p00, p01 - p00) as its normal, mirrored with the world."""
    light = 'AreaLightSource "diffuse" "rgb L" [1 2 3] "float scale" 2'
    found = []
    for before in ("", "ReverseOrientation", "Scale 1 1 -1", "Scale -1 1 1"):
        scene, notes = read(imported, f'{light} {before} Shape "bilinearmesh" {SQUARE}')
        assert notes == ["scene.pbrt:2: reflects nothing here, because it shines"]
        assert scene["surfaces"][0]["material"] == {"kind": "emissive", "radiance": [2, 4, 6]}
        found.append(np.array(scene["surfaces"][0].get("to_world", np.eye(4)))[:3, 2].tolist())
    assert found == [[0, 0, 1], [0, 0, -1], [0, 0, -1], [0, 0, 1]]


def test_triangles_keep_their_outside(imported: Import, tmp_path: Path) -> None:
    """pbrt's triangles face cross(p1 - p0, p2 - p0), wherever their placement mirrors, reversed or not."""
    found = []
    for before in ("", "ReverseOrientation", "Scale -1 1 1", "Translate 0 0 5"):
        scene, _ = read(imported, f'{before} Shape "trianglemesh" {TRIANGLE}')
        mesh = read_mesh(tmp_path / scene["surfaces"][0]["file"])
        a, b, c = mesh.vertices[mesh.faces[0]]
        found.append(float(np.cross(b - a, c - a)[2]))
        assert mesh.vertices[:, 2] == pytest.approx(5 if "Translate" in before else 0)
    assert found == [1, -1, 1, 1]


def test_objects_are_placed_again(imported: Import) -> None:
    scene, notes = read(
        imported,
        'ObjectBegin "o" Translate 1 0 0 Shape "sphere" ObjectEnd\nScale 2 2 2 ObjectInstance "o"\n'
        'Translate 0 1 0 ObjectInstance "o"',
    )
    assert notes == []
    assert [(surface["center"], surface["radius"]) for surface in scene["surfaces"]] == [
        ([-2, 0, 0], 2),
        ([-2, 2, 0], 2),
    ]


def test_transforms_follow_each_other(imported: Import) -> None:
    steps = {
        "Translate 1 2 3 Scale 2 2 2": [-1, 2, 3],
        'CoordinateSystem "here" Translate 9 9 9 CoordSysTransform "here" Translate 1 0 0': [-1, 0, 0],
        "Rotate 90 0 0 1 Translate 1 0 0": [0, 1, 0],
        "Transform [1 0 0 0  0 1 0 0  0 0 1 0  4 5 6 1]": [-4, 5, 6],
        "Translate 1 0 0 ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  4 5 6 1]": [-5, 5, 6],
        "Translate 1 0 0 Identity": [0, 0, 0],
        "TransformBegin Translate 1 0 0 TransformEnd": [0, 0, 0],
        "LookAt 0 0 0  0 0 1  0 1 0 Translate 1 2 3": [-1, 2, 3],
    }
    for text, center in steps.items():
        scene, _ = read(imported, f"{text} {SPHERE}")
        assert scene["surfaces"][0]["center"] == pytest.approx(center), text


def test_includes(imported: Import, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "a.pbrt").write_text('Translate 1 0 0\nShape "plymesh" "string filename" "b.ply"\n')
    scene, notes = read(imported, f'Include "parts/a.pbrt"\n{SPHERE} Identity Import "parts/a.pbrt" {SPHERE}')
    first, ball, _, second = scene["surfaces"]
    assert first["file"] == "parts/b.ply"
    assert (ball["center"], second["center"]) == ([-1, 0, 0], [0, 0, 0])
    assert notes == [f'{tmp_path}/parts/a.pbrt:2: the file "b.ply" is not there; the scene refers to it all the same']


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('Shape "curve"', ['left out: the shape "curve"; sphere, disk, trianglemesh, bilinearmesh and plymesh are known']),
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
        ('MakeNamedMedium "c" "string type" "homogeneous" "string preset" "Skin1" MediumInterface "c" "" Shape "sphere"',
         ['the preset "Skin1" is not carried over']),
        ('MakeNamedMedium "c" "string type" "homogeneous" MediumInterface "c" "" Shape "trianglemesh" ' + TRIANGLE,
         ["the medium inside is left out: the shape is not closed"]),
        ('MakeNamedMedium "a" "string type" "homogeneous" Material "interface" MediumInterface "a" "b" Shape "sphere"',
         ["the medium outside goes on inside this shape: where media overlap, they add"]),
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
        ('PixelFilter "mitchell"', 'the filter "mitchell" is not carried over; a gaussian of deviation 0.5 stands for it'),
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
