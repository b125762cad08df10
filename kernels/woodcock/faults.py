"""What a render found amiss in its own work, as its kernel counts it (core/audit.h)."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.space import Array

#: Planes of a kernel's audit: six of them counts or sums, the last the largest excess.
PLANES = 7


@dataclass(frozen=True)
class Faults:
    """nan, infinite, negative: samples that were that and count as zero; unfinished: likewise, of paths given up.

    violations: tentative collisions where σ_t exceeded its majorant; touched: the sum of their paths' throughputs, of
    which every sample begins with 1; repaired: violations in samples that were thrown away and rendered again under a
    higher majorant.
    """

    nan: int = 0
    infinite: int = 0
    negative: int = 0
    unfinished: int = 0
    violations: int = 0
    touched: float = 0.0
    repaired: int = 0

    @property
    def rejected(self) -> int:
        """Samples that count as zero because they were no radiance."""
        return self.nan + self.infinite + self.negative + self.unfinished

    def __add__(self, other: Faults) -> Faults:
        return Faults(*(mine + its for mine, its in zip(astuple(self), astuple(other), strict=True)))

    def array(self) -> Array:
        return np.array(astuple(self), np.float64)

    @classmethod
    def of(cls, numbers: Any) -> Faults:
        """Of `array`'s numbers. Raises TypeError or ValueError for others."""
        nan, infinite, negative, unfinished, violations, touched, repaired = (float(number) for number in numbers)
        return cls(int(nan), int(infinite), int(negative), int(unfinished), int(violations), touched, int(repaired))


def audited(planes: NDArray[np.uint32]) -> tuple[Faults, float]:
    """The faults of a launch, and the largest σ_t / majorant where it was above 1, else 0.

    planes: (PLANES, pixels), as the kernel leaves them.
    """
    nan, infinite, negative, unfinished, violations = planes[:5].sum(axis=1, dtype=np.uint64).tolist()
    touched, excess = planes[5:].view(np.float32)
    found = Faults(nan, infinite, negative, unfinished, violations, float(touched.sum(dtype=np.float64)))
    return found, float(excess.max())
