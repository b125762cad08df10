"""The certificate says of a film what its numbers say, fails where they are bad, and never passes without evidence."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from woodcock.batches import Batches
from woodcock.certificate import Line, certify
from woodcock.checks import Check
from woodcock.contract import Contract
from woodcock.convergence import Slope, Verdict
from woodcock.drift import Drift
from woodcock.faults import Faults
from woodcock.film import Film
from woodcock.report import Use

SAMPLES = 64
DRIFT: Drift = {"relative": 1e-7, "error": 1e-8, "largest": 1e-6, "turned": 0.0, "paths": 1000}
PASSED: Check = {
    "name": "darkness", "law": "Where nothing shines, every pixel is 0.", "status": "passed",
    "deviation": 0.0, "unit": "relative", "limit": 1e-4, "reason": "",
}  # fmt: skip


def use(**keys: Any) -> Use:
    evidence = {"options": ["-cl-std=CL1.2"], "drift": DRIFT, "checks": [PASSED]}
    given = {"id": "cpu0", "name": "x", "driver": "1", "program_hash": "a", "precision": "float"}
    return cast(Use, {**given, "kinds": {"majorant": ["grid"]}, "evidence": evidence} | keys)


def film(launches: int = 8, seed: int = 1, shared: float = 0.0, height: int = 48, width: int = 40) -> Film:
    """Of normal samples around 2; shared: how much of their deviation all pixels of a launch have in common."""
    random = np.random.default_rng(seed)
    whole = Film.empty(width, height, ("Y",))
    for launch in range(launches):
        own = random.standard_normal((SAMPLES, height, width, 1)) + shared * random.standard_normal()
        mean, start = own.mean(axis=0) + 2, launch * SAMPLES
        m2 = ((own - own.mean(axis=0)) ** 2).sum(axis=0)
        batches = Batches(1, 0.0, SAMPLES, float(mean.mean()))
        count = np.full((height, width), SAMPLES, np.uint32)
        whole = whole.merge(Film(count, mean, m2, ("Y",), ((start, start + SAMPLES),), batches=batches))
    return whole


CONTRACT: Contract = {"kind": "samples", "asked": 512, "reached": 512, "met": True, "says": "512 of 512 samples."}
SLOPE: Slope = {
    "slope": -0.5, "low": -0.6, "high": -0.4, "expected": -0.5, "points": 8, "verdict": "as expected",
    "says": "The error falls.", "against": None,
}  # fmt: skip


def line(
    name: str,
    picture: Film,
    *uses: Use,
    orders: dict[str, Any] | None = None,
    slope: Slope = SLOPE,
    contract: Contract = CONTRACT,
) -> Line:
    found = certify(picture, uses or (use(),), orders, slope, contract)
    json.dumps(found, allow_nan=False)
    (one,) = (each for each in found["lines"] if each["name"] == name)
    assert (name in found["failed"]) == (one["status"] == "failed")
    assert (name in found["not_checked"]) == (one["status"] == "not checked")
    return one


def test_launches_know_the_error_of_the_mean() -> None:
    """As the variances of 8 × 64 samples of 48 × 40 pixels: 1 / √983040."""
    many = film(launches=60)
    said = line("standard error", many)
    assert said["status"] == "passed"
    assert said["values"]["launches"] == 60
    assert said["values"]["by_variances"] == pytest.approx((60 * SAMPLES * 48 * 40) ** -0.5, rel=0.01)
    assert said["values"]["by_launches"] == pytest.approx(said["values"]["by_variances"], rel=0.3)


def test_launches_that_differ_too_much_fail() -> None:
    """What all pixels of a launch share, the variances of the pixels do not see."""
    said = line("standard error", film(shared=0.01))
    assert said["status"] == "failed"
    assert "not independent" in said["says"]


@pytest.mark.parametrize(
    ("verdict", "status"), [("as expected", "passed"), ("flagged", "failed"), ("not known", "not checked")]
)
def test_convergence_is_the_verdict_on_the_slope(verdict: Verdict, status: str) -> None:
    said = line("convergence", film(), slope={**SLOPE, "verdict": verdict})
    assert (said["status"], said["says"]) == (status, "The error falls.")
    assert said["values"] == {"slope": -0.5, "low": -0.6, "high": -0.4, "expected": -0.5, "points": 8}


def test_nothing_converges_without_noise() -> None:
    still = replace(film(), bound=np.ones((48, 40, 1)))
    assert line("convergence", still, slope={**SLOPE, "verdict": "not known"})["status"] == "stated"


@pytest.mark.parametrize(
    ("met", "reached", "status"), [(True, 512, "passed"), (False, 511, "failed"), (False, None, "not checked")]
)
def test_a_contract_is_met_or_missed(met: bool, reached: float | None, status: str) -> None:
    said = line("contract", film(), contract={**CONTRACT, "met": met, "reached": reached})
    assert (said["status"], said["values"]) == (status, {"kind": "samples", "asked": 512, "reached": reached})


def test_one_launch_tells_nothing() -> None:
    assert line("standard error", film(launches=1))["status"] == "not checked"


def test_launches_are_compared_with_pixels_that_have_more_samples() -> None:
    """Nine in ten pixels have a hundred times the samples: launches know nothing of it, and still agree."""
    whole = film(launches=60)
    more = np.ones((48, 40), np.uint32)
    more[:, 4:] = 100
    m2 = whole.m2 * (whole.count * more - 1)[..., None] / (whole.count - 1)[..., None]
    said = line("standard error", replace(whole, count=whole.count * more, m2=m2))
    assert said["status"] == "passed"
    assert said["values"]["by_variances"] == pytest.approx((60 * SAMPLES * 48 * 40 / 0.109) ** -0.5, rel=0.01)
    assert said["values"]["by_launches"] == pytest.approx(said["values"]["by_variances"], rel=0.3)
    shared = film(shared=0.01)
    m2 = shared.m2 * (shared.count * more - 1)[..., None] / (shared.count - 1)[..., None]
    assert line("standard error", replace(shared, count=shared.count * more, m2=m2))["status"] == "failed"


def test_batches_do_not_depend_on_the_order_of_merging() -> None:
    parts = [film(launches=1, seed=seed) for seed in range(5)]
    parts = [replace(part, ranges=((i * 100, i * 100 + SAMPLES),)) for i, part in enumerate(parts)]
    a, b = parts[0], parts[4]
    for part in parts[1:]:
        a = a.merge(part)
    for part in (parts[2], parts[0], parts[3].merge(parts[1])):
        b = b.merge(part)
    means = np.array([part.mean.mean() for part in parts])
    assert a.batches.count == b.batches.count == 5
    assert a.batches.spread == pytest.approx(SAMPLES * ((means - means.mean()) ** 2).sum())
    assert b.batches.spread == pytest.approx(a.batches.spread)


def test_the_worst_tile_is_where_the_noise_is() -> None:
    noisy = film()
    m2 = noisy.m2.copy()
    m2[32:, 32:] *= 9
    said = line("worst tile", replace(noisy, m2=m2))
    assert [said["values"][key] for key in ("x", "y", "width", "height")] == [32, 32, 8, 16]
    assert said["values"]["rmse"] == pytest.approx(3 * noisy.rmse(), rel=0.05)


def test_a_bound_stands_for_the_error() -> None:
    still = replace(film(), bound=np.full((48, 40, 1), 0.5))
    said = line("bound", still, use(precision="double"))
    assert (said["status"], said["values"]["largest"]) == ("stated", 0.5)
    assert line("rounding", still)["status"] == "stated"
    assert line("bound", replace(still, bound=np.full((48, 40, 1), np.inf)))["status"] == "failed"


def test_rejected_samples_are_named() -> None:
    assert line("samples", film())["status"] == "passed"
    said = line("samples", replace(film(), faults=Faults(nan=1, negative=3)))
    assert said["status"] == "failed"
    assert "4 of" in said["says"]
    assert "1 nan, 3 negative" in said["says"]


def test_violations_fail_and_repairs_are_told() -> None:
    assert line("majorant", film())["status"] == "passed"
    assert line("majorant", film(), use(kinds={}))["status"] == "stated"
    broken = line("majorant", replace(film(), faults=Faults(violations=5, touched=96.0)))
    assert broken["status"] == "failed"
    assert broken["values"]["weight"] == pytest.approx(96 / (8 * SAMPLES * 48 * 40))
    mended = line("majorant", replace(film(), faults=Faults(repaired=5)))
    assert mended["status"] == "passed"
    assert "rendered again" in mended["says"]


def test_what_a_cut_series_leaves_out() -> None:
    assert line("series", film())["values"] == {"truncation": 0.0}
    orders = {"last": 2, "rest": 0.02, "rest_error": 0.001, "rest_bound": 0.2, "norm": 0.5}
    said = line("series", film(), orders=orders)
    assert "beyond 2" in said["says"]
    assert said["values"]["rest_bound"] == 0.2


def test_rounding_needs_evidence_of_every_device() -> None:
    assert line("rounding", film())["status"] == "passed"
    assert line("rounding", film(), use(), use(evidence=None))["status"] == "not checked"
    drifting = {"options": [], "drift": DRIFT | {"relative": -1e-3}, "checks": []}
    assert line("rounding", film(), use(), use(evidence=drifting))["status"] == "failed"


def test_flags_that_trade_accuracy_are_named() -> None:
    assert line("build", film())["values"]["mode"] == "certified"
    relaxed = {"options": ["-cl-fast-relaxed-math"], "drift": None, "checks": []}
    said = line("build", film(), use(evidence=relaxed))
    assert said["values"]["mode"] == "relaxed"
    assert "-cl-fast-relaxed-math" in said["says"]
    assert line("build", film(), use(evidence=None))["status"] == "not checked"


def test_a_law_is_only_as_good_as_on_the_worst_device() -> None:
    assert line("darkness", film())["status"] == "passed"
    for status, reason in (("failed", "off by 3"), ("not checked", "there is no light")):
        other = use(
            id="gpu0",
            evidence={"options": [], "drift": DRIFT, "checks": [PASSED | {"status": status, "reason": reason}]},
        )
        said = line("darkness", film(), use(), other)
        assert (said["status"], said["values"]["device"]) == (status, "gpu0")
        assert said["says"].lower().endswith(f"{reason}.")
    assert line("laws", film(), use(), use(evidence=None))["status"] == "not checked"
