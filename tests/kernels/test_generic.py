"""The program with everything switched on gives the pictures that a scene's own program gives, and is one program."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import t
from tests import statistics
from tests.analytic.scenes import (
    PHASES,
    ROUNDING,
    Grid,
    Kind,
    Scene,
    affine,
    balance,
    ball,
    constant,
    cube_mesh,
    cuboid,
    noise,
    picture_of,
    random_walk,
    rectangle,
)
from tests.conftest import described

from woodcock.device import Context, Device
from woodcock.film import Film
from woodcock.generic import fields, gain, generic_layout, is_generic, measure_gain, widen
from woodcock.generic.gain import PAIRS, compared
from woodcock.generic.slots import kinds as kinds_of
from woodcock.generic.whole import KINDS
from woodcock.layers import SUFFIXES
from woodcock.plan import lay_out
from woodcock.program import OPTIONS, compose, file_of
from woodcock.render import Renderer, read_file
from woodcock.scene import Camera, Emission, Filter, Light, Material, Phase, Shape, Surface, Volume

#: A scene of a box, what is said of grids, a folder for files -> what is changed in it.
Change = Callable[[Grid, Path], Scene]

GLASS: Kind = {"kind": "dielectric", "ior": 1.4}
FROSTED: Kind = {"kind": "rough_dielectric", "ior": 1.4, "roughness": 0.4}
WHITE: Kind = {"kind": "diffuse", "reflectance": [0.8, 0.7, 0.6]}
LAMP: Kind = {"kind": "emissive", "radiance": [3, 2, 1]}
SUN: Kind = {"kind": "sun", "direction": [0.3, -0.5, 1], "irradiance": 2, "angular_radius": 5}
BEAM: Kind = {"kind": "directional", "direction": [1, 0.3, 0.6], "irradiance": [4, 3, 2]}
POINT: Kind = {"kind": "point", "position": [1.2, 0.3, 0.2], "intensity": [0.5, 0.3, 0.2]}
SPOT: Kind = {"kind": "spot", "position": [0.4, -0.3, 0.1], "target": [0.5, 0.6, 0.5], "intensity": 0.7, "cutoff": 40}
SKY: Kind = {"kind": "constant", "radiance": 0.5}
EYE: Kind = {"origin": [0.3, 0.2, -1.5], "target": [0.5, 0.5, 0.5], "up": [0, -1, 0]}
TURNED = affine([0.5, 0.2, 0], [-0.2, 0.6, 0.1], [0.1, -0.1, 0.7], [0.3, 0.2, 0.2])
FORWARD: Kind = {"kind": "henyey_greenstein", "g": 0.6}


def clouds(grid: Grid, folder: Path) -> Scene:
    """Fields of every storage, of numbers and of colours, apart from each other and of media that they overlap."""
    warm = np.linspace(0.5, 1, 24, dtype=np.float32).reshape(2, 3, 4)
    fire = {"kind": "blackbody", "file": grid(warm)["file"], "grid": "density", "kelvin": 3000}
    tint = {"file": grid(noise(2, 2, 3, 3, seed=5))["file"]}
    glow = {"kind": "grid", "file": grid(noise(3, 3, 3))["file"], "scale": [0.2, 0.1, 0.05]}
    counts = np.arange(60, dtype=np.uint8).reshape(3, 4, 5)
    return {
        "volumes": [
            grid(noise(5, 4, 6, 3), scale=[2, 3, 4], albedo=[0.9, 0.8, 0.7], albedo_grid=tint, phase=FORWARD),
            grid(counts, scale=0.05, to_world=TURNED, interpolation="nearest", emission=glow),
            grid(noise(4, 4, 4).astype(np.float16), to_world=TURNED, emission=fire),
            constant(ball(), [1, 0.5, 2], 0.9, emission={"kind": "constant", "epsilon": 0.1}),
            constant(cuboid(0.4, 0.8), 1, 0.2, emission={"kind": "blackbody", "kelvin": 2500, "luminance": 0.5}),
        ],
        "surfaces": [rectangle([0.4, 0, 0.1], [0, 0.4, 0.1], [0.5, 0.5, 1.2], WHITE)],
        "majorant": {"kind": "grid", "resolution": 4},
        "lights": [SKY, POINT, SUN],
        "camera": {"kind": "thin_lens", "aperture_radius": 0.05, "fov": 40, **EYE},
        "film": {"width": 24, "height": 20, "filter": {"kind": "gaussian"}},
        "orders": 2,
        "layers": list(SUFFIXES),
    }


def room(grid: Grid, folder: Path) -> Scene:
    """Primitives, materials and phase functions of every kind, a mesh full of a medium, and all lights."""
    mesh = {"file": cube_mesh(folder), "to_world": affine([0.3, 0, 0], [0, 0.3, 0], [0, 0, 0.3], [0.6, 0.1, 0.5])}
    disk = {"kind": "disk", "center": [0.5, -0.2, 0.5], "normal": [0, 1, 0], "radius": 0.2, "material": LAMP}
    sky = np.random.default_rng(4).random((4, 8, 3))
    return {
        "volumes": [
            constant(cuboid(-0.3, 1.3), 0.8, 0.9, phase=PHASES["mixture"]),
            constant({"kind": "mesh", **mesh}, [4, 6, 8], [0.9, 0.8, 0.7], phase=PHASES["tabulated"]),
        ],
        "surfaces": [
            rectangle([1, 0, 0], [0, 0, 1], [0.5, 1.2, 0.5], WHITE),
            rectangle([0.3, 0, 0], [0, 0.3, 0], [0.5, 0.5, 1.1], {"kind": "mirror", "reflectance": 0.8}),
            {**ball((0.3, 0.8, 0.5), 0.2), "material": GLASS},
            {**ball((0.8, 0.8, 0.3), 0.15), "material": FROSTED},
            {**ball((0.2, 0.2, 0.3), 0.1), "material": {"kind": "emissive", "radiance": 2, "two_sided": True}},
            {**ball((0.5, 0.5, 0.2), 0.1), "material": {"kind": "null"}},
            disk,
            {"kind": "mesh", **mesh, "material": FROSTED},
        ],
        "lights": [SKY, SKY, POINT, SPOT, BEAM, SUN, {"kind": "image", "file": picture_of(folder, sky)}],
        "camera": {"kind": "perspective", "fov": 50, **EYE},
        "film": {"width": 24, "height": 24, "filter": {"kind": "tent"}},
    }


#: What each changes in a white box.
SCENES: dict[str, Change] = {
    "clouds": clouds,
    "room": room,
    "grey": lambda grid, folder: {
        "volumes": [constant(cuboid(), 2, 0.9, phase=PHASES["rayleigh"])],
        "lights": [SKY],
        "orders": 1,
        "layers": ["transmittance", "depth"],
    },
    "points": lambda grid, folder: {
        "volumes": [
            constant(ball(), 4, 0.9, phase=PHASES["draine"]),
            constant(cuboid(0.3, 1.1), [3, 1, 0], [0.9, 0.5, 0.8], phase=PHASES["two_lobe"]),
        ],
        "lights": [POINT, SPOT, BEAM],
        "camera": {"kind": "spherical", **EYE, "origin": [0.4, 0.5, 0.6], "target": [0.5, 0.5, 1.5]},
    },
    "cloud": lambda grid, folder: {"volumes": [grid(noise(4, 5, 6), scale=8, albedo=0.95)], "lights": [SKY, BEAM]},
    # Flights through grids have no second vertex.
    "veiled": lambda grid, folder: {
        "volumes": [grid(noise(4, 5, 6), scale=6, albedo=0.2), constant(ball(), 2, 0.9)],
        "lights": [POINT],
    },
    "shine": lambda grid, folder: {
        "volumes": [],
        "surfaces": [
            rectangle([0.5, 0, 0], [0, 0.5, 0], [0.5, 0.5, 0.9], WHITE),
            {**ball((0.7, 0.2, 0.2), 0.1), "material": LAMP},
        ],
        "lights": [],
    },
    "beam": lambda grid, folder: {
        "volumes": [
            constant(cuboid(), 3, [0.9, 0.8, 0.5], phase={"kind": "two_lobe", "g1": 1, "g2": -0.3, "weight": 0.5})
        ],
        "lights": [SKY],
    },
    "absorbing": lambda grid, folder: {
        "volumes": [grid(noise(4, 5, 6), scale=[1, 2, 3], albedo=0.5, emission={"kind": "constant", "epsilon": 3})],
        "integrator": {"kind": "transmittance"},
    },
    "glowing": lambda grid, folder: {
        "volumes": [
            constant(ball(), 2, 0.3, emission={"kind": "blackbody", "kelvin": 2000}, phase=FORWARD | {"g": 1}),
            grid(noise(4, 5, 6), albedo=0.5, emission={"kind": "constant", "epsilon": 0.3}),
        ],
        "integrator": {"kind": "emission_absorption"},
    },
}
#: Of what a scene holds; all else are choices that keep its mean.
UNIONS = {
    "camera": Camera,
    "filter": Filter,
    "volume": Volume,
    "shape": Shape,
    "emission": Emission,
    "phase": Phase,
    "light": Light,
    "surface": Surface,
    "material": Material,
}
#: Every channel is to be known to so much of its mean, by so many samples.
WITHIN, SAMPLES = 0.04, 512
FAST = ("clouds", "room", "grey")
scenes = pytest.mark.parametrize("name", SCENES)


@pytest.fixture(scope="module")
def text() -> str:
    return compose(generic_layout(), 8).text


def scene_of(name: str, box: Scene, grid: Grid, folder: Path) -> Scene:
    return random_walk(box) | SCENES[name](grid, folder)


@pytest.mark.parametrize("name", [*FAST, *(pytest.param(n, marks=pytest.mark.slow) for n in SCENES if n not in FAST)])
def test_the_picture_is_the_same(device: Device, box: Scene, grid: Grid, tmp_path: Path, name: str) -> None:
    scene = described(scene_of(name, box, grid, tmp_path))
    lean, full = (
        Renderer(scene.model_copy(update={"seed": statistics.seed(seed)}), device, full=full).render(0, SAMPLES)
        for seed, full in ((7, False), (8, True))
    )
    same(full, lean)


def same(full: Film, lean: Film) -> None:
    """Accepts every channel's mean over the picture, and asserts that it is known well."""
    assert full.names == lean.names
    assert full.rejected == full.violations == lean.rejected == lean.violations == 0
    off, error = balance((1, full), (-1, lean))
    scale = np.abs(lean.mean).mean(axis=(0, 1))
    assert np.all(error <= WITHIN * scale), f"known to {error} of {scale} only"
    # Without noise a picture has a bound.
    allowed = ROUNDING * scale + (0 if lean.bound is None else lean.bound.mean(axis=(0, 1)))
    off = np.maximum(np.abs(off) - allowed, 0)
    z = np.divide(off, error, out=np.where(off > 0, np.inf, 0.0), where=error > 0)
    statistics.accept_z(z[0], "beauty", exact=bool(allowed[0] < statistics.NEGLIGIBLE * error[0]))
    statistics.accept_z(z, "all channels, which share their paths", exact=False)


