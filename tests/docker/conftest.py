"""The image as the Dockerfile makes it, without a Docker engine, and containers of it."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import httpx2
import psutil
import pytest
import yaml
from tests.server.conftest import postgres as postgres
from tests.server.s3_server import VERSION, program

ROOT = Path(__file__).parents[2]
DOCKERFILE = ROOT / "docker" / "Dockerfile"
#: The suite that the Dockerfile's base is made of.
SUITE = "bookworm"
#: What Debian's slim image leaves out.
LEFT_OUT = "".join(f"path-exclude /usr/share/{part}/*\n" for part in ("doc", "groff", "info", "locale", "man"))
USER = "10001"


class Buildah:
    """Buildah on a storage of its own, and the root file system of the image that it built there."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.command = ["buildah", "--root", str(folder / "storage"), "--runroot", str(folder / "run")]
        self.command += ["--storage-driver", "vfs"]

    def __call__(self, *arguments: str | Path) -> str:
        done = subprocess.run([*self.command, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True)
        assert not done.returncode, f"buildah {arguments[0]}: {done.stdout[-3000:]}{done.stderr[-3000:]}"
        return done.stdout.strip()

    def base(self, name: str) -> None:
        """Debian by debootstrap, under the name of the image that it stands for."""
        base = self.folder / "base"
        bootstrap = ["debootstrap", "--variant=minbase", SUITE, str(base)]
        made = subprocess.run(bootstrap, capture_output=True, text=True)
        assert not made.returncode, f"debootstrap: {made.stdout[-2000:]}{made.stderr[-2000:]}"
        (base / "etc/dpkg/dpkg.cfg.d/docker").write_text(LEFT_OUT)
        sources = base / "etc/apt/sources.list"
        mirror = sources.read_text().split()[1].rstrip("/")  # that debootstrap used
        suites = (f"{mirror} {SUITE}", f"{mirror} {SUITE}-updates", f"{mirror}-security {SUITE}-security")
        sources.write_text("".join(f"deb {suite} main\n" for suite in suites))
        for part in ("doc", "info", "locale", "man"):
            shutil.rmtree(base / "usr/share" / part)
        for folder in ("var/cache/apt", "var/lib/apt/lists"):
            shutil.rmtree(base / folder)
            (base / folder).mkdir()
        container = self("from", "scratch")
        self("copy", "--quiet", container, base, "/")
        self("commit", "--quiet", "--rm", container, name)
        shutil.rmtree(base)

    def build(self, name: str) -> None:
        # Without layers: of each stage, one copy is enough.
        options = ["--isolation", "chroot", "--format", "docker", "--pull-never", "--layers=false"]
        self("bud", *options, *_pip(self.folder), "--tag", name, "--file", DOCKERFILE, ROOT)


def _pip(folder: Path) -> list[str]:
    """Where this machine's pip takes packages from, and whom it trusts, as the build's secrets."""
    listed = subprocess.run([sys.executable, "-m", "pip", "config", "list"], capture_output=True, text=True, check=True)
    said = dict(line.split("=", 1) for line in listed.stdout.splitlines())
    config, secrets = ["[global]"], []
    for key in ("cert", "index-url", "extra-index-url"):
        for value in (said.get(f"{scope}.{key}") for scope in ("global", "install", ":env:")):
            if value and key == "cert":
                secrets += ["--secret", f"id=ca.pem,src={value.strip(chr(39))}"]
                value = "/run/secrets/ca.pem"
            if value:
                config.append(f"{key} = {value.strip(chr(39))}")
                break
    (folder / "pip.conf").write_text("\n".join(config) + "\n")
    return [*secrets, "--secret", f"id=pip.conf,src={folder / 'pip.conf'}"]


class Image:
    """The image, its configuration, and its root file system, mounted."""

    def __init__(self, buildah: Buildah, name: str) -> None:
        self.buildah = buildah
        self.container = buildah("from", "--pull-never", name)
        self.root = Path(buildah("mount", self.container))
        inspected = json.loads(buildah("inspect", "--type", "image", name))
        self.config: dict[str, Any] = inspected["Docker"]["config"]

    @property
    def environment(self) -> dict[str, str]:
        return dict(one.split("=", 1) for one in self.config["Env"])


@pytest.fixture(scope="session")
def image() -> Iterator[Image]:
    missing = [name for name in ("buildah", "debootstrap", "unshare", "ip") if not shutil.which(name)]
    if missing or os.geteuid():
        pytest.fail(f"wanted: root, and {', '.join(missing) or 'no program more'} (make image-test installs them)")
    folder = Path(tempfile.mkdtemp(prefix="woodcock-image-"))
    buildah = Buildah(folder)
    try:
        line = next(line for line in DOCKERFILE.read_text().splitlines() if line.startswith("ARG BASE="))
        buildah.base(line.removeprefix("ARG BASE="))
        buildah.build("localhost/woodcock")
        yield Image(buildah, "localhost/woodcock")
    finally:
        with suppress(AssertionError):
            buildah("rm", "--all")
        shutil.rmtree(folder)


#: Root file system read-only, /tmp small and without execution, a network of its own, no privileges to gain. Its
#: arguments: root, data, cache, command. What it runs is the first process there.
CONTAINER = f"""
set -eu
root=$1 data=$2 cache=$3; shift 3
mount --bind --options ro "$root" "$root"
mount --options remount,bind,ro "$root"
mount --types proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount --rbind --options ro /sys "$root/sys"
mount --types tmpfs --options size=64m,noexec,nosuid,mode=1777 tmpfs "$root/tmp"
mount --bind "$data" "$root/data"
mount --bind "$cache" "$root/cache"
ip link set lo up
exec chroot "$root" setpriv --reuid={USER} --regid={USER} --clear-groups --bounding-set=-all --inh-caps=-all \\
    --no-new-privs -- "$@"
"""


def _of_user(path: Path) -> None:
    path.mkdir(mode=0o700, exist_ok=True)
    os.chown(path, int(USER), int(USER))


class Container:
    """The image's own command, or another, in namespaces of its own."""

    def __init__(self, image: Image, folder: Path, *command: str) -> None:
        self.image = image
        self.log = folder / "log.txt"
        for mount in ("data", "cache"):
            _of_user(folder / mount)
        unshare = ["unshare", "--mount", "--pid", "--net", "--ipc", "--uts", "--fork", "--"]
        script = ["sh", "-c", CONTAINER, "sh", image.root, folder / "data", folder / "cache"]
        with self.log.open("a") as log:
            self.process = subprocess.Popen(
                [*unshare, *map(str, script), *image.config["Entrypoint"], *(command or image.config["Cmd"])],
                stdout=log,
                stderr=log,
                env=image.environment | {"WOODCOCK_INSECURE": "true", "WOODCOCK_NAMES": "localhost"},
            )
        self.wait_until(self._runs)
        #: The container's first process.
        [self.first] = psutil.Process(self.process.pid).children()

    def _runs(self) -> bool:
        return [one.name() for one in psutil.Process(self.process.pid).children()] == ["tini"]

    def run(self, *command: str, text: str = "") -> subprocess.CompletedProcess[str]:
        """A command beside what runs there, as `docker exec` does."""
        enter = ["nsenter", "--target", str(self.first.pid), "--mount", "--pid", "--net", "--ipc", "--uts", "--root"]
        enter += ["--wd=/", "setpriv", f"--reuid={USER}", f"--regid={USER}", "--clear-groups", "--"]
        return subprocess.run(
            [*enter, *command], input=text, env=self.image.environment, capture_output=True, text=True, timeout=120
        )

    def healthy(self) -> bool:
        return not self.run(*self.image.config["Healthcheck"]["Test"][1:]).returncode

    def wait_until(self, true: Callable[[], bool], seconds: float = 120) -> None:
        end = time.monotonic() + seconds
        while not true():
            assert self.process.poll() is None, self.log.read_text()
            assert time.monotonic() < end, self.log.read_text()
            time.sleep(0.05)

    def stop(self, seconds: float = 30) -> int:
        """SIGTERM to the first process, as an engine sends it; the exit status."""
        self.first.send_signal(signal.SIGTERM)
        return self.process.wait(seconds)


@pytest.fixture
def contain(image: Image, tmp_path: Path) -> Iterator[Callable[..., Container]]:
    """Runs a container on the test's own data and cache; what still runs at the end is killed."""
    made: list[Container] = []

    def run(*command: str) -> Container:
        made.append(Container(image, tmp_path, *command))
        return made[-1]

    yield run
    for container in made:
        with suppress(psutil.NoSuchProcess):
            container.first.kill()
        container.process.wait()


#: Capabilities that Buildah gives to a container, at most; its "ALL" would drop those, too, that are added.
GIVEN = {"AUDIT_WRITE", "CHOWN", "DAC_OVERRIDE", "FOWNER", "FSETID", "KILL", "MKNOD", "NET_BIND_SERVICE", "NET_RAW"}
GIVEN |= {"SETFCAP", "SETGID", "SETPCAP", "SETUID", "SYS_CHROOT"}


class Part:
    """A composed service of the image by `buildah run`, on the machine's own network. Each has its own data, cache and
    temporary folder."""

    def __init__(self, image: Image, folder: Path, name: str, service: dict[str, Any], **shared: Path) -> None:
        """shared: what is mounted by these names."""
        self.log = folder / f"log-{name}.txt"
        options = ["--user", service.get("user", USER)]
        for key, value in service.get("environment", {}).items():
            options += ["--env", f"{key}={value}"]
        own = {mount: folder / f"{mount}-{name}" for mount in ("data", "cache", "tmp")}
        for path in own.values():
            _of_user(path)
        for mount, path in (own | shared).items():
            options += ["--volume", f"{path}:/{mount}"]
        for dropped in sorted(GIVEN - {*service.get("cap_add", ())}):
            options += ["--cap-drop", f"CAP_{dropped}"]
        self._run = [*image.buildah.command, "run", "--isolation", "chroot", *options]
        self._run += [image.container, "--"]
        self._command = [*service.get("entrypoint", image.config["Entrypoint"])]
        self._command += service.get("command", image.config["Cmd"])

    def run(self, *command: str) -> int:
        """This one, or another beside it; the exit status."""
        with self.log.open("a") as log:
            return subprocess.run(
                [*self._run, *(command or self._command)], stdout=log, stderr=log, timeout=120
            ).returncode

    @contextmanager
    def running(self, *more: str) -> Iterator[None]:
        """more: arguments."""
        with self.log.open("a") as log:
            process = subprocess.Popen([*self._run, *self._command, *more], stdout=log, stderr=log)
        try:
            yield
        finally:
            _end(process)


def _end(process: subprocess.Popen[bytes]) -> None:
    inside = [one for one in psutil.Process(process.pid).children(recursive=True) if one.name() == "tini"]
    for tini in inside:
        tini.send_signal(signal.SIGTERM)
    try:
        process.wait(30)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        raise


def composed(name: str) -> dict[str, dict[str, Any]]:
    """Services of a compose file, by their names."""
    services: dict[str, dict[str, Any]] = yaml.safe_load((ROOT / "docker" / name).read_text())["services"]
    return services


@pytest.fixture
def store(tmp_path: Path) -> Iterator[dict[str, str]]:
    """The farm's object store by its composed command, in tmp_path / "objects"; the service's settings for it."""
    farm = composed("compose.farm.yaml")
    store, settings = farm["store"], farm["woodcock"]["environment"]
    assert settings["AWS_ENDPOINT_URL"] == "http://store:7070"
    assert store["image"].split(":")[-1] == VERSION, "the one that is tried here"
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = "{}:{}".format(*free.getsockname())
    gateway, [script] = program(), store["command"]
    environment = {"PATH": f"{gateway.parent}:{os.environ['PATH']}", "VGW_PORT": address}
    with (tmp_path / "store.txt").open("w") as log:
        process = subprocess.Popen(
            [*store["entrypoint"], script.replace("/data", str(tmp_path / "objects"))],
            env=store["environment"] | environment,
            stdout=log,
            stderr=log,
        )
    health = store["healthcheck"]["test"][-1].replace("127.0.0.1:7070", address)
    end = time.monotonic() + 20
    try:
        while True:
            with suppress(httpx2.TransportError):
                if httpx2.get(health).is_success:
                    break
            assert time.monotonic() < end, (tmp_path / "store.txt").read_text()
            time.sleep(0.05)
        yield {name: value.replace("store:7070", address) for name, value in settings.items()}
    finally:
        process.terminate()
        assert process.wait(20) == 0
