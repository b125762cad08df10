"""Mitsuba's media and phase functions."""

from __future__ import annotations

import re

import numpy as np

from woodcock.formats import VolumeError, read_grid
from woodcock.importing import colour
from woodcock.importing.draft import Draft, Medium
from woodcock.importing.geometry import Fields, placement
from woodcock.importing.mitsuba.element import Element
from woodcock.importing.report import SourceError, number, shown
from woodcock.importing.transforms import Array, inverse, point

UNIT_CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)

#: What Mitsuba takes where a medium does not say.
ALBEDO, SIGMA_T = 0.75, 1.0


class Media:
    """Each medium is made once, however many shapes it fills."""

    def __init__(self, draft: Draft, world: Array) -> None:
        self._draft, self._world = draft, world
        self._made: dict[int, Medium | None] = {}

    def medium(self, element: Element) -> Medium | None:
        if id(element) not in self._made:
            self._made[id(element)] = self._make(element)
        return self._made[id(element)]

    def _make(self, element: Element) -> Medium | None:
        element.passed_over("sample_emitters", "has_spectral_extinction", "majorant_resolution_factor")
        match element.kind:
            case "homogeneous":
                return self._homogeneous(element)
            case "heterogeneous":
                return self._heterogeneous(element)
        self._draft.report.note(
            element.where, f"left out: the medium {shown(element.kind)}; homogeneous and heterogeneous are known"
        )
        element.left_out()
        return None

    def _homogeneous(self, element: Element) -> Medium:
        scale = element.number("scale", 1.0)
        if "sigma_s" in element or "sigma_a" in element:
            scattered, absorbed = (colour.triple(element.spectrum(name, 0.0)) for name in ("sigma_s", "sigma_a"))
            sigma_t = scattered + absorbed
            albedo = colour.simple(np.divide(scattered, sigma_t, out=np.zeros(3), where=sigma_t > 0))
        else:
            sigma_t = colour.triple(element.spectrum("sigma_t", SIGMA_T))
            albedo = element.spectrum("albedo", ALBEDO)
        fields = {"sigma_t": colour.simple(scale * sigma_t), "albedo": albedo, "phase": self._phase_of(element)}
        return Medium({"kind": "constant", **fields})

    def _heterogeneous(self, element: Element) -> Medium | None:
        scale = element.number("scale", 1.0)
        sigma_t = element.object("sigma_t", "volume")
        if sigma_t is None or sigma_t.kind != "gridvolume":
            if sigma_t is not None and sigma_t.kind != "constvolume":
                self._draft.report.note(sigma_t.where, f"left out: the volume {shown(sigma_t.kind)}, and its medium")
                return None
            return self._homogeneous(element)
        file, matrix, box = self._grid(sigma_t)
        fields: Fields = {"kind": "grid", "file": file, "scale": scale}
        albedo = element.object("albedo", "volume")
        if albedo is not None and albedo.kind == "gridvolume":
            albedo_file, albedo_matrix, _ = self._grid(albedo)
            if np.allclose(albedo_matrix, matrix, rtol=1e-6, atol=1e-9):
                fields |= {"albedo": 1.0, "albedo_grid": {"file": albedo_file}}
            else:
                fields["albedo"] = ALBEDO
                self._draft.report.note(
                    albedo.where, f"the grid of the albedo lies otherwise than that of sigma_t; {ALBEDO} stands for it"
                )
        else:
            fields["albedo"] = element.spectrum("albedo", ALBEDO)
        fields["phase"] = self._phase_of(element)
        if sigma_t.string("filter_type", "trilinear") == "nearest":
            fields["interpolation"] = "nearest"
        return Medium({**fields, **placement(matrix)}, box)

    def _grid(self, element: Element) -> tuple[str, Array, Array]:
        """A gridvolume's file, its `to_world`, and its corners (8, 3) in the world.

        Mitsuba's grid fills the unit cube, or with `use_grid_bbox` the box that the file states.
        """
        name, folder, where = element.file()
        element.passed_over("accel")
        if element.string("wrap_mode", "clamp") != "clamp":
            self._draft.report.note(element.at("wrap_mode"), "the grid ends at its box; it is not repeated")
        element.boolean("raw", False)
        file = self._draft.refer(name, folder, where)
        own = np.eye(4)
        try:
            grid = read_grid(folder / name)
        except VolumeError as error:
            self._draft.report.note(where, f"the grid is not checked: {error}")
        else:
            # From the unit cube to where the file's own transform puts the same voxels
            size = np.array(grid.values.shape[2::-1], float)
            own = grid.index_to_world @ np.diag((*size, 1.0)) if grid.placed else own
        stated = own if element.boolean("use_grid_bbox", False) else np.eye(4)
        matrix = self._world @ element.transform() @ stated
        return file, matrix @ inverse(own, where), point(matrix, UNIT_CUBE)

    def _phase_of(self, medium: Element) -> Fields:
        found = [phase for _, phase in medium.objects("phase")]
        return self._phase(found[0]) if found else {"kind": "isotropic"}

    def _phase(self, element: Element) -> Fields:
        match element.kind:
            case "isotropic" | "rayleigh":
                return {"kind": element.kind}
            case "hg":
                return self._lobe(element.number("g", 0.8), element.at("g"))
            case "tabphase":
                values = [
                    number(text, element.at("values"), "values")
                    for text in re.split(r"[\s,]+", element.string("values").strip())
                ]
                return {"kind": "tabulated", "cosine": np.linspace(-1, 1, len(values)).tolist(), "value": values}
            case "blendphase":
                return self._blend(element)
        self._draft.report.note(
            element.where, f"the phase function {shown(element.kind)} is not carried over; isotropic stands for it"
        )
        element.left_out()
        return {"kind": "isotropic"}

    def _lobe(self, g: float, where: str) -> Fields:
        if g < -0.9999:
            self._draft.report.note(where, "g is brought to -0.9999")
        return {"kind": "henyey_greenstein", "g": max(g, -0.9999)}

    def _blend(self, element: Element) -> Fields:
        weight = element.spectrum("weight", 0.5)
        share = float(colour.triple(weight).mean())
        if isinstance(weight, list):
            self._draft.report.note(element.where, f"the weight of a blend is one number here: {share:g}")
        phases = [phase for _, phase in element.objects("phase")]
        if len(phases) != 2 or not 0 <= share <= 1:
            raise SourceError(f"{element.where}: a blendphase needs two phase functions and a weight from 0 to 1")
        components: list[Fields] = []
        for phase, part in zip(map(self._phase, phases), (1 - share, share), strict=True):
            alone: Fields = {"weight": 1.0, "phase": phase}
            inner = phase["components"] if phase["kind"] == "mixture" else [alone]
            components += [{"weight": part * item["weight"], "phase": item["phase"]} for item in inner]
        components = [item for item in components if item["weight"] > 0]
        return components[0]["phase"] if len(components) == 1 else {"kind": "mixture", "components": components}
