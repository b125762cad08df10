"""Two Henyey–Greenstein lobes."""

from woodcock.phase import henyey_greenstein
from woodcock.scene import HenyeyGreensteinPhase, TwoLobePhase
from woodcock.space import Array

FIELDS = {"g1": "float", "gap1": "float", "g2": "float", "gap2": "float", "first": "float", "second": "float"}


def record(phase: TwoLobePhase) -> dict[str, float]:
    lobes = (*henyey_greenstein.lobe(phase.g1), *henyey_greenstein.lobe(phase.g2))
    return dict(zip(FIELDS, (*lobes, phase.weight, 1 - phase.weight), strict=True))


def lobes(phase: TwoLobePhase) -> list[tuple[float, HenyeyGreensteinPhase]]:
    """Each with its share."""
    return [
        (phase.weight, HenyeyGreensteinPhase(g=phase.g1)),
        (1 - phase.weight, HenyeyGreensteinPhase(g=phase.g2)),
    ]


def evaluate(phase: TwoLobePhase, cosine: Array) -> Array:
    """Float64 oracle: p(cos θ), per steradian."""
    (a, first), (b, second) = lobes(phase)
    return a * henyey_greenstein.evaluate(first, cosine) + b * henyey_greenstein.evaluate(second, cosine)


def mean_cosine(phase: TwoLobePhase) -> float:
    return phase.weight * phase.g1 + (1 - phase.weight) * phase.g2


def cumulative(phase: TwoLobePhase, cosine: Array) -> Array:
    """Probability that a sample's cosine lies below."""
    (a, first), (b, second) = lobes(phase)
    return a * henyey_greenstein.cumulative(first, cosine) + b * henyey_greenstein.cumulative(second, cosine)
