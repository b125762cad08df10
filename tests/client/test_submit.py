"""The page where scenes are written, in a real browser, with the service itself."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from woodcock.scene import Scene
from woodcock_client import Client

from .real import serving
from .waiting import until


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A real service for what these tests submit and upload."""
    with serving(tmp_path_factory.mktemp("submit")) as address:
        yield address


@pytest.fixture
def editor(page: Page, address: str) -> Locator:
    """The page, open; where its text is written."""
    page.goto(f"{address}/submit")
    expect(page.get_by_text("This can be rendered.")).to_be_visible()
    return page.get_by_role("textbox", name="Scene, as JSON")


def text_of(page: Page) -> str:
    return str(page.evaluate("JSON.parse(sessionStorage.getItem('woodcock-draft')).text"))


def write(page: Page, editor: Locator, text: str) -> None:
    """In place of what is there, as if pasted: brackets close by themselves where they are typed."""
    editor.press("Control+a")
    page.keyboard.insert_text(text)


def write_scene(page: Page, editor: Locator, scene: dict[str, Any]) -> None:
    write(page, editor, json.dumps(scene))
    expect(page.get_by_text("This can be rendered.")).to_be_visible()


def offers(page: Page) -> Locator:
    return page.locator(".cm-tooltip-autocomplete").get_by_role("option")


def accept(page: Page) -> None:
    page.wait_for_timeout(150)  # the editor takes no Enter for what it has only just shown
    page.keyboard.press("Enter")


def refused(said: list[str]) -> None:
    """The browser's own lines about answers that were refusals, and no others, were said."""
    assert said
    assert all("422" in text for text in said)
    said.clear()


# Writing


def test_keys_and_kinds_are_offered(page: Page, editor: Locator) -> None:
    write(page, editor, '{"camera": ')
    editor.press("Control+Space")
    kinds = ["orthographic", "perspective", "spherical", "thin_lens"]
    expect(offers(page)).to_have_text([re.compile(f"^{kind}") for kind in kinds])
    page.keyboard.type("perspec")
    expect(offers(page)).to_have_count(1)
    accept(page)
    assert json.loads(text_of(page) + "}")["camera"] == {
        "kind": "perspective", "origin": [0, 0, 5], "target": [0, 0, 0]
    }  # fmt: skip

    # Of an object of a kind the keys of that kind, less those that are there
    write(page, editor, '{"lights": [{"kind": "sun", "direction": [0, -1, 0], ')
    editor.press("Control+Space")
    expect(offers(page)).to_have_text(["irradiancerequired", re.compile("^angular_radius")])
    accept(page)
    assert text_of(page).endswith('"irradiance": 3')

    # Before there is a kind nothing else; then the kinds
    write(page, editor, '{"stop": {')
    page.keyboard.type('"')
    expect(offers(page)).to_have_text(re.compile("^kind"))
    accept(page)
    editor.press("Control+Space")
    expect(offers(page)).to_have_text(["relative_error", "samples", "seconds"])


def test_the_pointer_asks_what_a_field_is(page: Page, editor: Locator) -> None:
    editor.get_by_text('"sigma_t"').hover()
    note = page.locator(".note")
    expect(note).to_contain_text("Extinction coefficient, inverse scene units: one number or red, green, blue.")
    expect(note).to_contain_text("a number 0 or more or a list of 3")