@scenes
def test_one_program_fits_all(box: Scene, grid: Grid, tmp_path: Path, name: str, text: str) -> None:
    layout = widen(described(scene_of(name, box, grid, tmp_path)), read_file)
    assert is_generic(layout)
    assert compose(layout, 8).text == text


@pytest.mark.parametrize(
    "change",
    [{"lights": [POINT] * 17}, {"orders": 16}, {"volumes": [constant(cuboid(), 1, 0.5)] * 8}],
    ids=["lights", "orders", "volumes"],
)
def test_places_are_added_where_a_scene_needs_more(box: Scene, change: Scene) -> None:
    layout = widen(described(box | change), read_file)
    assert is_generic(layout) == ("volumes" in change)
    assert layout.offsets()[-1] == layout.pack().nbytes


def test_every_kind_is_in_it(text: str) -> None:
    held = {(concept, kind) for concept, kinds in KINDS.items() for kind in kinds}
    assert {(concept, kind) for concept, union in UNIONS.items() for kind in kinds_of(union)} <= held
    # How a medium of either kind is looked up is written here.
    of_files = {kind for kind in held if kind[0] not in ("integrator", "volume", "storage")}
    assert not [kind for kind in of_files if f'#line 1 "{file_of(*kind)}"' not in text]
    assert not [storage for storage in KINDS["storage"] if f"volume/field_{storage}.h" not in text]


