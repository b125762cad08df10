"""Pages that the program writes: one HTML text each, which fetches nothing and works from disk.

document.py   a template, its style and script, its policy       templates/    those
report.py     the page of a render; metrics.py, its numbers      words.py      numbers and times as text
chart.py      error against time; axis.py, svg.py, figure.py     flip_book.py  pictures.py, legend.py: views of a film
"""

from __future__ import annotations

from woodcock.pages.document import policy
from woodcock.pages.report import report_page

__all__ = ["policy", "report_page"]
