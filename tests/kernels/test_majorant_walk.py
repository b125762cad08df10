"""Walks through majorants, global and grid, go where a float64 oracle goes, and end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.kernels.device_code import KIND_NEEDS, numbers, struct
from tests.kernels.test_volume import grid_of
from tests.statistics import accept_mean, accept_squares, accept_z

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.layout import Record, module
from woodcock.majorant.hops import crossing, hops
from woodcock.scene import GlobalMajorant, GridMajorant, GridVolume
from woodcock.space import Array, Space
from woodcock.volume.compose import compose
from woodcock.volume.media import read_media

MAJORANTS = module("majorant", "grid")

CELLS = (5, 3, 4)
SIZE = np.array([10.0, 4.0, 6.0])
#: Ways on through cells, and how many times CELLS are cut for it.
WAYS = pytest.mark.parametrize(("way", "finer"), [("cells", 1), ("hops", 7)])

#: So many huge bounds lie in memory before and after those of the cells.
AROUND = 4096


def walk(
    context: Context, cells: Array, rays: dict[str, Any], lanes: int, body: str, results: list[str], way: str = "cells"
) -> Array:
    """Evaluates after `majorant_walk walk` was started on rays o, d from near to far; huge bounds surround `cells`.

    way: on through them, one by one or by `hops`, whose blocks hold cells of one bound here.
    """
    record = Record("majorant", "grid", "kind", MAJORANTS.FIELDS, MAJORANTS.record(cells.shape[::-1], SIZE))
    bounds = cells.astype(np.float32).reshape(-1)
    if way == "hops":
        bounds = MAJORANTS.with_blocks(np.maximum(bounds, MAJORANTS.LEAST), hops(cells, 1e9).exponents.reshape(-1))
    start = f"""
