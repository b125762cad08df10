"""Pages: nothing fetched, everything escaped, charts and false colour that say what the numbers are."""

from __future__ import annotations

import base64
import hashlib
import html
import io
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from tests.kernels.sample_pages import HOSTILE, film, reference, report, sample_comparison, sample_report, scene

from woodcock.image import tone_map, white_of
from woodcock.pages import policy, report_page, words
from woodcock.pages.axis import Axis
from woodcock.pages.chart import Chart, Curve, Dot, Fit, draw, spread
from woodcock.pages.flip_book import frames
from woodcock.pages.pictures import LARGEST, Scale, both_ways, data_uri, decades, shrunk
from woodcock.scene import parse


class Reader(HTMLParser):
    """Every tag, with its attributes, and the text of the page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.inside: list[str] = []
        self.raw: dict[str, str] = {}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self.text += " "
        self.inside.append(tag)

    def handle_endtag(self, tag: str) -> None:
        while self.inside and self.inside.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        if self.inside and self.inside[-1] in ("style", "script"):
            self.raw[self.inside[-1]] = self.raw.get(self.inside[-1], "") + data
        else:
            self.text += data


@pytest.fixture(scope="module")
def the_report() -> str:
    return sample_report()


@pytest.fixture(scope="module")
def the_comparison() -> str:
    return sample_comparison()


@pytest.fixture(params=["report", "comparison"])
def either(request: pytest.FixtureRequest) -> str:
    return str(request.getfixturevalue(f"the_{request.param}"))


# The document


def test_nothing_is_fetched(either: str) -> None:
    read = Reader(either)
    for tag, attributes in read.tags:
        for name in ("src", "href", "action", "poster", "data", "srcset"):
            value = attributes.get(name)
            assert value is None or value.startswith("data:"), (tag, name, value)
        assert "style" not in attributes, tag  # the policy would not let it
        assert not any(name.startswith("on") for name in attributes), tag
        assert tag not in ("link", "iframe", "object", "base") or attributes.get("href") == "data:,"
    assert "url(" not in read.raw["style"]
    assert "@import" not in read.raw["style"]


def test_the_policy_lets_its_own_style_and_script_pass_alone(either: str) -> None:
    read = Reader(either)
    (said,) = [a["content"] for tag, a in read.tags if tag == "meta" and a.get("http-equiv")]
    assert said == policy()
    assert "default-src 'none'" in policy()
    assert "unsafe" not in policy()
    for tag in ("style", "script"):
        digest = base64.b64encode(hashlib.sha256(read.raw[tag].encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy()


def test_strings_are_escaped(either: str) -> None:
    read = Reader(either)
    assert [tag for tag, _ in read.tags].count("script") == 1
    assert not any(attributes.get("src") == "x" for _, attributes in read.tags)
    assert HOSTILE in read.text


def test_ids_are_unique_and_pictures_have_texts(either: str) -> None:
    read = Reader(either)
    ids = [attributes["id"] for _, attributes in read.tags if "id" in attributes]
    assert len(set(ids)) == len(ids)
    named = {attributes["aria-labelledby"] for _, attributes in read.tags if "aria-labelledby" in attributes}
    assert named <= set(ids)
    for tag, attributes in read.tags:
        assert tag != "img" or attributes["alt"]
        assert tag != "svg" or attributes.get("aria-label") or attributes.get("aria-hidden") == "true"


def test_the_report_says_what_it_holds(the_report: str) -> None:
    text = " ".join(Reader(the_report).text.split())
    for said in (
        "48 × 32 pixels, 48 samples per pixel on average, 64 at most, 6.4 s of rendering",
        "✗ Contract missed The root mean square error is 7.2 % of the mean luminance; 2 % was asked for.",
        "Take care with this picture 3 of 98304 samples",
        "The error falls as the power −0.49 of time",
        "True MSE",
        "HDR-FLIP 0.043",
        "render 6.4 s 72 %",
        "busy for 94.3 % of the rendering",
        "2.03 × as fast as with everything in it (95 % interval 1.98 to 2.09)",
        "Left out: 2 parts",
        "rounding not checked",
        "woodcock render scene.json -o picture.exr --device cpu0",
        "0 to 63",
    ):
        assert said in text, said


def test_the_scene_can_be_taken_from_the_page(either: str) -> None:
    (text,) = re.findall(r"<summary>The scene</summary><pre[^>]*>(.*?)</pre>", either, re.DOTALL)
    assert parse(html.unescape(text)) == scene()


def test_a_report_with_nothing_in_it(the_report: str) -> None:
    """What may be missing: a reference, a slope, a gain, a second sample, and the keys of later versions."""
    picture = film()
    bare = report(picture, known=False)
    for key in ("contract", "slope", "gain", "program", "utilisation", "rel_mse", "efficiency"):
        bare[key] = None
    text = Reader(report_page(bare, scene(), picture, None, "bare")).text
    assert "Contract" not in text
    assert "Left out" not in text
    assert "True MSE" not in text
    for key in ("contract", "slope", "gain", "program", "utilisation", "rel_mse", "efficiency", "against", "reference"):
        del bare[key]
    assert "bare" in Reader(report_page(bare, scene(), picture, None, "bare")).text
    one = replace(picture, count=np.ones_like(picture.count), ranges=((0, 1),))
    bare |= {"error": [], "rmse": None, "relative_rmse": None, "samples": 1}
    assert "is not known: that takes two samples" in Reader(report_page(bare, scene(), one, None, "one")).text


def test_a_picture_without_noise_has_a_bound() -> None:
    picture = film()
    exact = replace(picture, bound=np.full(picture.mean.shape, 1e-4), m2=np.zeros(picture.m2.shape))
    said = report(exact, known=False) | {"deterministic": True, "error": []}
    text = Reader(report_page(said, scene(), exact, None, "exact")).text
    assert "It has no noise: a pixel is off by at most" in text
    assert "Error bound" in text
    assert "Error against time" not in text


def test_the_comparison_says_who_wins(the_comparison: str) -> None:
    text = " ".join(Reader(the_comparison).text.split())
    assert "times as efficient as" in text
    assert "another picture" in text
    assert "default" in text
    assert f"the same program as “delta, ratio, grid”: “{HOSTILE}”, “another”." in text


# Numbers as text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (0.0123456, "0.0123"),
        (1.5, "1.5"),
        (2.0, "2"),
        (99.96, "100"),
        (1234.5, "1\u2009234"),
        (123456, "1.2 × 10⁵"),
        (2.5e-7, "2.5 × 10⁻⁷"),
        (-0.25, "−0.25"),
        (-3e-9, "−3.0 × 10⁻⁹"),
        (math.nan, "not known"),
        (math.inf, "∞"),
    ],
)
def test_numbers(value: float, text: str) -> None:
    assert words.number(value) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0, "0 s"), (0.0042, "4.2 ms"), (5.25, "5.2 s"), (42.4, "42 s"), (61, "1 min 01 s"), (7260, "2 h 01 min")],
)
def test_durations(seconds: float, text: str) -> None:
    assert words.duration(seconds) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.001, "0.001"), (1e-4, "10⁻⁴"), (5e-7, "5 × 10⁻⁷"), (20, "20"), (1e6, "10⁶"), (-0.05, "−0.05")],
)
def test_ticks_are_short(value: float, text: str) -> None:
    assert words.tick(value) == text


# Charts


@pytest.mark.parametrize(("low", "high"), [(1, 1), (0.9, 1.1), (0.1, 30), (1e-6, 1e6), (3e-9, 1e-8), (7, 7.001)])
def test_axes_have_a_few_round_ticks(low: float, high: float) -> None:
    axis = Axis.over([low, high], 0, 640)
    ticks = axis.ticks(64)
    assert 2 <= len(ticks) <= 10
    assert axis.low < low <= high < axis.high
    assert all(axis.low <= tick <= axis.high for tick in ticks)
    assert all(round(tick / 10 ** math.floor(math.log10(tick) + 1e-9), 9) in (1, 2, 3, 5, 7) for tick in ticks)
    assert min(np.diff([axis.at(tick) for tick in ticks])) > 40
    assert axis.at(math.sqrt(axis.low * axis.high)) == pytest.approx(320)


def test_names_are_moved_apart_and_kept_in_order() -> None:
    places = spread([10, 11, 12, 100, 101, 300], 16, 0, 300)
    assert np.all(np.diff(places) >= 16 - 1e-9)
    assert places[5] == pytest.approx(300)
    assert places[3] == pytest.approx(92.5)
    assert places[0] >= 0
    crowded = spread([0.0] * 8, 10, 0, 70)
    assert crowded == pytest.approx([10.0 * k for k in range(8)])
    assert spread([50.0], 10, 0, 70) == [50.0]


def coordinates(path: str) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in re.findall(r"(-?[\d.]+) (-?[\d.]+)", path)]


def test_the_chart_draws_what_is_measured() -> None:
    """A series of slope -0.4: the guide is steeper than the fit, and the fan ends in the last dot."""
    dots = [Dot(t, 0.5 * t**-0.4, f"dot {t}") for t in (0.1, 1.0, 10.0, 100.0)]
    curve = Curve("estimated", dots, fit=Fit(-0.4, -0.5, -0.3))
    figure = draw(Chart([curve], "time", "error", "says", goal=0.01))
    assert figure is not None
    (fit,) = [each.get("d", "") for each in figure.iter("path") if each.get("class") == "fit"]
    (guide,) = [each.get("d", "") for each in figure.iter("path") if each.get("class") == "guide"]
    (band,) = [each.get("d", "") for each in figure.iter("path") if each.get("class") == "band"]
    (x1, y1), (x2, y2) = coordinates(fit)
    (u1, v1), (u2, v2) = coordinates(guide)
    # Both axes are logarithmic: slopes are as the powers
    assert (v2 - v1) / (u2 - u1) / ((y2 - y1) / (x2 - x1)) == pytest.approx(0.5 / 0.4, rel=0.01)
    assert coordinates(band)[0] == pytest.approx((x2, y2), abs=0.11)
    (goal,) = [each for each in figure.iter("line") if each.get("class") == "goal"]
    assert float(goal.get("y1", 0)) > y2  # the error has not come down to it
    titles = [each.text for each in figure.iter("title")]
    assert titles == [dot.says for dot in dots]
    assert draw(Chart([Curve("none", [])], "time", "error", "says")) is None


def test_every_curve_has_a_look_of_its_own(the_comparison: str) -> None:
    looks = {
        (attributes["class"], re.sub(r"-?\d+(\.\d+)?", "#", attributes["d"] or ""))
        for tag, attributes in Reader(the_comparison).tags
        if tag == "path" and str(attributes.get("class")).startswith("marker")
    }
    assert len(looks) >= 12


# Pictures


def decoded(uri: str) -> np.ndarray[Any, Any]:
    png = base64.b64decode(uri.removeprefix("data:image/png;base64,"))
    return np.rint(255 * imread(io.BytesIO(png), format="png"))


def test_a_picture_comes_back_from_its_uri() -> None:
    pixels = np.random.default_rng(3).integers(0, 256, (5, 7, 3))
    assert (decoded(data_uri(pixels / 255)) == pixels).all()


def test_pictures_are_shrunk_by_means() -> None:
    values = np.random.default_rng(4).random((512, 4096, 1)).astype(np.float32)
    small = shrunk(values)
    assert small.shape == (LARGEST // 8, LARGEST, 1)
    assert small[..., 0] == pytest.approx(
        values[..., 0].reshape(LARGEST // 8, 4, LARGEST, 4).mean(axis=(1, 3)), rel=1e-4
    )
    assert (shrunk(values[:9, :9]) == values[:9, :9]).all()


def test_views_of_a_film() -> None:
    picture = film()
    found = frames(picture, reference())
    assert [frame.name for frame in found] == ["Result", "Standard error", "Samples", "Reference", "Error"]
    assert [frame.legend is not None for frame in found] == [False, True, True, False, True]
    # One exposure: where the film is the reference the pictures are the same
    same = replace(picture, mean=reference().mean)
    shown = frames(same, reference())
    assert shown[0].uri == shown[3].uri
    assert "0 everywhere" in shown[4].says
    white = white_of(picture.mean)
    assert decoded(found[3].uri) == pytest.approx(255 * tone_map(reference().mean, white), abs=1)
    even = replace(picture, count=np.full_like(picture.count, 64))
    assert [frame.name for frame in frames(even, None)] == ["Result", "Standard error"]


def test_the_error_is_red_where_the_picture_is_too_bright() -> None:
    picture = film()
    offset = np.zeros(picture.mean.shape)
    offset[:, :24], offset[:, 24:] = 0.1, -0.1
    error = decoded(frames(replace(picture, mean=reference().mean + offset), reference())[4].uri).astype(int)
    assert (error[:, :24, 0] > error[:, :24, 2] + 50).all()
    assert (error[:, 24:, 2] > error[:, 24:, 0] + 20).all()


def test_scales_map_their_ends_to_the_palettes_ends() -> None:
    scale = Scale(0.01, 1.0, "radiance", logarithmic=True)
    colours = scale.colours(np.array([[0.0, 0.01, 0.1, 1.0, 9.0, math.nan]]))[0]
    assert colours[0] == pytest.approx(colours[1])
    assert colours[3] == pytest.approx(colours[4])
    assert 255 * colours[1] == pytest.approx([68, 1, 84], abs=1)  # viridis
    assert 255 * colours[2] == pytest.approx([33, 145, 140], abs=1)
    assert 255 * colours[3] == pytest.approx([253, 231, 37], abs=1)
    assert colours[5] == pytest.approx(colours[0])
    around = both_ways(np.array([-3.0, 1.0]), "radiance")
    assert around is not None
    assert around.low == -around.high
    assert 255 * around.colours(np.zeros((1, 1)))[0, 0] == pytest.approx([247, 246, 246], abs=1)
    assert decades(np.zeros((3, 3)), "radiance") is None
    assert both_ways(np.zeros((3, 3)), "radiance") is None
    wide = decades(np.geomspace(1e-12, 1, 1000), "radiance")
    assert wide is not None
    assert wide.high / wide.low == pytest.approx(1e4)
