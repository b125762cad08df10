"""What can be done with a render on its page, and what the fleet says, with the service itself in a browser."""

from __future__ import annotations

import hashlib
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from woodcock.scene import Scene
from woodcock_client import Client

from .conftest import SCENE
from .real import serving

Submit = Callable[..., str]

SMALL = {"film": {"width": 24, "height": 16}, "stop": {"kind": "samples", "samples": 16}}
#: A mesh that is not closed: nobody can say what is inside of it.
OPEN = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
LONG = {"stop": {"kind": "seconds", "seconds": 600}}
#: What is asked of the service for a cancellation answers when the page knows of it already.
LATE = """
const ask = window.fetch;
window.fetch = async (...asked) => {
  const answer = await ask(...asked);
  if (!String(asked[0]).endsWith("/cancel")) return answer;
  const badge = () => document.querySelector(".badge").textContent;
  while (badge() !== "Cancelled") await new Promise((done) => setTimeout(done, 10));
  setTimeout(() => (document.body.dataset.answered = ""), 200);
  return answer;
};
"""


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with serving(tmp_path_factory.mktemp("life")) as address:
        yield address


@pytest.fixture
def submit(address: str) -> Submit:
    """Asks for a render, waits for its end unless it has none, and returns its id."""

    def submit(name: str, wait: bool = True, **replaced: Any) -> str:
        with Client(address) as client:
            job = client.submit(Scene.model_validate({**SCENE, **SMALL, **replaced}), name=name)
            if wait:
                *_, last = client.follow(job.id)
                assert last.finished_at
        return job.id

    return submit


def told(page: Page, path: str) -> Any:
    """What the API says, asked past the page."""
    return page.request.get(f"{page.url.partition('/renders')[0]}/api/v1{path}").json()


def test_a_render_is_extended_and_rendered_again(page: Page, address: str, submit: Submit) -> None:
    first = submit("extended")
    page.goto(f"{address}/renders/{first}")
    extend = page.get_by_role("button", name="Extend to half the error")
    expect(extend).to_contain_text(re.compile(r"about .* more, to 64 samples per pixel"))
    extend.dblclick()
    expect(page.get_by_text("Goes on from")).to_be_visible()
    expect(page.locator(".badge")).to_have_text("Done", timeout=60_000)
    made = page.url.rpartition("/")[2]
    before, after = told(page, f"/jobs/{first}"), told(page, f"/jobs/{made}")
    assert (after["extends"], after["samples"]) == (first, 64)
    assert after["rmse"] == pytest.approx(before["rmse"] / 2, rel=0.25)
    named = told(page, "/jobs?text=extended")["items"]
    assert {job["id"] for job in named} == {first, made}, "a double click makes one"

    page.get_by_role("link", name="another render").click()
    expect(page).to_have_url(f"{address}/renders/{first}")
    expect(page.get_by_text("Goes on from")).to_have_count(0)
    page.get_by_role("button", name="Render again").click()
    expect(page).not_to_have_url(f"{address}/renders/{first}")
    expect(page.locator(".badge")).to_have_text("Done", timeout=60_000)
    again = told(page, f"/jobs/{page.url.rpartition('/')[2]}")
    seed = again["scene"].pop("seed")
    assert before["scene"].pop("seed") != seed
    assert again["scene"] == before["scene"]
    assert again["retry_of"] is None


def test_a_name_and_tags_are_changed_where_they_stand(page: Page, address: str, submit: Submit) -> None:
    id = submit("as it was")
    page.goto(f"{address}/renders/{id}")
    page.get_by_role("button", name="Rename").press("Enter")
    page.keyboard.type("as it is")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", level=1)).to_have_text("as it is")
    expect(page).to_have_title("as it is · Woodcock")
    expect(page.get_by_role("button", name="Rename")).to_be_focused()
    page.keyboard.press("Enter")
    page.keyboard.type("as it shall not be")
    page.keyboard.press("Escape")
    expect(page.get_by_role("heading", level=1)).to_have_text("as it is")
    for tag in ("two", "one"):
        page.get_by_role("button", name="Add tag").click()
        page.keyboard.type(tag)
        page.keyboard.press("Enter")
        expect(page.get_by_role("link", name=tag, exact=True)).to_be_visible()
    expect(page.locator(".tag")).to_have_text([re.compile("^one"), re.compile("^two")])
    page.get_by_role("button", name="Remove the tag two").click()
    expect(page.locator(".tag")).to_have_count(1)
    page.get_by_role("button", name="Pin").click()
    expect(page.get_by_role("button", name="Pinned")).to_have_attribute("aria-pressed", "true")
    job = told(page, f"/jobs/{id}")
    assert (job["name"], job["tags"], job["pinned"]) == ("as it is", ["one"], True)


def test_an_answer_that_comes_after_the_end_does_not_turn_it_back(page: Page, address: str, submit: Submit) -> None:
    page.add_init_script(LATE)
    page.goto(f"{address}/renders/{submit('late', wait=False, **LONG)}")
    page.get_by_role("button", name="Cancel").click()
    expect(page.locator("body[data-answered]")).to_be_attached(timeout=30_000)
    expect(page.locator(".badge")).to_have_text("Cancelled")
    expect(page.get_by_role("button", name="Try again")).to_be_visible()


