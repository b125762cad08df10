"""The channels of a picture: which there are, in which order, and in which units kernels write them."""

from __future__ import annotations

from typing import Any, get_args

import pytest
from tests.conftest import described

from woodcock.layers import SUFFIXES, exponents, is_radiance, layer_names
from woodcock.scene import LayerName


def test_every_layer_has_channels() -> None:
    assert set(SUFFIXES) == set(get_args(LayerName))


@pytest.mark.parametrize(
    ("channels", "asked", "names"),
    [
        (1, {}, "Y"),
        (3, {}, "R G B"),
        (1, {"orders": 1}, "Y order.0.Y order.1.Y order.rest.Y"),
        (3, {"orders": 0}, "R G B order.0.R order.0.G order.0.B order.rest.R order.rest.G order.rest.B"),
        (1, {"layers": ["depth", "albedo", "normal"]}, "Y depth.Z albedo.Y normal.X normal.Y normal.Z"),
        (3, {"layers": ["albedo", "transmittance"]}, "R G B albedo.R albedo.G albedo.B transmittance.Y"),
        (1, {"orders": 0, "layers": ["optical_depth"]}, "Y order.0.Y order.rest.Y optical_depth.Y"),
    ],
    ids=str,
)
def test_names_in_order(box: dict[str, Any], channels: int, asked: dict[str, Any], names: str) -> None:
    assert layer_names(described(box | asked), channels) == tuple(names.split())


def test_units(box: dict[str, Any]) -> None:
    names = layer_names(described(box | {"orders": 0, "layers": ["depth", "normal", "position", "optical_depth"]}), 1)
    assert exponents(names, 5, -3) == [5, 5, 5, -3, 0, 0, 0, 0, 0, 0, 0]
    assert [is_radiance(name) for name in names] == [True] * 3 + [False] * 8
