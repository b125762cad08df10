"""/api/v1/examples: scenes to start from, and /examples, where their files are"""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

from fastapi import APIRouter
from fastapi.staticfiles import StaticFiles
from pydantic import BaseModel, JsonValue

from woodcock import scene as scenes

FOLDER = Path(str(files("woodcock_client") / "examples"))

#: Name of the file -> what it shows, the simplest first.
ABOUT = {
    "block": "A translucent block, lit from one side: one homogeneous medium and a phase function.",
    "milk": "A glass ball full of milk under a lamp: light that scatters hundreds of times, and refraction.",
    "fog": "A spot light in fog: surfaces of three materials inside a medium.",
    "fireball": "An explosion from a volume file: density, and black-body emission from its temperature.",
    "shadow": "The same file as an X-ray: only absorption, so without noise.",
}

router = APIRouter(prefix="/api/v1/examples", tags=["examples"])
static = StaticFiles(directory=FOLDER)


class Example(BaseModel):
    """scene: as it is written, without its defaults; files: where those can be had that it names, by name, to be
    uploaded; picture: of 240 × 180 pixels."""

    name: str
    about: str
    scene: dict[str, JsonValue]
    files: dict[str, str]
    picture: str


class ExampleList(BaseModel):
    items: list[Example]


@router.get("")
def list_examples() -> ExampleList:
    """Scenes to start from."""
    return ExampleList(items=[_example(name) for name in ABOUT])


def _example(name: str) -> Example:
    text = (FOLDER / f"{name}.json").read_bytes()
    return Example(
        name=name,
        about=ABOUT[name],
        scene=json.loads(text),
        files={file: f"/examples/{file}" for file in scenes.files(scenes.parse(text))},
        picture=f"/web/submit/examples/{name}.webp",
    )
