"""What is said to Docker and Kubernetes: by their own schemas, and by what the program understands."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import kubernetes_validate
import pytest
import yaml

from woodcock_server.access.origin import LOOPBACK
from woodcock_server.config import Settings
from woodcock_server.store import connect

from .conftest import composed

DOCKER = Path(__file__).parents[2] / "docker"
#: The second is merged into the first.
COMPOSE = ["compose.yaml", "compose.farm.yaml"]
OVERLAYS = ("base", "gpu", "autoscaling")
KUBERNETES = "1.34"
KUSTOMIZE = "sigs.k8s.io/kustomize/kustomize/v5@v5.7.1"
COMPOSE_SPEC = "github.com/compose-spec/compose-go/v2@v2.16.2"
KEDA = "github.com/kedacore/keda/v2@v2.18.0"
#: Settings of others, which the service's libraries read.
THEIRS = ("AWS_", "OCL_")

network = pytest.mark.image


def resources() -> Iterator[dict[str, Any]]:
    for path in sorted(DOCKER.glob("kubernetes/*/*.yaml")):
        if path.name != "kustomization.yaml":
            yield from yaml.safe_load_all(path.read_text())


def pods() -> Iterator[dict[str, Any]]:
    for one in resources():
        if one["kind"] == "Deployment":
            yield one["spec"]["template"]["spec"]


def whole() -> Iterator[tuple[str, dict[str, Any]]]:
    """Composed services, without what one file changes of another's."""
    for file in COMPOSE:
        yield from ((name, service) for name, service in composed(file).items() if "image" in service)


def test_manifests_are_what_kubernetes_takes() -> None:
    checked = [one for one in resources() if "keda" not in one["apiVersion"]]
    assert len(checked) > 10
    for one in checked:
        kubernetes_validate.validate(one, KUBERNETES, strict=True)


def test_pods_are_restricted() -> None:
    for pod in pods():
        assert pod["securityContext"]["runAsNonRoot"]
        assert pod["securityContext"]["seccompProfile"] == {"type": "RuntimeDefault"}
        assert pod["automountServiceAccountToken"] is False
        for container in pod["containers"]:
            assert container["securityContext"] == {
                "allowPrivilegeEscalation": False,
                "readOnlyRootFilesystem": True,
                "capabilities": {"drop": ["ALL"]},
            }
            assert container["resources"]["limits"]["memory"]
            mounted = {one["mountPath"] for one in container["volumeMounts"]}
            assert mounted >= {"/cache", "/tmp"}


def test_pods_are_probed_and_composed_services_in_the_same_way() -> None:
    asked: dict[str, set[str]] = {"scheduler": set(), "worker": set()}
    for pod in pods():
        [container] = pod["containers"]
        assert {"startupProbe", "livenessProbe", "readinessProbe"} <= set(container)
        for probe in ("startup", "liveness", "readiness") if "args" not in container else ():
            assert container[f"{probe}Probe"]["httpGet"]["httpHeaders"] == [{"name": "Host", "value": LOOPBACK[-1]}]
        for kind in container.get("args", []):
            assert container["startupProbe"]["exec"] == container["livenessProbe"]["exec"]
            asked[kind].add(container["readinessProbe"]["exec"]["command"][-1])
    for service in composed(COMPOSE[0]).values():
        for kind in service.get("command", []):
            if kind in asked:
                asked[kind].add(service["healthcheck"]["test"][-1])
    assert {kind: len(each) for kind, each in asked.items()} == {"scheduler": 1, "worker": 1}


def test_composed_services_are_restricted() -> None:
    for name, service in whole():
        assert service["security_opt"] == ["no-new-privileges:true"]
        assert service["mem_limit"]
        assert service["pids_limit"]
        if name != "database":  # It changes its user, and writes beside its volume.
            assert service["read_only"]
            assert service["cap_drop"] == ["ALL"]


def test_composed_services_can_be_reached_by_those_alone_who_need_to() -> None:
    services = dict(whole())
    assert yaml.safe_load((DOCKER / COMPOSE[0]).read_text())["networks"] == {"farm": {"internal": True}}
    networks = {name: service.get("networks") for name, service in services.items()}
    assert networks == {
        "certificates": None, "scheduler": ["farm"], "woodcock": ["default", "farm"], "worker": ["farm"],
        "worker-gpu": ["farm"], "database": ["default"], "store": ["farm"],
    }  # fmt: skip
    assert services["certificates"]["network_mode"] == "none"
    ports = {name: service["ports"] for name, service in services.items() if "ports" in service}
    assert ports == {"woodcock": ["127.0.0.1:8000:8000"]}
    assert services["worker-gpu"]["profiles"] == ["gpu"]
    assert [name for name, service in services.items() if "devices" in str(service.get("deploy"))] == ["worker-gpu"]


def test_composed_services_wait_for_what_tells_its_state() -> None:
    services = dict(whole())
    waited = {
        name: one["condition"] for service in services.values() for name, one in service.get("depends_on", {}).items()
    }
    waited |= {name: one["condition"] for name, one in composed(COMPOSE[1])["woodcock"]["depends_on"].items()}
    assert waited == {
        "certificates": "service_completed_successfully", "database": "service_healthy", "store": "service_healthy",
    }  # fmt: skip
    for name, service in services.items():
        image_has_one = name == "woodcock"
        assert image_has_one or service["healthcheck"].get("test") or name == "certificates"


