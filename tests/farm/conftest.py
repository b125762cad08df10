"""Farms, and the scenes that they render."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.server.conftest import make_scene as make_scene
from tests.server.conftest import s3 as s3

from .harness import Farm
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
    """The hosts head, node1 and node2, which cannot be had everywhere."""
    if reason := fault():
        pytest.skip(f"separate hosts cannot be had here: {reason}")
    network = Network("head", "node1", "node2")
    with network.made():
        yield network


@pytest.fixture
def hosts(tmp_path: Path, network: Network) -> Iterator[Farm]:
    """A farm on separate hosts, of which head has the scheduler."""
    farm = Farm(tmp_path, network.within)
    # A cable that is pulled out is noticed within 12 s, the least that Dask takes, not half a minute.
    farm.environment["DASK_DISTRIBUTED__COMM__TIMEOUTS__TCP"] = "12s"
    farm.environment["WOODCOCK_HOST"] = network.addresses["head"]
    farm.environment["WOODCOCK_INSECURE"] = "1"
    farm.start_scheduler(network.addresses["head"], port=8786)
    yield farm
    farm.close()
