"""The fleet in a real browser, with faults that the service itself cannot be asked for."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import Page, expect

from .service import Service


def test_a_device_that_is_not_trusted_says_why(service: Service, page: Page, said: list[str]) -> None:
    lost = "jobs, 0123: The process that renders on gpu0 died 4 times while rendering."
    of = {"name": "A graphics card", "kind": "gpu", "state": "distrusted", "stability": "failed", "failures": [lost]}
    service.devices["gpu0"] = {**service.devices["cpu0"], **of, "speed": None, "waiting": 1200}
    fault = {"state": "failed", "stability": "not checked", "fault": "The driver is on fire.", "checked_at": None}
    service.devices["gpu1"] = {**service.devices["cpu0"], **fault, "lanes": []}
    case = {"group": "depth", "case": "1000", "expected": 1.0, "got": None, "deviation": 9.0, "limit": 5.0}
    row = {**case, "unit": "roundings", "verdict": "failed", "says": "not a number", "seconds": 0.1}
    passed = {**row, "case": "1", "got": 1.0, "deviation": 0.5, "verdict": "passed", "says": ""}
    moments = {"started_at": "2025-01-01T00:00:00Z", "finished_at": "2025-01-01T00:02:00Z"}
    service.checks["gpu0"] = {
        "device": "gpu0", "state": "failed", "version": "0.1.0", **moments, "rows": [passed, row]
    }  # fmt: skip
    page.goto(f"{service.url}/fleet")
    first, second, third = (page.locator(".device-card").nth(index) for index in range(3))
    expect(first).to_contain_text("2.5 million samples a second")
    expect(second.locator(".badge")).to_have_text("Distrusted")
    expect(second).to_contain_text("It is in quarantine: renders were lost on it")
    expect(second).to_contain_text(lost)
    expect(second).to_contain_text("Waiting1 200 renders")
    second.get_by_text("Its cases").click()
    expect(second).to_contain_text("1 failed, 1 passed, by Woodcock 0.1.0, in 2 min 00 s")
    expect(second.locator("tbody tr").first).to_have_text("depth, 1000not a numberfailed1–9 roundings5")
    expect(third).to_contain_text("It cannot even build and run a program.")
    expect(third.get_by_role("button")).to_have_count(0)
    service.refuse(403, "The token may not check devices.")
    first.get_by_role("button", name="Check again").click()
    expect(first.get_by_role("alert")).to_have_text("The token may not check devices.")
    assert all("403" in text for text in said)
    said.clear()


def test_failures_are_told_by_reason(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    lost = "The process that renders on cpu0 died 4 times while rendering. It is killed when it takes more than 9 MiB."
    errors = [*7 * [lost], "volumes[0]: leads beyond all numbers", f"sha256:{64 * 'a'}: is not closed", None]
    for number, error in enumerate(errors):
        id = service.add(scene_json, f"render {number}")
        service.update(id, state="failed", error=error, finished_at="2025-01-01T00:00:00Z")
    heard = {"url": "https://example.org/hook", "state": "given up", "attempts": 8, "error": "503 was answered"}
    service.update(id, webhook=heard)
    page.goto(f"{service.url}/fleet")
    expect(page.locator(".reasons h3")).to_contain_text(
        [
            "No reason was given 1 render",
            "A file that the scene names cannot be used 1 render",
            "The scene cannot be rendered as it is 1 render",
            "A device’s process died again and again 7 renders",
        ]
    )
    died = page.locator(".reasons > li").last
    expect(died.get_by_role("link", name="render 0")).to_be_hidden()
    died.get_by_text("2 more").click()
    expect(died.get_by_role("link", name="render 0")).to_be_visible()
    expect(page.get_by_text("https://example.org/hook: 503 was answered")).to_be_visible()


def test_what_is_next_to_go_is_told(service: Service, page: Page) -> None:
    due = {"comparison": None, "jobs": ["a"], "name": "old", "finished_at": "2025-01-01T00:00:00Z", "size": 1 << 20}
    service.retention |= {"days": 30.0, "size": 4 << 20, "freed": 1 << 20, "renders": [due]}
    page.goto(f"{service.url}/fleet")
    expect(
        page.get_by_text("renders that ended more than 30 days ago are deleted, and the oldest go once")
    ).to_be_visible()
    expect(page.get_by_text("Next to go: 1 render and 0 files, 1 MiB.")).to_be_visible()
    expect(page.locator("meter")).to_have_attribute("value", str(3 << 20))


def test_a_fleet_without_devices_and_one_out_of_reach(service: Service, page: Page, said: list[str]) -> None:
    service.devices.clear()
    page.goto(f"{service.url}/fleet")
    expect(page.get_by_text("No device was found when the service started")).to_be_visible()
    expect(page.get_by_text("Nothing that is kept here has failed.")).to_be_visible()
    service.broken = (500, "text/plain", b"")
    expect(page.get_by_text("The service does not answer. What you see may be old")).to_be_visible()
    service.broken = None
    expect(page.get_by_text("The service does not answer.")).to_be_hidden()
    assert all("500" in text for text in said)
    said.clear()


@pytest.mark.parametrize("width", [320, 390, 900])
def test_the_fleet_fits(service: Service, page: Page, scene_json: dict[str, Any], width: int) -> None:
    service.devices["gpu0"] = {
        **service.devices["cpu0"],
        "name": "w" * 90,
        "failures": ["x" * 200],
        "state": "distrusted",
    }
    service.update(service.add(scene_json, "w" * 150), state="failed", error="x" * 300)
    page.set_viewport_size({"width": width, "height": 700})
    page.goto(f"{service.url}/fleet")
    expect(page.locator(".reasons")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= width
