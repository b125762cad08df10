"""Farms, and the scenes that they render."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.server.conftest import make_scene as make_scene

from .harness import Farm


@pytest.fixture
def farm(tmp_path: Path) -> Iterator[Farm]:
    """A scheduler on this machine; nothing else runs yet."""
    farm = Farm(tmp_path)
    farm.start_scheduler()
    yield farm
    farm.close()
