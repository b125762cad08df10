"""HDR-FLIP of two pictures in a process of its own: the package holds Python's lock for as long as it computes, and the
service would answer nobody and lose its leases meanwhile.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from woodcock import metrics
from woodcock.compare.rendered import Rendered

#: Seconds that FLIP may take, by `metrics.flip_seconds`; it is killed after twice as many.
MOST_SECONDS = 120.0


class NoFlip(Exception):  # noqa: N818 - it is an answer
    """There is none for these pictures."""


def flip_errors(picture: Path, reference: Path, height: int, width: int) -> NDArray[np.float32]:
    """(height, width, 1) of two EXRs of that size; blocks. Raises NoFlip."""
    command = [sys.executable, "-m", __name__, str(picture), str(reference)]
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1"},  # the processors are the renders'
            start_new_session=True,
            timeout=2 * MOST_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise NoFlip from None
    if len(done.stdout) != 4 * height * width:
        raise NoFlip
    return np.frombuffer(done.stdout, np.float32).reshape(height, width, 1)


def main(picture: str, reference: str) -> None:
    """Write little-endian floats, row by row, or nothing."""
    mine, its = Rendered.load(Path(picture)).mean, Rendered.load(Path(reference)).mean
    if metrics.flip_seconds(its) > MOST_SECONDS:
        return
    errors = metrics.flip_errors(mine, its)
    if errors is not None:
        sys.stdout.buffer.write(errors.astype("<f4").tobytes())


if __name__ == "__main__":
    main(*sys.argv[1:])
