"""The device's space, and what no scene may ask of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.conftest import described

from woodcock.camera.pose import Pose
from woodcock.device import Device
from woodcock.film import Film
from woodcock.render import Renderer
from woodcock.scene import PerspectiveCamera, SceneError
from woodcock.space import Space

CORNERS = np.array(list(np.ndindex(2, 2, 2)), float)


@pytest.mark.parametrize("size", [1e-36, 1e-12, 1.0, 1e12, 1e36])
def test_scenes_are_about_one_long(size: float) -> None:
    space = Space.around(size * (CORNERS + 7), 3e20)
    assert 0.5 <= np.ptp(space.point(size * (CORNERS + 7)), axis=0).max() <= 1
    assert np.allclose(space.point(size * (CORNERS + 7)).sum(axis=0), 0, atol=1e-12)
    assert 0.5 <= space.radiance(np.array(3e20)) <= 1
    assert space.coefficient(2 / size) == pytest.approx(2 / space.length(size))


@pytest.mark.parametrize(
    ("size", "strongest", "says"),
    [
        (1e-40, 1.0, "the scene is 1e-40 long"),
        (1e40, 1.0, "the scene is 1e.40 long"),
        (1.5e308, 1.0, "long"),
        (1.0, 1e-40, "largest radiance, about 1e-40"),
        (1.0, 1e39, "largest radiance, about 1e.39"),
        (1.0, np.inf, "largest radiance, about inf"),
    ],
)
def test_what_float32_cannot_express_is_refused(size: float, strongest: float, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        Space.around(size * CORNERS, strongest)


def test_mean_free_paths_that_float32_cannot_express_are_refused() -> None:
    space = Space.around(CORNERS, 1.0)
    assert space.coefficient(1e35) == 1e35 * 2
    with pytest.raises(SceneError, match="mean free paths of 5e-41"):
        space.coefficient(1e40)
    with pytest.raises(SceneError, match=r"σ_t of 1\.7e\+308"):
        space.coefficients(np.array([1.0, 1.7e308]))


def test_a_camera_too_far_for_float32_is_refused() -> None:
    far = PerspectiveCamera(origin=(0, 0, -1e30), target=(0, 0, 0))
    with pytest.raises(SceneError, match=r"camera: stands 5e\+29 times"):
        Pose.of(far, Space.around(CORNERS, 1.0))
    assert np.allclose(Pose.of(far, Space.around(1e20 * CORNERS, 1.0)).forward, [0, 0, 1])


@pytest.mark.parametrize(
    ("largest", "dtype"), [(3.0, np.float16), (1e-45, np.float32), (2e-39, np.float32), (3e38, np.float32)]
)
def test_a_grid_is_the_medium_that_its_scale_says(
    box: dict[str, Any],
    grid: Callable[..., dict[str, Any]],
    device: Device,
    picture: Callable[..., Film],
    largest: float,
    dtype: Any,
) -> None:
    """By the loop that takes densities relative to the largest: halves, denormal numbers, and the largest there are."""
    values = np.full((2, 3, 4), largest, dtype)
    values[0] = 0
    box["volumes"] = [grid(values, scale=2 / float(values.max()), albedo=0.5)]
    ones = box | {"volumes": [grid((values > 0).astype(np.float32), scale=2, albedo=0.5)]}
    assert "storage" in Renderer(described(box), device).kinds
    assert np.array_equal(picture(box, 4).mean, picture(ones, 4).mean)
