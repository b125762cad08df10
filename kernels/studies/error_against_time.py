"""Error against run time. Writes error_against_time.md and error_against_time.svg beside this file.

python -m studies.error_against_time [--out folder]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from studies.series.figure import draw
from studies.series.measure import Effort, measure
from studies.series.page import page
from woodcock.device import find


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder of the page and its figure")
    folder = parser.parse_args().out
    numbers = measure(find(), Effort())
    draw(numbers, folder / "error_against_time.svg")
    (folder / "error_against_time.md").write_text(page(numbers))


if __name__ == "__main__":
    main()
