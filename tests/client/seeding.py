"""A data folder with as many ended renders as are wanted, whose pictures are shared: what a wall of thousands is."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from sqlalchemy import bindparam, insert, update

from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.identifiers import new_id
from woodcock_server.jobs import repository
from woodcock_server.storage import Storage
from woodcock_server.tables import batches, jobs

#: The axes of the batch that the newest renders are of, and how many renders that are.
PRODUCT = {"volumes[0].sigma_t": [1, 2], "camera.fov": [20, 35, 50]}
SWEPT = 6
SAMPLES = 64


def seed(data: Path, scene: dict[str, Any], count: int) -> str:
    """Renders `render 0` to `render {count - 1}`, each a minute after the one before; every tenth has failed, every
    fourth is tagged `sky`. Returns the id of a batch of the newest."""
    storage, now, batch = Storage(data), datetime.now(UTC), new_id()
    engine = open_database(Settings(data=data).database)
    ids = [new_id() for _ in range(count)]
    points = [{"volumes[0].sigma_t": t, "camera.fov": f} for t in (1, 2) for f in (20, 35, 50)]
    swept = dict(zip(ids[-SWEPT:], points, strict=True))
    with engine.begin() as connection:
        sweep = {"name": "block", "scene": scene, "product": PRODUCT, "zip": {}}
        connection.execute(insert(batches).values(id=batch, created_at=now, **sweep))
        for first in range(0, count, 500):
            some = range(first, min(count, first + 500))
            asked = {ids[number]: _asked(number, scene, batch, swept.get(ids[number])) for number in some}
            repository.add_all(connection, asked, now)
        ended = [
            {
                "job": ids[number],
                "ends": "succeeded" if number % 10 else "failed",
                "says": None if number % 10 else "The device was lost.",
                "then": now - timedelta(minutes=count - number),
            }
            for number in range(count)
        ]
        values = {"state": bindparam("ends"), "error": bindparam("says"), "size": 1}
        times = {"created_at": bindparam("then"), "started_at": bindparam("then"), "finished_at": bindparam("then")}
        connection.execute(update(jobs).where(jobs.c.id == bindparam("job")).values(**values, **times), ended)
    engine.dispose()
    _pictures(storage, ids)
    return batch


def _asked(number: int, scene: dict[str, Any], batch: str, point: dict[str, Any] | None) -> dict[str, Any]:
    kind, device = ("volumetric_path", "cpu0") if number % 5 else ("transmittance", "gpu0")
    return {
        "name": f"render {number}",
        "scene": scene,
        "device": "any",
        "tags": ["sky"] if number % 4 == 0 else [],
        "batch": batch if point else None,
        "point": point,
        **repository.NOTHING,
        "samples": SAMPLES,
        "usage": {device: {"kinds": {"integrator": [kind]}}},
    }


def _pictures(storage: Storage, ids: list[str]) -> None:
    shared = []
    across, down = np.meshgrid(np.linspace(0, 1, 320), np.linspace(0, 1, 240))
    for shade in range(8):
        pixels = np.stack([across, down, np.full_like(across, shade / 8)], axis=-1)
        shared.append(storage.scratch / f"{shade}.webp")
        Image.fromarray((255 * pixels).astype(np.uint8)).save(shared[-1])
    report = storage.scratch / "report.json"
    report.write_text("{}")
    for number, job_id in enumerate(ids):
        (storage.jobs / job_id).mkdir()
        storage.job_file(job_id, report.name).hardlink_to(report)
        for name in ("preview.png", "thumbnail.webp"):
            storage.job_file(job_id, name).hardlink_to(shared[number % len(shared)])
