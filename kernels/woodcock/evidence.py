"""What a device can say for a picture that it rendered: gathered once the picture is done, for its certificate."""

from __future__ import annotations

from typing import TypedDict

from woodcock.checks import Check, checked
from woodcock.drift import Drift
from woodcock.generic import Gain, measure_gain
from woodcock.program import OPTIONS
from woodcock.render import Renderer, read_file
from woodcock.scene import Scene


class Evidence(TypedDict):
    """options: of the compiler; drift: of the picture's own numbers, None where there is none to measure; checks: of
    the program on the device; gain: of leaving out what the scene does not need, None where it cannot be measured.
    """

    options: list[str]
    drift: Drift | None
    checks: list[Check]
    gain: Gain | None


def gather(renderer: Renderer, scene: Scene) -> Evidence:
    """renderer: of the scene. Raises DeviceError, and what reading the scene's files raises."""
    return {
        "options": list(OPTIONS),
        "drift": renderer.drift(),
        "checks": checked(scene, renderer.device, renderer.program_hash, read_file, full=renderer.full),
        "gain": measure_gain(renderer, scene),
    }
