"""Layers of pictures over HTTP, against the EXR and numpy."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest
from numpy.typing import NDArray

from woodcock.film import Film
from woodcock.image import measured, read_exr, write_exr
from woodcock_server.layers.cache import Cache
from woodcock_server.layers.halves import halves, scale_of

from .conftest import Service

MakeScene = Callable[..., dict[str, Any]]
Channels = dict[str, NDArray[np.float32]]
LAYERS = ["beauty", "order.0", "order.1", "order.rest", "albedo", "depth", "normal"]
RADIANCE = ["beauty", "order.0", "order.1", "order.rest"]


def ended(job: dict[str, Any]) -> bool:
    return bool(job["finished_at"])


@pytest.fixture(scope="module")
def job(service: Service, make_scene: MakeScene) -> dict[str, Any]:
    """A job that is done, whose picture has many layers."""
    job = service.wait(service.submit(make_scene(samples=9)), ended)
    names = [*"RGB", *(f"{layer}.{c}" for layer in ("order.0", "order.1", "order.rest", "albedo") for c in "RGB")]
    names += ["depth.Z", *(f"normal.{c}" for c in "XYZ")]
    rng = np.random.default_rng(3)
    mean, m2 = rng.lognormal(sigma=3, size=(40, 24, len(names))), rng.lognormal(sigma=5, size=(40, 24, len(names)))
    film = Film(rng.integers(2, 10, (40, 24)).astype(np.uint32), mean, m2, tuple(names))
    write_exr(service.data / "jobs" / job["id"] / "image.exr", film, {})
    return job


@pytest.fixture
def exr(service: Service, job: dict[str, Any]) -> Channels:
    return read_exr(service.data / "jobs" / job["id"] / "image.exr")[0]


def names_of(layer: dict[str, Any]) -> list[str]:
    """Its channels' names in the EXR."""
    return [channel if layer["name"] == "beauty" else f"{layer['name']}.{channel}" for channel in layer["channels"]]


def numbers(answer: httpx2.Response, shape: tuple[int, ...]) -> NDArray[np.float64]:
    stored = np.frombuffer(answer.content, "<f2").reshape(shape)
    return stored.astype(np.float64) * float(answer.headers["woodcock-scale"])


def test_every_layer_comes_as_halves(service: Service, job: dict[str, Any], exr: Channels) -> None:
    found = service.http.get(job["links"]["layers"]).raise_for_status().json()
    assert (found["width"], found["height"], found["samples"]) == (24, 40, 9)
    variances = ["variance" if name == "beauty" else f"variance.{name}" for name in RADIANCE]
    assert [layer["name"] for layer in found["layers"]] == [*LAYERS, *variances, "samples"]
    units = {layer["name"]: layer["unit"] for layer in found["layers"]}
    assert [units[name] for name in ("order.rest", "variance", "depth", "samples", "albedo")] == [
        "radiance", "radiance²", "length", "samples", ""
    ]  # fmt: skip
    assert sorted(name for layer in found["layers"] for name in names_of(layer)) == sorted(exr)
    for layer in found["layers"]:
        answer = service.http.get(layer["link"])
        assert (answer.status_code, answer.headers["content-type"]) == (200, "application/octet-stream")
        assert answer.headers["woodcock-samples"] == "9"
        right = np.stack([exr[name] for name in names_of(layer)], axis=-1)
        assert numbers(answer, right.shape) == pytest.approx(right, rel=2**-11, abs=float(right.max()) * 2**-38)


def test_a_browser_may_keep_what_never_changes(service: Service, job: dict[str, Any]) -> None:
    link = f"{job['links']['layers']}/variance"
    assert service.http.get(f"{link}?samples=9").headers["cache-control"] == "private, max-age=31536000, immutable"
    for query in ("", "?samples=8"):
        answer = service.http.get(f"{link}{query}")
        assert answer.headers["cache-control"] == "private, no-cache"
    known = {"If-None-Match": answer.headers["etag"]}
    again = service.http.get(link, headers=known)
    assert (again.status_code, again.content, again.headers["etag"]) == (304, b"", answer.headers["etag"])


