"""Scenes as LuxCoreRender's.

What follows from its source (LuxCoreRender/LuxCore) and was measured:
- A heterogeneous volume is marched: a step takes the coefficients of a random point in it. That is biased, by the
  variance of the optical depth within a step; `step` keeps it below the noise.
- A volume's phase function is Schlick's, p_k = (1 - k²) / 4π(1 - k cos θ)². Henyey–Greenstein is a mixture of these,
  in closed form (`asymmetry`), so a texture that draws k anew from place to place gives it exactly.
- Its weights of multiple importance sampling forget Russian roulette on one side, so that with both a sky is too
  bright: a furnace shows 3 for 1. A sky of importance 0 is met by scattered paths alone, which is exact.
- Paths are exact to 16 collisions in a box of optical depth 5; after 24 some outshine the whole picture where the
  medium scatters forward and has a distant light.
- A density grid has sample i at i / n, not (i + 1/2) / n, and clamps at its edges.
- A spot light shines with I / cos θ: `mappoint`, a point light with a picture of its directions, is used instead.
- Pixels lie one row too low: `screenwindow` corrects it.
- Emission of a volume is added once for every step, not for its length.
"""

from __future__ import annotations

import contextlib
import sys
from typing import Any

import numpy as np
from protocol import Image, Job, Skip

with contextlib.redirect_stdout(sys.stderr):  # it says what it loads
    import pyluxcore

#: Largest change of the optical depth of a step within it, and the longest step in voxels.
CHANGE, LONGEST = 0.4, 1.0
#: Periods of the texture of `asymmetry` along the scene's longest side, its samples, and its direction.
PERIODS, SAMPLES, WAVE = 1024, 4096, np.array([0.5377, 0.6212, 0.5702])
#: Rows of its own table of a light's picture.
ROWS = 256

Settings = dict[str, Any]


def camera(camera: dict[str, Any], width: int, height: int) -> Settings:
    """A picture of two units' height in its own terms, moved by a row, as it counts rows from 1 to the height."""
    if camera["kind"] not in ("perspective", "orthographic"):
        raise Skip(f"a camera of the kind {camera['kind']} is not translated here")
    half = 1.0 if camera["kind"] == "perspective" else camera["height"] / 2
    row, aspect = 2 * half / height, width / height
    return {
        "scene.camera.type": camera["kind"],
        "scene.camera.lookat.orig": camera["origin"],
        "scene.camera.lookat.target": camera["target"],
        "scene.camera.up": camera["up"],
        "scene.camera.fieldofview": camera.get("fov", 40.0),
        "scene.camera.screenwindow": [-half * aspect, half * aspect, -half - row, half - row],
        "scene.camera.cliphither": 1e-3,
        "scene.camera.clipyon": 1e6,
        "scene.camera.autofocus.enable": False,
        "scene.camera.lensradius": 0.0,
    }


def lamp(scene: Any, name: str, light: dict[str, Any]) -> Settings:
    kind, key = light["kind"], f"scene.lights.{name}"
    if kind == "constant":
        return {f"{key}.type": "constantinfinite", f"{key}.color": rgb(light["radiance"]), f"{key}.importance": 0.0}
    if kind == "directional":
        return {
            f"{key}.type": "sharpdistant",
            f"{key}.direction": light["direction"],
            f"{key}.color": rgb(light["irradiance"]),
        }
    if kind == "spot":
        return spot(scene, name, light)
    raise Skip(f"a light of the kind {kind} is not translated here")


def spot(scene: Any, name: str, light: dict[str, Any]) -> Settings:
    """A point light whose picture is a cap about the pole. Its intensity is divided by the picture's mean over ROWS.

    Rows of these without light in their middle are dark in all their height: a faint rim keeps the last one lit.
    """
    theta = (np.arange(18000) + 0.5) / 100
    beam, cutoff = np.cos(np.radians([light["beam"], light["cutoff"]]))
    t = np.clip((np.cos(np.radians(theta)) - cutoff) / (beam - cutoff), 0, 1)
    cap = np.where((t > 0) | (theta > light["cutoff"] + 180 / ROWS), t * t * (3 - 2 * t), 1e-9)
    scene.DefineImageMap(f"{name}.map", np.repeat(cap.astype(np.float32), 2), 1.0, 1, 2, len(cap))
    middle = (np.arange(ROWS) + 0.5) / ROWS * 180
    weight = np.sin(np.radians(middle))
    mean = float(weight @ np.interp(middle, theta, cap) / weight.sum())
    position, target = np.array(light["position"]), np.array(light["target"])
    axis = (target - position) / np.linalg.norm(target - position)
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    to_scene = np.eye(4)
    to_scene[:3] = np.column_stack([side, np.cross(axis, side), axis, position])
    key = f"scene.lights.{name}"
    return {
        f"{key}.type": "mappoint",
        f"{key}.mapfile": f"{name}.map",
        f"{key}.gamma": 1.0,
        f"{key}.transformation": columns(to_scene),
        f"{key}.color": [mean * (4 * np.pi) ** 2 * c for c in rgb(light["intensity"])],
    }


