"""Scenes with surfaces, and with media between them."""

from __future__ import annotations

from tests.references.case import FLOOR, SIZE, SKY, Case, ball, box, constant, floor, lobe, perspective, pinhole, sphere
from tests.references.mitsuba_side import ISOTROPIC, hg

SURFACES = [
    Case(
        "shapes",
        {
            "camera": perspective(),
            "surfaces": [
                floor(0.7, 0.6, 0.5),
                {"kind": "mesh", "file": "body.ply", "material": {"kind": "diffuse", "reflectance": [0.8, 0.3, 0.2]}},
                {
                    "kind": "disk",
                    "center": [1, 0.2, -0.9],
                    "normal": [-1, 0.5, -1],
                    "radius": 0.4,
                    "material": {"kind": "diffuse", "reflectance": 0.9},
                },
                sphere([-1.2, 0.9, 0], 0.4, kind="emissive", radiance=[5, 3, 2]),
                sphere([0.3, 0.4, -1.2], 0.5, kind="null"),
            ],
            "lights": [constant([0.2, 0.3, 0.4])],
        },
        pinhole(),
        lambda m: {
            "floor": {**m.rectangle(FLOOR), "bsdf": m.diffuse([0.7, 0.6, 0.5])},
            "body": {**m.mesh(), "bsdf": m.diffuse([0.8, 0.3, 0.2])},
            "disk": {**m.disk([1, 0.2, -0.9], [-1, 0.5, -1], 0.4), "bsdf": m.diffuse(0.9)},
            "lamp": {**m.sphere([-1.2, 0.9, 0], 0.4), **m.emissive([5, 3, 2])},
            "nothing": {**m.sphere([0.3, 0.4, -1.2], 0.5), "bsdf": {"type": "null"}},
            "sky": m.constant([0.2, 0.3, 0.4]),
        },
    ),
    Case(
        "mirror",
        {
            "camera": perspective(),
            "volumes": [ball([-0.7, -0.3, -1], 0.6, sigma_t=4, albedo=[0.6, 0.8, 0.95], phase=lobe(0.3))],
            "surfaces": [floor(0.7, 0.6, 0.5), sphere([0.4, -0.1, 0.3], 1, kind="mirror", reflectance=[0.9, 0.8, 0.7])],
            "lights": [constant(0.5), {"kind": "directional", "direction": [-0.5, -1, 0.6], "irradiance": 2}],
        },
        pinhole(),
        lambda m: {
            "ball": m.within(m.sphere([-0.7, -0.3, -1], 0.6), m.medium(4, [0.6, 0.8, 0.95], hg(0.3))),
            "floor": {**m.rectangle(FLOOR), "bsdf": m.diffuse([0.7, 0.6, 0.5])},
            "mirror": {
                **m.sphere([0.4, -0.1, 0.3], 1),
                "bsdf": {"type": "conductor", "material": "none", "specular_reflectance": m.rgb([0.9, 0.8, 0.7])},
            },
            "sky": m.constant(0.5),
            "light": m.directional([-0.5, -1, 0.6], 2),
        },
    ),
    Case(
        "glass",
        {
            "camera": perspective(),
            "volumes": [ball([0, 0, 0], 0.7, sigma_t=3, albedo=[0.9, 0.6, 0.3])],
            "surfaces": [floor(0.5, 0.6, 0.7), sphere([0, 0, 0], 1, kind="dielectric", ior=1.5)],
            "lights": [SKY],
        },
        pinhole(),
        lambda m: {
            "ball": m.within(m.sphere([0, 0, 0], 0.7), m.medium(3, [0.9, 0.6, 0.3], ISOTROPIC)),
            "floor": {**m.rectangle(FLOOR), "bsdf": m.diffuse([0.5, 0.6, 0.7])},
            "glass": {**m.sphere([0, 0, 0], 1), "bsdf": {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}},
            "sky": m.sky(),
        },
    ),
    Case(
        "frosted",
        {
            "camera": perspective(),
            "surfaces": [
                floor(0.5, 0.6, 0.7),
                sphere([0, -0.1, 0], 1, kind="rough_dielectric", ior=1.5, roughness=0.3),
            ],
            "lights": [SKY],
        },
        pinhole(),
        lambda m: {
            "floor": {**m.rectangle(FLOOR), "bsdf": m.diffuse([0.5, 0.6, 0.7])},
            "glass": {
                **m.sphere([0, -0.1, 0], 1),
                "bsdf": {
                    "type": "roughdielectric",
                    "distribution": "ggx",
                    "alpha": 0.3,
                    "int_ior": 1.5,
                    "ext_ior": 1.0,
                },
            },
            "sky": m.sky(),
        },
    ),
    Case(
        "sun",
        {
            "camera": perspective(),
            "volumes": [box(-1, 1, sigma_t=1, albedo=0.9, phase=lobe(0.6))],
            "surfaces": [floor(0.7, 0.6, 0.5)],
            "lights": [
                constant(0.1),
                {"kind": "sun", "direction": [0.7, -1, 0.4], "irradiance": [3, 2.5, 2], "angular_radius": 6},
            ],
        },
        pinhole(),
        lambda m: {
            "body": m.within(m.box([-1] * 3, [1] * 3), m.medium(1, 0.9, hg(0.6))),
            "floor": {**m.rectangle(FLOOR), "bsdf": m.diffuse([0.7, 0.6, 0.5])},
            "sky": m.constant(0.1),
            "sun": m.sun([0.7, -1, 0.4], [3, 2.5, 2], 6),
        },
    ),
    Case(
        "inside",
        {
            "camera": perspective([0.2, 0.1, -1.8], [0, 0, 0]),
            "volumes": [ball([0, 0, 0], 2.5, sigma_t=0.4, albedo=[0.95, 0.9, 0.8], phase=lobe(0.3))],
            "surfaces": [sphere([0.3, -0.2, 0], 0.5, kind="diffuse", reflectance=[0.3, 0.5, 0.9])],
            "lights": [{"kind": "point", "position": [-2, 3, -1], "intensity": [10, 12, 14]}, constant(0.1)],
        },
        lambda m: {
            **m.camera("perspective", [0.2, 0.1, -1.8], [0, 0, 0], SIZE, fov=40),
            "medium": {"type": "ref", "id": "fog"},
        },
        lambda m: {
            "fog": m.medium(0.4, [0.95, 0.9, 0.8], hg(0.3)),
            "ball": {
                **m.sphere([0, 0, 0], 2.5),
                "bsdf": {"type": "null"},
                "interior": {"type": "ref", "id": "fog"},
            },
            "body": {
                **m.sphere([0.3, -0.2, 0], 0.5),
                "bsdf": m.diffuse([0.3, 0.5, 0.9]),
                "exterior": {"type": "ref", "id": "fog"},
            },
            "light": m.point([-2, 3, -1], [10, 12, 14]),
            "sky": m.constant(0.1),
        },
    ),
]
