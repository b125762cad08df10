"""Stiff rays: what the methods for L′ + σ_t L = q cost. Writes stiff_ode.md and stiff_ode.svg beside this file.

python -m studies.stiff_ode [--out folder]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from studies.stiff.figure import draw
from studies.stiff.measure import Effort, measure
from studies.stiff.page import page
from woodcock.device import find


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder of the page and its figure")
    folder = parser.parse_args().out
    numbers = measure(find(), Effort())
    draw(numbers, folder / "stiff_ode.svg")
    (folder / "stiff_ode.md").write_text(page(numbers))


if __name__ == "__main__":
    main()
