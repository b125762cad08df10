"""Batches: a job for each point of a sweep, all or none, and how they are seen."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from sqlalchemy import event, select
from starlette.testclient import TestClient

from woodcock.scene import Scene
from woodcock_server.batches import service as batches
from woodcock_server.tables import job_files

from .files import exr, npy
from .sweeps import PATH, PRODUCT, Sweep, made, problem, services

MakeScene = Callable[..., dict[str, Any]]
SPECTRUM = "must be one number or three (red, green, blue), each 0 or more"


def faults(answer: Any) -> dict[str, str]:
    assert problem(answer, 422)
    return {fault["field"]: fault["message"] for fault in answer.json()["errors"]}


# Making one


def test_a_batch_is_a_job_for_each_point(client: TestClient, sweep: Sweep, make_scene: MakeScene) -> None:
    zipped = {"seed": [7, 8], "volumes[0].albedo": [0.5, [0.1, 0.2, 0.3]]}
    answer = sweep(name="block", zip=zipped, tags=["b", "a"], priority=-3)
    batch = made(answer)
    assert answer.headers["location"] == batch["links"]["self"] == f"{PATH}/{batch['id']}"
    assert client.get(batch["links"]["self"]).json() == batch
    assert Scene.model_validate(batch["scene"]) == Scene.model_validate(make_scene())
    assert batch["axes"] == [
        {"paths": ["seed", "volumes[0].albedo"], "rows": [[7, 0.5], [8, [0.1, 0.2, 0.3]]]},
        {"paths": ["volumes[0].sigma_t"], "rows": [[1], [2]]},
        {"paths": ["camera.fov"], "rows": [[20], [35]]},
    ]
    assert batch["counts"] == {"queued": 8} | dict.fromkeys(
        ("running", "cancelling", "succeeded", "failed", "cancelled"), 0
    )
    points = [
        {"seed": seed, "volumes[0].albedo": albedo, "volumes[0].sigma_t": sigma_t, "camera.fov": fov}
        for seed, albedo in zip(*zipped.values(), strict=True)
        for sigma_t in (1, 2)
        for fov in (20, 35)
    ]
    assert [job["point"] for job in batch["jobs"]] == points
    found = [client.get(job["links"]["self"]).json() for job in batch["jobs"]]
    for job, short, point in zip(found, batch["jobs"], points, strict=True):
        assert {key: job[key] for key in short} == short
        assert (job["batch"], job["point"]) == (batch["id"], point)
        assert (job["tags"], job["priority"], job["device"]) == (["a", "b"], -3, "any")
        scene = make_scene(seed=point["seed"])
        scene["camera"]["fov"] = point["camera.fov"]
        scene["volumes"][0] |= {"sigma_t": point["volumes[0].sigma_t"], "albedo": point["volumes[0].albedo"]}
        assert Scene.model_validate(job["scene"]) == Scene.model_validate(scene)
    assert found[0]["name"] == "block: seed=7, albedo=0.5, sigma_t=1, fov=20"
    listed = client.get(batch["links"]["jobs"], params={"limit": 5})
    assert [job["id"] for job in listed.json()["items"]] == [job["id"] for job in batch["jobs"]][:2:-1], "in that order"
    rest = client.get(listed.links["next"]["url"]).json()["items"]
    assert [job["id"] for job in rest] == [job["id"] for job in batch["jobs"]][2::-1]
    assert client.get("/api/v1/jobs", params={"batch": batch["id"], "state": "running"}).json()["items"] == []
    assert client.get("/api/v1/jobs", params={"batch": "another"}).json()["items"] == []


def test_a_job_that_is_of_no_batch_says_so(client: TestClient, make_scene: MakeScene) -> None:
    job = client.post("/api/v1/jobs", json={"scene": make_scene()}).json()
    assert (job["batch"], job["point"]) == (None, None)


def test_of_the_end_of_each_job_is_told(client: TestClient, sweep: Sweep) -> None:
    secret = "whsec_" + "A" * 32
    answer = sweep(webhook={"url": "https://example.org/hook", "secret": secret}, pinned=True)
    jobs = client.get(made(answer)["links"]["jobs"]).json()["items"]
    told = {"url": "https://example.org/hook", "state": "waiting", "attempts": 0, "error": None}
    assert [(job["webhook"], job["pinned"]) for job in jobs] == [(told, True)] * 4
    assert secret not in answer.text


def test_names_are_no_longer_than_names_may_be(client: TestClient, sweep: Sweep) -> None:
    batch = made(sweep(name="x" * 200))
    assert client.get(batch["links"]["jobs"]).json()["items"][0]["name"] == "x" * 200


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        ({"product": {}}, {"product": "must name a field and its values, or `zip` must"}),
        ({"product": {"seed": 5}}, {"product.seed": "input should be a valid list (got 5)"}),
        (
            {"product": {"seed": list(range(501)), "orders": [1, 2]}},
            {"product": "must make 1000 jobs at most; this makes 1002"},
        ),
        (
            {"product": {f"x{n}": list(range(1000)) for n in range(10)}},
            {"product": "must make 1000 jobs at most; this makes more than a billion"},
        ),
        ({"zip": {"seed": [1, 2], "orders": [1]}}, {"zip.orders": "must hold as many values as seed does, 2, not 1"}),
        (
            {"product": {"volumes[1].sigma_t": [1]}},
            {'product["volumes[1].sigma_t"]': "must lead to a field: volumes has no item [1], it holds 1"},
        ),
        (
            {"product": {"volumes[0].sigma_t": [1, -1, 2, "x"], "camera.fov": [20, 200]}},
            {
                'product["volumes[0].sigma_t"][1]': f"{SPECTRUM} (got -1)",
                'product["volumes[0].sigma_t"][3]': f'{SPECTRUM} (got "x")',
                'product["camera.fov"][1]': "input should be less than 180 (got 200)",
            },
        ),
        ({"product": {"volumes[0].density": [1]}}, {'product["volumes[0].density"][0]': "is not a known key (got 1)"}),
        (
            {"product": {"volumes[0].phase": [{"kind": "isotropic"}, {"kind": "henyey_greenstein"}]}},
            {'product["volumes[0].phase"][1].g': "is required"},
        ),
        (
            {"product": {"camera.origin[2]": [0, 0.5]}, "zip": {"camera.origin": [[0.5, 0.5, 1]]}},
            {'product["camera.origin[2]"]': "must not lie within camera.origin, which varies too"},
        ),
        (
            {"product": {"volumes[0].sigma_t": [1, 2], "camera.origin[2]": [0, 0.5, 1]}},
            {"scene.camera": "target must differ from origin; first at sigma_t=1, origin[2]=0.5"},
        ),
        (
            {"zip": {"volumes[0]": [{"kind": "grid", "file": "a.vdb", "albedo": 0.5}]}, "product": {"seed": [1, 2]}},
            {'zip["volumes[0]"][0].file': "must be the id (sha256:…) of a volume that was uploaded to /api/v1/volumes"},
        ),
        ({"device": "cpu7"}, {"device": "must be any, or the kind or id of a device of this server: there is none"}),
        (
            {"reference": "nobody"},
            {
                "reference": "must be the id of a job that has succeeded, or that of an uploaded picture (sha256:…); "
                "first at sigma_t=1, fov=20"
            },
        ),
        ({"scene": {}}, {"scene.camera": "is required"}),
        ({"priority": 101}, {"priority": "input should be less than or equal to 100 (got 101)"}),
    ],
)  # fmt: skip
def test_what_cannot_be_swept(
    client: TestClient, sweep: Sweep, asked: dict[str, Any], expected: dict[str, str]
) -> None:
    before = client.get("/api/v1/jobs").json(), client.get(PATH).json()
    assert faults(sweep(**asked)) == expected
    assert (client.get("/api/v1/jobs").json(), client.get(PATH).json()) == before, "all or none"


def test_a_reference_has_the_size_of_every_picture(client: TestClient, sweep: Sweep) -> None:
    posted = client.post("/api/v1/volumes?name=right.exr", content=exr(np.full((16, 16, 3), 0.5)))
    named = posted.raise_for_status().json()["id"]
    batch = made(sweep(reference=named))
    assert {job["reference"] for job in client.get(batch["links"]["jobs"]).json()["items"]} == {named}
    answer = sweep(reference=named, zip={"film.width": [16, 8, 8, 4]}, product={"seed": [1, 2]})
    assert problem(answer, 422)
    says = "must be {0} × 16 pixels, as the scene's film is; it is 16 × 16; first at width={0}, seed=1"
    assert answer.json()["errors"] == [{"field": "reference", "message": says.format(width)} for width in (8, 4)]


def test_the_first_faults_are_told(sweep: Sweep) -> None:
    found = faults(sweep(product={"seed": list(range(-500, 500))}))
    assert list(found) == [f"product.seed[{n}]" for n in range(batches.FEW)]


def test_what_all_jobs_name_is_looked_up_once(client: TestClient, sweep: Sweep, make_scene: MakeScene) -> None:
    file = client.post("/api/v1/volumes?name=a.npy", content=npy(np.ones((4, 4, 4)))).json()["id"]
    named = client.post("/api/v1/volumes?name=a.exr", content=exr(np.ones((16, 16, 3)))).json()["id"]
    scene = make_scene(volumes=[{"kind": "grid", "file": file, "albedo": 0.5}])
    statements = []

    def note(*about: Any) -> None:
        statements.append(about[2])

    engine = services(client).engine
    event.listen(engine, "before_cursor_execute", note)
    try:
        batch = made(sweep(scene=scene, reference=named, product={"volumes[0].scale": list(range(1, 101))}))
    finally:
        event.remove(engine, "before_cursor_execute", note)
    assert len(statements) < 40
    with engine.connect() as connection:
        pairs = select(job_files.c.job_id, job_files.c.file).where(job_files.c.file.in_([file, named]))
        found = {tuple(pair) for pair in connection.execute(pairs)}
    assert found == {(job["id"], each) for job in batch["jobs"] for each in (file, named)}


# Keys


def test_a_batch_that_is_asked_for_twice_is_made_once(client: TestClient, sweep: Sweep, make_scene: MakeScene) -> None:
    first = sweep("twice", tags=["once"])
    again = sweep("twice", tags=["once"])
    assert again.json() == made(first)
    assert again.headers["location"] == first.headers["location"]
    assert len(client.get("/api/v1/jobs", params={"tag": "once"}).json()["items"]) == 4
    assert list(faults(sweep("twice", tags=["other"]))) == ["Idempotency-Key"]
    job = {"scene": make_scene()}
    for path, body, other, others in (
        ("/api/v1/jobs", job, PATH, {**job, "product": PRODUCT}),
        (PATH, {**job, "product": PRODUCT}, "/api/v1/jobs", job),
    ):
        headers = {"Idempotency-Key": f"of {path}".replace(" ", "-")}
        assert client.post(path, json=body, headers=headers).status_code == 201
        assert list(faults(client.post(other, json=others, headers=headers))) == ["Idempotency-Key"]


def test_two_that_come_at_once_are_one(client: TestClient, sweep: Sweep) -> None:
    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(lambda _: sweep("at-once", tags=["at once"]), range(8)))
    assert {answer.status_code for answer in answers} == {201}
    assert len({answer.json()["id"] for answer in answers}) == 1
    assert len(client.get("/api/v1/jobs", params={"tag": "at once"}).json()["items"]) == 4


# Seeing them


def test_batches_come_in_pages_newest_first(client: TestClient, sweep: Sweep) -> None:
    batches = [made(sweep(name=f"batch {n}"))["id"] for n in range(3)]
    first = client.get(PATH, params={"limit": 2})
    following = client.get(first.links["next"]["url"])
    items = [*first.json()["items"], *following.json()["items"]]
    assert [each["id"] for each in items][:3] == batches[::-1]
    assert items[0]["counts"]["queued"] == 4
    assert set(items[0]) == {"id", "owner", "name", "created_at", "counts", "links"}
    assert problem(client.get(PATH, params={"limit": 0}), 422)
    for method, path in (("GET", ""), ("POST", "/cancel"), ("DELETE", "")):
        assert problem(client.request(method, f"{PATH}/nobody{path}"), 404) == "There is no batch nobody."


@pytest.mark.parametrize("listing", [True, False])
def test_what_has_not_changed_is_not_sent_again(client: TestClient, sweep: Sweep, listing: bool) -> None:
    batch = made(sweep())
    path = PATH if listing else batch["links"]["self"]
    tag = client.get(path).headers["ETag"]

    def again() -> int:
        return client.get(path, headers={"If-None-Match": tag}).status_code

    assert again() == 304
    client.post(f"{batch['jobs'][2]['links']['self']}/cancel").raise_for_status()
    assert again() == 200
