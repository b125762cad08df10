"""Blender Cycles through bpy 5.0: the adapter of its unbiased volumes ("null scattering") on the CPU.

bpy 5.0 for Python 3.11 brings all that is needed: OpenVDB to write grids for it, OpenImageIO to read its pictures.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from cycles_scene import make_scene
from protocol import Image, Job, Render, Skip, serve

bpy.utils.expose_bundled_modules()
import OpenImageIO  # noqa: E402  it is one of these modules

#: Samples have numbers to twice this.
LAST = 1 << 23
#: Bounces, of all kinds: the most that Cycles takes.
BOUNCES = 1024
SETTINGS = (
    "CPU, 2 threads; unbiased volumes, full-precision grids; {bounces} bounces at most, no clamping, denoising, guiding"
    " or adaptive sampling; seconds are those that Cycles reports for rendering without synchronization"
)


def make(job: Job) -> tuple[dict[str, Any], Render]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    _configure(job.scene["film"], job.folder)
    make_scene(job)

    def render(samples: int, seed: int) -> tuple[Image, float]:
        settings = bpy.context.scene.cycles
        # A window of its own: what its unbiased transmittances draw for all pixels alike depends on a sample's number,
        # not on the seed.
        start = seed * samples % LAST
        settings.sample_offset, settings.sample_subset_length = start, samples
        settings.samples, settings.seed = start + samples, seed
        # Made known to the persistent session, which would else render what it rendered before.
        bpy.context.scene.update_tag(refresh={"TIME"})
        bpy.ops.render.render(write_still=True)
        return _read(Path(bpy.context.scene.render.filepath))

    render(1, 1)
    described = {
        "name": "Blender Cycles",
        "version": bpy.app.version_string,
        "settings": SETTINGS.format(bounces=BOUNCES),
    }
    return described, render


def _configure(film: dict[str, Any], folder: Path) -> None:
    if film["filter"] != {"kind": "box", "radius": 0.5}:
        raise Skip("only the box filter of one pixel is translated")
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = film["width"], film["height"], 100
    render.threads_mode, render.threads = "FIXED", 2
    render.use_persistent_data = True
    render.use_compositing = render.use_sequencer = False
    render.filepath = str(folder / "cycles.exr")
    image = render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGB", "32", "NONE"
    cycles.device = "CPU"
    cycles.pixel_filter_type = "BOX"
    cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_guiding = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.volume_biased = False
    cycles.use_sample_subset = True
    for kind in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", BOUNCES)


def _read(file: Path) -> tuple[Image, float]:
    """The picture, and the seconds that Cycles wrote into its header."""
    opened = OpenImageIO.ImageInput.open(str(file))
    image, header = opened.read_image("float"), opened.spec()
    opened.close()
    seconds = 0.0
    for part in header.getattribute("cycles.ViewLayer.render_time").split(":"):
        seconds = 60 * seconds + float(part)
    return image[..., :3], seconds


if __name__ == "__main__":
    serve(make)
