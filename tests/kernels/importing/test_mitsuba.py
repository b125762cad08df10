"""Mitsuba scenes: what becomes what, to the letter; and that nothing is dropped in silence."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import mitsuba

from woodcock.importing import Report, SourceError, convert

NOTHING = '<shape type="sphere"/>'
GREY = {"kind": "diffuse", "reflectance": 0.5}
ISOTROPIC = {"kind": "isotropic"}
TEXTURED = (
    'the texture "bitmap" is not carried over; 0.5 stands for it',
    '<string> "filename" of <texture type="bitmap"> is not carried over',
)


def write_vol(path: Path, values: np.ndarray[Any, Any], box: tuple[float, ...] = (0, 0, 0, 1, 1, 1)) -> None:
    z, y, x = values.shape[:3]
    channels = 1 if values.ndim == 3 else values.shape[3]
    path.write_bytes(struct.pack("<3sB5i6f", b"VOL", 3, 1, x, y, z, channels, *box) + values.astype("<f4").tobytes())


def inside(medium: str, shape: str = '<shape type="sphere">') -> str:
    return mitsuba(f'{shape}<bsdf type="null"/>{medium}</shape>')


def homogeneous(body: str) -> str:
    return f'<medium name="interior" type="homogeneous">{body}</medium>'


def heterogeneous(body: str, to_world: str = "", more: str = "") -> str:
    grid = f'<string name="filename" value="a.vol"/><transform name="to_world">{to_world}</transform>{more}'
    volume = f'<volume name="sigma_t" type="gridvolume">{grid}</volume>'
    return f'<medium name="interior" type="heterogeneous">{volume}{body}</medium>'


def test_a_whole_scene(imported: Import) -> None:
    scene, notes = imported(
        """<scene version="3.0.0">
  <default name="samples" value="16"/>
  <default name="colour" value="1, 2, 3"/>
  <integrator type="volpathmis"><integer name="rr_depth" value="8"/></integrator>
  <sensor type="perspective">
    <string name="fov_axis" value="y"/> <float name="fov" value="30"/>
    <transform name="to_world"><translate x="1" z="-4"/></transform>
    <sampler type="multijitter"><integer name="sample_count" value="$samples"/></sampler>
    <film type="hdrfilm">
      <integer name="width" value="200"/> <integer name="height" value="100"/> <rfilter type="tent"/>
    </film>
  </sensor>
  <medium type="homogeneous" id="fog"> <rgb name="sigma_t" value="$colour"/> <float name="scale" value="2"/> </medium>
  <alias id="fog" as="haze"/>
  <shape type="cube"> <bsdf type="null"/> <ref name="interior" id="haze"/> </shape>
  <emitter type="directional"> <vector name="direction" x="0" y="-1" z="0"/> </emitter>
