"""Pixel filters against their float64 oracles: box, tent, gaussian."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.kernels.device_code import call

from woodcock.device import Context
from woodcock.layout import module
from woodcock.scene import BoxFilter, GaussianFilter, TentFilter

#: Filters and how far they reach.
FILTERS = [(BoxFilter(radius=1.25), 1.25), (TentFilter(radius=1.5), 1.5), (GaussianFilter(deviation=0.4), 1.6)]
filters = pytest.mark.parametrize(("pixel_filter", "extent"), FILTERS, ids=["box", "tent", "gaussian"])
#: The lattice's ends, its middle, and 2^12 steps across it.
U = np.sort(np.concatenate([[0, 2.0**-24, 0.5, 1 - 2.0**-24], (np.arange(4096) + 0.5) / 4096])).astype(np.float32)


@filters
def test_offsets_and_densities(context: Context, lanes: int, pixel_filter: Any, extent: float) -> None:
    """Offsets invert the distribution function, so samples follow the density."""
    name, kind = f"filter_{pixel_filter.kind}", module("filter", pixel_filter.kind)
    probes = np.linspace(-1.1 * extent, 1.1 * extent, U.size, dtype=np.float32)
    expressions = [f"{name}_offset(kind, u)", f"{name}_pdf(kind, x)", f"{name}_offset(kind, 1.f - u)"]
    got = call(
        context, "filter", pixel_filter, kind.record(pixel_filter), "", expressions, {"u": U, "x": probes}, lanes
    )
    offset, density, mirrored = got.astype(np.float64)
    assert np.allclose(kind.cumulative(pixel_filter, offset), U, rtol=0, atol=2e-7)
    assert (np.diff(offset) >= 0).all()
    assert np.abs(offset).max() == pytest.approx(extent, rel=1e-3)
    assert np.abs(offset).max() <= extent * (1 + 1e-6)
    assert np.allclose(offset, -mirrored, rtol=0, atol=1e-6)
    assert np.allclose(density, kind.density(pixel_filter, probes.astype(float)), rtol=3e-6, atol=1e-6)


@filters
def test_density_is_the_slope_of_the_distribution(pixel_filter: Any, extent: float) -> None:
    """The oracle itself: it integrates to 1, to its own distribution function, and is no negative weight."""
    kind = module("filter", pixel_filter.kind)
    edges = np.linspace(-extent, extent, 20001)
    density = kind.density(pixel_filter, (edges[1:] + edges[:-1]) / 2)
    assert (density >= 0).all()
    assert np.allclose(np.cumsum(density) * (edges[1] - edges[0]), kind.cumulative(pixel_filter, edges[1:]), atol=1e-7)
    assert kind.cumulative(pixel_filter, np.array([-2 * extent, 0, 2 * extent])) == pytest.approx([0, 0.5, 1])
