"""A service that speaks the HTTP API on a real socket, with its faults under the control of the test."""

from __future__ import annotations

import hashlib
import json
import struct
import sys
import threading
import zlib
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

from woodcock import scene as scenes

WEB = Path(__file__).parents[2] / "client" / "woodcock_client" / "web"
TYPES = {".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".css": "text/css"}


def png(width: int, height: int, shade: int) -> bytes:
    """A grey ramp; `shade` (0 to 255) is its brightest value."""
    rows = b"".join(b"\0" + bytes(shade * (x + y) // (width + height) for x in range(width)) for y in range(height))
    chunks = (
        (b"IHDR", struct.pack(">2I5B", width, height, 8, 0, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows)),
        (b"IEND", b""),
    )
    packed = (struct.pack(">I", len(d)) + t + d + struct.pack(">I", zlib.crc32(t + d)) for t, d in chunks)
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


class Service:
    """Jobs advance when a test says so; `requests` lists what was asked as (method, path)."""

    def __init__(self, port: int = 0) -> None:
        self.jobs: dict[str, dict[str, Any]] = {}
        self.artifacts: dict[tuple[str, str], bytes] = {}
        self.volumes: dict[str, dict[str, Any]] = {}
        self.devices = {"cpu0": dict(DEVICE)}
        self.checks: dict[str, dict[str, Any]] = {}  # by device
        self.retention: dict[str, Any] = dict(RETENTION)
        self.batches: dict[str, dict[str, Any]] = {}
        self.requests: list[tuple[str, str]] = []
        self.secrets: dict[str, str | None] = {}  # of webhooks, by job
        self.streams_to_cut = 0  # streams that break after their first event
        self.truncate = False  # artifacts end after half their length
        self.broken: tuple[int, str, bytes] | None = None  # status, content type, body of every answer
        self.changed = threading.Condition()
        self.stopping = False
        service = self

        class Handler(_Handler):
            pass

        Handler.service = service
        self.http = _Server(("127.0.0.1", port), Handler)
        self.port = self.http.server_address[1]
        self.url = f"http://127.0.0.1:{self.port}"
        self.thread = threading.Thread(target=self.http.serve_forever, args=(0.02,))
        self.thread.start()

    def close(self) -> None:
        with self.changed:
            self.stopping = True
            self.changed.notify_all()
        self.http.shutdown()
        self.http.server_close()
        self.thread.join()

    def add(self, scene: dict[str, Any], name: str = "") -> str:
        scene = scenes.Scene.model_validate(scene).model_dump(mode="json")
        with self.changed:
            id = f"job{len(self.jobs):04}"
            at = f"/api/v1/jobs/{id}"
            absent = dict.fromkeys(("image", "preview", "thumbnail", "report", "report_page"))
            links = {"self": at, "events": f"{at}/events", **absent}
            self.jobs[id] = {
                "id": id,
                "owner": "",
                "name": name,
                "tags": [],
                "priority": 0,
                "pinned": False,
                "state": "queued",
                "waiting": None,
                "created_at": f"2025-01-01T{len(self.jobs) // 60:02}:{len(self.jobs) % 60:02}:00Z",
                "started_at": None,
                "finished_at": None,
                "width": scene["film"]["width"],
                "height": scene["film"]["height"],
                "samples": 0,
                "target": scene["stop"],
                "fraction": 0.0,
                "seconds": 0.0,
                "rmse": None,
                "relative_rmse": None,
                "device": "any",
                "devices": [],
                "reference": None,
                "batch": None,
                "point": None,
                "retry_of": None,
                "extends": None,
                "webhook": None,
                "integrator": None,
                "error": None,
                "links": links,
                "scene": scene,
            }
        return id

    def refuse(self, status: int, detail: str) -> None:
        """From now on, whatever is asked."""
        problem = {"type": "about:blank", "title": "Refused", "status": status, "detail": detail}
        self.broken = (status, "application/problem+json", json.dumps(problem).encode())

    def update(self, id: str, **values: Any) -> None:
        """Change a job and tell its followers."""
        with self.changed:
            self.jobs[id] = {**self.jobs[id], **values}
            self.changed.notify_all()

    def advance(self, id: str, samples: int) -> None:
        """Render up to so many samples."""
        job = self.jobs[id]
        fraction = samples / job["target"].get("samples", 64)
        picture = png(job["width"], job["height"], 80 + int(175 * min(fraction, 1)))
        self.artifacts[id, "preview.png"] = self.artifacts[id, "thumbnail.webp"] = picture
        at = f"/api/v1/jobs/{id}"
        self.update(
            id,
            state="running",
            started_at=job["created_at"],
            samples=samples,
            fraction=min(fraction, 1.0),
            seconds=samples / 50,
            rmse=0.25 / samples**0.5,
            relative_rmse=0.5 / samples**0.5,
            devices=["cpu0"],
            links={**job["links"], "preview": f"{at}/preview.png", "thumbnail": f"{at}/thumbnail.webp"},
        )

    def finish(self, id: str, report: dict[str, Any] | None = None) -> None:
        job = self.jobs[id]
        self.artifacts[id, "image.exr"] = b"v/1\x01" + bytes(range(256)) * 64
        self.artifacts[id, "report.json"] = json.dumps(report or {}).encode()
        at = f"/api/v1/jobs/{id}"
        made = {"image": f"{at}/image.exr", "report": f"{at}/report.json", "report_page": f"{at}/report.html"}
        links = {**job["links"], **made}
        self.update(id, state="succeeded", fraction=1.0, finished_at=job["created_at"], links=links)


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        if not isinstance(sys.exception(), ConnectionError):  # followers leave when they like
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    service: Service

    def log_message(self, format: str, *args: object) -> None:
        pass

    def do_GET(self) -> None:
        path, query = self._route()
        match path.split("/")[1:]:
            case _ if self.service.broken:
                self._send(*self.service.broken)
            case ["api", "v1", "jobs"]:
                self._list(query)
            case ["api", "v1", "jobs", "counts"]:
                states = [job["state"] for job in self.service.jobs.values()]
                counts = {state: states.count(state) for state in STATES}
                self._json(200, {"states": counts, "tags": {}, "devices": {}, "integrators": {}})
            case ["api", "v1", "retention"]:
                self._json(200, self.service.retention)
            case ["healthz"]:
                self._json(200, {"status": "ok", "version": "0.1.0"})
            case ["api", "v1", "jobs", id, *rest] if id in self.service.jobs:
                if not rest:
                    self._json(200, self.service.jobs[id])
                elif rest == ["events"]:
                    self._events(id)
                else:
                    self._artifact(id, rest[0])
            case ["api", "v1", "volumes", id] if id in self.service.volumes:
                self._json(200, self.service.volumes[id])
            case ["api", "v1", "batches", id] if id in self.service.batches:
                self._json(200, self.service.batches[id])
            case ["api", "v1", "devices"]:
                self._json(200, {"items": [{"id": id, **device} for id, device in self.service.devices.items()]})
            case ["api", "v1", "devices", id, "stability"] if id in self.service.checks:
                self._json(200, self.service.checks[id])
            case [""] | ["compare"] | ["submit"] | ["fleet"] | ["renders" | "batches", _]:
                self._file(WEB / "index.html")
            case ["web", *parts] if WEB.joinpath(*parts).is_file():
                self._file(WEB.joinpath(*parts))
            case _:
                self._problem(404, f"there is nothing at {path}")

    def do_POST(self) -> None:
        path, query = self._route()
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        _, *parts = path.split("/")
        if self.service.broken:
            self._send(*self.service.broken)
        elif parts[:3] == ["api", "v1", "devices"]:
            if parts[3] not in self.service.devices:
                self._problem(404, f"There is no device {parts[3]}.")
                return
            moments = {"started_at": None, "finished_at": None}
            started = {"device": parts[3], "state": "running", "version": "0.1.0", **moments, "rows": []}
            self._json(202, self.service.checks.setdefault(parts[3], started))
        elif path == "/api/v1/volumes":
            id = f"sha256:{hashlib.sha256(body).hexdigest()}"
            facts = {"name": query["name"], "size": len(body), "created_at": "2025-01-01T00:00:00Z"}
            self.service.volumes[id] = {"id": id, **facts, **CONTENTS.get(Path(query["name"]).suffix, VOLUME)}
            self._json(201, self.service.volumes[id])
        else:
            given = json.loads(body)
            try:
                scenes.Scene.model_validate(given["scene"])
            except ValueError as error:
                self._problem(422, "the scene is not valid", [{"field": "scene", "message": str(error)}])
                return
            if lacking := [path for path, file in _named(given["scene"], "scene") if file not in self.service.volumes]:
                faults = [{"field": path, "message": "must be sha256:… of an upload"} for path in lacking]
                self._problem(422, "the scene is not valid", faults)
                return
            if given["device"] not in ("any", *self.service.devices):
                fault = {"field": "device", "message": "must be any, or the kind or id of a device"}
                self._problem(422, "The job cannot have the device that it asks for.", [fault])
                return
            if given["reference"] not in (None, *self.service.jobs, *self.service.volumes):
                fault = {"field": "reference", "message": "must be the id of a job that has succeeded"}
                self._problem(422, "The picture cannot be held against this reference.", [fault])
                return
            id = self.service.add(given["scene"], given["name"])
            told = given["webhook"] and {
                "url": given["webhook"]["url"],
                "state": "waiting",
                "attempts": 0,
                "error": None,
            }
            self.service.secrets[id] = given["webhook"] and given["webhook"]["secret"]
            self.service.update(id, device=given["device"], reference=given["reference"], webhook=told)
            self._json(201, self.service.jobs[id])

    # Answers

    def _route(self) -> tuple[str, dict[str, str]]:
        url = urlsplit(self.path)
        path = unquote(url.path)
        self.service.requests.append((self.command, path))
        return path, {key: values[0] for key, values in parse_qs(url.query).items()}

    def _list(self, query: dict[str, str]) -> None:
        items = [
            job
            for job in reversed(self.service.jobs.values())
            if all(job[key] == query.get(key, job[key]) for key in ("state", "batch"))
        ]
        start, limit = int(query.get("cursor", 0)), int(query.get("limit", 50))
        more = str(start + limit) if start + limit < len(items) else None
        self._json(200, {"items": items[start : start + limit], "next": more})

    def _events(self, id: str) -> None:
        self._head(200, "text/event-stream", None)
        cut = self.service.streams_to_cut > 0
        self.service.streams_to_cut -= cut
        sent: dict[str, Any] | None = None
        while not self.service.stopping:
            with self.service.changed:
                while self.service.jobs[id] is sent and not self.service.stopping:
                    self.service.changed.wait()
                job = sent = self.service.jobs[id]
            over = job["state"] in ("succeeded", "failed", "cancelled")
            event = f": ping\n\nevent: {'end' if over else 'progress'}\ndata: {json.dumps(job)}\n\n".encode()
            self.wfile.write(b"%x\r\n%b\r\n" % (len(event), event))
            if cut:
                self.close_connection = True  # without the last chunk: broken, not ended
                return
            if over:
                break
        self.wfile.write(b"0\r\n\r\n")

    def _artifact(self, id: str, name: str) -> None:
        data = self.service.artifacts.get((id, name))
        if data is None:
            self._problem(404, f"{name} does not exist yet")
            return
        kind = {"preview.png": "image/png", "thumbnail.webp": "image/png", "report.json": "application/json"}.get(
            name, "image/x-exr"
        )
        self._head(200, kind, len(data))
        self.wfile.write(data[: len(data) // 2] if self.service.truncate else data)
        self.close_connection = self.service.truncate

    def _file(self, path: Path) -> None:
        self._send(200, TYPES.get(path.suffix, "image/svg+xml"), path.read_bytes())

    def _problem(self, status: int, detail: str, errors: list[dict[str, str]] | None = None) -> None:
        body = {"type": "about:blank", "title": "Refused", "status": status, "detail": detail, "errors": errors or []}
        self._send(status, "application/problem+json", json.dumps(body).encode())

    def _json(self, status: int, value: object) -> None:
        self._send(status, "application/json", json.dumps(value).encode())

    def _send(self, status: int, kind: str, body: bytes) -> None:
        self._head(status, kind, len(body))
        self.wfile.write(body)

    def _head(self, status: int, kind: str, length: int | None) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if length is None:
            self.send_header("Transfer-Encoding", "chunked")
        else:
            self.send_header("Content-Length", str(length))
        self.end_headers()


def _named(value: Any, path: str) -> Iterator[tuple[str, str]]:
    """The files that a scene names, by where."""
    if isinstance(value, dict):
        for key, item in value.items():
            if key == "file" and item is not None:
                yield f"{path}.file", item
            else:
                yield from _named(item, f"{path}.{key}")
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _named(item, f"{path}[{index}]")


STATES = ("queued", "running", "cancelling", "succeeded", "failed", "cancelled")
RETENTION = {"days": None, "size": None, "kept": 3 << 20, "freed": 0, "renders": [], "files": []}
DEVICE: dict[str, Any] = {
    "name": "A processor",
    "platform": "Portable Computing Language",
    "driver": "7.0",
    "kind": "cpu",
    "compute_units": 2,
    "memory": 1 << 33,
    "lanes": [1, 4, 8],
    "speed": 2.5e6,
    "state": "ready",
    "fault": None,
    "stability": "passed",
    "checked_at": "2025-01-01T00:00:00Z",
    "failures": [],
    "job": None,
    "waiting": 0,
    "links": {"stability": "/api/v1/devices/cpu0/stability"},
}
VOLUME = {"type": "volume", "grids": [{"name": "density", "type": "float", "shape": [2, 2, 2], "voxels": 8}]}
CONTENTS = {
    ".obj": {"type": "mesh", "grids": [], "triangles": 12},
    ".exr": {"type": "picture", "grids": [], "width": 4, "height": 2},
}
