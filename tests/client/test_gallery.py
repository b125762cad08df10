"""The gallery in a real browser: with the service itself, then its wall with faults that it cannot be asked for."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from typer.testing import CliRunner

from woodcock.scene import Scene
from woodcock_client import Client, ServiceError
from woodcock_client.cli import build

from .real import serving
from .service import WEB, Service


def picture_range(page: Page) -> int:
    """The picture's brightest value less its darkest, of 255."""
    return int(
        page.locator(".stage img").evaluate(
            """async (image) => {
                await image.decode();
                const canvas = document.createElement("canvas");
                [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
                const draw = canvas.getContext("2d");
                draw.drawImage(image, 0, 0);
                const values = draw.getImageData(0, 0, canvas.width, canvas.height).data.filter((_, i) => i % 4 < 3);
                return Math.max(...values) - Math.min(...values);
            }"""
        )
    )


# The service itself


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """A real service on a free port, with a folder of its own."""
    with serving(tmp_path) as address:
        yield address


def test_a_render_from_submission_to_download(page: Page, address: str, scene_json: dict[str, Any]) -> None:
    # An empty wall says what to do
    page.goto(address)
    expect(page.get_by_role("heading", name="Nothing rendered yet")).to_be_visible()
    expect(page.get_by_text(f"woodcock submit scene.json --follow --server {address}")).to_be_visible()

    # The card of a new render appears by itself
    scene_json["volumes"][0]["albedo"] = 0.5  # darker than its surround
    scene = Scene.model_validate({**scene_json, "stop": {"kind": "seconds", "seconds": 3}})
    with Client(address) as client:
        job = client.submit(scene, name="furnace <b>box</b>")
    card = page.get_by_role("link", name="furnace <b>box</b>")
    expect(card).to_be_visible()
    card.click()
    expect(page).to_have_url(f"{address}/renders/{job.id}")

    # The page follows it to its end
    expect(page.locator(".badge")).to_have_text("Done", timeout=60_000)
    expect(page.get_by_role("progressbar")).to_have_attribute("aria-valuenow", "100")
    expect(page.locator(".numbers")).to_contain_text("of 3 s")
    expect(page.locator(".figures")).to_contain_text("%")
    expect(page.get_by_role("heading", name="Error over time")).to_be_visible()
    expect(page.get_by_role("heading", name="Where the time went")).to_be_visible()
    expect(page.locator(".caution")).to_have_count(0)
    picture = page.locator(".stage img")
    expect(picture).to_be_visible()
    assert picture_range(page) > 20

    # Its files come down
    with page.expect_download() as exr:
        page.get_by_role("link", name="EXR").click()
    assert exr.value.suggested_filename == "furnace-b-box-b.exr"
    assert exr.value.path().read_bytes()[:4] == b"\x76\x2f\x31\x01"
    with page.expect_download() as written:
        page.get_by_role("link", name="Scene").click()
    assert Scene.model_validate_json(written.value.path().read_bytes()) == scene

    # The same address works from nothing, and the wall shows the finished card
    page.reload()
    expect(page.locator(".badge")).to_have_text("Done")
    page.locator("a.up").click()
    expect(page.locator(".card .stage img")).to_be_visible()
    expect(page.locator(".card .progress")).to_have_count(0)


def test_who_has_a_token_signs_in(
    page: Page, said: list[str], address: str, tmp_path: Path, scene_json: dict[str, Any]
) -> None:
    with Client(address) as client:
        job = client.submit(Scene.model_validate(scene_json), name="a secret")
        for _ in client.follow(job.id):
            pass
    made = CliRunner().invoke(build(["token"]), ["token", "create", "me", "--data", str(tmp_path / "data")])
    page.goto(f"{address}/renders/{job.id}")
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
    expect(page.locator("body")).not_to_contain_text("a secret")
    page.get_by_label("Token").fill("woodcock_wrong")
    page.keyboard.press("Enter")
    expect(page.locator(".signin").get_by_role("alert")).to_have_text(
        "The token is unknown or revoked, or has expired."
    )
    page.get_by_label("Token").fill(made.stdout.strip())
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("heading", name="a secret")).to_be_visible()
    expect(page.locator(".stage img")).to_be_visible()
    assert picture_range(page) > 10
    assert page.evaluate("document.cookie") == "", "no script can read the token"
    page.reload()
    expect(page.get_by_role("heading", name="a secret")).to_be_visible()
    refused = [text for text in said if "401" in text]
    assert refused
    for text in refused:
        said.remove(text)
    with Client(address) as client, pytest.raises(ServiceError, match="asks for a token"):
        client.job(job.id)
    with Client(address, token=made.stdout.strip()) as client:
        assert client.job(job.id).name == "a secret"


# The wall


