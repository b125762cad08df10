"""Woodcock against its peers, scene by scene; and the judge of that comparison, on images whose variance is known."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom
from tests import statistics
from tests.benchmarks.peers import judge, page, run
from tests.benchmarks.peers.exact import transmittances
from tests.benchmarks.peers.judge import Shot
from tests.benchmarks.peers.protocol import Skip
from tests.benchmarks.peers.run import OURS, PEERS, Adapter, Peer, PeerError, Shots
from tests.benchmarks.peers.scenes import CASES, DATA, Case, Scene
from tests.conftest import Rng

# All scenes by all peers


@pytest.mark.benchmark
@pytest.mark.timeout(7200)
def test_peers(tmp_path: Path) -> None:
    """Writes benchmarks/; the means agree, and the goals are met."""
    records, failures = [], list[str]()
    for case in CASES:
        if case.file and not (DATA / case.file).is_file():
            print(f"{case.name}: left out, there is no {case.file} in the data")
            continue
        folder = tmp_path / case.name
        folder.mkdir()
        made = run.shoot(case, folder)
        error = exactness(folder, made) if made[0].described["deterministic"] else None
        records.append(page.record(case, made, error))
        failures += faults(records[-1])
        page.write(run.ROOT / "benchmarks", records)
    print("\n" + page.text(records))
    failures += judge.failures(page.ratios(records))
    assert not failures, "\n".join(failures)


def exactness(folder: Path, made: list[Shots]) -> float:
    """The largest error of Woodcock's picture without noise, relative."""
    scene = run.parse(json.dumps(json.loads((folder / "peer.json").read_text())["scene"]))
    rows, columns, right = transmittances(scene, folder)
    return float(np.abs(made[0].images[0][rows, columns, 0] / right - 1).max())


def faults(record: page.Record) -> list[str]:
    """What is wrong with a scene, the ratios aside. Who differs is wrong himself where another one agrees with us."""
    ours, *others = record["renderers"]
    agreeing = [row for row in others if not row["skipped"] and not row["differs"]]
    found = [
        f"{record['scene']}: {row['peer']}: {row['differs']}" for row in others if not agreeing and row.get("differs")
    ]
    found += [f"{record['scene']}: {row['peer']} {row['skipped']}" for row in others if row["failed"]]
    if record["error"] is not None:
        limit = 1e-6 if ours["doubles"] else 1e-5
        if not record["error"] <= limit:
            found.append(f"{record['scene']}: off by {record['error']:.1e}; the goal is {limit:g}")
        for row in others:
            if not row["skipped"] and not ours["seconds"] < row["seconds"]:
                found.append(
                    f"{record['scene']}: without noise in {ours['seconds']:.3g} s; {row['peer']} takes "
                    f"{row['seconds']:.3g} s for {row['samples']} samples"
                )
    return found


def test_one_that_differs_is_wrong_if_another_agrees() -> None:
    ours, agrees, differs = ({"peer": name, "skipped": None, "failed": False} for name in ("Woodcock", "a", "b"))
    ours |= {"doubles": True, "differs": None}
    agrees |= {"differs": None}
    differs |= {"differs": "means differ by 5 %"}
    record = {"scene": "smoke", "error": None}
    assert faults(record | {"renderers": [ours, agrees, differs]}) == []
    assert faults(record | {"renderers": [ours, differs]}) == ["smoke: b: means differ by 5 %"]


# The judge


def shot(rng: np.random.Generator, deviation: float, seconds: float, rounds: int = 6, mean: float = 1.0) -> Shot:
    """A picture of 32 × 32 with independent noise; the times vary by a tenth."""
    images = rng.normal(mean, deviation, (rounds, 32, 32, 3))
    return Shot(images, (seconds * rng.uniform(0.9, 1.1, rounds)).tolist())


def test_the_error_is_the_variance_between_rounds() -> None:
    images = np.array([[[[1.0, 2.0, 0.0]]], [[[3.0, 2.0, 6.0]]]])  # variances 2, 0 and 18
    assert judge.mse(images) == pytest.approx(20 / 3)
    assert judge.efficiency(Shot(images, [2.0, 4.0])) == pytest.approx(1 / 20)
    assert judge.efficiency(Shot(np.ones((3, 2, 2, 3)), [1.0] * 3)) is None


