"""The README's examples, run as they stand."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from woodcock_client import cli

if TYPE_CHECKING:
    from .service import Service

README = (Path(__file__).parents[2] / "client" / "README.md").read_text()


@pytest.fixture(autouse=True)
def _folder(scene_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(scene_file.parent)
    scene_file.rename("cloud.json")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_python(renders: Service, capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = blocks("python")
    exec(example.replace("http://127.0.0.1:8000", renders.url), {})
    assert capsys.readouterr().out.splitlines()[-1].startswith("succeeded 64 ")
    assert Path("cloud.exr").read_bytes() == renders.artifacts["job0000", "image.exr"]


def test_shell(renders: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WOODCOCK_SERVER", renders.url)
    for line in "".join(blocks("sh")).splitlines():
        monkeypatch.setattr("sys.argv", shlex.split(line))
        with pytest.raises(SystemExit) as caught:
            cli.main()
        assert caught.value.code == 0, line
    assert Path("cloud.report.json").exists()
