"""Pages that the program writes, opened from disk in a real browser."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect
from tests.kernels.sample_pages import sample_comparison, sample_report

#: Of text, and of the graphics that carry meaning: WCAG 2.2, 1.4.3 and 1.4.11, level AA.
TEXT, GRAPHICS = 4.5, 3.0

#: Contrasts of all that is drawn with text or as a curve against what is behind it.
CONTRASTS = """() => {
  const parse = (css) => {
    const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
    canvas.fillStyle = css;
    canvas.fillRect(0, 0, 1, 1);
    return [...canvas.getImageData(0, 0, 1, 1).data];
  };
  const light = ([r, g, b]) => {
    const [x, y, z] = [r, g, b].map((c) => ((c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    return 0.2126 * x + 0.7152 * y + 0.0722 * z;
  };
  const behind = (element) => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) layers.push(parse(getComputedStyle(at).backgroundColor));
    return layers.reverse().reduce((under, [r, g, b, a]) => {
      return [r, g, b].map((c, i) => (c * a + under[i] * (255 - a)) / 255);
    }, [255, 255, 255]);
  };
  const found = [];
  for (const element of document.querySelectorAll("body *")) {
    const style = getComputedStyle(element);
    if (!element.getClientRects().length || style.visibility === "hidden") continue;
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    const drawn = element.matches(".marker, .line, .fit, .whisker");
    if ((!own && !drawn) || element.matches("title, script")) continue;
    const inSvg = element instanceof SVGElement;
    const ink = parse(!inSvg ? style.color : drawn ? style.stroke : style.fill);
    const [a, b] = [light(ink), light(behind(element))].sort((x, y) => y - x);
    found.push({ what: `${element.tagName} .${element.getAttribute("class")}`, drawn, ratio: (a + 0.05) / (b + 0.05) });
  }
  return found;
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pages")
    (folder / "report.html").write_text(sample_report())
    (folder / "comparison.html").write_text(sample_comparison())
    return folder


@pytest.fixture(params=["report", "comparison"])
def file(folder: Path, request: pytest.FixtureRequest) -> str:
    return (folder / f"{request.param}.html").as_uri()


@pytest.fixture
def asked(page: Page) -> Iterator[list[str]]:
    """What the page asks the world for; nothing may be."""
    asked: list[str] = []

    def note(request: Any) -> None:
        if not request.url.startswith(("data:", "file:")):
            asked.append(request.url)

    page.on("request", note)
    yield asked
    assert asked == []


def test_it_opens_from_disk_without_a_word(page: Page, asked: list[str], file: str) -> None:
    dialogs: list[str] = []
    page.on("dialog", lambda dialog: (dialogs.append(dialog.message), dialog.dismiss())[0])
    page.goto(file)
    expect(page.locator("h1")).to_contain_text("alert(1)")
    for image in page.locator(".frames img, .wall img").all():
        assert image.evaluate("image => image.decode().then(() => image.naturalWidth)") > 0
    assert dialogs == []


def test_digits_and_buttons_turn_the_book(page: Page, asked: list[str], file: str) -> None:
    page.goto(file)
    book = page.locator(".book").first
    frames, buttons = book.locator(".frames > figure"), book.get_by_role("button")
    expect(frames.nth(0)).to_be_visible()
    expect(frames.nth(1)).to_be_hidden()
    place = frames.nth(0).locator("img").bounding_box()
    page.keyboard.press("2")
    expect(frames.nth(1)).to_be_visible()
    expect(frames.nth(0)).to_be_hidden()
    expect(buttons.nth(1)).to_have_attribute("aria-pressed", "true")
    assert frames.nth(1).locator("img").bounding_box() == place  # nothing moves
    page.keyboard.press("Control+1")  # the browser's own
    expect(frames.nth(1)).to_be_visible()
    buttons.nth(0).focus()
    page.keyboard.press("Enter")
    expect(frames.nth(0)).to_be_visible()
    expect(frames.nth(1)).to_be_hidden()
    page.keyboard.press("0")
    for frame in frames.all():
        expect(frame).to_be_visible()


@pytest.mark.parametrize("width", [320, 390, 1280])
def test_it_fits_the_screen(page: Page, asked: list[str], file: str, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 800})
    page.goto(file)
    page.evaluate("document.querySelectorAll('details').forEach((each) => (each.open = true))")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    shown = page.locator("svg.chart:visible").all()
    assert {str(each.get_attribute("class")).split()[1] for each in shown} == {"narrow" if width < 640 else "wide"}
    for figure in shown:
        frame = figure.bounding_box()
        assert frame is not None
        for text in figure.locator("text").all():
            box = text.bounding_box()
            assert box is not None
            assert box["x"] >= frame["x"] - 1, text.text_content()
            assert box["x"] + box["width"] <= frame["x"] + frame["width"] + 1, text.text_content()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_contrast(page: Page, asked: list[str], file: str, scheme: Any) -> None:
    page.emulate_media(color_scheme=scheme)
    page.goto(file)
    page.evaluate("document.querySelectorAll('details').forEach((each) => (each.open = true))")
    found = page.evaluate(CONTRASTS)
    assert sum(each["drawn"] for each in found) > 10
    assert len(found) > 60
    assert [each for each in found if each["ratio"] < (GRAPHICS if each["drawn"] else TEXT)] == []


def test_it_prints_all_views(page: Page, asked: list[str], file: str) -> None:
    page.emulate_media(media="print", color_scheme="dark")
    page.goto(file)
    for frame in page.locator(".frames > figure").all():
        expect(frame).to_be_visible()
    expect(page.locator(".buttons").first).to_be_hidden()
    assert page.evaluate("getComputedStyle(document.documentElement).backgroundColor") == "rgb(255, 255, 255)"


def test_without_scripts_all_views_are_there(browser: Browser, file: str) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(file)
    for frame in page.locator(".frames > figure").all():
        expect(frame).to_be_visible()
    expect(page.locator(".buttons").first).to_be_hidden()
    context.close()
