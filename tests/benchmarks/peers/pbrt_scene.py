"""Scenes as pbrt-v4's text. Raises Skip where pbrt cannot render one, or nothing here translates it.

pbrt computes with four wavelengths, not with red, green and blue, and what is coloured twice (a coloured ball in
coloured light) has another colour there. So that pictures have the same mean, a colour is a spectrum that is constant
on three bands, one per channel. Only grids of coloured light take nothing but pbrt's own spectra of colours; beside
grey media these have the right mean too.

Read off pbrt-v4's source: a grid's samples lie at the middles of its voxels and beyond them it falls to 0; lights are
divided by the luminance of their spectrum (of D65, if it is made from a colour), grids of light are not.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from protocol import Image, Job, Skip

#: As good as none; pbrt has no word for it.
DEPTH = 1_000_000
#: Where blue ends and green ends, nanometres; pbrt's fixed wavelengths are 479, 546, 617 and 830.
EDGES = (499.5, 574.5)
#: ∫ȳ dλ, nanometres, to which pbrt brings D65 but not the light of an rgbgrid.
Y_INTEGRAL = 106.856895
Fields = dict[str, Any]


def numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def triple(value: Any) -> Image:
    """(3,) of one number or of red, green and blue."""
    return np.broadcast_to(np.asarray(value, float), (3,))


class Spectra:
    """Colours as pbrt's own spectra, exact in the mean where nothing is coloured twice."""

    def value(self, name: str, rgb: Image) -> str:
        return f'"rgb {name}" [{numbers(rgb)}]'

    def light(self, name: str, rgb: Image) -> str:
        return self.value(name, rgb)


@dataclass(frozen=True)
class Bands:
    """Colours as spectra of three bands; `shares` of them in the luminance of an even spectrum, red first."""

    shares: Image

    def value(self, name: str, rgb: Image) -> str:
        red, green, blue = rgb
        first, second = EDGES
        steps = (300, blue, first - 0.001, blue, first + 0.001, green)
        return f'"spectrum {name}" [{numbers((*steps, second - 0.001, green, second + 0.001, red, 900, red))}]'

    def light(self, name: str, rgb: Image) -> str:
        """Brought to a luminance of 1 by pbrt, and back to its own by `scale`."""
        return f'{self.value(name, rgb)} "float scale" {numbers([self.shares @ rgb])}'


Colours = Spectra | Bands


def coefficients(volume: Fields) -> tuple[Image, Image]:
    """σ_a and σ_s, (3,); of a grid, those of density 1."""
    sigma_t = triple(volume["sigma_t"] if volume["kind"] == "constant" else volume["scale"])
    albedo = triple(volume["albedo"])
    return sigma_t * (1 - albedo), sigma_t * albedo


def grey(volume: Fields) -> bool:
    return all(np.ptp(sigma) == 0 for sigma in coefficients(volume))


def written(job: Job, colours: Colours) -> str:
    """The scene as pbrt's text. Raises Skip."""
    scene = job.scene
    if scene["film"]["filter"] != {"kind": "box", "radius": 0.5}:
        raise Skip("pixel filters other than a box of one pixel are not translated")
    if len(scene["volumes"]) != 1:
        raise Skip("media that overlap do not add in pbrt")
    body = [
        _camera(scene["camera"], scene["film"]),
        'PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5',
        'Sampler "independent"',
        f'Integrator "volpath" "integer maxdepth" {DEPTH}',
        "WorldBegin",
        *(_light(light, colours) for light in scene["lights"]),
        *(_surface(surface, colours) for surface in scene["surfaces"]),
        _volume(scene["volumes"][0], job, colours),
    ]
    return "\n".join(body) + "\n"


def film(width: int, height: int) -> str:
    return f'Film "rgb" "integer xresolution" {width} "integer yresolution" {height} "bool savefp16" false'


def _camera(camera: Fields, size: Fields) -> str:
    """pbrt's camera space is left-handed: mirrored, +x is on the right as here."""
    width, height = size["width"], size["height"]
    if camera["kind"] == "perspective":
        half, more = 1.0, f' "float fov" {camera["fov"]!r}'
    elif camera["kind"] == "orthographic":
        half, more = camera["height"] / 2, ""
    else:
        raise Skip(f"the camera {camera['kind']} is not translated")
    wide = half * width / height
    window = f'"float screenwindow" [{numbers((-wide, wide, -half, half))}]'
    pose = numbers((*camera["origin"], *camera["target"], *camera["up"]))
    return f'{film(width, height)}\nScale -1 1 1\nLookAt {pose}\nCamera "{camera["kind"]}" {window}{more}'


