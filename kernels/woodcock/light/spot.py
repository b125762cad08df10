"""Light from one point into a cone."""

from __future__ import annotations

import math

import numpy as np

from woodcock.scene import SpotLight
from woodcock.space import Array, Space

FIELDS = {"position": "vector3", "axis": "vector3", "intensity": "colour", "cutoff": "float", "steepness": "float"}
ON_ESCAPE = False
SAMPLED = True
LOCAL = True
#: Is there light along a part of a ray only?
SPANS = True


def strength(light: SpotLight) -> Array:
    """The intensity: radiance × area, so that over the square of a length it compares with a radiance."""
    return np.atleast_1d(np.array(light.intensity))


def position(light: SpotLight) -> Array:
    """(3,), scene units."""
    return np.array(light.position)


def record(light: SpotLight, space: Space) -> dict[str, Array | float]:
    """cutoff: its versine; steepness: 1 over the difference of the versines, at most what float32 can hold."""
    cutoff, beam = _versine(light.cutoff), _versine(_beam(light))
    return {
        "position": space.point(position(light)),
        "axis": axis(light),
        "intensity": space.intensity(strength(light)),
        "cutoff": cutoff,
        "steepness": 1 / max(cutoff - beam, 1e-30),
    }


def axis(light: SpotLight) -> Array:
    """Unit direction (3,) of the cone's middle, away from the light."""
    along = np.array(light.target) - position(light)
    return np.asarray(along / np.linalg.norm(along))


def _beam(light: SpotLight) -> float:
    return 0.75 * light.cutoff if light.beam is None else light.beam


def _versine(degrees: float) -> float:
    return 2 * math.sin(math.radians(degrees) / 2) ** 2


def weight(light: SpotLight, points: Array) -> Array:
    """Float64 oracle: intensity × falloff over squared distance (..., channels) at points (..., 3) of the scene."""
    to = points - position(light)
    distance = np.linalg.norm(to, axis=-1, keepdims=True)
    cosine = to @ axis(light) / distance[..., 0]
    low, high = np.cos(np.radians([light.cutoff, _beam(light)]))
    t = np.clip((cosine - low) / (high - low), 0, 1)
    return np.asarray(strength(light) * (t * t * (3 - 2 * t))[..., None] / distance**2)
