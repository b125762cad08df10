"""Emission: constant, grid and blackbody. The table of temperatures against Planck's integrals, these against published
chromaticities."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from tests.kernels.device_code import literal

from woodcock.device import Context
from woodcock.emission import blackbody, constant, grid
from woodcock.evaluate import evaluate
from woodcock.layout import Record
from woodcock.scene import BlackbodyEmission, GridEmission
from woodcock.space import Array, Space


def chromaticity(kelvin: float) -> Array:
    xyz = blackbody.tristimulus(np.array(kelvin))
    return np.asarray(xyz[:2] / xyz.sum())


@pytest.mark.parametrize(
    ("kelvin", "x", "y", "off"),
    [
        (1000, 0.6528, 0.3445, 0.016),  # where the fit's far red counts
        (2000, 0.5267, 0.4133, 0.004),
        (2855.6, 0.4476, 0.4074, 0.002),  # CIE illuminant A
        (6500, 0.3135, 0.3237, 0.001),
        (10000, 0.2807, 0.2884, 0.001),
        (1e9, 0.2399, 0.2342, 0.001),  # the end of the Planckian locus
    ],
)
def test_blackbody_has_the_published_chromaticity(kelvin: float, x: float, y: float, off: float) -> None:
    """Planckian locus, CIE 1931 (Wyszecki & Stiles 1982); the analytic observer meets it, best above 2500 K."""
    assert np.hypot(*(chromaticity(kelvin) - (x, y))) < off


def test_planck_is_integrated_exactly() -> None:
    def integrand(wavelength: float, kelvin: float, component: int) -> float:
        planck = 1 / np.expm1(blackbody.SECOND_CONSTANT / (wavelength * kelvin)) / (wavelength / 560) ** 5
        return float(planck * blackbody.observer(np.array(wavelength))[component])

    for kelvin in (800.0, 2500.0, 9000.0):
        found = blackbody.tristimulus(np.array(kelvin))
        for component in range(3):
            expected, _ = quad(integrand, 360, 830, (kelvin, component), epsrel=1e-10, limit=400)
            assert found[component] == pytest.approx(expected, rel=2e-5)


def test_luminance_is_that_of_the_reference() -> None:
    emission = BlackbodyEmission(kelvin=3000, reference=2500, luminance=4)
    rgb = blackbody.radiance(emission, np.array(2500.0))
    assert rgb @ [0.2126, 0.7152, 0.0722] == pytest.approx(4, rel=1e-3)
    assert np.array_equal(blackbody.radiance(emission, np.array([0.0, 1e-30])), np.zeros((2, 3)))
    ember = blackbody.radiance(emission, np.array(1200.0))
    assert ember[2] == 0 < ember[1] < ember[0]  # blue would be negative
    tinted = emission.model_copy(update={"luminance": (1.0, 2.0, 3.0)})
    assert np.allclose(
        blackbody.radiance(tinted, np.array(6000.0)) * 4 / [1, 2, 3], blackbody.radiance(emission, np.array(6000.0))
    )


@pytest.mark.parametrize(("kelvin", "largest"), [(800.0, 2.63), (1.0, 40000.0), (300.0, 1.0), (6500.0, 3.0)])
def test_blackbody_table_is_planck(context: Context, lanes: int, kelvin: float, largest: float) -> None:
    emission, space = BlackbodyEmission(kelvin=kelvin, reference=kelvin * largest), Space(radiance_exponent=3)
    table = blackbody.table(emission, largest, space)
    values = np.concatenate([np.linspace(0, largest, 500), largest * np.geomspace(1e-6, 1, 500), [0, largest]])
    values = np.minimum(values.astype(np.float32), np.float32(largest))
    step = 0.25
    record = Record("emission", "blackbody", "kind", blackbody.FIELDS, blackbody.record(emission, largest, step, table))
    got = run(context, record, lanes, "emission_blackbody_radiance(&numbers, table, v)", values / step, table)
    expected = space.radiance(blackbody.radiance(emission, kelvin * values.astype(float)))
    brightest = expected.max(axis=1)
    assert np.all(np.abs(got.T - expected) <= 1e-4 * brightest[:, None] + 2e-8 * brightest.max())


def test_cold_grids_are_dark(context: Context) -> None:
    emission = BlackbodyEmission(kelvin=300)
    table = blackbody.table(emission, 0.0, Space())
    record = Record("emission", "blackbody", "kind", blackbody.FIELDS, blackbody.record(emission, 0.0, 1.0, table))
    got = run(context, record, 4, "emission_blackbody_radiance(&numbers, table, v)", np.zeros(8, np.float32), table)
    assert np.array_equal(got, np.zeros((3, 8)))


def test_constant_and_grid(context: Context, lanes: int) -> None:
    """In the device's units: a length of 4 scene units, radiance in eighths."""
    space = Space(length_exponent=2, radiance_exponent=3)
    values = np.linspace(0, 5, 40, dtype=np.float32)
    record = Record("emission", "constant", "kind", constant.FIELDS, constant.record(np.array([1.0, 2, 3]), space))
    got = run(context, record, lanes, "emission_constant_epsilon(&numbers)", values)
    assert np.array_equal(got.T, constant.epsilon((1, 2, 3), np.zeros((40, 3))) * 4 / 8)

    emission = GridEmission(file="x", scale=(0.5, 0.25, 2))
    record = Record("emission", "grid", "kind", grid.FIELDS, grid.record(emission, 0.5, space))
    got = run(context, record, lanes, "emission_grid_epsilon(&numbers, spectrum_of(v, v + 1.f, v + 2.f))", values / 0.5)
    stored = values[:, None] + np.array([0, 0.5, 1])
    assert np.allclose(got.T, grid.epsilon(emission, stored) * 4 / 8, rtol=1e-6)


def run(context: Context, record: Record, lanes: int, call: str, values: Array, table: Any = None) -> Array:
    """(3, n): a colour for every value v."""
    members = " ".join(f"{ctype} {name};" for name, ctype in record.fields.items())
    parts = [
        *("core/rng.h", "core/vector.h", "core/spectrum_3.h"),
        f"struct {record.struct} {{ {members} }};\n",
        f"emission/{record.kind}.h",
        f"__constant struct {record.struct} numbers = {literal(record, 3)};\n",
    ]
    return evaluate(
        context,
        [f"spectrum_channel(found, {channel})" for channel in range(3)],
        {"v": values.astype(np.float32)},
        lanes=lanes,
        parts=parts,
        buffers={} if table is None else {"table": table.astype(np.float32).reshape(-1)},
        body=f"spectrum found = {call};",
    )
