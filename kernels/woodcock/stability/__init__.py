"""Does a device get stiff and extreme scenes right? Every case is rendered and held against its exact answer; nothing
may be NaN, infinite, negative, hang, or be silently wrong.

    cases/      what is rendered, a file a subject      exact.py   what comes out, in float64, without the renderer
    case.py     pictures against exact answers          scenes.py  what cases' scenes are made of
    children.py cases in child processes: a case that hangs or crashes is a row that failed
"""

from woodcock.stability.children import check, sweep
from woodcock.stability.outcome import Outcome, Row

__all__ = ["Outcome", "Row", "check", "sweep"]
