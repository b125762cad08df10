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

from woodcock_server.config import Settings

DOCKER = Path(__file__).parents[2] / "docker"
COMPOSE = sorted(DOCKER.glob("compose*.yaml"))
OVERLAYS = ("base", "gpu", "autoscaling")
KUBERNETES = "1.34"
KUSTOMIZE = "sigs.k8s.io/kustomize/kustomize/v5@v5.7.1"
COMPOSE_SPEC = "github.com/compose-spec/compose-go/v2@v2.9.0"
KEDA = "github.com/kedacore/keda/v2@v2.18.0"
#: Settings of others, which the service's libraries read.
THEIRS = ("AWS_",)

network = pytest.mark.image


def resources() -> Iterator[dict[str, Any]]:
    for path in sorted(DOCKER.glob("kubernetes/*/*.yaml")):
        if path.name != "kustomization.yaml":
            yield from yaml.safe_load_all(path.read_text())


def pods() -> Iterator[dict[str, Any]]:
    for one in resources():
        if one["kind"] == "Deployment":
            yield one["spec"]["template"]["spec"]


def compose_services() -> Iterator[tuple[str, dict[str, Any]]]:
    for path in COMPOSE:
        yield from yaml.safe_load(path.read_text())["services"].items()


def of_woodcock() -> Iterator[dict[str, Any]]:
    return (service for _, service in compose_services() if service["image"] == "woodcock")


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


def test_composed_services_are_restricted() -> None:
    for service in of_woodcock():
        assert service["read_only"]
        assert service["cap_drop"] == ["ALL"]
        assert service["security_opt"] == ["no-new-privileges:true"]
        assert service["mem_limit"]
        assert service["pids_limit"]
    for name, service in compose_services():
        for port in service.get("ports", []):
            assert port.startswith("127.0.0.1:"), name


def test_what_they_set_are_settings_and_what_they_run_are_commands() -> None:
    said: set[str] = set()
    run: list[str] = ["serve"]
    for service in of_woodcock():
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
@pytest.mark.parametrize("path", COMPOSE, ids=lambda path: path.name)
def test_compose_files_are_what_compose_takes(go: dict[str, str], path: Path) -> None:
    schema = json.loads((module(go, COMPOSE_SPEC) / "schema/compose-spec.json").read_text())
    jsonschema.Draft7Validator(schema).validate(yaml.safe_load(path.read_text()))


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
