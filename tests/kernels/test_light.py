"""Lights against their float64 oracles: constant, directional."""

from __future__ import annotations

import numpy as np
from tests.kernels.device_code import call

from woodcock.device import Context
from woodcock.layout import module
from woodcock.scene import ConstantLight, DirectionalLight
from woodcock.space import Space

SPACE = Space(radiance_exponent=3)
INPUT = {"u": np.linspace(0, 1, 5, dtype=np.float32)}


def test_constant(context: Context, lanes: int) -> None:
    light = ConstantLight(radiance=2.5)
    kind = module("light", "constant")
    expression = "light_constant_radiance(kind, vector_of(u, u, u))"
    got = call(context, "light", light, kind.record(light, SPACE), "", [expression], INPUT, lanes)
    assert np.array_equal(got[0] * 8, kind.radiance(light, np.zeros((5, 3)))[:, 0])


def test_directional(context: Context, lanes: int) -> None:
    light = DirectionalLight(direction=(3, -4, 12), irradiance=7)
    kind = module("light", "directional")
    body = "spectrum weight; vector d = light_directional_sample(kind, &weight);"
    got = call(context, "light", light, kind.record(light, SPACE), body, ["d.x", "d.y", "d.z", "weight"], INPUT, lanes)
    assert np.allclose(got[:3].T, kind.towards(light), atol=1e-7)
    assert np.allclose(kind.towards(light), np.array([-3, 4, -12]) / 13)
    assert np.array_equal(got[3] * 8, np.full(5, 7))
