"""The studies beside the kernels: what the page on stiff rays says is so, and is what a run says."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.statistics import accept_z

from studies.stiff import device as ours
from studies.stiff.measure import OURS, Effort, Numbers, foil, orders, relative, stability, stepped
from studies.stiff.methods import METHODS, radau, solve
from studies.stiff.page import row, stability_table
from studies.stiff.problems import Problem, constant, foils, jumps, layers, ramp, slab, transparent
from woodcock.device import Device

FOLDER = Path(__file__).parents[2] / "kernels" / "studies"
PROBLEMS = [constant(1e-2), constant(1e8), jumps(), foils(2.0**-16), ramp()]
NAMES = [f"{problem.name}-{problem.sigma.max():.0e}" for problem in PROBLEMS]


@cache
def classical() -> Numbers:
    """What needs no device, by few steps."""
    numbers = Numbers(Effort(steps=tuple(2**k + 1 for k in range(13))), "", "")
    stability(numbers)
    orders(numbers)
    return numbers


@cache
def reference(problem: Problem) -> float:
    return radau(problem, 1e-9)[0]


@pytest.mark.parametrize("problem", [*PROBLEMS, transparent(0.0), transparent(1e-8)], ids=lambda p: p.name)
def test_radau_and_closed_forms_agree(problem: Problem) -> None:
    assert relative(radau(problem, 1e-9)[0], problem) < 1e-8


def test_explicit_methods_blow_up_beyond_their_limits() -> None:
    problem, sigma = constant(1e4), 1e4
    for method, limit in (("explicit Euler", 2.0), ("RK4", 2.785)):
        below, above = (
            relative(solve(method, problem, round(sigma / (limit * by)))[0], problem) for by in (0.95, 1.05)
        )
        assert below < 1e-9, method
        assert above > 1e20, method
    assert max(classical().stability["implicit Euler"]) < 1e-9


def test_orders_are_lost_at_jumps() -> None:
    found = classical().orders
    smooth = {method: found["constant, σ_t = 1"][method] for method in METHODS}
    assert smooth.pop("ray marching, opacity") == np.inf
    assert smooth == pytest.approx({"explicit Euler": 1, "RK4": 4, "implicit Euler": 1, "ray marching": 1}, abs=0.1)
    assert found["ramp"]["ray marching, opacity"] == pytest.approx(2, abs=0.2)
    assert found["jumps"]["ray marching, opacity"] == pytest.approx(1, abs=0.1)
    assert found["foils, h above their width"]["implicit Euler"] == pytest.approx(0, abs=0.05)


@pytest.mark.parametrize("problem", PROBLEMS, ids=NAMES)
def test_the_kernel_keeps_its_bound_at_few_evaluations(device: Device, problem: Problem) -> None:
    """Against Radau, whatever the stiffness and the jumps; Radau needs more, and fixed steps a million."""
    most = {"constant": 10, "jumps": 20, "foils": 130, "ramp": 500}[problem.name]
    for tolerance in (1e-1, 1e-6):
        found = ours.emission_absorption(device, problem, tolerance)
        right = reference(problem)
        assert abs(found.value - right) <= found.error + 1e-8 * right
        assert found.error <= tolerance * right
        assert found.evaluations <= most


def test_the_kernel_keeps_the_digits_of_thin_media(device: Device) -> None:
    for sigma in (1e-8, 1e-16, 0.0):
        assert stepped(transparent(sigma), device, 1e-4).error < 1e-6
        with np.errstate(invalid="ignore"):
            naive = (1 - np.exp(-np.float32(sigma))) / np.float32(sigma)
        assert not abs(naive - 1) < 0.9


def test_estimators_fall_with_the_root_of_the_paths(device: Device) -> None:
    for problem in (constant(1e-2), constant(1e2), constant(1e8)):
        few, many = (ours.volumetric_path(device, problem, samples) for samples in (8, 128))
        assert many.error < 2e-2 * many.value
        if problem.sigma.max() > 10:
            assert many.value == pytest.approx(problem.exact(), rel=1e-6)  # one temperature: every collision tells it
        else:
            accept_z((many.value - problem.exact()) / many.error, problem.name)
            assert few.error / many.error == pytest.approx(4, rel=0.3)
        assert many.evaluations == 2 * many.samples


@pytest.mark.parametrize("sigma", [1e4, 1e8])
def test_an_opaque_glow_is_seen_through_a_clear_half(device: Device, sigma: float) -> None:
    """Also where a mean free path is less than float32 adds to the distance."""
    media = [slab(0, 0.5, 1e-3, 1e-3), slab(0.5, 1, sigma, sigma)]
    problem = layers("behind", [0, 0.5, 1], [1e-3, sigma], [1e-3, sigma], lambda folder: media)
    found = ours.volumetric_path(device, problem, 64)
    accept_z((found.value - problem.exact()) / found.error)
    assert found.error < 5e-3


@pytest.mark.parametrize("width", [2.0**-12, 2.0**-24])
def test_clocks_ring_in_thin_foils(device: Device, width: float) -> None:
    problem = foils(width)
    found = ours.volumetric_path(device, problem, 64)
    accept_z((found.value - problem.exact()) / found.error)


def test_ratio_tracking_sees_thin_foils(device: Device) -> None:
    for cells in (16, 4096):
        problem = foil(cells)
        found = ours.volumetric_path(device, problem, 32, layer="transmittance", majorant=256)
        accept_z((found.value - problem.exact()) / found.error, f"{cells} cells")
        assert found.error < 5e-3


def test_short_steps_do_not_vanish(device: Device) -> None:
    assert ours.advanced(device, 100_000, 1e-8, compensated=False) == 0.5
    assert ours.advanced(device, 100_000, 1e-8, compensated=True) == pytest.approx(0.501, rel=1e-7)


def test_counting_changes_no_picture(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    counted = ours.emission_absorption(device, jumps())
    monkeypatch.setattr(ours, "STEPS", {})
    plain = ours.emission_absorption(device, jumps())
    assert counted[:2] == plain[:2]
    assert plain.evaluations == 0


def test_the_page_is_of_this_run(device: Device) -> None:
    """It names all methods and problems, and has the numbers of those that are quickly run again."""
    text = (FOLDER / "stiff_ode.md").read_text()
    for name in (*METHODS, "Radau", OURS, "delta", "ratio", *(problem.name for problem in PROBLEMS)):
        assert name in text
    assert stability_table(classical()) in text
    assert (FOLDER / "stiff_ode.svg").read_text().startswith("<?xml")
    if device.doubles:
        for problem in (jumps(), foils(2.0**-16), ramp()):
            assert " | ".join(row(OURS, 1e-1, stepped(problem, device, 1e-1))) in text
