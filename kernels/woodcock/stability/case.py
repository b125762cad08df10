"""What a case is: a scene, its exact answer, and how the two are compared."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from woodcock.device import Device, DeviceError
from woodcock.formats import VolumeError
from woodcock.image import ImageError
from woodcock.render import Renderer
from woodcock.scene import SceneError, parse
from woodcock.space import Array
from woodcock.stability import judging
from woodcock.stability.judging import Finding

Description = dict[str, Any]
#: A scene as its JSON's Python; its files go into the folder.
Described = Callable[[Path], Description]
Samples = tuple[int, int]


@dataclass(frozen=True)
class Case:
    """measure: renders on a device, with a folder for its files; random: is its deviation one of chance?"""

    group: str
    name: str
    measure: Callable[[Device, Path], Finding]
    random: bool = False


def renderer(scene: Description, device: Device) -> Renderer:
    return Renderer(parse(json.dumps(scene)), device)


def exactly(
    group: str, name: str, scene: Described, expected: Callable[[], float | Array], light: float = 1.0, stop: int = 1
) -> Case:
    """Solved without random numbers. expected: of all pixels, or (height, width), there of sample 0: the middles of
    pixels; light: the largest radiance of the scene."""

    def measure(device: Device, folder: Path) -> Finding:
        return judging.within_bound(renderer(scene(folder), device).render(0, stop), expected(), light)

    return Case(group, name, measure)


def on_average(
    group: str,
    name: str,
    scene: Described,
    expected: Callable[[], float | Array],
    samples: Samples,
    *,
    spread: float | None = None,
    roundings: float = judging.ROUNDINGS,
    unresolved: str = "",
) -> Case:
    """By random paths: the mean over the picture, of every channel; see `judging.by_chance`.

    unresolved: what float32 may not resolve in the scene. Where the picture is off, the renderer itself must say so: by
    its standard error, or by its comparison with double precision, which the certificate reports, and by how much.
    """

    def measure(device: Device, folder: Path) -> Finding:
        at_work = renderer(scene(folder), device)
        film = at_work.render(*samples)
        if unresolved and (finding := judging.unknown(film, expected(), unresolved)):
            return finding
        finding = judging.by_chance(film, expected(), spread, roundings)
        if finding.verdict == "failed" and unresolved and finding.got is not None:
            return judging.explained(finding, at_work.drift(), unresolved)
        return finding

    return Case(group, name, measure, random=True)


def by_hits(group: str, name: str, scene: Described, chance: Callable[[], float], samples: Samples) -> Case:
    """By random paths of which each is 1 with probability `chance`, else 0."""

    def measure(device: Device, folder: Path) -> Finding:
        return judging.by_hits(renderer(scene(folder), device).render(*samples), chance())

    return Case(group, name, measure, random=True)


def white(
    group: str,
    name: str,
    scene: Described,
    samples: Samples = (0, 4),
    *,
    expected: float = 1.0,
    roundings: float = judging.ROUNDINGS,
) -> Case:
    """By random paths, every sample of which has the same value."""

    def measure(device: Device, folder: Path) -> Finding:
        return judging.everywhere(renderer(scene(folder), device).render(*samples), expected, roundings)

    return Case(group, name, measure)


def inexpressible(group: str, name: str, scene: Described) -> Case:
    """A scene that must be refused, by a sentence that says what cannot be expressed."""

    def measure(device: Device, folder: Path) -> Finding:
        try:
            renderer(scene(folder), device).render(0, 1)
        except (SceneError, VolumeError, ImageError, DeviceError) as error:
            return Finding(verdict="not expressible", says=str(error).splitlines()[0])
        return judging.failed("the scene was taken, though float32 cannot express it")

    return Case(group, name, measure)
