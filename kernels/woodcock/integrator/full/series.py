"""Bounds on the Neumann series L = L⁰ + K L⁰ + …: of its operator's norm and of its first term."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from woodcock.layout import module
from woodcock.material.emissive import strength as shine
from woodcock.scene import DiffuseMaterial, EmissiveMaterial, MirrorMaterial, NullMaterial, Scene
from woodcock.space import Array
from woodcock.volume.media import Medium, strongest


def norm(scene: Scene, media: Sequence[Medium], corners: Array) -> float:
    """At least ‖K‖: no medium scatters more than its albedo of what its depth stops, no surface more than it reflects.

    ∫ α σ_s over a ray is at most albedo × (1 - exp(-τ)), and what reaches a surface is the rest.
    """
    length = float(np.linalg.norm(np.ptp(corners, axis=0)))
    depth = sum(float(medium.bound.max()) for medium in media) * length
    scattered = max((float(np.max(medium.volume.albedo)) for medium in media), default=0.0)
    reflected = 0.0
    for surface in scene.surfaces:
        match surface.material:
            case DiffuseMaterial(reflectance=share) | MirrorMaterial(reflectance=share):
                reflected = max(reflected, float(np.max(share)))
            case EmissiveMaterial() | NullMaterial():
                pass
            case _:  # Refraction packs radiance by η²: no bound below 1
                return 1.0
    return max(scattered, reflected) if reflected else -scattered * math.expm1(-depth)


def unscattered(lights: Sequence[Any], scene: Scene, media: Sequence[Medium], corners: Array) -> float | None:
    """At least L⁰ anywhere, in any direction; None where a light is a point or a direction: it has no radiance."""
    emissive = [s.material for s in scene.surfaces if isinstance(s.material, EmissiveMaterial)]
    total = max((float(np.max(shine(material))) for material in emissive), default=0.0)
    sky = 0.0
    for light in lights:
        kind = module("light", light.kind)
        if not kind.ON_ESCAPE:
            return None
        sky += float(np.max(kind.strength(light)))
    length = float(np.linalg.norm(np.ptp(corners, axis=0)))
    return max(total, sky) + sum(strongest(medium, length) for medium in media)
