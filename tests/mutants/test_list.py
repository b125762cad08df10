"""The list of sins fits the tree as it is; `make mutants` tells whether tests notice them."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.mutants.sin import ROOT, Sin
from tests.mutants.sins import SINS
from tests.mutants.verdict import is_assertion

from woodcock.device import DeviceError
from woodcock.scene import BoxShape, ConstantVolume
from woodcock.volume.media import Medium

sins = pytest.mark.parametrize("sin", SINS, ids=lambda sin: sin.name)


def test_sins_differ() -> None:
    assert len({sin.name for sin in SINS}) == len(SINS)
    assert len({(sin.file, sin.old, sin.new) for sin in SINS}) == len(SINS)


@sins
def test_its_line_is_there_once(sin: Sin) -> None:
    assert "\n" not in sin.old
    assert sin.new != sin.old
    assert sin.fault(ROOT) is None


@sins
def test_its_tests_are_there(sin: Sin) -> None:
    assert sin.tests
    for test in sin.tests:
        file, _, name = test.partition("::")
        assert f"def {name.partition('[')[0] or 'test_'}" in (ROOT / file).read_text(), test


def test_a_line_that_is_gone_is_told(tmp_path: Path) -> None:
    sin = Sin("a sin", "file.h", "t * 2.f", "t", ())
    (tmp_path / "file.h").write_text("t * 2.f;\n")
    sin.commit(tmp_path)
    assert (tmp_path / "file.h").read_text() == "t;\n"
    with pytest.raises(ValueError, match=r"a sin: file.h has 0 times"):
        sin.commit(tmp_path)


def test_only_an_assertion_of_a_test_counts() -> None:
    with pytest.raises(AssertionError) as own:
        assert len(SINS) == 0
    assert is_assertion(own, ROOT)
    with pytest.raises(pytest.fail.Exception) as vain, pytest.raises(ValueError, match="any"):
        pass
    assert is_assertion(vain, ROOT)
    with pytest.raises(pytest.fail.Exception) as late:
        pytest.fail("Timeout (>300.0s) from pytest-timeout.")
    assert not is_assertion(late, ROOT)
    with pytest.raises(DeviceError) as broken:
        raise DeviceError("cannot build the program")
    assert not is_assertion(broken, ROOT)
    volume = ConstantVolume(shape=BoxShape(min=(0, 0, 0), max=(1, 1, 1)), sigma_t=1, albedo=0)
    with pytest.raises(AssertionError) as of_the_program:
        Medium(volume).bounded()
    assert not is_assertion(of_the_program, ROOT)
