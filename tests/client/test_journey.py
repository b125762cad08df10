"""The whole way through the gallery, with the service itself: from a volume on disk to a picture that is shared and,
in the end, deleted."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from woodcock.image import read_exr

from .looking import told
from .real import serving


def test_from_a_volume_to_a_picture_that_is_shared_and_deleted(
    page: Page, context: BrowserContext, said: list[str], tmp_path: Path
) -> None:
    values = np.random.default_rng(5).random((4, 5, 6)).astype(np.float32)
    np.save(tmp_path / "noise.npy", values)
    with serving(tmp_path) as address:
        # Upload, from the wall that has nothing to show
        page.goto(address)
        page.get_by_role("link", name="Begin with an example").click()
        expect(page).to_have_url(f"{address}/submit")
        page.get_by_label("Files to upload").set_input_files(tmp_path / "noise.npy")
        page.locator(".stored").filter(has_text="noise.npy").locator("summary").click()
        page.get_by_role("button", name="Use in the scene").click()
        expect(page.get_by_text("This can be rendered.")).to_be_visible()

        # Submit and watch
        page.get_by_label("Name").fill("noise in a box")
        page.get_by_role("button", name="Render", exact=True).click()
        expect(page.get_by_role("heading", name="noise in a box")).to_be_visible()
        expect(page.locator(".heading .badge")).to_have_text("Done", timeout=90_000)
        render = page.url

        # View: what is under the pointer is in the EXR
        expect(page.locator("canvas")).to_be_visible()
        page.locator("canvas").hover()
        expect(page.locator(".note .at")).to_have_text(re.compile(r"^\d+, \d+$"))
        x, y = (int(each) for each in page.locator(".note .at").inner_text().split(","))
        channels, header = read_exr(
            tmp_path / "data" / "jobs" / render.rsplit("/", 1)[1].partition("?")[0] / "image.exr"
        )
        text = page.locator(".note .line").inner_text()
        found = [float(number) for number in re.findall(r"\d+\.?\d*(?:e-?\d+)?", text)][::2]
        assert found == pytest.approx([channels["Y"][y, x]], rel=1e-4)
        assert "noise.npy" not in header["scene"], "it is named by its content"

        # Again with other random numbers, and held against the first
        page.get_by_role("button", name="Render again").click()
        expect(page).not_to_have_url(re.compile(re.escape(render.partition("?")[0])))
        expect(page.locator(".heading .badge")).to_have_text("Done", timeout=90_000)
        page.get_by_role("navigation").get_by_role("link", name="Renders").click()
        expect(page.locator(".card")).to_have_count(2)
        for box in page.get_by_role("checkbox", name="Select noise in a box").all():
            box.check()
        toolbar = page.get_by_role("toolbar", name="Selected renders")
        toolbar.get_by_role("link", name="Compare").click()
        expect(page.locator(".verdicts strong")).to_contain_text("Noise", timeout=30_000)
        page.keyboard.press("s")
        told(page, mode="split")

        # The address is the view: it shows the same to whoever is sent it
        other = context.new_page()
        other.goto(page.url)
        expect(other.get_by_role("slider", name="Where the pictures meet")).to_be_visible()
        expect(other.locator(".verdicts strong")).to_contain_text("Noise", timeout=30_000)
        other.close()

        # Delete both; what was undone stays, what was not is gone
        page.goto(address)
        expect(page.locator(".card")).to_have_count(2)
        for box in page.get_by_role("checkbox", name="Select noise in a box").all():
            box.check()
        page.get_by_role("button", name="Delete").click()
        expect(page.locator(".card")).to_have_count(0)
        page.get_by_role("button", name="Undo").click()
        expect(page.locator(".card")).to_have_count(2)
        for box in page.get_by_role("checkbox", name="Select noise in a box").all():
            box.check()
        page.get_by_role("button", name="Delete").click()
        expect(page.locator(".card")).to_have_count(0)
        page.goto("about:blank")  # what was put off is done when the gallery is left
        end = time.monotonic() + 15
        while page.request.get(f"{address}/api/v1/jobs").json()["items"]:
            assert time.monotonic() < end
            time.sleep(0.1)
        page.goto(render)
        expect(page.get_by_role("heading", name="There is no such render")).to_be_visible()
        assert all("404" in text for text in said)
        said.clear()
        assert list((tmp_path / "data" / "jobs").iterdir()) == []
