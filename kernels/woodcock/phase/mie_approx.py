"""Jendersie & d'Eon, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", SIGGRAPH 2023 Talks."""

from math import exp

from woodcock.phase import draine, henyey_greenstein
from woodcock.scene import DrainePhase, HenyeyGreensteinPhase, MieApproxPhase
from woodcock.space import Array

FIELDS = {
    "peak_g": "float",
    "peak_gap": "float",
    "peak": "float",
    "draine": "float",
    **draine.FIELDS,
}


def lobes(phase: MieApproxPhase) -> tuple[HenyeyGreensteinPhase, DrainePhase, float]:
    """The two lobes and the Draine lobe's share, by their fits for a diameter d from 5 to 50 µm."""
    d = phase.diameter
    peak = HenyeyGreensteinPhase(g=exp(-0.0990567 / (d - 1.67154)))
    rest = DrainePhase(g=exp(-2.20679 / (d + 3.91029) - 0.428934), alpha=exp(3.62489 - 8.29288 / (d + 5.52825)))
    return peak, rest, exp(-0.599085 / (d - 0.641583) - 0.665888)


def record(phase: MieApproxPhase) -> dict[str, float]:
    peak, rest, share = lobes(phase)
    g, gap = henyey_greenstein.lobe(peak.g)
    return {"peak_g": g, "peak_gap": gap, "peak": 1 - share, "draine": share, **draine.record(rest)}


def evaluate(phase: MieApproxPhase, cosine: Array) -> Array:
    """Float64 oracle: p(cos θ), per steradian."""
    peak, rest, share = lobes(phase)
    return (1 - share) * henyey_greenstein.evaluate(peak, cosine) + share * draine.evaluate(rest, cosine)


def mean_cosine(phase: MieApproxPhase) -> float:
    peak, rest, share = lobes(phase)
    return (1 - share) * peak.g + share * draine.mean_cosine(rest)


def cumulative(phase: MieApproxPhase, cosine: Array) -> Array:
    """Probability that a sample's cosine lies below."""
    peak, rest, share = lobes(phase)
    return (1 - share) * henyey_greenstein.cumulative(peak, cosine) + share * draine.cumulative(rest, cosine)
