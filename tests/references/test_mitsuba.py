"""Our pictures against those of Mitsuba 3, pixel by pixel, within the noise that both measured."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import t
from tests.references import inputs
from tests.references.case import SIZE, Case
from tests.references.scenes import CASES
from tests.statistics import accept, accept_z, least

from woodcock.device import Device
from woodcock.film import Film
from woodcock.image import read_exr
from woodcock.render import Renderer
from woodcock.scene import parse, with_files

Array = NDArray[np.float64]

#: What is no noise, relative: Mitsuba's rays start up to 2e-4 off surfaces, and its sky has other rows.
SYSTEMATIC = 5e-4
#: A pixel is compared by itself where both know it this well, relative: else its mean is not normal yet.
KNOWN = 0.05
BLOCK = 8
#: Samples that show what is plainly wrong.
FEW = 64

by_name = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("references")
    inputs.write(path)
    return path


def reference(case: Case) -> tuple[Array, Array, int]:
    """Mean and variance of the mean, (height, width, 3), and the number of passes that they are of."""
    layers, header = read_exr(Path(__file__).parent / "mitsuba" / f"{case.name}.exr")
    assert json.loads(header["scene"]) == json.loads(json.dumps(case.scene)), "make the reference again"
    mean, error = (
        np.stack([layers[f"{prefix}{name}"] for name in "RGB"], axis=-1).astype(np.float64) for prefix in ("", "error.")
    )
    return mean, error**2, int(header["passes"])


def rendered(case: Case, folder: Path, device: Device, samples: int) -> Film:
    scene = parse(json.dumps(case.scene | {"film": {"width": SIZE, "height": SIZE}, "seed": 5}))
    return Renderer(with_files(scene, lambda file: str(folder / file)), device).render(0, samples)


def welch(difference: Array, variances: tuple[Array, Array], samples: tuple[int, int]) -> Array:
    """Probability of a difference of means as large as this or larger."""
    total = variances[0] + variances[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = total**2 / sum(v**2 / (n - 1) for v, n in zip(variances, samples, strict=True))
        p = 2 * t.sf(np.abs(difference) / np.sqrt(total), freedom)
    return np.where(total > 0, p, np.where(difference == 0, 1.0, 0.0))


def blocks(picture: Array) -> Array:
    """The means of squares of BLOCK² pixels."""
    return picture.reshape(SIZE // BLOCK, BLOCK, SIZE // BLOCK, BLOCK, -1).mean(axis=(1, 3))


def place(p: Array) -> tuple[int, ...]:
    """Row, column and channel of the smallest."""
    return tuple(int(i) for i in np.unravel_index(p.argmin(), p.shape))


def check(case: Case, film: Film, single: bool) -> None:
    """The picture's mean, its blocks and, if asked for, its pixels.

    None is exact: the reference's errors stay whatever our seed is, and allowances make it conservative.
    """
    expected, noise, passes = reference(case)
    mean, variance = (np.broadcast_to(a, expected.shape) for a in (film.layer("").mean, film.layer("").variance()))
    allowed = SYSTEMATIC * expected + (0 if film.bound is None else film.bound)
    difference = np.sign(mean - expected) * np.maximum(np.abs(mean - expected) - allowed, 0)
    assert film.rejected == film.violations == 0

    error = np.sqrt((variance + noise).sum(axis=(0, 1))) / SIZE**2
    off = np.maximum(np.abs((mean - expected).mean(axis=(0, 1))) - allowed.mean(axis=(0, 1)), 0)
    accept_z(off / error, "the mean is off by", exact=False)

    scale = BLOCK**2
    shift = blocks(mean - expected)
    shift = np.sign(shift) * np.maximum(np.abs(shift) - blocks(allowed), 0)
    p = welch(shift, (blocks(variance) / scale, blocks(noise) / scale), (film.samples * scale, passes * scale))
    accept(least(p), f"a block differs at {place(p)}", exact=False)

    if single:
        known = (np.maximum(variance, noise) <= (KNOWN * expected) ** 2).all(axis=-1)
        assert known.mean() > 0.85
        p = np.where(known[..., None], welch(difference, (variance, noise), (film.samples, passes)), 1.0)
        accept(least(p), f"a pixel differs at {place(p)}", exact=False)


@by_name
def test_few_samples(case: Case, folder: Path, device: Device) -> None:
    """Enough for the mean and for blocks of pixels: what is plainly wrong."""
    check(case, rendered(case, folder, device, FEW), single=False)


@pytest.mark.slow
@by_name
def test_every_pixel(case: Case, folder: Path, device: Device) -> None:
    check(case, rendered(case, folder, device, case.ours), single=True)
