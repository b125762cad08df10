"""Mistakes of the service: in what it renders, in its books over restarts, in what it tells."""

from __future__ import annotations

from tests.mutants.sin import Sin

BOOKS = "tests/server/test_books.py"
CRASH = "tests/server/test_contracts.py::test_a_relative_error_goes_on_after_a_crash"
METRICS = "tests/server/test_metrics.py"
REFERENCES = "tests/server/test_references.py"
ROUNDS = "tests/server/test_rounds.py"
TOLD = "tests/server/test_webhooks.py"
DELIVERIES = "tests/server/test_deliveries.py"
NETWORK = "tests/server/test_webhook_network.py"


def server(path: str) -> str:
    """A file of the service."""
    return f"server/woodcock_server/{path}"


SINS = (
    Sin(
        "a job that goes on begins its contract anew",
        server("rendering.py"),
        "in_thread(Rounds, self._scene, self.devices, self._film, self._longest)",
        "in_thread(Rounds, self._scene, self.devices, None, self._longest)",
        (CRASH,),
    ),
    Sin(
        "device seconds count once per restart",
        server("books.py"),
        'before["render_seconds"] if before else 0.0',
        "0.0",
        (f"{BOOKS}::test_books_fit_the_film_that_a_crash_leaves",),
    ),
    Sin(
        "what a crash left half-written counts",
        server("books.py"),
        'said = kept if kept and kept["samples"] == film.mean_samples else self._row',
        "said = self._row",
        (f"{BOOKS}::test_books_fit_the_film_that_a_crash_leaves",),
    ),
    Sin(
        "a round ends with its last piece handed out",
        server("rounds.py"),
        "return not (self._unmerged or self._pool.left)",
        "return not self._pool.left",
        (f"{ROUNDS}::test_a_round_waits_for_all_of_its_pieces",),
    ),
    Sin(
        "a device's speed is that of whole pictures",
        server("rounds.py"),
        "piece.stop - piece.start, seconds, piece.width(self._pixels))",
        "piece.stop - piece.start, seconds, self._pixels)",
        (f"{ROUNDS}::test_a_range_of_few_pixels_takes_as_long_as_one_of_all",),
    ),
    Sin(
        "what waits for a device takes no time",
        server("rounds.py"),
        "left = self._stop.seconds - seconds - (ahead / pace.rate if ahead else 0.0)",
        "left = self._stop.seconds - seconds",
        (f"{ROUNDS}::test_seconds_end_by_the_clock_and_not_without_a_sample",),
    ),
    Sin(
        "errors are taken to fall as 1/n",
        server("jobs/schemas.py"),
        '(stop["relative_error"] / row["reached"]) ** 2',
        '(stop["relative_error"] / row["reached"])',
        ("tests/server/test_jobs.py::test_a_relative_error_is_as_far_as_its_samples",),
    ),
    Sin(
        "a reference may have any size",
        server("jobs/reference.py"),
        "if size != (width, height):",
        "if size == (0, 0):",
        (f"{REFERENCES}::test_another_size_is_told",),
    ),
    Sin(
        "a job that failed is a reference",
        server("jobs/reference.py"),
        'if row["state"] != State.SUCCEEDED:',
        'if row["state"] == State.QUEUED:',
        (f"{REFERENCES}::test_a_job_that_has_not_succeeded_is_none",),
    ),
    Sin(
        "whoever asks makes labels",
        server("metrics.py"),
        "return str(route.path)",
        'return str(scope["path"])',
        (f"{METRICS}::test_requests_are_counted_by_route_never_by_path",),
    ),
    Sin(
        "samples are counted per pixel",
        server("rendering.py"),
        "int(film.count.sum())",
        "film.samples",
        (f"{METRICS}::test_a_job_is_counted",),
    ),
    Sin(
        "a report's page is of the service's origin",
        server("jobs/endpoints.py"),
        "sandbox allow-scripts",
        "sandbox allow-scripts allow-same-origin",
        ("tests/server/test_report_page.py::test_a_page_works_under_its_policy_and_reaches_nothing",),
    ),
    Sin(
        "a failure is not told of",
        server("jobs/repository.py"),
        "    if state.final:",
        "    if state is State.SUCCEEDED:",
        (f"{TOLD}::test_every_end_is_due_in_its_own_transaction",),
    ),
    Sin(
        "two servers make the same attempt",
        server("webhooks/repository.py"),
        'values = {"attempts": webhooks.c.attempts + 1, "due_at": until}',
        'values = {"attempts": webhooks.c.attempts + 1}',
        (f"{DELIVERIES}::test_servers_that_share_a_database_send_each_once",),
    ),
    Sin(
        "a signature holds for ever",
        server("webhooks/signature.py"),
        'f"{id}.{timestamp}.".encode() + body',
        'f"{id}.".encode() + body',
        (f"{DELIVERIES}::test_the_signature_is_the_specifications",),
    ),
    Sin(
        "IPv6 leads to internal IPv4",
        server("webhooks/network.py"),
        "return address.ipv4_mapped",
        'return IPv4Address("1.1.1.1")',
        (f"{NETWORK}::test_what_is_internal",),
    ),
    Sin(
        "who is connected to is not looked at",
        server("webhooks/network.py"),
        "if permitted(ip_address(peer), self._allowed):",
        "if peer:",
        (f"{NETWORK}::test_a_peer_that_is_another_than_was_asked_for_gets_nothing",),
    ),
    Sin(
        "a webhook's secret is told back",
        server("problems.py"),
        'error = {**error, "input": None}',
        "error = {**error}",
        (f"{TOLD}::test_a_fault_of_a_webhook_is_named_and_what_it_has_is_not_told_back",),
    ),
)
