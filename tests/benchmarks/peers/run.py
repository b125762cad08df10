"""Renders a scene by Woodcock and its peers: each in a process of its own that lives on, one at a time, in turns."""

from __future__ import annotations

import json
import math
import os
import select
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from tests.benchmarks.peers.protocol import Image, Skip
from tests.benchmarks.peers.scenes import Case

from woodcock.formats import read_grid
from woodcock.scene import GridEmission, GridVolume, Scene, parse
from woodcock.volume.grid import to_scene

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
#: About how long the rendering of one image may take.
IMAGE_SECONDS = 3.0
#: Images of a renderer, each with a seed of its own.
ROUNDS = 6
#: For those who take longer than this for one sample: so many.
SLOW_SECONDS, SLOW_ROUNDS = 12.0, 3
#: Images at fewer samples, for the curves: parts of the samples of an image, and how many each.
PARTS, PART_ROUNDS = (16, 4), 2
#: Samples of an image where Woodcock takes none.
SAMPLES_WITHOUT_NOISE = 16
MOST_SAMPLES = 1 << 16
FIRST_SEED = 2
#: Longest wait for an answer.
ANSWER_SECONDS = 600.0
NOT_INSTALLED = "not installed: make peers"


@dataclass(frozen=True)
class Adapter:
    """peer: what goals are set against; module: what its interpreter must have."""

    peer: str
    script: str
    arguments: tuple[str, ...] = ()
    module: str | None = None

    def python(self) -> str:
        """The interpreter. Raises Skip where the peer is not installed."""
        if self.module is None:
            return sys.executable
        python = os.environ.get("WOODCOCK_PEERS") or str(ROOT / ".venv-peers" / "bin" / "python")
        found = "import importlib.util, sys; sys.exit(importlib.util.find_spec(sys.argv[1]) is None)"
        try:
            there = subprocess.run([python, "-c", found, self.module], capture_output=True, check=False).returncode == 0
        except OSError:
            there = False
        if not there:
            raise Skip(NOT_INSTALLED)
        return python


OURS = Adapter("Woodcock", "woodcock_side.py")
#: pbrt is a program, and its adapter says itself where that is missing.
PEERS = (
    Adapter("Mitsuba 3 scalar", "mitsuba_side.py", ("scalar_rgb",), "mitsuba"),
    Adapter("Mitsuba 3 LLVM", "mitsuba_side.py", ("llvm_ad_rgb",), "mitsuba"),
    Adapter("Mitsuba 3 LLVM, tuned", "mitsuba_side.py", ("llvm_ad_rgb", "tuned"), "mitsuba"),
    Adapter("Cycles", "cycles_side.py", (), "bpy"),
    Adapter("pbrt-v4", "pbrt_side.py"),
    Adapter("LuxCore", "luxcore_side.py", (), "pyluxcore"),
)


class PeerError(RuntimeError):
    """A peer that failed; one sentence."""


@dataclass
class Shots:
    """What one renderer made of a scene. images: (rounds, height, width, 3), of `samples` each, rendered in `seconds`;
    parts: the same at fewer samples; described: what its adapter says of it; skipped: why it made none; failed: was
    that a fault?
    """

    adapter: Adapter
    described: dict[str, Any] = field(default_factory=dict)
    skipped: str | None = None
    failed: bool = False
    samples: int = 0
    rounds: int = ROUNDS
    images: list[Image] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    parts: dict[int, tuple[list[Image], list[float]]] = field(default_factory=dict)


class Peer:
    """An adapter at work in a folder. Raises Skip where it cannot do this scene, PeerError where it fails."""

    def __init__(self, adapter: Adapter, folder: Path) -> None:
        self.folder, self.name = folder, adapter.peer
        log = folder / f"{adapter.peer.replace(' ', '-')}.log"
        command = [adapter.python(), str(HERE / adapter.script), str(folder), *adapter.arguments]
        with log.open("wb") as said:
            self._process = subprocess.Popen(
                command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said
            )
        try:
            self.described = self._answer()
            if "skip" in self.described:
                raise Skip(self.described["skip"])
        except Exception:
            self.close()
            raise

    def render(self, samples: int, seed: int) -> tuple[Image, float]:
        """(height, width, 3) and the seconds that it took."""
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # if it has ended, the answer says so
            self._process.stdin.write(json.dumps({"samples": samples, "seed": seed}).encode() + b"\n")
            self._process.stdin.flush()
        answer = self._answer()
        return np.load(self.folder / answer["image"]), answer["seconds"]

    def close(self) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()

    def _answer(self) -> dict[str, Any]:
        stream = self._process.stdout
        assert stream is not None
        if not select.select([stream], [], [], ANSWER_SECONDS)[0]:
            self._process.kill()
            raise PeerError(f"{self.name}: no answer within {ANSWER_SECONDS:.0f} s")
        if not (line := stream.readline()):
            raise PeerError(f"{self.name}: ended by itself with {self._process.wait()}")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise PeerError(f"{self.name}: {answer['error']}")
        return answer


