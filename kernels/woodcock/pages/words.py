"""Numbers, shares and times as text, as the gallery writes them."""

from __future__ import annotations

import math

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
THIN_SPACE = "\u2009"


def count(n: float) -> str:
    """Digits grouped by thin spaces, so that 1 024 means the same everywhere."""
    return f"{round(n):,}".replace(",", THIN_SPACE)


def number(x: float, digits: int = 3) -> str:
    """Significant digits, without an exponent where the number is of everyday size."""
    if not math.isfinite(x):
        return "not known" if math.isnan(x) else "∞" if x > 0 else "−∞"
    if x == 0:
        return "0"
    if not 1e-4 <= abs(x) < 1e5:
        mantissa, _, exponent = f"{x:.1e}".partition("e")
        return f"{mantissa} × 10{str(int(exponent)).translate(SUPERSCRIPTS)}".replace("-", "−")
    return _trimmed(x, digits).replace("-", "−")


def _trimmed(x: float, digits: int) -> str:
    places = digits - 1 - math.floor(math.log10(abs(x)))
    if places <= 0:
        return count(x)
    text = f"{x:.{places}f}"
    return text.rstrip("0").rstrip(".")


def percent(x: float) -> str:
    return f"{number(100 * x)} %"


def tick(x: float) -> str:
    """A round number, as short as it can be."""
    if x == 0 or 1e-3 <= abs(x) < 1e4:
        return f"{x:g}".replace("-", "−")
    mantissa, _, exponent = f"{x:e}".partition("e")
    power = f"10{str(int(exponent)).translate(SUPERSCRIPTS)}"
    factor = f"{float(mantissa):g}".replace("-", "−")
    return power if factor == "1" else f"{factor} × {power}"


def duration(seconds: float) -> str:
    if seconds == 0:
        return "0 s"
    if seconds < 0.1:
        return f"{number(1000 * seconds)} ms"
    if seconds < 59.5:
        return f"{seconds:.1f} s" if seconds < 10 else f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02} s"
    return f"{minutes // 60} h {minutes % 60:02} min"


def samples(n: float) -> str:
    text = count(n) if n == int(n) else number(n)
    return f"{text} sample{'' if n == 1 else 's'}"
