"""pbrt's cameras: points of its world, projected by its own formulas, are where the scene's camera finds them.

The formulas are those of pbrt-v4's book, chapter 5: raster to screen to camera space, where the camera looks along +z
with +y up and +x on the right, and the camera's transform takes the world there.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
import pytest
from tests.kernels.importing.conftest import Import
from tests.kernels.importing.scenes import pbrt

from woodcock.camera import orthographic, perspective, spherical
from woodcock.importing.environment import equal_area, latlong_directions
from woodcock.light import image
from woodcock.scene import ImageLight, OrthographicCamera, PerspectiveCamera, SphericalCamera, load

WIDTH, HEIGHT = 80, 60
POINTS = np.array([[0.3, 0.2, 0.1], [-0.5, 0.4, 0.0], [0.1, -0.7, 0.6], [0.9, 0.9, -0.3]])


def look_at(eye: tuple[float, ...], target: tuple[float, ...], up: tuple[float, ...]) -> np.ndarray[Any, Any]:
    """World to camera, of pbrt's LookAt: its rows are right, up and forward."""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(np.divide(up, np.linalg.norm(up)), forward)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = right, np.cross(forward, right), forward
    matrix[:3, 3] = -matrix[:3, :3] @ eye
    return matrix


LOOK = "LookAt 1 2 -5  0 0.1 0  0.1 1 0"
TO_CAMERA = look_at((1, 2, -5), (0, 0.1, 0), (0.1, 1, 0))
PLACES = {
    "left-handed": (LOOK, TO_CAMERA),
    "right-handed": (f"Scale -1 1 1 {LOOK}", np.diag([-1, 1, 1, 1]) @ TO_CAMERA),
    "scaled": (f"Scale 2 2 2 {LOOK}", np.diag([2, 2, 2, 1]) @ TO_CAMERA),
}


def project(kind: str, camera: np.ndarray[Any, Any], tangent: float, half: float) -> np.ndarray[Any, Any]:
    """(n, 2): u, v from the upper left of points (n, 3) in camera space; `half` is half the screen's height."""
    x, y, z = camera.T
    if kind == "spherical":
        # pbrt swaps y and z of (sin θ cos φ, sin θ sin φ, cos θ), θ = π v and φ = 2π u
        return np.stack(
            [np.arctan2(z, x) / (2 * np.pi) % 1, np.arccos(y / np.hypot(np.hypot(x, y), z)) / np.pi], axis=1
        )
    depth = z * tangent if kind == "perspective" else np.ones_like(z)
    screen = np.stack([x / depth, y / depth], axis=1) / half
    return np.asarray(np.stack([screen[:, 0] * HEIGHT / WIDTH / 2 + 0.5, 0.5 - screen[:, 1] / 2], axis=1))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    ("kind", "parameters", "half"),
    [
        ("perspective", '"float fov" 40', 1.0),
        ("perspective", '"float fov" 40 "float screenwindow" [-1 1 -.75 .75]', 0.75),
        ("perspective", '"float fov" 40 "float lensradius" .1 "float focaldistance" 3', 1.0),
        ("orthographic", "", 1.0),
        ("orthographic", '"float screenwindow" [-4 4 -3 3]', 3.0),
        ("spherical", '"string mapping" "equirectangular"', 1.0),
    ],
)
def test_points_are_seen_where_pbrt_sees_them(
    imported: Import, tmp_path: Path, place: str, kind: str, parameters: str, half: float
) -> None:
    transform, to_camera = PLACES[place]
    options = f'Film "rgb" "integer xresolution" {WIDTH} "integer yresolution" {HEIGHT} {transform} '
    balls = " ".join(f'AttributeBegin Translate {x} {y} {z} Shape "sphere" AttributeEnd' for x, y, z in POINTS)
    scene, notes = imported(pbrt(balls, f'{options} Camera "{kind}" {parameters}'), "scene.pbrt")
    assert len(notes) == 1
    camera = load(tmp_path / "out.json").camera
    centers = np.array([surface["center"] for surface in scene["surfaces"]])
    in_camera = POINTS @ to_camera[:3, :3].T + to_camera[:3, 3]
    u, v = project(kind, in_camera, np.tan(np.radians(20)), half).T
    aspect = WIDTH / HEIGHT
    if camera.kind == "thin_lens":
        size = np.cbrt(abs(np.linalg.det(to_camera[:3, :3])))
        assert (camera.aperture_radius, camera.focus_distance) == pytest.approx((0.1 / size, 3 / size))
        camera = PerspectiveCamera(origin=camera.origin, target=camera.target, up=camera.up, fov=camera.fov)
    if isinstance(camera, PerspectiveCamera):
        origins, directions = perspective.ray(camera, aspect, u, v)
    elif isinstance(camera, OrthographicCamera):
        origins, directions = orthographic.ray(camera, aspect, u, v)
    else:
        assert isinstance(camera, SphericalCamera)
        origins, directions = spherical.ray(camera, aspect, u, v)
    ways = centers - origins
    np.testing.assert_allclose(np.cross(directions, ways), 0, atol=1e-9)
    assert (np.sum(directions * ways, axis=-1) > 0).all()
    # Left-handed worlds are mirrored, right-handed ones are not; pbrt's spherical camera has it the other way round
    mirrored = (place == "right-handed") == (kind == "spherical")
    np.testing.assert_allclose(centers, POINTS * ((-1 if mirrored else 1), 1, 1))


