"""Surfaces and materials as parts of a program: kinds in use, buffers, and calls that go to just those kinds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from woodcock.formats.mesh import MeshError
from woodcock.layout import module
from woodcock.material.emissive import power
from woodcock.scene.surface import DielectricMaterial, EmissiveMaterial, Material, RoughDielectricMaterial
from woodcock.space import Array, Space
from woodcock.surface import dispatch
from woodcock.surface.build import KINDS, Built

#: Kinds of materials; their numbers in the records are positions here.
MATERIALS = ("diffuse", "mirror", "dielectric", "rough_dielectric", "emissive", "null")

#: Rough boundaries between indices closer than this bend nothing that float32 could say; they are taken for smooth.
LEAST_BEND = 1e-3

#: Primitives that rays try one after the other; more go into a hierarchy of boxes.
FEW = 4

#: Uniforms have so many values; so have the shares of emissive primitives.
SHARES = 1 << 24


@dataclass(frozen=True)
class Composed:
    """kinds: by concept; buffers: name -> elements' C type, array; parts: for `flatten`, files and generated text, to
    come after `struct world`, whose members the buffers are; emits: whether `surface_light_sample` and its density are
    there."""

    kinds: dict[str, tuple[str, ...]]
    buffers: dict[str, tuple[str, NDArray[np.generic]]]
    parts: list[str]
    emits: bool


def compose(built: Built, space: Space, channels: int, *, hierarchy: bool = False) -> Composed:
    """What a program needs for surfaces. hierarchy: of few primitives, too.

    Raises MeshError for more emissive triangles than can be told apart.
    """
    hierarchy |= len(built.primitives) > FEW or "mesh" in built.numbers
    materials = [_meant(body.material) for body in built.bodies]
    kinds = tuple(kind for kind in KINDS if kind in built.numbers)
    used = tuple(kind for kind in MATERIALS if any(material.kind == kind for material in materials))
    emits = "emissive" in used
    smooth = built.normals is not None

    numbers = [_numbers(material, space, channels) for material in materials]
    first = np.cumsum([0, *map(len, numbers)])[:-1]
    records = [
        (MATERIALS.index(material.kind), start, body.media)
        for material, start, body in zip(materials, first, built.bodies, strict=True)
    ]
    buffers: dict[str, tuple[str, NDArray[np.generic]]] = {
        "surface_primitives": ("int", built.primitives.reshape(-1)),
        "surface_records": ("int", np.array(records, np.int32).reshape(-1)),
        # A material without numbers must not leave the buffer empty.
        "material_numbers": ("float", np.concatenate([*numbers, np.zeros(1)]).astype(np.float32)),
        **{f"surface_{kind}": ("float", built.numbers[kind]) for kind in kinds},
    }
    if hierarchy:
        buffers |= {
            "surface_boxes": ("float", built.boxes.reshape(-1)),
            "surface_links": ("int", built.links.reshape(-1)),
        }
    if built.normals is not None:
        buffers["surface_mesh_normals"] = ("float", built.normals)
    if emits:
        buffers |= _emitters(built, materials)

    nearest = by_hierarchy(kinds) if hierarchy else [dispatch.in_turn(built.primitives)]
    parts = parts_of(kinds, used, nearest, smooth, emits)
    return Composed({"surface": kinds, "material": used}, buffers, parts, emits)


def by_hierarchy(kinds: Sequence[str]) -> list[str]:
    """Parts that find the nearest of many surfaces."""
    return [dispatch.tests(kinds), "surface/traverse.h"]


def parts_of(
    kinds: Sequence[str], materials: Sequence[str], nearest: Sequence[str], smooth: bool, emits: bool
) -> list[str]:
    """Parts for `flatten`; nearest: those that find the nearest surface; smooth: meshes have normals; emits: some
    material does."""
    parts = [f"surface/{kind}.h" for kind in kinds] + [f"material/{kind}.h" for kind in materials]
    parts += ["surface/point.h", dispatch.PRIMITIVE, *nearest, dispatch.locate(kinds, smooth), "surface/records.h"]
    parts.append(dispatch.materials(materials, MATERIALS))
    if emits:
        parts += ["core/light_sample.h", dispatch.emitters(kinds), "surface/emitters.h"]
    return parts


def _meant(material: Material) -> Material:
    if isinstance(material, RoughDielectricMaterial) and abs(material.ior - 1) < LEAST_BEND:
        return DielectricMaterial(ior=material.ior)
    return material


def _numbers(material: Material, space: Space, channels: int) -> Array:
    """A material's numbers in a row, colours as wide as the scene's channels."""
    kind = module("material", material.kind)
    values = kind.record(material, space)
    rows = [
        np.broadcast_to(np.asarray(values[name], float).reshape(-1), channels if ctype == "colour" else 1)
        for name, ctype in kind.FIELDS.items()
    ]
    return np.concatenate([np.zeros(0), *rows])


def _emitters(built: Built, materials: list[Material]) -> dict[str, tuple[str, NDArray[np.generic]]]:
    """Shares of the emissive primitives, and of every primitive the probability that it is chosen, per area where the
    point is then taken uniformly in its area."""
    powers = np.array([power(m) if isinstance(m, EmissiveMaterial) else 0.0 for m in materials])
    weight = powers[built.primitives[:, 2]] * built.areas
    chosen = np.flatnonzero([isinstance(m, EmissiveMaterial) for m in materials])
    emitters = np.flatnonzero(np.isin(built.primitives[:, 2], chosen))
    if len(emitters) > SHARES // 4:
        raise MeshError(f"surfaces: {len(emitters)} triangles shine; {SHARES // 4} are the most")
    share = _shares(weight[emitters])
    padded = 1 << int(np.ceil(np.log2(len(emitters)))) if len(emitters) > 1 else 1
    ends = np.full(1 + padded, SHARES, np.int32)
    ends[0], ends[1 : 1 + len(emitters)] = padded // 2, np.cumsum(share)
    pdf = np.zeros(len(built.primitives))
    pdf[emitters] = share / SHARES
    spheres = built.primitives[:, 0] == KINDS.index("sphere")
    pdf[~spheres] /= built.areas[~spheres]
    return {
        "surface_emitter_ends": ("int", ends),
        "surface_emitters": ("int", emitters.astype(np.int32)),
        "surface_emitter_pdf": ("float", pdf.astype(np.float32)),
    }


def _shares(weight: Array) -> NDArray[np.int64]:
    """Whole numbers of sum SHARES in proportion to weights, each at least 1, so that nothing that shines is missed."""
    if not weight.sum() > 0:
        weight = np.ones_like(weight)
    weight = weight / weight.max()  # so that no sum overflows
    share: NDArray[np.int64] = 1 + np.floor(weight / weight.sum() * (SHARES - len(weight))).astype(np.int64)
    share[np.argmax(weight)] += SHARES - share.sum()
    return share
