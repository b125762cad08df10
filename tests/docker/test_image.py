"""The image, built for real, and what runs from it."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import time
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import OpenImageIO
import pytest
import yaml
from psycopg.conninfo import conninfo_to_dict

from woodcock.device import find
from woodcock.render import Renderer
from woodcock.scene import parse
from woodcock_server import certificate

from .conftest import DOCKERFILE, USER, Container, Image, Part, composed

pytestmark = [pytest.mark.image, pytest.mark.timeout(1800)]

SAMPLES = 64
SCENE: dict[str, Any] = {
    "camera": {"kind": "perspective", "origin": [0.5, 0.5, -2], "target": [0.5, 0.5, 0.5]},
    "volumes": [
        {
            "kind": "constant",
            "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
            "sigma_t": 4,
            "albedo": [0.98, 0.95, 0.9],
            "phase": {"kind": "henyey_greenstein", "g": 0.6},
        }
    ],
    "lights": [{"kind": "constant", "radiance": 1}],
    "film": {"width": 64, "height": 48},
    "stop": {"kind": "samples", "samples": SAMPLES},
}
LONG = SCENE | {"stop": {"kind": "seconds", "seconds": 600}}
#: Of PostgreSQL, in the folder that a URL calls its host.
SOCKET = ".s.PGSQL.5432"
#: Bytes; the image's README says how much there is.
LARGEST = 850e6

Contain = Callable[..., Container]


def beauty(path: Path) -> Any:
    picture = OpenImageIO.ImageInput.open(str(path))
    assert picture, OpenImageIO.geterror()
    names = list(picture.spec().channelnames)
    pixels = picture.read_image("float")
    picture.close()
    return pixels[:, :, [names.index(channel) for channel in "RGB"]]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def test_a_job_gives_the_picture_that_is_rendered_outside(image: Image, tmp_path: Path) -> None:
    port = free_port()
    service = {"command": ["serve", "--host", "127.0.0.1", "--port", str(port), "--data", "/data"]}
    with Part(image, tmp_path, "woodcock", service).running():
        job = render(port, tmp_path)
    assert job["devices"] == ["cpu0"]
    assert_as_outside(tmp_path / "inside.exr")


def test_the_composed_farm_renders(
    image: Image, tmp_path: Path, store: dict[str, str], postgres: Callable[[], str]
) -> None:
    """Each service by its composed command and settings; of the other images, what they hold runs outside."""
    port, farm = free_port(), free_port()
    database = conninfo_to_dict(postgres())
    composed_url = "woodcock:${POSTGRES_PASSWORD:?choose one}@database/woodcock"
    names = {
        "scheduler:8786": f"127.0.0.1:{farm}",
        composed_url: "{user}@/{dbname}?host=/database".format(**database),
    }
    (tmp_path / "farm").mkdir()

    def part(name: str, **more: str) -> Part:
        service = composed("compose.yaml")[name]
        environment = service.get("environment", {}) | more
        for there, here in names.items():
            environment = {key: value.replace(there, here) for key, value in environment.items()}
        shared = {"farm": tmp_path / "farm", f"database/{SOCKET}": Path(str(database["host"]), SOCKET)}
        return Part(image, tmp_path, name, service | {"environment": environment}, **shared)

    assert part("certificates").run() == 0
    scheduler, worker, service = part("scheduler"), part("worker"), part("woodcock", **store)
    with (
        scheduler.running("--host", "127.0.0.1", "--port", str(farm)),
        worker.running("--name", "node7"),
        service.running("--host", "127.0.0.1", "--port", str(port)),
    ):
        job = render(port, tmp_path)
        for name, one in (("scheduler", scheduler), ("worker", worker)):
            kind, script = composed("compose.yaml")[name]["healthcheck"]["test"]
            assert kind == "CMD-SHELL"
            assert one.run("sh", "-c", script) == 0
    assert job["devices"] == ["cpu0@node7"]
    assert_as_outside(tmp_path / "inside.exr")
    assert list((tmp_path / "objects/woodcock/jobs").rglob("image.exr*"))
    assert not list((tmp_path / "data-woodcock").glob("*.sqlite"))


def render(port: int, folder: Path) -> dict[str, Any]:
    """The scene by the service at a port, once it is ready, to inside.exr in the folder; returns the job."""
    with httpx2.Client(base_url=f"http://127.0.0.1:{port}") as http:
        wait_until_ready(http, folder)
        job: dict[str, Any] = http.post("/api/v1/jobs", json={"scene": SCENE}).raise_for_status().json()
        while job["state"] in ("queued", "running"):
            time.sleep(0.1)
            job = http.get(f"/api/v1/jobs/{job['id']}").raise_for_status().json()
        assert job["state"] == "succeeded", job
        picture = http.get(f"/api/v1/jobs/{job['id']}/image.exr").raise_for_status()
        (folder / "inside.exr").write_bytes(picture.content)
        assert "<script" in http.get("/").raise_for_status().text
    return job


def assert_as_outside(picture: Path) -> None:
    outside = Renderer(parse(json.dumps(SCENE)), find()).render(0, SAMPLES)
    # The picture is half floats; another compiler may round otherwise.
    np.testing.assert_allclose(beauty(picture), outside.mean, rtol=1e-3)


def wait_until_ready(http: httpx2.Client, folder: Path) -> None:
    end = time.monotonic() + 120
    while time.monotonic() < end:
        try:
            if http.get("/readyz").is_success:
                return
        except httpx2.TransportError:
            pass
        time.sleep(0.2)
    pytest.fail("\n".join(path.read_text() for path in sorted(folder.glob("log-*.txt"))))


def test_nobody_in_it_can_write_but_to_its_mounts(contain: Contain) -> None:
    container = contain()
    container.wait_until(container.healthy)
    mounts = ["(", "-path", "/data", "-o", "-path", "/cache", "-o", "-path", "/tmp", ")", "-prune", "-o"]
    assert container.run("find", "/", "-xdev", *mounts, "-writable", "-not", "-type", "l", "-print").stdout == ""
    for folder, can in (("/data", True), ("/cache", True), ("/tmp", True), ("/opt/woodcock", False), ("/", False)):
        assert (container.run("touch", f"{folder}/touched").returncode == 0) is can
    status = Path(f"/proc/{container.first.pid}/status").read_text()
    assert "CapEff:\t0000000000000000" in status
    assert "CapBnd:\t0000000000000000" in status
    assert "NoNewPrivs:\t1" in status
    scene = container.run("sh", "-c", "cat > /tmp/scene.json", text=json.dumps(SCENE))
    assert not scene.returncode, scene.stderr
    submitted = container.run("woodcock", "submit", "/tmp/scene.json", "--follow", "-o", "/tmp/scene.exr")
    assert not submitted.returncode, submitted.stdout + submitted.stderr
    kept = container.run("sh", "-c", "ls /data/jobs/*/image.exr /cache/woodcock").stdout
    assert "image.exr" in kept
    assert "pocl" in kept


@pytest.mark.parametrize("seconds", [0.2, 1, 2.5, 4])
def test_it_ends_where_it_is_stopped_while_it_starts(contain: Contain, seconds: float) -> None:
    container = contain()
    time.sleep(seconds)
    assert container.stop() == 0
    assert "Traceback" not in container.log.read_text()


def test_a_worker_is_probed_while_there_is_no_scheduler(contain: Contain, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    certificate.write(tmp_path / "data/farm", timedelta(days=1))
    for path in (tmp_path / "data/farm", *(tmp_path / "data/farm").iterdir()):
        os.chown(path, int(USER), int(USER))
    manifest = yaml.safe_load((DOCKERFILE.parent / "kubernetes/base/worker.yaml").read_text())
    [pod] = manifest["spec"]["template"]["spec"]["containers"]
    container = contain("worker", "--scheduler", "tls://127.0.0.1:8786", "--certificates", "/data/farm")

    def probe(kind: str) -> bool:
        return not container.run(*pod[f"{kind}Probe"]["exec"]["command"]).returncode

    assert not probe("startup")
    container.wait_until(lambda: probe("startup"))
    assert probe("liveness")
    assert not probe("readiness")
    assert container.stop() == 0


def test_a_driver_can_be_left_out(contain: Contain) -> None:
    container, vendors = contain(), "/etc/OpenCL/vendors"
    assert composed("compose.yaml")["worker-gpu"]["environment"]["OCL_ICD_VENDORS"] == f"{vendors}/nvidia.icd"
    for driver, devices in (("pocl", True), ("nvidia", False)):
        listed = container.run("env", f"OCL_ICD_VENDORS={vendors}/{driver}.icd", "woodcock", "devices")
        assert ("cpu0" in listed.stdout) is devices, listed


def test_a_job_that_a_stop_interrupts_goes_on_with_the_next_start(contain: Contain) -> None:
    container = contain()
    container.wait_until(container.healthy)
    container.run("sh", "-c", "cat > /data/scene.json", text=json.dumps(LONG))
    job = container.run("woodcock", "submit", "/data/scene.json")
    assert not job.returncode, job.stderr
    container.wait_until(lambda: samples(container) > 0)
    assert container.stop() == 0
    again = contain()
    again.wait_until(again.healthy)
    before = samples(again)
    assert before > 0
    again.wait_until(lambda: samples(again) > before)


def samples(container: Container) -> int:
    """Of the newest job."""
    ask = "import urllib.request as r; print(r.urlopen('http://127.0.0.1:8000/api/v1/jobs').read().decode())"
    [job, *_] = json.loads(container.run("python3", "-c", ask).stdout)["items"]
    return int(job["samples"])


def test_a_worker_that_dies_is_buried_and_replaced(contain: Contain) -> None:
    container = contain()
    container.wait_until(container.healthy)
    died = [one for one in container.first.children(recursive=True) if "spawn_main" in " ".join(one.cmdline())]
    assert died
    for one in died:
        one.kill()

    def replaced() -> bool:
        now = container.first.children(recursive=True)
        workers = [one for one in now if one.status() != "zombie" and "spawn_main" in " ".join(one.cmdline())]
        return not set(died) & set(now) and len(workers) >= len(died)

    container.wait_until(replaced)
    assert not [one for one in container.first.children(recursive=True) if one.status() == "zombie"]


def test_its_list_of_contents_names_all_that_is_in_it(image: Image) -> None:
    listed = json.loads((image.root / "usr/share/woodcock/sbom.cdx.json").read_text())
    components = {(one["name"].lower().replace("_", "-"), one["version"]) for one in listed["components"]}
    query = ["dpkg-query", f"--admindir={image.root / 'var/lib/dpkg'}", "--show"]
    packages = subprocess.run(query, capture_output=True, text=True, check=True).stdout
    wanted = {tuple(line.split("\t")) for line in packages.splitlines()}
    wanted = {(str(name).split(":")[0], version) for name, version in wanted}
    for metadata in image.root.glob("opt/woodcock/lib/python3*/site-packages/*.dist-info"):
        name, version = metadata.name.removesuffix(".dist-info").split("-", 1)
        wanted.add((name.lower().replace("_", "-"), version))
    assert len(wanted) > 100
    assert wanted <= components


def test_it_is_small_and_has_no_compiler_to_run(image: Image) -> None:
    commands = {path.name for folder in ("usr/bin", "usr/local/bin") for path in (image.root / folder).iterdir()}
    commands |= {path.name for path in (image.root / "opt/woodcock/bin").iterdir()}
    assert not commands & {"cc", "gcc", "g++", "c++", "cpp", "clang", "clang-15", "gcc-12", "as-gcc", "pip", "pip3"}
    size = sum(path.lstat().st_size for path in image.root.rglob("*") if path.is_file() and not path.is_symlink())
    print(f"{size / 1e6:.0f} MB")
    assert size < LARGEST


def test_it_runs_as_nobody_in_particular(image: Image) -> None:
    assert image.config["User"] == "10001:10001"
    assert set(image.config["Volumes"]) == {"/data", "/cache"}
    owned = [path for path in (image.root / "opt").rglob("*") if path.lstat().st_uid]
    assert owned == []
    assert (image.root / "data").stat().st_uid == 10001
