"""Differences of two jobs' pictures: numbers and maps against plain sums over the EXRs, and what is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from sqlalchemy import update
from starlette.testclient import TestClient
from tests.statistics import accept_z

from woodcock import flip, metrics
from woodcock.film import Film
from woodcock.image import read_exr, write_exr
from woodcock.space import Array
from woodcock_server.jobs.states import State
from woodcock_server.tables import jobs as table

from .conftest import Service

Make = Callable[..., dict[str, Any]]
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
SIZE = 32
#: A disc on a slope, in colour.
Y, X = np.mgrid[0:SIZE, 0:SIZE] / SIZE
TRUTH = (0.2 + Y + np.where((X - 0.5) ** 2 + (Y - 0.4) ** 2 < 0.1, 2, 0))[..., None] * np.array([1, 0.6, 0.3])


def sampled(truth: Array, seed: int, samples: int = 64) -> Film:
    """As a render has it: of exponential samples."""
    values = truth * np.random.default_rng(seed).exponential(size=(samples, *truth.shape[:2], 1))
    mean = values.mean(axis=0)
    names = ("R", "G", "B") if truth.shape[-1] == 3 else ("Y",)
    return Film(np.full(truth.shape[:2], samples, np.uint32), mean, ((values - mean) ** 2).sum(axis=0), names)


def finished(client: TestClient, scene: dict[str, Any], film: Film, seed: int) -> str:
    """A job whose picture is this film's."""
    services: Any = client.app.state.services  # type: ignore[attr-defined]
    job_id = str(client.post("/api/v1/jobs", json={"scene": scene}).json()["id"])
    with services.engine.begin() as connection:
        connection.execute(update(table).where(table.c.id == job_id).values(state=State.SUCCEEDED))
    services.storage.open_job(job_id)
    samples = int(film.count.max())
    header = {"seed": str(seed), "sampleRanges": json.dumps([[0, samples]]), "samples": str(samples)}
    write_exr(services.storage.job_file(job_id, "image.exr"), film, header)
    return job_id


class Jobs(NamedTuple):
    """Renders by name; http: how they are asked for."""

    ids: dict[str, str]
    http: Any
    data: Any


@pytest.fixture(scope="module")
def jobs(client: TestClient, make_scene: Make, data: Any) -> Jobs:
    """Of one scene: twice, with other seeds, and with the first's seed and more samples; and of other ones."""
    films = {
        "one": (sampled(TRUTH, 1), 1),
        "two": (sampled(TRUTH, 2), 2),
        "more": (sampled(TRUTH, 1, 128), 1),
        "darker": (sampled(0.95 * TRUTH, 3), 3),
        "grey": (sampled(TRUTH[..., :1], 4), 4),
        "once": (sampled(TRUTH, 5, 1), 5),
        "black": (sampled(0 * TRUTH, 6), 6),
        "broken": (replace(sampled(TRUTH, 7), mean=np.inf * TRUTH), 7),
    }
    ids = {name: finished(client, make_scene(SIZE), film, seed) for name, (film, seed) in films.items()}
    return Jobs(ids, client, data)


def path(jobs: Jobs, one: str, other: str, what: str = "") -> str:
    return f"/api/v1/jobs/{jobs.ids[one]}/differences/{jobs.ids[other]}{what}"


def got(jobs: Jobs, one: str, other: str, **query: Any) -> dict[str, Any]:
    answer = jobs.http.get(path(jobs, one, other), params=query)
    assert answer.status_code == 200, answer.text
    return answer.json()  # type: ignore[no-any-return]


def mapped(jobs: Jobs, one: str, other: str, name: str) -> Array:
    answer = jobs.http.get(path(jobs, one, other, f"/{name}"))
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/octet-stream"
    assert "immutable" in answer.headers["cache-control"]
    scale = float(answer.headers["woodcock-scale"])
    assert np.frexp(scale)[0] == 0.5, "a power of two"
    halves = np.frombuffer(answer.content, "<f2").astype(np.float64)
    return halves.reshape(SIZE, SIZE, -1) * scale


def picture(jobs: Jobs, name: str, layer: str = "") -> Array:
    channels, _ = read_exr(jobs.data / "jobs" / jobs.ids[name] / "image.exr")
    names = [name for name in ("R", "G", "B") if f"{layer}{name}" in channels] or ["Y"]
    return np.stack([channels[f"{layer}{name}"] for name in names], axis=-1).astype(np.float64)


