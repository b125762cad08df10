"""The service's API as Python calls."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from http import HTTPStatus
from pathlib import Path
from typing import Literal
from urllib.parse import quote

import httpx2
from pydantic import JsonValue

from woodcock.scene import Scene
from woodcock_client.batch_models import Batch
from woodcock_client.connection import ServiceError, Unreachable
from woodcock_client.download import replacing
from woodcock_client.models import (
    Device,
    DeviceList,
    Job,
    JobPage,
    JobSummary,
    Stability,
    State,
)
from woodcock_client.trial_models import Comparison, JobCheck
from woodcock_client.uploads import Uploads

Artifact = Literal["image.exr", "preview.png", "report.json", "report.html"]

PAGE = 100  # jobs per request of a listing
RECONNECT = (0.25, 5.0)  # seconds before the first and the last attempt to pick up a broken stream
LOOK_EVERY = 1.0  # seconds between two looks at a batch
SILENCE = 60.0  # seconds without even a ping after which a stream counts as broken


class Client(Uploads):
    """A connection to one Woodcock service; a context manager.

    `base_url` is the service's address, such as "http://127.0.0.1:8000". `timeout` is how many seconds may pass
    without an answer before a call raises Unreachable; `follow` stays patient that long through an outage. `token` is
    needed where the service asks for one.

    Every call may raise Unreachable or ServiceError. Raises ValueError if `base_url` is not an http(s) address.
    """

    # Jobs

    def submit(
        self,
        scene: Scene,
        *,
        name: str = "",
        device: str = "any",
        reference: str | None = None,
        webhook: str | None = None,
        webhook_secret: str | None = None,
    ) -> Job:
        """Queue a render; files named by a path are uploaded first, unless the service already has them.

        `device` is the id of the one that is to render it alone, even if it is not trusted. `reference` is a picture of
        the same size that this one is held against: the id of a job that has succeeded, or of an `upload`. `webhook` is
        a URL that is told of the render's end, signed by `webhook_secret` ("whsec_" and base64 of 24 to 64 random
        bytes). Returns once the service has committed the job. Raises SceneError if a file cannot be read.
        """
        body = {
            "scene": self._sent(scene),
            "name": name,
            "device": device,
            "reference": reference,
            "webhook": webhook and {"url": webhook, "secret": webhook_secret},
        }
        return self._read(Job, self._request("POST", "/api/v1/jobs", json=body))

    def check(self, scene: Scene, *, device: str = "any") -> JobCheck:
        """A dry run: what would be compiled, which devices it fits, how long it would render. Takes some seconds.

        Files are uploaded as by `submit`; nothing is queued.
        """
        body = {"scene": self._sent(scene), "device": device}
        return self._read(JobCheck, self._request("POST", "/api/v1/jobs/check", json=body))

    def compare(
        self,
        scene: Scene,
        vary: Mapping[str, Sequence[str]],
        seconds: float,
        *,
        name: str = "",
        device: str = "any",
        reference: str | None = None,
    ) -> Comparison:
        """Queue a job for each variant of a scene, each of so many seconds, one after the other on one device.

        `vary` has the kinds to try of `majorant`, `free_flight`, `transmittance` or `integrator`; files, `device` and
        `reference` are as `submit` has them.
        """
        body = {
            "scene": self._sent(scene),
            "vary": {field: list(kinds) for field, kinds in vary.items()},
            "seconds": seconds,
            "name": name,
            "device": device,
            "reference": reference,
        }
        return self._read(Comparison, self._request("POST", "/api/v1/comparisons", json=body))

    def comparison(self, id: str) -> Comparison:
        """The comparison as it is now; with its verdict, once all of its jobs have ended."""
        return self._read(Comparison, self._request("GET", f"/api/v1/comparisons/{quote(id, safe='')}"))

    def sweep(
        self,
        scene: Scene,
        product: Mapping[str, Sequence[JsonValue]] | None = None,
        zip: Mapping[str, Sequence[JsonValue]] | None = None,
        *,
        name: str = "",
        device: str = "any",
        reference: str | None = None,
        webhook: str | None = None,
        webhook_secret: str | None = None,
    ) -> Batch:
        """Queue a job for every combination of values of the scene's fields, 1000 at most, all or none.

        Both have lists of values by the path of the field, such as "volumes[0].sigma_t". Each list of `product` is
        combined with all others; those of `zip` have one length and go together. Files, also among the values, and all
        else are as `submit` has them; the webhook is told of the end of each.
        """
        body = {
            "scene": self._sent(scene),
            "product": self._sent_values(product or {}),
            "zip": self._sent_values(zip or {}),
            "name": name,
            "device": device,
            "reference": reference,
            "webhook": webhook and {"url": webhook, "secret": webhook_secret},
        }
        return self._read(Batch, self._request("POST", "/api/v1/batches", json=body))

    def batch(self, id: str) -> Batch:
        """The batch as it is now, with all of its jobs."""
        return self._read(Batch, self._request("GET", f"/api/v1/batches/{quote(id, safe='')}"))

    def follow_batch(self, id: str) -> Iterator[Batch]:
        """The batch now, then again when it has changed, until all of its jobs have ended.

        Outages are sat out as by `follow`.
        """
        last: Batch | None = None
        lost: float | None = None
        while last is None or not last.finished:
            try:
                now = self.batch(id)
            except (Unreachable, ServiceError) as error:
                lost = self._sit_out(error, lost)
            else:
                lost = None
                if now != last:
                    last = now
                    yield now
                if now.finished:
                    return
            time.sleep(LOOK_EVERY)

    def job(self, id: str) -> Job:
        """The job as it is now, with its scene."""
        return self._read(Job, self._request("GET", _job_path(id)))

    def jobs(self, *, state: State | None = None) -> Iterator[JobSummary]:
        """Every job, newest first, fetched page by page as the iterator advances."""
        query: dict[str, str | int] = {"limit": PAGE}
        if state is not None:
            query["state"] = state
        while True:
            page = self._read(JobPage, self._request("GET", "/api/v1/jobs", params=query))
            yield from page.items
            if page.next is None:
                return
            query["cursor"] = page.next

    def follow(self, id: str) -> Iterator[JobSummary]:
        """The job now, then again at each change, until it has finished.

        Reads the event stream. When that breaks, the job's state is read instead and the stream picked up again, so
        a restart of the service or a proxy that cuts long connections costs nothing but a moment.
        """
        first_delay, last_delay = RECONNECT
        delay = first_delay
        last: JobSummary | None = None
        lost: float | None = None  # when an outage began
        while True:
            try:
                for summary in self._changes(id):
                    delay, lost = first_delay, None
                    if summary != last:
                        last = summary
                        yield summary
                    if summary.finished:
                        return
            except (Unreachable, ServiceError) as error:
                lost = self._sit_out(error, lost)
            time.sleep(delay)
            delay = min(2 * delay, last_delay)

    def _changes(self, id: str) -> Iterator[JobSummary]:
        """One stream's summaries, and the job's state after it if it broke before the end."""
        try:
            with self._stream(f"{_job_path(id)}/events", silence=max(self._timeout, SILENCE)) as response:
                for event in httpx2.EventSource(response):
                    if event.event in ("progress", "end"):
                        yield self._parse(JobSummary, event.data)
        except Unreachable:
            pass
        yield self._read(JobSummary, self._request("GET", _job_path(id)))

    def _sit_out(self, error: Unreachable | ServiceError, lost: float | None) -> float:
        """When the outage began, None for now; raises the error if it is none, or lasts for too long."""
        temporary = isinstance(error, Unreachable) or error.status >= HTTPStatus.INTERNAL_SERVER_ERROR
        began = lost or time.monotonic()
        if not temporary or time.monotonic() - began > self._timeout:
            raise error
        return began

    def fetch(self, id: str, artifact: Artifact, path: Path) -> None:
        """Save a job's picture, preview or report as `path`.

        The file appears whole or not at all, and replaces an older one. Raises ServiceError with status 404 while
        the artifact does not exist yet, and OSError if the file cannot be written.
        """
        with self._stream(f"{_job_path(id)}/{artifact}") as response, replacing(path) as file:
            for chunk in response.iter_bytes():
                file.write(chunk)

    # Devices

    def devices(self) -> tuple[Device, ...]:
        """The devices that the service renders on, those that failed their check among them."""
        return self._read(DeviceList, self._request("GET", "/api/v1/devices")).items

    def check_device(self, id: str) -> Stability:
        """Begin a stability check of a device, unless one is under way; it takes minutes."""
        return self._read(Stability, self._request("POST", _stability_path(id)))

    def stability(self, id: str) -> Stability:
        """The check of a device that is under way, or else its newest outcome.

        Raises ServiceError with status 404 for a device that is not checked.
        """
        return self._read(Stability, self._request("GET", _stability_path(id)))


def _job_path(id: str) -> str:
    return f"/api/v1/jobs/{quote(id, safe='')}"


def _stability_path(id: str) -> str:
    return f"/api/v1/devices/{quote(id, safe='')}/stability"
