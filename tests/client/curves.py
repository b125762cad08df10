"""The viewer's tone curves, by their published formulas: linear radiance to display values, 0 to 255."""

from __future__ import annotations

from typing import Any

import numpy as np

from woodcock.image import tone_map

from .looking import Floats


def srgb(linear: Floats) -> Floats:
    x = np.clip(linear, 0, 1)
    return 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def soft(x: Floats) -> Floats:
    return 255 * tone_map(x, 1.0)  # that of previews


def filmic(x: Floats) -> Floats:
    def hable(x: Floats | float) -> Any:
        a, b, c, d, e, f = 0.15, 0.5, 0.1, 0.2, 0.02, 0.3
        return ((x * (a * x + c * b) + d * e) / (x * (a * x + b) + d * f)) - e / f

    return srgb(hable(2 * x) / hable(11.2))


def agx(x: Floats) -> Floats:
    inset = np.array([[0.842479062253094, 0.0784335999999992, 0.0792237451477643],
                      [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
                      [0.0423756549057051, 0.0784336, 0.879142973793104]])  # fmt: skip
    stops = np.clip(np.log2(np.maximum(x @ inset.T, 1e-10)), -12.47393, 4.026069)
    t = (stops + 12.47393) / (4.026069 + 12.47393)
    sigmoid = np.polyval([15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232], t)
    return 255 * np.clip(sigmoid @ np.linalg.inv(inset).T, 0, 1)


CURVES = {"soft": soft, "linear": srgb, "filmic": filmic, "agx": agx}
