"""The wall and the page of a batch in a real browser, of a real service that holds thousands of renders."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2
import pytest
from playwright.sync_api import BrowserContext, Locator, Page, expect

from woodcock.scene import Scene

from .conftest import SCENE
from .looks import check
from .real import serving
from .seeding import SAMPLES, seed
from .waiting import until

#: Renders of the service, and those of the slow test.
FEW, MANY = 1500, 10_000
NO_DEVICES = "import woodcock_server.app; woodcock_server.app.discover = list"


@dataclass(frozen=True)
class Wall:
    """A service without devices; batch: of the newest renders."""

    address: str
    http: httpx2.Client
    batch: str

    def named(self, name: str) -> list[dict[str, Any]]:
        items = self.http.get("/api/v1/jobs", params={"text": name}).raise_for_status().json()["items"]
        return [job for job in items if job["name"] == name]


@pytest.fixture(scope="module")
def wall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Wall]:
    """Shared by tests: each deletes and tags renders that no other one looks at."""
    folder = tmp_path_factory.mktemp("wall")
    batch = seed(folder / "data", Scene.model_validate(SCENE).model_dump(mode="json"), FEW)
    with serving(folder, NO_DEVICES) as address, httpx2.Client(base_url=address) as http:
        yield Wall(address, http, batch)


def card(page: Page, name: str) -> Locator:
    return page.locator(".card", has=page.get_by_text(name, exact=True))


def names(page: Page) -> list[str]:
    """Of the cards that are wholly in the window, in order."""
    return page.locator(".cards li").evaluate_all(
        """all => all.filter(one => {
            const { top, bottom } = one.getBoundingClientRect();
            return top >= 0 && bottom <= innerHeight;
        }).map(one => one.querySelector(".name").textContent)"""
    )


def test_all_that_is_stored_is_scrolled_through(page: Page, wall: Wall) -> None:
    page.goto(wall.address)
    expect(page.locator(".card img").first).to_be_visible()
    picture = page.locator(".card img").first
    expect(picture).to_have_attribute("src", re.compile(rf"thumbnail\.webp\?state=succeeded&samples={SAMPLES}$"))
    assert names(page)[:2] == [f"render {FEW - 1}", f"render {FEW - 2}"]
    page.mouse.move(600, 400)
    end = time.monotonic() + 30
    while "render 0" not in names(page):
        assert time.monotonic() < end
        page.mouse.wheel(0, 15_000)
        page.wait_for_timeout(30)
        assert page.locator(".cards li").count() <= 60, "only what is near the window is in the page"
    expect(page.locator(".rest")).to_have_count(0)
    last = page.locator(".cards li").last
    expect(last).to_have_attribute("aria-posinset", str(FEW))
    expect(last).to_have_attribute("aria-setsize", str(FEW))


#: Scrolls by whole frames, and says how long each took, ms.
SCROLL = """async frames => {
    const took = [];
    let last = await new Promise(requestAnimationFrame);
    for (let n = 0; n < frames; n += 1) {
        scrollBy(0, 300);
        const now = await new Promise(requestAnimationFrame);
        took.push(now - last);
        last = now;
    }
    return took;
}"""


@pytest.mark.slow
def test_ten_thousand_renders_are_no_slower(page: Page, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Times are of two idle cores, and bounded generously; what was measured is printed."""
    seed(tmp_path / "data", Scene.model_validate(SCENE).model_dump(mode="json"), MANY)
    with serving(tmp_path, NO_DEVICES) as address:
        began = time.perf_counter()
        page.goto(address)
        expect(page.locator(".card img").first).to_be_visible()
        until(page, "document.querySelector('.card img').complete")
        first = time.perf_counter() - began
        session = page.context.new_cdp_session(page)

        def heap() -> float:
            """What scripts hold once garbage is collected, MiB."""
            session.send("HeapProfiler.collectGarbage")
            return float(session.send("Runtime.getHeapUsage")["usedSize"] / 2**20)

        before, frames = heap(), page.evaluate(SCROLL, 300)
        began, most = time.perf_counter(), 0
        while "render 0" not in names(page):
            assert time.perf_counter() - began < 120
            page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
            page.wait_for_timeout(20)
            most = max(most, page.evaluate("document.querySelectorAll('*').length"))
        end, after = time.perf_counter() - began, heap()
        again = page.evaluate(SCROLL.replace("300", "-300"), 300)  # with all of them listed
        page.wait_for_timeout(5000)  # a look at what is new
    ordered = [sorted(each) for each in (frames, again)]
    typical, late = ([each[int(part * len(each))] for each in ordered] for part in (0.5, 0.99))
    with capsys.disabled():
        print(
            f"\n{MANY} renders: first tile {first:.2f} s, end reached in {end:.1f} s, at most {most} elements, "
            f"heap {before:.1f} -> {after:.1f} MiB, frames (50 %, 99 %) {typical[0]:.0f}, {late[0]:.0f} ms at the top "
            f"and {typical[1]:.0f}, {late[1]:.0f} ms at the end"
        )
    assert first < 5
    assert most < 1200
    assert after - before < 20, "MiB for ten thousand"
    # SwiftShader draws every frame on the processor, which takes most of this; what thousands must not do is add to it.
    assert max(typical) < 100
    assert typical[1] < 1.5 * typical[0]


