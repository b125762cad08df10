"""Where media shine: by which estimator paths gather it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from woodcock.majorant.grid import Bounded, Floats, bounds, combined, mean_chord
from woodcock.scene import BlackbodyEmission, GridEmission
from woodcock.space import Array
from woodcock.volume.media import Medium

#: Per mean chord of the box.
KAPPA = 3.0
#: Times the variance that a lookup less for every step is worth.
MORE = 1.5


@dataclass(frozen=True)
class Box:
    """low, high: (3,), opposite corners, in a space to which `from_scene`, (4, 4), leads."""

    low: Array
    high: Array
    from_scene: Array

    @property
    def chord(self) -> float:
        """Its mean, a length of the scene; exact for a box that is not sheared."""
        sides = np.linalg.norm(np.linalg.inv(self.from_scene)[:3, :3], axis=0) * (self.high - self.low)
        return mean_chord(sides)


def dense_glow(media: Sequence[Medium], majorant: Array, box: Box) -> bool:
    """Do paths gather emission as well where they collide tentatively, ε / σ̄ at each, as along pieces of their flights?

    The one has a variance of about ∫ ε² / σ̄, the other of ∫ ε² / (σ̄ + κ), 1 / κ being how far flights get in a void.

    majorant: σ̄ of the cells of a box, [z][y][x], 1 / length of the scene.
    """
    tentative, along = 0.0, 0.0
    for medium in media:
        if not medium.emits:
            continue
        if medium.density is None:
            return False
        squared = _epsilon(medium, majorant, box) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            tentative += float(np.where(squared > 0, squared / majorant, 0).sum())
        along += float((squared / (majorant + KAPPA / box.chord)).sum())
    return 0 < tentative <= MORE * along


def _epsilon(medium: Medium, majorant: Array, box: Box) -> Array:
    """[z][y][x]: about the largest ε in every cell, in any unit."""
    match medium.volume.emission:
        case GridEmission(scale=scale):
            field = medium.emission
            assert field is not None
            weights = np.atleast_1d(np.array(scale, np.float32))

            def slab(first: int, stop: int) -> Floats:
                values = field.decoded(first, stop)
                return np.asarray(values * weights.max() if values.ndim == 3 else (values * weights).max(axis=-1))

            z, y, x = majorant.shape
            to_box = box.from_scene @ medium.to_scene(field)
            stored = Bounded(slab, 1.0, field.size, 0.5 if field.nearest else 1.0, to_box)
            if np.allclose(to_box, np.eye(4)) and field.size == tuple(box.high):  # and no coarser than σ̄ is
                return bounds(stored, (x, y, z))
            return combined([stored], (x, y, z), box.low, box.high)
        case BlackbodyEmission():
            return majorant  # what absorbs shines
        case _:
            return np.ones_like(majorant)
