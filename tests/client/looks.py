"""A page as those see it who cannot see or point, and a picture of it.

`screenshots/` at the repository's root has one of each page: to be looked at.
"""

from __future__ import annotations

from pathlib import Path

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page

SCREENSHOTS = Path(__file__).parents[2] / "screenshots"


def check(page: Page, name: str) -> None:
    """No violation of WCAG 2.2 AA or of best practice, nothing wider than the window; and a screenshot."""
    narrow = page.viewport_size is not None and page.viewport_size["width"] < 600
    SCREENSHOTS.mkdir(exist_ok=True)
    page.screenshot(path=SCREENSHOTS / f"{name}-{'narrow' if narrow else 'wide'}.png")
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0, "it scrolls sideways"
    violations = Axe().run(page).response["violations"]
    assert [(each["id"], each["help"], [node["html"][:200] for node in each["nodes"]]) for each in violations] == []
