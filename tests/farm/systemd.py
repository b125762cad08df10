"""A machine with systemd and this one's files, whose changes to them are its own, on this machine's network."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

from .harness import wait_until

ROOT = Path(__file__).parents[2]
#: Where the machine has the environment and the sources of these tests, which the units of systemd may not see where
#: they are.
INSTALLED, SOURCES = "/opt/woodcock", "/opt/sources"
#: By which Python finds these there.
PYTHONPATH = ":".join(f"{SOURCES}/{name}" for name in ("kernels", "server", "client"))

#: No other unit that happens to be installed is started.
TARGET = """\
[Unit]
Requires=basic.target
After=basic.target
"""
#: A container may not do it.
TRIAL = """\
mount -t tmpfs tmpfs /mnt
mkdir /mnt/changes /mnt/work
mount -t overlay overlay -o lowerdir=/,upperdir=/mnt/changes,workdir=/mnt/work /mnt
"""
COMMAND = f"""\
#!{INSTALLED}/bin/python
from woodcock_client.cli import main
if __name__ == "__main__":
    main()
"""


class Machine:
    """folder: of its changes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._log = folder / "log.txt"
        #: Its files.
        self.root = folder / "root"

    def run(self, command: str) -> str:
        """What a command of its shell prints."""
        within = ["nsenter", f"--target={self._init}", "--mount", "--pid", "--ipc", "--uts", "--cgroup", "sh", "-ec"]
        done = subprocess.run([*within, command], capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        return done.stdout

    @contextmanager
    def made(self) -> Iterator[None]:
        """While it runs."""
        with self._files(), _control_groups():
            (self._folder / "woodcock").write_text(COMMAND)
            (self._folder / "woodcock").chmod(0o755)
            bound = ((sys.prefix, INSTALLED), (self._folder / "woodcock", f"{INSTALLED}/bin/woodcock"), (ROOT, SOURCES))
            with self._log.open("w") as log:
                process = subprocess.Popen(
                    [
                        "systemd-nspawn", f"--directory={self.root}", "--register=no", "--keep-unit", "--console=pipe",
                        "--resolv-conf=off", *(f"--bind-ro={here}:{there}" for here, there in bound),
                        "--boot", "systemd.unit=woodcock-test.target",
                    ],
                    stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                )  # fmt: skip
            try:
                wait_until(lambda: self._children(process.pid), 20, self._log.read_text)
                self._init = self._children(process.pid)[0]
                wait_until(self._up, 60, self._log.read_text)
                yield
            finally:
                process.terminate()  # It is shut down.
                process.wait(60)

    @contextmanager
    def _files(self) -> Iterator[None]:
        changes, work = self._folder / "changes", self._folder / "work"
        for folder in (self.root, changes, work):
            folder.mkdir(parents=True)
        options = f"lowerdir=/,upperdir={changes},workdir={work}"
        subprocess.run(["mount", "-t", "overlay", "overlay", "-o", options, str(self.root)], check=True)
        try:
            units = self.root / "etc/systemd/system"
            shutil.rmtree(units)
            units.mkdir()
            (units / "woodcock-test.target").write_text(TARGET)
            for path in (INSTALLED, SOURCES):
                (self.root / path[1:]).mkdir(parents=True)
            # The interpreter may lie below somebody's home.
            for path in map(Path, (sys.base_prefix, *map(str, Path(sys.base_prefix).parents))):
                here = self.root / path.relative_to("/")
                here.chmod(stat.S_IMODE(here.stat().st_mode) | 0o011)
            yield
        finally:
            subprocess.run(["umount", "--lazy", str(self.root)], check=True)

    def _children(self, pid: int) -> list[int]:
        return [child.pid for child in psutil.Process(pid).children()]

    def _up(self) -> bool:
        try:
            return "active" in self.run("systemctl is-active woodcock-test.target")
        except AssertionError:
            return False


@contextmanager
def _control_groups() -> Iterator[None]:
    """Remove those that the machine was in, which stay."""

    def there() -> set[Path]:
        return {path for name in ("payload", "supervisor") for path in Path("/sys/fs/cgroup").rglob(name)}

    before = there()
    try:
        yield
    finally:
        for group in there() - before:
            for folder, _, _ in os.walk(group, topdown=False):
                Path(folder).rmdir()


def fault() -> str | None:
    """Why there can be no machine here; None if there can."""
    if os.getuid() != 0:
        return "it needs root"
    if shutil.which("systemd-nspawn") is None:
        return "there is no systemd-nspawn: apt install systemd-container"
    trial = subprocess.run(["unshare", "--mount", "sh", "-ec", TRIAL], capture_output=True, text=True)
    return trial.stderr.strip() or None
