"""Mitsuba 3 as a peer: `python mitsuba_side.py FOLDER VARIANT [tuned]`, of scalar_rgb or llvm_ad_rgb.

As it comes, or tuned: without Russian roulette, and without shadow rays where the sky is the only light.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import mitsuba as mi
import numpy as np
from protocol import Image, Job, Render, Skip, serve

Described = dict[str, Any]

THREADS = 2
#: Its roulette is played at every null collision, too: where most of a grid is far below the majorant, the default
#: ends nearly all longer paths, costs two to ten times the efficiency and hides the mean in rare huge samples.
#: So paths end by leaving where it is tuned.
DEFAULT_DEPTH, NO_ROULETTE = 5, 1 << 20
#: Samples of a pixel that a pass of an LLVM variant holds in memory at once.
PASS = 16
#: Of the diagonal of a unit cube to Mitsuba's cube from -1 to 1.
FROM_CUBE = np.array([[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1]])


def make(job: Job) -> tuple[dict[str, str], Render]:
    """Raises Skip for what Mitsuba does not have."""
    variant, tuned = sys.argv[2], "tuned" in sys.argv[3:]
    settings = choose(variant)
    described = Scene(job, tuned=tuned).described()
    scene = mi.load_dict(described)
    integrator = described["integrator"]["type"]

    def render(samples: int, seed: int) -> tuple[Image, float]:
        began = time.perf_counter()
        image = rendered(scene, samples, seed, samples if variant.startswith("scalar") else PASS)
        return image, time.perf_counter() - began

    if not variant.startswith("scalar"):
        render(1, 0)  # compiles the kernel of all numbers of samples that are powers of two
    roulette = "no Russian roulette" if tuned else "defaults"
    said = f"{integrator}, {THREADS} threads, unbounded depth, {roulette}{settings}"
    return {"name": f"Mitsuba 3 {variant}", "version": mi.__version__, "settings": said}, render


def choose(variant: str) -> str:
    """Sets the variant and the threads; what else is to be said. Raises Skip where LLVM is missing."""
    import drjit

    mi.set_variant(variant)
    drjit.set_thread_count(THREADS)
    mi.set_log_level(mi.LogLevel.Error)
    if variant.startswith("scalar"):
        return ""
    try:
        drjit.eval(drjit.arange(mi.Float, 2) + 1)
    except Exception as error:
        raise Skip(
            "no LLVM library of version 16 or newer: apt install libllvm19, or name it by DRJIT_LIBLLVM_PATH"
        ) from error
    return f", LLVM {drjit.detail.llvm_version()[0]}"


def rendered(scene: Any, samples: int, seed: int, most: int) -> Image:
    """In passes of at most so many samples, each with a seed of its own."""
    import drjit

    total = np.zeros(1)
    for number, first in enumerate(range(0, samples, most)):
        count = min(most, samples - first)
        image = mi.render(scene, spp=count, seed=(seed << 12) + number)
        drjit.eval(image)
        drjit.sync_thread()
        total = total + np.array(image, np.float64) * (count / samples)
    return np.asarray(total)


class Scene:
    """A scene in Mitsuba's words."""

    def __init__(self, job: Job, *, tuned: bool) -> None:
        self.job, self.scene, self.tuned = job, job.scene, tuned

    def described(self) -> Described:
        parts: Described = {"type": "scene", "integrator": self.integrator(), "camera": self.camera()}
        for kind in ("volumes", "surfaces", "lights"):
            for number, part in enumerate(self.scene[kind]):
                described = getattr(self, f"{kind[:-1]}_{part['kind']}", None)
                if described is None:
                    raise Skip(f"no {part['kind']} {kind[:-1]}")
                parts[f"{kind[:-1]}_{number}"] = described(part)
        return parts

    def integrator(self) -> Described:
        extinctions = [part.get("sigma_t", part.get("scale")) for part in self.scene["volumes"]]
        chromatic = any(isinstance(each, list) and len(set(each)) > 1 for each in extinctions)
        depth = NO_ROULETTE if self.tuned else DEFAULT_DEPTH
        return {"type": "volpathmis" if chromatic else "volpath", "max_depth": -1, "rr_depth": depth}

    def camera(self) -> Described:
        camera, film = self.scene["camera"], self.scene["film"]
        kinds = {"perspective", "orthographic"}
        if camera["kind"] not in kinds:
            raise Skip(f"no {camera['kind']} camera")
        if film["filter"] != {"kind": "box", "radius": 0.5}:
            raise Skip("the pixel filter is no box of a pixel")
        to_world = mi.ScalarTransform4f().look_at(origin=camera["origin"], target=camera["target"], up=camera["up"])
        if camera["kind"] == "orthographic":
            half = camera["height"] / 2
            to_world = to_world @ mi.ScalarTransform4f().scale([half, half, 1])
            view = {}
        else:
            view = {"fov": camera["fov"], "fov_axis": "y"}
        return {
            "type": camera["kind"],
            "to_world": to_world,
            "near_clip": 1e-3,
            "far_clip": 1e5,
            **view,
            "sampler": {"type": "independent"},
            "film": {
                "type": "hdrfilm",
                "width": film["width"],
                "height": film["height"],
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
        }

    # Media

    def volume_constant(self, volume: Described) -> Described:
        largest = float(np.max(volume["sigma_t"]))
        sigma = rgb((np.array(volume["sigma_t"]) / largest).tolist())
        medium = {"type": "homogeneous", "sigma_t": sigma, "scale": largest, **self.medium(volume)}
        shape = volume["shape"]
        if shape["kind"] == "sphere":
            return boundary({"type": "sphere", "center": shape["center"], "radius": shape["radius"]}, medium)
        if shape["kind"] != "box":
            raise Skip(f"no {shape['kind']} shape")
        low, high = np.array(shape["min"]), np.array(shape["max"])
        placed = np.diag([*(high - low), 1.0])
        placed[:3, 3] = low
        return boundary(box(np.array(shape["to_world"]) @ placed), medium)

    def volume_grid(self, volume: Described) -> Described:
        if volume["albedo_grid"] or volume["interpolation"] != "trilinear" or isinstance(volume["scale"], list):
            raise Skip("no translation of this grid")
        to_scene = self.job.to_scene(volume["file"])
        sigma = {
            "type": "gridvolume",
            "grid": mi.VolumeGrid(np.ascontiguousarray(self.job.values(volume["file"]))),
            "to_world": matrix(to_scene),
            "wrap_mode": "clamp",
            "raw": True,
        }
        medium = {"type": "heterogeneous", "sigma_t": sigma, "scale": volume["scale"], **self.medium(volume)}
        return boundary(box(to_scene), medium)

    def medium(self, volume: Described) -> Described:
        """What media of both kinds have. Shadow rays are cast only where some light must be sampled."""
        if volume["emission"]:
            raise Skip("its media do not emit")
        phase = volume["phase"]
        if phase["kind"] == "isotropic":
            described = {"type": "isotropic"}
        elif phase["kind"] == "henyey_greenstein":
            described = {"type": "hg", "g": phase["g"]}
        else:
            raise Skip(f"no translation of the phase function {phase['kind']}")
        sampled = not self.tuned or any(light["kind"] != "constant" for light in self.scene["lights"])
        return {"albedo": rgb(volume["albedo"]), "phase": described, "sample_emitters": sampled}

    # Surfaces

    def surface_rectangle(self, surface: Described) -> Described:
        return {"type": "rectangle", "to_world": matrix(surface["to_world"]), "bsdf": material(surface["material"])}

    def surface_sphere(self, surface: Described) -> Described:
        placed = {"center": surface["center"], "radius": surface["radius"]}
        return {"type": "sphere", **placed, "bsdf": material(surface["material"])}

    # Lights

    def light_constant(self, light: Described) -> Described:
        return {"type": "constant", "radiance": rgb(light["radiance"])}

    def light_directional(self, light: Described) -> Described:
        return {"type": "directional", "direction": light["direction"], "irradiance": rgb(light["irradiance"])}

    def light_spot(self, light: Described) -> Described:
        """Between `beam` and `cutoff` Mitsuba falls off by another curve."""
        axis = np.array(light["target"]) - np.array(light["position"])
        up = np.eye(3)[int(np.argmin(np.abs(axis)))]
        to_world = mi.ScalarTransform4f().look_at(origin=light["position"], target=light["target"], up=up)
        return {
            "type": "spot",
            "to_world": to_world,
            "intensity": rgb(light["intensity"]),
            "beam_width": light["beam"],
            "cutoff_angle": light["cutoff"],
        }


def rgb(colour: Any) -> Described:
    return {"type": "rgb", "value": colour if isinstance(colour, list) else [colour] * 3}


def matrix(rows: Any) -> Any:
    return mi.ScalarTransform4f(np.array(rows, float))


def box(unit_to_scene: Any) -> Described:
    return {"type": "cube", "to_world": matrix(unit_to_scene @ FROM_CUBE)}


def boundary(shape: Described, medium: Described) -> Described:
    """A shape of the same index inside and outside, filled by a medium."""
    return {**shape, "bsdf": {"type": "null"}, "interior": medium}


def material(described: Described) -> Described:
    """Both sides reflect."""
    if described["kind"] != "diffuse":
        raise Skip(f"no translation of the material {described['kind']}")
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(described["reflectance"])}}


if __name__ == "__main__":
    serve(make)
