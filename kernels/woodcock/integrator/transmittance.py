"""Lays out a scene whose media absorb, L = exp(-∫σ_t) L_e: without random numbers."""

from __future__ import annotations

from woodcock.integrator import deterministic
from woodcock.layout import Layout, Read
from woodcock.scene import Scene


def lay_out(scene: Scene, read: Read) -> Layout:
    """Raises VolumeError, SceneError."""
    return deterministic.lay_out(scene, read, "transmittance")
