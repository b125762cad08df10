"""What there is to render on: identity and limits. All quirks of OpenCL platforms live here and in probe.py."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import platformdirs

from woodcock.pocl import correct_processor

#: In the name of PoCL's platform.
IS_POCL = "Portable Computing Language"

#: Lane widths that the device code has.
WIDTHS = (1, 4, 8, 16)

#: PoCL names the processor that its LLVM generates code for in the device's version. An LLVM older than the processor
#: takes it for the one before, while PoCL picks its library of builtins by the AVX-512 flag: then every builtin is a
#: call that spills all registers, and one of 16 lanes kills the compiler.
_MISTAKEN_AVX512 = re.compile(r"-znver[123]\b|-(haswell|broadwell|skylake|alderlake|x86-64(-v[123])?)$")
#: So programs say themselves what the library was built for.
_FOR_AVX512 = """\
#pragma clang attribute push(__attribute__((target("arch=skylake-avx512"))), apply_to = function)
{}
#pragma clang attribute pop
"""


class DeviceError(RuntimeError):
    """No device can do the work; the text says what is missing and what to install."""


@dataclass(frozen=True)
class Device:
    """An OpenCL device. memory and max_allocation are bytes; native_lanes is what the driver says, not what works;
    doubles: has it double precision?"""

    id: str
    name: str
    kind: str
    platform: str
    platform_version: str
    version: str
    driver: str
    compute_units: int
    memory: int
    max_allocation: int
    native_lanes: int
    doubles: bool

    @property
    def identity(self) -> str:
        """What a program built for this device depends on."""
        return "|".join((self.platform, self.platform_version, self.name, self.version, self.driver))

    @property
    def mistaken(self) -> bool:
        """Does PoCL take the processor for an older one, without AVX-512?"""
        return self.native_lanes == 16 and _MISTAKEN_AVX512.search(self.version) is not None


@cache
def cache_folder() -> Path:
    """A writable folder for compiled kernels and device checks: the user's cache, or a private temporary one.

    PoCL aborts the process when it cannot write its cache, so it is told to use this one.
    """
    folder = platformdirs.user_cache_path("woodcock")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        folder = Path(tempfile.gettempdir()) / f"woodcock-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
    return folder


@cache
def opencl() -> ModuleType:
    """pyopencl, with the caches set up. Raises DeviceError where it is not installed."""
    kernels = cache_folder() / "pocl"
    if "POCL_CACHE_DIR" not in os.environ:
        kernels.mkdir(exist_ok=True)
        os.environ["POCL_CACHE_DIR"] = str(kernels)
    # Programs are kept by PoCL and by drivers; a second copy in pyopencl's own cache would only go stale.
    os.environ.setdefault("PYOPENCL_NO_CACHE", "1")
    try:
        import pyopencl
    except ImportError as error:
        raise DeviceError(f"pyopencl is missing ({error}): pip install 'woodcock[render,pocl]'") from None
    return pyopencl


@cache
def _found() -> dict[str, tuple[Device, Any]]:
    cl = opencl()
    try:
        platforms = cl.get_platforms()
    except cl.Error:
        platforms = []
    found: dict[str, tuple[Device, Any]] = {}
    counts: dict[str, int] = {}
    for platform in platforms:
        try:
            handles = platform.get_devices()
        except cl.Error:
            continue
        for handle in handles:
            kind = {cl.device_type.GPU: "gpu", cl.device_type.ACCELERATOR: "accelerator"}.get(
                handle.type & ~cl.device_type.DEFAULT, "cpu"
            )
            number = counts.get(kind, 0)
            counts[kind] = number + 1
            named = correct_processor(handle) if IS_POCL in platform.name else None
            device = Device(
                id=f"{kind}{number}",
                name=handle.name.strip(),
                kind=kind,
                platform=platform.name.strip(),
                platform_version=platform.version.strip(),
                version=handle.version.strip() + (f", compiles for {named}" if named else ""),
                driver=handle.driver_version.strip(),
                compute_units=handle.max_compute_units,
                memory=handle.global_mem_size,
                max_allocation=handle.max_mem_alloc_size,
                native_lanes=handle.native_vector_width_float,
                doubles=handle.double_fp_config != 0,
            )
            found[device.id] = (device, handle)
    return found


def devices() -> tuple[Device, ...]:
    """All OpenCL devices, in the platforms' order. Raises DeviceError if there is none."""
    found = tuple(device for device, _ in _found().values())
    if not found:
        raise DeviceError(
            "no OpenCL platform was found: pip install 'woodcock[pocl]' for the processor (x86-64), "
            "or apt install pocl-opencl-icd, or the OpenCL driver of your GPU"
        )
    return found