def test_a_fault_is_marked_at_its_field(
    page: Page, said: list[str], editor: Locator, scene_json: dict[str, Any]
) -> None:
    scene_json["volumes"][0]["sigma_t"] = -4.5
    del scene_json["camera"]["origin"]
    write(page, editor, json.dumps(scene_json))
    faults = page.locator(".problems").get_by_role("button")
    expect(faults).to_have_text([re.compile("camera.origin.*is required"), re.compile("sigma_t.*0 or more")])
    expect(editor.locator(".cm-lintRange-error")).to_have_text(['"camera"', '"sigma_t": -4.5'])

    # The list leads there, and what is mended is a fault no more
    faults.last.click()
    page.keyboard.insert_text('"sigma_t": 4.5')
    expect(faults).to_have_count(1)
    expect(editor.locator(".cm-lintRange-error")).to_have_text(['"camera"'])

    # What is no JSON is marked at once, and nothing can be sent
    write(page, editor, '{"camera": {]}')
    expect(faults).to_have_text(re.compile("This is not JSON yet"))
    expect(editor.locator(".cm-lintRange-error")).to_have_count(1)
    expect(page.get_by_role("button", name="Render", exact=True)).to_be_disabled()

    # Faults beside the scene lead to their controls
    editor.press("Control+z")
    editor.press("Control+z")
    page.get_by_label("Tags, with commas").fill("a" * 65)
    faults.filter(has_text="tags[0]").click()
    expect(page.get_by_label("Tags, with commas")).to_be_focused()
    refused(said)


def test_what_is_written_outlives_a_reload(page: Page, editor: Locator, scene_json: dict[str, Any]) -> None:
    write_scene(page, editor, {**scene_json, "seed": 777})
    page.get_by_label("Name").fill("kept")
    page.reload()
    expect(editor).to_contain_text('"seed": 777')
    expect(page.get_by_label("Name")).to_have_value("kept")


def test_it_begins_with_a_render(page: Page, address: str, scene_json: dict[str, Any]) -> None:
    scene = Scene.model_validate({**scene_json, "seed": 5, "stop": {"kind": "samples", "samples": 1}})
    with Client(address) as client:
        job = client.submit(scene, name="the first")
        for _ in client.follow(job.id):
            pass
    page.goto(f"{address}/submit?from={job.id}")
    expect(page.get_by_label("Name")).to_have_value("the first")
    expect(page.get_by_text("This can be rendered.")).to_be_visible()
    assert Scene.model_validate_json(text_of(page)) == scene
    assert '"filter"' not in text_of(page), "what is as by default is not written"
    assert page.url == f"{address}/submit"


# Sending


def test_an_example_renders_to_its_end(page: Page, address: str, editor: Locator) -> None:
    page.get_by_role("button", name="shadow").click()
    expect(editor).to_contain_text('"orthographic"')
    scene = json.loads(text_of(page))
    assert re.fullmatch("sha256:[0-9a-f]{64}", scene["volumes"][0]["file"])
    expect(page.locator(".stored")).to_contain_text("fireball.vdb")
    write_scene(page, editor, {**scene, "film": {"width": 48, "height": 48}, "stop": {"kind": "samples", "samples": 2}})

    page.get_by_role("button", name="Estimate").click()
    expect(page.locator(".estimate")).to_contain_text("alone:", timeout=60_000)
    expect(page.locator(".estimate")).to_contain_text("Takes")
    expect(page.locator(".estimate")).to_contain_text("transmittance")

    page.get_by_role("button", name="Render", exact=True).click()
    expect(page.get_by_role("heading", name="shadow")).to_be_visible()
    expect(page.locator(".badge")).to_have_text("Done", timeout=60_000)
    expect(page.locator("canvas").first).to_be_visible()


def test_a_sweep_of_two_fields_is_a_batch(
    page: Page, address: str, editor: Locator, scene_json: dict[str, Any]
) -> None:
    write_scene(page, editor, {**scene_json, "stop": {"kind": "samples", "samples": 1}})
    page.get_by_role("button", name="Vary a field").click()
    page.get_by_label("Path", exact=True).fill("volumes[0].sigma_t")
    assert page.locator("#paths option[value='volumes[0].sigma_t']").count() == 1
    page.get_by_label("Values", exact=True).fill("1, 2")
    expect(page.get_by_text("2 renders")).to_be_visible()
    page.get_by_role("button", name="Vary another field").click()
    second = page.get_by_role("group", name="Field 2")
    second.get_by_label("Path", exact=True).fill("film.width")
    second.get_by_label("Takes").select_option("log")
    for label, value in (("From", "16"), ("To", "64"), ("Steps", "2")):
        second.get_by_label(label, exact=True).fill(value)
    page.get_by_role("button", name="Render 4").click()
    expect(page).to_have_url(re.compile(r"batch"))
    with Client(address) as client:
        batch = client.batch(re.search(r"[0-9a-f-]{36}", page.url)[0])  # type: ignore[index]
    points = [(job.point["volumes[0].sigma_t"], job.point["film.width"]) for job in batch.jobs]
    assert points == [(1, 16), (1, 64), (2, 16), (2, 64)]


