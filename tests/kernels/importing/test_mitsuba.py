"""Mitsuba scenes: what becomes what, to the letter."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import mitsuba

NOTHING = '<shape type="sphere"/>'
GREY = {"kind": "diffuse", "reflectance": 0.5}
ISOTROPIC = {"kind": "isotropic"}


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
