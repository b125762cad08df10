"""Scenes of media: their shapes, phase functions, grids, colours; cameras; lights that are no surface."""

from __future__ import annotations

from tests.references.case import (
    CEILING,
    COSINES,
    FRONT,
    PLACED,
    SIZE,
    SKY,
    TINTED_TABLE,
    Case,
    ball,
    box,
    constant,
    density,
    lobe,
    perspective,
    pinhole,
    rectangle,
)
from tests.references.mitsuba_side import ISOTROPIC, RAYLEIGH, Described, blend, hg, tabulated

TABLE = {"kind": "tabulated", "cosine": COSINES, "value": TINTED_TABLE}
MIXTURE = {
    "kind": "mixture",
    "components": [
        {"weight": 1, "phase": {"kind": "isotropic"}},
        {"weight": 2, "phase": lobe(0.8)},
        {"weight": 1, "phase": {"kind": "rayleigh"}},
    ],
}


def mixture() -> Described:
    return blend(0.25, ISOTROPIC, blend(2 / 3, hg(0.8), RAYLEIGH))


MEDIA = [
    Case(
        "cube",
        {
            "camera": perspective(),
            "volumes": [box(-1, 1, sigma_t=1.5, albedo=[0.9, 0.7, 0.5])],
            "lights": [
                constant(0.4),
                {"kind": "directional", "direction": [-0.5, -1, 0.6], "irradiance": [2, 2, 3]},
            ],
        },
        pinhole(),
        lambda m: {
            "body": m.within(m.box([-1] * 3, [1] * 3), m.medium(1.5, [0.9, 0.7, 0.5], ISOTROPIC)),
            "sky": m.constant(0.4),
            "light": m.directional([-0.5, -1, 0.6], [2, 2, 3]),
        },
    ),
    Case(
        "lens",
        {
            "camera": {
                "kind": "thin_lens",
                "origin": list(FRONT),
                "target": [0, 0, 0],
                "fov": 40,
                "aperture_radius": 0.3,
                "focus_distance": 3.6,
            },
            "volumes": [ball([-0.4, 0.2, 0], 1, sigma_t=3, albedo=0.95, phase=lobe(0.7))],
            "surfaces": [rectangle([[0.5, 0, 0, 1], [0, 0.5, 0, 0], [0, 0, -0.5, 1.5], [0, 0, 0, 1]], kind="diffuse")],
            "lights": [{"kind": "point", "position": [1.5, 2, -2.5], "intensity": 12}, constant(0.2)],
        },
        lambda m: m.camera("thinlens", FRONT, (0, 0, 0), SIZE, fov=40, aperture_radius=0.3, focus_distance=3.6),
        lambda m: {
            "body": m.within(m.sphere([-0.4, 0.2, 0], 1), m.medium(3, 0.95, hg(0.7))),
            "card": {
                **m.rectangle([[0.5, 0, 0, 1], [0, 0.5, 0, 0], [0, 0, -0.5, 1.5], [0, 0, 0, 1]]),
                "bsdf": m.diffuse(0.5),
            },
            "light": m.point([1.5, 2, -2.5], 12),
            "sky": m.constant(0.2),
        },
    ),
    Case(
        "body",
        {
            "camera": {"kind": "orthographic", "origin": [2, 1, -3], "target": [0, 0.1, 0], "height": 2.6},
            "volumes": [
                {
                    "kind": "constant",
                    "shape": {"kind": "mesh", "file": "body.ply"},
                    "sigma_t": 4,
                    "albedo": 0.9,
                    "phase": lobe(-0.4),
                }
            ],
            "lights": [SKY],
        },
        lambda m: m.camera("orthographic", [2, 1, -3], [0, 0.1, 0], SIZE, height=2.6),
        lambda m: {"body": m.within(m.mesh(), m.medium(4, 0.9, hg(-0.4))), "sky": m.sky()},
    ),
    Case(
        "cloud",
        {
            "camera": perspective(),
            "volumes": [density(scale=5, albedo=0.95, phase={"kind": "rayleigh"})],
            "lights": [constant(0.3), {"kind": "directional", "direction": [1, -0.6, 0.3], "irradiance": 4}],
        },
        pinhole(),
        lambda m: {
            "body": m.within(m.mapped_box(PLACED), m.grid_medium(PLACED, 5, m.rgb(0.95), RAYLEIGH)),
            "sky": m.constant(0.3),
            "light": m.directional([1, -0.6, 0.3], 4),
        },
    ),
    Case(
        "marble",
        {
            "camera": perspective(),
            "volumes": [
                density(
                    scale=6,
                    albedo=[1, 0.9, 0.8],
                    albedo_grid={"file": "colours.npy"},
                    phase={"kind": "two_lobe", "g1": 0.8, "g2": -0.3, "weight": 0.6},
                )
            ],
            "lights": [
                constant(0.3),
                {
                    "kind": "spot",
                    "position": [0.5, 3, -2],
                    "target": [0, 0, 0],
                    "intensity": [30, 25, 20],
                    "cutoff": 15,
                    "beam": 14.99,
                },
            ],
        },
        pinhole(),
        lambda m: {
            "body": m.within(
                m.mapped_box(PLACED),
                m.grid_medium(PLACED, 6, m.colours(PLACED, [1, 0.9, 0.8]), blend(0.6, hg(0.8), hg(-0.3))),
            ),
            "sky": m.constant(0.3),
            "light": m.spot([0.5, 3, -2], [0, 0, 0], [30, 25, 20], 14.99, 15),
        },
    ),
    Case(
        "tinted",
        {
            "camera": perspective(),
            "volumes": [box(-1, 1, sigma_t=[0.5, 1.5, 4], albedo=[0.95, 0.9, 0.8], phase=TABLE)],
            "lights": [constant(0.5), {"kind": "directional", "direction": [0.3, -1, 0.6], "irradiance": 3}],
        },
        pinhole(),
        lambda m: {
            "body": m.within(
                m.box([-1] * 3, [1] * 3), m.medium([0.5, 1.5, 4], [0.95, 0.9, 0.8], tabulated(TINTED_TABLE))
            ),
            "sky": m.constant(0.5),
            "light": m.directional([0.3, -1, 0.6], 3),
        },
        integrator="volpathmis",
    ),
    Case(
        "pair",
        {
            "camera": perspective(FRONT),
            "volumes": [
                box(-1.3, -0.1, sigma_t=3, albedo=[0.95, 0.8, 0.6], phase=TABLE),
                ball([0.8, -0.2, 0.2], 0.7, sigma_t=6, albedo=[0.5, 0.9, 0.99], phase=MIXTURE),
            ],
            "surfaces": [rectangle(CEILING, kind="emissive", radiance=[4, 4, 3])],
            "lights": [constant(0.1)],
        },
        pinhole(FRONT),
        lambda m: {
            "cube": m.within(m.box([-1.3] * 3, [-0.1] * 3), m.medium(3, [0.95, 0.8, 0.6], tabulated(TINTED_TABLE))),
            "ball": m.within(m.sphere([0.8, -0.2, 0.2], 0.7), m.medium(6, [0.5, 0.9, 0.99], mixture())),
            "lamp": {**m.rectangle(CEILING), **m.emissive([4, 4, 3])},
            "sky": m.constant(0.1),
        },
    ),
    Case(
        "shade",
        {
            "camera": perspective(),
            "volumes": [density(scale=[0.5, 1, 3], albedo=0)],
            "lights": [SKY],
        },
        pinhole(),
        lambda m: {
            "body": m.within(m.mapped_box(PLACED), m.grid_medium(PLACED, [0.5, 1, 3], m.rgb(0), ISOTROPIC)),
            "sky": m.sky(),
        },
        integrator="volpathmis",
    ),
]
