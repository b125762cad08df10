"""What this server has done since it started, for Prometheus; jobs by state are the database's, which servers share.

Labels come from small sets: states, devices, stages, lines of the certificate, routes and statuses.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram
from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: Upper ends of buckets, seconds: from a preview of a small scene to a night in the queue.
SECONDS = (0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 300, 1800, 7200, 36000)
#: Of answers.
REQUEST_SECONDS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 10)
#: Of errors relative to the mean luminance: three a decade.
ERRORS = (*(float(f"{digit}e{power}") for power in range(-5, 0) for digit in (1, 2, 5)), 1.0)
#: Of efficiencies, whose scale is the scene's own: decades.
EFFICIENCIES = tuple(10.0**power for power in range(-2, 11))


class Metrics:
    """The metrics of one application, in a registry of their own."""

    def __init__(self) -> None:
        self.registry = registry = CollectorRegistry()
        self.jobs = Gauge("woodcock_jobs", "Jobs in the database, by state.", ["state"], registry=registry)
        self.finished = Counter(
            "woodcock_jobs_finished", "Jobs that this server brought to an end.", ["outcome"], registry=registry
        )
        self.queue_wait = Histogram(
            "woodcock_queue_wait_seconds", "From a job's submission to its first claim.", registry=registry,
            buckets=SECONDS,
        )  # fmt: skip
        self.first_preview = Histogram(
            "woodcock_first_preview_seconds", "From a job's first claim to its first preview.", registry=registry,
            buckets=SECONDS,
        )  # fmt: skip
        self.samples = Counter("woodcock_samples", "Samples rendered, of single pixels.", ["device"], registry=registry)
        self.render_seconds = Counter(
            "woodcock_render_seconds", "Time in which a device rendered.", ["device"], registry=registry
        )
        self.speed = Gauge(
            "woodcock_device_samples_per_second", "Samples of single pixels by the second, of the latest range.",
            ["device"], registry=registry,
        )  # fmt: skip
        self.speeds: dict[str, float] = {}  # the same
        self.utilisation = Gauge(
            "woodcock_device_utilisation_ratio", "Share of the latest job's rendering time in which a device rendered.",
            ["device"], registry=registry,
        )  # fmt: skip
        self.stage_seconds = Counter(
            "woodcock_stage_seconds",
            "Time for what is not rendering: read, build, upload (of all devices), merge, check, write.",
            ["stage"], registry=registry,
        )  # fmt: skip
        self.programs = Counter(
            "woodcock_programs",
            "Programs that jobs began with: of the scene's own cached or built, or the generic one.",
            ["found"], registry=registry,
        )  # fmt: skip
        self.relative_error = Histogram(
            "woodcock_relative_error_ratio", "Estimated error of finished pictures over their mean luminance.",
            registry=registry, buckets=ERRORS,
        )  # fmt: skip
        self.efficiency = Histogram(
            "woodcock_efficiency", "1 / (variance of a pixel × seconds) of finished jobs, in the scene's unit.",
            registry=registry, buckets=EFFICIENCIES,
        )  # fmt: skip
        self.slope_flagged = Counter(
            "woodcock_slope_flagged", "Finished jobs whose error did not fall as it should.", registry=registry
        )
        self.lines_failed = Counter(
            "woodcock_certificate_lines_failed", "Lines of certificates that failed.", ["line"], registry=registry
        )
        self.requests = Counter(
            "woodcock_http_requests", "Answers, by route and status.", ["route", "status"], registry=registry
        )
        self.request_seconds = Histogram(
            "woodcock_http_request_seconds", "Until an answer begins, by route.", ["route"], registry=registry,
            buckets=REQUEST_SECONDS,
        )  # fmt: skip
        for outcome in ("succeeded", "failed"):
            self.finished.labels(outcome)
        for found in ("cached", "built", "generic"):
            self.programs.labels(found)

    def claimed(self, row: Mapping[str, Any], now: datetime) -> None:
        """A job leaves the queue; only its first claim counts, for what comes after is no waiting of its own."""
        if row["token"] == 1:
            self.queue_wait.observe((now - row["created_at"]).total_seconds())

    def rendered(self, device: str, samples: int, seconds: float) -> None:
        """A device rendered so many samples of single pixels."""
        self.samples.labels(device).inc(samples)
        self.render_seconds.labels(device).inc(seconds)
        if seconds > 0:
            self.speeds[device] = samples / seconds
            self.speed.labels(device).set(self.speeds[device])

    def prepared(self, found: str, seconds: Mapping[str, float]) -> None:
        """A device is ready for a job. found: of woodcock.start.Start; seconds: of read, build and upload."""
        self.programs.labels(found).inc()
        self.spent(seconds)

    def spent(self, seconds: Mapping[str, float]) -> None:
        """Time went into these stages."""
        for stage, each in seconds.items():
            self.stage_seconds.labels(stage).inc(each)

    def succeeded(self, report: Mapping[str, Any]) -> None:
        """A job is done. report: its report.json."""
        self.finished.labels("succeeded").inc()
        if (lasted := report["seconds"]["render"]) > 0:
            for use in report["devices"]:
                self.utilisation.labels(use["id"]).set(use["render_seconds"] / lasted)
        for histogram, value in (
            (self.relative_error, report["relative_rmse"]),
            (self.efficiency, report["efficiency"]),
        ):
            if value is not None:
                histogram.observe(value)
        if report["slope"]["verdict"] == "flagged":
            self.slope_flagged.inc()
        for line in report["certificate"]["failed"]:
            self.lines_failed.labels(line).inc()


class CountRequests:
    """ASGI middleware: counts and times every answer when it begins."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self.app = app
        self.metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self.app(scope, receive, send)
        answered, began = False, time.monotonic()

        def count(status: int) -> None:
            nonlocal answered
            answered, route = True, _route(scope)
            self.metrics.requests.labels(route, str(status)).inc()
            self.metrics.request_seconds.labels(route).observe(time.monotonic() - began)

        async def counted(message: Message) -> None:
            if message["type"] == "http.response.start":
                count(message["status"])
            await send(message)

        try:
            return await self.app(scope, receive, counted)
        except Exception:
            if not answered:  # The outermost layer, beyond this one, will answer.
                count(500)
            raise


def _route(scope: Scope) -> str:
    """The template of a path, never the path: whoever asks must not make labels."""
    if route := scope.get("route"):
        return str(route.path)
    if "endpoint" in scope:  # A mount, by where it is mounted; else a route without parameters.
        return str(scope["root_path"] or scope["path"])
    return "none"
