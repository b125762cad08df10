"""Cameras against their float64 oracles: perspective, orthographic."""

from __future__ import annotations

import numpy as np
import pytest
from tests.kernels.device_code import call

from woodcock.device import Context
from woodcock.layout import module
from woodcock.scene import OrthographicCamera, PerspectiveCamera
from woodcock.space import Space

PLACE = {"origin": (1, -4, 2.5), "target": (0.2, 0.1, 0.3), "up": (0, 0.1, 1)}


@pytest.mark.parametrize(
    "camera",
    [PerspectiveCamera(**PLACE, fov=35), PerspectiveCamera(**PLACE, fov=150), OrthographicCamera(**PLACE, height=3)],
    ids=repr,
)
@pytest.mark.parametrize("aspect", [1, 1.75])
def test_rays(context: Context, lanes: int, camera: PerspectiveCamera | OrthographicCamera, aspect: float) -> None:
    space = Space(np.array([0.3, 0.2, 0.1]), 2)
    u, v = np.random.default_rng(4).random((2, 256), dtype=np.float32)
    kind = module("camera", camera.kind)
    body = f"vector a, d; real start; camera_{camera.kind}_ray(kind, u, v, &a, &d, &start);"
    results = ["a.x", "a.y", "a.z", "d.x", "d.y", "d.z", "start"]
    got = call(
        context, "camera", camera, kind.record(camera, aspect, space), body, results, {"u": u, "v": v}, lanes
    ).astype(float)
    anchor, direction, start = got[:3].T, got[3:6].T, got[6]
    origin, right = kind.ray(camera, aspect, u.astype(float), v.astype(float))
    assert np.allclose(direction, right, atol=3e-7)
    assert np.allclose(np.linalg.norm(direction, axis=1), 1, atol=3e-7)
    # Back along the ray from its anchor lies the camera.
    begin = (anchor + start[:, None] * direction) * 4 + space.centre
    assert np.allclose(begin, origin, atol=3e-6)


def test_the_picture_is_upright() -> None:
    """The upper left corner of the picture is up and to the left of the view."""
    camera = PerspectiveCamera(origin=(0, 0, 5), target=(0, 0, 0))
    _, direction = module("camera", "perspective").ray(camera, 1.0, np.array([0.0]), np.array([0.0]))
    assert direction[0, 0] < 0 < direction[0, 1]
