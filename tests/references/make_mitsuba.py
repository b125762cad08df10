"""Renders the references in mitsuba/ by Mitsuba 3; run by hand, from the root of the project:

    pip install mitsuba OpenImageIO numpy
    python -m tests.references.make_mitsuba [NAME ...]

Every picture is the mean of independent passes with seeds of their own, so that its standard error is measured.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
from tests.references import inputs
from tests.references.case import SIZE, Case
from tests.references.mitsuba_side import Mitsuba
from tests.references.scenes import CASES

PASSES = 64
VARIANT = "scalar_rgb"


def render(case: Case, folder: Path, seed: int) -> np.ndarray:
    """(passes, height, width, 3)"""
    m = Mitsuba(mi, folder)
    integrator = {"type": case.integrator, "max_depth": -1, "rr_depth": 8}
    # What a scene refers to must come before.
    scene = mi.load_dict({"type": "scene", "integrator": integrator, **case.mitsuba(m), "camera": case.camera(m)})
    spp = case.samples // PASSES
    return np.stack([np.array(mi.render(scene, spp=spp, seed=seed + turn)) for turn in range(PASSES)])


def main() -> None:
    mi.set_variant(VARIANT)
    chosen = [case for case in CASES if not sys.argv[1:] or case.name in sys.argv[1:]]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        inputs.write(folder)
        for case in chosen:
            began = time.perf_counter()
            passes = render(case, folder, 1000 * CASES.index(case)).astype(np.float64)
            assert passes.shape == (PASSES, SIZE, SIZE, 3)
            mean, error = passes.mean(axis=0), passes.std(axis=0, ddof=1) / np.sqrt(PASSES)
            layers = {name: mean[..., i].astype(np.float32) for i, name in enumerate("RGB")}
            layers |= {f"error.{name}": error[..., i].astype(np.float32) for i, name in enumerate("RGB")}
            path = Path(__file__).parent / "mitsuba" / f"{case.name}.exr"
            facts = {"samples": str(case.samples), "passes": str(PASSES), "scene": json.dumps(case.scene)}
            inputs.write_picture(path, layers, half="error.", mitsuba=f"{mi.__version__} {VARIANT}", **facts)
            relative = np.sqrt((error**2).mean()) / mean.mean()
            print(f"{case.name}: {relative:.2%} of the mean, {time.perf_counter() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
