"""The command line as a user meets it: a process, its exit code, and what it says where."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
import sys
import threading
import time
import tomllib
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from woodcock_client import cli

if TYPE_CHECKING:
    from .service import Service

COMMAND = [sys.executable, "-W", "error", "-m", "woodcock_client.cli"]
ROOT = Path(__file__).parents[2]


def environment(**extra: str) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "COLUMNS": "200", "NO_COLOR": "1", **extra}


def woodcock(*arguments: object, **extra: str) -> subprocess.CompletedProcess[str]:
    command = [*COMMAND, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment(**extra), check=False)


def test_submit_names_the_page_and_goes(service: Service, scene_file: Path) -> None:
    done = woodcock("submit", scene_file, "--server", service.url + "/")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{service.url}/renders/job0000\n", "")
    assert service.jobs["job0000"]["name"] == "box"


def test_submit_asks_for_a_device(service: Service, scene_file: Path) -> None:
    assert woodcock("submit", scene_file, "--device", "cpu0", "--server", service.url).returncode == 0
    assert service.jobs["job0000"]["device"] == "cpu0"
    done = woodcock("submit", scene_file, "--device", "gpu0", "--server", service.url)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith("device: must be any, or the kind or id of a device\n")


def test_submit_names_a_reference(service: Service, scene_file: Path, tmp_path: Path) -> None:
    """A job by its id, a file by uploading it."""
    assert woodcock("submit", scene_file, "--server", service.url).returncode == 0
    assert service.jobs["job0000"]["reference"] is None
    assert woodcock("submit", scene_file, "--reference", "job0000", "--server", service.url).returncode == 0
    assert service.jobs["job0001"]["reference"] == "job0000"
    picture = tmp_path / "right.exr"
    picture.write_bytes(b"a picture")
    assert woodcock("submit", scene_file, "--reference", picture, "--server", service.url).returncode == 0
    (uploaded,) = service.volumes
    assert service.jobs["job0002"]["reference"] == uploaded
    done = woodcock("submit", scene_file, "--reference", "nothing", "--server", service.url)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith("reference: must be the id of a job that has succeeded\n")
    done = woodcock("submit", scene_file, "--reference", tmp_path / "none.exr", "--server", service.url)
    assert (done.returncode, done.stderr) == (1, f"woodcock: {tmp_path / 'none.exr'}: No such file or directory\n")


def test_submit_names_a_webhook(service: Service, scene_file: Path) -> None:
    """Its secret is in no process list."""
    asked, secret = ("submit", scene_file, "--server", service.url, "--webhook", "https://example.org/"), "whsec_a"
    done = woodcock(*asked, WOODCOCK_WEBHOOK_SECRET=secret)
    assert (done.returncode, done.stderr) == (0, "")
    assert service.jobs["job0000"]["webhook"]["url"] == "https://example.org/"
    assert service.secrets["job0000"] == secret
    for more, says in (((), "needs WOODCOCK_WEBHOOK_SECRET"), (("--check",), "neither --check nor --vary")):
        done = woodcock(*asked, *more)
        assert (done.returncode, done.stdout) == (2, "")
        assert says in done.stderr
    assert len(service.jobs) == 1


def test_an_error_that_is_asked_for_is_told(service: Service, scene_json: dict[str, Any], tmp_path: Path) -> None:
    add = service.add

    def rendered(scene: dict[str, Any], name: str = "") -> str:
        id = add(scene, name)
        service.advance(id, 64)
        service.finish(id)
        return id

    service.add = rendered  # type: ignore[method-assign]
    path = tmp_path / "box.json"
    path.write_text(json.dumps({**scene_json, "stop": {"kind": "relative_error", "relative_error": 0.07}}))
    done = woodcock("submit", path, "--follow", WOODCOCK_SERVER=service.url)
    assert done.stderr.splitlines()[-1] == "succeeded 100%, 64 samples to an error of 7.00%, error 6.25%, 1.3 s"


def test_what_a_render_waits_for_is_told(service: Service, scene_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add = service.add

    def held_up(scene: dict[str, Any], name: str = "") -> str:
        id = add(scene, name)
        service.update(id, waiting="Every device failed.")
        threading.Thread(target=give_up, args=(id,)).start()
        return id

    def give_up(id: str) -> None:
        while ("GET", f"/api/v1/jobs/{id}/events") not in service.requests:
            time.sleep(0.02)
        time.sleep(0.5)
        service.update(id, state="failed", waiting=None, error="no hope")

    monkeypatch.setattr(service, "add", held_up)
    done = woodcock("submit", scene_file, "--follow", "--server", service.url)
    assert done.stderr.splitlines()[0] == "queued      0%, 0 / 64 samples, Every device failed., 0.0 s"
    assert done.stderr.splitlines()[1].startswith("failed ")


def test_submit_follows_in_plain_lines_and_fetches(renders: Service, scene_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "box.exr"
    done = woodcock("submit", scene_file, "--follow", "-o", out, "--name", "first", WOODCOCK_SERVER=renders.url)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [f"{renders.url}/renders/job0000", str(out), str(tmp_path / "box.report.json")]
    last = done.stderr.splitlines()[-1]
    assert last == "succeeded 100%, 64 / 64 samples, error 6.25%, 1.3 s"
    assert out.read_bytes() == renders.artifacts["job0000", "image.exr"]
    assert json.loads((tmp_path / "box.report.json").read_text()) == {"error": []}
    assert renders.jobs["job0000"]["name"] == "first"


def test_a_render_without_noise_says_how_wrong_it_is_at_most(service: Service, scene_file: Path) -> None:
    add = service.add

    def bounded(scene: dict[str, Any], name: str = "") -> str:
        id = add(scene, name)
        service.advance(id, 64)
        service.update(id, integrator="transmittance", rmse=2e-8, relative_rmse=4.2e-8)
        service.finish(id)
        return id

    service.add = bounded  # type: ignore[method-assign]
    done = woodcock("submit", scene_file, "--follow", WOODCOCK_SERVER=service.url)
    last = done.stderr.splitlines()[-1]
    assert last == "succeeded 100%, 64 / 64 samples, no noise, error at most 4e-06%, 1.3 s"


def test_output_alone_waits_in_silence(renders: Service, scene_file: Path, tmp_path: Path) -> None:
    done = woodcock("submit", scene_file, "-o", tmp_path / "box.exr", "--server", renders.url)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "box.exr").exists()


def test_a_terminal_gets_a_bar(renders: Service, scene_file: Path) -> None:
    ours, theirs = pty.openpty()
    command = [*COMMAND, "submit", str(scene_file), "--follow", "--server", renders.url]
    done = subprocess.run(
        command, stdout=subprocess.DEVNULL, stderr=theirs, timeout=60, env=environment(TERM="xterm"), check=False
    )
    os.close(theirs)
    shown = b""
    while chunk := _read(ours):
        shown += chunk
    os.close(ours)
    assert done.returncode == 0
    assert "succeeded" in shown.decode()
    assert "━" in shown.decode()
    assert "64 / 64 samples error 6.25%" in shown.decode()


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 65536)
    except OSError:  # Linux's way to say that the other side is closed
        return b""


def test_a_failed_render_exits_1_with_its_reason(
    service: Service, scene_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add = service.add

    def add_failed(scene: dict[str, Any], name: str = "") -> str:
        id = add(scene, name)
        service.update(id, state="failed", error="the device ran out of memory\n\nclFinish: -5")
        return id

    monkeypatch.setattr(service, "add", add_failed)
    done = woodcock("submit", scene_file, "--follow", "--server", service.url)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "woodcock: the render failed: the device ran out of memory"


def test_an_interrupt_leaves_the_render_running(service: Service, scene_file: Path) -> None:
    command = [*COMMAND, "submit", str(scene_file), "--follow", "--server", service.url]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment()
    ) as process:
        assert process.stderr is not None
        assert process.stderr.readline().startswith("queued")
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=30)
    assert process.returncode == 130
    assert said == f"woodcock: interrupted; the render goes on at {service.url}/renders/job0000\n"


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (["submit", "none.json"], 2, "none.json: No such file or directory"),
        (["submit", "bad.json"], 2, "bad.json: camera: is required"),
        (["submit", "box.json", "-o", "box.png"], 2, "-o box.png: the name must end in .exr"),
        (["submit", "box.json", "-o", "no/box.exr"], 2, "-o no/box.exr: no is not a folder"),
        (["submit", "box.json", "--server", "farm"], 2, "--server: the service's address must look like http://"),
        (["submit", "box.json", "--server", "http://127.0.0.1:9"], 3, "no answer from the service at http://127.0"),
    ],
)
def test_faults_are_one_sentence(
    scene_file: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], code: int, sentence: str
) -> None:
    monkeypatch.chdir(scene_file.parent)
    Path("bad.json").write_text('{"volumes": []}')
    done = woodcock(*arguments)
    assert done.returncode == code
    assert done.stdout == ""
    assert done.stderr.startswith(f"woodcock: {sentence}")
    assert "Traceback" not in done.stderr


def test_a_service_that_fails_is_not_the_users_fault(service: Service, scene_file: Path) -> None:
    service.broken = (503, "application/problem+json", b'{"detail":"the database is not there"}')
    done = woodcock("submit", scene_file, "--server", service.url)
    assert (done.returncode, done.stderr) == (3, "woodcock: the database is not there\n")


# Commands of other packages


def test_every_command_of_the_project_names_its_extra() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert cli.EXTRAS.keys() == project["entry-points"]["woodcock.commands"].keys()
    extras = {extra for command in cli.EXTRAS.values() for extra in command.split(",")}
    assert extras <= project["optional-dependencies"].keys()


def run(monkeypatch: pytest.MonkeyPatch, arguments: list[str], *points: tuple[str, str]) -> int | str | None:
    found = EntryPoints(EntryPoint(name, value, "woodcock.commands") for name, value in points)
    monkeypatch.setattr(cli, "entry_points", lambda group: found.select(group=group))
    monkeypatch.setattr(sys, "argv", ["woodcock", *arguments])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    return caught.value.code


def test_a_command_of_an_installed_package_runs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, ["where"], ("where", "os:getcwd")) == 0


@pytest.mark.parametrize("points", [[], [("serve", "woodcock_absent.command:serve")]])
def test_a_command_that_is_not_installed_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], points: list[tuple[str, str]]
) -> None:
    assert run(monkeypatch, ["serve", "--port", "9"], *points) == 2
    assert 'get it with: pip install "woodcock[server,pocl]"' in capsys.readouterr().err


def test_a_library_missed_while_a_command_runs_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "lazy_command.py").write_text("def render() -> None:\n    import absent_library\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert run(monkeypatch, ["render"], ("render", "lazy_command:render")) == 2
    said = capsys.readouterr().err
    assert "`render` is not installed (absent_library is missing)" in said


def test_submit_imports_no_other_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, ["submit", "--help"], ("serve", "this_would_fail:serve")) == 0
    assert "--follow" in capsys.readouterr().out


def test_help_teaches(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, ["--help"]) == 0
    said = capsys.readouterr().out
    assert "woodcock submit cloud.json --follow -o cloud.exr" in said
    assert re.search(r'serve +\(needs pip install "woodcock\[server,pocl\]"\)', said)
    assert "Exit codes:" in said


def test_version(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, ["--version"]) == 0
    assert capsys.readouterr().out.startswith("woodcock")


def test_an_unknown_command_is_bad_usage(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, ["frobnicate"]) == 2
    assert "No such command 'frobnicate'" in capsys.readouterr().err
