"""Scenes of phase functions that Mitsuba has no words for, but can take tables of."""

from __future__ import annotations

from tests.references.case import SKY, Case, ball, box, constant, perspective, pinhole
from tests.references.mitsuba_side import draine, mie

BEHIND = (-2.4, -0.9, 3.4)  # towards the brightest of the sky

PHASES = [
    Case(
        "dust",
        {
            "camera": perspective(),
            "volumes": [
                box(-1, 1, sigma_t=1.5, albedo=[0.95, 0.9, 0.8], phase={"kind": "draine", "g": 0.6, "alpha": 1})
            ],
            "lights": [constant(0.1), {"kind": "directional", "direction": [0.3, -1, 0.6], "irradiance": 3}],
        },
        pinhole(),
        lambda m: {
            "body": m.within(m.box([-1] * 3, [1] * 3), m.medium(1.5, [0.95, 0.9, 0.8], draine(0.6, 1))),
            "sky": m.constant(0.1),
            "light": m.directional([0.3, -1, 0.6], 3),
        },
    ),
    Case(
        "haze",
        {
            "camera": perspective(BEHIND),
            "volumes": [
                ball([0, 0, 0], 1.2, sigma_t=2, albedo=[0.99, 0.95, 0.9], phase={"kind": "mie_approx", "diameter": 5})
            ],
            "lights": [SKY],
        },
        pinhole(BEHIND),
        lambda m: {
            "body": m.within(m.sphere([0, 0, 0], 1.2), m.medium(2, [0.99, 0.95, 0.9], mie(5))),
            "sky": m.sky(),
        },
    ),
]