def test_a_pixel_has_the_very_values_of_the_exr(service: Service, job: dict[str, Any], exr: Channels) -> None:
    for x, y in ((0, 0), (23, 39), (11, 15), (12, 16)):
        found = service.http.get(f"{job['links']['self']}/pixels?x={x}&y={y}").raise_for_status().json()
        assert (found["x"], found["y"], found["width"], found["height"], found["samples"]) == (x, y, 1, 1, 9)
        for layer in found["layers"]:
            assert layer["values"] == [float(exr[name][y, x]) for name in names_of(layer)], layer["name"]
        beauty, samples = found["layers"][0], found["layers"][-1]
        assert beauty["errors"] == pytest.approx([math.sqrt(exr[f"variance.{c}"][y, x]) for c in "RGB"])
        assert samples["errors"] is None


def test_a_rectangle_has_its_mean_and_standard_error(service: Service, job: dict[str, Any], exr: Channels) -> None:
    found = service.http.get(f"{job['links']['self']}/pixels?x=3&y=10&width=7&height=25").raise_for_status().json()
    part = np.s_[10:35, 3:10]
    for layer in found["layers"]:
        means = [float(exr[name][part].mean(dtype=np.float64)) for name in names_of(layer)]
        assert layer["values"] == pytest.approx(means, rel=1e-12)
        errors = [math.sqrt(exr[f"variance.{name}"][part].sum(dtype=np.float64)) / 175 for name in names_of(layer)
                  if f"variance.{name}" in exr]  # fmt: skip
        assert layer["errors"] == (pytest.approx(errors) if errors else None)
        assert bool(errors) == (layer["name"] in RADIANCE)


def test_what_is_not_in_the_picture_is_told_by_its_field(service: Service, job: dict[str, Any]) -> None:
    for query, field, says in (
        ("x=24&y=0", "x", "must be less than 24"),
        ("x=0&y=39&height=2", "height", "must be 1 at most, from 39 on"),
        ("x=0&y=-1", "y", "greater than or equal to 0"),
        ("y=0", "x", "is required"),
    ):
        answer = service.http.get(f"{job['links']['self']}/pixels?{query}")
        assert answer.status_code == 422
        (fault,) = answer.json()["errors"]
        assert fault["field"] == field
        assert says in fault["message"]
    answer = service.http.get(f"{job['links']['layers']}/order.2")
    assert answer.status_code == 404
    assert "has no layer order.2: it has beauty, order.0" in answer.json()["detail"]


def test_what_is_no_finite_number_is_told_as_it_is(service: Service, make_scene: MakeScene) -> None:
    job = service.wait(service.submit(make_scene()), ended)
    path = service.data / "jobs" / job["id"] / "image.exr"
    film = Film(np.full((4, 3), 5, np.uint32), np.full((4, 3, 1), 1e-30), np.zeros((4, 3, 1)), ("Y",))
    film.mean[0, :, 0] = np.nan, np.inf, -np.inf
    film.mean[1, :, 0] = 1e30, 3e-39, 0
    write_exr(path, film, {})
    answer = service.http.get(f"{job['links']['layers']}/beauty")
    assert answer.content == halves(read_exr(path)[0]["Y"][..., None], float(answer.headers["woodcock-scale"]))
    got = numbers(answer, (4, 3))
    assert np.array_equal(got[0], [np.nan, np.inf, -np.inf], equal_nan=True)
    assert got[1] == pytest.approx([1e30, 0, 0], rel=1e-3)
    told = [
        service.http.get(f"{job['links']['self']}/pixels?x={x}&y=0").json()["layers"][0]["values"] for x in (0, 1, 2)
    ]
    assert told == [["NaN"], ["Infinity"], ["-Infinity"]]
    whole = service.http.get(f"{job['links']['self']}/pixels?x=0&y=0&width=3&height=4").json()
    assert whole["layers"][0]["values"] == ["NaN"]

    path.unlink()
    answer = service.http.get(job["links"]["layers"])
    assert answer.status_code == 404
    assert answer.json()["detail"].endswith("has no layers: its image.exr was deleted or cannot be read.")
    path.write_bytes(b"v/1\x01 and no more")
    assert service.http.get(f"{job['links']['self']}/pixels?x=0&y=0").status_code == 404


