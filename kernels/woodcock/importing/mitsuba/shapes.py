"""Mitsuba's shapes, what they are made of, what they emit and what fills them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from woodcock.importing import colour
from woodcock.importing.draft import GOES_ON, Draft, seen_through
from woodcock.importing.geometry import Cube, Disk, Fields, Geometry, MeshFile, Rectangle, Sphere
from woodcock.importing.mitsuba.element import Element
from woodcock.importing.mitsuba.media import Media
from woodcock.importing.report import SourceError, number, shown
from woodcock.importing.transforms import Array, determinant, normal, translate, uniform_scale

#: Mitsuba's names of refractive indices.
IOR = {
    "vacuum": 1.0,
    "helium": 1.000036,
    "hydrogen": 1.000132,
    "air": 1.000277,
    "carbon dioxide": 1.00045,
    "water": 1.333,
    "acetone": 1.36,
    "ethanol": 1.361,
    "carbon tetrachloride": 1.461,
    "glycerol": 1.4729,
    "benzene": 1.501,
    "silicone oil": 1.52045,
    "bromine": 1.661,
    "water ice": 1.31,
    "fused quartz": 1.458,
    "pyrex": 1.47,
    "acrylic glass": 1.49,
    "polypropylene": 1.49,
    "bk7": 1.5046,
    "sodium chloride": 1.544,
    "amber": 1.55,
    "pet": 1.575,
    "diamond": 2.419,
}
CLOSED = (Sphere, Cube)
GREY: Fields = {"kind": "diffuse", "reflectance": 0.5}


class Shapes:
    def __init__(self, draft: Draft, world: Array) -> None:
        self._draft, self._world = draft, world
        self._media = Media(draft, world)

    def shape(self, element: Element) -> None:
        if element.kind == "merge":
            for _, inner in element.objects("shape"):
                self.shape(inner)
            return
        geometry = self._geometry(element)
        if geometry is None:
            return
        flipped = element.boolean("flip_normals", False)
        if isinstance(geometry, Sphere) and determinant(element.transform()) < 0:
            flipped = not flipped  # Mitsuba turns a sphere inside out where its placement mirrors, and no other shape
        media = dict(element.objects("medium"))
        inside = self._media.medium(media["interior"]) if "interior" in media else None
        material = self._material(element, geometry)
        if material is None and inside is None and "interior" not in media:
            self._draft.report.note(element.where, "left out: a boundary that lets everything pass and holds no medium")
        if "exterior" in media and media["exterior"] is not media.get("interior") and seen_through(material):
            self._draft.report.note(element.where, GOES_ON)
        self._draft.shape(element.where, geometry, material, flipped, inside)

    def _geometry(self, element: Element) -> Geometry | None:
        where = element.where
        matrix = self._world @ element.transform()
        match element.kind:
            case "sphere":
                center, radius = element.vector("center"), element.number("radius", 1.0)
                if center is not None:
                    matrix = matrix @ translate(*center)
                if (factor := uniform_scale(matrix)) is None:
                    self._draft.report.note(where, "left out: a sphere that is scaled to an ellipsoid")
                    element.left_out()
                    return None
                return Sphere(matrix[:3, 3], _positive(factor * radius, where, "radius"))
            case "rectangle":
                return Rectangle(matrix)
            case "disk":
                across = matrix[:3, :2].T @ matrix[:3, :2]
                if not np.allclose(across, across[0, 0] * np.eye(2), rtol=0, atol=1e-5 * across[0, 0]):
                    self._draft.report.note(where, "left out: a disk that is scaled to an ellipse")
                    element.left_out()
                    return None
                facing = normal(matrix, np.array([0.0, 0.0, 1.0]))
                return Disk(matrix[:3, 3], facing / np.linalg.norm(facing), float(np.sqrt(across[0, 0])))
            case "cube":
                return Cube(matrix, where)
            case "ply" | "obj":
                return self._mesh(element, matrix)
        self._draft.report.note(
            where, f"left out: the shape {shown(element.kind)}; sphere, rectangle, disk, cube, ply and obj are known"
        )
        element.left_out()
        return None

    def _mesh(self, element: Element, matrix: Array) -> MeshFile:
        name, folder, where = element.file()
        element.passed_over("flip_tex_coords")
        smooth = not element.boolean("face_normals", False)
        file = self._draft.refer(name, folder, where)
        if smooth and not _has_normals(folder / name, element.kind):
            self._draft.report.note(where, "the file has no normals: its faces stay flat, where Mitsuba smooths them")
        return MeshFile(file, folder / name, matrix, smooth)

    def _material(self, element: Element, geometry: Geometry) -> Fields | None:
        """None for what lets everything pass."""
        bsdfs = [bsdf for _, bsdf in element.objects("bsdf")]
        emitters = [emitter for _, emitter in element.objects("emitter")]
        if emitters and emitters[0].kind == "area":
            if bsdfs:
                material = self._bsdf(bsdfs[0])
                if material is None:
                    self._draft.report.note(bsdfs[0].where, "lets nothing pass here, because its shape shines")
                elif material.get("reflectance") != 0.0:
                    self._draft.report.note(bsdfs[0].where, "reflects nothing here, because its shape shines")
            return {"kind": "emissive", "radiance": emitters[0].spectrum("radiance", 1.0, emitted=True)}
        if emitters:
            self._draft.report.note(emitters[0].where, f"left out: the emitter {shown(emitters[0].kind)} of a shape")
            emitters[0].left_out()
        material = self._bsdf(bsdfs[0]) if bsdfs else GREY
        if (not bsdfs or bsdfs[0].kind == "diffuse") and not isinstance(geometry, CLOSED):
            self._draft.report.note(element.where, "reflects on both sides here; from behind Mitsuba's is black")
        return material

    def _bsdf(self, element: Element) -> Fields | None:
        where = element.where
        match element.kind:
            case "null":
                return None
            case "diffuse":
                return {"kind": "diffuse", "reflectance": self._share(element, "reflectance", 0.5)}
            case "twosided":
                inner = [bsdf for _, bsdf in element.objects("bsdf")]
                if not inner:
                    raise SourceError(f"{where}: a twosided bsdf needs one inside")
                if len(inner) > 1:
                    self._draft.report.note(where, "both sides are made of the first of the two bsdfs")
                return self._bsdf(inner[0])
            case "dielectric":
                self._tinted(element, "specular_reflectance", "specular_transmittance")
                return {"kind": "dielectric", "ior": self._ior(element)}
            case "roughdielectric":
                return self._rough(element)
            case "conductor" if element.string("material", "none" if "eta" not in element else "") == "none":
                if "eta" not in element and "k" not in element:
                    return {"kind": "mirror", "reflectance": self._share(element, "specular_reflectance", 1.0)}
        name = "diffuse_reflectance" if "diffuse_reflectance" in element else "reflectance"
        reflectance = self._share(element, name, 0.5)
        self._draft.report.note(
            where, f"the bsdf {shown(element.kind)} is not carried over; a diffuse surface stands for it"
        )
        element.left_out()
        return {"kind": "diffuse", "reflectance": reflectance}

    def _share(self, element: Element, name: str, default: float) -> colour.Colour:
        value = colour.triple(element.spectrum(name, default))
        if value.min() < 0 or value.max() > 1:
            self._draft.report.note(element.where, f"the {name} is brought between 0 and 1")
        return colour.simple(np.clip(value, 0, 1))

    def _tinted(self, element: Element, *names: str) -> None:
        for name in names:
            if name in element and element.spectrum(name, 1.0) != 1.0:
                self._draft.report.note(element.where, f"the {name} is not carried over: it is 1 here")

    def _rough(self, element: Element) -> Fields:
        element.passed_over("sample_visible")
        self._tinted(element, "specular_reflectance", "specular_transmittance")
        if element.string("distribution", "beckmann") != "ggx":
            self._draft.report.note(element.where, "the microfacets are GGX's here, not Beckmann's, of the same alpha")
        alpha = element.number("alpha", 0.1)
        if "alpha_u" in element or "alpha_v" in element:
            alpha = (element.number("alpha_u", alpha) + element.number("alpha_v", alpha)) / 2
            self._draft.report.note(element.where, f"the roughness is {alpha:g} in every direction here")
        if not 0.001 <= alpha <= 1:
            self._draft.report.note(element.where, "the roughness is brought between 0.001 and 1")
        return {"kind": "rough_dielectric", "ior": self._ior(element), "roughness": min(max(alpha, 0.001), 1.0)}

    def _ior(self, element: Element) -> float:
        inside, outside = (self._index(element, *which) for which in (("int_ior", "bk7"), ("ext_ior", "air")))
        ratio = inside / outside
        if not 0.2 <= ratio <= 5:
            raise SourceError(f"{element.where}: the ratio of refractive indices must be from 0.2 to 5, not {ratio:g}")
        return ratio

    def _index(self, element: Element, name: str, default: str) -> float:
        try:
            given = element.string(name, default)
        except SourceError:  # a number, and no name
            return _positive(element.number(name, 1.0), element.at(name), name)
        if given in IOR:
            return IOR[given]
        if given[:1].isdigit():
            return _positive(number(given, element.at(name), name), element.at(name), name)
        raise SourceError(f"{element.at(name)}: {shown(given)} is no known material; known are {', '.join(IOR)}")


def _positive(value: float, where: str, what: str) -> float:
    if not 0 < value < np.inf:
        raise SourceError(f"{where}: {what} must be more than 0, not {value:g}")
    return value


def _has_normals(path: Path, kind: str) -> bool:
    """Whether a mesh's file gives normals to its corners; a file that cannot be read is not judged."""
    try:
        if not path.is_file():
            return True
        with path.open("rb") as file:
            if kind == "ply":
                return b"property float nx" in file.read(1 << 14).split(b"end_header")[0]
            return any(line.startswith(b"vn ") for line in file)
    except OSError:
        return True
