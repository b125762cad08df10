"""Cases that hang or crash are rows; the others go on."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import pytest
from tests.stability.fakes import CASES, passes
from typer import Typer
from typer.testing import CliRunner

from woodcock.device import Device
from woodcock.stability import children, command
from woodcock.stability.case import Case
from woodcock.stability.judging import Finding
from woodcock.stability.outcome import Row

FAKES = (sys.executable, str(Path(__file__).with_name("fakes.py")))


def rows(device: Device, cases: tuple[Case, ...] = CASES, timeout: float = 5.0) -> list[Row]:
    return list(children.supervised(cases, (*FAKES, device.id), timeout))


def test_what_hangs_crashes_or_lies_has_failed_and_the_others_have_not(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    found = rows(device)
    assert [row["case"] for row in found] == [case.name for case in CASES]
    assert {row["verdict"] for row in found if row["case"] == "passes"} == {"passed"}
    says = {row["case"]: row["says"] for row in found}
    assert says == {
        "passes": "",
        "hangs": "the case did not end within 5 s",
        "aborts": "the case was ended by SIGABRT: ld: cannot find -lgcc",
        "leaves": "the case ended its process with code 3: no message",
        "raises": "ValueError: a fault",
        "lies": "the picture is off by more than 4 roundings",
    }
    assert {row["verdict"] for row in found if row["says"]} == {"failed"}


def test_a_device_on_which_nothing_ends_is_given_up(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(children, "PATIENCE", 2)
    cases = tuple(Case("fakes", f"{n}", passes) for n in range(5))
    found = list(children.supervised(cases, (sys.executable, "-c", "raise SystemExit('no device')"), 5.0))
    assert [row["says"] for row in found[:2]] == ["the case ended its process with code 1: no device"] * 2
    assert all(row["says"].startswith("not tried: 2 cases in a row") for row in found[2:])
    assert len(found) == 5


def test_a_sweep_that_is_dropped_ends_its_child(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    sweep = children.supervised(CASES, (*FAKES, device.id), 60.0)
    next(sweep)  # the child hangs in its second case now
    began = time.perf_counter()
    sweep.close()  # type: ignore[attr-defined]
    assert time.perf_counter() - began < 5


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, device: Device):
    """Runs the command over these cases."""
    app = Typer()
    app.command()(command.stability)

    def invoke(cases: tuple[Case, ...], *arguments: str):
        monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
        monkeypatch.setattr(command, "CASES", cases)
        monkeypatch.setattr(command, "sweep", lambda device: iter([children.row_of(case, device) for case in cases]))
        return CliRunner().invoke(app, arguments)

    return invoke


def test_the_table_names_every_case(run) -> None:
    result = run(CASES[:1])
    assert result.exit_code == 0
    assert "passes" in result.output
    assert "100%" in result.output
    assert "1 passed" in result.output


def test_a_failed_case_is_said_and_is_the_exit_code(run) -> None:
    result = run((CASES[0], CASES[7]))
    assert result.exit_code == 1
    assert "1 passed, 1 failed" in result.output


def test_json_is_the_outcome(run, device: Device) -> None:
    fine = Case("fakes", "fine", lambda device, folder: Finding(1.0, 1.0, 0.0, "roundings", 4.0))
    result = run((fine, CASES[7]), "--json", "--device", device.id)
    outcome = json.loads(result.stdout)
    assert result.exit_code == 1
    assert (outcome["device"], outcome["name"], outcome["passed"]) == (device.id, device.name, False)
    assert [row["verdict"] for row in outcome["rows"]] == ["passed", "failed"]
    assert outcome["rows"][1]["deviation"] == 1e7


def test_an_unknown_device_is_bad_usage(run) -> None:
    result = run(CASES[:1], "--device", "gpu77")
    assert result.exit_code == 2
    assert "gpu77" in result.output
