"""LuxCoreRender through pyluxcore: its PATHCPU engine. `luxcore_scene.py` translates the scenes."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from luxcore_scene import Settings, camera, lamp, medium, properties, pyluxcore, solid
from protocol import Image, Job, Render, Skip, serve

THREADS = 2
#: Longest path.
DEPTH = 10_000


def make(job: Job) -> tuple[dict[str, Any], Render]:
    pyluxcore.Init(lambda message: None)
    scene = pyluxcore.Scene()
    film = job.scene["film"]
    if film["filter"] != {"kind": "box", "radius": 0.5}:
        raise Skip("its pixel filters are not translated here, but for a box of one pixel")
    scene.Parse(properties(camera(job.scene["camera"], film["width"], film["height"])))
    for i, light in enumerate(job.scene["lights"]):
        scene.Parse(properties(lamp(scene, f"light{i}", light)))
    if len(job.scene["volumes"]) > 1:
        raise Skip("where its volumes overlap one of them counts, not their sum")
    forward = any(volume["phase"]["kind"] != "isotropic" for volume in job.scene["volumes"])
    if forward and any(light["kind"] == "directional" for light in job.scene["lights"]):
        raise Skip("under a distant light its long paths of forward scattering outshine the picture, so means disagree")
    for volume in job.scene["volumes"]:
        medium(scene, job, volume)
    for i, surface in enumerate(job.scene["surfaces"]):
        solid(scene, f"surface{i}", surface)
    settings = "PATHCPU, two threads, Sobol sampler without adaptive sampling, no clamping, the sky met by paths alone"
    described = {"name": "LuxCoreRender PATHCPU", "version": pyluxcore.Version(), "settings": settings}

    def render(samples: int, seed: int) -> tuple[Image, float]:
        config = pyluxcore.RenderConfig(properties(engine(film, samples, seed)), scene)
        session = pyluxcore.RenderSession(config)
        session.Start()
        start = time.perf_counter()
        while not session.HasDone():
            time.sleep(0.0005)
            session.UpdateStats()
        seconds = time.perf_counter() - start
        image = np.empty((film["height"], film["width"], 3), np.float32)
        session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, image, 0)
        session.Stop()
        return image[::-1].copy(), seconds

    render(1, 0)
    return described, render


def engine(film: dict[str, Any], samples: int, seed: int) -> Settings:
    return {
        "renderengine.type": "PATHCPU",
        "renderengine.seed": seed + 1,
        "native.threads.count": THREADS,
        "sampler.type": "SOBOL",
        "sampler.sobol.adaptive.strength": 0.0,
        "path.pathdepth.total": DEPTH,
        "path.pathdepth.diffuse": DEPTH,
        "path.pathdepth.glossy": DEPTH,
        "path.pathdepth.specular": DEPTH,
        "path.clamping.variance.maxvalue": 0.0,
        "path.hybridbackforward.enable": False,
        "batch.haltspp": samples,
        "film.width": film["width"],
        "film.height": film["height"],
        "film.filter.type": "BOX",
        "film.filter.width": 0.5,
        "film.imagepipelines.0.0.type": "NOP",
        "film.outputs.0.type": "RGB",
        "film.outputs.0.index": 0,
        "film.outputs.0.filename": "image.exr",
    }


if __name__ == "__main__":
    serve(make)
