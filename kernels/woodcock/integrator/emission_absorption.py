"""Lays out a scene whose media absorb and emit, L′ + σ_t L = ε: without random numbers."""

from __future__ import annotations

from woodcock.integrator import deterministic
from woodcock.layout import Layout, Read
from woodcock.scene import Scene


def lay_out(scene: Scene, read: Read) -> Layout:
    """Raises VolumeError, SceneError."""
    return deterministic.lay_out(scene, read, "emission_absorption")