def test_thumbnails_are_asked_for_once(context: BrowserContext, page: Page, wall: Wall) -> None:
    page.goto(wall.address)
    expect(page.locator(".card img").first).to_be_visible()
    page.wait_for_load_state("networkidle")
    page.reload()
    expect(page.locator(".card img").first).to_be_visible()
    page.wait_for_load_state("networkidle")
    sent = page.evaluate(
        """performance.getEntriesByType("resource").filter(one => one.name.includes("thumbnail"))
           .map(one => one.transferSize)"""
    )
    assert len(sent) >= 12
    assert set(sent) == {0}, "the browser kept them"


# What the wall is narrowed to


def test_a_filter_is_in_the_address(page: Page, wall: Wall) -> None:
    page.goto(wall.address)
    page.get_by_label("Search names").fill("render 10")
    expect(page).to_have_url(f"{wall.address}/?text=render+10")
    expect(page.locator(".name").first).to_have_text(f"render {10}99")
    page.get_by_label("State").select_option("failed")
    expect(page.locator(".name").first).to_have_text("render 1090")
    page.get_by_label("Tag").select_option("sky")
    page.get_by_label("Device").select_option("gpu0")
    page.get_by_label("Estimator").select_option("transmittance")
    expect(page).to_have_url(
        f"{wall.address}/?text=render+10&state=failed&tag=sky&device=gpu0&integrator=transmittance"
    )
    expected = ["render 1080", "render 1060", "render 1040", "render 1020", "render 1000", "render 100"]
    expect(page.locator(".name")).to_have_text([*expected, "render 10"][:6])

    # It survives a visit to a render, and a fresh start
    card(page, "render 1040").click()
    expect(page.get_by_role("heading", name="render 1040")).to_be_visible()
    page.go_back()
    expect(page.locator(".name")).to_have_text(expected)
    page.reload()
    expect(page.locator(".name")).to_have_text(expected)
    expect(page.get_by_label("Search names")).to_have_value("render 10")
    expect(page.get_by_label("Device")).to_have_value("gpu0")
    page.get_by_role("button", name="Without the tag sky").click()
    page.get_by_label("Device").select_option("")
    page.get_by_label("Search names").fill("no such name")
    expect(page.get_by_role("heading", name="No render is like that")).to_be_visible()
    page.get_by_role("button", name="Clear").click()
    expect(page).to_have_url(f"{wall.address}/")
    expect(page.get_by_label("Search names")).to_have_value("")
    expect(page.locator(".name").first).to_have_text(f"render {FEW - 1}")


# What is new


@pytest.mark.slow
def test_cards_keep_their_place_while_renders_come_in(page: Page, wall: Wall) -> None:
    page.goto(f"{wall.address}/?text=n")
    expect(page.locator(".card").first).to_be_visible()
    page.mouse.move(600, 400)
    page.mouse.wheel(0, 3000)
    until(page, "scrollY === 3000")
    expect(page.locator(".card img").first).to_be_visible()
    before = names(page)
    for name in ("new 1", "new 2"):
        wall.http.post("/api/v1/jobs", json={"scene": SCENE, "name": name}).raise_for_status()
    news = page.get_by_role("button", name="2 new renders")
    expect(news).to_be_visible()
    assert names(page) == before
    news.click()
    expect(page.locator(".name").first).to_have_text("new 2")
    assert page.evaluate("scrollY") == 0
    expect(news).to_have_count(0)
    for job in (*wall.named("new 1"), *wall.named("new 2")):
        wall.http.post(f"{job['links']['self']}/cancel").raise_for_status()
        wall.http.delete(job["links"]["self"]).raise_for_status()
    expect(page.locator(".name").first).to_have_text(f"render {FEW - 1}")  # without being asked for


