"""Mitsuba's cameras and environments against Mitsuba itself: where its rays go, ours go.

The numbers are those of Mitsuba 3.9.1, variant scalar_rgb: `sensor.sample_ray(0, 0.5, (u, v), (0.5, 0.5))` of SENSORS,
origin and direction at the film's COORDINATES; and `emitter.eval` of ENVMAP with SKY as its picture.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import mitsuba

from woodcock.camera import orthographic, perspective
from woodcock.light import image
from woodcock.scene import ImageLight, OrthographicCamera, PerspectiveCamera, load

COORDINATES = np.array([[0.5, 0.5], [0.25, 0.25], [1, 0], [0, 1]])
LOOK = '<transform name="to_world">{}<lookat origin="1, 2, 5" target="0.5, 0, 0" {}/></transform>'
UP = 'up="0, 1, 0"'
FOV = '<float name="fov" value="40"/>'
AXIS = FOV + '<string name="fov_axis" value="{}"/>'
TURNED = '<rotate y="1" angle="30"/><rotate x="1" angle="-20"/><translate x="1" y="2" z="3"/>'
LENS = '<float name="aperture_radius" value="0.25"/><float name="focus_distance" value="3"/>'
SENSORS = {
    "perspective": ("perspective", FOV + LOOK.format("", 'up="0.1, 1, 0"')),
    "smaller": ("perspective", AXIS.format("smaller") + f'<transform name="to_world">{TURNED}</transform>'),
    "larger": ("perspective", AXIS.format("larger")),
    "y": ("perspective", AXIS.format("y")),
    "diagonal": ("perspective", AXIS.format("diagonal")),
    "focal length": ("perspective", '<string name="focal_length" value="35mm"/>'),
    "mirrored": ("perspective", FOV + LOOK.format('<scale x="-1"/>', UP)),
    "no up": ("perspective", FOV + LOOK.format("", "")),
    "thinlens": ("thinlens", FOV + LENS + LOOK.format("", UP)),
    "orthographic": ("orthographic", LOOK.format('<scale value="3"/>', UP)),
}
RAYS = [
    (
        "perspective",
        "64x48",
        [
            [0.99908, 1.9963, 4.99076, -0.09245, -0.3698, -0.9245],
            [0.99736, 1.99774, 4.99035, -0.25712, -0.22002, -0.941],
            [1.00288, 1.99846, 4.98951, 0.26225, -0.13997, -0.95479],
            [0.99527, 1.99414, 4.992, -0.43055, -0.53323, -0.72821],
        ],
    ),
    (
        "smaller",
        "64x48",
        [
            [1.005, 2.00296, 3.00814, 0.5, 0.2962, 0.8138],
            [1.0071, 2.00426, 3.00638, 0.67957, 0.40739, 0.6101],
            [1.0008, 2.00721, 3.00917, 0.06816, 0.61662, 0.7843],
            [1.0092, 1.99871, 3.0071, 0.78682, -0.11013, 0.60727],
        ],
    ),
    (
        "larger",
        "64x48",
        [
            [0.0, 0.0, 0.01, 0.0, 0.0, 1.0],
            [0.00182, 0.00136, 0.01, 0.17745, 0.13309, 0.97509],
            [-0.00364, 0.00273, 0.01, -0.33129, 0.24847, 0.91022],
            [0.00364, -0.00273, 0.01, 0.33129, -0.24847, 0.91022],
        ],
    ),
    (
        "y",
        "64x48",
        [
            [0.0, 0.0, 0.01, 0.0, 0.0, 1.0],
            [0.00243, 0.00182, 0.01, 0.2322, 0.17415, 0.95695],
            [-0.00485, 0.00364, 0.01, -0.41492, 0.31119, 0.85499],
            [0.00485, -0.00364, 0.01, 0.41492, -0.31119, 0.85499],
        ],
    ),
    (
        "diagonal",
        "64x48",
        [
            [0.0, 0.0, 0.01, 0.0, 0.0, 1.0],
            [0.00146, 0.00109, 0.01, 0.14324, 0.10743, 0.98384],
            [-0.00291, 0.00218, 0.01, -0.27362, 0.20521, 0.93969],
            [0.00291, -0.00218, 0.01, 0.27362, -0.20521, 0.93969],
        ],
    ),
    (
        "focal length",
        "64x48",
        [
            [0.0, 0.0, 0.01, 0.0, 0.0, 1.0],
            [0.00247, 0.00185, 0.01, 0.23621, 0.17716, 0.95541],
            [-0.00494, 0.00371, 0.01, -0.42061, 0.31546, 0.85063],
            [0.00494, -0.00371, 0.01, 0.42061, -0.31546, 0.85063],
        ],
    ),
    (
        "mirrored",
        "64x48",
        [
            [0.99908, 1.9963, 4.99076, -0.09245, -0.3698, -0.9245],
            [1.00084, 1.99757, 4.99007, 0.08153, -0.23693, -0.9681],
            [0.99535, 1.99884, 4.99011, -0.42294, -0.10574, -0.89997],
            [1.0028, 1.99377, 4.9914, 0.25464, -0.56746, -0.78304],
        ],
    ),
    (
        "no up",
        "64x48",
        [
            [0.99908, 1.9963, 4.99076, -0.09245, -0.3698, -0.9245],
            [1.0004, 1.99797, 4.98996, 0.0392, -0.19811, -0.9794],
            [1.00186, 1.99287, 4.99185, 0.1691, -0.64877, -0.74196],
            [0.99629, 1.99973, 4.98966, -0.3374, -0.02443, -0.94104],
        ],
    ),
    (
        "thinlens",
        "64x48",
        [
            [0.99908, 1.9963, 4.99076, -0.09245, -0.3698, -0.9245],
            [0.99721, 1.99757, 4.99043, -0.27162, -0.23693, -0.93278],
            [1.0026, 1.99884, 4.98939, 0.23636, -0.10574, -0.9659],
            [0.99555, 1.99377, 4.99212, -0.40466, -0.56746, -0.71711],
        ],
    ),
    (
        "orthographic",
        "64x48",
        [
            [0.99723, 1.98891, 4.97226, -0.09245, -0.3698, -0.9245],
            [-0.53673, 3.03416, 4.70756, -0.09245, -0.3698, -0.9245],
            [3.89954, 4.07941, 3.84583, -0.09245, -0.3698, -0.9245],
            [-1.90509, -0.10159, 6.0987, -0.09245, -0.3698, -0.9245],
        ],
    ),
    (
        "perspective",
        "48x64",
        [
            [0.99908, 1.9963, 4.99076, -0.09245, -0.3698, -0.9245],
            [0.99744, 1.99872, 4.98995, -0.24524, -0.12208, -0.96174],
            [1.00303, 2.00042, 4.98871, 0.25901, 0.03621, -0.9652],
            [0.99512, 1.99218, 4.9928, -0.4171, -0.66856, -0.61568],
        ],
    ),
    (
        "smaller",
        "48x64",
        [
            [1.005, 2.00296, 3.00814, 0.5, 0.2962, 0.8138],
            [1.00658, 2.00493, 3.00645, 0.62929, 0.47186, 0.61752],
            [1.00185, 2.00814, 3.00819, 0.158, 0.69636, 0.70009],
            [1.00815, 1.99778, 3.00809, 0.69699, -0.18987, 0.69149],
        ],
    ),
    (
        "orthographic",
        "48x64",
        [
            [0.99723, 1.98891, 4.97226, -0.09245, -0.3698, -0.9245],
            [-0.56892, 3.84713, 4.38559, -0.09245, -0.3698, -0.9245],
            [3.83515, 5.70535, 3.20189, -0.09245, -0.3698, -0.9245],
            [-1.8407, -1.72754, 6.74263, -0.09245, -0.3698, -0.9245],
        ],
    ),
]


def sensor(name: str, width: str, height: str) -> str:
    kind, inner = SENSORS[name]
    sides = f'<integer name="width" value="{width}"/><integer name="height" value="{height}"/>'
    return f'<sensor type="{kind}">{inner}<film type="hdrfilm">{sides}</film></sensor>'


@pytest.mark.parametrize(("name", "film", "expected"), RAYS, ids=[f"{name} {film}" for name, film, _ in RAYS])
def test_rays_are_those_of_mitsuba(
    imported: Import, tmp_path: Path, name: str, film: str, expected: list[list[float]]
) -> None:
    width, height = film.split("x")
    _, notes = imported(mitsuba('<shape type="sphere"/>', sensor(name, width, height)))
    mirrored = "the camera mirrors its picture: the world is mirrored instead, x turned round"
    assert notes == ([f"scene.xml:1: {mirrored}"] if name == "mirrored" else [])
    camera = load(tmp_path / "out.json").camera
    u, v = COORDINATES.T
    oracle = orthographic if isinstance(camera, OrthographicCamera) else perspective
    # In the middle of its lens, a thin lens is a pinhole
    pinhole = camera
    if camera.kind == "thin_lens":
        assert (camera.aperture_radius, camera.focus_distance) == (0.25, 3)
        pinhole = PerspectiveCamera(origin=camera.origin, target=camera.target, up=camera.up, fov=camera.fov)
    origins, directions = oracle.ray(pinhole, int(width) / int(height), u, v)
    points, ways = np.split(np.array(expected), 2, axis=1)
    if name == "mirrored":
        points, ways = points * (-1, 1, 1), ways * (-1, 1, 1)
    np.testing.assert_allclose(directions, ways, atol=2e-5)
    # Mitsuba's rays begin on the near clipping plane: on the same line
    np.testing.assert_allclose(np.cross(points - origins, ways), 0, atol=1e-4)


SKY = np.stack([*np.mgrid[1:9, 1:17][::-1], np.ones((8, 16))], axis=-1).astype(np.float32)
TURN = '<rotate x="1" angle="20"/><rotate y="1" angle="50"/>'
ENVMAP = f"""<emitter type="envmap"><string name="filename" value="sky.exr"/><float name="scale" value="2"/>
<transform name="to_world">{TURN}</transform></emitter>"""
DIRECTIONS = np.array(
    [
        [0.36354, 0.8643, 0.3476],
        [-0.79057, 0.54924, 0.2708],
        [-0.61636, 0.66706, 0.41849],
        [0.47329, 0.04573, 0.87972],
        [-0.82269, -0.18199, -0.53857],
        [0.89698, 0.0595, -0.43805],
        [-0.94988, -0.31244, 0.00989],
        [-0.16577, 0.77836, 0.60553],
    ]
)
#: Red grows to the right, green downwards.
RADIANCES = np.array(
    [
        [17.9326, 2.8022, 2.0],
        [28.5258, 7.3181, 2.0],
        [27.6944, 6.3655, 2.0],
        [19.0753, 7.357, 2.0],
        [27.3198, 11.3589, 2.0],
        [10.9181, 8.1272, 2.0],
        [28.7979, 11.5436, 2.0],
        [25.1766, 4.7069, 2.0],
    ]
)


def write_sky(path: Path) -> None:
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), oiio.ImageSpec(16, 8, 3, oiio.FLOAT))
    assert output.write_image(SKY)
    assert output.close()


@pytest.mark.parametrize("mirrored", [False, True])
def test_an_environment_is_turned_as_by_mitsuba(imported: Import, tmp_path: Path, mirrored: bool) -> None:
    write_sky(tmp_path / "sky.exr")
    camera = sensor("mirrored" if mirrored else "perspective", "64", "48")
    scene, notes = imported(mitsuba(f'{ENVMAP}<shape type="sphere"/>', camera))
    assert len(notes) == mirrored
    assert {**scene["lights"][0], "to_world": 0} == {"kind": "image", "file": "sky.exr", "scale": 2, "to_world": 0}
    light = load(tmp_path / "out.json").lights[0]
    assert isinstance(light, ImageLight)
    found = image.radiance(image.read(light), DIRECTIONS * ((-1 if mirrored else 1), 1, 1))
    np.testing.assert_allclose(found[:, [0, 2]], RADIANCES[:, [0, 2]], atol=2e-3)
    # Mitsuba's first and last row lie on the poles, ours half a row from them
    np.testing.assert_allclose(found[:, 1], RADIANCES[:, 1], atol=2 * 0.5)
