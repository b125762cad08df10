"""A report, and how a page shows it."""

from __future__ import annotations

import re
from typing import Any

from playwright.sync_api import Page

REPORT: dict[str, Any] = {
    "program_hash": "9f3c2a77b1e04d55",
    "kinds": {"camera": ["perspective"], "volume": ["constant"]},
    "seconds": {"read": 0.1, "build": 0.5, "upload": 0.1, "render": 3.0},
    "certificate": {
        "failed": ["majorant"],
        "not_checked": ["rounding"],
        "lines": [
            {"name": "samples", "status": "passed", "says": "Every sample was a finite radiance.", "values": {}},
            {"name": "majorant", "status": "failed", "says": "σ_t exceeded its majorant 12 times.", "values": {}},
            {"name": "rounding", "status": "not checked", "says": "No doubles here.", "values": {}},
            {"name": "build", "status": "stated", "says": "Built without flags.", "values": {}},
        ],
    },
    "devices": [{"id": "cpu0", "name": "A processor", "lanes": 8, "samples": 64, "render_seconds": 3.0}],
    "error": [
        {"seconds": 0.1 * 4**i, "device_seconds": 0.2 * 4**i, "samples": 4**i, "rmse": 0.2 / 2**i, "against": None}
        for i in range(4)
    ],
    "contract": {"kind": "samples", "asked": 64, "reached": 64, "met": True, "says": "64 of 64 samples."},
    "slope": {"slope": -0.497, "low": -0.53, "high": -0.47, "verdict": "as expected", "says": "As it should."},
    "efficiency": 1234.5,
    "mean_samples": 64.0,
    "utilisation": 0.93,
    "mean_luminance": 0.5,
    "reference": None,
    "against": None,
}


def fact(page: Page, name: str) -> str:
    """What the first table says under this name."""
    row = page.locator(".table").first.locator("> div").filter(has=page.locator("dt", has_text=re.compile(f"^{name}$")))
    return " ".join(row.locator("dd").inner_text().replace("\n", " ").split(" "))