def test_a_picture_is_looked_at_while_it_is_rendered(service: Service, make_scene: MakeScene) -> None:
    scene = make_scene(size=32, stop={"kind": "seconds", "seconds": 60})
    waiting = service.submit(scene)
    path = f"/api/v1/jobs/{waiting}/layers"

    def listed() -> dict[str, Any]:
        found: dict[str, Any] = service.http.get(path).raise_for_status().json()
        assert bool(found["layers"]) == (found["samples"] > 0)
        return found

    job = service.wait(waiting, lambda _: bool(listed()["layers"]))
    found = listed()
    assert job["links"]["layers"] == path
    assert [layer["name"] for layer in found["layers"]] == ["beauty", "variance", "samples"]
    link = f"{job['links']['layers']}/beauty"
    first = service.http.get(link).raise_for_status()
    known = {"If-None-Match": first.headers["etag"]}
    service.wait(waiting, lambda _: service.http.get(link, headers=known).status_code == 200)
    second = service.http.get(link)
    assert int(second.headers["woodcock-samples"]) > int(first.headers["woodcock-samples"]) > 0
    assert first.headers["cache-control"] == "private, no-cache"
    a, b = (numbers(each, (32, 32)) for each in (first, second))
    assert not np.array_equal(a, b)
    assert a.mean() == pytest.approx(b.mean(), rel=0.1)
    pixel = service.http.get(f"/api/v1/jobs/{waiting}/pixels?x=16&y=16").raise_for_status().json()
    assert pixel["samples"] >= int(second.headers["woodcock-samples"])
    assert 0 <= pixel["layers"][0]["values"][0] < 5
    assert service.http.post(f"/api/v1/jobs/{waiting}/cancel").status_code == 202
    job = service.wait(waiting, ended)
    assert job["links"]["layers"] is None
    answer = service.http.get(link)
    assert answer.status_code == 404
    assert answer.json()["detail"].endswith("has no layers: it is cancelled.")


@pytest.mark.parametrize("largest", [1.0, 0.999, 65504.0, 1e-38, 1e-44, 3e38, 2.0**-40])
def test_halves_keep_large_and_small_numbers(largest: float) -> None:
    values = np.float32(largest) * np.geomspace(1e-4, 1, 1000, dtype=np.float32)
    scale = scale_of(values[:, None])
    assert math.frexp(scale)[0] == 0.5
    back = np.frombuffer(halves(values[:, None], scale), "<f2").astype(np.float64) * scale
    assert back == pytest.approx(values.astype(np.float64), rel=2**-11)
    assert scale_of(np.array([np.nan, np.inf, 0], np.float32)) == 1


def test_a_cache_stays_within_its_bounds() -> None:
    cache, read = Cache(300), list[int]()

    def kilo(key: int) -> Callable[[], Channels]:
        return lambda: read.append(key) or {"Y": np.zeros(25, np.float32)}  # type: ignore[func-returns-value]

    for key in (1, 2, 3, 1, 4, 1, 2):  # 2 was longest not asked for when 4 came
        cache.get(key, kilo(key))
    assert read == [1, 2, 3, 4, 2]
    large = {"Y": np.zeros(1000, np.float32)}
    assert cache.get(5, lambda: large) is large
    cache.get(1, kilo(1))
    assert read[-1] == 2, "what is too large takes nobody's place"


def test_a_film_has_the_channels_of_its_exr(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    shape = (3, 4, 7)
    names = ("R", "G", "B", "order.0.R", "order.0.G", "order.0.B", "depth.Z")
    film = Film(np.full(shape[:2], 4, np.uint32), rng.random(shape), rng.random(shape), names)
    write_exr(tmp_path / "a.exr", film, {})
    written, found = read_exr(tmp_path / "a.exr")[0], measured(film)
    assert found.keys() == written.keys()
    for name, values in written.items():
        assert np.array_equal(found[name].astype(np.float32), values)