def test_the_interval_holds_the_ratio(rng: Rng) -> None:
    """Nine times the variance in half of the time."""
    random, misses, trials = rng(1), 0, 200
    for _ in range(trials):
        found = judge.ratio(shot(random, 0.1, 1), shot(random, 0.3, 0.5))
        assert found is not None
        assert found["low"] is not None
        assert found["high"] is not None
        assert found["low"] < found["value"] < found["high"] < 1.5 * found["low"]
        misses += not found["low"] < 4.5 < found["high"]
    statistics.accept(2 * min(binom.cdf(misses, trials, 0.05), binom.sf(misses - 1, trials, 0.05)), exact=False)


def test_rounds_are_paired(rng: Rng) -> None:
    """What slows all of a round down does not widen the interval; a third round that only one has does not count."""
    random = rng(2)
    ours, theirs, moods = shot(random, 0.1, 1), shot(random, 0.3, 1), np.array([1, 5, 1, 9, 1, 3.0])
    slowed = [each._replace(seconds=moods.tolist()) for each in (ours, theirs)]
    even = [each._replace(seconds=[1.0] * 6) for each in (ours, theirs)]
    found, right = judge.ratio(*slowed), judge.ratio(*even)
    assert found == pytest.approx(right, rel=0.02)
    fewer = Shot(theirs.images[:3], [1.0] * 3)
    assert judge.ratio(even[0], fewer) == judge.ratio(Shot(ours.images[:3], [1.0] * 3), fewer)


def test_equal_means_have_a_ratio(rng: Rng) -> None:
    ours, theirs = shot(rng(3), 0.02, 1), shot(rng(4), 0.2, 1)
    row = judge.rows(ours.images, ours, {"Cycles": theirs})["Cycles"]
    assert row["differs"] is None
    assert row["ratio"] is not None
    assert row["ratio"]["value"] == pytest.approx(100, rel=0.1)
    assert abs(row["bias"]) < 5 * row["bias_error"] < 0.02


@pytest.mark.parametrize(("part", "says"), [(slice(None), "in the whole"), (slice(0, 8), "in part 1 of 16")])
def test_a_biased_picture_has_no_ratio(rng: Rng, part: slice, says: str) -> None:
    """Of the whole, or of a sixteenth of it."""
    ours, theirs, honest = shot(rng(5), 0.02, 1), shot(rng(6), 0.02, 1), shot(rng(7), 0.02, 1)
    theirs.images[:, part, part] *= 1.01
    found = judge.rows(ours.images, ours, {"Cycles": theirs, "LuxCore": honest})
    assert found["Cycles"]["ratio"] is None
    assert says in str(found["Cycles"]["differs"])
    assert found["LuxCore"]["differs"] is None
    assert found["LuxCore"]["ratio"] is not None


def test_pixels_that_share_random_numbers_are_no_bias(rng: Rng) -> None:
    random = rng(8)
    ours, theirs = shot(random, 0.02, 1), shot(random, 0.02, 1)
    theirs.images[...] += random.normal(0, 0.02, (6, 1, 1, 1))
    assert judge.rows(ours.images, ours, {"Cycles": theirs})["Cycles"]["differs"] is None


def test_a_picture_without_noise_is_the_truth(rng: Rng) -> None:
    ours = Shot(np.ones((6, 32, 32, 3)), [1.0] * 6)
    found = judge.rows(ours.images, ours, {"same": shot(rng(9), 0.1, 1), "other": shot(rng(10), 0.1, 1, mean=1.02)})
    assert found["same"]["differs"] is None
    assert found["same"]["ratio"] is None
    assert found["other"]["differs"] is not None


def test_goals_that_are_missed() -> None:
    good = {"Mitsuba 3 scalar": {"cloud": 110.0, "milk": 41.0}, "pbrt-v4": {"cloud": 31.0, "milk": 13.0}}
    assert judge.failures(good) == []
    found = judge.failures({"Cycles": {"cloud": 80.0, "milk": 25.0}, "LuxCore": {"milk": 21.0}})
    assert len(found) == 2
    assert "cloud: 80 times as efficient as Cycles; the goal is 85" in found[0]
    assert "geometric mean: 21 times as efficient as LuxCore; the goal is 30" in found[1]


# Adapters

