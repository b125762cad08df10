"""The design's arrows and names, read from the files."""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from pydantic import BaseModel

from woodcock.scene import Scene

ROOT = Path(__file__).parents[1]
KERNELS = ROOT / "kernels" / "woodcock"
PACKAGES = {
    "woodcock": KERNELS,
    "woodcock_server": ROOT / "server" / "woodcock_server",
    "woodcock_client": ROOT / "client" / "woodcock_client",
}
MOST_LINES = 400

#: Concept -> how a function of a kind is prefixed; a tracking kind says which of its two questions it answers.
PREFIXES = {
    "camera": ("camera_{}_",),
    "volume": ("volume_{}_",),
    "majorant": ("majorant_{}_",),
    "emission": ("emission_{}_",),
    "phase": ("phase_{}_",),
    "light": ("light_{}_",),
    "filter": ("filter_{}_",),
    "shape": ("shape_{}_",),
    "surface": ("surface_{}_",),
    "material": ("material_{}_",),
    "tracking": ("free_flight_{}_", "transmittance_{}_"),
}
#: Files beside the kinds that are none: how cameras stand, how a grid's voxels are stored, what phase functions share.
SHARED = {
    "camera": re.compile(r"pose\.py"),
    "volume": re.compile(r"(grid|field)_(float|half|uint8)\.h|field\.(h|py)|(compose|glow|media|text)\.py"),
    "majorant": re.compile(r"(global_)?walk\.h|(global|grid)_(ahead|control|cells|hops)\.h|(choice|control|hops)\.py"),
    "phase": re.compile(r"compose\.py|lobe_\w+\.h"),
    "surface": re.compile(r"(build|closed|compose|dispatch|emitters|hierarchy|point|records|traverse)\.(h|py)"),
}
KINDS = [
    (concept, kind)
    for concept in PREFIXES
    for kind in sorted(
        {
            path.stem
            for path in (KERNELS / concept).iterdir()
            if path.suffix in (".h", ".py") and path.name != "__init__.py"
            if not (concept in SHARED and SHARED[concept].fullmatch(path.name))
        }
    )
]
kinds = pytest.mark.parametrize(("concept", "kind"), KINDS)


def imports(package: str) -> Iterator[tuple[str, str]]:
    """Every import of a package's modules, as (file and line, module); names from a package count as modules of it."""
    for path in PACKAGES[package].rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{path}:{node.lineno}: imports here are absolute"
                inside = f"{node.module}." if node.module in PACKAGES else ""
                modules = [f"{inside}{alias.name}" for alias in node.names] if inside else [str(node.module)]
            else:
                continue
            for module in modules:
                yield f"{path.relative_to(ROOT)}:{node.lineno}", module


@pytest.mark.parametrize(
    ("package", "allowed"),
    [
        ("woodcock", r"woodcock\b.*"),
        ("woodcock_client", r"woodcock\.scene\b.*|woodcock_client\b.*"),
        ("woodcock_server", r"woodcock\b.*|woodcock_server\b.*"),
    ],
)
def test_arrows_point_one_way(package: str, allowed: str) -> None:
    ours = [(at, module) for at, module in imports(package) if module.split(".")[0] in PACKAGES]
    assert ours
    assert [(at, module) for at, module in ours if not re.fullmatch(allowed, module)] == []


def scene_kinds(annotation: Any = Scene) -> set[tuple[str, str]]:
    """(concept, kind) of every model in a scene's unions; `ConstantVolume` is the concept volume's."""
    if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
        return set().union(*map(scene_kinds, get_args(annotation)))
    found = set().union(*(scene_kinds(field.annotation) for field in annotation.model_fields.values()))
    if kind := annotation.model_fields.get("kind"):
        words = re.findall("FreeFlight|[A-Z][a-z]*", annotation.__name__)
        assert "_".join(words[:-1]).lower() == kind.default, annotation
        found.add((words[-1].lower(), kind.default))
    return found


def test_kinds_of_the_scene_and_files_are_the_same() -> None:
    tracking = {kind for concept, kind in scene_kinds() if concept in ("freeflight", "transmittance")}
    # Integrators and stops are no kinds of device code.
    described = {concept for concept, _ in scene_kinds()} - {"stop", "integrator", "freeflight", "transmittance"}
    in_scene = {(concept, kind) for concept, kind in scene_kinds() if concept in described}
    assert described == set(PREFIXES) - {"tracking"}
    assert in_scene == {(concept, kind) for concept, kind in KINDS if concept in described}
    # Of constant media, which have closed forms, nobody asks.
    assert tracking == {kind for concept, kind in KINDS if concept == "tracking"} - {"analytic", "exact"}


@kinds
def test_a_kind_has_device_code_and_oracle(concept: str, kind: str) -> None:
    for suffix in (".h", ".py"):
        assert (KERNELS / concept / f"{kind}{suffix}").is_file(), f"{concept}/{kind}{suffix} is missing"


@kinds
def test_functions_bear_their_kinds_name(concept: str, kind: str) -> None:
    text = (KERNELS / concept / f"{kind}.h").read_text()
    functions = re.findall(r"^(?:static )?inline [^(;]*?(\w+)\s*\(", text, re.MULTILINE)
    assert functions
    prefixes = tuple(prefix.format(kind) for prefix in PREFIXES[concept])
    assert [name for name in functions if not name.startswith(prefixes)] == []


@kinds
@pytest.mark.parametrize("where", ["tests/kernels/test_{}.py", "kernels/README.md"])
def test_a_kind_is_tested_and_documented(concept: str, kind: str, where: str) -> None:
    path = ROOT / where.format(concept)
    # As a word of its own, as part of a test's or a function's name, or as its model's
    named = re.compile(rf"(?<![a-z]){kind}(?![a-z])|\b{kind.title().replace('_', '')}{concept.title()}\b")
    assert named.search(path.read_text()), f"{path.relative_to(ROOT)} does not name the {concept} {kind}"


def files() -> list[Path]:
    """What git tracks, or would if it were added."""
    command = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("this is no git checkout")
    return [ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file()]


def test_files_are_short() -> None:
    code = (".py", ".h", ".cl", ".js", ".css", ".html")
    ours = (path for path in files() if path.suffix in code and not {"vendor", "golden"} & set(path.parts))
    lines = {str(path.relative_to(ROOT)): len(path.read_bytes().splitlines()) for path in ours}
    assert {path: count for path, count in lines.items() if count > MOST_LINES} == {}


def test_no_file_knows_this_machine() -> None:
    local = re.compile(rb"(?<![\w.\-}])/(?:work|root|home/\w+|Users/\w+)/|" + re.escape(bytes(ROOT)) + rb"\b")
    assert [str(path.relative_to(ROOT)) for path in files() if local.search(path.read_bytes())] == []
