"""A viewer's page: goes to views of a picture, and waits for what it then draws and says."""

from __future__ import annotations

import math
import time
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Page, expect

from woodcock.film import Film

from .easel import Easel
from .pixels import shown

Floats = NDArray[np.float64]
WIDTH, HEIGHT = 48, 32
PATIENCE = 15  # seconds
NAMES = (
    "R",
    "G",
    "B",
    "order.0.R",
    "order.0.G",
    "order.0.B",
    "order.rest.R",
    "order.rest.G",
    "order.rest.B",
    "depth.Z",
)


def film(seed: int, samples: int = 16) -> Film:
    """Radiance over twelve stops, one channel brighter than the other; depth from 1 to 5."""
    rng = np.random.default_rng(seed)
    mean = 2 ** rng.uniform(-9, 3, (HEIGHT, WIDTH, len(NAMES))) * (1 + np.arange(len(NAMES)) % 3)
    mean[..., -1] = rng.uniform(1, 5, (HEIGHT, WIDTH))
    m2 = 10 ** rng.uniform(-6, 1, mean.shape)
    return Film(np.full((HEIGHT, WIDTH), samples, np.uint32), mean, m2, NAMES, ((0, samples),))


def visit(page: Page, easel: Easel, job: str, **view: Any) -> None:
    """Loads the page."""
    page.goto(f"{easel.address}/renders/{job}?{urlencode(view)}")
    expect(page.get_by_label("Layer")).to_be_visible()


def turn(page: Page, **view: Any) -> None:
    """Goes to another view of the same picture, as a link would."""
    page.evaluate(
        """query => {
            history.pushState(null, "", `${location.pathname}?${query}`);
            dispatchEvent(new Event("woodcock-address"));
        }""",
        urlencode(view),
    )


def view_of(page: Page) -> dict[str, str]:
    return dict(parse_qsl(urlsplit(page.url).query))


def told(page: Page, **view: str | None) -> None:
    """The address comes to tell so much."""
    end = time.monotonic() + PATIENCE
    while any(view_of(page).get(name) != value for name, value in view.items()):
        assert time.monotonic() < end, page.url
        page.wait_for_timeout(30)


def corner(page: Page, zoom: float, width: int = WIDTH, height: int = HEIGHT) -> tuple[int, int]:
    """Where on the canvas a centred picture begins."""
    box = page.locator("canvas").bounding_box()
    assert box
    return math.floor((round(box["width"]) - width * zoom) / 2), math.floor((round(box["height"]) - height * zoom) / 2)


def point_at(page: Page, x: float, y: float, zoom: float) -> tuple[float, float]:
    """The page's point over a pixel's middle."""
    box = page.locator("canvas").bounding_box()
    assert box
    left, top = corner(page, zoom)
    return box["x"] + left + (x + 0.5) * zoom, box["y"] + top + (y + 0.5) * zoom


def drawn(page: Page, right: Floats, zoom: float = 4, tolerance: float = 2) -> None:
    """The middle of each pixel of a centred picture comes to be (height, width, 3) of 255."""
    height, width = right.shape[:2]
    step = max(1, round(zoom))
    end = time.monotonic() + PATIENCE
    while True:
        left, top = corner(page, zoom, round(width * max(1, 1 / zoom)), round(height * max(1, 1 / zoom)))
        seen = shown(page.locator("canvas"))[top + step // 2 :, left + step // 2 :][::step, ::step][:height, :width]
        off = np.abs(seen - right)
        if off.max() <= tolerance:
            return
        assert time.monotonic() < end, f"off by {off.max()} at {np.unravel_index(off.argmax(), off.shape)}"
        page.wait_for_timeout(50)
