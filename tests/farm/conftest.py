"""Farms, and the scenes that they render."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.server.conftest import make_scene as make_scene
from tests.server.conftest import s3 as s3

from .harness import Farm, on_hosts
from .network import Network, fault


@pytest.fixture
def farm(tmp_path: Path) -> Iterator[Farm]:
    """A scheduler on this machine; nothing else runs yet."""
    farm = Farm(tmp_path)
    farm.start_scheduler()
    yield farm
    farm.close()


@pytest.fixture
def network() -> Iterator[Network]:
    """The hosts head, on which the test is, and node1 to node4, which cannot be had everywhere."""
    if reason := fault():
        pytest.skip(f"separate hosts cannot be had here: {reason}")
    network = Network("head", *(f"node{number}" for number in range(1, 5)))
    with network.made(), network.being("head"):
        yield network


@pytest.fixture
def hosts(tmp_path: Path, network: Network) -> Iterator[Farm]:
    farm = on_hosts(tmp_path, network)
    yield farm
    farm.close()
