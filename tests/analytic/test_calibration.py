"""Fresh seeds: standard errors are what they claim to be, so that agreement within them means something."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.stats import kstest
from tests.conftest import SIGNIFICANCE, z_score

from woodcock.film import Film

Grid = Callable[..., dict[str, Any]]


@pytest.mark.slow
@pytest.mark.parametrize("medium", ["constant", "grid"])
def test_z_scores_are_normal(box: dict[str, Any], grid: Grid, picture: Callable[..., Film], medium: str) -> None:
    """Of many pictures of a known mean, each with a seed of its own."""
    first = secrets.randbelow(1 << 31)
    print(f"seeds from {first}")
    box["volumes"] = [
        grid(np.array([[[1]], [[5]], [[0]], [[2]]], np.uint8), scale=0.75, albedo=0)
        if medium == "grid"
        else {
            "kind": "constant",
            "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
            "sigma_t": 1.5,
            "albedo": 0,
        }
    ]
    scores = [z_score(picture(box | {"seed": first + turn}, 64), np.exp(-1.5)) for turn in range(400)]
    assert kstest(scores, "norm").pvalue > SIGNIFICANCE
