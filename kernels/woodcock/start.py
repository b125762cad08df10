"""A scene on a device without the wait for a compiler: until its own program is built, in a child process, the ready
generic one renders. `python -m woodcock.start DEVICE` is that child.
"""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
import tempfile
import time
import weakref
from contextlib import suppress
from functools import cache
from typing import IO, Literal

from woodcock.child import end_with_parent
from woodcock.device import Device, DeviceError, find
from woodcock.formats import VolumeError
from woodcock.generic import widen
from woodcock.image import ImageError
from woodcock.layout import Layout
from woodcock.markers import WIDE, is_built
from woodcock.plan import lay_out
from woodcock.probe import best_lanes, probe
from woodcock.render import Renderer, program_of, read_file
from woodcock.scene import BoxShape, ConstantVolume, Film, OrthographicCamera, Scene, SceneError, parse

log = logging.getLogger(__name__)

#: The integrator whose programs take seconds to build, on a quiet core 3; all others take about one.
SLOW = "volumetric_path_full"
#: Nobody waits so long for a program.
LONGEST_BUILD_SECONDS = 600.0


class Start:
    """renderer: renders at once; own: by the scene's own program, no longer by the generic one; found: how that began:
    the own program was built before (`cached`), is built now (`built`), or the generic one takes its place (`generic`).

    The two programs use random numbers differently: samples that the generic one rendered are right, but others.
    """

    def __init__(self, scene: Scene, device: Device) -> None:
        """Raises as Renderer does."""
        self._scene, self._device = scene, device
        began = time.perf_counter()
        read = cache(read_file)
        layout = lay_out(scene, read)
        cached = self._is_built(layout)
        self.own = cached or layout.integrator != SLOW
        if not self.own:
            generic = widen(scene, read)
            self.own = not self._is_built(generic)
        if not self.own:
            try:
                self.renderer = Renderer(scene, device, layout=generic)
            except DeviceError as error:  # It takes more memory than the scene's own.
                log.warning("the generic program is not used: %s", error)
                self.own = True
        if self.own:
            self.renderer = Renderer(scene, device, layout=layout)
        self.found: Literal["cached", "built", "generic"] = "cached" if cached else "built" if self.own else "generic"
        self._wanted = None if self.own else layout
        self._build: Build | None = None
        ready = self.renderer.seconds
        ready["read"] = time.perf_counter() - began - ready["build"] - ready["upload"]

    def swap(self) -> bool:
        """Put the scene's own program in, if it is built by now; to be called after each range. Was it put in?

        Its build begins with the first call: the compiler takes no cores from the first range. From then on it may,
        for the generic program takes several times as long, and the sooner it is relieved the better.
        """
        if self._wanted is None:
            return False
        if self._build is None:
            self._build = Build(self._device, self._scene)
        if self._build.running:
            return False
        layout, self._wanted = self._wanted, None
        if fault := self._build.fault():
            log.warning("%s goes on with the generic program: %s", self._device.id, fault)
            return False
        before = self.renderer.seconds
        del self.renderer  # so that the device need not hold both
        try:
            self.renderer = Renderer(self._scene, self._device, layout=layout)
            self.own = True
        except DeviceError as error:
            log.warning("%s goes on with the generic program: %s", self._device.id, error)
            self.renderer = Renderer(self._scene, self._device, full=True)
        for part, seconds in before.items():
            self.renderer.seconds[part] += seconds
        return self.own

    def settled(self) -> Renderer:
        """The scene's own program, waited for. Raises DeviceError where it could not be built."""
        self.swap()
        if self._wanted is not None and self._build is not None:
            self._build.wait(LONGEST_BUILD_SECONDS)
            self.swap()
        if not self.own:
            raise DeviceError(f"{self._device.id} ({self._device.name}) did not build the scene's own program")
        return self.renderer

    def _is_built(self, layout: Layout) -> bool:
        lanes = best_lanes(self._device, probe(self._device))
        film = self._scene.film
        return is_built(self._device, program_of(layout, self._device, lanes)[0], film.width * film.height)


class Build:
    """A program being built in a child process: the scene's, or with None the generic one, at lowest priority.

    The child ends with this process, and no later than this object.
    """

    def __init__(self, device: Device, scene: Scene | None) -> None:
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115 - closed by `_end`
        command = [sys.executable, "-m", "woodcock.start", device.id]
        self._child = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=self._errors, stderr=self._errors, text=True
        )
        self.end = weakref.finalize(self, _end, self._child, self._errors)
        assert self._child.stdin is not None
        with suppress(BrokenPipeError):  # It is dead already, which `fault` tells.
            self._child.stdin.write(("" if scene is None else scene.model_dump_json()) + "\n")
            self._child.stdin.flush()

    @property
    def running(self) -> bool:
        return self._child.poll() is None

    def wait(self, seconds: float) -> None:
        """Until it has ended; it is ended after so many seconds."""
        try:
            self._child.wait(seconds)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()

    def fault(self) -> str | None:
        """Of a build that has ended: what it died or complained of; None if the program is built."""
        code = self._child.returncode
        if code == 0:
            return None
        self._errors.seek(0)
        said = [line.strip() for line in self._errors if line.strip()]
        how = f"ended by {signal.Signals(-code).name}" if code < 0 else f"exit {code}"
        return f"the build failed ({how}): {said[-1] if said else 'no message'}"


def _end(child: subprocess.Popen[str], errors: IO[str]) -> None:
    child.kill()
    child.wait()
    errors.close()
    with suppress(BrokenPipeError):
        child.stdin.close()  # type: ignore[union-attr]


def prepare(device: Device) -> None:
    """Build the generic program, in every form that a picture's size may ask for. Raises DeviceError."""
    box = ConstantVolume(shape=BoxShape(min=(0.0, 0.0, 0.0), max=(1.0, 1.0, 1.0)), sigma_t=1.0, albedo=0.5)
    camera = OrthographicCamera(origin=(0.5, 0.5, 2.0), target=(0.5, 0.5, 0.5), height=1.0)
    lanes = best_lanes(device, probe(device))
    for width, height in ((1, 1), (1024, WIDE * lanes // 1024)):
        scene = Scene(camera=camera, volumes=(box,), film=Film(width=width, height=height))
        layout = widen(scene, read_file)
        if not is_built(device, program_of(layout, device, lanes)[0], width * height):
            Renderer(scene, device, layout=layout)


def _serve(device_id: str) -> None:
    """The child: builds the program of the scene in the first line of stdin, or if that is empty the generic one."""
    line = sys.stdin.readline()
    end_with_parent()
    try:
        device = find(device_id)
        if line.strip():
            Renderer(parse(line), device)
        else:
            os.nice(19)
            prepare(device)
    except (DeviceError, SceneError, VolumeError, ImageError) as error:
        sys.exit(str(error).splitlines()[0])


if __name__ == "__main__":
    _serve(sys.argv[1])
