"""How fields are stored: the narrowest storage for an error, bricks, and chunks of them; and that past 1 GiB."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.lib.format import open_memmap
from tests.kernels.media_code import ask

from woodcock.device import Context
from woodcock.formats import Grid, VolumeError
from woodcock.formats import grid as limits
from woodcock.scene import GlobalMajorant, GridVolume
from woodcock.space import Space
from woodcock.volume.compose import compose
from woodcock.volume.field import BRICK, CHUNK, MOST_CHUNKS, Buffer, Field
from woodcock.volume.media import read_media

RANDOM = np.random.default_rng(17)


def grid_of(values: Any) -> Grid:
    depth, height, width = values.shape[:3]
    return Grid("density", values, np.diag([1 / width, 1 / height, 1 / depth, 1]), placed=False)


def field_of(values: Any, allowed: float = 0.0) -> Field:
    return Field.of(grid_of(values), float(values.max()), allowed)


def restored(field: Field, shift: int) -> Any:
    """The values, from the chunks."""
    stored = np.concatenate([chunk.array() for chunk in field.chunks(shift)])
    if field.storage == "half":
        stored = stored.view(np.float16)
    x, y, z = field.bricks
    bricks = stored.reshape(z, y, x, BRICK, BRICK, BRICK, field.channels).transpose(0, 3, 1, 4, 2, 5, 6)
    values = bricks.reshape(z * BRICK, y * BRICK, x * BRICK, field.channels)
    width, height, depth = field.size
    return values[:depth, :height, :width].astype(np.float64) * field.step


@pytest.mark.parametrize(
    ("values", "allowed", "storage", "error"),
    [
        (np.arange(90), 0, "uint8", 0),
        (np.arange(90).astype(np.uint8), 0.5, "uint8", 0),
        (np.arange(90) / 7, 0, "float", 0),
        (np.arange(90) / 7, 0.002, "uint8", 1 / 510),
        (np.arange(90) / 7, 0.001, "half", 2**-11),
        (np.arange(90) / 7, 1e-5, "float", 0),
        (np.arange(90) * 1e20 / 2**60, 0, "float", 0),
        (np.arange(90) * 2.0**100, 0, "half", 0),
        (np.arange(90) * 2.0**-140, 0, "half", 0),
        (np.full(90, 0.99999), 1e-3, "uint8", 2e-5),
        (np.linspace(0, 0.99999, 90), 1e-3, "half", 2**-11),
        (np.array([6e-8] + [65504] * 89, np.float16), 0, "half", 0),
        (np.zeros(90), 0.1, "uint8", 0),
    ],
)
def test_storage_is_the_narrowest_with_the_error_that_is_allowed(
    values: Any, allowed: float, storage: str, error: float
) -> None:
    values = values.reshape(3, 6, 5)
    values = values if values.dtype in (np.uint8, np.float16) else values.astype(np.float32)
    field = field_of(values, allowed)
    assert field.storage == storage
    assert field.error <= min(error, allowed)
    back, largest = restored(field, 30)[..., 0], float(values.max())
    assert np.abs(back - values.astype(np.float64)).max() <= (field.error + 1e-12) * largest
    assert np.allclose(field.decoded(1, 3), back[1:3].astype(np.float32), rtol=1e-6, atol=0)


def test_bricks_and_chunks_hold_every_voxel_once() -> None:
    values = RANDOM.random((9, 6, 13, 3)).astype(np.float32)
    field = field_of(values)
    assert field.bricks == (4, 2, 3)
    for shift in (0, 1, 3, 30):
        assert np.array_equal(restored(field, shift), values)
    assert [chunk.size for chunk in field.chunks(4)] == [16 * 192, 8 * 192]
    assert field.shift() == (CHUNK // (192 * 4)).bit_length() - 1
    assert field.shift(192 * 4 * 5) == 2
    many = field_of(np.broadcast_to(np.float32(0.3), (512, 64, 64)))
    assert len(many.chunks(many.shift(1))) <= MOST_CHUNKS


def test_pieces_are_layers() -> None:
    """The host never holds a second copy: a piece is no more than one layer of bricks."""
    field = field_of(RANDOM.random((16, 8, 8)).astype(np.float32))
    (chunk,) = field.chunks(30)
    assert isinstance(chunk, Buffer)
    pieces: Iterator[Any] = chunk.pieces()
    assert [piece.nbytes for piece in pieces] == [4 * 8 * 8 * 4] * 4
    assert sum(piece.nbytes for piece in chunk.pieces()) == chunk.nbytes


def look_up(context: Context, values: Any, voxels: Any, lanes: int, most_bytes: int = CHUNK) -> Any:
    """(2, n): the values of voxels (n, 3) by one tap, and by all."""
    media = read_media([GridVolume(file="x", albedo=0)], lambda file, name: grid_of(values))
    composed = compose(media, Space(), GlobalMajorant(), most_bytes=most_bytes)
    given = {name: (column + 0.5).astype(np.float32) for name, column in zip("xyz", voxels.T, strict=True)}
    body = "words w = {(word)0u, (word)0x80000400u, (word)0x80000000u, (word)0u};"
    return ask(
        context,
        composed,
        ["medium_0_sigma_t(world, p, w)", "medium_0_sigma_t_exact(world, p)"],
        given,
        lanes,
        body=body,
    )


@pytest.mark.parametrize("storage", ["uint8", "half", "float"])
def test_lookups_find_the_chunk(context: Context, lanes: int, storage: str) -> None:
    values = RANDOM.integers(0, 256, (9, 10, 11))
    values = (values / {"uint8": 1, "half": 4, "float": 3}[storage]).astype(np.float32)
    voxels = np.argwhere(values >= 0)[:, ::-1]
    got = look_up(context, values, voxels, lanes, most_bytes=64 * 4 * 4)
    assert np.allclose(got, values[tuple(voxels.T[::-1])], rtol=1e-6)


@pytest.mark.slow
def test_a_grid_past_a_gibibyte(context: Context, tmp_path: Path) -> None:
    """2.5 GiB of float32 in a sparse, mapped file: known voxels are found, the last of all among them."""
    size = np.array([1024, 1024, 640])
    if context.device.memory < 8 * size.prod():
        pytest.skip("the device has too little memory")
    values = open_memmap(tmp_path / "large.npy", mode="w+", dtype=np.float32, shape=tuple(size[::-1].tolist()))
    voxels = np.concatenate([np.array(list(np.ndindex(2, 2, 2))) * (size - 1), RANDOM.integers(0, 640, (64, 3))])
    values[tuple(voxels.T[::-1])] = (np.arange(len(voxels)) + 1) / 3
    got = look_up(context, values, voxels, 1)
    assert np.allclose(got, values[tuple(voxels.T[::-1])], rtol=1e-6)


def test_arrays_that_fit_no_memory_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sparse file of a few bytes may ask for any size."""
    monkeypatch.setattr(limits, "memory", lambda: 1 << 20)
    limits.check_size((64, 64, 64), "spans")
    with pytest.raises(
        VolumeError, match="spans 64 × 64 × 65 voxels, more than the 1 MiB of this machine's memory hold"
    ):
        limits.check_size((64, 64, 65), "spans")
