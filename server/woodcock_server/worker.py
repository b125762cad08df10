"""What runs in a worker process: one process a device, so a driver that aborts takes nothing else with it."""

from __future__ import annotations

import logging
import signal
import time
from collections.abc import Callable
from functools import lru_cache, wraps
from typing import ParamSpec, TypeVar

from woodcock import device as opencl
from woodcock import stability
from woodcock.device import DeviceError
from woodcock.evidence import Evidence, gather
from woodcock.film import Film
from woodcock.formats import VolumeError
from woodcock.image import ImageError
from woodcock.render import Renderer
from woodcock.report import Facts
from woodcock.scene import SceneError, parse

P = ParamSpec("P")
T = TypeVar("T")


def dask_setup(_worker: object) -> None:
    """Run by Dask in a worker's process, before it takes work."""
    # Ctrl-C reaches every process of a terminal, but it is the service that stops its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What goes wrong comes back as an exception; what Dask says here is of connections that close when all is closed.
    for name in ("distributed", "distributed.worker"):
        logging.getLogger(name).setLevel(logging.CRITICAL)


@lru_cache(maxsize=2)
def _renderer(scene: str, device_id: str) -> Renderer:
    """The scene made ready; two are kept, so that one job's end and the next one's start do not push each other out."""
    return Renderer(parse(scene), opencl.find(device_id))


def _faults_alone(function: Callable[P, T]) -> Callable[P, T]:
    """Raise a fault without what it was caused by: a driver's error cannot be sent to another process."""

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return function(*args, **kwargs)
        except (SceneError, VolumeError, ImageError, DeviceError) as error:
            fault: Exception = type(error)(str(error))
        except Exception as error:
            fault = RuntimeError(f"{type(error).__name__}: {error}")
        raise fault

    return call


@_faults_alone
def prepare(scene: str, device_id: str) -> Facts:
    """Make a scene (JSON; its files are paths) ready on a device; returns what the report says of the two.

    Raises SceneError, VolumeError, ImageError or DeviceError if it cannot be rendered there.
    """
    return _renderer(scene, device_id).facts()


@_faults_alone
def render_range(scene: str, device_id: str, start: int, stop: int) -> tuple[Film, float]:
    """Samples [start, stop) of every pixel, and the seconds that rendering them took. Raises as `prepare` does."""
    renderer = _renderer(scene, device_id)
    began = time.perf_counter()
    film = renderer.render(start, stop)
    return film, time.perf_counter() - began


@_faults_alone
def check_stability(device_id: str) -> stability.Outcome:
    """Check a device by stiff and extreme scenes, rendered in child processes; takes minutes. Raises DeviceError."""
    return stability.check(opencl.find(device_id))


@_faults_alone
def certify(scene: str, device_id: str) -> Evidence:
    """What the device can say for a picture of the scene. Raises as `prepare` does."""
    return gather(_renderer(scene, device_id), parse(scene))