def medium(scene: Any, job: Job, volume: dict[str, Any]) -> None:
    """The volume, in a box that lets everything pass."""
    if volume["emission"] is not None:
        raise Skip("its volumes add their emission once for every step of ray marching, not for its length")
    key, albedo = "scene.volumes.medium", np.array(rgb(volume["albedo"]))
    found: Settings = {f"{key}.multiscattering": True}
    if volume["kind"] == "constant":
        shape = volume["shape"]
        if shape["kind"] != "box":
            raise Skip(f"a volume in a {shape['kind']} is not translated here")
        to_scene = np.eye(4)
        to_scene[:3] = np.column_stack([np.diag(np.subtract(shape["max"], shape["min"])), shape["min"]])
        to_scene = np.array(shape["to_world"]) @ to_scene
        sigma_t = np.array(rgb(volume["sigma_t"]))
        found |= {
            f"{key}.type": "homogeneous",
            f"{key}.absorption": (sigma_t * (1 - albedo)).tolist(),
            f"{key}.scattering": (sigma_t * albedo).tolist(),
        }
    else:
        if volume["albedo_grid"] is not None or volume["interpolation"] != "trilinear":
            raise Skip("grids of the albedo, and grids without interpolation, are not translated here")
        to_scene = job.to_scene(volume["file"])
        values = job.values(volume["file"])
        scale = np.array(rgb(volume["scale"]))
        scene.Parse(properties(grid("density", values, to_scene, "clamp")))
        for name, factor in (("absorption", scale * (1 - albedo)), ("scattering", scale * albedo)):
            texture = {"type": "scale", "texture1": "density", "texture2": factor.tolist()}
            scene.Parse(properties({f"scene.textures.{name}.{k}": v for k, v in texture.items()}))
            found[f"{key}.{name}"] = name if factor.any() else [0.0, 0.0, 0.0]
        size, longest = step(values * scale.max(), to_scene), np.linalg.norm(to_scene[:3, :3], axis=0).sum()
        found |= {
            f"{key}.type": "heterogeneous",
            f"{key}.steps.size": size,
            f"{key}.steps.maxcount": int(longest / size) + 1,
        }
    mesh(scene, "medium", CORNERS @ to_scene[:3, :3].T + to_scene[:3, 3], SIDES)
    found[f"{key}.asymmetry"] = asymmetry(scene, volume["phase"], to_scene)
    found |= {
        "scene.materials.boundary.type": "null",
        "scene.materials.boundary.volume.interior": "medium",
        "scene.objects.medium.shape": "medium",
        "scene.objects.medium.material": "boundary",
    }
    scene.Parse(properties(found))


def step(sigma_t: Image, to_scene: Image) -> float:
    """Length of a step, scene units: so small that its optical depth changes by no more than CHANGE within it."""
    steepest = max(1e-30, *(float(np.abs(np.diff(sigma_t, axis=axis)).max()) for axis in range(3)))
    voxel = float(min(np.linalg.norm(to_scene[:3, i]) / n for i, n in enumerate(sigma_t.shape[2::-1])))
    return min(LONGEST * voxel, float(np.sqrt(CHANGE * voxel / steepest)))


def asymmetry(scene: Any, phase: dict[str, Any], to_scene: Image) -> Any:
    """Its parameter of asymmetry, which gives k = 1.55 g - 0.55 g³.

    With a = 2g / (1 + g²) and x of the density Beta(3/2, 1/2), the moments of (1 - k²) w(k), k = ax, are those of
    (1 - a cos θ)^(-3/2), of which Henyey–Greenstein is a multiple: w ∝ Beta(x) / (1 - a²x²) mixes p_k to it. The
    texture is w's quantile function of a phase that turns many times within a mean free path.
    """
    if phase["kind"] == "isotropic" or (phase["kind"] == "henyey_greenstein" and phase["g"] == 0):
        return [0.0, 0.0, 0.0]
    if phase["kind"] != "henyey_greenstein":
        raise Skip("its phase function is Schlick's; only Henyey–Greenstein is translated to it")
    a = 2 * phase["g"] / (1 + phase["g"] ** 2)
    angle = np.linspace(0, np.pi / 2, 200_001)  # x = sin²
    weight = np.sin(angle) ** 2 / (1 - (a * np.sin(angle) ** 2) ** 2)
    total = np.concatenate([[0], np.cumsum((weight[1:] + weight[:-1]) / 2)])
    # The texture is linear from sample to sample, so that its last one is met with half the others' share.
    k = a * np.sin(np.interp((np.arange(SAMPLES) + 0.5) / SAMPLES, total / total[-1], angle)) ** 2
    g = np.linspace(-0.938, 0.938, 200_001)  # where k rises with g, from -1 to 1
    values = np.interp(k, 1.55 * g - 0.55 * g**3, g).astype(np.float32)
    turns = np.eye(4)
    turns[0, :3] = WAVE * PERIODS / np.linalg.norm(to_scene[:3, :3], axis=0).max()
    scene.Parse(properties(grid("asymmetry", values[None, None], np.linalg.inv(turns), "repeat", 0.0)))
    return "asymmetry"


