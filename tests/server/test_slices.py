"""Slices of uploaded volumes, against NumPy, and what is said where there are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
import pytest
from numpy.typing import NDArray
from starlette.testclient import TestClient

from woodcock_server.volumes import samples
from woodcock_server.volumes.contents import UnreadableFile
from woodcock_server.volumes.parser import Parser
from woodcock_server.volumes.samples import Samples, cut, png

from .conftest import Instead
from .files import CUBE, fire, npy, npz

VALUES = np.random.default_rng(5).normal(1, 1, (4, 5, 6)).astype(np.float32)  # [z][y][x], some of them negative


def upload(client: TestClient, content: bytes) -> str:
    answer = client.post("/api/v1/volumes?name=file", content=content)
    assert answer.status_code in (200, 201), answer.text
    return f"/api/v1/volumes/{answer.json()['id']}"


def decoded(content: bytes, folder: Path) -> NDArray[np.uint8]:
    (folder / "slice.png").write_bytes(content)
    pixels: NDArray[np.uint8] = oiio.ImageBuf(str(folder / "slice.png")).get_pixels(oiio.UINT8)
    return pixels


def grey(values: NDArray[np.float32], high: float) -> NDArray[np.uint8]:
    return np.rint(255 * (values.astype(np.float64) / high).clip(0, 1)).astype(np.uint8)


def test_slices_are_the_grids_voxels(client: TestClient, tmp_path: Path) -> None:
    volume, high = upload(client, npy(VALUES)), float(VALUES.max())
    for axis, position, plane in (
        ("z", 1, VALUES[1]),
        ("y", 4, VALUES[:, 4]),
        ("x", 0, VALUES[:, :, 0]),
        ("x", None, VALUES[:, :, 3]),
    ):
        answer = client.get(
            f"{volume}/slice.png", params={"axis": axis} | ({"position": position} if position is not None else {})
        )
        assert (answer.status_code, answer.headers["content-type"]) == (200, "image/png")
        assert answer.headers["cache-control"] == "private, max-age=31536000, immutable"
        np.testing.assert_array_equal(decoded(answer.content, tmp_path)[..., 0], grey(plane, high)[::-1])
    assert client.get(f"{volume}/range").json() == {
        "name": "density", "shape": [6, 5, 4], "channels": 1, "low": float(VALUES.min()), "high": high, "stride": 1
    }  # fmt: skip


def test_grids_of_vectors_are_in_colour(client: TestClient, tmp_path: Path) -> None:
    answer = client.get(f"{upload(client, fire())}/slice.png", params={"grid": "tint", "axis": "y", "position": 2})
    ramp = np.linspace(0.2, 1, 6**3).astype(np.float32).reshape(6, 6, 6)[:, 2]
    colours = np.stack([ramp, np.float32(1) - ramp, ramp * 0], axis=-1)
    np.testing.assert_allclose(decoded(answer.content, tmp_path), grey(colours, 1.0)[::-1], atol=1)


def test_what_is_not_finite_is_black(client: TestClient, tmp_path: Path) -> None:
    values = np.array([[[np.nan, np.inf, -np.inf, 2.0, -1.0]]], np.float32)
    volume = upload(client, npy(values))
    assert decoded(client.get(f"{volume}/slice.png").content, tmp_path)[0, :, 0].tolist() == [0, 0, 0, 255, 0]
    found = client.get(f"{volume}/range").json()
    assert (found["low"], found["high"]) == (-1, 2)
    volume = upload(client, npy(np.full((1, 1, 2), np.nan)))
    found = client.get(f"{volume}/range").json()
    assert (found["low"], found["high"]) == (None, None)
    assert not decoded(client.get(f"{volume}/slice.png").content, tmp_path).any()


def test_large_grids_are_thinned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_bytes(npy(VALUES))
    monkeypatch.setattr(samples, "MOST_SAMPLES", 20)
    found = Samples.model_validate(samples.sample(tmp_path / "a", 0))
    assert (found.shape, found.stride, len(found.values)) == ((6, 5, 4), 2, 2 * 3 * 3)
    shown = decoded(png(cut(found, "z", 3)), tmp_path)
    np.testing.assert_array_equal(shown[..., 0], grey(VALUES[2, ::2, ::2], float(VALUES.max()))[::-1])


def test_a_grid_is_read_once(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    asked, read = [], Parser.sample

    def sample(self: Parser, path: Path, position: int) -> Samples:
        asked.append(position)
        return read(self, path, position)

    monkeypatch.setattr(Parser, "sample", sample)
    volume = upload(client, npz(a=VALUES, b=VALUES + 1))
    for position in range(4):
        for grid in ("a", "b"):
            params = {"grid": grid, "position": position}
            assert client.get(f"{volume}/slice.png", params=params).status_code == 200
    assert asked == [0, 1]


@pytest.mark.parametrize(
    ("params", "field"),
    [
        ({"grid": "heat"}, "grid"),
        ({"grid": "a\0b"}, "grid"),
        ({"grid": "x" * 2000}, "grid"),
        ({"grid": "a"}, None),
        ({"axis": "w", "grid": "a"}, "axis"),
        ({"position": 6, "axis": "x", "grid": "a"}, "position"),
        ({"position": 10**30, "grid": "a"}, "position"),
        ({"position": -1, "grid": "a"}, "position"),
        ({"position": "middle", "grid": "a"}, "position"),
        ({}, "grid"),  # there are two, and none is the usual one
    ],
)
def test_what_is_no_slice_is_refused(client: TestClient, params: dict[str, Any], field: str | None) -> None:
    answer = client.get(f"{upload(client, npz(a=VALUES, b=VALUES + 1))}/slice.png", params=params)
    if field is None:
        assert answer.status_code == 200
    else:
        assert (answer.status_code, [fault["field"] for fault in answer.json()["errors"]]) == (422, [field])


def test_only_volumes_have_slices(client: TestClient) -> None:
    mesh = upload(client, CUBE)
    for part in ("slice.png", "range"):
        answer = client.get(f"{mesh}/{part}")
        assert (answer.status_code, answer.json()["detail"]) == (422, "Only volumes have slices.")
        assert client.get(f"/api/v1/volumes/sha256:{'0' * 64}/{part}").status_code == 404


def test_a_reader_that_dies_is_told_in_a_sentence_and_tried_again(
    client: TestClient,
    instead: Instead,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    volume = upload(client, npy(VALUES + 7))
    instead("kill -SEGV $$")
    answer = client.get(f"{volume}/slice.png")
    assert (answer.status_code, answer.json()["detail"]) == (422, "file: cannot be read: its reader ended by SIGSEGV")
    monkeypatch.undo()
    assert client.get(f"{volume}/slice.png").status_code == 200


def test_the_child_keeps_to_its_limits(tmp_path: Path) -> None:
    with (tmp_path / "a").open("wb") as file:  # 250 KB that take 250 MiB once they are unpacked
        np.savez_compressed(file, density=np.zeros((400, 400, 400), np.float32))
    with pytest.raises(UnreadableFile, match="takes more than 256 MiB of memory to read"):
        Parser(1 << 28, 60).sample(tmp_path / "a", 0)
