"""Waiting for what a page comes to."""

from __future__ import annotations

import time
from typing import Any

from playwright.sync_api import Page

PATIENCE = 15  # seconds


def until(page: Page, expression: str, arg: Any = None) -> None:
    """Until that JavaScript is true. `Page.wait_for_function` has the page evaluate text, which its policy forbids."""
    deadline = time.monotonic() + PATIENCE
    while not page.evaluate(expression, arg):
        assert time.monotonic() < deadline, f"never: {expression}"
        page.wait_for_timeout(50)