def _light(light: Fields, colours: Colours) -> str:
    match light["kind"]:
        case "constant":
            return f'LightSource "infinite" {colours.light("L", triple(light["radiance"]))}'
        case "directional":
            way = f'"point3 from" [0 0 0] "point3 to" [{numbers(light["direction"])}]'
            return f'LightSource "distant" {way} {colours.light("L", triple(light["irradiance"]))}'
        case "spot":
            way = f'"point3 from" [{numbers(light["position"])}] "point3 to" [{numbers(light["target"])}]'
            cutoff = light["cutoff"]
            beam = 0.75 * cutoff if light["beam"] is None else light["beam"]
            cone = f'"float coneangle" {cutoff!r} "float conedeltaangle" {numbers([cutoff - beam])}'
            return f'LightSource "spot" {way} {cone} {colours.light("I", triple(light["intensity"]))}'
    raise Skip(f"the light {light['kind']} is not translated")


def _surface(surface: Fields, colours: Colours) -> str:
    material = surface["material"]
    if material["kind"] != "diffuse":
        raise Skip(f"the material {material['kind']} is not translated")
    made = f'Material "diffuse" {colours.value("reflectance", triple(material["reflectance"]))}'
    match surface["kind"]:
        case "sphere":
            return f"AttributeBegin\n{made}\n{_sphere(surface)}\nAttributeEnd"
        case "rectangle":
            corners = np.array([[x, y, 0, 1] for y in (-1, 1) for x in (-1, 1)]) @ np.array(surface["to_world"]).T
            patch = f'Shape "bilinearmesh" "point3 P" [{numbers(corners[:, :3].flat)}]'
            return f"AttributeBegin\n{made}\n{patch}\nAttributeEnd"
    raise Skip(f"the surface {surface['kind']} is not translated")


def _sphere(sphere: Fields) -> str:
    return f'Translate {numbers(sphere["center"])}\nShape "sphere" "float radius" {sphere["radius"]!r}'


#: The triangles of a box whose corners are numbered 4 z + 2 y + x, seen from outside counter-clockwise.
_BOX = np.array(
    [
        *([0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]),
        *([2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]),
    ]
)


def _box(low: Image, high: Image, to_world: Image) -> str:
    corners = np.array([[x[0], y[1], z[2], 1] for z in (low, high) for y in (low, high) for x in (low, high)])
    faces = _BOX if np.linalg.det(to_world[:3, :3]) > 0 else _BOX[:, ::-1]
    points = f'"point3 P" [{numbers((corners @ to_world.T)[:, :3].flat)}]'
    return f'Shape "trianglemesh" {points} "integer indices" [{" ".join(map(str, faces.flat))}]'


def _volume(volume: Fields, job: Job, colours: Colours) -> str:
    phase = volume["phase"]
    if phase["kind"] not in ("isotropic", "henyey_greenstein"):
        raise Skip(f"the phase function {phase['kind']} is not pbrt's")
    medium = f'MakeNamedMedium "medium" "float g" {phase.get("g", 0.0)!r}'
    if volume["kind"] == "grid":
        to_scene = job.to_scene(volume["file"])
        where = _box(np.zeros(3), np.ones(3), to_scene)
        made = f"Transform [{numbers(to_scene.T.flat)}]\n{medium} {_grid(volume, job, colours)}"
    else:
        if volume["emission"] is not None:
            raise Skip("the emission of homogeneous media is not translated")
        shape, made = volume["shape"], f'{medium} "string type" "homogeneous" {_sigmas(volume, colours)}'
        if shape["kind"] == "mesh":
            raise Skip("meshes are not translated")
        box = shape["kind"] == "box"
        where = _box(*(np.array(shape[k], float) for k in ("min", "max", "to_world"))) if box else _sphere(shape)
    inside = f'Material "interface"\nMediumInterface "medium" ""\n{where}'
    return f"AttributeBegin\n{made}\nAttributeEnd\nAttributeBegin\n{inside}\nAttributeEnd"


