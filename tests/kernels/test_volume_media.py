"""What `volume/compose.py` writes for media, against float64 oracles: σ_t, albedo and ε of grids and constants, in
every storage, in chunks, side by side, in single and double precision."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter
from tests.conftest import Rng
from tests.kernels.media_code import ask
from tests.statistics import accept_mean

from woodcock.deterministic import lanes_of
from woodcock.device import Context
from woodcock.emission import blackbody, grid
from woodcock.formats import Grid, VolumeError
from woodcock.layout import module
from woodcock.scene import BlackbodyEmission, GlobalMajorant, GridEmission, GridMajorant, Majorant, Volume
from woodcock.space import Array, Space
from woodcock.volume.compose import compose
from woodcock.volume.media import Medium, read_media, strongest

GRIDS = module("volume", "grid")
RANDOM = np.random.default_rng(31)
#: (depth, height, width), none a multiple of a brick.
SHAPE = (9, 6, 5)


def noise(*shape: int, dtype: Any = np.float32) -> Grid:
    """A grid that nothing places: it fills the unit cube."""
    values = RANDOM.random(shape).astype(dtype)
    depth, height, width = shape[:3]
    return Grid("density", values, np.diag([1 / width, 1 / height, 1 / depth, 1]), placed=False)


FILES = {
    "smoke": noise(*SHAPE),
    "colours": noise(4, 3, 7, 3, dtype=np.float16),
    "bytes": Grid(
        "density", RANDOM.integers(0, 256, SHAPE).astype(np.uint8), np.diag([0.3, 0.2, 0.15, 1]), placed=True
    ),
    "heat": Grid("temperature", noise(5, 4, 3).values * 2, np.diag([0.21, 0.24, 0.13, 1]), placed=True),
    "dye": noise(3, 3, 3, 3),
}
TURNED = ((0.8, -0.6, 0, 1), (0.6, 0.8, 0.1, -2), (0, 0, 1.5, 0.25), (0, 0, 0, 1))


def read(file: str, name: str | None) -> Grid:
    return FILES[file]


def media_of(*volumes: dict[str, Any]) -> tuple[Medium, ...]:
    return read_media([TypeAdapter(Volume).validate_python(volume) for volume in volumes], read)


def points(medium: Medium, count: int = 600) -> tuple[Array, Array]:
    """Random points in a medium's local space, some outside and some on voxels' middles; and the same in the scene."""
    assert medium.density is not None
    size = np.array(medium.density.size)
    local = (RANDOM.random((count, 3)) * 1.2 - 0.1) * size
    local[:100] = np.floor(local[:100]) + 0.5
    local = local.astype(np.float32).astype(float)
    to_scene = medium.to_scene(medium.density)
    return local, local @ to_scene[:3, :3].T + to_scene[:3, 3]


def inputs(local: Array) -> dict[str, Any]:
    return {name: column.astype(np.float32) for name, column in zip("xyz", local.T, strict=True)}


def close(got: Any, expected: Any, tolerance: float = 3e-6) -> None:
    scale = np.abs(expected).max()
    assert np.allclose(got, expected, rtol=0, atol=tolerance * scale)


SPACE = Space(np.array([0.5, 0.25, 0.5]), 2, 3)
WORDS = "words w = {(word)0u, (word)0x80000400u, (word)0x80000000u, (word)0u};"


@pytest.mark.parametrize("precise", [False, True])
def test_one_grid_with_an_albedo_grid_and_temperatures(context: Context, lanes: int, precise: bool) -> None:
    lanes = lanes_of(lanes, precise=precise)
    (medium,) = media = media_of(
        {
            "kind": "grid",
            "file": "smoke",
            "albedo": 0.75,
            "scale": 4,
            "to_world": TURNED,
            "albedo_grid": {"file": "dye"},
            "emission": {"kind": "blackbody", "file": "heat", "kelvin": 900, "luminance": 3},
        }
    )
    composed = compose(media, SPACE, GlobalMajorant(), most_bytes=64 * 4 * 2)
    assert len([name for name in composed.buffers if name.startswith("medium_0_density")]) > 4  # in chunks
    local, scene = points(medium)
    body = f"{WORDS} spectrum epsilon = medium_0_emission(world, p), albedo = medium_0_albedo(world, p, w);"
    expressions = ["medium_0_sigma_t_exact(world, p)", "medium_0_sigma_t(world, p, w)"]
    expressions += [f"spectrum_channel({name}, {c})" for name in ("epsilon", "albedo") for c in range(3)]
    given = inputs(local)
    if precise:
        given = {name: column.astype(float) for name, column in given.items()}
    got = ask(context, composed, expressions, given, lanes, body=body, channels=3)

    size = np.array(SHAPE[::-1])
    sigma_t = GRIDS.density(medium.volume, FILES["smoke"], scene)
    inside = np.all((local > 0) & (local < size), axis=1)
    # Alone it is only asked for inside; there it is clamped.
    close(got[0][inside], np.ldexp(sigma_t, 2)[inside])
    nearest = FILES["smoke"].values[tuple(np.clip(np.floor(local), 0, size - 1).astype(int).T[::-1])]
    middles = np.arange(600) < 100
    close(got[1][middles], 16 * nearest[middles])
    albedo = 0.75 * GRIDS.interpolated(FILES["dye"], placed("dye"), scene)
    emission = medium.volume.emission
    assert isinstance(emission, BlackbodyEmission)
    kelvin = 900 * GRIDS.interpolated(FILES["heat"], placed("heat"), scene)
    epsilon = (sigma_t * (1 - albedo.T)).T * blackbody.radiance(emission, kelvin)
    close(got[2:5].T[inside], np.ldexp(epsilon, 2 - 3)[inside], 1e-4)
    one_tap = FILES["dye"].values.reshape(-1, 3) * 0.75
    away = np.linalg.norm(got[5:8].T[inside][:, None] - one_tap[None], axis=2).min(axis=1)
    assert np.all((away < 1e-5) | (np.abs(got[5:8].T[inside]).max(axis=1) == 0))


def placed(name: str) -> Array:
    return np.array(TURNED) @ FILES[name].index_to_world


def test_media_side_by_side(context: Context, lanes: int) -> None:
    first, second, _ = media = media_of(
        {"kind": "grid", "file": "colours", "albedo": 0.5, "scale": [1, 2, 3], "to_world": TURNED},
        {
            "kind": "grid",
            "file": "bytes",
            "albedo": [0.1, 0.2, 0.3],
            "interpolation": "nearest",
            "emission": {"kind": "grid", "file": "dye", "scale": [3, 2, 1]},
        },
        {
            "kind": "constant",
            "shape": {"kind": "sphere", "radius": 2},
            "sigma_t": 5,
            "albedo": 1,
            "emission": {"kind": "constant", "epsilon": 7},
        },
    )
    assert [medium.grey for medium in media] == [False, True, True]
    composed = compose(media, SPACE, GlobalMajorant())
    assert composed.kinds["storage"] == ("half", "uint8", "float")
    for index, medium in enumerate((first, second)):
        local, scene = points(medium)
        body = f"""{WORDS}
