"""Phase functions of several media in one program; and what of a phase function goes straight on."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter
from tests.conftest import Rng
from tests.kernels.phase_code import exactly_unit, run, unit_vectors
from tests.statistics import accept_counts

from woodcock.device import Context
from woodcock.layout import module
from woodcock.phase.compose import compose, delta_fraction, without_delta
from woodcock.scene import Phase

FORWARD = {"kind": "henyey_greenstein", "g": 0.8}
STEEP = {"kind": "tabulated", "cosine": [-1, 0.5, 1], "value": [1, 0, 9]}
BACK = {"kind": "tabulated", "cosine": [-1, -0.9, 0, 0.3, 1], "value": [5, 1, 1, 0, 0]}
STRAIGHT = {"kind": "henyey_greenstein", "g": 1}


def phase_of(description: dict[str, Any]) -> Any:
    return TypeAdapter(Phase).validate_json(json.dumps(description))


def mixture(*parts: tuple[float, dict[str, Any]]) -> dict[str, Any]:
    return {"kind": "mixture", "components": [{"weight": weight, "phase": phase} for weight, phase in parts]}


MEDIA = [
    phase_of(description)
    for description in (
        FORWARD,
        STEEP,
        mixture((1, BACK), (2, FORWARD), (1, STEEP), (1, {"kind": "mie_approx", "diameter": 10})),
        FORWARD,
        {"kind": "henyey_greenstein", "g": -0.5},
        BACK,
        mixture((3, {"kind": "rayleigh"}), (1, STEEP)),
        STEEP,
    )
]


def test_equal_phase_functions_are_one_instance() -> None:
    code = compose(MEDIA)
    assert [record.member for record in code.records] == [
        *("phase_0", "phase_1", "phase_2", "phase_2_0", "phase_2_1", "phase_2_2", "phase_2_3"),
        *("phase_3", "phase_4", "phase_5", "phase_5_0", "phase_5_1"),
    ]
    assert code.kinds == ("henyey_greenstein", "tabulated", "mixture", "mie_approx", "rayleigh")
    assert {record.concept for record in code.records} == {"phase"}
    assert list(code.buffers) == [f"phase_tabulated_{name}" for name in ("versine", "value", "cumulative")]


def test_one_phase_function_is_not_dispatched() -> None:
    assert "medium ==" not in compose([MEDIA[0], MEDIA[3]]).text
    assert "medium == 1" in compose(MEDIA[:2]).text


def test_numbers_do_not_change_the_text() -> None:
    droplets = {"kind": "mie_approx", "diameter": 20}
    other = phase_of(mixture((9, STEEP), (1, FORWARD), (2, BACK), (3, droplets)))
    a, b = compose([MEDIA[2]]), compose([other])
    assert (a.text, a.kinds) == (b.text, b.kinds)
    assert compose([phase_of(mixture((9, FORWARD), (1, STEEP), (2, BACK), (3, droplets)))]).text != a.text


def test_each_medium_has_its_own(context: Context, lanes: int, rng: Rng) -> None:
    """Lanes in lockstep that are in different media; a lane in none keeps its direction."""
    n = 1 << 16
    random = rng(5)
    index = random.integers(-1, len(MEDIA), n).astype(np.float32)
    u, v = random.random((2, n), dtype=np.float32)
    into, out = unit_vectors(n, 1), unit_vectors(n, 2)
    body = "vector s = phase_sample(world, medium, in, u, v);"
    results = ["phase_eval(world, medium, in, out)", "s.x", "s.y", "s.z"]
    inputs = {"index": index, "u": u, "v": v, "in": into, "out": out}
    density, *sampled = run(context, MEDIA, lanes, results, inputs, body)
    a, b, s = exactly_unit(into), exactly_unit(out), np.array(sampled, float)
    nowhere = index < 0
    assert np.array_equal(s[:, nowhere], into[:, nowhere])
    assert not density[nowhere].any()
    for i, phase in enumerate(MEDIA):
        here, kind = index == i, module("phase", phase.kind)
        right = kind.evaluate(phase, (a * b).sum(axis=0)[here])
        assert np.allclose(density[here], right, rtol=2e-5, atol=2e-7)
        share = np.clip(kind.cumulative(phase, (a * s).sum(axis=0)[here]), 0, 1)
        accept_counts(np.histogram(share, bins=32, range=(0, 1))[0], what=f"medium {i}")


@pytest.mark.parametrize(
    ("description", "fraction", "rest"),
    [
        (FORWARD, 0, FORWARD),
        ({"kind": "henyey_greenstein", "g": 0.9999}, 0, {"kind": "henyey_greenstein", "g": 0.9999}),
        (STRAIGHT, 1, {"kind": "isotropic"}),
        ({"kind": "two_lobe", "g1": 1, "g2": 0.8, "weight": 0.25}, 0.25, FORWARD),
        ({"kind": "two_lobe", "g1": 0.8, "g2": 0.99999, "weight": 0.25}, 0.75, FORWARD),
        ({"kind": "two_lobe", "g1": 1, "g2": 0.8, "weight": 0}, 0, FORWARD),
        ({"kind": "two_lobe", "g1": 1, "g2": 1, "weight": 0.3}, 1, {"kind": "isotropic"}),
        (mixture((1, STRAIGHT), (3, FORWARD)), 0.25, FORWARD),
        (mixture((1, STRAIGHT), (1, STRAIGHT), (1, STRAIGHT)), 1, {"kind": "isotropic"}),
        (mixture((1, BACK), (3, FORWARD)), 0, mixture((1, BACK), (3, FORWARD))),
        (
            mixture((1, BACK), (1, {"kind": "two_lobe", "g1": 1, "g2": 0.8, "weight": 0.5}), (2, STRAIGHT)),
            0.625,
            mixture((0.25, BACK), (0.125, FORWARD)),
        ),
    ],
)
def test_what_goes_straight_on_is_told_apart(description: Any, fraction: float, rest: Any) -> None:
    phase = phase_of(description)
    assert delta_fraction(phase) == fraction
    assert without_delta(phase) == phase_of(rest)
    assert delta_fraction(without_delta(phase)) == 0
    # The mean cosine is kept: f · 1 + (1 - f) g'.
    kind, left = module("phase", phase.kind), without_delta(phase)
    cosine = fraction + (1 - fraction) * module("phase", left.kind).mean_cosine(left)
    assert cosine == pytest.approx(kind.mean_cosine(phase), abs=1e-4)


def test_a_lobe_beyond_the_narrowest_is_finite(context: Context, lanes: int) -> None:
    """Were it not taken away before, it would be the narrowest that float32 can tell from a beam."""
    u, v = np.random.default_rng(1).random((2, 64), dtype=np.float32)
    into = unit_vectors(64, 3)
    body = "vector s = phase_sample(world, medium, in, u, v);"
    results = ["phase_eval(world, medium, in, s)", "vector_dot(in, s)"]
    density, cosine = run(context, [phase_of(STRAIGHT)], lanes, results, {"u": u, "v": v, "in": into}, body)
    assert np.all(np.isfinite(density))
    assert np.all(density > 0)
    assert np.median(cosine) > 1 - 1e-6