def _sigmas(volume: Fields, colours: Colours) -> str:
    absorbed, scattered = coefficients(volume)
    return f"{colours.value('sigma_a', absorbed)} {colours.value('sigma_s', scattered)}"


def _grid(volume: Fields, job: Job, colours: Colours) -> str:
    """In the unit cube. A layer of copies lies around it, so that nothing fades inside; the boundary cuts it off."""
    density = job.values(volume["file"])
    if density.ndim != 3 or volume["albedo_grid"] is not None or volume["interpolation"] != "trilinear":
        raise Skip("grids of colours, of albedo, or without interpolation are not translated")
    counts = np.array(density.shape[::-1])
    size = " ".join(f'"integer n{axis}" {count + 2}' for axis, count in zip("xyz", counts, strict=True))
    size += f' "point3 p0" [{numbers(-1 / counts)}] "point3 p1" [{numbers(1 + 1 / counts)}]'
    if volume["emission"] is None:
        values = numbers(np.pad(density, 1, mode="edge").ravel().tolist())
        return f'"string type" "uniformgrid" {size} {_sigmas(volume, colours)} "float density" [{values}]'
    absorbed, scattered = (
        np.repeat(density[..., None], 3, axis=3) * sigma.astype(np.float32) for sigma in coefficients(volume)
    )
    glow = emitted(_epsilon(volume, job), absorbed[..., 0].astype(float))
    rim = ((1, 1), (1, 1), (1, 1), (0, 0))
    arrays = {"sigma_a": absorbed, "sigma_s": scattered, "Le": glow}
    lists = (f'"rgb {name}" [{numbers(np.pad(a, rim, mode="edge").ravel().tolist())}]' for name, a in arrays.items())
    return f'"string type" "rgbgrid" {size} "float Lescale" {1 / Y_INTEGRAL!r} {" ".join(lists)}'


def _epsilon(volume: Fields, job: Job) -> Image:
    """ε of the density's voxels, (z, y, x, 3)."""
    emission = volume["emission"]
    if emission["kind"] != "grid" or not grey(volume):
        raise Skip("of emission, only grids of ε in grey media are translated")
    same = np.allclose(job.to_scene(emission["file"]), job.to_scene(volume["file"]))
    values = job.values(emission["file"])
    if not same or values.shape[:3] != job.values(volume["file"]).shape:
        raise Skip("absorption and emission share one grid in pbrt")
    colour = values if values.ndim == 4 else values[..., None]
    return np.asarray(colour * triple(emission["scale"]))


def emitted(epsilon: Image, absorbed: Image, rounds: int = 12) -> Image:
    """L of the voxels, (z, y, x, 3), for ε (z, y, x, 3) = σ_a L.

    pbrt interpolates σ_a and L apart, so that ε / σ_a at the voxels would be a few per cent too dark between them. L is
    made such that around every voxel, weighed as it is interpolated, σ_a L emits as much as ε does; factors alone get
    it there, so that no L is negative. Products of three linear functions are integrated exactly by two Gauss points.
    """
    points = 0.5 + np.array([-1, 1]) / math.sqrt(12)

    def at(values: Image) -> Image:
        """A grid, interpolated at the Gauss points of its cells; axes take turns to come first."""
        for _ in range(3):
            low, step = values[:-1], np.diff(values, axis=0)
            between = np.stack([low + step * point for point in points], axis=1)
            values = np.moveaxis(between.reshape(-1, *values.shape[1:]), 0, 2)
        return values

    def around(values: Image) -> Image:
        """Integrals over the cells, weighed by what each voxel has in them."""
        for _ in range(3):
            pairs = values.reshape(-1, 2, *values.shape[1:])
            total = np.zeros((len(pairs) + 1, *values.shape[1:]))
            for k, point in enumerate(points):
                total[:-1] += (1 - point) * pairs[:, k]
                total[1:] += point * pairs[:, k]
            values = np.moveaxis(total, 0, 2)
        return values

    sigma, light = at(absorbed), np.zeros(epsilon.shape)
    shares = around(sigma)
    for channel in range(3):
        wanted = around(at(epsilon[..., channel]))
        values = np.divide(wanted, shares, out=np.zeros(shares.shape), where=shares > 0)
        for _ in range(rounds):
            found = around(sigma * at(values))
            values *= np.divide(wanted, found, out=np.ones(found.shape), where=found > 0)
        light[..., channel] = values
    return light
