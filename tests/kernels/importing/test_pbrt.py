"""pbrt scenes: what becomes what, to the letter."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import DEPTH, filled, read

from woodcock.formats.mesh import read_mesh

SPHERE = 'Shape "sphere"'
GREY = {"kind": "diffuse", "reflectance": 0.5}
SQUARE = '"point3 P" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]'
TRIANGLE = '"point3 P" [0 0 0  1 0 0  0 1 0]'
#: A closed box from -1 to 1
BOX = (
    '"point3 P" [-1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1  -1 -1 1  1 -1 1  -1 1 1  1 1 1] '
    '"integer indices" [0 2 3 0 3 1 4 5 7 4 7 6 0 1 5 0 5 4 2 6 7 2 7 3 0 4 6 0 6 2 1 3 7 1 7 5]'
)


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
        ('"string type" "homogeneous" "spectrum sigma_a" [300 2 800 2] "float scale" 3',
         {"sigma_t": 9, "albedo": 1 / 3}),
        ('"string type" "homogeneous" "rgb sigma_s" [0 0 0] "rgb Le" [1 2 3] "float Lescale" 2',
         {"sigma_t": 1, "albedo": 0, "emission": {"kind": "constant", "epsilon": [2, 4, 6]}}),
    ],
)  # fmt: skip
def test_homogeneous(imported: Import, medium: str, expected: dict[str, Any]) -> None:
    scene, notes = read(imported, filled(medium))
    assert notes == []
    volume = scene["volumes"][0]
    assert (volume["sigma_t"], volume["albedo"]) == pytest.approx((expected["sigma_t"], expected["albedo"]))
    assert volume.get("emission") == expected.get("emission")


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
    assert np.array([red, green, blue]) / green == pytest.approx([1.2632, 1, 0.7939], rel=0.01)
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
    assert np.array([red, green, blue]) / 2 == pytest.approx([1.8451, 0.8261, 0.2333], abs=0.03)


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
