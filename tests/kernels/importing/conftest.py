"""What the tests of importing share."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from woodcock.importing import Report, convert
from woodcock.scene import load

Import = Callable[..., tuple[dict[str, Any], list[str]]]


@pytest.fixture
def imported(tmp_path: Path) -> Import:
    """The scene that a text becomes, as JSON, and what was noted; it must load."""

    def run(text: str, name: str = "scene.xml") -> tuple[dict[str, Any], list[str]]:
        source, target, report = tmp_path / name, tmp_path / "out.json", Report()
        source.write_text(text)
        written = convert(source, target, report)
        load(target)
        assert written[0] == target
        assert all(path.is_file() and path.parent == tmp_path for path in written)
        scene: dict[str, Any] = json.loads(target.read_text())
        return scene, [str(note) for note in report.notes]

    return run
