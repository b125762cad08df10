"""What must hold of a job after a fault, by its files and rows."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from tests.farm.harness import wait_until
from tests.statistics import accept_z

from .rig import Rig
from .stages import PIECE

SAMPLES = 5 * PIECE
SIZE = 32

#: README, "The life of a job".
LEGAL = {
    None: {"queued"},
    "queued": {"running", "cancelled"},
    "running": {"running", "queued", "cancelling", "succeeded", "failed"},
    "cancelling": {"cancelled"},
}
FILES = {"image.exr", "preview.png", "thumbnail.webp", "report.json", "report.html"}


def eventually(check: Callable[[], None], seconds: float) -> None:
    """The check passes within so many seconds."""
    end = time.monotonic() + seconds
    while True:
        try:
            return check()
        except AssertionError:
            if time.monotonic() > end:
                raise
        time.sleep(0.1)


@dataclass(frozen=True)
class Picture:
    layers: dict[str, np.ndarray]
    header: dict[str, str]
    preview: bytes


def picture(rig: Rig, job_id: str) -> Picture:
    """What is kept of the job, read without the renderer's code."""
    files = rig.files(job_id)
    buffer = oiio.ImageBuf(str(files["image.exr"]))
    pixels, spec = np.asarray(buffer.get_pixels(oiio.FLOAT)), buffer.spec()
    layers = {name: pixels[..., index] for index, name in enumerate(spec.channelnames)}
    header = {each.name: str(each.value) for each in spec.extra_attribs}
    return Picture(layers, header, files["preview.png"].read_bytes())


def check_states(rig: Rig, job_id: str) -> list[str]:
    """A legal walk from the queue to the end that the row has; returns it."""
    row = rig.rows("SELECT state, error, holder, lease_until FROM jobs WHERE id = :id", id=job_id)[0]
    assert (row.state, row.error, row.holder, row.lease_until) == ("succeeded", None, None, None)
    events = rig.rows("SELECT state FROM job_events WHERE job_id = :id ORDER BY id", id=job_id)
    walk = [event.state for event in events]
    for before, after in pairwise([None, *walk]):
        assert after in LEGAL.get(before, ()), walk
    assert walk[-1] == "succeeded"
    return walk


def check_picture(rig: Rig, job_id: str, undisturbed: Picture, alone: bool) -> None:
    """Every sample counts once. alone: one device rendered it, so every bit is that of the picture without a fault."""
    found = picture(rig, job_id)
    assert json.loads(found.header["woodcock:sampleRanges"]) == [[0, SAMPLES]]
    assert (found.layers["samples.count"] == SAMPLES).all()
    assert found.layers.keys() == undisturbed.layers.keys()
    if alone:
        for name, layer in found.layers.items():
            assert np.array_equal(layer, undisturbed.layers[name]), name
        assert found.preview == undisturbed.preview, "the preview is that of the picture"
    else:
        same, other = found.layers["Y"].astype(float), undisturbed.layers["Y"].astype(float)
        variance = found.layers["variance.Y"].astype(float).sum() + undisturbed.layers["variance.Y"].astype(float).sum()
        accept_z((same - other).sum() / np.sqrt(variance), exact=False)
    report = json.loads(rig.files(job_id)["report.json"].read_text())
    assert (report["samples"], report["sample_ranges"]) == (SAMPLES, [[0, SAMPLES]])
    assert sum(use["samples"] for use in report["devices"]) == SAMPLES
    for before, after in pairwise(report["error"]):
        assert before["samples"] < after["samples"]


def check_files(rig: Rig, job_id: str) -> None:
    """No file that nothing knows, and none half-written."""
    token = rig.rows("SELECT token FROM jobs WHERE id = :id", id=job_id)[0].token
    files = set(rig.files(job_id))
    films = {name for name in files if name.startswith("film-")}
    assert len(films) == 1
    assert int(next(iter(films)).removeprefix("film-").removesuffix(".npz")) <= token
    assert files == FILES | films
    rig.check_rest()


def check_answers(rig: Rig, job_id: str, body: dict[str, Any], key: str, walk: list[str]) -> None:
    """A request that comes twice is done once, and the events are told, by every service."""
    for service in rig.alive:
        before = rig.rows("SELECT count(*) AS jobs FROM jobs")
        again = service.http.post("/api/v1/jobs", json=body, headers={"Idempotency-Key": key})
        assert (again.status_code, again.json()["id"]) == (201, job_id)
        assert rig.rows("SELECT count(*) AS jobs FROM jobs") == before
        told, event = [], ""
        with service.http.stream("GET", f"/api/v1/jobs/{job_id}/events") as stream:
            for line in stream.iter_lines():
                if line.startswith("event: "):
                    event = line.removeprefix("event: ")
                elif line.startswith("data: ") and event == "state":
                    told.append(json.loads(line.removeprefix("data: "))["state"])
        assert (told, event) == (walk, "end")
        wait_until(lambda service=service: service.http.get("/readyz").status_code == 200, 10)