def test_a_card_moves_with_its_render(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    id = service.add(scene_json, "moving")
    page.goto(service.url)
    expect(page.locator(".card .badge")).to_have_text("Queued")
    expect(page.locator(".card")).to_contain_text("No samples yet")
    box = page.locator(".card").bounding_box()
    service.advance(id, 16)
    expect(page.locator(".card .badge")).to_have_text("25 %")
    expect(page.locator(".card img")).to_have_attribute("src", re.compile(r"samples=16$"))
    service.advance(id, 48)
    expect(page.locator(".card img")).to_have_attribute("src", re.compile(r"samples=48$"))
    assert page.locator(".card").bounding_box() == box  # nothing jumped
    service.finish(id)
    expect(page.locator(".card .badge")).to_have_count(0)


def test_older_renders_come_as_the_wall_is_scrolled(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    for number in range(110):
        service.add(scene_json, f"render {number}")
        service.finish(f"job{number:04}")
    page.goto(service.url)
    expect(page.locator(".card").first).to_contain_text("render 109")
    page.mouse.move(600, 400)
    page.mouse.wheel(0, 20_000)
    expect(page.locator(".rest")).to_have_count(0)
    page.mouse.wheel(0, 20_000)
    expect(page.locator(".card .name").last).to_have_text("render 0")
    assert page.locator(".card").count() < 60, "of what is far from the window nothing is in the page"

    # Back from a render, the wall is as it was left
    page.mouse.wheel(0, -1500)
    expect(page.locator(".card .name").last).not_to_have_text("render 0")
    place = page.evaluate("scrollY")
    name = page.locator(".card .name").nth(10).inner_text()
    page.locator(".card").nth(10).evaluate("card => card.click()")
    expect(page.get_by_role("heading", name=name)).to_be_visible()
    page.go_back()
    expect(page.locator(".card .name", has_text=name)).to_be_visible()
    assert page.evaluate("scrollY") == pytest.approx(place, abs=2)


def test_the_wall_shows_one_batch(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    for number, batch in enumerate(("b 1", None, "b 1")):
        id = service.add(scene_json, f"render {number}")
        service.update(id, batch=batch, point=batch and {"volumes[0].sigma_t": number, "film.width": 64})
        service.finish(id)
    page.goto(f"{service.url}/?batch=b%201")
    expect(page.locator(".card .name")).to_have_text(["render 2", "render 0"])
    expect(page.get_by_role("link", name="of a batch")).to_have_attribute("href", "/batches/b%201")
    page.get_by_role("link", name="Renders").click()
    expect(page.locator(".card .name")).to_have_text(["render 2", "render 1", "render 0"])
    page.locator(".card", has_text="render 0").click()
    batch = page.get_by_role("link", name="volumes[0].sigma_t = 0, film.width = 64")
    expect(batch).to_have_attribute("href", "/batches/b%201")
    page.goto(f"{service.url}/?batch=none")
    expect(page.get_by_role("heading", name="No render is like that")).to_be_visible()


def test_the_keyboard_suffices(service: Service, page: Page, scene_json: dict[str, Any]) -> None:
    service.finish(service.add(scene_json, "typed"))
    page.goto(service.url)
    expect(page.locator(".card")).to_be_visible()
    names = []
    for _ in range(5):
        page.keyboard.press("Tab")
        names.append(page.evaluate("document.activeElement.textContent.trim().slice(0, 12)"))
    assert names == ["Skip to cont", "Woodcock", "Renders", "Fleet", "API"]
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.type") == "search"
    for _ in range(5):
        page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="typed")).to_be_visible()
    assert page.evaluate("document.activeElement.id") == "main"


def test_a_service_that_goes_and_comes_back(
    service: Service, page: Page, said: list[str], scene_json: dict[str, Any]
) -> None:
    service.broken = (503, "application/problem+json", b'{"detail": "the database is not there"}')
    page.route(re.compile(r"/(web/.*)?$"), lambda route: serve_file(route))
    page.goto(service.url)
    expect(page.get_by_role("heading", name="The renders cannot be listed")).to_be_visible()
    expect(page.get_by_text("the database is not there")).to_be_visible()
    service.broken = None
    service.add(scene_json, "kept")
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_text("kept")).to_be_visible()
    page.route("**/api/**", lambda route: route.abort())
    expect(page.get_by_text("The service does not answer.")).to_be_visible()
    expect(page.get_by_text("kept")).to_be_visible()  # what was known stays in view
    page.unroute("**/api/**")
    expect(page.get_by_text("The service does not answer.")).to_be_hidden()
    assert said
    assert all("Failed to load resource" in line for line in said)
    said.clear()


def serve_file(route: Any) -> None:
    path = route.request.url.split("/", 3)[3] or "web/index.html"
    route.fulfill(path=WEB.parent / path)
