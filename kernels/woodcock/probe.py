"""Is a device to be trusted, and at which lane widths? Asked in a child process, because a driver that cannot build a
program may take the process with it: PoCL's builtins of a width that its code generator lacks do so.
"""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
import sys
from dataclasses import asdict, dataclass

import numpy as np

from woodcock import __version__
from woodcock.child import end_with_parent, lifeline
from woodcock.device import WIDTHS, Context, Device, DeviceError, cache_folder, check_toolchain, find
from woodcock.evaluate import evaluate
from woodcock.files import replacing

TIMEOUT_SECONDS = 30

#: What PoCL says before it aborts on a machine with a linker but without a compiler's or the C library's files.
UNLINKED = re.compile(r"cannot find -l(\w+)")


@dataclass(frozen=True)
class Probe:
    """lanes: widths that work, ascending, none where the device cannot be used; fault: why not."""

    lanes: tuple[int, ...]
    fault: str | None


def probe(device: Device) -> Probe:
    """Checks a device in child processes, one a width; what is found is kept on disk by device and driver."""
    try:
        check_toolchain(device)
    except DeviceError as error:
        return Probe((), str(error))
    key = hashlib.sha256(f"{device.identity}|{__version__}".encode()).hexdigest()
    kept = cache_folder() / "probes" / f"{key[:32]}.json"
    try:
        stored = json.loads(kept.read_text())
        return Probe(tuple(stored["lanes"]), stored["fault"])
    except (OSError, ValueError, KeyError):
        pass
    faults = {width: _fault(device, width) for width in WIDTHS if width == 1 or device.kind != "gpu"}
    lanes = tuple(width for width, fault in faults.items() if fault is None)
    result = Probe(lanes, None if lanes else f"{device.id} ({device.name}): {faults[1]}")
    if lanes:  # A fault may be mended without a new driver; it is looked at afresh.
        kept.parent.mkdir(exist_ok=True)
        with replacing(kept) as temporary:
            temporary.write_text(json.dumps(asdict(result)))
    return result


def best_lanes(device: Device, result: Probe) -> int:
    """The widest width that works and that the device has registers for. Raises DeviceError where none works."""
    if not result.lanes:
        raise DeviceError(result.fault or f"{device.id} cannot be used")
    return max(width for width in result.lanes if width <= max(1, device.native_lanes))


def _fault(device: Device, lanes: int) -> str | None:
    """What a child process that checks one width died or complained of."""
    if lanes == 16 and device.mistaken:
        return f"{device.platform} knows no AVX-512 for this processor, but uses a library built for it"
    command = [sys.executable, "-m", "woodcock.probe", device.id, str(lanes)]
    try:
        with lifeline() as stdin:
            done = subprocess.run(
                command, stdin=stdin, capture_output=True, text=True, timeout=TIMEOUT_SECONDS, check=False
            )
    except subprocess.TimeoutExpired:
        return f"the check of {lanes} lanes did not end within {TIMEOUT_SECONDS} s"
    if done.returncode == 0:
        return None
    if missing := UNLINKED.search(done.stderr):
        return f"PoCL cannot link kernels, for `ld` does not find lib{missing[1]}: apt install gcc libc6-dev"
    said = [line for line in done.stderr.splitlines() if line.strip()]
    return f"the check of {lanes} lanes failed (exit {done.returncode}): {said[-1] if said else 'no message'}"


def check(device: Device, lanes: int) -> None:
    """The builtins that kernels rely on, against numpy. Raises DeviceError."""
    x = np.linspace(0.01, 3.99, 64, dtype=np.float32)
    expected = {
        "fma(x, x, -x)": x.astype(float) ** 2 - x,
        "log(x)": np.log(x),
        "exp(-x)": np.exp(-x),
        "sqrt(x)": np.sqrt(x),
        "floor(x)": np.floor(x),
        "1.f / x": 1 / x,
        "fmin(x, fmax((real)1.f, copysign(x, -x)))": np.minimum(x, 1),
        "pick((real)0.f, x, test(x > 1.f) & ~test(x > 2.f))": np.where((x > 1) & (x <= 2), x, 0),
        "to_real(clamp(to_integer(x), 1, 2))": np.clip(np.floor(x), 1, 2),
        "gather(float, x_ + i, lane_index())": x,
        "some(test(x > 3.9f)) ? (real)1.f : (real)0.f": (x.reshape(-1, lanes) > 3.9).any(1).repeat(lanes),
        "word_as_real(to_word(x * 0x1p28f))": (x * 2**28).astype(np.uint32).view(np.float32),
    }
    context = Context.on(device)
    for (expression, right), got in zip(
        expected.items(), evaluate(context, list(expected), {"x": x}, lanes=lanes), strict=True
    ):
        if not np.allclose(got, right, rtol=2e-6, atol=1e-6):
            raise DeviceError(f"{expression} is wrong on {device.name}: off by up to {np.abs(got - right).max():g}")


if __name__ == "__main__":
    end_with_parent()
    try:
        check(find(sys.argv[1]), int(sys.argv[2]))
    except DeviceError as error:
        sys.exit(str(error))