def grid(name: str, values: Image, to_scene: Image, wrap: str, middle: float = 0.5) -> Settings:
    """A texture of (z, y, x) values in the unit cube's image, sample i at (i + middle) / n."""
    nx, ny, nz = values.shape[2::-1]
    to_samples = np.linalg.inv(to_scene)
    to_samples[:3, 3] -= middle / np.array([nx, ny, nz])
    described = {
        "type": "densitygrid",
        "nx": nx,
        "ny": ny,
        "nz": nz,
        "storage": "float",
        "wrap": wrap,
        "data": values.astype(np.float32),
        "mapping.type": "globalmapping3d",
        "mapping.transformation": columns(to_samples),
    }
    return {f"scene.textures.{name}.{key}": value for key, value in described.items()}


CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
#: Its twelve triangles, counter-clockwise seen from outside.
SIDES = np.array(
    [
        *([0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]),
        *([2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]),
    ]
)


def ball() -> tuple[Image, Image]:
    """The unit sphere, which it has not, of 260,608 triangles: 2e-5 of the radius off; points, and corners of each."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 257), np.linspace(0, 2 * np.pi, 513), indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).reshape(-1, 3)
    at = np.arange(257 * 513).reshape(257, 513)
    upper = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:]], -1)[:-1]
    lower = np.stack([at[:-1, :-1], at[1:, 1:], at[:-1, 1:]], -1)[1:]
    return points, np.concatenate([upper.reshape(-1, 3), lower.reshape(-1, 3)])


def solid(scene: Any, name: str, surface: dict[str, Any]) -> None:
    if surface["material"]["kind"] != "diffuse":
        raise Skip(f"a material of the kind {surface['material']['kind']} is not translated here")
    if surface["kind"] == "rectangle":
        matrix = np.array(surface["to_world"])
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        mesh(scene, name, corners @ matrix[:3, :3].T + matrix[:3, 3], np.array([[0, 1, 2], [0, 2, 3]]))
    elif surface["kind"] == "sphere":
        points, faces = ball()
        mesh(scene, name, np.array(surface["center"]) + surface["radius"] * points, faces, points)
    else:
        raise Skip(f"a surface of the kind {surface['kind']} is not translated here")
    found = {
        f"scene.materials.{name}.type": "matte",
        f"scene.materials.{name}.kd": rgb(surface["material"]["reflectance"]),
        f"scene.objects.{name}.shape": name,
        f"scene.objects.{name}.material": name,
    }
    scene.Parse(properties(found))


def mesh(scene: Any, name: str, points: Image, faces: Image, normals: Image | None = None) -> None:
    """A shape; normals, where it has some, are smooth."""
    vectors = None if normals is None else [tuple(n) for n in normals.tolist()]
    corners, triangles = [tuple(p) for p in points.tolist()], [tuple(f) for f in faces.tolist()]
    scene.DefineMesh(name, corners, triangles, vectors, None, None, None)


def properties(found: Settings) -> Any:
    """Its own kind of dictionary."""
    made = pyluxcore.Properties()
    for key, value in found.items():
        if isinstance(value, np.ndarray):
            made.Set(pyluxcore.Property(key, []).AddAllFloat(np.ascontiguousarray(value).reshape(-1)))
        else:
            made.Set(pyluxcore.Property(key, list(value) if isinstance(value, list | tuple) else value))
    return made


def columns(matrix: Image) -> list[float]:
    """A matrix as it writes one: column by column."""
    numbers: list[float] = matrix.T.reshape(-1).tolist()
    return numbers


def rgb(value: Any) -> list[float]:
    return [float(v) for v in value] if isinstance(value, list | tuple) else [float(value)] * 3
