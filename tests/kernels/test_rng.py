"""Addressed random numbers: the published generator, its uniforms, and their independence of lanes."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm
from tests.statistics import accept, accept_counts, least

from woodcock.device import Context
from woodcock.evaluate import evaluate

PARTS = ["core/rng.h"]


def pcg4d(v: np.ndarray) -> np.ndarray:
    """Jarzynski & Olano (2020) in numpy; (4, n) words."""
    with np.errstate(over="ignore"):
        x, y, z, w = (v * np.uint32(1664525) + np.uint32(1013904223)).astype(np.uint32)
        for turn in range(2):
            x = x + y * w
            y = y + z * x
            z = z + x * y
            w = w + y * z
            if turn == 0:
                x, y, z, w = (word ^ (word >> np.uint32(16)) for word in (x, y, z, w))
        return np.stack([x, y, z, w])


def words(context: Context, lanes: int, address: np.ndarray, hashed: str = "rng_words(&at, c)") -> np.ndarray:
    """(4, n) words of (pixel, sample, dimension, 7)."""
    halves = [f"to_real(word_as_integer(v.{part} {half}))" for part in "xyzw" for half in (">> 16u", "& 65535u")]
    body = f"rng_address at = {{a, b, c, 7u}}; words v = {hashed};"
    inputs = dict(zip("abcd", address, strict=True))
    got = evaluate(context, halves, inputs, lanes=lanes, parts=PARTS, body=body).astype(np.uint32)
    return (got[::2] << np.uint32(16)) | got[1::2]


def test_words_are_those_of_the_paper(context: Context, lanes: int) -> None:
    """The hash itself, and then with its low halves mixed."""
    address = np.random.default_rng(2).integers(0, 1 << 32, (4, 1024), dtype=np.uint32)
    assert np.array_equal(words(context, lanes, address, "pcg4d((words){a, b, c, d})"), pcg4d(address))
    pixel, sample, dimension, _ = address
    paper = pcg4d(np.stack([pixel, sample, np.full_like(pixel, 7), dimension]))
    assert np.array_equal(words(context, lanes, address), paper ^ (paper >> np.uint32(16)))


def test_no_bit_tells_of_another(context: Context) -> None:
    """All 128 bits of a step against each other and those of the next two steps, along the samples of a pixel.

    The published hash fails this: its lowest bits tell of each other.
    """
    n = 1 << 16
    sample, still = np.arange(n, dtype=np.uint32), np.zeros(n, np.uint32)
    steps = [words(context, 1, np.stack([still + 5, sample, still + step, still])) for step in range(3)]
    bits = np.concatenate([((word >> np.uint32(bit)) & 1) for step in steps for word in step for bit in range(32)])
    signs = bits.reshape(-1, n).astype(np.float32) * 2 - 1
    z = signs @ signs.T / np.sqrt(n)
    accept(least(2 * norm.sf(np.abs(z[np.triu_indices_from(z, 1)]))), exact=False)


def test_neighbouring_addresses_are_uniform_and_uncorrelated(context: Context, lanes: int) -> None:
    """Pixels, samples and dimensions that follow each other, as a render uses them."""
    pixel, sample, dimension = (axis.reshape(-1).astype(np.uint32) for axis in np.meshgrid(*[np.arange(48)] * 3))
    v = words(context, lanes, np.stack([pixel, sample, dimension, np.full_like(pixel, 7)]))
    for word in v:
        for byte in range(4):
            counts = np.bincount((word >> np.uint32(8 * byte)) & 255, minlength=256)
            accept_counts(counts)
    u = v / 2.0**32 - 0.5
    shifted = np.concatenate([u, np.roll(u, 1, axis=1), np.roll(u, 48, axis=1), np.roll(u, 48 * 48, axis=1)])
    correlation = np.corrcoef(shifted) - np.eye(len(shifted))
    z = np.abs(correlation[np.triu_indices_from(correlation, 1)]) * np.sqrt(u.shape[1])
    accept(least(2 * norm.sf(z)), exact=False)


def test_unit_lies_in_the_half_open_interval(context: Context, lanes: int) -> None:
    w = np.array([0, 255, 256, 0xFFFFFFFF, 0x80000000], np.uint32)
    (got,) = evaluate(context, ["unit(w)"], {"w": w}, lanes=lanes, parts=PARTS)
    assert np.array_equal(got, np.array([0, 0, 2.0**-24, 1 - 2.0**-24, 0.5], np.float32))