spectrum exact = medium_{index}_sigma_t_exact(world, p), tap = medium_{index}_sigma_t(world, p, w);
spectrum albedo = medium_{index}_albedo(world, p, w), epsilon = medium_1_emission(world, p);
spectrum constant_sigma_t = medium_2_sigma_t_exact(world, p), constant_epsilon = medium_2_emission(world, p);
"""
        names = ("exact", "tap", "albedo", "epsilon", "constant_sigma_t", "constant_epsilon")
        expressions = [f"spectrum_channel({name}, {c})" for name in names for c in range(3)]
        got = ask(context, composed, expressions, inputs(local), lanes, body=body, channels=3).reshape(6, 3, -1)
        sigma_t = GRIDS.density(medium.volume, medium.density.grid, scene)  # type: ignore[union-attr]
        sigma_t = np.ldexp(np.broadcast_to(sigma_t.T, (3, len(local))), 2)
        edge = np.abs(np.abs(local / np.array(medium.density.size) - 0.5) - 0.5).min(axis=1) < 1e-5  # type: ignore[union-attr]
        close(got[0][:, ~edge], sigma_t[:, ~edge])
        if index == 1:
            close(got[1][:, ~edge], sigma_t[:, ~edge])
            inside = np.any(sigma_t > 0, axis=0) & ~edge
            found = GRIDS.interpolated(FILES["dye"], FILES["dye"].index_to_world, scene, nearest=True)
            emission = medium.volume.emission
            assert isinstance(emission, GridEmission)
            close(got[3].T[inside], np.ldexp(grid.epsilon(emission, found), 2 - 3)[inside])
        close(got[2], np.broadcast_to(np.array(medium.volume.albedo).reshape(-1, 1), (3, len(local))))
        close(got[4:], np.array([20, 7 * 4 / 8]).reshape(2, 1, 1) * np.ones((2, 3, len(local))))


@pytest.mark.parametrize("what", ["density", "albedo"])
def test_one_tap_lookups_are_right_in_the_mean(context: Context, what: str, rng: Rng) -> None:
    (medium,) = media = media_of({"kind": "grid", "file": "smoke", "albedo": 1, "albedo_grid": {"file": "smoke"}})
    composed = compose(media, Space(), GlobalMajorant())
    local, scene = points(medium, 150)
    local, scene = local[100:] * 0.8 + 0.5, scene[100:]
    scene = local / SHAPE[::-1]
    repeats = 4000
    given = {name: column.repeat(repeats) for name, column in inputs(local).items()}
    words = rng(32).integers(0, 1 << 32, (2, len(given["x"])), np.uint32)
    given |= dict(zip("ab", words, strict=True))
    call = {"density": "medium_0_sigma_t", "albedo": "medium_0_albedo"}[what]
    (got,) = ask(context, composed, [f"{call}(world, p, w)"], given, 8, body="words w = {a, a, b, b};")
    taps = got.reshape(-1, repeats).astype(float)
    expected = GRIDS.interpolated(FILES["smoke"], FILES["smoke"].index_to_world, scene)
    inside = np.all((scene > 0) & (scene < 1), axis=1)
    assert inside.sum() > 20
    accept_mean(taps[inside], expected[inside], allowed=1e-7)


def test_a_medium_of_one_temperature(context: Context) -> None:
    media = media_of(
        {"kind": "grid", "file": "smoke", "albedo": 0.25, "emission": {"kind": "blackbody", "kelvin": 2500}},
        {
            "kind": "constant",
            "shape": {"kind": "sphere", "radius": 2},
            "sigma_t": 2,
            "albedo": 0.5,
            "emission": {"kind": "blackbody", "kelvin": 2500},
        },
    )
    composed = compose(media, SPACE, GlobalMajorant())
    local, _ = points(media[0], 64)
    body = "spectrum a = medium_0_emission(world, p), b = medium_1_emission(world, p);"
    body += "real s = medium_0_sigma_t_exact(world, p);"
    expressions = ["s", *(f"spectrum_channel({name}, {c})" for name in "ab" for c in range(3))]
    got = ask(context, composed, expressions, inputs(local), 1, body=body, channels=3)
    emission = media[0].volume.emission
    assert isinstance(emission, BlackbodyEmission)
    radiance = blackbody.radiance(emission, np.array(2500.0))
    close(got[1:4], 0.75 * got[0] * radiance[:, None] / 8)
    close(got[4:7], 4 * np.tile(radiance[:, None], got.shape[1]) / 8)
    assert strongest(media[1], 1e-3) == pytest.approx(1e-3 * radiance.max())
    assert strongest(media[1], 1e9) == pytest.approx(radiance.max())


def test_the_text_holds_what_the_scene_uses() -> None:
    plain = {"kind": "grid", "file": "smoke", "albedo": 0.5}
    alone = compose(media_of(plain), SPACE, GlobalMajorant())
    for absent in ("field_holds", "spectrum_of", "chunk", "emission", "there", "field_nearest"):
        assert absent not in alone.text
    assert alone.files == ["majorant/global_walk.h", "volume/field.h", "volume/field_float.h"]
    assert alone.kinds == {"majorant": ("global",), "volume": ("grid",), "storage": ("float",)}
    moved = compose(media_of(plain | {"scale": 7, "to_world": TURNED}), SPACE, GlobalMajorant())
    assert moved.text == alone.text
    constant = {"kind": "constant", "shape": {"kind": "sphere", "radius": 2}, "sigma_t": 5, "albedo": 1}
    assert not compose(media_of(constant), SPACE, GlobalMajorant()).files
    both = compose(media_of(plain, plain | {"file": "bytes"}, constant), SPACE, GlobalMajorant())
    assert both.text.count("field_holds") == 4
    assert [record.member for record in both.records] == [
        *("tracking", "majorant", "medium_0", "medium_0_density_field"),
        *("medium_1", "medium_1_density_field", "medium_2"),
    ]


def test_facts() -> None:
    media = media_of(
        {"kind": "grid", "file": "smoke", "albedo": 0, "scale": 2, "storage_error": 0.01},
        {"kind": "grid", "file": "colours", "albedo": [0, 0, 0.1]},
    )
    facts = compose(media, SPACE, GlobalMajorant()).facts["media"]
    stored = facts[0]["storage"]["density"]
    assert stored["kind"] == "uint8"
    assert 0 < stored["error"] <= 1 / 510 * (1 + 1e-6)
    assert facts[0]["sigma_t"][0] == pytest.approx(2 * FILES["smoke"].values.max(), rel=2e-3)
    assert not facts[0]["scatters"]
    assert facts[1]["scatters"]
    assert facts[1]["coloured"]
    assert not facts[1]["emits"]
    assert facts[1]["sigma_t"] == pytest.approx(FILES["colours"].values.max(axis=(0, 1, 2)).tolist())


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"albedo_grid": {"file": "bytes"}}, "bytes: grid 'density' holds albedos above 1, up to 25"),
        (
            {"emission": {"kind": "blackbody", "file": "dye", "kelvin": 1}},
            "dye: .* holds vectors; temperatures are num",
        ),
    ],
)
def test_files_of_something_else_are_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(VolumeError, match=message):
        media_of({"kind": "grid", "file": "smoke", "albedo": 0.5, **keys})


BLACK = {"kind": "grid", "file": "smoke", "albedo": 0.2}
SHINING = {"kind": "grid", "file": "smoke"}


@pytest.mark.parametrize("majorant", [GlobalMajorant(), GridMajorant(resolution=4)])
@pytest.mark.parametrize(
    ("volumes", "expected"),
    [
        ([BLACK | {"scale": 40, "emission": SHINING}], True),
        ([BLACK | {"scale": 0.5, "emission": SHINING}], False),
        ([BLACK | {"scale": 40, "emission": {"kind": "blackbody", "kelvin": 900}}], True),
        ([BLACK | {"scale": 40, "emission": SHINING}, BLACK | {"scale": 10}], True),
        ([BLACK | {"scale": 40}], False),
        ([BLACK | {"scale": 40, "emission": SHINING}, {"kind": "constant", "shape": {"kind": "sphere", "radius": 1},
          "sigma_t": 9, "albedo": 0, "emission": {"kind": "constant", "epsilon": 1}}], False),
    ],
)  # fmt: skip
def test_where_emission_is_dense(volumes: list[dict[str, Any]], expected: bool, majorant: Majorant) -> None:
    assert compose(media_of(*volumes), Space(), majorant, glow=True).dense_glow is expected


def test_emission_in_a_void_is_not_dense() -> None:
    """A plane of voxels that shines, and one of haze that is a third of the grid away."""
    haze, glow = np.zeros((2, 9, 1, 1), np.float32)
    haze[0], glow[8] = 1, 1
    placed = np.diag([1, 1, 1 / 9, 1])
    files = {name: Grid(name, values, placed, placed=False) for name, values in (("haze", haze), ("glow", glow))}
    volume: dict[str, Any] = {"kind": "grid", "file": "haze", "scale": 90, "albedo": 0}
    volume["emission"] = {"kind": "grid", "file": "glow"}
    media = read_media([TypeAdapter(Volume).validate_python(volume)], lambda file, name: files[file])
    assert not compose(media, Space(), GridMajorant(resolution=8), glow=True).dense_glow
    assert compose(media, Space(), GlobalMajorant(), glow=True).dense_glow
