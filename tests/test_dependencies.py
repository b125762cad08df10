"""What an installation pulls in: the client neither a renderer nor a service, each extra just its own."""

from __future__ import annotations

import ast
import importlib.metadata
import os
import subprocess
import sys
import tomllib
import venv
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
#: Package -> the extras that hold what it imports, beside what the client's installation has; and where it lies.
PACKAGES = {
    "woodcock": (("render", "denoise"), ROOT / "kernels" / "woodcock"),
    "woodcock_server": (("server", "s3"), ROOT / "server" / "woodcock_server"),
    "woodcock_client": ((), ROOT / "client" / "woodcock_client"),
}
#: Distributions that are imported as part of another, which is declared.
PARTS = {
    "starlette": "fastapi",
    "anyio": "starlette",
    "dask": "distributed",
    "tornado": "distributed",
    "markupsafe": "jinja2",
    "httpcore2": "httpx2",
}
#: Extras that only choose what another's libraries come with.
CHOICES = {"pocl", "postgres"}
#: What only some scenes or commands need, imported when they do.
AT_NEED = {"blosc", "flip_evaluator", "mitsuba_oidn", "trimesh"}

#: What a library of ours needs for what we ask of it, and we do not import.
FOR_OTHERS: set[str] = set()


@cache
def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]  # type: ignore[no-any-return]


def declared(extra: str | None) -> list[Requirement]:
    """The requirements of an extra, or of the installation without any; extras of ours in it are left out."""
    found = project()["optional-dependencies"][extra] if extra else project()["dependencies"]
    return [one for one in map(Requirement, found) if one.name != project()["name"]]


def with_extras(*extras: str) -> list[Requirement]:
    """What an installation with these extras asks for."""
    asked = list(map(Requirement, project()["dependencies"]))
    waiting = list(extras)
    for extra in waiting:
        asked += declared(extra)
        for one in map(Requirement, project()["optional-dependencies"][extra]):
            if one.name == project()["name"]:
                waiting += one.extras
    return asked


def closure(requirements: list[Requirement]) -> set[str]:
    """Names of the distributions that these pull in, by what is installed here; those that are not are leaves."""
    found: set[tuple[str, str]] = set()

    def add(requirement: Requirement) -> None:
        for extra in ("", *requirement.extras):
            key = (canonicalize_name(requirement.name), extra)
            if key in found:
                continue
            found.add(key)
            try:
                needs = importlib.metadata.requires(requirement.name) or []
            except importlib.metadata.PackageNotFoundError:
                continue
            for need in map(Requirement, needs):
                if need.marker is None or need.marker.evaluate({"extra": extra}):
                    add(need)

    for requirement in requirements:
        add(requirement)
    return {name for name, _ in found}


@cache
def distribution(module: str) -> str:
    """The distribution of a top-level module."""
    names = importlib.metadata.packages_distributions().get(module, [module])
    return canonicalize_name(names[0])


def modules_of(distributions: set[str]) -> set[str]:
    """Top-level modules that these distributions hold."""
    held = importlib.metadata.packages_distributions().items()
    return {module for module, names in held if {canonicalize_name(name) for name in names} <= distributions}


def imported(folder: Path) -> Iterator[tuple[str, str]]:
    """File and distribution of every import of other people's code; none in blocks for type checkers alone."""
    for path in folder.rglob("*.py"):
        tree = ast.parse(path.read_text())
        for node in ast.walk(tree):
            if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
                node.body = []
        for node in ast.walk(tree):
            names: list[str] = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module]
            for module in {name.split(".")[0] for name in names}:
                if module not in sys.stdlib_module_names and module not in PACKAGES:
                    yield str(path.relative_to(ROOT)), distribution(module)


def names(requirements: list[Requirement]) -> set[str]:
    return {canonicalize_name(one.name) for one in requirements}


# What is declared


def test_the_client_needs_little() -> None:
    assert names(with_extras()) == {"httpx2", "pydantic", "rich", "typer"}
    pulled = closure(with_extras())
    assert "pydantic-core" in pulled, "it looks further than the first requirements"
    assert not pulled & {"pyopencl", "numpy", "fastapi", "sqlalchemy", "distributed", "uvicorn", "openimageio"}


def test_each_extra_adds_just_its_own() -> None:
    client, renderer = closure(with_extras()), closure(with_extras("render"))
    service = closure(with_extras("server"))
    assert {"numpy", "pyopencl"} <= renderer - client
    choices = {"pocl-binary-distribution", "mitsuba-oidn"}
    assert not renderer & {"fastapi", "sqlalchemy", "distributed", "uvicorn", *choices}
    assert renderer < service, "the service renders"
    assert not service & choices
    assert closure(with_extras("render", "pocl")) - renderer == {"pocl-binary-distribution"}
    assert "mitsuba-oidn" in closure(with_extras("render", "denoise")) - renderer
    assert not service & {"hypothesis", "mypy", "playwright", "pytest", "ruff", "scipy"}