__global const float *bounds = surrounded + {AROUND};
majorant_walk walk = {{0}};
vector origin = vector_of(ox, oy, oz), along = vector_of(dx, dy, dz);
majorant_grid_start(&numbers, bounds, origin, along, near, far, &walk, (mask)-1);
"""
    return evaluate(
        context,
        results,
        {name: np.asarray(value, np.float32) for name, value in rays.items()},
        lanes=lanes,
        parts=[*KIND_NEEDS, struct(record), f"majorant/grid_{way}.h", "majorant/grid.h", numbers(record)],
        buffers={"surrounded": np.pad(bounds, AROUND, constant_values=1e9)},
        body=start + body,
    )


def rays_through(random: np.random.Generator, count: int) -> dict[str, Any]:
    """Rays through the grid, from inside and outside; axis-parallel ones, and ones through corners of cells."""
    origin, target = random.random((2, count, 3)) * SIZE
    direction = target - origin
    direction[: count // 8, 1:] = 0
    direction[count // 8 : count // 6, :2] = 0
    origin -= direction * random.integers(0, 2, count)[:, None] * 3
    return dict(zip(("ox", "oy", "oz", "dx", "dy", "dz"), np.hstack([origin, direction]).T, strict=True))


def clipped(rays: dict[str, Any]) -> dict[str, Any]:
    """near, far: where the rays, as float32 has them, run through the box."""
    o, d = (np.stack([rays[f"{name}{axis}"] for axis in "xyz"]).astype(np.float32).astype(float) for name in "od")
    with np.errstate(all="ignore"):
        a, b = -o / d, (SIZE[:, None] - o) / d
    parallel = d == 0
    near = np.where(parallel, -np.inf, np.minimum(a, b)).max(axis=0)
    far = np.where(parallel, np.inf, np.maximum(a, b)).min(axis=0)
    return {**rays, "near": np.maximum(near, 0), "far": far}


def pieces(rays: dict[str, Any], index: int, bounds: Array) -> tuple[Array, Array]:
    """Oracle: the lengths at which a ray crosses planes, near and far included, and the bounds between."""
    o, d = (np.array([rays[f"{name}{axis}"][index] for axis in "xyz"], np.float32).astype(float) for name in "od")
    near, far = rays["near"][index], rays["far"][index]
    cells = bounds.shape[::-1]
    side = SIZE / cells
    with np.errstate(all="ignore"):
        planes = [(np.arange(n + 1) * side[a] - o[a]) / d[a] for a, n in enumerate(cells) if d[a] != 0]
    lengths = np.unique(np.concatenate([[near, far], *planes]))
    lengths = lengths[(lengths >= near) & (lengths <= far)]
    middles = o + (lengths[:-1] + lengths[1:])[:, None] / 2 * d
    x, y, z = np.clip(np.floor(middles / side), 0, np.array(cells) - 1).astype(int).T
    return lengths, bounds[z, y, x]


@WAYS
def test_walks_spend_optical_depth_as_the_oracle_does(context: Context, lanes: int, way: str, finer: int) -> None:
    """Three steps of a walk: where they end, or that they leave, through cells of which half are empty."""
    random = np.random.default_rng(9)
    bounds = random.random(CELLS[::-1]) * (random.random(CELLS[::-1]) < 0.5) * 4
    bounds = bounds.astype(np.float32).astype(float).repeat(finer, 0).repeat(finer, 1).repeat(finer, 2)
    rays = clipped(rays_through(random, 480))
    depths = random.exponential(size=(3, 480)).astype(np.float32)
    body = "real t[3], from[3]; mask left[3], active = (mask)-1;\n"
    for step in range(3):
        body += f"left[{step}] = majorant_grid_step(&numbers, bounds, &walk, depth_{step}, active);\n"
        body += f"active &= ~left[{step}]; t[{step}] = walk.t; from[{step}] = walk.t_from;\n"
    results = [f"{name}[{step}]" for name in ("t", "from") for step in range(3)]
    results += [f"pick((real)0.f, (real)1.f, left[{step}])" for step in range(3)]
    given = {**rays, **{f"depth_{step}": depth for step, depth in enumerate(depths)}}
    t, start, left = walk(context, bounds, given, lanes, body, results, way).reshape(3, 3, -1)
    for index in range(480):
        lengths, between = pieces(rays, index, bounds)
        spent = np.concatenate([[0], np.cumsum(between * np.diff(lengths))])
        total, expected = np.cumsum(depths[:, index].astype(float)), np.full(3, lengths[-1])
        for step in np.flatnonzero(total < spent[-1]):
            cell = int(np.searchsorted(spent, total[step], side="right")) - 1
            expected[step] = lengths[cell] + (total[step] - spent[cell]) / between[cell]
        sure = np.abs(total - spent[-1]) > 1e-4
        went = np.concatenate([[0], np.cumsum(total >= spent[-1])[:-1]]) == 0  # had not left before
        scale = 1e-5 * max(1, abs(lengths[-1])) / max(1e-3, min([b for b in between if b > 0], default=1))
        assert np.allclose(t[went & sure, index], expected[went & sure], rtol=0, atol=scale)
        assert np.array_equal(left[went & sure, index] > 0, (total >= spent[-1])[went & sure])
        assert start[0, index] == np.float32(rays["near"][index])
        assert start[1, index] == t[0, index] or not went[1]


@WAYS
def test_walks_end_whatever_the_ray(context: Context, lanes: int, way: str, finer: int) -> None:
    """Rays along faces and edges, through corners, of no direction, of huge and tiny ones, with ends beyond everything
    or before the start, and of NaN: every walk ends, and no lookup leaves the grid."""
    side = SIZE / CELLS
    corners = np.array(list(np.ndindex(*(n + 1 for n in CELLS)))) * side
    directions = np.array(list(np.ndindex(3, 3, 3))) - 1.0
    origin, direction = (
        np.repeat(corners, len(directions) * 2, axis=0),
        np.tile(np.repeat(directions * side, 2, axis=0), (len(corners), 1)),
    )
    origin[1::2] -= 100 * direction[1::2]
    extra = [(x, y) for x in (np.nan, 1e30, -1e30, 1e-40, 0) for y in (np.nan, np.inf, 1e30, 1e-30, 1e-42, 0)]
    origin = np.concatenate([origin, [(x, 1, 1) for x, _ in extra]])
    direction = np.concatenate([direction, [(y, 1e-3, y) for _, y in extra]])
    rays = dict(zip(("ox", "oy", "oz", "dx", "dy", "dz"), np.hstack([origin, direction]).T, strict=True))
    rays |= {"near": np.zeros(len(origin)), "far": np.full(len(origin), 1e30)}
    rays["near"][::5], rays["far"][::7] = 50, 0.5
    body = """
