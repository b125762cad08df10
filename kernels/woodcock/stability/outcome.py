"""What a sweep of the stiff and the extreme found on a device."""

from __future__ import annotations

from typing import Literal, TypedDict

Unit = Literal["standard errors", "roundings"]
Verdict = Literal["passed", "failed", "not expressible"]


class Row(TypedDict):
    """One case. expected: the exact answer, got: the picture's, of the worst pixel where there is no noise, else of the
    mean; deviation: got - expected in `unit`, which is the standard error of the mean or 2^-24 of what is expected, a
    rounding of float32; limit: of |deviation|. None where there was nothing to compare.

    says: empty where passed, else what is wrong or what cannot be expressed, one sentence.
    """

    group: str
    case: str
    expected: float | None
    got: float | None
    deviation: float | None
    unit: Unit
    limit: float | None
    verdict: Verdict
    says: str
    seconds: float


class Outcome(TypedDict):
    """All cases on one device. device: its id; version: woodcock's; passed: did no case fail?"""

    device: str
    name: str
    platform: str
    driver: str
    version: str
    passed: bool
    seconds: float
    rows: list[Row]