def test_a_requirement_is_declared_once() -> None:
    parts = [declared(extra) for extra in (None, *project()["optional-dependencies"])]
    everywhere = [name for part in parts for name in sorted(names(part))]
    twice = {name for name in everywhere if everywhere.count(name) > 1}
    assert twice == {"pyopencl"}, "`render` has it, and `pocl` chooses its driver"


@pytest.mark.parametrize("package", PACKAGES)
def test_what_a_package_imports_is_in_its_extra(package: str) -> None:
    extras, folder = PACKAGES[package]
    asked = names(with_extras(*extras))
    for part, whole in PARTS.items():
        if whole in asked:
            assert part in closure([Requirement(whole)]), f"{whole} no longer brings {part}"
            asked.add(part)
    found = list(imported(folder))
    assert found
    assert [(at, name) for at, name in found if name not in asked] == []


def test_what_is_declared_is_imported() -> None:
    found = {name for _, folder in PACKAGES.values() for _, name in imported(folder)}
    extras = set(project()["optional-dependencies"]) - {"test"} - CHOICES
    asked = set().union(names(declared(None)), *(names(declared(extra)) for extra in extras))
    assert asked - found == FOR_OTHERS


# What is imported indeed

REFUSING = """
import sys
class Refusing:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {refused!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Refusing())
"""


def python(code: str, refused: set[str], *arguments: str) -> str:
    """What code prints in an interpreter in which these modules cannot be imported."""
    done = subprocess.run(
        [sys.executable, "-c", REFUSING.format(refused=sorted(refused)) + code, *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def beyond(*extras: str) -> set[str]:
    """Modules that are installed here, for the tests, and are not with these extras."""
    return modules_of(closure(with_extras("test")) - closure(with_extras(*extras))) - set(PACKAGES)


def test_the_refusing_interpreter_refuses() -> None:
    with pytest.raises(AssertionError, match="No module named 'numpy'"):
        python("import woodcock.film", {"numpy"})


def test_the_client_runs_without_renderer_and_service() -> None:
    refused = beyond()
    assert {"numpy", "pyopencl", "fastapi", "sqlalchemy", "distributed"} <= refused
    python("import woodcock.scene, woodcock_client.client, woodcock_client.cli, woodcock_client.demo", refused)
    command = "from woodcock_client.cli import main\nmain()"
    assert "submit" in python(command, refused, "--help")
    assert "SCENE.json" in python(command, refused, "submit", "--help")


def test_a_scene_needs_pydantic_alone() -> None:
    python("import woodcock.scene", beyond() | {"httpx2", "rich", "typer"})


def test_the_renderer_runs_without_service() -> None:
    refused = beyond("render", "denoise")
    assert {"fastapi", "sqlalchemy", "distributed"} <= refused
    folder = PACKAGES["woodcock"][1]
    parts = (path.relative_to(folder.parent).with_suffix("").parts for path in folder.rglob("*.py"))
    modules = {".".join(part for part in one if part != "__init__") for one in parts if one[-1] != "__main__"}
    python(f"import importlib\nfor name in {sorted(modules)!r}: importlib.import_module(name)", refused)


def test_what_few_scenes_need_is_imported_when_they_do() -> None:
    python("import woodcock.render, woodcock.start, woodcock.command, woodcock.report", beyond("render") | AT_NEED)


def test_the_service_runs_without_a_client_of_object_stores() -> None:
    python("import woodcock_server.command, woodcock_server.backup", {"obstore"})


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_an_installation_of_the_client(tmp_path: Path) -> None:
    def run(*command: str | Path) -> str:
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        done = subprocess.run(
            list(map(str, command)), cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        if "Could not find a version" in done.stderr or "NewConnectionError" in done.stderr:
            pytest.skip(f"the package index does not answer: {done.stderr.splitlines()[-1]}")
        assert done.returncode == 0, done.stderr
        return done.stdout

    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", tmp_path, ROOT)
    (wheel,) = tmp_path.glob("*.whl")
    venv.create(tmp_path / "client", with_pip=True)
    bin = tmp_path / "client" / "bin"
    run(bin / "pip", "install", wheel)
    assert "SCENE.json" in run(bin / "woodcock", "submit", "--help")
    assert "needs pip install" in run(bin / "woodcock", "--help")
    run(bin / "python", "-c", "import woodcock.scene")
    installed = {line.split("==")[0].lower() for line in run(bin / "pip", "list", "--format=freeze").splitlines()}
    assert {canonicalize_name(name) for name in installed} - {"pip", "setuptools", "woodcock"} <= closure(with_extras())
    assert not installed & {"numpy", "pyopencl", "fastapi"}