mask active = (mask)-1;
real worst = walk.bound;
for (int i = 0; i < 20; ++i) {
    active &= ~majorant_grid_step(&numbers, bounds, &walk, (real)0.25f, active);
    worst = larger(worst, walk.bound);
}
mask left = majorant_grid_step(&numbers, bounds, &walk, (real)1e37f, active);
worst = larger(worst, walk.bound);
"""
    results = ["worst", "pick((real)0.f, (real)1.f, left | ~active)", "walk.t"]
    bounds = np.full(np.array(CELLS[::-1]) * finer, 0.5)
    worst, left, t = walk(context, bounds, rays, lanes, body, results, way)
    assert worst.max() <= 0.5 * (1 + 2e-6)  # blocks lift bounds by that
    assert left.all()
    inside = np.isfinite(origin).all(axis=1) & (np.abs(origin) < 1e6).all(axis=1) & (rays["near"] < rays["far"])
    assert np.isfinite(t[inside]).all()


@WAYS
def test_nothing_stops_a_walk_through_empty_cells(context: Context, way: str, finer: int) -> None:
    rays = clipped(rays_through(np.random.default_rng(4), 64))
    far = rays["far"].copy()
    rays["far"] = np.full(64, 1e30)
    body = "mask left = majorant_grid_step(&numbers, bounds, &walk, (real)1e-20f, (mask)-1);"
    results = ["walk.t", "pick((real)0.f, (real)1.f, left)"]
    t, left = walk(context, np.zeros(np.array(CELLS[::-1]) * finer), rays, 1, body, results, way)
    assert left.all()
    assert np.allclose(t, far, rtol=1e-5)


def test_blocks_bound_all_their_cells() -> None:
    """A dense core in haze that varies; what blocks lift bounds by costs less than crossing their cells."""
    random = np.random.default_rng(5)
    bounds = random.random((20, 24, 33)) * 0.01
    bounds[8:12, 9:13, 15:19] = 100
    pace = 0.01
    blocks = hops(bounds, pace)
    assert blocks.exponents.max() == 3
    assert np.all(blocks.exponents[8:12, 9:13, 15:19] <= 1)
    for at in np.ndindex(bounds.shape):
        reach = (1 << int(blocks.exponents[at])) - 1
        around = tuple(slice(max(i - reach, 0), i + reach + 1) for i in at)
        assert blocks.bounds[at] == bounds[around].max()
        assert blocks.bounds[at] - bounds[around].mean() < 0.16 / pace
    assert blocks.cost < crossing(bounds, pace)
    stored = MAJORANTS.buffers(blocks.bounds, Space(), blocks.exponents)["bounds"].reshape(bounds.shape)
    assert np.all(stored >= blocks.bounds)
    assert np.all(stored <= blocks.bounds * (1 + 3e-6))
    assert np.array_equal(MAJORANTS.blocks_of(stored), blocks.exponents)


def test_cells_that_differ_have_no_blocks() -> None:
    bounds = np.random.default_rng(6).random((8, 8, 8)) * 100
    blocks = hops(bounds, 1.0)
    assert not blocks.exponents.any()
    assert np.array_equal(blocks.bounds, bounds)
    assert blocks.cost > crossing(bounds, 1.0)


def test_small_steps_do_not_stall(context: Context) -> None:
    """A thousand steps, each below half an ulp of t, add up."""
    ray = {"ox": -999, "oy": 2, "oz": 3, "dx": 1, "dy": 0, "dz": 0, "near": 1000.1, "far": 1001}
    rays = {name: np.full(8, value) for name, value in ray.items()}
    body = """
