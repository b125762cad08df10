"""What tests of the client share: a service whose faults they control, small scenes, a browser."""

from __future__ import annotations

import json
import os
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright

from woodcock.scene import Scene
from woodcock_client import Client

from .real import Gallery, serving
from .service import Service

ARGUMENTS = [
    *("--no-sandbox", "--disable-quic", "--no-first-run"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),  # WebGL by the processor, the same everywhere
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
]
expect.set_options(timeout=15_000)

SCENE: dict[str, Any] = {
    "camera": {"kind": "perspective", "origin": [0, 0, -4], "target": [0, 0, 0]},
    "volumes": [
        {
            "kind": "constant",
            "shape": {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
            "sigma_t": 1.0,
            "albedo": 0.9,
        }
    ],
    "lights": [{"kind": "constant", "radiance": 1.0}],
    "film": {"width": 64, "height": 64},
    "stop": {"kind": "samples", "samples": 64},
}


@pytest.fixture
def service() -> Iterator[Service]:
    running = Service()
    yield running
    running.close()


@pytest.fixture
def renders(service: Service, monkeypatch: pytest.MonkeyPatch) -> Service:
    """A service that renders what it is given."""
    add = service.add

    def render(id: str) -> None:
        for samples in (1, 16, 32, 64):
            service.advance(id, samples)
        service.finish(id, {"error": []})

    def added(scene: dict[str, Any], name: str = "") -> str:
        id = add(scene, name)
        threading.Timer(0.1, render, [id]).start()
        return id

    monkeypatch.setattr(service, "add", added)
    return service


@pytest.fixture
def scene_json() -> dict[str, Any]:
    """A small scene that every part of Woodcock can render."""
    return json.loads(json.dumps(SCENE))  # type: ignore[no-any-return]


@pytest.fixture
def scene_file(tmp_path: Path, scene_json: dict[str, Any]) -> Path:
    path = tmp_path / "box.json"
    path.write_text(json.dumps(scene_json))
    return path


@pytest.fixture(scope="session")
def gallery(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Gallery]:
    """A real service with two finished renders, which no test may change."""
    folder = tmp_path_factory.mktemp("gallery")
    scene = {**SCENE, "film": {"width": 48, "height": 32}, "stop": {"kind": "samples", "samples": 16}}
    scene |= {"orders": 1, "layers": ["albedo", "depth"]}
    scene["volumes"] = [{**SCENE["volumes"][0], "albedo": [0.9, 0.6, 0.3]}]
    with serving(folder) as address, Client(address) as client:
        made = [
            client.submit(Scene.model_validate({**scene, "seed": seed}), name=f"box, seed {seed}") for seed in (1, 2)
        ]
        for job in made:
            *_, last = client.follow(job.id)
            assert last.state == "succeeded", last.error
        yield Gallery(address, folder / "data", (made[0].id, made[1].id))


# The browser


@pytest.fixture(scope="module")  # while it lives its event loop runs in this thread, and no other can
def browser() -> Iterator[Browser]:
    chromium = shutil.which("chromium")
    if chromium is None:
        message = "chromium is missing: apt-get install chromium"
        if os.environ.get("WOODCOCK_REQUIRE_BROWSER") == "1":
            pytest.fail(message)
        pytest.skip(message)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    yield context
    context.close()


@pytest.fixture
def said(context: BrowserContext) -> Iterator[list[str]]:
    """What the console says; a test that expects something takes it out, the rest fails it."""
    said: list[str] = []
    context.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    context.on("weberror", lambda error: said.append(str(error.error)))
    yield said
    assert said == []


@pytest.fixture
def page(context: BrowserContext, said: list[str]) -> Page:
    return context.new_page()
