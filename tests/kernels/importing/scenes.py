"""Scenes of other renderers in short."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def mitsuba(body: str, sensor: str = '<sensor type="perspective"/>') -> str:
    """A Mitsuba scene whose body begins on line 2; its camera stands in the origin and looks along +z."""
    return f'<scene version="3.0.0">{sensor}<integrator type="volpath"/>\n{body}\n</scene>\n'


def pbrt(body: str, options: str = 'Camera "perspective"') -> str:
    """A pbrt scene whose body begins on line 2, with nothing to note by itself but paths' lengths and the filter."""
    quiet = 'PixelFilter "box" Integrator "volpath" "integer maxdepth" 5 '
    return f"{quiet}{options} WorldBegin\n{body}\n"


#: What every scene of pbrt has to be told.
DEPTH = "scene.pbrt:1: paths have any length here; pbrt's end after 5 scatterings: it is darker"


def filled(medium: str, shape: str = 'Shape "sphere"') -> str:
    """A shape of pbrt's that holds a medium; the shape stands on line 3."""
    return f'MakeNamedMedium "m" {medium}\nMaterial "interface" MediumInterface "m" "" {shape}'


def read(imported: Callable[..., Any], body: str, options: str = 'Camera "perspective"') -> tuple[Any, list[str]]:
    """A scene of pbrt's, and what it loses beside the length of paths."""
    scene, notes = imported(pbrt(body, options), "scene.pbrt")
    assert DEPTH in notes
    return scene, [note for note in notes if note != DEPTH]
