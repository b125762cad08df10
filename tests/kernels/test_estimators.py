"""Free flights (delta, decomposition) and transmittances (ratio, residual_ratio, ray_marching) through grids."""

from __future__ import annotations

import functools
import itertools
from typing import Any

import numpy as np
import pytest
from scipy.stats import binomtest, chisquare
from tests.analytic.scenes import Grid, Kind, Picture, Scene, constant, cuboid, noise, random_walk, same
from tests.conftest import Rng, described
from tests.kernels.grid_rays import DIRECTION, ORIGIN, Field, array_of, changed, field_of, placed, run, track
from tests.statistics import accept, accept_mean, accept_z, least

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.formats import Grid as Values
from woodcock.layout import Layout, module
from woodcock.plan import lay_out
from woodcock.space import Array

MARCHING, RESIDUAL = module("tracking", "ray_marching"), module("tracking", "residual_ratio")
FLIGHTS, TRANSMITTANCES = ("delta", "decomposition"), ("ratio", "residual_ratio", "ray_marching")
#: Every kind once; both are at work in one program, walks beside flights.
PAIRS = [("delta", "ratio"), ("decomposition", "residual_ratio"), ("decomposition", "ray_marching")]
pairs = pytest.mark.parametrize(("flight", "transmittance"), PAIRS)
MAJORANTS: dict[str, Kind] = {"global": {"kind": "global"}, "grid": {"kind": "grid", "resolution": 8}}


def asked(flight: str, transmittance: str) -> dict[str, Any]:
    return {"free_flight": {"kind": flight}, "transmittance": {"kind": transmittance}}


# The parts of ray marching


def test_orders_and_points_of_ray_marching(context: Context, lanes: int) -> None:
    chances = [MARCHING.chance(order) for order in range(1, 20)]
    u = np.array([chance * side for chance in chances for side in (1 - 1e-5, 1 + 1e-5)] + [0.5, 1, 1e-19], np.float32)
    depth = np.concatenate([[0], np.geomspace(1e-6, 8, len(u) - 1)]).astype(np.float32)
    order, points = evaluate(
        context,
        ["to_real(transmittance_ray_marching_order(u))", "transmittance_ray_marching_points(depth)"],
        {"u": u, "depth": depth},
        lanes=lanes,
        parts=["core/rng.h", "core/vector.h", "core/spectrum_1.h", "core/coefficient_1.h", "tracking/ray_marching.h"],
    )
    expected = [sum(float(value) < MARCHING.chance(k) for k in range(1, 40)) for value in u]
    assert order.tolist() == expected
    assert max(expected) > 19  # no order is the last
    assert points.tolist() == MARCHING.points(depth.astype(float)).tolist()


@pytest.mark.parametrize("channels", [1, 3])
def test_the_series_of_ray_marching(context: Context, lanes: int, channels: int) -> None:
    """The value of given depths of combs, to orders far beyond those that are means."""
    random, n, most = np.random.default_rng(1), 240, 12
    orders = np.arange(n) % most
    orders[orders == 1] = 0  # there is none
    depths = random.uniform(0, 3, (most, n)).astype(np.float32)
    combs = "".join(
        f"m.sum = coefficient_scale(colour_of(d{k}), (real)4.f); going = transmittance_ray_marching_end(&m, going);\n"
        for k in range(most)
    )
    colour = "spectrum_of(d, d * 0.5f, d * 2.f)" if channels == 3 else "d"
    results = evaluate(
        context,
        [f"coefficient_channel(value, {c})" for c in range(channels)],
        {"order": orders.astype(np.float32), **{f"d{k}": depth for k, depth in enumerate(depths)}},
        lanes=lanes,
        parts=[
            *("core/rng.h", "core/vector.h", f"core/spectrum_{channels}.h", f"core/coefficient_{channels}.h"),
            "tracking/ray_marching.h",
            f"static inline coefficient colour_of(real d) {{ return {colour}; }}\n",
        ],
        body=f"""
ray_marching m = {{(integer)0}};
transmittance_ray_marching_begin(&m, (real)1.f, (real)1.f, (mask)-1);
m.order = to_integer(order);
m.spacing = (real)0.25f;
mask going = (mask)-1;
{combs}coefficient value = transmittance_ray_marching_value(&m);
""",
    )
    for found, tint in zip(results, (1, 0.5, 2) if channels == 3 else (1,), strict=True):
        right = [
            MARCHING.value((depths[: order + 1, i].astype(float) * tint).tolist()) for i, order in enumerate(orders)
        ]
        assert np.allclose(found, right, rtol=1e-4, atol=1e-4)


