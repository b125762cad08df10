"""What a page shows, pixel by pixel."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
from numpy.typing import NDArray
from playwright.sync_api import Locator


def shown(element: Locator) -> NDArray[np.int64]:
    """(height, width, 3), 0 to 255."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shown.png"
        element.screenshot(path=path, animations="disabled")
        pixels = oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8)
    return np.asarray(pixels)[..., :3].astype(np.int64)
