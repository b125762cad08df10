"""Denoising takes noise away and leaves the light; without its extra it says what to install."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from woodcock import denoise as module
from woodcock.denoise import DenoiseError, denoise

SIZE = (96, 128)
RAMP = np.linspace(0.2, 2, SIZE[1])[None, :, None] * np.linspace(0.5, 1, SIZE[0])[:, None, None]


@pytest.fixture
def _oidn() -> None:
    pytest.importorskip("mitsuba_oidn", reason="Open Image Denoise is not installed: pip install 'woodcock[denoise]'")


def noisy(clean: np.ndarray) -> np.ndarray:
    """As 16 samples leave it: positive, of the right mean. (Of 4, coloured, the filter moves the mean by 1.3 %.)"""
    random = np.random.default_rng(13)
    return (clean * random.gamma(16, 1 / 16, clean.shape)).astype(np.float32)


@pytest.mark.usefixtures("_oidn")
@pytest.mark.parametrize("scale", [1, 1e-20, 1e20])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("clean", [np.full((*SIZE, 1), 0.7), RAMP], ids=["constant", "ramp"])
def test_noise_goes_and_light_stays(clean: np.ndarray, channels: int, scale: float) -> None:
    clean = np.broadcast_to(clean * scale, (*SIZE, channels))
    before = noisy(clean)
    after = denoise(before)
    assert after.shape == before.shape
    assert after.dtype == np.float32
    error, left = (np.sqrt(np.mean((image / scale - clean / scale) ** 2)) for image in (before, after))
    assert left < error / 4
    assert after.mean(dtype=float) == pytest.approx(before.mean(dtype=float), rel=0.01)


@pytest.mark.usefixtures("_oidn")
def test_guides_keep_edges() -> None:
    """An edge that the albedo has is sharper than one left to be guessed."""
    clean = np.where(np.arange(SIZE[1]) % 16 < 8, 0.9, 0.6)[None, :, None] * np.ones((*SIZE, 1))
    normal = np.zeros((*SIZE, 3), np.float32)
    normal[..., 2] = 1
    before = noisy(clean)
    alone, guided = denoise(before), denoise(before, clean.astype(np.float32), normal)
    assert np.mean((guided - clean) ** 2) < np.mean((alone - clean) ** 2)


@pytest.mark.usefixtures("_oidn")
def test_black_stays_black() -> None:
    assert not denoise(np.zeros((16, 16, 3), np.float32)).any()


def test_shapes_that_do_not_fit() -> None:
    beauty = np.ones((4, 4, 3), np.float32)
    with pytest.raises(ValueError, match=r"beauty must be \(height, width, 1 or 3\), not \(4, 4\)"):
        denoise(beauty[..., 0])
    with pytest.raises(ValueError, match=r"albedo must be"):
        denoise(beauty, beauty[:2])
    with pytest.raises(ValueError, match=r"normal must be \(height, width, 3\), not \(4, 4, 1\)"):
        denoise(beauty, normal=beauty[..., :1])


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    module._library.cache_clear()
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    with pytest.raises(DenoiseError, match=r"pip install 'woodcock\[denoise\]'"):
        denoise(np.ones((4, 4, 1), np.float32))
    module._library.cache_clear()