ADAPTER = """
import json, sys
sys.path.insert(0, {here!r})
import numpy as np
from protocol import Skip, serve

def make(job):
    what = sys.argv[2]
    print("chatter of a library")
    if what == "skip":
        raise Skip("it has no clouds")
    side = job.scene["film"]["height"]
    value = float(job.values("d.npy").max())
    def render(samples, seed):
        print("more of it")
        with open("order", "a") as file:
            print(what, samples, seed, file=file)
        if what == "broken" and seed > 2:
            raise ValueError("no more memory.")
        image = value + np.random.default_rng(seed).normal(0, samples**-0.5, (side, side, 3))
        return image[:1] if what == "cut" else image, samples * 2.0**-10
    described = {{"name": what, "version": "1", "settings": "none", "device": "d", "driver": "d"}}
    return described | {{"deterministic": False}}, render

serve(make)
"""


def tiny(folder: Path) -> Scene:
    np.save(folder / "d.npy", np.full((2, 3, 4), 7, np.uint8))
    rows = [[2, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    return {
        "camera": {"kind": "perspective", "origin": [0, 0, 3], "target": [0, 0, 0]},
        "volumes": [{"kind": "grid", "file": "d.npy", "albedo": 0.5, "to_world": rows}],
        "film": {"width": 16, "height": 16},
    }


TINY = Case("tiny", "a scene of one grid", tiny)


@pytest.fixture
def adapter(tmp_path: Path) -> Path:
    path = tmp_path / "fake_side.py"
    path.write_text(ADAPTER.format(here=str(run.HERE)))
    return path


def test_the_protocol(adapter: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two that render in turns, one that has no clouds, one that breaks down: chatter goes elsewhere."""
    monkeypatch.setattr(run, "IMAGE_SECONDS", 60 / 1024)  # of 64 samples
    ours, *others = (Adapter(name, str(adapter), (name,)) for name in ("ours", "theirs", "skip", "broken"))
    made = run.shoot(TINY, tmp_path, ours, others)
    assert [(shots.skipped, shots.failed) for shots in made] == [
        (None, False),
        (None, False),
        ("it has no clouds", False),
        ("failed: broken: ValueError: no more memory", True),
    ]
    assert made[1].samples == 64
    assert made[1].seconds == [64 / 1024] * run.ROUNDS
    assert sorted(made[1].parts) == [4, 16]
    order = [line.split() for line in (tmp_path / "order").read_text().splitlines()]
    turns = [(who, seed) for who, samples, seed in order if samples == "64" and who != "broken" and int(seed) > 1]
    assert turns == [(who, str(run.FIRST_SEED + turn)) for turn in range(run.ROUNDS) for who in ("ours", "theirs")]
    assert len(set(map(tuple, order))) == len(order), "no image is rendered twice"
    assert "chatter of a library\nmore of it\n" in (tmp_path / "theirs.log").read_text()
    assert np.mean(made[1].images) == pytest.approx(7, abs=0.02)
    grid = json.loads((tmp_path / "peer.json").read_text())["grids"]["d.npy"]
    assert grid["to_scene"] == [[2, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]

    record = page.record(TINY, made)
    page.write(tmp_path / "page", [record])
    written = (tmp_path / "page" / "benchmarks.md").read_text()
    assert "| skip | it has no clouds |" in written
    assert "| theirs | **" in written
    assert "<svg" in (tmp_path / "page" / "tiny.svg").read_text()
    assert json.loads((tmp_path / "page" / "benchmarks.json").read_text())[0]["renderers"][1]["samples"] == 64
    assert faults(record) == ["tiny: broken failed: broken: ValueError: no more memory"]


def test_a_picture_of_the_wrong_size_is_an_error(adapter: Path, tmp_path: Path) -> None:
    run.prepare(TINY, tmp_path)
    peer = Peer(Adapter("cut", str(adapter), ("cut",)), tmp_path)
    with pytest.raises(PeerError, match=r"the picture is of shape \(1, 16, 3\), not \(16, 16, 3\)"):
        peer.render(1, 1)
    peer.close()


def test_a_peer_that_is_not_installed_is_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WOODCOCK_PEERS", "no-such-python")
    for each in PEERS:
        if each.module:
            with pytest.raises(Skip, match="make peers"):
                each.python()
        else:
            assert each.python() == OURS.python()
    assert math.isclose(judge.geometric_mean([2, 8]), 4)
