"""pbrt's shapes, what they are made of, what they emit and what fills them."""

from __future__ import annotations

import math

import numpy as np

from woodcock.importing import colour
from woodcock.importing.draft import GOES_ON, Draft, seen_through
from woodcock.importing.geometry import Disk, Faces, Fields, Geometry, Mesh, MeshFile, Rectangle, Sphere
from woodcock.importing.pbrt.media import Media
from woodcock.importing.pbrt.parameters import Parameters
from woodcock.importing.pbrt.world import Directive, Shape, World
from woodcock.importing.report import SourceError, shown
from woodcock.importing.transforms import Array, determinant, normal, point, uniform_scale

#: Glasses that pbrt knows by name, at the sodium line.
GLASSES = {
    "glass-BK7": 1.5168,
    "glass-BAF10": 1.67,
    "glass-FK51A": 1.4866,
    "glass-LASF9": 1.8503,
    "glass-F5": 1.6727,
    "glass-F10": 1.7283,
    "glass-F11": 1.7847,
}
GREY: Fields = {"kind": "diffuse", "reflectance": 0.5}


class Shapes:
    def __init__(self, draft: Draft, source: World, world: Array) -> None:
        self._draft, self._source, self._world = draft, source, world
        self._media = Media(draft, source, world)
        self._materials: dict[int, Fields | None] = {}

    def shape(self, shape: Shape) -> None:
        directive, graphics = shape.directive, shape.graphics
        where = directive.where
        geometry = self._geometry(directive)
        if geometry is None:
            return
        # pbrt's quadrics turn inside out where their placement mirrors, its triangles do not
        swaps = isinstance(geometry, Sphere | Disk) and determinant(directive.to_world) < 0
        inside = self._media.medium(graphics.inside, where) if graphics.inside != graphics.outside else None
        material = self._material(graphics.material)
        if graphics.area_light is not None:
            material = self._shining(graphics.area_light, material, where)
        elif material is None and graphics.inside == graphics.outside:
            self._draft.report.note(where, "left out: a boundary that lets everything pass and holds no medium")
        if graphics.outside not in ("", graphics.inside) and seen_through(material):
            self._draft.report.note(where, GOES_ON)
        self._draft.shape(where, geometry, material, graphics.reverse != swaps, inside)

    def _geometry(self, directive: Directive) -> Geometry | None:
        where, parameters = directive.where, directive.parameters
        parameters.used = True
        matrix = self._world @ directive.to_world
        match directive.kind:
            case "sphere":
                radius = parameters.number("radius", 1.0)
                if (factor := uniform_scale(matrix)) is None:
                    self._draft.report.note(where, "left out: a sphere that is scaled to an ellipsoid")
                    return None
                for name in ("zmin", "zmax", "phimax"):
                    if name in parameters:
                        parameters.number(name, 0.0)
                        self._draft.report.note(parameters.at(name), f"{name} is not carried over: the sphere is whole")
                return Sphere(matrix[:3, 3], _positive(radius * factor, where, "radius"))
            case "disk":
                return self._disk(directive, matrix)
            case "trianglemesh":
                return self._triangles(directive, matrix)
            case "bilinearmesh":
                return self._bilinear(directive, matrix)
            case "plymesh":
                name, at = parameters.string("filename", ""), parameters.at("filename")
                file = self._draft.refer(name, parameters.folder, at)
                if name.endswith(".gz"):
                    self._draft.report.note(at, "the mesh is packed: unpack it with gunzip")
                return MeshFile(file, parameters.folder / name, matrix)
        self._draft.report.note(
            where,
            f"left out: the shape {shown(directive.kind)}; sphere, disk, trianglemesh, bilinearmesh and plymesh "
            "are known",
        )
        parameters.passed_over(*parameters.found)
        return None

    def _disk(self, directive: Directive, matrix: Array) -> Disk | None:
        where, parameters = directive.where, directive.parameters
        across = matrix[:3, :2].T @ matrix[:3, :2]
        if not np.allclose(across, across[0, 0] * np.eye(2), rtol=0, atol=1e-5 * across[0, 0]):
            self._draft.report.note(where, "left out: a disk that is scaled to an ellipse")
            return None
        for name, whole in (("innerradius", 0.0), ("phimax", 360.0)):
            if parameters.number(name, whole) != whole:
                self._draft.report.note(parameters.at(name), f"{name} is not carried over: the disk is whole")
        center = point(matrix, np.array([0.0, 0.0, parameters.number("height", 0.0)]))
        facing = normal(matrix, np.array([0.0, 0.0, 1.0]))
        radius = _positive(parameters.number("radius", 1.0) * math.sqrt(across[0, 0]), where, "radius")
        return Disk(center, facing / np.linalg.norm(facing), radius)

    def _corners(self, parameters: Parameters, each: int) -> tuple[Array, Faces, Array | None]:
        """Points (n, 3), indices (m, each), and normals (n, 3)."""
        corners, normals = parameters.points("P"), parameters.points("N")
        if corners is None:
            raise SourceError(f'{parameters.where}: a mesh needs "point3 P"')
        indices = parameters.numbers("indices", "integer")
        if indices is None and len(corners) == each:
            indices = np.arange(each, dtype=float)
        if indices is None or indices.size == 0 or indices.size % each:
            raise SourceError(f'{parameters.at("indices")}: a mesh needs "integer indices", {each} for every face')
        if not ((indices >= 0) & (indices < len(corners)) & (indices == np.floor(indices))).all():
            raise SourceError(f"{parameters.at('indices')}: indices must be from 0 to {len(corners) - 1}")
        if normals is not None and len(normals) != len(corners):
            raise SourceError(f"{parameters.at('N')}: there must be as many normals as points")
        return corners, indices.astype(np.int32).reshape(-1, each), normals

    def _triangles(self, directive: Directive, matrix: Array) -> Mesh:
        parameters = directive.parameters
        parameters.passed_over("uv", "S", "faceIndices")
        corners, faces, normals = self._corners(parameters, 3)
        return _mesh(matrix, corners, faces, normals)

    def _bilinear(self, directive: Directive, matrix: Array) -> Geometry:
        """Flat patches: a parallelogram alone is a rectangle, all else triangles."""
        parameters = directive.parameters
        parameters.passed_over("uv", "faceIndices")
        corners, patches, normals = self._corners(parameters, 4)
        p00, p10, p01, p11 = (corners[patches[:, i]] for i in range(4))
        size = float(np.linalg.norm(np.ptp(corners, axis=0)))
        if len(patches) == 1 and np.allclose(p00 + p11, p10 + p01, rtol=0, atol=1e-6 * size) and normals is None:
            u, v = (p10 - p00)[0] / 2, (p01 - p00)[0] / 2
            across = np.cross(u, v)
            square = np.eye(4)
            square[:3, 0], square[:3, 1], square[:3, 3] = u, v, (p10 + p01)[0] / 2
            square[:3, 2] = across / (np.linalg.norm(across) or 1.0)
            placed = matrix @ square
            placed[:3, 2] = normal(matrix, square[:3, 2])
            placed[:3, 2] /= np.linalg.norm(placed[:3, 2])
            if np.linalg.norm(across) > 0:
                return Rectangle(placed)
        heights = np.einsum("ij,ij->i", p11 - p00, np.cross(p10 - p00, p01 - p00))
        if (np.abs(heights) > 1e-6 * size**3).any():
            self._draft.report.note(directive.where, "curved patches become two triangles each")
        faces = np.concatenate([patches[:, [0, 1, 3]], patches[:, [0, 3, 2]]])
        return _mesh(matrix, corners, faces, normals)

    # Materials

    def _material(self, material: Directive | str | None) -> Fields | None:
        """None for what lets everything pass."""
        if isinstance(material, str):
            if material not in self._source.materials:
                raise SourceError(f"{self._draft.source}: there is no material {shown(material)}")
            material = self._source.materials[material]
        if material is None:
            return GREY
        if id(material) not in self._materials:
            self._materials[id(material)] = self._made(material)
        return self._materials[id(material)]

    def _made(self, material: Directive) -> Fields | None:
        parameters = material.parameters
        parameters.used = True
        match material.kind:
            case "" | "none" | "interface":
                return None
            case "diffuse":
                return {"kind": "diffuse", "reflectance": self._share(parameters)}
            case "dielectric":
                return self._dielectric(parameters)
        reflectance = self._share(parameters)
        self._draft.report.note(
            material.where, f"the material {shown(material.kind)} is not carried over; a diffuse surface stands for it"
        )
        parameters.passed_over(*parameters.found)
        return {"kind": "diffuse", "reflectance": reflectance}

    def _share(self, parameters: Parameters) -> colour.Colour:
        value = colour.triple(parameters.spectrum("reflectance", 0.5))
        if value.min() < 0 or value.max() > 1:
            self._draft.report.note(parameters.at("reflectance"), "the reflectance is brought between 0 and 1")
        return colour.simple(np.clip(value, 0, 1))

    def _dielectric(self, parameters: Parameters) -> Fields:
        roughness = parameters.number("roughness", 0.0)
        both = [parameters.number(name, roughness) for name in ("uroughness", "vroughness")]
        if both[0] != both[1]:
            self._draft.report.note(parameters.where, "the roughness is the same in every direction here")
        mean = sum(both) / 2
        if parameters.boolean("remaproughness", True):
            mean = math.sqrt(max(mean, 0.0))
        ior = self._ior(parameters)
        if mean < 0.001:  # pbrt takes it for smooth as well
            return {"kind": "dielectric", "ior": ior}
        if mean > 1:
            self._draft.report.note(parameters.where, "the roughness is brought to 1")
        return {"kind": "rough_dielectric", "ior": ior, "roughness": min(mean, 1.0)}

    def _ior(self, parameters: Parameters) -> float:
        found = parameters.found.get("eta")
        if found is not None and found.values and found.values[0] in GLASSES:
            parameters.passed_over("eta")
            self._draft.report.note(
                found.where, f"{shown(found.values[0])} has one refractive index here, no dispersion"
            )
            return GLASSES[found.values[0]]
        eta = colour.triple(parameters.spectrum("eta", 1.5))
        if not (eta == eta[0]).all():
            self._draft.report.note(parameters.at("eta"), "eta has one value here, no dispersion")
        if not 0.2 <= eta.mean() <= 5:
            raise SourceError(f"{parameters.at('eta')}: eta must be from 0.2 to 5, not {eta.mean():g}")
        return float(eta.mean())

    def _shining(self, light: Directive, material: Fields | None, where: str) -> Fields | None:
        parameters = light.parameters
        parameters.used = True
        if light.kind != "diffuse":
            raise SourceError(f"{light.where}: an area light must be diffuse, not {shown(light.kind)}")
        if material is None:
            self._draft.report.note(where, "lets nothing pass here, because it shines")
        elif material.get("reflectance") != 0.0:
            self._draft.report.note(where, "reflects nothing here, because it shines")
        for name in ("filename", "power"):
            if name in parameters:
                parameters.passed_over(name)
                self._draft.report.note(parameters.at(name), f"{name} is not carried over: L and scale alone count")
        radiance = colour.triple(parameters.light("L", 1.0)) * parameters.number("scale", 1.0)
        two_sided = {"two_sided": True} if parameters.boolean("twosided", False) else {}
        return {"kind": "emissive", "radiance": colour.simple(radiance), **two_sided}


def _mesh(matrix: Array, corners: Array, faces: Faces, normals: Array | None) -> Mesh:
    """In the world, where a placement that mirrors leaves the outside outside."""
    if determinant(matrix) < 0:
        faces = np.ascontiguousarray(faces[:, ::-1])
    turned = None if normals is None else normal(matrix, normals)
    if turned is not None:
        turned = turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-30)
    return Mesh(point(matrix, corners), faces, turned)


def _positive(value: float, where: str, what: str) -> float:
    if not 0 < value < np.inf:
        raise SourceError(f"{where}: {what} must be more than 0, not {value:g}")
    return value
