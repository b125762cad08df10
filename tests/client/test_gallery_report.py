"""What a render's page shows of its report, in a real browser."""

from __future__ import annotations

import re
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from .reports import REPORT, fact
from .service import Service


def test_the_chart_is_read_by_keys_by_the_pointer_and_as_a_table(
    service: Service, page: Page, scene_json: dict[str, Any]
) -> None:
    id = service.add({**scene_json, "stop": {"kind": "relative_error", "relative_error": 0.02}}, "charted")
    service.advance(id, 64)
    service.finish(id, {**REPORT, "contract": {**REPORT["contract"], "kind": "relative_error", "asked": 0.02}})
    page.goto(f"{service.url}/renders/{id}")
    points = page.get_by_role("slider", name="Points of the chart")
    points.focus()
    expect(points).to_have_attribute("aria-valuetext", re.compile(r": 5 % after 13 s, 64 samples per pixel$"))
    page.keyboard.press("Home")
    expect(points).to_have_attribute("aria-valuetext", re.compile(r": 40 % after 0.2 s, 1 sample per pixel$"))
    page.keyboard.press("ArrowRight")
    expect(points).to_have_attribute("aria-valuenow", "2")
    expect(page.locator(".tip")).to_contain_text("20 %")
    page.locator("h1").click()
    expect(page.locator(".tip")).to_have_count(0)
    page.locator(".board .marker").nth(2).hover(force=True)
    expect(page.locator(".tip")).to_contain_text("10 %")
    expect(page.get_by_text("asked for: 2 %")).to_be_visible()
    expect(page.locator(".key")).to_contain_text("in its 95 % band")
    page.get_by_text("Values", exact=True).click()
    rows = page.locator(".error-chart tbody tr")
    expect(rows).to_have_count(4)
    expect(rows.first).to_have_text("40 %0.2 s1Estimated by its samples")


def test_what_went_wrong_is_told_in_plain_words(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json, "certified")
    service.advance(id, 64)
    service.finish(id, REPORT)
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".caution")).to_contain_text("denser somewhere than its bound")
    line = page.locator(".certificate li").filter(has_text="majorant")
    expect(line.get_by_text("tracked through the medium by valid bounds")).to_be_hidden()
    line.get_by_role("heading").click()
    expect(line).to_contain_text("It failed: the medium is denser somewhere than its bound")
    expect(line.get_by_text("tracked through the medium by valid bounds")).to_be_visible()


def test_a_report_that_cannot_be_had_is_asked_for_again(
    service: Service, page: Page, scene_json: dict[str, Any], said: list[str]
) -> None:
    id = service.add(scene_json, "without")
    service.advance(id, 64)
    service.finish(id, REPORT)
    report = service.artifacts.pop((id, "report.json"))
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".awaited")).to_contain_text("The report cannot be shown. report.json does not exist yet")
    service.artifacts[id, "report.json"] = report
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_role("heading", name="Certificate")).to_be_visible()
    assert all("404" in text for text in said)
    said.clear()


def test_what_a_button_cannot_do_is_told_beside_it(
    service: Service, page: Page, scene_json: dict[str, Any], said: list[str]
) -> None:
    id = service.add(scene_json, "refused")
    service.advance(id, 64)
    service.finish(id, REPORT)
    page.goto(f"{service.url}/renders/{id}")
    page.get_by_role("button", name="Extend to half the error").wait_for()
    service.refuse(429, "You have 9 jobs; 9 are the most.")
    page.get_by_role("button", name="Extend to half the error").click()
    expect(page.locator(".actions + .fault")).to_have_text("You have 9 jobs; 9 are the most.")
    assert all("429" in text for text in said)
    said.clear()


def test_a_report_tells_how_the_error_fell(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json, "told")
    service.advance(id, 64)
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".numbers")).to_have_text("64 of 64 samples per pixel")
    assert page.locator("a", has_text="Report page").count() == 0
    service.finish(id, REPORT)
    expect(page.get_by_role("link", name="Report page")).to_have_attribute("href", f"/api/v1/jobs/{id}/report.html")
    assert fact(page, "Stops after") == "64 samples per pixel kept"
    assert fact(page, "Samples") == "64 per pixel"
    assert fact(page, "Error falls as") == "t−0.50 as expected, −0.53 to −0.47 with 95 %"
    assert fact(page, "Efficiency") == "1 235 1 / (variance × seconds)"
    expect(page.get_by_text("Devices were rendering for 93 % of their time")).to_be_visible()
    assert page.locator(".board .open, .caution .slope").count() == 0
    assert page.get_by_text("True error").count() == 0


def test_a_picture_is_shown_against_its_reference(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json, "held against")
    service.advance(id, 64)
    service.update(id, reference=f"sha256:{'0123456789abcdef' * 4}")
    against = {"mse": 0.0004, "rel_mse": 0.01, "smape": 0.02, "bias": -0.001, "bias_error": 0.0005, "flip": 0.031}
    points = [{**point, "against": {**against, "mse": 0.04 / 4**i}} for i, point in enumerate(REPORT["error"])]
    points[0]["against"] = None  # a point of before is none of the curve's
    service.finish(id, {**REPORT, "error": points, "reference": "right.exr", "against": against})
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".table").first).to_contain_text("sha256:01234567…")
    assert fact(page, "True error") == "4 % mean off by -0.2 % ± 0.1 %, ꟻLIP 0.031"
    expect(page.locator(".board .marker.open")).to_have_count(3)
    expect(page.locator(".board .marker:not(.open)")).to_have_count(4)
    centre = "all => all.map(one => one.getBBox()).map(box => [box.x + box.width / 2, box.y + box.height / 2])"
    estimated, true = (page.locator(f".board .marker{mark}").evaluate_all(centre) for mark in (":not(.open)", ".open"))
    assert true == [pytest.approx(at, abs=0.1) for at in estimated[1:]], "the two are equal"
    expect(page.locator(".key")).to_contain_text("True, against the reference 5 %")


def test_a_report_of_before_is_shown_as_it_was(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    """It knows of no contract, and there is no page of it."""
    id = service.add(scene_json, "old")
    service.advance(id, 64)
    new = ("contract", "slope", "efficiency", "mean_samples", "utilisation", "reference", "against")
    service.finish(id, {key: value for key, value in REPORT.items() if key not in new})
    page.goto(f"{service.url}/renders/{id}")
    expect(page.get_by_role("heading", name="Error over time")).to_be_visible()
    assert fact(page, "Stops after") == "64 samples per pixel"
    assert page.get_by_role("link", name="Report page").count() == 0