def test_a_scene_s_own_program_is_not_the_generic_one(box: Scene) -> None:
    assert not is_generic(lay_out(described(box), read_file))


@pytest.mark.slow
def test_chunks(box: Scene, grid: Grid, device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fields beyond a buffer's size are found wherever they have been cut."""
    volumes = [
        grid(noise(12, 9, 10), albedo=0.9, scale=4),
        grid(noise(5, 5, 5, 3), albedo=0.5),
        grid(np.arange(1000, dtype=np.uint8).reshape(10, 10, 10), albedo=0.7, scale=0.02),
    ]
    scene = described(box | {"volumes": volumes})
    whole = Renderer(scene, device, full=True).render(0, 4)
    monkeypatch.setattr(fields, "CHUNK", 1 << 12)
    assert not is_generic(widen(scene, read_file))
    assert np.array_equal(Renderer(scene, device, full=True).render(0, 4).mean, whole.mean)


@pytest.mark.slow
def test_it_builds_without_a_warning(context: Context, lanes: int) -> None:
    context.build(compose(generic_layout(), lanes).text, (*OPTIONS, "-Werror"), "render")


@pytest.mark.slow
def test_it_has_a_twin_in_doubles(device: Device, box: Scene, grid: Grid, tmp_path: Path) -> None:
    if not device.doubles:
        pytest.skip(f"{device.name} has no doubles")
    found = Renderer(described(scene_of("clouds", box, grid, tmp_path)), device, full=True).drift()
    assert found is not None
    assert abs(found["relative"]) < 1e-3


# What leaving out gains


class Clock:
    """Time goes on by what a renderer takes for a sample, times the next of some factors."""

    def __init__(self) -> None:
        self.now = 0.0

    def renderer(self, seconds: float, factors: list[float]) -> Any:
        left = iter(factors)

        def render(start: int, stop: int) -> None:
            self.now += (stop - start) * seconds * next(left)

        view = SimpleNamespace(size=(4, 4), render=render)
        view.through = lambda width, height: view
        return view


def test_gain_is_the_mean_of_pairs_with_its_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock()
    monkeypatch.setattr("time.perf_counter", lambda: clock.now)
    noise_of = [np.exp(np.random.default_rng(seed).normal(0, 0.1, 100)).tolist() for seed in (1, 2)]
    # A launch to warm up, and one to be measured by, come before the pairs.
    lean, full = (clock.renderer(s, [1.0, 1.0, *factors]) for s, factors in zip((0.01, 0.03), noise_of, strict=True))
    gain = compared(lean, full)
    pairs = math.ceil(round((clock.now - 0.08) / 0.11, 1))
    assert pairs >= PAIRS
    logs = np.log(np.array(noise_of)[:, :pairs])
    ratios = math.log(3) + logs[1] - logs[0]
    low, high = t.interval(0.95, pairs - 1, ratios.mean(), ratios.std(ddof=1) / math.sqrt(pairs))
    assert [gain["ratio"], gain["low"], gain["high"]] == pytest.approx(np.exp([ratios.mean(), low, high]).tolist())
    assert [gain["lean"], gain["full"]] == pytest.approx(
        (np.array([0.01, 0.03]) * np.exp(logs.mean(axis=1)) / 16).tolist()
    )


def test_gain_of_a_ready_program(box: Scene, device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = described(box)
    lean = Renderer(scene, device)
    monkeypatch.setattr(gain, "is_built", lambda *_: True)
    found = measure_gain(lean, scene)
    assert found is not None
    assert 0 < found["low"] <= found["ratio"] <= found["high"]
    assert found["ratio"] == pytest.approx(found["full"] / found["lean"])
    monkeypatch.setattr(gain, "is_built", lambda *_: False)
    assert measure_gain(lean, scene) is None


@pytest.mark.parametrize("kept", ["full", "without random numbers", "files"])
def test_no_gain(box: Scene, grid: Grid, device: Device, monkeypatch: pytest.MonkeyPatch, kept: str) -> None:
    monkeypatch.setattr(gain, "is_built", lambda *_: True)
    monkeypatch.setattr(gain, "compared", lambda *_: pytest.fail("nothing is to be measured"))
    monkeypatch.setattr(gain, "LARGEST_FILES", 100)
    solved = {"integrator": {"kind": "transmittance"}} if kept == "without random numbers" else {}
    volumes = {"volumes": [grid(noise(4, 4, 4))]} if kept == "files" else {}
    scene = described(box | solved | volumes)
    assert measure_gain(Renderer(scene, device, full=kept == "full"), scene) is None
