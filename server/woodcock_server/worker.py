"""What runs in a worker process: one process a device, so a driver that aborts takes nothing else with it."""

from __future__ import annotations

import json
import logging
import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache, wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
from distributed import get_worker
from numpy.typing import NDArray

from woodcock import device as opencl
from woodcock import stability
from woodcock.device import Device, DeviceError
from woodcock.evidence import Evidence, gather
from woodcock.film import Film
from woodcock.formats import VolumeError
from woodcock.image import ImageError
from woodcock.layout import Layout
from woodcock.leanness import parts
from woodcock.markers import is_built
from woodcock.plan import lay_out
from woodcock.predict import Memory, Prediction, memory, predict
from woodcock.probe import best_lanes, probe
from woodcock.render import Renderer, program_of, read_file
from woodcock.report import Facts
from woodcock.scene import Scene, SceneError, parse, with_files
from woodcock.start import Start
from woodcock_server import logs
from woodcock_server.config import Settings
from woodcock_server.farm.cache import Cache, Held, NoRoomError
from woodcock_server.farm.files import Peer
from woodcock_server.steady import keep_time
from woodcock_server.storage import StoreAway

P = ParamSpec("P")
T = TypeVar("T")


#: Variable of a worker host: what its scheduler is told of the host's devices, JSON.
FOUND = "WOODCOCK_FOUND"


def dask_setup(worker: Any) -> None:
    """Run by Dask in a worker's process, before it takes work."""
    keep_time()
    logs.configure(Settings().log_format)
    if found := os.environ.get(FOUND):
        worker.startup_information["woodcock"] = lambda _: json.loads(found)
    # Ctrl-C reaches every process of a terminal, but it is the service that stops its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What goes wrong comes back as an exception; what Dask says here is of connections that close when all is closed.
    for name in ("distributed", "distributed.worker"):
        logging.getLogger(name).setLevel(logging.CRITICAL)


def _find(device_id: str) -> Device:
    """A device of this machine, by the id that it may have among others: `gpu0@node7`. Raises DeviceError."""
    return opencl.find(device_id.partition("@")[0])


@cache
def _cache() -> Cache:
    settings = Settings()
    return Cache(settings.cache, settings.cache_size)


@dataclass(frozen=True)
class _Described:
    """A scene whose files are here, for as long as this object is."""

    scene: Scene
    held: tuple[Held, ...]


def _described(scene: str) -> _Described:
    """Fetches the files that a service has, `tls://HOST:PORT/sha256:…`. Raises SceneError, VolumeError, DeviceError or
    StoreAway."""
    held = []

    def here(file: str) -> str:
        if not file.startswith("tls://"):
            return file
        address, _, file_id = file.rpartition("/")
        try:
            held.append(_cache().fetch(file_id, Peer(address, get_worker().security)))
        except OSError as error:
            raise DeviceError(f"{file_id} was not fetched: {error}") from None
        return str(held[-1].path)

    return _Described(with_files(parse(scene), here), tuple(held))


@dataclass(frozen=True)
class _Ready:
    start: Start
    described: _Described


@lru_cache(maxsize=2)
def _ready(scene: str, device_id: str) -> _Ready:
    """The scene made ready; two are kept, so that one job's end and the next one's start do not push each other out."""
    described = _described(scene)
    return _Ready(Start(described.scene, _find(device_id)), described)


def _start(scene: str, device_id: str) -> Start:
    try:
        return _ready(scene, device_id).start
    except NoRoomError:  # Scenes of before may hold files.
        _ready.cache_clear()
        return _ready(scene, device_id).start


def _faults_alone(function: Callable[P, T]) -> Callable[P, T]:
    """Raise a fault without what it was caused by: a driver's error cannot be sent to another process."""

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return function(*args, **kwargs)
        except (SceneError, VolumeError, ImageError, DeviceError, StoreAway) as error:
            fault: Exception = type(error)(_cache().by_id(str(error)))
        except Exception as error:
            fault = RuntimeError(f"{type(error).__name__}: {error}")
        raise fault

    return call


@_faults_alone
def load(device_id: str) -> None:
    """Load the driver, so that the first job need not. Raises DeviceError."""
    _find(device_id)


@_faults_alone
def prepare(scene: str, device_id: str, own: bool) -> tuple[Facts, str]:
    """Make a scene (JSON; its files are paths) ready on a device; returns what the report says of the two, and how its
    program was found (`Start.found`).

    own: wait for the scene's own program, where a generic one could begin.

    Raises SceneError, VolumeError, ImageError or DeviceError if it cannot be rendered there.
    """
    ready = _start(scene, device_id)
    return (ready.settled() if own else ready.renderer).facts(), ready.found


@_faults_alone
def render_range(
    scene: str, device_id: str, start: int, stop: int, pixels: NDArray[np.int32] | None
) -> tuple[Film, float, str]:
    """Samples [start, stop) of pixels, the seconds that rendering them took, and the hash of the program that did.

    pixels: indices y × width + x; None for all. Raises as `prepare` does.
    """
    ready = _start(scene, device_id)
    program, began = ready.renderer.program_hash, time.perf_counter()
    film = ready.renderer.render(start, stop, pixels)
    seconds = time.perf_counter() - began
    ready.swap()
    return film, seconds, program


@_faults_alone
def check_stability(device_id: str) -> stability.Outcome:
    """Check a device by stiff and extreme scenes, rendered in child processes; takes minutes. Raises DeviceError."""
    return stability.check(_find(device_id))


@_faults_alone
def certify(scene: str, device_id: str) -> tuple[Facts, Evidence]:
    """What the device can say for a picture of the scene, by the scene's own program. Raises as `prepare` does."""
    renderer = _start(scene, device_id).settled()
    return renderer.facts(), gather(renderer, _ready(scene, device_id).described.scene)


@dataclass(frozen=True)
class Survey:
    """What a scene would compile and hold on a device. program: hash, kinds, lanes, source_lines, built, remained and
    left_out; read_seconds: of reading its files."""

    program: dict[str, Any]
    memory: Memory
    read_seconds: float


@_faults_alone
def survey(scene: str, device_id: str) -> Survey:
    """Lay a scene out for a device; nothing is built. Raises SceneError, VolumeError or ImageError."""
    began = time.perf_counter()
    held, device = _described(scene), _find(device_id)
    described = held.scene
    layout = lay_out(described, read_file)
    program, precise = program_of(layout, device, best_lanes(device, probe(device)))
    width, height = described.film.width, described.film.height
    _surveyed.clear()
    _surveyed[scene, device_id] = layout
    remained, left_out = parts(program)
    told = {
        "hash": program.hash,
        "kinds": {concept: list(kinds) for concept, kinds in layout.kinds.items()},
        "lanes": program.lanes,
        "source_lines": sum(remained.values()),
        "built": is_built(device, program, width * height),
        "remained": remained,
        "left_out": left_out,
    }
    needed = memory(layout, width, height, len(layout.names), program.lanes, precise=precise)
    return Survey(told, needed, time.perf_counter() - began)


#: The scene that was surveyed last, laid out, until it is forecast or another one is surveyed.
_surveyed: dict[tuple[str, str], Layout] = {}


@_faults_alone
def forecast(scene: str, device_id: str) -> tuple[float, Prediction]:
    """Seconds of building a scene's program and of its upload, and the prediction of its rendering. Raises as `prepare`
    does."""
    held, device = _described(scene), _find(device_id)
    described = held.scene
    renderer = Renderer(described, device, layout=_surveyed.pop((scene, device_id), None))
    return renderer.seconds["build"] + renderer.seconds["upload"], predict(renderer, described)
