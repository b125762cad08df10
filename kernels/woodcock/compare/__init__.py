"""The shoot-out: variants of a scene, each rendered for equal time in turns, held against each other.

vary.py        which scenes                  efficiency.py   1 / (variance × time), and how far a ratio is known
agreement.py   do they show the same?        judge.py        rows, and who wins
run.py         the rendering, in turns       page.py         the page
rendered.py    a finished picture            noise.py        is the difference of two noise or bias?
"""

from __future__ import annotations

from woodcock.compare.efficiency import Ratio, Slice, of_series, ratio
from woodcock.compare.judge import Row, Verdict, row, winner
from woodcock.compare.vary import FIELDS, CompareError, Variant, kinds, parse, seeded, variants

__all__ = [
    "FIELDS",
    "CompareError",
    "Ratio",
    "Row",
    "Slice",
    "Variant",
    "Verdict",
    "kinds",
    "of_series",
    "parse",
    "ratio",
    "row",
    "seeded",
    "variants",
    "winner",
]
