"""Sweeps as the command line takes them, and what is said of them on their way."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from woodcock_client import Batch, Client, ServiceError, cli, client, sweeps

if TYPE_CHECKING:
    from .service import Service


def batch(scene: dict[str, Any], *states: str, **more: Any) -> dict[str, Any]:
    """A batch with a job in each of the states."""
    jobs = [
        {
            "id": f"job{number}",
            "point": {"volumes[0].sigma_t": number, "camera.target": [0, 0, number]},
            "state": state,
            "fraction": {"succeeded": 1, "running": 0.5}.get(state, 0),
            "samples": 64,
            "seconds": 1.25,
            "relative_rmse": 0.01,
            "links": {"self": f"/api/v1/jobs/job{number}", "events": f"/api/v1/jobs/job{number}/events"},
            **more,
        }
        for number, state in enumerate(states)
    ]
    rows = [[number, [0, 0, number]] for number in range(len(states))]
    return {
        "id": "b1",
        "name": "",
        "created_at": "2026-01-01T00:00:00Z",
        "scene": scene,
        "axes": [{"paths": ["volumes[0].sigma_t", "camera.target"], "rows": rows}],
        "counts": {state: states.count(state) for state in states},
        "jobs": jobs,
        "links": {"self": "/api/v1/batches/b1", "jobs": "/api/v1/jobs?batch=b1"},
    }


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1,2,4", [1, 2, 4]),
        (" 1 , -2.5e1", [1, -25.0]),
        ("[1,2,3],[4,5,6]", [[1, 2, 3], [4, 5, 6]]),
        ('{"kind":"box","size":[1,2]},null,true', [{"kind": "box", "size": [1, 2]}, None, True]),
        ("a.vdb, b.vdb", ["a.vdb", "b.vdb"]),
        ('"a,b",1.5x,NaN', ["a,b", "1.5x", "NaN"]),
    ],
)
def test_values_are_json_or_text(text: str, expected: list[Any]) -> None:
    assert sweeps.axes("--sweep", [f"a.b[0]={text}", "c=1"]) == {"a.b[0]": expected, "c": [1]}


@pytest.mark.parametrize(
    "texts", [["a"], ["a="], ["a=1,"], ["a=,1"], ["a=[1,2"], ["a=[b,c]"], ['a="b'], ["a=1", "a=2"]]
)
def test_what_are_no_values(texts: list[str]) -> None:
    with pytest.raises(ValueError, match=r"^--zip a.*: write each field once, as PATH=value,value, such as ") as caught:
        sweeps.axes("--zip", texts)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--sweep", "seed"], "--sweep seed: write each field once, as PATH=value,value"),
        (["--zip", "seed=1", "-o", "a.exr"], "--check, --vary, --sweep and -o exclude each other"),
        (["--sweep", "seed=1", "--check"], "--check, --vary, --sweep and -o exclude each other"),
    ],
)
def test_what_is_no_sweep_is_one_sentence(
    scene_file: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    says: str,
) -> None:
    monkeypatch.setattr("sys.argv", ["woodcock", "submit", str(scene_file), *arguments])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    said = capsys.readouterr()
    assert (caught.value.code, said.out) == (2, "")
    assert said.err.startswith(f"woodcock: {says}")


def test_a_batch_is_followed_in_plain_lines(capsys: pytest.CaptureFixture[str], scene_json: dict[str, Any]) -> None:
    def changes() -> Iterator[Batch]:
        for states, more in (
            (("queued", "queued"), {"waiting": "No device."}),
            (("running", "queued"), {}),
            (("running", "queued"), {}),
            (("succeeded", "failed"), {}),
        ):
            yield Batch.model_validate(batch(scene_json, *states, **more))

    end = sweeps.show(changes())
    assert capsys.readouterr().err.splitlines() == [
        "  0%, 0 of 2 done, No device.",
        " 25%, 0 of 2 done, 1 running",
        "100%, 2 of 2 done, 1 failed",
    ]
    sweeps.print_table(end)
    head, _, first, second = (line.split() for line in capsys.readouterr().out.splitlines() if line.strip())
    assert head == ["volumes[0].sigma_t", "camera.target", "state", "samples", "error", "seconds", "render"]
    assert first == ["0", "[0,", "0,", "0]", "succeeded", "64", "1.00%", "1.2", "job0"]
    assert second[4:6] == ["failed", "64"]


def test_a_terminal_gets_a_bar_for_all(
    capsys: pytest.CaptureFixture[str], scene_json: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    states = (("running", "queued"), ("succeeded", "cancelled"))
    sweeps.show(Batch.model_validate(batch(scene_json, *each)) for each in states)
    said = capsys.readouterr().err
    assert "━" in said
    assert "2 of 2 done, 1 cancelled" in said


def test_an_outage_is_sat_out(service: Service, scene_json: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "LOOK_EVERY", 0.02)
    service.batches["b1"] = batch(scene_json, "running", "queued")

    def mend() -> None:
        service.batches["b1"] = batch(scene_json, "succeeded", "succeeded")
        service.broken = None

    with Client(service.url, timeout=5) as talk:
        seen = []
        for now in talk.follow_batch("b1"):
            seen.append(now.fraction)
            service.broken = (503, "application/problem+json", b"{}")
            threading.Timer(0.1, mend).start()
        assert seen == [0.25, 1.0]
        with pytest.raises(ServiceError) as caught:
            list(talk.follow_batch("b2"))
        assert caught.value.status == 404, "that is no outage"