def test_a_render_is_cancelled_tried_again_and_deleted(page: Page, address: str, submit: Submit) -> None:
    id = submit("stopped", wait=False, **LONG)
    page.goto(f"{address}/renders/{id}")
    expect(page.get_by_role("button", name=re.compile("Delete|Extend"))).to_have_count(0)
    page.get_by_role("button", name="Cancel").click()
    expect(page.locator(".badge")).to_have_text("Cancelled", timeout=30_000)
    page.get_by_role("button", name="Try again").dblclick()
    expect(page.get_by_text("Tries again")).to_be_visible()
    again = page.url.rpartition("/")[2]
    assert again != id
    assert {job["id"] for job in told(page, "/jobs?text=stopped")["items"]} == {id, again}
    page.get_by_role("button", name="Cancel").click()
    expect(page.locator(".badge")).to_have_text("Cancelled", timeout=30_000)
    page.get_by_role("button", name="Delete").click()
    expect(page).to_have_url(f"{address}/")
    page.get_by_role("button", name="Undo").click()
    page.goto(f"{address}/renders/{again}")
    page.get_by_role("button", name="Delete").click()
    expect(page.get_by_text("stopped is deleted.")).to_be_visible()
    page.goto("about:blank")  # who leaves has meant it
    end = time.monotonic() + 15
    while page.request.get(f"{address}/api/v1/jobs/{again}").status != 404:
        assert time.monotonic() < end
    assert page.request.get(f"{address}/api/v1/jobs/{id}").ok


def test_a_report_tells_what_was_left_out_and_how_to_make_it_again(page: Page, address: str, submit: Submit) -> None:
    id = submit("reported", stop={"kind": "seconds", "seconds": 2})
    page.goto(f"{address}/renders/{id}")
    expect(page.get_by_role("img", name=re.compile(r"The error fell from .* % after .* to .* % after"))).to_be_visible()
    lean = page.locator("section").filter(has=page.get_by_role("heading", name="What the scene did not need"))
    expect(lean).to_contain_text(re.compile(r"lines of the renderer, \d.* %, were not compiled in"))
    lights = lean.locator(".table > div").filter(has_text="Lights")
    expect(lights).to_contain_text(
        "even surroundings · without pictures of surroundings, directional, sun, point, spot"
    )
    surfaces = lean.locator(".table > div").filter(has_text="Surfaces").locator("dd")
    expect(surfaces).to_have_text("without sphere, rectangle, disk, mesh")
    assert page.locator(".certificate li").count() == page.locator(".certificate details").count()

    made = page.locator("section").filter(has=page.get_by_role("heading", name="How to make it again"))
    with page.expect_download() as scene:
        page.get_by_role("link", name="Scene").click()
    expect(made).to_contain_text(hashlib.sha256(scene.value.path().read_bytes()).hexdigest())
    report = told(page, f"/jobs/{id}/report.json")
    expect(made).to_contain_text(report["program_hash"])
    expect(made).to_contain_text(f'"samples": {report["samples"]}')
    expect(made.locator("pre")).to_contain_text(f"woodcock submit scene.json --server {address} --device ")


def test_the_fleet_says_what_it_does_and_what_failed(page: Page, address: str, submit: Submit, tmp_path: Path) -> None:
    mesh = tmp_path / "open.obj"
    mesh.write_text(OPEN)
    submit("an open mesh", volumes=[{**SCENE["volumes"][0], "shape": {"kind": "mesh", "file": str(mesh)}}])
    going, waits = submit("goes on", wait=False, **LONG), submit("waits", wait=False)
    page.goto(f"{address}/renders/{going}")
    expect(page.locator(".badge")).to_have_text("Rendering")
    page.get_by_role("link", name="Fleet").click()
    expect(page).to_have_url(f"{address}/fleet")
    expect(page.get_by_role("link", name="Fleet")).to_have_attribute("aria-current", "page")
    card = page.locator(".device-card").first
    (device, *_) = page.request.get(f"{address}/api/v1/devices").json()["items"]
    expect(card.get_by_role("heading", level=3)).to_have_text(device["name"])
    expect(card.locator(".badge")).to_have_text("Ready")
    expect(card.get_by_role("link", name="goes on")).to_be_visible()
    expect(card.get_by_role("progressbar", name="Progress of goes on")).to_be_visible()
    expect(card).to_contain_text("Waiting1 render")
    expect(card).to_contain_text("samples a second when it last rendered")
    states = page.locator(".states")
    for state in ("running", "queued", "failed"):
        expect(states.locator(f".{state} dd")).to_have_text(re.compile("^1 "))
    failed = page.locator(".reasons > li")
    expect(failed).to_have_count(1)
    expect(failed).to_contain_text("A file that the scene names cannot be used 1 render, the newest just now")
    expect(failed).to_contain_text(re.compile(r"sha256:[0-9a-f]{8}…"))
    expect(page.get_by_text("Everything is kept until somebody deletes it")).to_be_visible()
    expect(page.get_by_text(re.compile(r"^Woodcock \d"))).to_be_visible()
    failed.get_by_role("link", name="an open mesh").click()
    expect(page.locator(".failure")).to_contain_text("mend the file, upload it anew")
    for id in (waits, going):
        page.request.post(f"{address}/api/v1/jobs/{id}/cancel")


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_check_is_begun_and_its_cases_are_shown(page: Page, tmp_path: Path) -> None:
    with serving(tmp_path) as address:
        page.goto(f"{address}/fleet")
        card = page.locator(".device-card").first
        card.get_by_role("button", name="Check its stability").click()
        expect(card.locator(".badge")).to_have_text("Being checked")
        expect(card.get_by_role("button", name="Being checked…")).to_be_disabled()
        expect(card.get_by_role("button", name="Check again")).to_be_visible(timeout=800_000)
        expect(card).to_contain_text("Stabilitypassed just now")
        card.get_by_text("Its cases").click()
        expect(card.locator("tbody tr")).not_to_have_count(0)
        expect(card.locator("tbody tr.failed")).to_have_count(0)
