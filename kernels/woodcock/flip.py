"""HDR-ꟻLIP by NVIDIA's flip-evaluator, which holds Python's lock for as long as it computes: where that is long, in a
process of its own, so that whoever asks can answer others and keep its leases meanwhile.

`python -m woodcock.flip HEIGHT WIDTH EXPOSURES` reads two pictures from stdin and writes the errors to stdout, all
float32 as this machine has them.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from woodcock.space import Array

try:
    import flip_evaluator
except ImportError:  # it has wheels for some platforms only
    flip_evaluator = None

#: Seconds from which on it is not computed in this process, by the estimate that is given; a process takes as long.
SHORT = 0.2
#: It is killed after so many times what was estimated, and this many seconds at least.
PATIENCE, LEAST_PATIENCE = 10.0, 60.0


def errors(pictures: Sequence[Array], exposures: Mapping[str, float], seconds: float) -> Array | None:
    """Of every pixel, (height, width, 1).

    pictures: the reference and what is held against it, (height, width, 3) each, radiance; exposures: as
    flip-evaluator names them; seconds: how long that may take, roughly. None where it is not installed, or its process
    ended without an answer.
    """
    if flip_evaluator is None:
        return None
    images = [np.ascontiguousarray(one, np.float32) for one in pictures]
    if seconds < SHORT:
        return _evaluated(images, exposures)
    height, width = images[0].shape[:2]
    try:
        done = subprocess.run(
            [sys.executable, "-m", __name__, str(height), str(width), json.dumps(dict(exposures))],
            input=b"".join(one.tobytes() for one in images),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1"},  # the processors are the renders'
            start_new_session=True,
            timeout=max(PATIENCE * seconds, LEAST_PATIENCE),
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None
    if len(done.stdout) != 4 * height * width:
        return None
    return np.frombuffer(done.stdout, np.float32).reshape(height, width, 1).astype(np.float64)


def _evaluated(images: list[Any], exposures: Mapping[str, float]) -> Array:
    found, _, _ = flip_evaluator.evaluate(*images, "HDR", applyMagma=False, parameters=dict(exposures))
    return np.asarray(found, np.float64)


def _main(height: str, width: str, exposures: str) -> None:
    sent = np.frombuffer(sys.stdin.buffer.read(), np.float32).reshape(2, int(height), int(width), 3).copy()  # writable
    sys.stdout.buffer.write(_evaluated(list(sent), json.loads(exposures)).astype(np.float32).tobytes())


if __name__ == "__main__":
    _main(*sys.argv[1:])
