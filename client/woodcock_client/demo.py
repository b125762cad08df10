"""`make demo`: the service itself, started here, renders the example scenes; what comes back lies in a folder."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from os import killpg
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from woodcock.scene import Scene, SceneError, files, load
from woodcock_client.client import Artifact, Client
from woodcock_client.connection import ServiceError, Unreachable
from woodcock_client.exits import BAD_INPUT, FAILED, INTERRUPTED
from woodcock_client.models import Device
from woodcock_client.progress import show

EXAMPLES = Path(__file__).parent / "examples"
WOODCOCK = (sys.executable, "-m", "woodcock_client.cli")
PORT = 8000
STOP_SECONDS = 20
ARTIFACTS: dict[Artifact, str] = {"image.exr": ".exr", "preview.png": ".png", "report.json": ".report.json"}


class DemoError(RuntimeError):
    """Why the demo cannot go on, in one sentence."""


def demo(
    scenes: Annotated[Path, typer.Option(help="Folder of the scenes.", show_default="the examples")] = EXAMPLES,
    folder: Annotated[Path, typer.Option(help="Where pictures, log and the service's data go.")] = Path("demo"),
    data: Annotated[
        Path | None, typer.Option(help="Folder of volumes and the like; renders the examples that need them too.")
    ] = None,
    once: Annotated[bool, typer.Option(help="End after the renders, rather than keep serving the gallery.")] = False,
) -> None:
    """Start the service, render the example scenes on it, fetch the results, and keep serving the gallery."""
    for ending in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(ending) != signal.SIG_IGN:  # as under nohup
            signal.signal(ending, signal.default_int_handler)
    rendered = False
    try:
        wanted = {path.stem: load(path) for path in sorted(scenes.glob("*.json"))}
        if data is not None:
            wanted |= with_data(scenes / "data", data)
        folder.mkdir(parents=True, exist_ok=True)
        with _service(folder) as (process, address), Client(address) as client:
            _check(client.devices())
            typer.echo(f"The gallery is at {address}/")
            rendered = render(client, wanted, folder)
            if not once:
                typer.echo(f"The gallery stays at {address}/ until Ctrl-C.")
                process.wait()
                raise DemoError(f"the service ended: {_last_line(folder)}")
    except SceneError as error:
        _fail(str(error), BAD_INPUT)
    except (DemoError, ServiceError, Unreachable) as error:
        _fail(str(error), FAILED)
    except OSError as error:
        _fail(f"{error.filename}: {error.strerror}" if error.filename else str(error), FAILED)
    except KeyboardInterrupt:
        typer.echo()
        raise SystemExit(0 if rendered else INTERRUPTED) from None
    raise SystemExit(0 if rendered else FAILED)


def with_data(scenes: Path, data: Path) -> dict[str, Scene]:
    """The scenes of a folder whose files all lie in the folder `data`; what the others lack is told in a line each.

    Raises SceneError.
    """
    if not data.is_dir():
        raise SceneError(f"--data {data}: is not a folder")
    found = {}
    for path in sorted(scenes.glob("*.json")):
        scene = load(path, data)
        lacking = [file for file in files(scene) if not Path(file).is_file()]
        if lacking:
            typer.echo(f"{path.stem} is left out, for there is no {' and no '.join(lacking)}.")
        else:
            found[path.stem] = scene
    return found


def render(client: Client, scenes: dict[str, Scene], folder: Path) -> bool:
    """Render the scenes and fetch what becomes of them, as NAME.exr, NAME.png and NAME.report.json; True if all did.

    A render that fails is told of, and the others go on. Raises what Client raises.
    """
    jobs = {name: client.submit(scene, name=name) for name, scene in scenes.items()}
    failed = False
    for name, job in jobs.items():
        typer.echo(f"{name}, {job.width} × {job.height}")
        end = show(client.follow(job.id))
        if end.state != "succeeded":
            failed = True
            typer.echo(f"{name} {end.state}: {end.error}" if end.error else f"{name} {end.state}", err=True)
            continue
        saved = {artifact: folder / f"{name}{suffix}" for artifact, suffix in ARTIFACTS.items()}
        for artifact, path in saved.items():
            client.fetch(job.id, artifact, path)
        typer.echo("  ".join(map(str, saved.values())))
    return not failed


@contextmanager
def _service(folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """`woodcock serve` and its address, from when it is ready until the block ends. Raises DemoError."""
    command = [*WOODCOCK, "serve", "--host", "127.0.0.1", "--port", str(_port()), "--data", str(folder / "data")]
    with _log(folder).open("w") as log:
        # A session of its own: Ctrl-C reaches this process alone, which then ends the service in good order.
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True, start_new_session=True)
    try:
        typer.echo("Starting the service; the first time, it checks what it can render on.")
        assert process.stdout is not None
        address = re.search(r"http://[^/\s]+", process.stdout.readline())
        if address is None:
            process.wait()
            raise DemoError(f"the service did not start: {_last_line(folder)}")
        yield process, address[0]
    finally:
        _stop(process)


def _stop(process: subprocess.Popen[str]) -> None:
    """End the service and its workers: asked first, forced where that takes too long or is interrupted too."""
    with process:
        process.send_signal(signal.SIGINT)
        with suppress(subprocess.TimeoutExpired, KeyboardInterrupt):
            process.wait(STOP_SECONDS)
        with suppress(ProcessLookupError):
            killpg(process.pid, signal.SIGKILL)


def _check(devices: tuple[Device, ...]) -> None:
    """Raises DemoError, with the reason, if there is nothing to render on: jobs would wait for ever."""
    if any(device.state == "ready" for device in devices):
        return
    said = "; ".join(device.fault for device in devices if device.fault)
    if not said:  # No device at all; the service says so in its log only.
        listing = subprocess.run([*WOODCOCK, "devices"], capture_output=True, text=True, check=False)
        said = listing.stderr.strip().removeprefix("woodcock: ")
    raise DemoError(f"there is nothing to render on: {said}")


def _port() -> int:
    """The usual port if it is free, or 0 for any."""
    with socket.socket() as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind(("127.0.0.1", PORT))
        except OSError:
            return 0
    return PORT


def _log(folder: Path) -> Path:
    return folder / "service.log"


def _last_line(folder: Path) -> str:
    lines = _log(folder).read_text().strip().splitlines()
    return f"{lines[-1] if lines else 'it gave no reason'} (its log is {_log(folder)})"


def _fail(message: str, code: int) -> NoReturn:
    typer.echo(f"demo: {message}", err=True)
    raise SystemExit(code)


if __name__ == "__main__":
    typer.run(demo)