def find(device_id: str | None = None) -> Device:
    """The device with that id, by default the first. Raises DeviceError that names the known ids."""
    known = {device.id: device for device in devices()}
    if device_id is None:
        return next(iter(known.values()))
    if device_id not in known:
        raise DeviceError(f"there is no device {device_id!r}; there are {', '.join(known)}")
    return known[device_id]


def check_toolchain(device: Device) -> None:
    """PoCL links every kernel with the system's linker, and aborts the process without one; say so before it does."""
    if IS_POCL not in device.platform:
        return
    if not shutil.which("ld"):
        raise DeviceError("PoCL needs a linker and found no `ld`: apt install gcc libc6-dev")


@dataclass(frozen=True)
class Context:
    """An OpenCL context and queue on one device."""

    device: Device
    context: Any
    queue: Any

    @classmethod
    def on(cls, device: Device) -> Context:
        check_toolchain(device)
        cl = opencl()
        context = cl.Context([_found()[device.id][1]])
        return cls(device, context, cl.CommandQueue(context))

    def build(self, text: str, options: tuple[str, ...], kernel: str) -> Any:
        """A kernel of the program that is built from the text. Raises DeviceError with the compiler's log."""
        cl = opencl()
        if "NVIDIA" in self.device.platform:  # Changes no code; the log then tells the registers that it uses.
            options = (*options, "-cl-nv-verbose")
        if self.device.mistaken:
            text = _FOR_AVX512.format(text)
        with warnings.catch_warnings():
            # The log of a program that builds is the driver's chatter.
            warnings.simplefilter("ignore", cl.CompilerWarning)
            try:
                return cl.Kernel(cl.Program(self.context, text).build(options=list(options)), kernel)
            except cl.Error as error:
                raise DeviceError(f"{self.device.id} ({self.device.name}) cannot build the program: {error}") from None

    def upload(self, array: Any) -> Any:
        """A read-only buffer of an array, or of the pieces that make one, each copied as it comes.

        Raises DeviceError for one that is larger than the device takes.
        """
        cl = opencl()
        if array.nbytes > self.device.max_allocation:
            raise DeviceError(
                f"{self.device.id} ({self.device.name}) takes {self.device.max_allocation >> 20} MiB in one piece; "
                f"the volume needs {array.nbytes >> 20} MiB"
            )
        flags = cl.mem_flags
        if not hasattr(array, "pieces"):
            return cl.Buffer(self.context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=array)
        buffer, offset = cl.Buffer(self.context, flags.READ_ONLY, array.nbytes), 0
        for piece in array.pieces():
            cl.enqueue_copy(self.queue, buffer, piece, dst_offset=offset)
            offset += piece.nbytes
        return buffer

    def output(self, array: Any) -> Any:
        """A buffer that starts as a copy of the array: fresh device memory holds old data."""
        cl = opencl()
        flags = cl.mem_flags
        return cl.Buffer(self.context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=array)

    def download(self, array: Any, buffer: Any) -> None:
        """Waits for the queue and copies the buffer into the array."""
        opencl().enqueue_copy(self.queue, array, buffer)