# What is selected


def without_files(said: list[str]) -> None:
    """The browser's own lines about pages whose files nobody made, and no others."""
    assert all("404" in text for text in said)
    said.clear()


def test_keys_move_among_cards_and_select_them(page: Page, said: list[str], wall: Wall) -> None:
    page.goto(f"{wall.address}/?text=render+7")
    cards = page.locator(".card")
    expect(cards.first).to_be_visible()
    columns = page.locator(".cards").evaluate("one => getComputedStyle(one).gridTemplateColumns.split(' ').length")
    order = [f"render {number}" for number in (*range(799, 699, -1), *range(79, 69, -1), 7)]

    def focused() -> str:
        return str(page.evaluate("document.activeElement.querySelector('.name')?.textContent ?? ''"))

    page.get_by_label("Estimator").focus()
    while not focused():
        page.keyboard.press("Tab")
    assert focused() == order[0]
    for key, index in (("ArrowRight", 1), ("ArrowDown", 1 + columns), ("ArrowLeft", columns), ("ArrowUp", 0)):
        page.keyboard.press(key)
        assert focused() == order[index]
    page.keyboard.press("ArrowUp")
    assert focused() == order[0]
    page.keyboard.press("End")
    until(page, "document.activeElement.querySelector('.name')?.textContent !== 'render 799'")
    page.wait_for_timeout(300)
    page.keyboard.press("End")  # of all, now that all have come
    expect(page.locator(".card:focus .name")).to_have_text("render 7")
    page.keyboard.press("Home")
    expect(page.locator(".card:focus .name")).to_have_text(order[0])
    page.keyboard.press("Space")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+X")
    toolbar = page.get_by_role("toolbar", name="Selected renders")
    expect(toolbar).to_contain_text("3 selected")
    expect(page.get_by_label(f"Select {order[1]}")).to_be_checked()
    page.keyboard.press("x")
    expect(toolbar).to_contain_text("2 selected")
    page.keyboard.press("Escape")
    expect(toolbar).to_have_count(0)
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name=order[2])).to_be_visible()
    without_files(said)


def test_selected_renders_are_compared_and_tagged(page: Page, wall: Wall) -> None:
    page.goto(f"{wall.address}/?text=render+123")
    ids = {job["name"]: job["id"] for job in wall.http.get("/api/v1/jobs?text=render+123").json()["items"]}
    compare = page.get_by_role("toolbar").get_by_text("Compare")
    card(page, "render 1239").hover()
    page.get_by_label("Select render 1239", exact=True).check()
    expect(compare).to_be_disabled()
    card(page, "render 1237").click(modifiers=["Shift"])
    expect(page.get_by_role("toolbar")).to_contain_text("3 selected")
    chosen = ",".join(ids[f"render {number}"] for number in (1239, 1238, 1237))
    expect(compare).to_have_attribute("href", f"/compare?renders={chosen}")

    page.get_by_role("button", name="Tags").click()
    page.get_by_label("New tag").fill("chosen")
    page.get_by_role("button", name="Save").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    assert [wall.named(f"render {number}")[0]["tags"] for number in (1239, 1238, 1237)] == [["chosen"]] * 3
    card(page, "render 1236").click(modifiers=["Shift"])  # which is tagged `sky`
    page.get_by_role("button", name="Tags").click()
    expect(page.get_by_role("dialog").get_by_text("3 of 4")).to_be_visible()
    page.get_by_role("dialog").get_by_label("chosen").click()
    page.get_by_role("dialog").get_by_label("chosen").uncheck()
    page.get_by_role("button", name="Save").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    assert [wall.named(f"render {number}")[0]["tags"] for number in (1239, 1236)] == [[], ["sky"]]


