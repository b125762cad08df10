"""Cameras against their float64 oracles: perspective, orthographic, thin_lens, spherical."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.conftest import Rng
from tests.kernels.device_code import call
from tests.statistics import accept_mean

from woodcock.device import Context
from woodcock.layout import module
from woodcock.scene import Camera, OrthographicCamera, PerspectiveCamera, SphericalCamera, ThinLensCamera
from woodcock.space import Space

PLACE: dict[str, Any] = {"origin": (1, -4, 2.5), "target": (0.2, 0.1, 0.3), "up": (0, 0.1, 1)}
CAMERAS = [
    PerspectiveCamera(**PLACE, fov=35),
    PerspectiveCamera(**PLACE, fov=150),
    OrthographicCamera(**PLACE, height=3),
    ThinLensCamera(**PLACE, fov=35, aperture_radius=0.2),
    ThinLensCamera(**PLACE, fov=60, aperture_radius=0.2, focus_distance=1.5),
    SphericalCamera(**PLACE),
]
SPACE = Space(np.array([0.3, 0.2, 0.1]), 2)


def rays(context: Context, lanes: int, camera: Camera, aspect: float, space: Space, **film: np.ndarray) -> np.ndarray:
    """Anchors (3), directions (3) and starts of a camera's rays, (7, n)."""
    kind, arguments = module("camera", camera.kind), ", ".join(film)
    body = f"vector a, d; real start; camera_{camera.kind}_ray(kind, {arguments}, &a, &d, &start);"
    results = ["a.x", "a.y", "a.z", "d.x", "d.y", "d.z", "start"]
    return call(context, "camera", camera, kind.record(camera, aspect, space), body, results, film, lanes).astype(float)


def film(camera: Camera, seed: int = 4) -> dict[str, np.ndarray]:
    """Film coordinates, and of the lens where there is one."""
    names = ["u", "v", "lens_u", "lens_v"] if hasattr(module("camera", camera.kind), "LENS") else ["u", "v"]
    return {name: np.random.default_rng([seed, i]).random(256, dtype=np.float32) for i, name in enumerate(names)}


def right(camera: Camera, aspect: float, film: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    origin, direction = module("camera", camera.kind).ray(camera, aspect, *(x.astype(float) for x in film.values()))
    return origin, direction


@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
@pytest.mark.parametrize("aspect", [1, 1.75])
def test_rays(context: Context, lanes: int, camera: Camera, aspect: float) -> None:
    places = film(camera)
    got = rays(context, lanes, camera, aspect, SPACE, **places)
    anchor, direction, start = got[:3].T, got[3:6].T, got[6]
    origin, along = right(camera, aspect, places)
    assert np.allclose(direction, along, atol=3e-7)
    assert np.allclose(np.linalg.norm(direction, axis=1), 1, atol=3e-7)
    # Back along the ray from its anchor lies the camera.
    begin = (anchor + start[:, None] * direction) * 4 + SPACE.centre
    assert np.allclose(begin, origin, atol=3e-6)


@pytest.mark.parametrize("distance", [1e-4, 1e6])
@pytest.mark.parametrize("kind", ["perspective", "thin_lens"])
def test_distance_costs_no_precision(context: Context, distance: float, kind: str) -> None:
    """Rays of a camera far from the scene's middle, and of one close to it, are anchored where the oracle's run."""
    away = np.array([1.0, -4, 2.5]) / np.linalg.norm([1, -4, 2.5])
    focus = max(distance, 0.5)
    place: dict[str, Any] = {"origin": tuple(distance * away), "target": tuple((distance - focus) * away)}
    fov = 2 * np.degrees(np.arctan(0.5 / focus))
    camera: Camera = PerspectiveCamera(**place, fov=fov)
    if kind == "thin_lens":
        camera = ThinLensCamera(**place, fov=fov, aperture_radius=focus / 10, focus_distance=focus)
    places = film(camera)
    got = rays(context, 1, camera, 1.0, Space(), **places)
    anchor, direction = got[:3].T, got[3:6].T
    origin, along = right(camera, 1.0, places)
    assert np.allclose(direction, along, atol=3e-7)
    reach = ((anchor - origin) @ away) / (along @ away)
    assert np.allclose(anchor, origin + along * reach[:, None], atol=3e-7)


def test_a_thin_lens_is_sharp_in_its_focus(context: Context, lanes: int, rng: Rng) -> None:
    """All rays of a film coordinate meet in the plane of focus, and fill the lens evenly."""
    n = 1 << 12
    camera = ThinLensCamera(origin=(0, 0, 4), target=(0, 0, 0), aperture_radius=0.5, focus_distance=3)
    lens_u, lens_v = rng(5).random((2, n), dtype=np.float32)
    u, v = np.full(n, 0.2, np.float32), np.full(n, 0.7, np.float32)
    got = rays(context, lanes, camera, 1.0, Space(), u=u, v=v, lens_u=lens_u, lens_v=lens_v)
    anchor, direction, start = got[:3], got[3:6], got[6]
    lens = anchor + start * direction
    assert np.allclose(lens[2], 4, atol=2e-6)
    radius = np.hypot(lens[0], lens[1])
    assert radius.max() <= 0.5 + 2e-6
    accept_mean(radius**2, 0.125)
    accept_mean(lens[:2], 0)
    focus = anchor + (1 - anchor[2]) / direction[2] * direction
    assert np.ptp(focus, axis=1).max() < 3e-6
    pinhole = PerspectiveCamera(origin=(0, 0, 4), target=(0, 0, 0))
    _, middle = module("camera", "perspective").ray(pinhole, 1.0, np.array([0.2]), np.array([0.7]))
    assert np.allclose(focus[:, 0], np.array([0, 0, 4]) + 3 / -middle[0, 2] * middle[0], atol=3e-6)


def test_a_spherical_camera_sees_all_around(context: Context, lanes: int) -> None:
    """The target in the middle, up above, right on the right; beyond the film's edges it goes on."""
    camera = SphericalCamera(origin=(1, 2, 3), target=(1, 2, -4))
    u = np.array([0.5, 0.5, 0.5, 0.75, 0.25, 0, 1, -0.25, 1.25, 0.5, 0.5], np.float32)
    v = np.array([0.5, 0, 1, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, -0.25, 1.25], np.float32)
    half = np.sqrt(0.5)
    directions = [
        *([0, 0, -1], [0, 1, 0], [0, -1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, 1], [1, 0, 0], [-1, 0, 0]),
        *([0, half, half], [0, -half, half]),
    ]
    got = rays(context, lanes, camera, 2.0, Space(), u=u, v=v)
    assert np.allclose(got[3:6].T, directions, atol=3e-7)
    assert np.array_equal(got[:3].T + got[6][:, None] * got[3:6].T, np.broadcast_to([1, 2, 3], (u.size, 3)))


def test_the_picture_is_upright() -> None:
    """The upper left corner of the picture is up and to the left of the view."""
    corner = np.array([0.1])
    for camera in (
        PerspectiveCamera(origin=(0, 0, 5), target=(0, 0, 0)),
        SphericalCamera(origin=(0, 0, 5), target=(0, 0, 0)),
    ):
        _, direction = module("camera", camera.kind).ray(camera, 1.0, corner + 0.3, corner + 0.3)
        assert direction[0, 0] < 0 < direction[0, 1]
