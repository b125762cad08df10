"""Renders held against each other, in a real browser and by a real service."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from woodcock.image import read_exr
from woodcock.space import Array

from .real import Gallery
from .service import Service

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def picture(gallery: Gallery, place: int, layer: str = "") -> Array:
    channels, _ = read_exr(gallery.data / "jobs" / gallery.renders[place] / "image.exr")
    return np.stack([channels[f"{layer}{name}"] for name in "RGB"], axis=-1).astype(np.float64)


def opened(gallery: Gallery, page: Page, query: str = "") -> None:
    page.goto(f"{gallery.address}/compare?renders={','.join(gallery.renders)}{query}")
    expect(page.locator(".compare canvas").first).to_be_visible()


def settled(page: Page, **told: str | None) -> None:
    """The address comes to tell that."""

    def tells(url: str) -> bool:
        query = parse_qs(urlsplit(url).query)
        return all(query.get(name, [None]) == [value] for name, value in told.items())

    page.wait_for_url(tells)


def figure(page: Page, measure: str) -> str:
    row = page.locator(".measures tr", has=page.locator("th", has_text=re.compile(f"^{measure}")))
    return str(row.locator("td.figure").first.inner_text())


def number(text: str) -> float:
    match = re.match(r"([+−]?[\d. ]+)(?: × 10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", text.replace("\u2009", ""))
    assert match, text
    power = (match[2] or "⁰").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    return float(match[1].replace("−", "-")) * 10.0 ** int(power)


def test_numbers_are_those_of_the_pictures(gallery: Gallery, page: Page) -> None:
    opened(gallery, page)
    expect(page.locator(".verdicts strong")).to_have_text(re.compile("Noise"))
    expect(page.locator(".verdicts")).to_contain_text("16 parts agree to")
    b, a = picture(gallery, 0), picture(gallery, 1)  # the first is the reference
    vb, va = picture(gallery, 0, "variance."), picture(gallery, 1, "variance.")
    mean = np.mean(b @ LUMINANCE)
    squares = (a - b) ** 2 - vb
    assert number(figure(page, "MSE")) == pytest.approx(np.mean(squares @ LUMINANCE), rel=0.06)
    assert number(figure(page, "of which noise")) == pytest.approx(np.mean(va @ LUMINANCE), rel=0.06)
    relative = squares / (b**2 + 0.01 * mean**2)
    assert number(figure(page, "relMSE")) == pytest.approx(np.mean(relative @ LUMINANCE), rel=0.06)
    smape = np.divide(np.abs(a - b), a + b, out=np.zeros(a.shape), where=a + b > 0)
    assert number(figure(page, "SMAPE")) / 100 == pytest.approx(np.mean(smape @ LUMINANCE), rel=0.006)
    bias = np.mean((a - b) @ LUMINANCE) / mean
    assert number(figure(page, "Bias")) / 100 == pytest.approx(bias, rel=0.006, abs=1e-5)
    noisy = va + vb > 1e-12
    z = (a - b)[noisy] / np.sqrt((va + vb)[noisy])
    assert number(figure(page, "Beyond 2σ")) / 100 == pytest.approx(np.mean(np.abs(z) > 2), abs=2e-3)
    assert number(figure(page, "Mean z²")) == pytest.approx(np.mean(z**2), rel=0.01)
    assert page.locator(".measures tbody tr").count() == 9
    for formula in page.locator(".measures .formula").all():
        assert formula.inner_text()


def test_digits_flip_between_pictures_in_place(gallery: Gallery, page: Page) -> None:
    opened(gallery, page)
    caption = page.locator(".stage .caption")
    expect(caption).to_have_text("1 box, seed 1")
    before = page.locator(".compare canvas").bounding_box()
    page.locator(".compare canvas").focus()
    page.keyboard.press("2")  # for the canvas alone it would be nothing, and 1 another zoom
    expect(caption).to_have_text("2 box, seed 2")
    settled(page, show="2")
    assert page.locator(".compare canvas").bounding_box() == before
    page.keyboard.press("1")
    expect(caption).to_have_text("1 box, seed 1")
    settled(page, show=None, zoom=None)
    page.keyboard.press("3")
    expect(caption).to_have_text("1 box, seed 1")
    page.get_by_role("button", name="2, box, seed 2", exact=True).click()
    expect(caption).to_have_text("2 box, seed 2")


def test_values_of_all_pictures_are_under_the_pointer(gallery: Gallery, page: Page) -> None:
    opened(gallery, page, "&mode=map&show=2")
    expect(page.locator(".meaning")).to_contain_text("I − R")
    page.locator(".compare canvas").hover(position={"x": 300, "y": 200})
    caption = page.locator(".under caption")
    expect(caption).to_have_text(re.compile(r"Pixel \d+, \d+"))
    x, y = (int(each) for each in re.findall(r"\d+", caption.inner_text()))
    rows = page.locator(".under tbody tr")
    expect(rows).to_have_count(3)
    a, b = picture(gallery, 0)[y, x], picture(gallery, 1)[y, x]
    for row, expected in zip(rows.all(), (a, b, b - a), strict=True):
        found = [number(cell.inner_text()) for cell in row.locator("td").all()]
        assert found == pytest.approx(list(expected), rel=6e-3, abs=2e-5)


def test_the_line_of_a_split_is_moved_by_pointer_and_keys(gallery: Gallery, page: Page) -> None:
    opened(gallery, page)
    page.keyboard.press("s")
    line = page.get_by_role("slider", name="Where the pictures meet")
    expect(line).to_have_attribute("aria-valuenow", "50")
    stage = page.locator(".stage.split").bounding_box()
    assert stage is not None
    page.mouse.move(stage["x"] + stage["width"] / 2, stage["y"] + stage["height"] / 2)
    page.mouse.down()
    page.mouse.move(stage["x"] + stage["width"] / 4, stage["y"] + 20, steps=3)
    page.mouse.up()
    expect(line).to_have_attribute("aria-valuenow", "25")
    box = line.bounding_box()
    assert box is not None
    assert box["x"] + box["width"] / 2 == pytest.approx(stage["x"] + stage["width"] / 4, abs=1)
    line.focus()
    page.keyboard.press("ArrowRight")
    expect(line).to_have_attribute("aria-valuenow", "27")
    settled(page, mode="split", split="0.27")
    page.keyboard.press("End")
    expect(line).to_have_attribute("aria-valuenow", "100")
    assert page.locator(".half").nth(1).evaluate("each => each.style.clipPath") == "inset(0px 0px 0px 100%)"


def test_pictures_side_by_side_are_zoomed_together(gallery: Gallery, page: Page) -> None:
    opened(gallery, page, "&mode=side")
    expect(page.locator(".compare canvas")).to_have_count(2)
    page.locator(".compare canvas").nth(1).hover(position={"x": 100, "y": 100})
    page.mouse.wheel(0, -600)
    page.wait_for_url(re.compile("[?&]zoom="))
    points = []
    for index in (0, 1):
        page.locator(".compare canvas").nth(index).hover(position={"x": 140, "y": 90})
        expect(page.locator(".under caption")).to_have_text(re.compile("Pixel"))
        points.append(page.locator(".under caption").inner_text())
    assert points[0] == points[1]


def test_an_address_brings_the_same_comparison_back(gallery: Gallery, page: Page) -> None:
    opened(gallery, page)
    page.get_by_role("button", name="Map", exact=True).click()
    page.get_by_label("Map", exact=True).select_option("z")
    expect(page.locator(".meaning")).to_contain_text("z = (I − R) / √(var I + var R)")
    page.get_by_label("Channel").select_option("R")
    page.get_by_role("button", name="1 : 1").click()
    page.locator(".compared li").nth(1).get_by_label("Reference").check()
    expect(page.locator(".stage .caption")).to_have_text("1 box, seed 1 against 2 box, seed 2")
    settled(page, mode="map", difference="z", channel="R", zoom="1", reference="2")
    address = page.url
    page.goto(f"{gallery.address}/")
    page.goto(address)
    expect(page.locator(".stage .caption")).to_have_text("1 box, seed 1 against 2 box, seed 2")
    expect(page.get_by_label("Map", exact=True)).to_have_value("z")
    expect(page.get_by_label("Channel")).to_have_value("R")
    expect(page.locator(".meaning .scale")).to_have_text("−55")
    assert page.url == address


def test_renders_are_chosen_by_name(gallery: Gallery, page: Page) -> None:
    page.goto(f"{gallery.address}/compare?renders={gallery.renders[0]}")
    expect(page.get_by_label("box, seed 1")).to_be_checked()
    compare = page.get_by_role("button", name=re.compile("^Compare"))
    expect(compare).to_be_disabled()
    page.get_by_label("Name").fill("nothing of that name")
    expect(page.get_by_role("main").get_by_role("status")).to_contain_text("No other finished render")
    page.get_by_label("Name").fill("SEED 2")
    page.get_by_label("box, seed 2").check()
    compare.click()
    expect(page.locator(".verdicts strong")).to_have_text(re.compile("Noise"))
    assert page.url == f"{gallery.address}/compare?renders={','.join(gallery.renders)}"


def test_keys_are_listed(gallery: Gallery, page: Page) -> None:
    opened(gallery, page)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_contain_text("side by side")
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_be_hidden()


def test_what_cannot_be_compared_is_told(
    service: Service, page: Page, said: list[str], scene_json: dict[str, Any]
) -> None:
    done, small = (
        service.add({**scene_json, "film": {"width": size, "height": 64}}, f"{size} wide") for size in (64, 32)
    )
    waiting = service.add(scene_json, "not yet")
    for job in (done, small):
        service.advance(job, 64)
        service.finish(job, {"error": []})
    page.goto(f"{service.url}/compare?renders={done},{small}")
    expect(page.locator(".notice")).to_contain_text("“64 wide” is 64 × 64 pixels, “32 wide” 32 × 64.")
    page.goto(f"{service.url}/compare?renders={done},{waiting}")
    expect(page.locator(".notice")).to_contain_text("“not yet” is not done: queued. Come back once it is.")
    page.goto(f"{service.url}/compare?renders={done},nobody")
    expect(page.locator(".notice h1")).to_have_text("One of these renders is not there")
    assert all("404" in line for line in said)
    said.clear()


def test_what_is_seen_changes_with_what_is_shown(gallery: Gallery, page: Page) -> None:
    shots = set()
    for query in ("", "&show=2", "&mode=map&show=2"):
        opened(gallery, page, query)
        page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        shots.add(page.locator(".stage canvas").screenshot())
    assert len(shots) == 3