# Rays through grids


@functools.cache
def field(name: str) -> Field:
    """`cloud`: high contrast, empty cells; `haze`: nowhere empty; `many`: two grids in colour, one of them turned."""
    random = np.random.default_rng(5)
    cloud = (random.random((9, 11, 13)) ** 4).astype(np.float32)
    cloud[random.random(cloud.shape) < 0.3] = 0
    cloud[:4] = 0
    cloud[5:, 2:9, 3:] += 0.5
    if name == "cloud":
        return field_of(cloud)
    if name == "haze":
        return field_of(cloud * 0.1 + 0.9)
    colours = random.random((6, 5, 7, 3)).astype(np.float32) * 0.5 + 0.3
    turned = np.eye(4)
    turned[:3] = [[0.9, -0.3, 0, 0.2], [0.3, 0.9, 0.1, -0.1], [0, -0.1, 0.95, 0.05]]
    volumes: tuple[Kind, ...] = (
        {"kind": "grid", "file": "a", "albedo": 0.5, "scale": [1, 0.5, 0.2]},
        {"kind": "grid", "file": "b", "albedo": 0.5, "interpolation": "nearest"},
    )
    return Field(volumes, {"a": placed(cloud), "b": placed(colours, turned)}, ORIGIN, DIRECTION)


@functools.cache
def depth(name: str, ray: int, scale: float) -> tuple[Array, Array]:
    return field(name).depth(ray, scale)


#: The optical depth of a walk is 0.2 to 1 times this.
SCALES = [1e-6, 0.1, 1.0, 5.0]
RAYS = [("cloud", "grid"), ("haze", "global"), ("many", "grid")]


@pytest.mark.parametrize(("name", "majorant"), RAYS)
@pairs
def test_walks_and_flights_through_grids(
    context: Context, name: str, majorant: str, flight: str, transmittance: str, lanes: int, rng: Rng
) -> None:
    """Walks have the mean exp(-τ), and flights survive and collide by it; both in one program."""
    found = track(
        context, field(name), SCALES, lanes, rng, majorant=MAJORANTS[majorant], **asked(flight, transmittance)
    )
    assert found.violations == 0
    colours, rays = 3 if name == "many" else 1, range(len(ORIGIN))
    survival, shares = [], []
    for scale, through, flown in zip(SCALES, found.through, found.flown, strict=True):
        right = np.exp(-np.array([depth(name, ray, scale)[1][-1, :colours] for ray in rays]))
        count = min(int((found.walk_ray == ray).sum()) for ray in rays)
        walks = np.stack([through[:colours, found.walk_ray == ray][:, :count] for ray in rays])
        # A unit in the last place of a transmittance, and where τ is small one of what ratio tracking can tell.
        accept_mean(walks, right, f"{scale}", allowed=1e-6 + 2 * scale * (scale < 1e-3), exact=False)
        if transmittance == "ray_marching" and scale < 1e-3:
            assert np.allclose(walks.mean(axis=-1), right, atol=2e-7)
        for ray in rays:
            t, tau = depth(name, ray, scale)
            lengths = flown[found.flight_ray == ray]
            # Heroes take distances in turn, and each has a law of its own.
            hero = (2 * np.flatnonzero(found.flight_ray == ray) + 1 >> 1) % 3
            for c in range(colours):
                own = lengths[hero == c] if colours == 3 else lengths
                chance = float(np.exp(-tau[-1, c]))
                survival.append(binomtest(int((own < 0).sum()), own.size, min(chance, 1.0)).pvalue)
                if scale >= 1:
                    share = -np.expm1(-np.interp(own[own >= 0], t, tau[:, c])) / (1 - chance)
                    shares.append(chisquare(np.histogram(share, 16, (0, 1 + 1e-5))[0]).pvalue)
    accept(least(survival), "survival", exact=False)
    accept(least(shares), "collisions", exact=False)


@pytest.mark.parametrize("transmittance", ["residual_ratio", "ray_marching"])
def test_deep_walks_through_haze(context: Context, transmittance: str, rng: Rng) -> None:
    """τ of 10 to 35 in a medium that is hardly uneven, where ratio tracking has one walk in a million that counts."""
    keys = {"majorant": MAJORANTS["grid"], **asked("delta", transmittance)}
    found = track(context, field("haze"), [24.0], 4, rng, **keys)
    for ray in range(len(ORIGIN)):
        right = float(np.exp(-depth("haze", ray, 24.0)[1][-1, 0]))
        assert 10 < -np.log(right) < 50
        walks = found.through[0, 0, found.walk_ray == ray]
        accept_mean(walks, right, allowed=1e-4 * right, exact=False)
        assert walks.std() / np.sqrt(walks.size) < 0.2 * right


