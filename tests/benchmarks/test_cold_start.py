"""From POST to the first preview, by a service that has just started: with the scene's program in the driver's cache,
and without, when the generic one begins.

Pictures have half the examples' sides: in full size a single sample of `milk` takes longer than all the rest.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest
from tests.server.conftest import Service

EXAMPLES = Path(__file__).parents[2] / "client" / "woodcock_client" / "examples"
#: Of the small loop and of the one that knows everything.
SCENES = ("block", "fog", "milk")
MOST_CACHED, MOST_UNCACHED = 1.0, 3.0


def first_preview(service: Service, scene: dict[str, Any]) -> tuple[str, float]:
    """The job, and the seconds until its first preview was fetched."""
    began = time.perf_counter()
    job_id = service.submit(scene)
    while (answer := service.http.get(f"/api/v1/jobs/{job_id}/preview.png")).status_code != 200:
        assert answer.status_code == 404, answer.text
        assert time.perf_counter() < began + 60, service.log.read_text()
        time.sleep(0.01)
    return job_id, time.perf_counter() - began


def prepared(service: Service) -> None:
    """Wait for the generic program."""
    deadline = time.monotonic() + 600
    while "generic program ready" not in service.log.read_text():
        assert time.monotonic() < deadline, service.log.read_text()
        time.sleep(0.1)


@pytest.mark.benchmark
@pytest.mark.timeout(1800)
def test_cold_start(tmp_path: Path) -> None:
    caches = {"XDG_CACHE_HOME": str(tmp_path), "POCL_CACHE_DIR": str(tmp_path / "pocl")}
    (tmp_path / "pocl").mkdir()
    service = Service(tmp_path / "data", POCL_DEVICES="pthread", WOODCOCK_PREPARE="1", **caches)
    service.start()
    prepared(service)
    service.stop()

    def cold(scene: dict[str, Any]) -> tuple[float, int]:
        """Seconds to the first preview, and how many programs rendered."""
        service.start()
        try:
            job_id, seconds = first_preview(service, scene)
            service.wait(job_id, lambda job: job["state"] == "succeeded", 600)
            report = service.http.get(f"/api/v1/jobs/{job_id}/report.json").raise_for_status().json()
            return seconds, len(report["devices"][0]["programs"])
        finally:
            service.stop()

    rows = []
    for name in SCENES:
        scene = json.loads((EXAMPLES / f"{name}.json").read_text())
        scene["stop"] = {"kind": "samples", "samples": 16}
        scene["film"] |= {side: scene["film"][side] // 2 for side in ("width", "height")}
        rows.append((name, *cold(scene), *cold(scene)))
    print("\nseconds from POST to the first preview, service just started")
    print(f"{'scene':10}{'uncached':>10}{'programs':>10}{'cached':>10}{'programs':>10}")
    for name, uncached, programs, cached, program in rows:
        print(f"{name:10}{uncached:10.2f}{programs:10}{cached:10.2f}{program:10}")
    assert all(program == 1 for *_, program in rows)
    assert max(cached for *_, cached, _ in rows) < MOST_CACHED
    assert max(uncached for _, uncached, *_ in rows) < MOST_UNCACHED
