"""The program with everything switched on. Its text is the same for nearly all scenes: kinds are numbers that are
uploaded, and what a scene does not use lies dormant. It shows what leaving out gains, and renders a scene whose own
program is still being built.
"""

from __future__ import annotations

from woodcock.generic.gain import Gain as Gain
from woodcock.generic.gain import measure_gain as measure_gain
from woodcock.generic.whole import generic_layout as generic_layout
from woodcock.generic.whole import is_generic as is_generic
from woodcock.generic.whole import is_widened as is_widened
from woodcock.generic.whole import widen as widen
