"""Runs the full loop's tracking through grids along given rays, walks beside flights, for the tests of estimators."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tests.conftest import Rng
from tests.kernels.device_code import literal
from tests.kernels.test_volume import GRIDS

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.formats import Grid
from woodcock.integrator import volumetric_path_full
from woodcock.layout import Layout
from woodcock.program import world
from woodcock.scene import GridVolume, Scene, parse
from woodcock.space import Array, Space

CAMERA = {"kind": "orthographic", "origin": [0.5, 0.5, -5], "target": [0.5, 0.5, 0], "up": [0, 1, 0], "height": 1}
#: Its walks are what is asked for.
LIGHT = {"kind": "directional", "direction": [0, 0, 1], "irradiance": 1}

#: All lanes go through the grids once a scale: even ones as walks, odd ones as flights.
BODY = """
real value[{results}];
for (int scale = 0; scale < {scales}; ++scale) {{
    const struct world here = {{&numbers[scale]{buffers}}}, *world = &here;
    path p = {{{{(word)0u}}}};
    grid_state g = {{0}};
    audit found = {{0}};
    p.random.pixel = a;
    p.random.sample = turn;
    p.random.seed = (uint)scale;
    p.origin = vector_of(x, y, z);
    p.direction = vector_of(dx, dy, dz);
    p.end = (real)1e30f;
    p.hero = word_as_integer((a >> 1u) % 3u);
    p.throughput = spectrum_grey((real)1.f);
    p.transmittance = p.balance = coefficient_grey((real)1.f);
    p.walking = test((a & 1u) == 0u);
    mask collided, lost, hit = (mask)0;
    grids_start(&p, world, &g, (mask)-1);
    while (some(p.tracking)) {{
        grids_step(&p, world, &g, &found, &collided, &lost);
        hit |= collided;
    }}
    vector flown = vector_along(p.position, (real)-1.f, p.origin);
    real *of = value + {each} * scale;
    for (int c = 0; c < 3; ++c) of[c] = coefficient_channel(p.transmittance, c % COEFFICIENTS);
    of[3] = pick((real)-1.f, vector_dot(flown, p.direction), hit);
    of[4] = to_real(found.violations);
}}
"""
EACH = 5
#: About 2^16 lanes, by width, of prime numbers of work items: PoCL keeps the state of a whole group on its stack, and
#: these divide into no groups.
COUNTS = {1: 65537, 4: 4 * 16411, 8: 8 * 8209, 16: 16 * 4099}


@dataclass(frozen=True)
class Tracked:
    """through: (scales, 3, walks), by channel; flown: (scales, flights), lengths to collisions in the scene, -1 for
    none."""

    through: Array
    walk_ray: NDArray[np.int64]
    flown: Array
    flight_ray: NDArray[np.int64]
    violations: int


@dataclass(frozen=True)
class Field:
    """A scene of grids alone, and rays through it: from (n, 3) along unit directions (n, 3), in the scene."""

    volumes: tuple[dict[str, Any], ...]
    grids: dict[str, Grid]
    origin: Array
    direction: Array

    def scene(self, scale: float, **keys: Any) -> Scene:
        volumes = [{**v, "scale": (scale * np.array(v.get("scale", 1.0))).tolist()} for v in self.volumes]
        scene = {"camera": CAMERA, "volumes": volumes, "lights": [LIGHT], "film": {"width": 1, "height": 1}}
        scene |= {"majorant": {"kind": "global"}} | keys
        return parse(json.dumps(scene))

    def layout(self, scale: float, **keys: Any) -> Layout:
        return volumetric_path_full.lay_out(self.scene(scale, **keys), lambda file, name: self.grids[file])

    def sigma_t(self, ray: int, t: Array, scale: float) -> list[Array]:
        """Float64 oracle: of every medium at lengths t (n,) along a ray, (n, 3)."""
        points = self.origin[ray] + t[:, None] * self.direction[ray]
        found = []
        for volume in self.scene(scale).volumes:
            assert isinstance(volume, GridVolume)
            density = GRIDS.density(volume, self.grids[volume.file], points)
            found.append(np.broadcast_to(density if density.ndim == 2 else density[:, None], (len(t), 3)))
        return found

    def depth(self, ray: int, scale: float, most: float = 6.0, count: int = 40000) -> tuple[Array, Array]:
        """Float64 oracle: lengths (n,), and optical depth up to there by channel (n, 3)."""
        t = np.linspace(0, most, count + 1)
        middle = sum(self.sigma_t(ray, (t[:-1] + t[1:]) / 2, scale))
        return t, np.concatenate([np.zeros((1, 3)), np.cumsum(middle * np.diff(t)[:, None], axis=0)])


ORIGIN = np.array([[-0.3, 0.2, 0.4], [0.5, 1.2, 0.7], [0.31, 0.42, 0.53], [1.1, 0.9, -0.1]])
DIRECTION = np.array([[1, 0.4, 0.1], [0.05, -1, -0.2], [0.3, -0.5, 1], [-0.7, -0.6, 0.8]])
DIRECTION = DIRECTION / np.linalg.norm(DIRECTION, axis=1)[:, None]


def placed(values: Any, to_world: Any = None) -> Grid:
    """In the unit cube, or wherever that is put."""
    unit = np.diag([*(1 / np.array(values.shape[2::-1])), 1])
    return Grid("density", values, (np.eye(4) if to_world is None else to_world) @ unit, placed=True)


def field_of(values: Any, **keys: Any) -> Field:
    return Field(({"kind": "grid", "file": "a", "albedo": 0.5, **keys},), {"a": placed(values)}, ORIGIN, DIRECTION)


def track(context: Context, field: Field, scales: Sequence[float], lanes: int, rng: Rng, **keys: Any) -> Tracked:
    return run(context, field, [field.layout(scale, **keys) for scale in scales], lanes, rng)


def run(context: Context, field: Field, layouts: Sequence[Layout], lanes: int, rng: Rng) -> Tracked:
    first, n = layouts[0], COUNTS[lanes]
    space: Space = first.space
    assert all(layout.structs() == first.structs() for layout in layouts)
    arrays = {name: [array_of(layout.buffers[name]) for layout in layouts] for name in first.buffers}
    buffers = {f"{name}_of": np.concatenate(found) for name, found in arrays.items()}
    given = "".join(f", {name}_of + {found[0].size} * scale" for name, found in arrays.items())
    scenes = ",\n".join(
        "{" + ", ".join(literal(r, layout.channels) for r in layout.records) + "}" for layout in layouts
    )
    lane = np.arange(n)
    ray = (lane >> 1) % len(field.origin)
    inputs = dict(zip(("x", "y", "z"), space.point(field.origin)[ray].T, strict=True))
    inputs |= dict(zip(("dx", "dy", "dz"), field.direction[ray].T, strict=True))
    found = evaluate(
        context,
        [f"value[{i}]" for i in range(EACH * len(layouts))],
        {
            **{name: value.astype(np.float32) for name, value in inputs.items()},
            "a": lane.astype(np.uint32),
            "turn": np.full(n, rng(0).integers(1 << 32), np.uint32),
        },
        lanes=lanes,
        parts=[
            *("core/precision_float.h", "core/rng.h", "core/vector.h", f"core/spectrum_{first.channels}.h"),
            *(first.structs(), *first.before_world, world(first), *first.after_world),
            f"__constant struct scene numbers[{len(layouts)}] = {{{scenes}}};\n",
        ],
        buffers=buffers,
        body=BODY.format(scales=len(layouts), results=EACH * len(layouts), each=EACH, buffers=given),
    ).reshape(len(layouts), EACH, n)
    walks, flights = found[:, :, ::2].astype(float), found[:, :, 1::2].astype(float)
    flown = np.where(flights[:, 3] < 0, -1.0, np.ldexp(flights[:, 3], space.length_exponent))
    return Tracked(
        through=walks[:, :3],
        walk_ray=ray[::2],
        flown=flown,
        flight_ray=ray[1::2],
        violations=int(found[:, 4].sum()),
    )


def changed(layout: Layout, factors: dict[str, float]) -> Layout:
    """The same with buffers, by the beginnings of their names, multiplied."""
    buffers = dict(layout.buffers)
    for name, array in layout.buffers.items():
        for start, factor in factors.items():
            if name.startswith(start):
                buffers[name] = array_of(array) * np.float32(factor)
    return replace(layout, buffers=buffers)


def array_of(array: Any) -> NDArray[Any]:
    """A layout's buffer on the host."""
    return np.asarray(array.array() if hasattr(array, "pieces") else array)
