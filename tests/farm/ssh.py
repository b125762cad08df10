"""Hosts with names, accounts and home folders of their own on this machine, reached by OpenSSH."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from .harness import free_ports, wait_until

#: Where Debian has it, and `which` may not look.
SERVER = "/usr/sbin/sshd"

#: Another name and home folder, for one process and its children.
ELSEWHERE = """\
set -e
mount --bind {folder}/passwd /etc/passwd
mount -t tmpfs tmpfs /run
mkdir /run/sshd
hostname {host}
exec {server} -D -e -f {folder}/sshd_config
"""


class Hosts:
    """folder: of the private key, the commands and the homes. Settings are in the environment of all who log in."""

    def __init__(self, folder: Path, names: Sequence[str], **settings: str) -> None:
        self._folder, self._settings = folder, settings
        self._ports = dict(zip(names, free_ports(len(names)), strict=True))

    def home(self, host: str) -> Path:
        return self._folder / host / "home"

    @property
    def environment(self) -> Mapping[str, str]:
        """Of one who reaches them by name."""
        return {**os.environ, "PATH": f"{self._folder}{os.pathsep}{os.environ['PATH']}"}

    @contextmanager
    def made(self) -> Iterator[None]:
        self._folder.mkdir()
        _key(self._folder / "key")
        for command in ("ssh", "scp"):
            script = self._folder / command
            script.write_text(f'#!/bin/sh\nexec {shutil.which(command)} -F {self._folder}/config "$@"\n')
            script.chmod(0o700)
        with ExitStack() as stack:
            for host, port in self._ports.items():
                stack.enter_context(self._host(host, port))
            yield

    @contextmanager
    def _host(self, host: str, port: int) -> Iterator[None]:
        folder, home = self._folder / host, self.home(host)
        home.mkdir(parents=True)
        _key(folder / "host_key")
        (folder / "passwd").write_text(
            f"root:x:0:0:root:{home}:/bin/sh\nsshd:x:100:65534::/run/sshd:/usr/sbin/nologin\n"
        )
        settings = " ".join(f'"{name}={value}"' for name, value in self._settings.items())
        (folder / "sshd_config").write_text(
            f"ListenAddress 127.0.0.1:{port}\nHostKey {folder}/host_key\nAuthorizedKeysFile {self._folder}/key.pub\n"
            f"StrictModes no\nUsePAM no\nPidFile none\nSubsystem sftp internal-sftp\nSetEnv {settings}\n"
        )
        with (self._folder / "config").open("a") as config:
            config.write(
                f"Host {host}\n  HostName 127.0.0.1\n  Port {port}\n  User root\n  IdentityFile {self._folder}/key\n"
                f"  StrictHostKeyChecking accept-new\n  UserKnownHostsFile {self._folder}/known\n"
            )
        log = folder / "sshd.log"
        elsewhere = ELSEWHERE.format(folder=folder, host=host, server=SERVER)
        with log.open("w") as stream:
            process = subprocess.Popen(["unshare", "--mount", "--uts", "sh", "-c", elsewhere], stderr=stream)
        try:
            wait_until(lambda: "listening" in log.read_text(), 20, log.read_text)
            yield
        finally:
            process.terminate()
            process.wait(30)


def _key(path: Path) -> None:
    subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(path)], check=True)


def fault() -> str | None:
    """Why there can be no hosts here; None if there can."""
    missing = [command for command in ("unshare", "ssh", "scp", "ssh-keygen", SERVER) if shutil.which(command) is None]
    if missing:
        return f"{', '.join(missing)} missing: apt install openssh-server openssh-client"
    trial = subprocess.run(["unshare", "--mount", "--uts", "true"], capture_output=True, text=True)
    return trial.stderr.strip() or None
