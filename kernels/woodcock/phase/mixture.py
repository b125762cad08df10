"""A weighted sum of other phase functions; `compose.py` makes its device code."""

from __future__ import annotations

import numpy as np

from woodcock.layout import module
from woodcock.scene import MAX_COMPONENTS, MixturePhase
from woodcock.space import Array

FIELDS = {
    **{f"weight_{i}": "float" for i in range(MAX_COMPONENTS)},
    **{f"start_{i}": "float" for i in range(MAX_COMPONENTS + 1)},
}


def weights(phase: MixturePhase) -> Array:
    """Shares of the components; they sum to 1."""
    shares = np.array([component.weight for component in phase.components])
    shares = shares / shares.max()
    return np.asarray(shares / shares.sum())


def record(phase: MixturePhase) -> dict[str, float]:
    """A component's uniforms end where the next one's start; the last one's lie below 2, whatever the rounding."""
    shares, starts = np.zeros(MAX_COMPONENTS), np.full(MAX_COMPONENTS + 1, 2.0)
    shares[: len(phase.components)] = weights(phase)
    starts[: len(phase.components)] = np.append(0, np.cumsum(weights(phase))[:-1])
    return dict(zip(FIELDS, (*shares.tolist(), *starts.tolist()), strict=True))


def evaluate(phase: MixturePhase, cosine: Array) -> Array:
    """Float64 oracle: p(cos θ), per steradian."""
    return _sum(phase, [module("phase", part.phase.kind).evaluate(part.phase, cosine) for part in phase.components])


def mean_cosine(phase: MixturePhase) -> float:
    return float(_sum(phase, [module("phase", part.phase.kind).mean_cosine(part.phase) for part in phase.components]))


def cumulative(phase: MixturePhase, cosine: Array) -> Array:
    """Probability that a sample's cosine lies below."""
    return _sum(phase, [module("phase", part.phase.kind).cumulative(part.phase, cosine) for part in phase.components])


def _sum(phase: MixturePhase, parts: list[Array]) -> Array:
    return np.asarray(np.tensordot(weights(phase), np.array(parts), 1))