def test_numbers_are_those_of_the_formulas(jobs: Jobs) -> None:
    a, b = (picture(jobs, name) for name in ("one", "two"))
    va, vb = (picture(jobs, name, "variance.") for name in ("one", "two"))
    found = got(jobs, "one", "two")
    assert (found["job"], found["reference"]) == (jobs.ids["one"], jobs.ids["two"])
    mean = np.mean(b @ LUMINANCE)
    assert found["reference_mean"] == pytest.approx(mean)
    assert found["noise"] == pytest.approx(np.mean(va @ LUMINANCE))
    assert found["reference_noise"] == pytest.approx(np.mean(vb @ LUMINANCE))
    assert found["mse"] == pytest.approx(np.mean(((a - b) ** 2 - vb) @ LUMINANCE))
    assert found["rel_mse"] == pytest.approx(np.mean((((a - b) ** 2 - vb) / (b**2 + 0.01 * mean**2)) @ LUMINANCE))
    smape = np.divide(np.abs(a - b), a + b, out=np.zeros(a.shape), where=a + b > 0)
    assert found["smape"] == pytest.approx(np.mean(smape @ LUMINANCE))
    assert found["bias"] == pytest.approx(np.mean((a - b) @ LUMINANCE))
    deviations = [np.sqrt(one) @ LUMINANCE for one in (va, vb)]
    assert found["verdict"]["bias_error"] == pytest.approx(np.sqrt(sum(np.sum(d**2) for d in deviations)) / SIZE**2)
    assert found["flip"] == (None if metrics.flip(a, b) is None else pytest.approx(metrics.flip(a, b), rel=1e-5))
    without = got(jobs, "one", "two", flip="false")
    assert without == {**found, "flip": None}
    other_way = got(jobs, "two", "one", flip="false")
    assert other_way["bias"] == pytest.approx(-found["bias"])
    assert other_way["smape"] == pytest.approx(found["smape"])


def test_maps_are_those_of_the_formulas(jobs: Jobs) -> None:
    a, b = (picture(jobs, name) for name in ("one", "darker"))
    va, vb = (picture(jobs, name, "variance.") for name in ("one", "darker"))
    links = got(jobs, "one", "darker", flip="false")["maps"]
    assert set(links) == {"difference", "absolute", "relative", "smape", "flip", "z"}
    noise = va + vb
    expected = {
        "difference": a - b,
        "absolute": np.abs(a - b),
        "relative": (a - b) ** 2 / (b**2 + 0.01 * np.mean(b @ LUMINANCE) ** 2),
        "smape": np.divide(np.abs(a - b), a + b, out=np.zeros(a.shape), where=a + b > 0),
        "z": np.divide(a - b, np.sqrt(noise), out=np.zeros(a.shape), where=noise > 1e-12),
    }
    for name, values in expected.items():
        assert links[name] == path(jobs, "one", "darker", f"/{name}")
        found = mapped(jobs, "one", "darker", name)
        assert np.allclose(found, values, rtol=1e-3, atol=1e-4 * np.abs(values).max()), name
    if flip.flip_evaluator is not None:
        errors = metrics.flip_errors(a, b)
        assert errors is not None
        assert np.allclose(mapped(jobs, "one", "darker", "flip"), errors, rtol=1e-3, atol=1e-6)


def test_two_seeds_differ_by_noise_alone(jobs: Jobs) -> None:
    verdict = got(jobs, "one", "two", flip="false")["verdict"]
    assert (verdict["kind"], verdict["shared"]) == ("noise", False), verdict
    assert verdict["says"].startswith("Noise: ")
    assert len(verdict["parts"]) == 17
    assert verdict["scatter"]["pixels"] == 1


def test_what_is_darker_is_biased(jobs: Jobs) -> None:
    found = got(jobs, "darker", "one", flip="false")
    assert found["verdict"]["kind"] == "bias", found
    assert " is darker by " in found["verdict"]["says"]
    assert found["verdict"]["parts"][0]["bias"] == pytest.approx(found["bias"])


