"""A SLURM cluster of this machine: two nodes, the daemons' own files in a folder."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from .harness import free_ports, wait_until

NODES = ("node1", "node2")
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch")

CONFIGURATION = """\
ClusterName=woodcock
SlurmctldHost=localhost
SlurmctldPort={control}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmdSpoolDir={folder}/%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/affinity
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
DefMemPerNode=1
"""


class Slurm:
    """folder: of the daemons' files; its path is short, for a socket is there."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._configuration = folder / "slurm.conf"
        self.environment = {"SLURM_CONF": str(self._configuration)}

    def ask(self, *command: str, cwd: Path | None = None, **environment: str) -> str:
        """What a command of SLURM prints."""
        environment = {**os.environ, **self.environment, **environment}
        done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    def empty(self) -> bool:
        """No job waits, runs or is about to end."""
        return not self.ask("squeue", "--noheader")

    def logs(self) -> str:
        return "\n".join(f"--- {log.name}\n{log.read_text()[-3000:]}" for log in self._folder.glob("*.log"))

    @contextmanager
    def made(self) -> Iterator[None]:
        """While the daemons run; every job has ended afterwards."""
        with ExitStack() as stack:
            self._configure()
            munge = self._folder / "munge"
            files = [f"--{name}-file={munge / name}" for name in ("key", "pid", "seed", "log")]
            options = ("--foreground", "--force", f"--socket={munge / 'socket'}", *files)
            stack.enter_context(self._daemon("munge", "munged", *options))
            wait_until((munge / "socket").exists, 20, self.logs)
            stack.enter_context(self._daemon("slurmctld", "slurmctld", "-D", "-c"))
            for node in NODES:
                stack.enter_context(self._daemon(node, "slurmd", "-D", "-N", node))
            wait_until(lambda: self.ask("sinfo", "--noheader", "--states=idle", "--format=%D") == "2", 60, self.logs)
            try:
                yield
            finally:
                self.ask("scancel", "--user=root")
                wait_until(self.empty, 60, self.logs)

    def _configure(self) -> None:
        munge = self._folder / "munge"
        for folder in (munge, *(self._folder / name for name in ("state", *NODES))):
            folder.mkdir()
        (munge / "key").write_bytes(os.urandom(32))
        (munge / "key").chmod(0o600)
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") >> 20
        control, *ports = free_ports(1 + len(NODES))
        lines = [
            f"NodeName={node} NodeHostname=localhost NodeAddr=127.0.0.1 Port={port} CPUs={os.cpu_count()} "
            f"RealMemory={memory} State=UNKNOWN"
            for node, port in zip(NODES, ports, strict=True)
        ]
        lines.append("PartitionName=all Nodes=ALL Default=YES State=UP")
        self._configuration.write_text(
            CONFIGURATION.format(folder=self._folder, control=control) + "\n".join(lines) + "\n"
        )

    @contextmanager
    def _daemon(self, name: str, *command: str) -> Iterator[None]:
        with (self._folder / f"{name}.log").open("w") as log:
            process = subprocess.Popen(
                command, stdout=log, stderr=subprocess.STDOUT, env={**os.environ, **self.environment}
            )
        try:
            yield
        finally:
            process.terminate()
            process.wait(30)


def fault() -> str | None:
    """Why there can be no cluster here; None if there can."""
    if os.getuid() != 0:
        return "its daemons need root"
    missing = [program for program in PROGRAMS if shutil.which(program) is None]
    return f"{', '.join(missing)} missing: apt install slurm-wlm munge" if missing else None