STEPS = 60000
#: Longer than any ray is inside.
LONGEST = 3.0


def controls_along(field: Field, layout: Layout, ray: int) -> tuple[Array, Array, Array]:
    """Lengths along a ray (n,), control and residual bound there, of one grey grid in the unit cube."""
    records = {record.member: record.values for record in layout.records}
    majorant = records["majorant"]
    cells = np.array([majorant.get(f"cells_{axis}", 1) for axis in "xyz"])
    stored, above = (array_of(layout.buffers[name]) for name in ("minorant_0_0", "majorant_residual"))
    t = (np.arange(STEPS) + 0.5) * (LONGEST / STEPS)
    points = ORIGIN[ray] + t[:, None] * DIRECTION[ray]
    inside = np.all((points >= 0) & (points <= 1), axis=1)
    x, y, z = np.clip(np.floor(points[inside] * cells), 0, cells - 1).astype(int).T
    at = (z * cells[1] + y) * cells[0] + x
    unit = 2.0**-layout.space.length_exponent
    return t[inside], stored[at] * float(records["medium_0"]["sigma_t"]) * unit, above[at] * unit


@pytest.mark.parametrize("majorant", MAJORANTS)
def test_residual_ratio_is_never_worse_than_ratio(context: Context, majorant: str, rng: Rng) -> None:
    """The variance of one walk, against each other and against theory; values of voxels are those of lookups here."""
    values = (np.random.default_rng(8).random((4, 5, 6)) * 0.5 + 0.4).astype(np.float32)
    smooth = field_of(values, interpolation="nearest")
    kind = {"global": {"kind": "global"}, "grid": {"kind": "grid", "resolution": 2}}[majorant]
    layouts = {kind_: smooth.layout(1.0, majorant=kind, **asked("delta", kind_)) for kind_ in TRANSMITTANCES[:2]}
    found = {kind_: run(context, smooth, [layout], 4, rng) for kind_, layout in layouts.items()}
    for ray in range(len(ORIGIN)):
        t, control, residual = controls_along(smooth, layouts["residual_ratio"], ray)
        sigma_t = smooth.sigma_t(ray, t, 1.0)[0][:, 0]
        tau = float(sigma_t.sum()) * LONGEST / STEPS
        squares = {"ratio": sigma_t**2 / (control + residual), "residual_ratio": (sigma_t - control) ** 2 / residual}
        variances = []
        for kind_, each in squares.items():
            walks = found[kind_].through[0, 0, found[kind_].walk_ray == ray]
            right = float(RESIDUAL.variance(np.array(tau), each.sum() * LONGEST / STEPS))
            accept_mean((walks - np.exp(-tau)) ** 2, right, kind_, allowed=0.005 * right, exact=False)
            variances.append(walks.var())
        assert variances[1] < variances[0]


def test_decomposition_flies_as_delta_does_without_looking_up_what_it_knows(context: Context, rng: Rng) -> None:
    keys = {"majorant": MAJORANTS["grid"], "transmittance": {"kind": "ratio"}}
    layouts = [field("haze").layout(5.0, free_flight={"kind": kind}, **keys) for kind in FLIGHTS]
    delta, decomposition = (run(context, field("haze"), [layout], 4, rng) for layout in layouts)
    assert np.array_equal(delta.flown, decomposition.flown)
    # With all voxels empty the control alone is met, and by its own law.
    voxels = next(name for name in layouts[1].buffers if name.endswith("voxels"))
    blind = run(context, field("haze"), [changed(layouts[1], {voxels: 0})], 4, rng)
    bounds = field("haze").layout(5.0, **asked("decomposition", "residual_ratio"), majorant=keys["majorant"])
    for ray in range(len(ORIGIN)):
        _, control, _ = controls_along(field("haze"), bounds, ray)
        chance = float(module("tracking", "decomposition").survival(control.sum() * LONGEST / STEPS))
        flown = blind.flown[0][blind.flight_ray == ray]
        accept(binomtest(int((flown < 0).sum()), flown.size, chance).pvalue, exact=False)


# Pictures

BEAM: Kind = {"kind": "directional", "direction": [1, 0.3, 0.6], "irradiance": [4, 3, 2]}
CLOUD = field("cloud").grids["a"].values[:, ::2, ::2]


