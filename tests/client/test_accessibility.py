"""Every page of the gallery, in the states that it can be in: by axe-core, on a phone's width, and as screenshots.

Dark and wide, light and narrow.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Literal

import pytest
from playwright.sync_api import Browser, Page, expect

from .looks import check
from .real import Gallery
from .service import Service

Scheme = Literal["dark", "light"]
LOOKS: list[tuple[Scheme, int, int]] = [("dark", 1280, 800), ("light", 390, 844)]


@pytest.fixture(params=[LOOKS[0], pytest.param(LOOKS[1], marks=pytest.mark.slow)], ids=[look[0] for look in LOOKS])
def page(browser: Browser, said: list[str], request: pytest.FixtureRequest) -> Iterator[Page]:
    """A window of that scheme and size."""
    scheme, width, height = request.param
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, reduced_motion="reduce"
    )
    context.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    context.on("weberror", lambda error: said.append(str(error.error)))
    yield context.new_page()
    context.close()


def wall(page: Page) -> None:
    expect(page.locator(".card img").first).to_be_visible()


def viewer(page: Page) -> None:
    expect(page.locator("canvas")).to_be_visible()
    expect(page.get_by_role("heading", name="Certificate")).to_be_attached()


def compared(page: Page) -> None:
    expect(page.locator("canvas").first).to_be_visible()
    expect(page.get_by_text("relMSE").first).to_be_visible()


def written(page: Page) -> None:
    expect(page.get_by_text("This can be rendered.")).to_be_visible()


def fleet(page: Page) -> None:
    expect(page.get_by_role("heading", name="Devices")).to_be_visible()
    expect(page.get_by_text("samples a second").first).to_be_visible()


PAGES: dict[str, tuple[str, Callable[[Page], None]]] = {
    "wall": ("/", wall),
    "render": ("/renders/{0}", viewer),
    "render-variance": ("/renders/{0}?layer=variance", viewer),
    "compare": ("/compare?renders={0},{1}", compared),
    "compare-choose": ("/compare", lambda page: expect(page.get_by_role("heading", name="Compare")).to_be_visible()),
    "submit": ("/submit", written),
    "fleet": ("/fleet", fleet),
    "absent": (
        "/renders/%E0",
        lambda page: expect(page.get_by_role("heading", name="There is no such page")).to_be_visible(),
    ),
}


@pytest.mark.parametrize("name", PAGES)
def test_a_page(page: Page, gallery: Gallery, name: str) -> None:
    address, ready = PAGES[name]
    page.goto(gallery.address + address.format(*gallery.renders))
    ready(page)
    check(page, name)


def test_a_service_with_nothing_in_it(page: Page, service: Service) -> None:
    page.goto(service.url)
    expect(page.get_by_role("heading", name="Nothing rendered yet")).to_be_visible()
    check(page, "wall-empty")


def test_a_render_that_runs_and_one_that_failed(page: Page, service: Service, scene_json: dict[str, Any]) -> None:
    running, failed = service.add(scene_json, "on its way"), service.add(scene_json, "gone wrong")
    service.advance(running, 16)
    service.update(failed, state="failed", error="volumes[0].sigma_t: is not finite.\nThe driver said: nothing")
    page.goto(service.url)
    expect(page.get_by_text("gone wrong")).to_be_visible()
    check(page, "wall-mixed")
    page.goto(f"{service.url}/renders/{running}")
    expect(page.get_by_text("16 of 64")).to_be_visible()
    check(page, "render-running")
    page.goto(f"{service.url}/renders/{failed}")
    expect(page.get_by_role("heading", name="This render failed")).to_be_visible()
    check(page, "render-failed")


def test_a_service_that_is_away(page: Page, said: list[str], service: Service) -> None:
    page.route("**/api/**", lambda route: route.abort())
    page.goto(service.url)
    expect(page.get_by_role("heading", name="The service does not answer")).to_be_visible()
    check(page, "wall-away")
    said.clear()  # the browser's own lines about it


def test_who_is_not_signed_in(page: Page, said: list[str], service: Service) -> None:
    page.route(
        "**/api/**",
        lambda route: route.fulfill(
            status=401, content_type="application/problem+json", body='{"detail": "A token is needed."}'
        ),
    )
    page.goto(service.url)
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
    check(page, "signed-out")
    said.clear()
