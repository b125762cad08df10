"""Phase functions."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from woodcock.scene.basics import Fraction, Model, NonNegative, Number, Positive, length

MAX_COMPONENTS = 8
MAX_TABLE = 4096

Asymmetry = Annotated[Number, Field(ge=-0.9999, le=1)]


class IsotropicPhase(Model):
    """p = 1 / 4π."""

    kind: Literal["isotropic"] = "isotropic"


class HenyeyGreensteinPhase(Model):
    """Henyey & Greenstein (1941)."""

    kind: Literal["henyey_greenstein"] = "henyey_greenstein"
    g: Asymmetry = Field(
        description="Mean cosine; positive scatters forward. Above 0.9999 light goes straight on, as at 1."
    )


class TwoLobePhase(Model):
    """Two Henyey–Greenstein lobes."""

    kind: Literal["two_lobe"] = "two_lobe"
    g1: Asymmetry = Field(description="Mean cosine of the first lobe.")
    g2: Asymmetry = Field(description="Mean cosine of the second lobe.")
    weight: Fraction = Field(description="Share of the first lobe.")


class RayleighPhase(Model):
    """p = 3 (1 + cos² θ) / 16π."""

    kind: Literal["rayleigh"] = "rayleigh"


class DrainePhase(Model):
    """Draine (2003): Henyey–Greenstein × (1 + α cos² θ); α = 1 is Cornette & Shanks (1992)."""

    kind: Literal["draine"] = "draine"
    g: Annotated[Number, Field(ge=-0.9999, le=0.9999)] = Field(description="Asymmetry parameter (not the mean cosine).")
    alpha: NonNegative = Field(default=1.0, description="Strength of the cos² term.")


class MieApproxPhase(Model):
    """Water droplets: Jendersie & d'Eon (2023), a mixture of a Henyey–Greenstein and a Draine lobe."""

    kind: Literal["mie_approx"] = "mie_approx"
    diameter: Annotated[Number, Field(ge=5, le=50)] = Field(description="Diameter of the droplets, micrometres.")


class TabulatedPhase(Model):
    """Any phase function of the angle, linear in cos θ between the values given; normalised by the renderer."""

    kind: Literal["tabulated"] = "tabulated"
    cosine: Annotated[tuple[Number, ...], length(2, MAX_TABLE)] = Field(
        description="cos θ, rising from -1 (backward) to 1 (forward)."
    )
    value: Annotated[tuple[NonNegative, ...], length(2, MAX_TABLE)] = Field(description="p at each, any scale.")

    @model_validator(mode="after")
    def _is_a_table(self) -> TabulatedPhase:
        if len(self.cosine) != len(self.value):
            raise ValueError(f"cosine and value must be equally long, not {len(self.cosine)} and {len(self.value)}")
        if self.cosine[0] != -1 or self.cosine[-1] != 1:
            raise ValueError("cosine must begin with -1 and end with 1")
        if any(a >= b for a, b in zip(self.cosine, self.cosine[1:], strict=False)):
            raise ValueError("cosine must rise from each entry to the next")
        if not max(self.value) > 0:
            raise ValueError("value must exceed 0 somewhere")
        return self


Lobe = Annotated[
    IsotropicPhase
    | HenyeyGreensteinPhase
    | TwoLobePhase
    | RayleighPhase
    | DrainePhase
    | MieApproxPhase
    | TabulatedPhase,
    Field(discriminator="kind"),
]


class Component(Model):
    weight: Positive = Field(description="Share of the mixture, any scale.")
    phase: Lobe = Field(description="Phase function of this share.")


class MixturePhase(Model):
    """A weighted sum of other phase functions."""

    kind: Literal["mixture"] = "mixture"
    components: Annotated[tuple[Component, ...], length(1, MAX_COMPONENTS)] = Field(description="What is summed.")


Phase = Annotated[
    IsotropicPhase
    | HenyeyGreensteinPhase
    | TwoLobePhase
    | RayleighPhase
    | DrainePhase
    | MieApproxPhase
    | TabulatedPhase
    | MixturePhase,
    Field(discriminator="kind"),
]
