"""How paths find collisions and what reaches a light, where media are grids; constant ones have closed forms."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from woodcock.scene.basics import Model

# Where a flight collides


class DeltaFreeFlight(Model):
    """Delta tracking, Woodcock et al. (1965): tentative collisions at the majorant's rate, each looked up."""

    kind: Literal["delta"] = "delta"


class DecompositionFreeFlight(Model):
    """Decomposition tracking, Kutz et al. (2017): collisions below a lower bound on σ_t need no lookup."""

    kind: Literal["decomposition"] = "decomposition"


FreeFlight = Annotated[DeltaFreeFlight | DecompositionFreeFlight, Field(discriminator="kind")]

# What gets through to a light


class RatioTransmittance(Model):
    """Ratio tracking, Novák et al. (2014): every tentative collision weighs by 1 - σ_t / majorant."""

    kind: Literal["ratio"] = "ratio"


class ResidualRatioTransmittance(Model):
    """Residual ratio tracking, Novák et al. (2014): closed below a lower bound on σ_t, ratio tracking above."""

    kind: Literal["residual_ratio"] = "residual_ratio"


class RayMarchingTransmittance(Model):
    """Unbiased ray marching, Kettunen et al. (2021): a power series in optical depths of jittered combs."""

    kind: Literal["ray_marching"] = "ray_marching"


Transmittance = Annotated[
    RatioTransmittance | ResidualRatioTransmittance | RayMarchingTransmittance, Field(discriminator="kind")
]
