"""The viewer in a real browser: what it draws against numpy, what it tells against the EXR."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator
from urllib.parse import parse_qsl, urlsplit

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from woodcock.camera import spherical
from woodcock.film import LUMINANCE, Film
from woodcock.image import read_exr, tone_map
from woodcock.pages.pictures import SEQUENTIAL
from woodcock.scene import SphericalCamera

from .conftest import SCENE
from .curves import CURVES, srgb
from .easel import Easel, standing
from .looking import HEIGHT, PATIENCE, WIDTH, Floats, corner, drawn, film, point_at, told, turn, view_of, visit
from .pixels import shown
from .service import WEB


@pytest.fixture(scope="module")
def easel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Easel]:
    with standing(tmp_path_factory.mktemp("easel")) as easel:
        yield easel


@pytest.fixture(scope="module")
def picture(easel: Easel) -> str:
    """The id of a job that is done. The scene that is told has nothing to do with the picture."""
    return easel.hang(SCENE, film(1), "noise")


@pytest.fixture
def exr(easel: Easel, picture: str) -> dict[str, Floats]:
    found = read_exr(easel.storage.job_file(picture, "image.exr"))[0]
    return {name: values.astype(np.float64) for name, values in found.items()}


# What is drawn


def stacked(exr: dict[str, Floats], layer: str) -> Floats:
    return np.stack([exr[f"{layer}{channel}"] for channel in "RGB"], axis=-1)


def test_exposure_and_curves_are_as_numpy_has_them(
    page: Page, easel: Easel, picture: str, exr: dict[str, Floats]
) -> None:
    visit(page, easel, picture, zoom=4)
    beauty = stacked(exr, "")
    drawn(page, 255 * tone_map(beauty))  # at first as the preview
    for curve, layer, stops in (
        ("soft", "", 1.5), ("linear", "", -2), ("filmic", "order.0.", -1), ("agx", "order.rest.", 0.5), ("agx", "", -3)
    ):  # fmt: skip
        turn(page, zoom=4, layer=layer.rstrip(".") or "beauty", curve=curve, exposure=stops)
        drawn(page, CURVES[curve](stacked(exr, layer) * 2**stops))


def test_small_pixels_are_means_of_radiance(page: Page, easel: Easel, picture: str, exr: dict[str, Floats]) -> None:
    beauty = stacked(exr, "")
    visit(page, easel, picture, zoom=0.5, exposure=0)
    for zoom, side in ((0.5, 2), (0.25, 4), (0.0625, 16)):
        turn(page, zoom=zoom, exposure=0, curve="linear")
        mean = beauty.reshape(HEIGHT // side, side, WIDTH // side, side, 3).mean(axis=(1, 3))
        drawn(page, srgb(mean), zoom)


def table(name: str) -> Floats:
    """A false colour's, from the page's own file."""
    found = re.search(name + r': \{\s*name: "[^"]*",\s*digits:([^,]*),', (WEB / "viewer/colours.js").read_text())
    assert found
    digits = "".join(re.findall(r'"(\w+)"', found[1]))
    return np.array([int(digits[at : at + 2], 16) for at in range(0, len(digits), 2)], float).reshape(-1, 3)


def coloured(share: Floats, colours: Floats) -> Floats:
    steps = np.linspace(0, 1, len(colours))
    return np.stack([np.interp(np.clip(share, 0, 1), steps, colours[:, c]) for c in range(3)], axis=-1)


def test_false_colours_are_as_numpy_has_them(page: Page, easel: Easel, picture: str, exr: dict[str, Floats]) -> None:
    viridis, inferno = table("viridis"), table("inferno")
    assert coloured(np.linspace(0, 1, len(SEQUENTIAL)), viridis) == pytest.approx(255 * SEQUENTIAL, abs=4)
    visit(page, easel, picture, zoom=4, layer="depth", range="1.5,4")
    drawn(page, coloured((exr["depth.Z"] - 1.5) / 2.5, viridis))
    legend = page.locator(".legend")
    expect(legend).to_have_attribute("aria-label", re.compile("Depth: from 1.5 to 4 in the scene’s unit of length"))
    turn(page, zoom=4, layer="variance", map="inferno", range="1e-7,1e-3")
    luminance = stacked(exr, "variance.") @ LUMINANCE
    drawn(page, coloured((np.log10(luminance) + 7) / 4, inferno))
    expect(legend).to_contain_text("Variance, luminance in the square of the scene’s unit of radiance")
    turn(page, zoom=4, channel="G", map="viridis", range="0,8")
    drawn(page, coloured(exr["G"] / 8, viridis))
    # Of itself, from 0, which is near the first percentile, to the 99th
    turn(page, zoom=4, layer="depth")
    drawn(page, coloured(exr["depth.Z"] / np.percentile(exr["depth.Z"], 99), viridis))


def test_what_is_no_number_is_seen(page: Page, easel: Easel) -> None:
    mean = np.full((4, 6, 1), 0.5)
    mean[0, 0], mean[1, 2], mean[3, 5] = np.nan, np.inf, -np.inf
    nothing = Film(np.full((4, 6), 4, np.uint32), mean, np.zeros_like(mean), ("Y",), ((0, 4),))
    job = easel.hang(SCENE, nothing)
    visit(page, easel, job, zoom=8, exposure=0, curve="linear")
    flagged = np.full((4, 6, 3), srgb(np.array(0.5)))
    flagged[0, 0], flagged[1, 2], flagged[3, 5] = (255, 0, 255), (0, 255, 255), (0, 255, 255)
    drawn(page, flagged, 8)
    button = page.get_by_role("button", name="NaN/Inf 3 pixels")
    expect(button).to_have_attribute("aria-pressed", "true")
    button.click()
    plain = np.where(np.isfinite(mean), srgb(np.array(0.5)), 0.0).repeat(3, axis=-1)
    drawn(page, plain, 8)
    told(page, flag="0")
    turn(page, zoom=0.5, exposure=0, curve="linear")  # from afar, too
    drawn(
        page,
        np.array([[(255, 0, 255), (0, 255, 255), (188, 188, 188)], [(188,) * 3, (188,) * 3, (0, 255, 255)]], float),
        0.5,
    )
    page.mouse.move(*point_at(page, 0, 0, 0.5))
    note = page.locator(".note")
    box = page.locator("canvas").bounding_box()
    assert box
    turn(page, zoom=8, values=1)
    left, top = corner(page, 8, 6, 4)
    for x, y, says in ((0, 0, "NaN"), (2, 1, "∞"), (5, 3, "−∞")):
        page.mouse.move(box["x"] + left + 8 * x + 4, box["y"] + top + 8 * y + 4)
        expect(note).to_contain_text(f"{x}, {y} Beauty Y {says}")
        expect(page.get_by_role("row", name="Beauty").locator("td")).to_have_text([says])


# What is told


def numbers(text: str) -> list[float]:
    return [float(each) for each in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", text.replace("−", "-"))]


def test_values_under_the_pointer_are_those_of_the_exr(
    page: Page, easel: Easel, picture: str, exr: dict[str, Floats]
) -> None:
    visit(page, easel, picture, zoom=8, values=1)
    rows = page.locator(".values tr")
    for x, y in ((0, 0), (47, 31), (13, 22)):
        page.mouse.move(*point_at(page, x, y, 8))
        expect(page.locator(".values caption")).to_have_text(f"Pixel {x}, {y}")
        found = {
            row.locator("th").inner_text(): numbers(" ".join(row.locator("td").all_inner_texts())) for row in rows.all()
        }
        layers = {"Beauty": "RGB", "Order 0": "order.0.", "Higher orders": "order.rest.", "Depth": ["depth.Z"],
                  "Variance": "variance.", "Variance of order 0": "variance.order.0.",
                  "Variance of higher orders": "variance.order.rest.", "Samples": ["samples.count"]}  # fmt: skip
        assert list(found) == list(layers)
        for title, names in layers.items():
            channels = [f"{names}{c}" for c in "RGB"] if isinstance(names, str) and names != "RGB" else list(names)
            assert found[title] == pytest.approx([exr[name][y, x] for name in channels], rel=1e-5), title
        told = numbers(page.locator(".note .line").inner_text())
        assert told[::2] == pytest.approx([exr[c][y, x] for c in "RGB"], rel=1e-5)
        assert told[1::2] == pytest.approx([math.sqrt(exr[f"variance.{c}"][y, x]) for c in "RGB"], rel=0.06)
    page.mouse.move(2, 2)
    expect(page.locator(".values")).to_have_count(0)


def test_a_crop_is_chosen_told_and_shared(
    page: Page, context: BrowserContext, easel: Easel, picture: str, exr: dict[str, Floats]
) -> None:
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    visit(page, easel, picture, zoom=8)
    page.keyboard.down("Shift")
    page.mouse.move(*point_at(page, 10, 5, 8))
    page.mouse.down()
    page.mouse.move(*point_at(page, 20, 12, 8), steps=3)
    page.mouse.move(*point_at(page, 29, 24, 8))
    page.mouse.up()
    page.keyboard.up("Shift")
    told(page, crop="10,5,20,20", zoom="8")
    part = np.s_[5:25, 10:30]
    mean = page.locator(".crop .mean")
    expect(mean).to_contain_text("Mean of Beauty: R")
    found = numbers(mean.inner_text())
    assert found[::2] == pytest.approx([exr[c][part].mean() for c in "RGB"], rel=1e-5)
    assert found[1::2] == pytest.approx([math.sqrt(exr[f"variance.{c}"][part].sum()) / 400 for c in "RGB"], rel=0.06)
    page.get_by_role("button", name="Copy link").click()
    expect(page.get_by_text("Copied")).to_be_visible()
    link = page.evaluate("navigator.clipboard.readText()")
    assert dict(parse_qsl(urlsplit(link).query)) == {"crop": "10,5,20,20"}
    page.goto(link)
    expect(page.get_by_label("Left")).to_have_value("10")
    frame, canvas = page.locator(".frame").bounding_box(), page.locator("canvas").bounding_box()
    assert frame
    assert canvas
    assert frame["height"] == pytest.approx(0.9 * canvas["height"], abs=3)
    assert frame["y"] - canvas["y"] == pytest.approx(0.05 * canvas["height"], abs=3)
    page.get_by_label("Width").fill("7")
    page.keyboard.press("Enter")
    told(page, crop="10,5,7,20")
    page.get_by_role("button", name="Clear").click()
    told(page, crop=None, zoom=None)
    expect(page.locator(".frame")).to_have_count(0)


@pytest.mark.slow
def test_everything_is_done_with_keys(page: Page, easel: Easel, picture: str, exr: dict[str, Floats]) -> None:
    visit(page, easel, picture, zoom=8)
    canvas = page.get_by_role("application", name="Picture of noise: Beauty, 48 × 32 pixels")
    canvas.focus()
    note = page.locator(".note")
    for key, x in (("ArrowRight", 30), ("ArrowRight", 36), ("ArrowLeft", 30)):
        page.keyboard.press(key)
        told(page, x=str(x))
        expect(note).to_contain_text(f"{x}, 16 Beauty R {exr['R'][16, x]:.3g}"[:-1])
    for key, changed in (
        ("+", {"zoom": "11.3137"}), ("-", {"zoom": "8"}), ("0", {"zoom": None, "x": None}), ("1", {"zoom": "1"}),
        ("e", {}), ("c", {"curve": "linear"}), ("c", {"curve": "filmic"}), ("f", {"map": "viridis"}),
        ("f", {"map": "none"}),
        ("h", {"histogram": "1"}), ("v", {"values": "1"}), ("n", {"flag": "0"}), ("n", {"flag": None}),
        ("l", {"layer": "order.0", "map": None}), ("L", {"layer": None}), ("L", {"layer": "samples"}),
    ):  # fmt: skip
        before = float(view_of(page).get("exposure", "nan"))
        page.keyboard.press(key)
        told(page, **changed)
        if key == "e":
            page.keyboard.press("E")
            page.keyboard.press("E")
            white = np.percentile(stacked(exr, "").max(axis=-1), 99)
            end = time.monotonic() + PATIENCE
            right = pytest.approx(0.5 - math.log2(white), abs=1e-3)
            while float(view_of(page).get("exposure", "nan")) != right:
                assert time.monotonic() < end, page.url
                page.wait_for_timeout(30)
            assert math.isnan(before)
    expect(page.get_by_role("img", name="Histogram from 16 to 16")).to_be_visible()
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keys of the viewer")).to_contain_text("next tone curve")
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    expect(canvas.or_(page.get_by_role("application"))).to_be_focused()


def test_a_view_is_in_its_address(page: Page, easel: Easel, picture: str, exr: dict[str, Floats]) -> None:
    view = {"layer": "order.0", "channel": "B", "exposure": "1.25", "curve": "agx", "map": "turbo", "log": "1",
            "range": "0.001,4", "flag": "0", "zoom": "12", "x": "20", "y": "10.5", "crop": "3,4,5,6",
            "histogram": "1"}  # fmt: skip
    visit(page, easel, picture, **view)
    expect(page.get_by_label("Shown as")).to_have_value("turbo")
    page.locator("canvas").focus()
    page.keyboard.press("v")
    told(page, **view, values="1")
    address = page.url
    page.get_by_label("to", exact=True).fill("3")
    page.keyboard.press("Enter")
    told(page, range="0.001,3")
    page.goto(address)
    expect(page.get_by_label("to", exact=True)).to_have_value("4")
    # What is no view is none
    turn(
        page,
        layer="nothing",
        channel="Q",
        exposure="x",
        curve="__proto__",
        range="2,1",
        zoom="1e9",
        crop="40,0,20,1",
        yaw="",
    )
    drawn_beauty = page.get_by_label("Shown as")
    expect(drawn_beauty).to_have_value("soft")
    expect(page.get_by_label("Layer")).to_have_value("beauty")
    expect(page.locator(".frame")).to_have_count(0)


# From the inside, while it is rendered, and without WebGL


def test_a_spherical_picture_is_looked_at_from_its_inside(page: Page, easel: Easel) -> None:
    width, height = 64, 32
    v, u = np.mgrid[:height, :width]
    mean = np.stack([(u + 0.5) / width, (v + 0.5) / height, np.zeros((height, width))], axis=-1)
    mapped = Film(np.full((height, width), 4, np.uint32), mean, np.zeros_like(mean), ("R", "G", "B"), ((0, 4),))
    camera = {"kind": "spherical", "origin": [0, 0, 0], "target": [1, 2, 3], "up": [0, 1, 0.5]}
    job = easel.hang({**SCENE, "camera": camera}, mapped)
    pose = SphericalCamera.model_validate(camera)
    visit(page, easel, job, yaw=50, pitch=-20, fov=60, exposure=0, curve="linear")
    expect(page.get_by_role("button", name="Panorama")).to_have_attribute("aria-pressed", "true")
    box = page.locator("canvas").bounding_box()
    assert box

    def direction(u: float, v: float) -> Floats:
        return spherical.ray(pose, 2.0, np.array(u), np.array(v))[1]

    ahead = direction(0.5 + 50 / 360, 0.5 + 20 / 180)
    right = direction(0.5 + 140 / 360, 0.5)
    up = np.cross(right, ahead)
    screen = shown(page.locator("canvas"))
    for share_x, share_y in ((0.5, 0.5), (0.1, 0.2), (0.9, 0.3), (0.7, 0.95)):
        x, y = share_x * box["width"], share_y * box["height"]
        across, rise = ((2 * x - box["width"]) / box["height"], (box["height"] - 2 * y) / box["height"])
        looked = ahead + math.tan(math.radians(30)) * (across * right + rise * up)
        page.mouse.move(box["x"] + x, box["y"] + y)
        end, near = time.monotonic() + PATIENCE, False
        while not near:
            assert time.monotonic() < end, "not the pixel of that direction"
            column, row = (int(each) for each in page.locator(".note .at").inner_text().split(","))
            cosine = np.dot(direction((column + 0.5) / width, (row + 0.5) / height), looked) / np.linalg.norm(looked)
            near = cosine > math.cos(math.pi / height)
        red, green, _ = screen[int(y), int(x)]
        assert [red, green] == pytest.approx(srgb(np.array([(column + 0.5) / width, (row + 0.5) / height])), abs=6)
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 60, box["y"] + 130)
    page.mouse.up()
    page.mouse.wheel(0, -200)
    told(page, panorama=None)
    end = time.monotonic() + PATIENCE
    while (
        not (view := {name: float(value) for name, value in view_of(page).items() if name in ("yaw", "pitch", "fov")})[
            "fov"
        ]
        < 50
    ):
        assert time.monotonic() < end
        page.wait_for_timeout(30)
    assert view["yaw"] > 51
    assert view["pitch"] > -19
    page.locator("canvas").focus()
    page.keyboard.press("p")
    told(page, panorama="0")
    turn(page, panorama=0, zoom=8, exposure=0, curve="linear")
    drawn(page, srgb(mean), 8)


def test_a_picture_refines_in_place(page: Page, easel: Easel) -> None:
    first, second = film(2, 4), film(3, 8)
    job = easel.begin(SCENE, first)
    visit(page, easel, job, zoom=4)
    beauty = first.mean[..., :3]
    drawn(page, 255 * tone_map(beauty))
    page.locator("canvas").focus()
    page.keyboard.press("c")
    page.keyboard.press("E")
    gain = math.sqrt(2) / np.percentile(beauty.max(axis=-1), 99)
    drawn(page, srgb(beauty * gain))
    page.evaluate(
        """() => {
            window.lost = 0;
            new MutationObserver(changes => changes.forEach(each => window.lost += each.removedNodes.length))
                .observe(document.querySelector(".stage"), { childList: true });
        }"""
    )
    easel.go_on(job, second)
    drawn(page, srgb(second.mean[..., :3] * gain))
    last = film(4, 16)
    easel.finish(job, last)
    drawn(page, srgb(last.mean[..., :3] * gain))
    expect(page.locator(".badge")).to_have_text("Done")
    assert page.evaluate("window.lost") == 0, "the canvas stays"


def test_without_webgl_there_is_the_preview(page: Page, easel: Easel, picture: str) -> None:
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(f"{easel.address}/renders/{picture}")
    expect(page.locator(".note")).to_have_text("This browser draws no WebGL2, or is set not to. This is the preview.")
    expect(page.locator(".stage img")).to_be_visible()


def test_a_lost_graphics_card_comes_back(
    page: Page, said: list[str], easel: Easel, picture: str, exr: dict[str, Floats]
) -> None:
    visit(page, easel, picture, zoom=4)
    right = 255 * tone_map(stacked(exr, ""))
    drawn(page, right)
    page.evaluate(
        "window.extension = document.querySelector('canvas').getContext('webgl2').getExtension('WEBGL_lose_context')"
    )
    page.evaluate("window.extension.loseContext()")
    page.wait_for_timeout(100)
    page.evaluate("window.extension.restoreContext()")
    drawn(page, right)
    said[:] = [text for text in said if "CONTEXT_LOST" not in text]
