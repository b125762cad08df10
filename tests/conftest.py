"""What tests of the renderer share: the device, the lane widths it can run, and small scenes."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests import statistics
from tests.statistics import SIGNIFICANCE as SIGNIFICANCE

from woodcock.device import Context, Device, find
from woodcock.film import Film
from woodcock.probe import probe
from woodcock.render import Renderer
from woodcock.scene import Scene, parse

Picture = Callable[..., Film]
Rng = Callable[[int], np.random.Generator]


def pytest_sessionfinish(session: pytest.Session) -> None:
    """More comparisons than the level of each was made for are a failure."""
    made = len(statistics.COMPARISONS) + sum(OF_WORKERS)
    if hasattr(session.config, "workeroutput"):  # one of several processes: the first counts for all
        session.config.workeroutput["comparisons"] = made
    elif made > statistics.FAMILY and not statistics.FRESH:
        said = f"{made} statistical comparisons were made"
        print(f"\n{said}, but FAMILY in tests/statistics.py is {statistics.FAMILY}: raise it")
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


#: Comparisons that other processes have made, where the tests are run by several.
OF_WORKERS: list[int] = []


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    OF_WORKERS.append(getattr(node, "workeroutput", {}).get("comparisons", 0))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "lanes" in metafunc.fixturenames:
        widths = probe(find()).lanes
        # Of four widths the default tests leave out the second: each takes a compiler's time for every function.
        default = "not slow" in metafunc.config.getoption("markexpr")
        metafunc.parametrize("lanes", [width for width in widths if not (default and len(widths) > 3 and width == 4)])


@pytest.fixture(scope="session")
def device() -> Device:
    return find()


@pytest.fixture
def pocl(device: Device) -> None:
    """For tests of what only PoCL does."""
    if "Portable Computing Language" not in device.platform:
        pytest.skip(f"the first device is of {device.platform}; this is a test of PoCL: pip install 'woodcock[pocl]'")


@pytest.fixture(scope="session")
def context(device: Device) -> Context:
    return Context.on(device)


@pytest.fixture(scope="session")
def picture(device: Device) -> Picture:
    """Renders samples [0, n) of a scene given as its JSON's Python; a calibration run replaces the scene's seed."""

    def render(scene: dict[str, Any], samples: int, lanes: int | None = None) -> Film:
        scene = scene | {"seed": statistics.seed(scene.get("seed", 0))}
        return Renderer(described(scene), device, lanes=lanes).render(0, samples)

    return render


@pytest.fixture
def rng() -> Rng:
    """Random numbers for samples, by a seed that a calibration run replaces; inputs take numpy's own generator."""
    return lambda seed: np.random.default_rng(statistics.seed(seed))


def described(scene: dict[str, Any]) -> Scene:
    return parse(json.dumps(scene))


@pytest.fixture
def box() -> dict[str, Any]:
    """A grey unit cube seen along +z, filling the picture, in an environment of radiance 1, by random paths."""
    return {
        "camera": {
            "kind": "orthographic",
            "origin": [0.5, 0.5, -1],
            "target": [0.5, 0.5, 0.5],
            "up": [0, -1, 0],
            "height": 1,
        },
        "volumes": [
            {
                "kind": "constant",
                "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
                "sigma_t": 2,
                "albedo": 0.5,
            }
        ],
        "lights": [{"kind": "constant", "radiance": 1}],
        "film": {"width": 32, "height": 32},
        "integrator": {"kind": "volumetric_path"},  # also where nothing scatters
        "seed": 7,
    }


@pytest.fixture
def grid(tmp_path: Path) -> Callable[..., dict[str, Any]]:
    """A grid volume of an array [z][y][x], in the unit cube."""

    def volume(values: Any, **keys: Any) -> dict[str, Any]:
        file = tmp_path / f"grid{len(list(tmp_path.iterdir()))}.npy"
        np.save(file, values)
        return {"kind": "grid", "file": str(file), "albedo": 0.5, **keys}

    return volume


def z_score(film: Film, expected: Any) -> float:
    """How many standard errors a grey picture's mean lies off that of the expected values (a number or a picture)."""
    assert film.mean.shape[-1] == 1, "channels share their paths: compare them one by one"
    error = math.sqrt(float(film.variance().sum())) / film.mean.size
    return (float(film.mean.mean()) - float(np.mean(expected))) / error


@pytest.fixture(scope="session")
def agrees() -> Callable[[Film, Any], bool]:
    """Is the picture's mean that of the expected values? If it is not, this says so itself."""

    def check(film: Film, expected: Any) -> bool:
        statistics.accept_z(z_score(film, expected))
        return True

    return check