real first = walk.t;
for (int i = 0; i < 1000; ++i) majorant_grid_step(&numbers, bounds, &walk, (real)1e-2f, (mask)-1);
"""
    (gone,) = walk(context, np.full(CELLS[::-1], 1e3), rays, 4, body, ["walk.t - first"])
    assert np.allclose(gone, 1e-2, atol=1e-4)


@pytest.mark.parametrize(
    "majorant", [GlobalMajorant(), GridMajorant(resolution=7), GridMajorant(resolution=7, blocks=True)]
)
def test_tentative_collisions_come_at_the_majorants_rate(context: Context, majorant: Any) -> None:
    """Their number along a ray is Poisson's, of the mean ∫ majorant."""
    random = np.random.default_rng(12)
    media = read_media(
        [GridVolume(file="x", albedo=0, scale=6)],
        lambda file, name: grid_of(random.random((9, 8, 7)).astype(np.float32)),
    )
    composed = compose(media, Space(), majorant)
    tracking, record = composed.records[0].values, composed.records[1]
    count = 1 << 16
    buffers = {"bounds": composed.buffers["majorant_grid_bounds"].array()} if majorant.kind == "grid" else {}
    given = "&numbers, bounds, " if buffers else "&numbers, "
    body = f"""
majorant_walk walk = {{0}};
rng_address at = {{a, (word)0u, (word)0u, 5u}};
vector origin = vector_of((real)0.f, (real)1.f, (real)2.f), along = vector_of((real)4.f, (real)3.f, (real)3.5f);
majorant_{majorant.kind}_start({given}origin, along, (real)0.f, (real)1.75f, &walk, (mask)-1);
mask active = (mask)-1;
real events = (real)0.f, sum = (real)0.f;
while (some(active)) {{
    words w = rng_next(&at, active);
    real u, depth = rng_flight(&at, w, &u);
    active &= ~majorant_{majorant.kind}_step({given}&walk, depth, active);
    events += pick((real)0.f, (real)1.f, active);
    sum += pick((real)0.f, 1.f / walk.bound, active);
}}
"""
    events, lengths = evaluate(
        context,
        ["events", "sum"],
        {"a": np.arange(count, dtype=np.uint32)},
        lanes=4,
        parts=[*KIND_NEEDS, struct(record), *(file for file in composed.files if "majorant" in file), numbers(record)],
        buffers=buffers,
        body=body,
    ).astype(float)
    along = np.array([0, 1, 2]) + np.linspace(0, 1.75, 200001)[:, None] * [4, 3, 3.5]
    if majorant.kind == "grid":
        cells = [record.values[f"cells_{axis}"] for axis in "xyz"]
        x, y, z = np.floor(along[:-1] * record.values["per_cell"]).astype(int).T
        mean = 1.75 * buffers["bounds"].reshape(cells[::-1])[z, y, x].astype(float).mean()
    else:
        mean = 1.75 / record.values["mean_free_path"]
    assert np.all(along <= tracking["size"])
    accept_z((events.mean() - mean) / np.sqrt(mean / count))
    # As Poisson's law has it: Σ (n - mean)² / mean is χ² of almost as many degrees.
    accept_squares((count - 1) * events.var(ddof=1) / mean, count - 1)
    # Every event stands for one mean free path where it happened: together for the ray's length.
    accept_mean(lengths, 1.75, exact=False)