# Files


def test_an_uploaded_volume_shows_its_slices(page: Page, said: list[str], editor: Locator, tmp_path: Path) -> None:
    values = np.random.default_rng(3).random((4, 5, 6)).astype(np.float32)
    np.save(tmp_path / "noise.npy", values)
    page.get_by_label("Files to upload").set_input_files(tmp_path / "noise.npy")
    page.locator(".stored").filter(has_text="noise.npy").locator("summary").click()
    expect(page.get_by_text(f"values from {values.min():.3g} to {values.max():.3g}")).to_be_visible()
    expect(pixels(page, values, values[2])).to_be_visible()
    page.get_by_label("x", exact=True).check()
    page.get_by_label("Position").fill("4")
    pixels(page, values, values[:, :, 4])

    # It goes into the scene, and where the cursor is in something that names a file, there
    page.get_by_role("button", name="Use in the scene").click()
    expect(page.get_by_text("This can be rendered.")).to_be_visible()
    volumes = json.loads(text_of(page))["volumes"]
    assert [volume["kind"] for volume in volumes] == ["constant", "grid"]
    write(page, editor, '{"volumes": [{"kind": "grid", "file": "?", "albedo": 0.5}]}')
    for _ in range(5):
        editor.press("ArrowLeft")
    page.get_by_role("button", name="Use in the scene").click()
    (volume,) = json.loads(text_of(page))["volumes"]
    said.clear()  # the file that was named at first was none
    assert volume == {"kind": "grid", "grid": "density", "file": volumes[1]["file"], "albedo": 0.5}


def pixels(page: Page, values: Any, plane: Any) -> Locator:
    """The picture of a slice, once it is of this plane, whose last row is shown first."""
    image = page.locator(".slice img")
    expected = np.rint(255 * plane.astype(np.float64) / values.max()).astype(int)[::-1]
    until(
        page,
        """(expected) => {
            const image = document.querySelector(".slice img");
            if (!image?.complete || image.naturalHeight !== expected.length) return false;
            const canvas = document.createElement("canvas");
            [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
            const draw = canvas.getContext("2d");
            draw.drawImage(image, 0, 0);
            const { data } = draw.getImageData(0, 0, canvas.width, canvas.height);
            return expected.flat().every((value, at) => data[4 * at] === value);
        }""",
        arg=expected.tolist(),
    )
    return image


def test_files_are_dropped_anywhere(page: Page, said: list[str], editor: Locator) -> None:
    before = text_of(page) if page.evaluate("sessionStorage.length") else None
    drop = """(names) => {
        const files = new DataTransfer();
        for (const name of names) files.items.add(new File(["not a volume"], name));
        const target = document.querySelector(".editor").shadowRoot.querySelector(".cm-content");
        for (const kind of ["dragover", "drop"]) {
            const how = { dataTransfer: files, bubbles: true, composed: true, cancelable: true };
            target.dispatchEvent(new DragEvent(kind, how));
        }
    }"""
    page.evaluate(drop, ["broken.vdb"])
    expect(page.get_by_role("alert").filter(has_text="broken.vdb: is no file that can be read")).to_be_visible()
    page.get_by_role("button", name="Dismiss").click()
    expect(page.get_by_text("broken.vdb")).to_have_count(0)
    assert (text_of(page) if before else None) == before, "the file's text is not the editor's"
    refused(said)
