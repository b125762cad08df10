"""The report's page, as it is served: that it works under its policy, and that nothing else does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page, expect
from sqlalchemy import update
from starlette.testclient import TestClient
from tests.client.conftest import browser as browser
from tests.client.conftest import context as context
from tests.client.conftest import page as page
from tests.client.conftest import said as said

from woodcock_server.jobs.states import State
from woodcock_server.tables import jobs

from .conftest import Service

Make = Callable[..., dict[str, Any]]


def succeeded(client: TestClient, scene: dict[str, Any]) -> str:
    """A job that ended, of which nothing is on the disk."""
    job_id = str(client.post("/api/v1/jobs", json={"scene": scene}).json()["id"])
    services: Any = client.app.state.services  # type: ignore[attr-defined]
    with services.engine.begin() as connection:
        connection.execute(update(jobs).where(jobs.c.id == job_id).values(state=State.SUCCEEDED))
    services.storage.open_job(job_id)
    return job_id


def test_a_page_works_under_its_policy_and_reaches_nothing(
    service: Service, make_scene: Make, page: Page, said: list[str]
) -> None:
    attack = "<script>document.title = 'taken'</script><img src=x onerror=\"document.title = 'taken'\">"
    job_id = service.submit(make_scene(size=32, samples=200), name=attack)
    job = service.wait(job_id, lambda job: bool(job["state"] == "succeeded"))
    page.goto(f"{service.http.base_url}{job['links']['report_page']}".replace("//api", "/api"))
    expect(page.get_by_role("heading", level=1)).to_have_text(attack)
    assert page.title().startswith(attack)
    expect(page.locator(".book.live").first).to_be_visible()  # its script runs
    assert page.evaluate("getComputedStyle(document.body).paddingTop") != "0px"  # and its style is there
    assert page.locator("img[src=x]").count() == 0
    assert said == [], "the policy forbids nothing that it needs"

    assert page.evaluate("origin") == "null", "what runs in it is not of the service's origin"
    for address in ("/api/v1/jobs", "data:,1"):
        assert page.evaluate("address => fetch(address).then(() => 'reached', () => 'refused')", address) == "refused"
    page.evaluate("document.body.append(Object.assign(document.createElement('script'), {text: 'document.title = 1'}))")
    assert page.title().startswith(attack), "no script but its own runs"
    assert len(said) >= 3
    said.clear()


def test_the_policy_is_the_page_s_own(client: TestClient, make_scene: Make) -> None:
    """It names the script by its hash, and a page of an older version has that version's."""
    job_id = succeeded(client, make_scene())
    storage: Any = client.app.state.services.storage  # type: ignore[attr-defined]
    policy = "default-src &#39;none&#39;; script-src &#39;sha256-X&#39;"
    meta = f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
    for text, policy in (
        (f"<!doctype html>{meta}", "default-src 'none'; script-src 'sha256-X'"),
        ("<!doctype html>", "default-src 'none'"),
    ):
        storage.write_text(job_id, "report.html", text)
        answer = client.get(f"/api/v1/jobs/{job_id}/report.html")
        assert answer.text == text
        assert answer.headers["content-type"] == "text/html; charset=utf-8"
        assert answer.headers["x-content-type-options"] == "nosniff"
        own, *rest = answer.headers["content-security-policy"].split("; frame-ancestors 'none'")
        assert (own, rest) == (policy, ["; sandbox allow-scripts"])


def test_a_job_of_before_has_no_page_and_says_so(client: TestClient, make_scene: Make) -> None:
    job_id = succeeded(client, make_scene())
    answer = client.get(f"/api/v1/jobs/{job_id}/report.html")
    assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json")
    assert "ended under a version that wrote none" in answer.json()["detail"]


def test_the_report_is_described(client: TestClient) -> None:
    described = client.get("/openapi.json").json()
    content = described["paths"]["/api/v1/jobs/{id}/report.json"]["get"]["responses"]["200"]["content"]
    assert content == {"application/json": {"schema": {"$ref": "#/components/schemas/Report"}}}
    assert {"contract", "error", "slope", "against"} <= set(described["components"]["schemas"]["Report"]["properties"])
