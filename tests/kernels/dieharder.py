"""Dieharder (Brown, Eddelbuettel & Bauer), a battery of tests of random numbers, over a stream of words."""

from __future__ import annotations

import contextlib
import csv
import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.statistics import least

Words = Iterator[NDArray[np.uint32]]

#: A result below this is ambiguous: its test is repeated over fresh words.
AMBIGUOUS = 0.01


@dataclass(frozen=True)
class Test:
    """A test by dieharder's number, its tuple length where it has one, and how many p-values make one."""

    __test__ = False  # pytest would collect it

    number: int
    ntuple: int = 0
    p_samples: int = 1

    def options(self, times: int) -> list[str]:
        return ["-d", str(self.number), "-n", str(self.ntuple), "-p", str(self.p_samples * times)]


def require() -> None:
    """Skips a test where dieharder is missing; fails it where it must not be."""
    if shutil.which("dieharder"):
        return
    says = "dieharder is missing: apt install dieharder"
    if os.environ.get("WOODCOCK_REQUIRE_DIEHARDER"):
        pytest.fail(says)
    pytest.skip(says)


def p_values(test: Test, words: Words, times: int = 1) -> NDArray[np.float64]:
    """Of one test over as many words as it takes; two-sided, since words may be too even as well."""
    command = ["dieharder", "-g", "200", "-c", ",", "-D", "test_name", "-D", "pvalues", *test.options(times)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        assert process.stdin
        assert process.stdout
        assert process.stderr
        with contextlib.suppress(BrokenPipeError):  # it has read enough
            for piece in words:
                process.stdin.write(piece.astype("<u4", copy=False).data)
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        rows, complaints = process.stdout.read().decode().splitlines(), process.stderr.read().decode()
    assert process.returncode == 0, complaints
    p = np.array([float(p) for _, p in csv.reader(rows)])
    assert p.size, complaints
    return 2 * np.minimum(p, 1 - p)


def battery(tests: Sequence[Test], words: Words) -> tuple[float, str]:
    """The p-value of all tests together, each over words of its own, and which of them made it.

    A test's p-value is that of its least result (Šidák). Where it is ambiguous, the test is repeated over fresh words
    and four times as many, as dieharder's own mode to resolve ambiguity does: p = AMBIGUOUS × p of the repetition,
    which is uniform again. So the repetition is judged at AMBIGUOUS⁻¹ times the level that the tests have together.
    """
    found = []
    for test in tests:
        p = least(p_values(test, words))
        if p < AMBIGUOUS:
            p = AMBIGUOUS * least(p_values(test, words, times=4))
        found.append((p, f"dieharder -d {test.number} -n {test.ntuple}"))
    worst = min(found)
    return least([p for p, _ in found]), f"{worst[1]}: {worst[0]:.3g}"
