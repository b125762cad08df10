"""A real S3 server of the tests' own: VersityGW, which keeps its objects in a folder; Go builds it when it is first
needed."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

PACKAGE, VERSION = "github.com/versity/versitygw/cmd/versitygw", "v1.8.0"
KEY, SECRET = "woodcock", "only-for-tests"
BUCKET = "renders"


def program() -> Path:
    """Beside this Python; skips the test where it can be neither found nor built."""
    path = Path(sys.executable).with_name("versitygw")
    if not path.exists():
        if shutil.which("go") is None:
            pytest.skip("cannot be tried here: there is no Go to build the S3 server with")
        build = ["go", "install", f"{PACKAGE}@{VERSION}"]
        done = subprocess.run(build, env={**os.environ, "GOBIN": str(path.parent)}, capture_output=True, text=True)
        if done.returncode != 0:
            pytest.skip(f"cannot be tried here: {done.stderr.splitlines()[-1]}")
    return path


class S3Server:
    """environment: by which a service uses its bucket; folder: of the bucket."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "objects" / BUCKET
        self.folder.mkdir(parents=True)
        self._program, self._log, self._asked = program(), folder / "log.txt", folder / "asked.txt"
        with socket.create_server(("127.0.0.1", 0)) as free:
            self._port = free.getsockname()[1]
        self.environment = {
            "WOODCOCK_STORE": f"s3://{BUCKET}/farm",
            "AWS_ENDPOINT_URL": f"http://127.0.0.1:{self._port}",
            "AWS_ACCESS_KEY_ID": KEY,
            "AWS_SECRET_ACCESS_KEY": SECRET,
            "AWS_REGION": "us-east-1",
        }

    def start(self) -> None:
        address, asked = f"127.0.0.1:{self._port}", str(self._asked)
        command = [str(self._program), "--port", address, "--quiet", "--access-log", asked, "posix"]
        environment = {**os.environ, "ROOT_ACCESS_KEY": KEY, "ROOT_SECRET_KEY": SECRET}
        with self._log.open("a") as log:
            self.process = subprocess.Popen(
                [*command, str(self.folder.parent)], env=environment, stdout=log, stderr=log, cwd=self.folder.parent
            )
        end = time.monotonic() + 20
        while True:
            with suppress(OSError), socket.create_connection(("127.0.0.1", self._port)):
                return
            assert time.monotonic() < end, self._log.read_text()
            time.sleep(0.02)

    def stop(self) -> None:
        self.process.kill()
        self.process.wait()

    def hang(self) -> None:
        """Connections are taken, and nothing is answered."""
        self.process.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        self.process.send_signal(signal.SIGCONT)

    def path(self, key: str) -> Path:
        """Where an object lies; read so, nothing needs to answer."""
        return self.folder / "farm" / key

    def found(self) -> set[str]:
        """Keys of all objects, by the folder and not by asking."""
        return {str(path.relative_to(self.path(""))) for path in self.path("").rglob("*") if path.is_file()}

    def readers(self, key: str) -> list[str]:
        """Who read an object, in order, by what their programs call themselves."""
        return re.findall(rf" s3_GetObject farm/{key} .* (object_store|Python-urllib)/", self._asked.read_text())