</scene>"""
    )
    assert notes == []
    assert scene == {
        "camera": {"kind": "perspective", "origin": [1, 0, -4], "target": [1, 0, -3], "up": [0, 1, 0], "fov": 30},
        "volumes": [
            {
                "kind": "constant",
                "shape": {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
                "sigma_t": [2, 4, 6],
                "albedo": 0.75,
                "phase": ISOTROPIC,
            }
        ],
        "lights": [{"kind": "directional", "direction": [0, -1, 0], "irradiance": 1}],
        "film": {"width": 200, "height": 100, "filter": {"kind": "tent", "radius": 1}},
        "seed": 0,
        "stop": {"kind": "samples", "samples": 16},
        "integrator": {"kind": "volumetric_path"},
    }


def test_what_mitsuba_takes_where_nothing_is_said(imported: Import) -> None:
    scene, notes = imported(mitsuba(NOTHING))
    assert notes == []
    assert scene["film"] == {"width": 768, "height": 576, "filter": {"kind": "gaussian", "deviation": 0.5}}
    assert scene["stop"] == {"kind": "samples", "samples": 4}
    assert scene["surfaces"] == [{"kind": "sphere", "center": [0, 0, 0], "radius": 1, "material": GREY}]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('<float name="sigma_t" value="2"/><rgb name="albedo" value=".9 .8 .7"/>', (2, [0.9, 0.8, 0.7])),
        ('<spectrum name="sigma_t" value="3"/><volume name="albedo" type="constvolume">'
         '<rgb name="value" value="0.25"/></volume>', (3, 0.25)),
        ('<rgb name="sigma_s" value="1 2 3"/><rgb name="sigma_a" value="1 1 1"/>', ([2, 3, 4], [0.5, 2 / 3, 0.75])),
        ('<spectrum name="sigma_t" type="uniform"><float name="value" value="7"/></spectrum>', (7, 0.75)),
    ],
)  # fmt: skip
def test_homogeneous(imported: Import, body: str, expected: tuple[Any, Any]) -> None:
    scene, notes = imported(inside(homogeneous(body)))
    volume = scene["volumes"][0]
    assert notes == []
    assert volume["sigma_t"] == pytest.approx(expected[0])
    assert volume["albedo"] == pytest.approx(expected[1])


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('<phase type="hg"><float name="g" value="-.5"/></phase>', {"kind": "henyey_greenstein", "g": -0.5}),
        ('<phase type="rayleigh"/>', {"kind": "rayleigh"}),
        # Mitsuba 3.9.1: 3/(4π·1.375) forwards (wo = -wi), a sixth of it backwards
        ('<phase type="tabphase"><string name="values" value="0.5, 1, 3"/></phase>',
         {"kind": "tabulated", "cosine": [-1, 0, 1], "value": [0.5, 1, 3]}),
        ('<phase type="blendphase"><float name="weight" value=".25"/><phase type="isotropic"/>'
         '<phase type="blendphase"><float name="weight" value=".5"/><phase type="rayleigh"/>'
         '<phase type="hg"><float name="g" value=".3"/></phase></phase></phase>',
         {"kind": "mixture", "components": [
             {"weight": 0.75, "phase": ISOTROPIC},
             {"weight": 0.125, "phase": {"kind": "rayleigh"}},
             {"weight": 0.125, "phase": {"kind": "henyey_greenstein", "g": 0.3}}]}),
    ],
)  # fmt: skip
def test_phase_functions(imported: Import, body: str, expected: dict[str, Any]) -> None:
    scene, notes = imported(inside(homogeneous(body)))
    assert notes == []
    assert scene["volumes"][0]["phase"] == expected


@pytest.mark.parametrize("stated", [False, True])
def test_a_grid_fills_the_unit_cube_or_the_box_that_it_states(imported: Import, tmp_path: Path, stated: bool) -> None:
    """Where a voxel comes to lie, with the reader's own placement: Mitsuba 3.9.1 finds 23 at (1.9, 2.9, 3.9)
    of the box, and 4 at (.125, .5, .25) of the cube."""
    write_vol(tmp_path / "a.vol", np.arange(24.0).reshape(2, 3, 4), (0, 0, 0, 2, 3, 4))
    more = '<boolean name="use_grid_bbox" value="true"/>' if stated else ""
    cube = '<shape type="cube"><transform name="to_world"><scale value="30"/></transform>'
    scene, notes = imported(inside(heterogeneous('<float name="scale" value="5"/>', '<translate x="10"/>', more), cube))
    assert notes == []
    volume = scene["volumes"][0]
    assert {key: volume[key] for key in ("file", "scale", "albedo")} == {"file": "a.vol", "scale": 5, "albedo": 0.75}
    # The reader places voxels in the file's box
    far_corner = np.array(volume["to_world"]) @ (2, 3, 4, 1)
    assert far_corner == pytest.approx([12, 3, 4, 1] if stated else [11, 1, 1, 1])


def test_a_grid_and_its_albedo(imported: Import, tmp_path: Path) -> None:
    write_vol(tmp_path / "a.vol", np.ones((2, 2, 2)))
    write_vol(tmp_path / "b.vol", np.ones((2, 2, 2, 3)))
    same, other = ('<transform name="to_world"></transform>', '<transform name="to_world"><scale x="2"/></transform>')
    albedo = '<volume name="albedo" type="gridvolume"><string name="filename" value="b.vol"/>{}</volume>'
    scene, notes = imported(inside(heterogeneous(albedo.format(same)), '<shape type="cube">'))
    assert (scene["volumes"][0]["albedo"], scene["volumes"][0]["albedo_grid"]) == (1, {"file": "b.vol"})
    assert notes == []
    scene, notes = imported(inside(heterogeneous(albedo.format(other)), '<shape type="cube">'))
    assert scene["volumes"][0]["albedo"] == 0.75
    assert notes == ["scene.xml:2: the grid of the albedo lies otherwise than that of sigma_t; 0.75 stands for it"]


def test_a_grid_is_not_cut_by_its_shape(imported: Import, tmp_path: Path) -> None:
    write_vol(tmp_path / "a.vol", np.ones((2, 2, 2)))
    small = '<shape type="sphere"><float name="radius" value="0.5"/>'
    _, notes = imported(inside(heterogeneous(""), small))
    assert notes == [
        "scene.xml:2: the shape does not hold all of the grid of its medium: it is carried over uncut",
    ]
    twice = inside(heterogeneous("").replace("<medium ", '<medium id="m" '), '<shape type="cube">').replace(
        "</scene>", '<shape type="cube"><bsdf type="null"/><ref name="interior" id="m"/></shape></scene>'
    )
    scene, notes = imported(twice)
    assert len(scene["volumes"]) == 1
    assert notes == []


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ('<shape type="sphere"><point name="center" x="1" y="2" z="3"/><float name="radius" value="2"/>'
         '<transform name="to_world"><scale value="2"/></transform></shape>',
         {"kind": "sphere", "center": [2, 4, 6], "radius": 4}),
        ('<shape type="rectangle"><transform name="to_world"><scale x="2" y="3"/></transform></shape>',
         {"kind": "rectangle", "to_world": [[2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}),
        ('<shape type="rectangle"><boolean name="flip_normals" value="true"/></shape>',
         {"kind": "rectangle", "to_world": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]}),
        ('<shape type="disk"><transform name="to_world"><scale value="2"/><rotate x="1" angle="90"/>'
         '<translate y="5"/></transform></shape>',
         {"kind": "disk", "center": [0, 5, 0], "normal": [0, -1, 0], "radius": 2}),
        ('<shape type="obj"><string name="filename" value="m.obj"/><transform name="to_world">'
         '<matrix value="0 -1 0 1 0 0 0 0 1"/></transform></shape>',
         {"kind": "mesh", "file": "m.obj", "to_world": [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}),
        ('<shape type="obj"><string name="filename" value="m.obj"/><boolean name="face_normals" value="true"/></shape>',
         {"kind": "mesh", "file": "m.obj", "smooth": False}),
    ],
)  # fmt: skip
def test_shapes(imported: Import, tmp_path: Path, shape: str, expected: dict[str, Any]) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n")
    scene, notes = imported(mitsuba(shape))
    assert [note for note in notes if "from behind" not in note] == []
    surface = scene["surfaces"][0]
    assert surface.pop("material") == GREY
    assert surface == expected


@pytest.mark.parametrize(
    ("bsdf", "expected"),
    [
        ('<bsdf type="diffuse"><rgb name="reflectance" value=".1 .2 .3"/></bsdf>',
         {"kind": "diffuse", "reflectance": [0.1, 0.2, 0.3]}),
        ('<bsdf type="twosided"><bsdf type="diffuse"><float name="reflectance" value=".1"/></bsdf></bsdf>',
         {"kind": "diffuse", "reflectance": 0.1}),
        ('<bsdf type="dielectric"/>', {"kind": "dielectric", "ior": 1.5046 / 1.000277}),
        ('<bsdf type="dielectric"><string name="int_ior" value="air"/><string name="ext_ior" value="water"/></bsdf>',
         {"kind": "dielectric", "ior": 1.000277 / 1.333}),
        ('<bsdf type="roughdielectric"><string name="distribution" value="ggx"/><float name="alpha" value=".2"/>'
         '<float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>',
         {"kind": "rough_dielectric", "ior": 1.5, "roughness": 0.2}),
        ('<bsdf type="conductor"><string name="material" value="none"/></bsdf>', {"kind": "mirror", "reflectance": 1}),
        ('<bsdf type="conductor"/>', {"kind": "mirror", "reflectance": 1}),
    ],
)  # fmt: skip
def test_materials(imported: Import, bsdf: str, expected: dict[str, Any]) -> None:
    scene, notes = imported(mitsuba(f'<shape type="sphere">{bsdf}</shape>'))
    assert notes == []
    material = scene["surfaces"][0]["material"]
    assert material.keys() == expected.keys()
    assert all(material[key] == (pytest.approx(expected[key]) if key == "ior" else expected[key]) for key in expected)


def test_flipped_glass_and_a_mirrored_sphere(imported: Import) -> None:
    """Mitsuba 3.9.1 turns a sphere inside out where its placement mirrors."""
    glass = '<bsdf type="dielectric"><float name="int_ior" value="2"/><float name="ext_ior" value="1"/></bsdf>'
    flip, mirror = (
        '<boolean name="flip_normals" value="true"/>',
        '<transform name="to_world"><scale x="-1"/></transform>',
    )
    found = [
        imported(mitsuba(f'<shape type="sphere">{glass}{more}</shape>'))[0]["surfaces"][0]["material"]["ior"]
        for more in ("", flip, mirror, flip + mirror)
    ]
    assert found == [2, 0.5, 0.5, 2]


def test_a_cube_of_glass_becomes_a_mesh(imported: Import, tmp_path: Path) -> None:
    scene, notes = imported(mitsuba('<shape type="cube"><bsdf type="dielectric"/></shape>'))
    assert notes == []
    assert scene["surfaces"][0]["file"] == "out.cube.ply"
    assert (tmp_path / "out.cube.ply").read_bytes().startswith(b"ply\nformat binary_little_endian 1.0\n")


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
    assert scene["surfaces"][0]["material"]["reflectance"] == pytest.approx([0.742853, 0.48114, 0.208325], abs=0.02)


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
         '<string name="filename" value="a.png"/></texture></bsdf></shape>', list(TEXTURED)),
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
        ('<shape type="sphere"><bsdf type="diffuse"><spectrum name="reflectance" value="400:.1 700:.9"/></bsdf></shape>',
         ["the spectrum of reflectance is approximated by 0.72671 0.474687 0.218257"]),
        ('<sensor type="thinlens"/>', ["left out: a scene has one camera, and the first sensor is taken"]),
        ('<shape type="ply"><string name="filename" value="../no.ply"/></shape>',
         ['the file "../no.ply" is not there; the scene refers to it all the same',
          'refers to a file outside the scene\'s folder: "../no.ply"']),
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


def test_includes_and_paths(imported: Import, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "ball.xml").write_text(
        '<scene version="3.0.0"><shape type="ply"><string name="filename" value="ball.ply"/></shape></scene>'
    )
    scene, notes = imported(
        mitsuba('<path value="parts"/><default name="what" value="ball"/><include filename="$what.xml"/>')
    )
    assert scene["surfaces"][0]["file"] == "parts/ball.ply"
    assert notes[0].startswith(f'{tmp_path / "parts" / "ball.xml"}:1: the file "ball.ply" is not there')


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
