"""Reading scenes, and saying what is wrong with them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from woodcock.scene.whole import Scene

T = TypeVar("T")

#: How the id of a file that was uploaded to a service begins.
UPLOADED = "sha256:"

# Keys that hold a union tagged by `kind`, or a list of such.
_TAGGED = ("camera", "emission", "filter", "integrator", "majorant", "material", "phase", "shape", "stop")
_TAGGED_ITEMS = ("volumes", "lights", "surfaces")


class SceneError(ValueError):
    """A scene that cannot be rendered; the text names the field and what would be right."""


def parse(text: str | bytes) -> Scene:
    """A scene from JSON. Raises SceneError, one line per fault."""
    try:
        return Scene.model_validate_json(text)
    except ValidationError as error:
        raise SceneError(explain(error.errors(include_url=False))) from None


def load(path: Path, folder: Path | None = None) -> Scene:
    """A scene from a JSON file; its files, but for ids of uploaded ones, are resolved against `folder`, or its own.

    Raises SceneError.
    """
    try:
        scene = parse(path.read_bytes())
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}") from None
    except SceneError as error:
        raise SceneError("\n".join(f"{path}: {line}" for line in str(error).splitlines())) from None
    base = path.parent if folder is None else folder
    return with_files(scene, lambda file: file if file.startswith(UPLOADED) else str(base / file))


def with_files(scene: Scene, rename: Callable[[str], str]) -> Scene:
    """The same scene with every file that it names renamed: volumes, meshes and pictures alike."""
    return _renamed(scene, rename)


def _renamed(value: T, rename: Callable[[str], str]) -> T:
    if isinstance(value, tuple):
        return tuple(_renamed(item, rename) for item in value)  # type: ignore[return-value]
    if not isinstance(value, BaseModel):
        return value
    changes: dict[str, Any] = {
        name: _renamed(item, rename) for name, item in value if isinstance(item, BaseModel | tuple)
    }
    if file := getattr(value, "file", None):
        changes["file"] = rename(file)
    return value.model_copy(update=changes)


def files(scene: Scene) -> tuple[str, ...]:
    """The files that a scene names, in order, each once."""
    found: dict[str, None] = {}

    def note(file: str) -> str:
        found[file] = None
        return file

    with_files(scene, note)
    return tuple(found)


def explain(errors: Sequence[Mapping[str, Any]]) -> str:
    """Pydantic's errors as text, a line each: `field: what is wrong (got value)`."""
    return "\n".join(f"{field_path(error['loc']) or 'scene'}: {fault(error)}" for error in errors)


def fault(error: Mapping[str, Any]) -> str:
    """What one of pydantic's errors says is wrong, without the field: `what is wrong (got value)`."""
    match error["type"]:
        case "extra_forbidden":
            message = "is not a known key"
        case "missing":
            message = "is required"
        case "union_tag_not_found":
            message = "needs a `kind`"
        case "union_tag_invalid":
            message = f"unknown kind; known are {error['ctx']['expected_tags']}"
        case _:
            message = error["msg"].removeprefix("Value error, ")
    got = error["input"]
    shown = json.dumps(got) if isinstance(got, int | float | str) and error["type"] != "json_invalid" else ""
    if shown:
        message += f" (got {shown if len(shown) <= 60 else shown[:60] + '…'})"
    return f"{message[:1].lower()}{message[1:]}"


def field_path(loc: Sequence[int | str]) -> str:
    """The path as the scene is written: `volumes[0].sigma_t` of pydantic's ("volumes", 0, "constant", "sigma_t").

    A key that is no name is quoted: `product["camera.fov"]`.
    """
    path = ""
    tagged = False
    for position, part in enumerate(loc):
        if isinstance(part, int):
            path += f"[{part}]"
        elif not tagged:
            path += f".{part}" if part.isidentifier() else f"[{json.dumps(part, ensure_ascii=False)}]"
        before = loc[position - 1] if isinstance(part, int) and position else part
        # Unions are tagged by kind: the part after one of these is the kind, not a key of the scene.
        tagged = not tagged and before in (_TAGGED_ITEMS if isinstance(part, int) else _TAGGED)
    return path.removeprefix(".")