def test_the_store_of_the_farm_takes_what_the_service_has(
    store: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in store.items():
        monkeypatch.setenv(name, value)
    bucket = connect(store["WOODCOCK_STORE"])
    bucket.try_writing()
    bucket.put("large", bytes(20 << 20))  # in parts
    assert bucket.size("large") == 20 << 20


def test_what_they_set_are_settings_and_what_they_run_are_commands() -> None:
    said: set[str] = set()
    run: list[str] = ["serve"]
    for file in COMPOSE:
        for service in composed(file).values():
            if service.get("image", "woodcock") == "woodcock":
                said |= set(service.get("environment", {}))
                run += service.get("command", [])[:1] if "entrypoint" not in service else []
    for pod in pods():
        for container in pod["containers"]:
            said |= {one["name"] for one in container.get("env", [])}
            run += container.get("args", [])[:1]
    base = yaml.safe_load((DOCKER / "kubernetes/base/kustomization.yaml").read_text())
    said |= {one.split("=")[0] for one in base["configMapGenerator"][0]["literals"]}
    known = {f"WOODCOCK_{name}".upper() for name in Settings.model_fields}
    assert {one for one in said if not one.startswith(THEIRS)} <= known
    project = tomllib.loads((DOCKER.parent / "pyproject.toml").read_text())["project"]
    assert set(run) <= set(project["entry-points"]["woodcock.commands"])
    assert len(set(run)) > 2


@pytest.fixture(scope="session")
def go(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    if not shutil.which("go"):
        pytest.fail("Go is missing (1.24 or newer), by which kustomize and the schemas of compose and KEDA come")
    folder = tmp_path_factory.mktemp("go")
    return {**os.environ, "GOPATH": str(folder), "GOBIN": str(folder / "bin"), "GOFLAGS": "-modcacherw"}


def module(go: dict[str, str], name: str) -> Path:
    """The source of a Go module."""
    done = subprocess.run(["go", "mod", "download", "-json", name], env=go, capture_output=True, text=True, check=True)
    return Path(json.loads(done.stdout)["Dir"])


@network
def test_compose_files_are_what_compose_takes(go: dict[str, str], tmp_path: Path) -> None:
    schema = json.loads((module(go, COMPOSE_SPEC) / "schema/compose-spec.json").read_text())
    paths = [DOCKER / file for file in COMPOSE]
    for path in paths:
        jsonschema.Draft7Validator(schema).validate(yaml.safe_load(path.read_text()))
    # Compose's own loader: merges, follows anchors, and refuses volumes, networks and services that nobody has.
    name, version = COMPOSE_SPEC.split("@")
    subprocess.run(["go", "install", f"{name}/cmd@{version}"], env=go, check=True)

    def loaded(*paths: Path) -> Any:
        load = [f"{go['GOBIN']}/cmd", "-no-interpolation", "-format", "json", *map(str, paths)]
        done = subprocess.run(load, capture_output=True, text=True, cwd=tmp_path)
        assert not done.returncode, done.stderr
        return json.loads(done.stdout)

    one, farm = loaded(paths[0]), loaded(*paths)
    assert one["name"] == farm["name"] == "woodcock"
    assert set(farm["services"]) == set(one["services"]) | {"store"}
    assert set(farm["volumes"]) == set(one["volumes"]) | {"store"}
    assert set(farm["services"]["woodcock"]["depends_on"]) == {"certificates", "database", "store"}
    settings = dict(setting.split("=", 1) for setting in farm["services"]["woodcock"]["environment"])
    own = one["services"]["woodcock"]["environment"]
    assert settings == own | composed(COMPOSE[1])["woodcock"]["environment"]
    assert farm["services"]["worker"] == one["services"]["worker"]


@network
@pytest.mark.timeout(900)
def test_overlays_build_and_are_what_kubernetes_and_keda_take(go: dict[str, str]) -> None:
    subprocess.run(["go", "install", KUSTOMIZE], env=go, check=True)
    definitions = {}
    for path in (module(go, KEDA) / "config/crd/bases").glob("keda.sh_*.yaml"):
        crd = yaml.safe_load(path.read_text())["spec"]
        definitions[crd["names"]["kind"]] = crd["versions"][0]["schema"]["openAPIV3Schema"]
    for overlay in OVERLAYS:
        build = [f"{go['GOBIN']}/kustomize", "build", str(DOCKER / "kubernetes" / overlay)]
        built = subprocess.run(build, capture_output=True, text=True)
        assert not built.returncode, built.stderr
        made = list(yaml.safe_load_all(built.stdout))
        settings = {one["metadata"]["name"] for one in made if one["kind"] == "ConfigMap"}
        for one in made:
            assert one["kind"] == "Namespace" or one["metadata"]["namespace"] == "woodcock"
            if one["kind"] in definitions:
                jsonschema.validate(one, definitions[one["kind"]])
            else:
                kubernetes_validate.validate(one, KUBERNETES, strict=True)
            if one["kind"] == "Deployment":
                [container] = one["spec"]["template"]["spec"]["containers"]
                assert {sources["configMapRef"]["name"] for sources in container["envFrom"][:1]} == settings
                assert ":" in container["image"].split("/")[-1]
