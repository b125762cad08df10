"""The page of one render, in a real browser."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from .reports import REPORT, fact
from .service import Service


def test_a_render_shows_its_progress_and_then_its_report(
    service: Service, page: Page, scene_json: dict[str, Any]
) -> None:
    id = service.add(scene_json, "followed")
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".badge")).to_have_text("Queued")
    for samples in (16, 32):
        service.advance(id, samples)
        expect(page.locator(".numbers")).to_have_text(f"{samples} of 64 samples per pixel")
        expect(page.locator(".stage img")).to_have_attribute("src", re.compile(f"samples={samples}$"))
    expect(page.locator(".figures")).to_contain_text("8.84 %")
    expect(page.locator(".explain").first).to_contain_text("0.0442 in the scene’s unit of radiance")
    expect(page.get_by_text("EXR not yet")).to_be_visible()
    expect(page).to_have_title("50 % · followed · Woodcock")
    service.advance(id, 64)
    service.finish(id, REPORT)
    expect(page.locator(".badge")).to_have_text("Done")
    expect(page.get_by_role("link", name="EXR")).to_be_visible()
    expect(page.locator(".table").first).to_contain_text("A processor cpu0: 64 samples in 3.0 s, 8 at a time")
    expect(page.locator(".caution")).to_contain_text("σ_t exceeded its majorant 12 times")
    expect(page.locator(".caution")).not_to_contain_text("finite")
    lines = page.locator(".certificate li")
    expect(lines).to_have_text(
        [
            re.compile(r"✓\s*samples\s+passed\s*Every sample"),
            re.compile(r"✗\s*majorant\s+failed\s*σ_t exceeded"),
            re.compile(r"\?\s*rounding\s+not checked\s*No doubles"),
            re.compile(r"·\s*build\s*Built without flags"),
        ],
        use_inner_text=True,
        ignore_case=True,
    )
    expect(page.locator(".report code").first).to_have_text("9f3c2a77b1e04d55")
    expect(page.get_by_text("perspective")).to_be_visible()
    expect(page.get_by_role("img", name="The error fell from 40 % after 0.2 s to 5 % after 13 s.")).to_be_visible()


def test_a_relative_error_is_shown_with_what_was_reached(
    service: Service, page: Page, scene_json: dict[str, Any]
) -> None:
    id = service.add({**scene_json, "stop": {"kind": "relative_error", "relative_error": 0.02, "per": "tile"}}, "tiles")
    service.advance(id, 32)
    page.goto(service.url)
    expect(page.locator(".card")).to_contain_text("tiles")
    page.locator(".card").click()
    expect(page.locator(".numbers")).to_have_text("32 samples per pixel, down to an error of 2 % in every tile")
    assert fact(page, "Stops at") == "an error of 2 % in every tile"
    missed = {"kind": "relative_error", "asked": 0.02, "reached": 0.0312, "met": False, "says": "More was asked for."}
    unknown = {"slope": None, "low": None, "high": None, "verdict": "not known", "says": ""}
    service.advance(id, 64)
    service.finish(id, {**REPORT, "contract": missed, "slope": unknown, "efficiency": None, "mean_samples": 40.25})
    expect(page.locator(".table").first).to_contain_text("not kept: reached 3.12 %")
    assert fact(page, "Samples") == "64 per pixel at most, 40.3 on average"
    assert page.get_by_text("Error falls as").count() == page.get_by_text("Efficiency").count() == 0
    service.artifacts[id, "report.json"] = json.dumps(
        {**REPORT, "contract": {**missed, "met": True, "reached": 0.0199}}
    ).encode()
    page.reload()
    expect(page.locator(".table").first).to_contain_text("an error of 2 % in every tile reached 1.99 %")


def test_a_picture_without_noise_shows_its_bound(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json, "shadow")
    service.advance(id, 64)
    service.update(id, integrator="transmittance", rmse=3e-7, relative_rmse=None)
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".figures")).to_contain_text("Error at most")
    expect(page.locator(".figures")).to_contain_text("3.0 × 10⁻⁷")
    service.update(id, relative_rmse=6e-7)
    medium = {
        "kind": "grid",
        "sigma_t": [5.5],
        "storage": {"density": {"kind": "half", "error": 0.0005}},
        "emits": False,
        "scatters": False,
        "coloured": False,
    }
    device = {**REPORT["devices"][0], "precision": "double", "media": [medium]}
    bound = {"largest": 2e-6, "rms": 3e-7}
    nothing = {"certificate": {"failed": [], "not_checked": [], "lines": []}, "error": [], "orders": None}
    service.finish(id, {**REPORT, **nothing, "deterministic": True, "bound": bound, "devices": [device]})
    expect(page.locator(".explain").first).to_contain_text("no noise. The error is at most this, root mean square")
    expect(page.locator(".explain").first).to_contain_text("at most 2.0 × 10⁻⁶ in any pixel")
    facts = page.locator(".table").first
    expect(facts).to_contain_text("transmittance without random numbers")
    expect(facts).to_contain_text("8 at a time, in double precision")
    expect(page.get_by_text("stored as half, off by 0.05 % of its largest at most")).to_be_visible()
    expect(page.get_by_role("heading", name="Error over time")).to_have_count(0)
    expect(page.locator(".caution")).to_have_count(0)
    page.goto(service.url)
    expect(page.locator(".card")).to_contain_text("≤ 6.0 × 10⁻⁵ %")


def test_a_bound_that_is_not_known_is_not_shown_as_one(
    service: Service, page: Page, scene_json: dict[str, Any]
) -> None:
    id = service.add(scene_json, "opaque")
    service.advance(id, 64)
    service.update(id, integrator="emission_absorption", rmse=None, relative_rmse=None)
    service.finish(id, {**REPORT, "deterministic": True, "bound": {"largest": None, "rms": None}, "error": []})
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".figures")).to_contain_text("Error at most–")
    expect(page.locator(".explain").first).to_contain_text("has no bound")


def test_what_the_series_leaves_out_is_shown(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    rest = {"last": 2, "rest": 0.03, "rest_error": 0.001, "norm": 0.5}
    for bound, shown in ((0.25, "6 % ± 0.2 % of the light at most 50 %"), (None, "6 % ± 0.2 % of the light")):
        id = service.add(scene_json, "orders")
        service.advance(id, 64)
        service.update(id, integrator="volumetric_path")
        service.finish(id, {**REPORT, "mean_luminance": 0.5, "orders": {**rest, "rest_bound": bound}})
        page.goto(f"{service.url}/renders/{id}")
        row = page.locator(".table > div", has_text="After order 2")
        expect(row.locator("dd")).to_have_text(shown)
        expect(page.locator(".table").first).to_contain_text("volumetric_path by random paths")


def test_devices_say_whether_they_are_to_be_trusted(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    broken = {"state": "distrusted", "stability": "failed", "failures": ["albedo, 1: off"]}
    service.devices["gpu0"] = {**service.devices["cpu0"], "name": "A graphics card", "kind": "gpu", **broken}
    service.devices["gpu1"] = {**service.devices["cpu0"], "name": "Another card", "stability": "not checked"}
    id = service.add(scene_json, "asked for")
    waits = "It waits for the stability check of gpu0."
    service.update(id, device="gpu0", waiting=waits)
    page.goto(service.url)
    expect(page.locator(".card")).to_contain_text(waits)
    page.locator(".card").click()
    expect(page.get_by_text(waits)).to_be_visible()
    asked = page.locator(".table > div", has_text="Asked for")
    expect(asked.locator("dd")).to_have_text("A graphics card gpu0failed its stability check")
    service.update(id, waiting=None)
    service.advance(id, 64)
    expect(page.get_by_text(waits)).to_have_count(0)
    ids = ("cpu0", "gpu0", "gpu1", "gpu7")
    service.update(id, devices=list(ids))
    uses = [{**REPORT["devices"][0], "id": each, "name": service.devices[each]["name"]} for each in ids[:3]]
    uses[2]["name"] = "A card that is no longer here"
    service.finish(id, {**REPORT, "devices": uses[:2]})
    shown = page.locator(".table > div", has_text="Devices").locator(".device")
    expect(shown).to_have_count(4)
    expect(shown.nth(0)).to_have_text(re.compile(r"^A processor cpu0: 64 samples in 3.0 s, 8 at a time$"))
    expect(shown.nth(1)).to_have_text(re.compile(r"^A graphics card gpu0: .* timefailed its stability check$"))
    expect(shown.nth(1).locator(".stability")).to_have_class("stability failed")
    expect(shown.nth(2)).to_have_text("Another card gpu1its stability is not checked")
    expect(shown.nth(3)).to_have_text(re.compile("^gpu7 $"))
    service.artifacts[id, "report.json"] = json.dumps({**REPORT, "devices": uses}).encode()
    page.reload()
    expect(shown.nth(2)).to_contain_text("A card that is no longer here gpu1: ")
    expect(shown.nth(2).locator(".stability")).to_have_count(0)

    other = service.add(scene_json, "left to the service")
    page.goto(f"{service.url}/renders/{other}")
    expect(page.get_by_role("heading", name="left to the service")).to_be_visible()
    expect(page.get_by_text("Asked for")).to_have_count(0)


def test_a_broken_stream_is_picked_up(
    service: Service, page: Page, scene_json: dict[str, Any], said: list[str]
) -> None:
    id = service.add(scene_json, "followed")
    service.streams_to_cut = 1
    page.goto(f"{service.url}/renders/{id}")
    expect(page.get_by_text("The service does not answer.")).to_be_visible()
    expect(page.get_by_text("The service does not answer.")).to_be_hidden()
    service.advance(id, 64)
    service.finish(id)
    expect(page.locator(".badge")).to_have_text("Done")
    assert all("ERR_INCOMPLETE_CHUNKED_ENCODING" in line for line in said)
    said.clear()


def test_a_hidden_tab_lets_go_of_its_stream(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json, "hidden")
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".numbers")).to_have_text("0 of 64 samples per pixel")
    show = """hidden => {
        Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
        document.dispatchEvent(new Event("visibilitychange"));
    }"""
    page.evaluate(show, True)
    streams = service.requests.count(("GET", f"/api/v1/jobs/{id}/events"))
    service.advance(id, 32)
    page.wait_for_timeout(300)
    expect(page.locator(".numbers")).to_have_text("0 of 64 samples per pixel")
    page.evaluate(show, False)
    expect(page.locator(".numbers")).to_have_text("32 of 64 samples per pixel")
    assert service.requests.count(("GET", f"/api/v1/jobs/{id}/events")) == streams + 1


def test_a_render_that_stops_is_followed_to_its_end(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json, "stopping")
    service.update(id, state="cancelling")
    page.goto(f"{service.url}/renders/{id}")
    expect(page.locator(".badge")).to_have_text("Stopping")
    service.update(id, state="cancelled")
    expect(page.locator(".badge")).to_have_text("Cancelled")


def test_a_failure_is_told_in_words_and_nothing_runs_as_markup(
    service: Service, page: Page, scene_json: dict[str, Any]
) -> None:
    attack = "<img src=x onerror='document.title=1'><script>document.title=2</script>"
    id = service.add(scene_json, attack)
    service.update(id, state="failed", error=f"the device ran out of memory {attack}\n\nclFinish: -5")
    other = service.add(scene_json, "open mesh")
    service.update(other, state="failed", error=f"sha256:{'0123456789abcdef' * 4}: is not closed")
    page.goto(service.url)
    expect(page.locator(".card").first).to_contain_text("sha256:01234567…: is not closed")
    service.jobs.pop(other)
    page.goto(service.url)
    expect(page.locator(".card")).to_contain_text(attack)
    page.locator(".card").click()
    expect(page.locator(".failure")).to_contain_text(f"the device ran out of memory {attack}")
    expect(page.get_by_text("clFinish: -5")).to_be_hidden()
    page.get_by_text("Everything that was said").click()
    expect(page.get_by_text("clFinish: -5")).to_be_visible()
    expect(page.get_by_role("heading", level=1)).to_have_text(attack)
    expect(page.get_by_text("EXR none")).to_be_visible()
    expect(page).to_have_title(f"{attack} · Woodcock")
    assert page.locator("img[src=x], main script").count() == 0


def test_a_render_that_is_not_there(service: Service, page: Page, said: list[str]) -> None:
    page.goto(f"{service.url}/renders/nope")
    expect(page.get_by_role("heading", name="There is no such render")).to_be_visible()
    page.get_by_role("link", name="All renders").click()
    expect(page.get_by_role("heading", name="Nothing rendered yet")).to_be_visible()
    assert all("404" in line for line in said)
    said.clear()


@pytest.mark.parametrize("width", [320, 390, 900, 2560])
def test_no_width_scrolls_sideways(service: Service, page: Page, scene_json: dict[str, Any], width: int) -> None:
    id = service.add(scene_json, "w" * 150)
    service.update(id, state="failed", error="x" * 300)
    page.set_viewport_size({"width": width, "height": 700})
    for path, found in (("/", ".card"), (f"/renders/{id}", ".failure")):
        page.goto(service.url + path)
        expect(page.locator(found)).to_be_visible()
        assert page.evaluate("document.documentElement.scrollWidth") <= width