def square_to_sphere(u: np.ndarray[Any, Any], v: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """pbrt's EqualAreaSquareToSphere, as its book writes it."""
    x, y = 2 * u - 1, 2 * v - 1
    distance = 1 - (abs(x) + abs(y))
    r = 1 - abs(distance)
    phi = np.where(r == 0, 1, (abs(y) - abs(x)) / np.where(r == 0, 1, r) + 1) * np.pi / 4
    across = r * np.sqrt(2 - r * r)
    return np.stack(
        [np.copysign(np.cos(phi), x) * across, np.copysign(np.sin(phi), y) * across, np.copysign(1 - r * r, distance)],
        -1,
    )


def test_the_square_of_all_directions_is_inverted() -> None:
    u, v = np.random.default_rng(1).random((2, 1000))
    np.testing.assert_allclose(equal_area(square_to_sphere(u, v)), (u, v), atol=1e-12)


def test_directions_of_longitude_and_latitude_are_the_lights_own() -> None:
    """The middle of the picture looks along -z, right of it lies +x, and +y is up."""
    directions = latlong_directions(256)
    assert directions[128, 256] == pytest.approx([0, 0, -1], abs=0.02)
    assert directions[128, 384] == pytest.approx([1, 0, 0], abs=0.02)
    assert directions[0, 0] == pytest.approx([0, 1, 0], abs=0.02)


@pytest.mark.parametrize("place", ["left-handed", "right-handed"])
def test_an_environment_is_resampled(imported: Import, tmp_path: Path, place: str) -> None:
    """A picture whose colour is 2 + direction is found again, in the turned and mirrored world."""
    side = 128
    v, u = (np.mgrid[0:side, 0:side] + 0.5) / side
    output = oiio.ImageOutput.create(str(tmp_path / "sky.exr"))
    assert output.open(str(tmp_path / "sky.exr"), oiio.ImageSpec(side, side, 3, oiio.FLOAT))
    assert output.write_image(np.ascontiguousarray(2 + square_to_sphere(u, v), np.float32))
    assert output.close()
    body = 'Shape "sphere" Rotate 90 1 0 0 LightSource "infinite" "string filename" "sky.exr" "float scale" 3'
    scene, notes = imported(pbrt(body, f'{PLACES[place][0]} Camera "perspective"'), "scene.pbrt")
    assert notes[1:] == ["scene.pbrt:2: the square picture is resampled to one of longitude and latitude"]
    assert scene["lights"] == [{"kind": "image", "file": "out.sky.exr", "scale": 3}]
    light = load(tmp_path / "out.json").lights[0]
    assert isinstance(light, ImageLight)
    directions = np.random.default_rng(2).standard_normal((200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    mirrored = directions * ((1 if place == "right-handed" else -1), 1, 1)
    # Rotate takes the light's y to the world's z: in the light, y is the world's z, and z its -y
    local = np.stack([directions[:, 0], directions[:, 2], -directions[:, 1]], axis=1)
    np.testing.assert_allclose(image.radiance(image.read(light), mirrored), 3 * (2 + local), atol=0.1)