def cloud(grid: Grid, **keys: Any) -> Kind:
    return grid(CLOUD, scale=8, albedo=0.9, phase={"kind": "henyey_greenstein", "g": 0.6}, **keys)


@pytest.mark.parametrize("majorant", MAJORANTS)
@pytest.mark.parametrize("transmittance", TRANSMITTANCES)
@pytest.mark.parametrize("flight", FLIGHTS)
def test_all_combinations_agree(
    box: Scene, grid: Grid, picture: Picture, flight: str, transmittance: str, majorant: str
) -> None:
    scene = random_walk(box, volumes=[cloud(grid)], lights=[BEAM], film={"width": 16, "height": 16})
    asking = scene | asked(flight, transmittance) | {"majorant": MAJORANTS[majorant], "seed": 8}
    same(picture(scene, 2048), picture(asking, 2048), within=0.006, exact=False)


EVERYTHING: dict[str, Any] = {
    "surfaces": [{"kind": "sphere", "radius": 0.3, "center": [0.5, 0.5, 0.5], "material": {"kind": "null"}}],
    "lights": [BEAM, {"kind": "constant", "radiance": 0.3}],
    "film": {"width": 16, "height": 16},
    "orders": 1,
    "layers": ["transmittance", "optical_depth"],
}


@pytest.mark.parametrize(
    ("flight", "transmittance", "majorant"),
    [
        ("decomposition", "residual_ratio", "grid"),
        ("delta", "ray_marching", "global"),
        *(
            pytest.param(*combination, marks=pytest.mark.slow)
            for combination in itertools.product(FLIGHTS, TRANSMITTANCES, MAJORANTS)
        ),
    ],
)
def test_in_colour_with_other_media_and_surfaces(
    box: Scene, grid: Grid, picture: Picture, flight: str, transmittance: str, majorant: str
) -> None:
    """Beauty, orders, transmittance and optical depth, where grids in colour overlap each other and constant media."""
    volumes = [
        cloud(grid) | {"scale": [4, 2, 1], "emission": {"kind": "constant", "epsilon": [0.1, 0.2, 0.3]}},
        grid(noise(5, 4, 6, 3) + np.float32(0.5), albedo=[0.9, 0.5, 0.2], interpolation="nearest"),
        constant(cuboid(0.3, 1.1), [1, 0.5, 0.2], 0.8),
    ]
    scene = random_walk(box, volumes=volumes, **EVERYTHING)
    asking = scene | asked(flight, transmittance) | {"majorant": MAJORANTS[majorant], "seed": 8}
    default, film = picture(scene, 2048), picture(asking, 2048)
    same(default, film, within=0.02, exact=False)
    for layer in ("order.0", "order.1", "order.rest", "transmittance", "optical_depth"):
        pair = [each.layer(layer) for each in (default, film)]
        difference = pair[0].mean.mean(axis=(0, 1)) - pair[1].mean.mean(axis=(0, 1))
        variance = sum(each.variance().mean(axis=(0, 1)) / each.count.size for each in pair)
        accept_z(difference / np.sqrt(variance), layer, exact=False)


def test_kinds_are_named(box: Scene, grid: Grid) -> None:
    def kinds(**keys: Any) -> dict[str, tuple[str, ...]]:
        scene = random_walk(box, **keys)
        layout = lay_out(described(scene), lambda file, name: Values("x", CLOUD, np.eye(4), placed=False))
        return {concept: layout.kinds.get(concept, ()) for concept in ("free_flight", "transmittance")}

    ball = constant({"kind": "sphere", "center": [0.5, 0.5, 0.5], "radius": 0.4}, 1, 0.5)
    chosen = asked("decomposition", "ray_marching")
    assert kinds(volumes=[cloud(grid)], lights=[BEAM]) == {"free_flight": ("delta",), "transmittance": ("ratio",)}
    assert kinds(volumes=[cloud(grid), ball], lights=[BEAM], **chosen) == {
        "free_flight": ("analytic", "decomposition"),
        "transmittance": ("exact", "ray_marching"),
    }
    # Nothing asks what gets through; and constant media have closed forms whatever is asked for.
    assert kinds(volumes=[cloud(grid)], **chosen) == {"free_flight": ("decomposition",), "transmittance": ()}
    assert kinds(volumes=[ball], lights=[BEAM], **chosen) == {"free_flight": ("analytic",), "transmittance": ("exact",)}