def test_what_is_deleted_can_be_brought_back(page: Page, wall: Wall) -> None:
    def remove(text: str, *removed: str) -> None:
        page.goto(f"{wall.address}/?text={text}")
        for name in removed:
            card(page, name).hover()
            page.get_by_label(f"Select {name}", exact=True).check()
        page.get_by_role("button", name="Delete").click()
        for name in removed:
            expect(card(page, name)).to_have_count(0)

    remove("render+13", "render 1398", "render 1397")
    expect(page.get_by_role("status").get_by_text("2 renders deleted.")).to_be_visible()
    page.get_by_role("button", name="Undo").click()
    expect(page.locator(".name").nth(1)).to_have_text("render 1398")
    assert wall.named("render 1398")

    # Who leaves has meant it
    remove("render+13", "render 1396")
    assert wall.named("render 1396")
    page.goto("about:blank")
    end = time.monotonic() + 5
    while wall.named("render 1396"):
        assert time.monotonic() < end
        time.sleep(0.05)

    # One that must stay comes back, and it is said why
    asked = {"scene": SCENE, "name": "two", "vary": {"integrator": ["volumetric_path", "transmittance"]}, "seconds": 1}
    variants = wall.http.post("/api/v1/comparisons", json=asked).raise_for_status().json()["jobs"]
    for job in variants:
        wall.http.post(f"/api/v1/jobs/{job['id']}/cancel").raise_for_status()
    name = wall.http.get(f"/api/v1/jobs/{variants[0]['id']}").json()["name"]
    remove("two", name)
    page.evaluate("dispatchEvent(new PageTransitionEvent('pagehide'))")
    expect(page.get_by_role("alert").get_by_text("1 of 1 could not be deleted.")).to_contain_text("is a variant")
    expect(card(page, name)).to_be_visible()


# Batches


def test_a_batch_is_a_grid_of_its_values(page: Page, said: list[str], wall: Wall) -> None:
    page.goto(f"{wall.address}/batches/{wall.batch}")
    expect(page.get_by_role("heading", name="block")).to_be_visible()
    table = page.get_by_role("table")
    expect(table.locator("thead th")).to_have_text(["camera.fov", "volumes[0].sigma_t", "20", "35", "50"])
    expect(table.locator("tbody th")).to_have_text(["1", "2"])
    expect(table.locator("tbody img")).to_have_count(6)
    check(page, "batch")
    page.get_by_role("link", name="volumes[0].sigma_t = 2, camera.fov = 35").click()
    expect(page.get_by_role("heading", name=f"render {FEW - 2}")).to_be_visible()
    page.get_by_role("link", name="volumes[0].sigma_t = 2").click()
    expect(page).to_have_url(f"{wall.address}/batches/{wall.batch}")
    page.get_by_role("link", name="On the wall").click()
    expect(page.locator(".name")).to_have_text([f"render {FEW - 1 - index}" for index in range(6)])
    page.goto(f"{wall.address}/batches/none")
    expect(page.get_by_role("heading", name="There is no such batch")).to_be_visible()
    without_files(said)


@pytest.mark.slow
def test_a_batch_of_more_axes_is_stopped_and_deleted(page: Page, wall: Wall) -> None:
    product = {"seed": [7, 8], "volumes[0].sigma_t": [1, 2], "camera.fov": [20, 35]}
    asked = {"scene": SCENE, "name": "cube of values", "product": product, "zip": {"film.width": [8, 16]}}
    batch = wall.http.post("/api/v1/batches", json=asked).raise_for_status().json()
    page.goto(f"{wall.address}/batches/{batch['id']}")
    expect(page.get_by_text("0 of 16 done, 16 queued")).to_be_visible()
    page.get_by_label("film.width", exact=True).select_option("16")
    page.get_by_label("seed", exact=True).select_option("8")
    expect(page).to_have_url(f"{wall.address}/batches/{batch['id']}?at=1,1")
    page.reload()
    expect(page.get_by_label("seed", exact=True)).to_have_value("1")
    tile = page.get_by_title("film.width = 16, seed = 8, volumes[0].sigma_t = 1, camera.fov = 20")
    expect(page.locator(".tile")).to_have_count(4)
    page.get_by_role("button", name="Stop all…").click()
    page.get_by_role("button", name="Go on").click()
    page.get_by_role("button", name="Stop all…").click()
    page.get_by_role("button", name="Stop", exact=True).click()
    expect(page.get_by_text("0 of 16 done, 16 cancelled")).to_be_visible()
    expect(tile).to_be_visible()
    page.get_by_role("button", name="Delete").click()
    expect(page).to_have_url(f"{wall.address}/")
    expect(page.get_by_text("cube of values deleted, with 16 renders.")).to_be_visible()
    expect(page.locator(".name", has_text="cube of values")).to_have_count(0)
    page.get_by_role("button", name="Undo").click()
    expect(page.locator(".name").first).to_contain_text("cube of values")
    wall.http.delete(batch["links"]["self"]).raise_for_status()
    expect(page.locator(".name", has_text="cube of values")).to_have_count(0)