def prepare(case: Case, folder: Path) -> Scene:
    """Writes the scene, its files and peer.json into the folder."""
    scene = parse(json.dumps(case.written(folder)))
    described = {"scene": scene.model_dump(mode="json"), "grids": grids(scene, folder)}
    (folder / "peer.json").write_text(json.dumps(described))
    return scene


def grids(scene: Scene, folder: Path) -> dict[str, dict[str, Any]]:
    """The grids of a scene as peers read them, by file; as Woodcock's own reader has them."""
    found: dict[str, dict[str, Any]] = {}
    for volume in scene.volumes:
        if not isinstance(volume, GridVolume):
            continue
        emission = [volume.emission] if isinstance(volume.emission, GridEmission) else []
        for source in (volume, *emission):
            grid = read_grid(folder / source.file, source.grid)
            values = f"{source.file}.float.npy"
            np.save(folder / values, grid.values.astype(np.float32))
            placed = to_scene(volume, grid) @ np.diag([*grid.values.shape[2::-1], 1.0])
            found[source.file] = {"values": values, "to_scene": placed.tolist()}
    return found


def shoot(case: Case, folder: Path, ours: Adapter = OURS, peers: Sequence[Adapter] = PEERS) -> list[Shots]:
    """Renders a case by all of them, ours first. A peer that fails is left out; raises PeerError where ours does."""
    prepare(case, folder)
    racing: list[tuple[Peer, Shots]] = []
    made = [Shots(adapter) for adapter in (ours, *peers)]

    def each(what: Callable[[Peer, Shots], None]) -> None:
        for peer, shots in list(racing):
            try:
                what(peer, shots)
            except PeerError as error:
                if shots is made[0]:
                    raise
                shots.skipped, shots.failed = f"failed: {error}", True
                racing.remove((peer, shots))
                peer.close()

    try:
        for shots in made:
            try:
                peer = Peer(shots.adapter, folder)
            except Skip as skip:
                shots.skipped = str(skip)
            except PeerError as error:
                if shots is made[0]:
                    raise
                shots.skipped, shots.failed = f"failed: {error}", True
            else:
                shots.described = peer.described
                racing.append((peer, shots))
        without_noise = made[0].described["deterministic"]
        each(partial(_measure, without_noise=without_noise))
        for turn in range(ROUNDS):
            each(partial(_take, turn=turn))
        for turn in range(PART_ROUNDS):
            each(partial(_take_parts, turn=turn))
    finally:
        for peer, _ in racing:
            peer.close()
    return made


def _measure(peer: Peer, shots: Shots, without_noise: bool) -> None:
    """How many samples, and how many rounds."""
    if without_noise:
        shots.samples = 1 if peer.described.get("deterministic") else SAMPLES_WITHOUT_NOISE
        return
    shots.samples, seconds = pilot(peer)
    shots.rounds = SLOW_ROUNDS if seconds > SLOW_SECONDS else ROUNDS


def _take(peer: Peer, shots: Shots, turn: int) -> None:
    if turn < shots.rounds:
        image, seconds = peer.render(shots.samples, FIRST_SEED + turn)
        shots.images.append(image)
        shots.seconds.append(seconds)


def _take_parts(peer: Peer, shots: Shots, turn: int) -> None:
    for number, samples in enumerate(parts_of(shots.samples), 1):
        image, seconds = peer.render(samples, FIRST_SEED + ROUNDS * number + turn)
        images, times = shots.parts.setdefault(samples, ([], []))
        images.append(image)
        times.append(seconds)


def parts_of(samples: int) -> list[int]:
    """The fewer samples of the curves, each once."""
    return sorted({max(1, samples // part) for part in PARTS} - {samples})


def pilot(peer: Peer) -> tuple[int, float]:
    """Samples that take about IMAGE_SECONDS, a power of two, which suits sequences; and the seconds of the last image
    that told so."""
    samples = 1
    while True:
        _, seconds = peer.render(samples, 1)
        if seconds > IMAGE_SECONDS / 12 or samples >= MOST_SAMPLES:
            break
        samples *= 4
    fitting = samples * IMAGE_SECONDS / max(seconds, 1e-6)
    return min(MOST_SAMPLES, max(1, 2 ** round(math.log2(fitting)))), seconds
