"""The service's API as Python calls."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Mapping, Sequence
from http import HTTPStatus
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

import httpx2

from woodcock.scene import Scene, SceneError, files, with_files
from woodcock_client.connection import Connection, ServiceError, Unreachable
from woodcock_client.download import replacing
from woodcock_client.models import (
    Device,
    DeviceList,
    Job,
    JobPage,
    JobSummary,
    Stability,
    State,
    Volume,
)
from woodcock_client.trial_models import Comparison, JobCheck

Artifact = Literal["image.exr", "preview.png", "report.json", "report.html"]

PAGE = 100  # jobs per request of a listing
RECONNECT = (0.25, 5.0)  # seconds before the first and the last attempt to pick up a broken stream
SILENCE = 60.0  # seconds without even a ping after which a stream counts as broken


class Client(Connection):
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

    def _sent(self, scene: Scene) -> dict[str, Any]:
        """The scene with its files uploaded."""
        uploaded = {file: self._upload_for(file) for file in files(scene) if not file.startswith("sha256:")}
        return with_files(scene, lambda file: uploaded.get(file, file)).model_dump(mode="json")

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
                temporary = isinstance(error, Unreachable) or error.status >= HTTPStatus.INTERNAL_SERVER_ERROR
                lost = lost or time.monotonic()
                if not temporary or time.monotonic() - lost > self._timeout:
                    raise
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

    def fetch(self, id: str, artifact: Artifact, path: Path) -> None:
        """Save a job's picture, preview or report as `path`.

        The file appears whole or not at all, and replaces an older one. Raises ServiceError with status 404 while
        the artifact does not exist yet, and OSError if the file cannot be written.
        """
        with self._stream(f"{_job_path(id)}/{artifact}") as response, replacing(path) as file:
            for chunk in response.iter_bytes():
                file.write(chunk)

    # Files and devices

    def upload(self, path: Path) -> Volume:
        """Give the service a volume, mesh or picture; only its digest travels when the service already has it.

        Raises OSError if the file cannot be read.
        """
        with path.open("rb") as file:
            id = f"sha256:{hashlib.file_digest(file, 'sha256').hexdigest()}"
            try:
                return self.volume(id)
            except ServiceError as error:
                if error.status != HTTPStatus.NOT_FOUND:
                    raise
            size = file.tell()
            file.seek(0)
            response = self._request(
                "POST",
                "/api/v1/volumes",
                params={"name": path.name},
                content=file,
                headers={"Content-Type": "application/octet-stream", "Content-Length": str(size)},
            )
        volume = self._read(Volume, response)
        if volume.id != id:
            raise ServiceError(response.status_code, f"{path} changed while it was uploaded; submit it again")
        return volume

    def volume(self, id: str) -> Volume:
        """An uploaded file; `id` is "sha256:" and the digest."""
        return self._read(Volume, self._request("GET", f"/api/v1/volumes/{quote(id, safe=':')}"))

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

    def _upload_for(self, file: str) -> str:
        try:
            return self.upload(Path(file)).id
        except OSError as error:
            raise SceneError(f"{file}: {error.strerror or error}") from None


def _job_path(id: str) -> str:
    return f"/api/v1/jobs/{quote(id, safe='')}"


def _stability_path(id: str) -> str:
    return f"/api/v1/devices/{quote(id, safe='')}/stability"