def test_z_scores_of_renders(service: Service, make_scene: Make) -> None:
    """Two seeds differ by noise, whose z-scores are normal; two hundredths less of the albedo are a bias."""
    box = {"kind": "constant", "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}, "sigma_t": 4}
    albedos = {1: [0.9, 0.6, 0.3], 2: [0.9, 0.6, 0.3], 3: [0.882, 0.588, 0.294]}
    made = [
        service.submit(make_scene(SIZE, 400, seed=seed, volumes=[{**box, "albedo": albedo}]))
        for seed, albedo in albedos.items()
    ]
    for job in made:
        service.wait(job, lambda found: found["state"] == "succeeded")
    noise, bias = (
        service.http.get(f"/api/v1/jobs/{job}/differences/{made[0]}?flip=false").json()["verdict"] for job in made[1:]
    )
    assert noise["kind"] == "noise", noise
    scatter = noise["scatter"]
    pixels = scatter["pixels"] * SIZE**2
    for share, expected in ((scatter["beyond_2"], 0.0455), (scatter["beyond_3"], 0.0027)):
        accept_z((share - expected) / np.sqrt(expected / pixels), exact=False)
    accept_z((scatter["mean_square"] - 1) / scatter["error"], exact=False)
    assert bias["kind"] == "bias", bias
    assert bias["says"].startswith("Bias: the picture is darker by ")
    assert bias["scatter"]["mean_square"] > noise["scatter"]["mean_square"]


def test_the_same_seed_is_told(jobs: Jobs) -> None:
    """Half of the samples are the same: their noise is, and variances say nothing of the difference."""
    found = got(jobs, "one", "more", flip="false")
    verdict = found["verdict"]
    assert (verdict["shared"], verdict["scatter"], found["reference_noise"]) == (True, None, None)
    assert verdict["kind"] == "noise", verdict
    assert "z" not in found["maps"]
    answer = jobs.http.get(path(jobs, "one", "more", "/z"))
    assert answer.status_code == 409
    assert answer.json()["detail"].startswith("There are no z-scores of these pictures: they have no noise")
    assert got(jobs, "one", "one", flip="false")["verdict"]["kind"] == "same"


def test_pictures_of_other_kinds(jobs: Jobs) -> None:
    grey = got(jobs, "one", "grey", flip="false")
    assert grey["verdict"]["kind"] == "bias"
    squares = (picture(jobs, "one") - picture(jobs, "grey")) ** 2 - picture(jobs, "grey", "variance.")
    assert grey["mse"] == pytest.approx(np.mean(squares @ LUMINANCE))
    once = got(jobs, "once", "one", flip="false")
    assert (once["noise"], once["verdict"]["scatter"]) == (None, None)
    assert once["verdict"]["bias_error"] > 0
    black = got(jobs, "one", "black")
    assert (black["rel_mse"], black["flip"], black["reference_mean"]) == (None, None, 0)
    assert black["verdict"]["kind"] == "bias"
    answer = jobs.http.get(path(jobs, "one", "black", "/flip"))
    assert answer.status_code == 409
    assert answer.json()["detail"].startswith("FLIP has no answer here: ")


@pytest.mark.parametrize("what", ["", "/absolute", "/flip"])
def test_what_cannot_be_compared(client: TestClient, jobs: Jobs, make_scene: Make, what: str) -> None:
    def refused(one: str, other: str) -> tuple[int, str]:
        answer = client.get(f"/api/v1/jobs/{one}/differences/{other}{what}")
        assert answer.headers["content-type"] == "application/problem+json"
        return answer.status_code, answer.json()["detail"]

    one = jobs.ids["one"]
    small = finished(client, make_scene(16), sampled(TRUTH[:16, :16], 1), 1)
    sizes = f"Job {one} is 32 × 32 pixels, and {small} 16 × 16."
    assert refused(one, small) == (409, f"{sizes} Only pictures of one size are compared.")
    for pair in (("nobody", one), (one, "nobody")):
        assert refused(*pair) == (404, "There is no job nobody.")
    waiting = client.post("/api/v1/jobs", json={"scene": make_scene(SIZE)}).json()["id"]
    says = f"Job {waiting} is queued. Only jobs that have succeeded are compared."
    assert refused(one, waiting) == refused(waiting, one) == (409, says)
    if what != "/flip":
        status, says = refused(jobs.ids["broken"], one)
        assert (status, says.partition("jobs/")[0]) == (409, "These pictures cannot be compared: ")
        assert says.endswith("pixel (0, 0) is no finite number; only finite pictures are compared")
        gone = finished(client, make_scene(SIZE), sampled(TRUTH, 1), 1)
        (jobs.data / "jobs" / gone / "image.exr").unlink()
        assert refused(one, gone)[0] == 409


def test_a_map_that_there_is_not(jobs: Jobs) -> None:
    assert jobs.http.get(path(jobs, "one", "two", "/colour")).status_code == 422
