"""pbrt's media."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from woodcock.formats import VolumeError, list_grids, read_grid
from woodcock.importing import colour
from woodcock.importing.draft import Draft, Medium
from woodcock.importing.geometry import Fields, placement
from woodcock.importing.pbrt.parameters import Parameters
from woodcock.importing.pbrt.world import Directive, World
from woodcock.importing.report import SourceError, shown
from woodcock.importing.transforms import Array, check, point

UNIT_CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)

#: ∫ȳ dλ, nanometres: pbrt brings lights to a luminance of 1, but not what glows by its temperature, nor an rgbgrid.
Y_INTEGRAL = 106.856895
COLDEST = 100.0  # kelvin; what is colder emits nothing in pbrt


class Media:
    """Each medium is made once, however many shapes it fills."""

    def __init__(self, draft: Draft, source: World, world: Array) -> None:
        self._draft, self._source, self._world = draft, source, world
        self._made: dict[str, Medium | None] = {}

    def medium(self, name: str, where: str) -> Medium | None:
        if not name:
            return None
        if name not in self._made:
            if name not in self._source.media:
                raise SourceError(f"{where}: there is no medium {shown(name)}")
            self._made[name] = self._make(name, self._source.media[name])
        return self._made[name]

    def _make(self, name: str, directive: Directive) -> Medium | None:
        parameters = directive.parameters
        parameters.used = True
        match directive.kind:
            case "homogeneous":
                return self._homogeneous(parameters)
            case "uniformgrid":
                return self._uniform(name, directive)
            case "rgbgrid":
                return self._coloured(name, directive)
            case "nanovdb":
                return self._nanovdb(directive)
        self._draft.report.note(
            directive.where,
            f"left out: the medium {shown(directive.kind)}; homogeneous, uniformgrid, rgbgrid and nanovdb are known",
        )
        parameters.passed_over(*parameters.found)
        return None

    def _coefficients(self, parameters: Parameters) -> tuple[Array, Array]:
        """σ_a and σ_s, (3,)."""
        if "preset" in parameters:
            name = shown(parameters.string("preset", ""))
            self._draft.report.note(parameters.at("preset"), f"the preset {name} is not carried over")
        scale = parameters.number("scale", 1.0)
        absorbed, scattered = (scale * colour.triple(parameters.spectrum(name, 1.0)) for name in ("sigma_a", "sigma_s"))
        return absorbed, scattered

    def _phase(self, parameters: Parameters) -> Fields:
        g = parameters.number("g", 0.0)
        if not -1 < g < 1:
            raise SourceError(f"{parameters.at('g')}: g must be between -1 and 1, not {g:g}")
        return {"kind": "henyey_greenstein", "g": max(g, -0.9999)} if g else {"kind": "isotropic"}

    def _homogeneous(self, parameters: Parameters) -> Medium:
        absorbed, scattered = self._coefficients(parameters)
        fields: Fields = {
            "kind": "constant",
            "sigma_t": colour.simple(absorbed + scattered),
            "albedo": _ratio(scattered, absorbed + scattered),
            "phase": self._phase(parameters),
        }
        glow = absorbed * colour.triple(parameters.light("Le", 0.0)) * parameters.number("Lescale", 1.0)
        if glow.any():
            fields["emission"] = {"kind": "constant", "epsilon": colour.simple(glow)}
        return Medium(fields)

    def _box(self, directive: Directive) -> tuple[tuple[int, int, int], Array]:
        """Numbers of voxels (z, y, x), and from the unit cube to the world."""
        parameters = directive.parameters
        x, y, z = (parameters.integer(name, 1) for name in ("nx", "ny", "nz"))
        ends = parameters.point("p0", (0.0, 0.0, 0.0)), parameters.point("p1", (1.0, 1.0, 1.0))
        low, high = np.minimum(*ends), np.maximum(*ends)
        box = np.diag((*(high - low), 1.0))
        box[:3, 3] = low
        return (z, y, x), check(self._world @ directive.to_world @ box, directive.where)

    def _array(
        self, parameters: Parameters, name: str, shape: tuple[int, ...], type_: str = "float"
    ) -> NDArray[np.float32] | None:
        values = parameters.numbers(name, type_)
        if values is None:
            return None
        if min(shape) < 1 or values.size != np.prod([float(n) for n in shape]):
            size = " × ".join(map(str, reversed(shape)))
            raise SourceError(f"{parameters.at(name)}: {shown(name)} must hold {size} numbers, not {values.size}")
        return self._not_negative(values.reshape(shape).astype(np.float32), parameters.at(name))

    def _not_negative(self, values: NDArray[np.float32], where: str) -> NDArray[np.float32]:
        if values.min() < 0:
            self._draft.report.note(where, f"negative values, down to {values.min():g}, are 0 here")
        return np.maximum(values, np.float32(0))

    def _fades(self, values: NDArray[np.float32], where: str) -> None:
        faces = (values[[0, -1]], values[:, [0, -1]], values[:, :, [0, -1]])
        if any(face.any() for face in faces):
            self._draft.report.note(
                where,
                "towards the faces of the box the grid keeps its last value here, where pbrt's fades to half of it",
            )

    def _uniform(self, name: str, directive: Directive) -> Medium:
        parameters = directive.parameters
        shape, matrix = self._box(directive)
        density = self._array(parameters, "density", shape)
        if density is None:
            raise SourceError(f'{directive.where}: a uniformgrid needs "float density"')
        self._fades(density, parameters.at("density"))
        absorbed, scattered = self._coefficients(parameters)
        file = self._draft.array(name, density)
        fields: Fields = {
            "kind": "grid",
            "file": file,
            "scale": colour.simple(absorbed + scattered),
            "albedo": _ratio(scattered, absorbed + scattered),
            "phase": self._phase(parameters),
        }
        if emission := self._glow(name, parameters, density, file, absorbed):
            fields["emission"] = emission
        return Medium({**fields, **placement(matrix)}, point(matrix, UNIT_CUBE))

    def _glow(
        self, name: str, parameters: Parameters, density: NDArray[np.float32], file: str, absorbed: Array
    ) -> Fields | None:
        """ε = σ_a density × (Le × Lescale, or a blackbody of the temperature)."""
        shape = density.shape
        kelvin = self._array(parameters, "temperature", shape)
        factor = self._array(parameters, "Lescale", shape)
        offset = parameters.number("temperatureoffset", parameters.number("temperaturecutoff", 0.0))
        warmth = parameters.number("temperaturescale", 1.0)
        light = colour.triple(parameters.light("Le", 0.0))
        values = density if factor is None else density * factor
        if kelvin is not None:
            degrees = (kelvin - offset) * warmth
            spectra = _blackbody(degrees) * (degrees > COLDEST)[..., None] * Y_INTEGRAL
            self._interpolated(parameters, "temperature")
            glow = self._draft.array(f"{name}-emission", (values[..., None] * spectra).astype(np.float32))
            return {"kind": "grid", "file": glow, "scale": colour.simple(absorbed)} if absorbed.any() else None
        if not (absorbed * light).any():
            return None
        if factor is not None:
            self._interpolated(parameters, "Lescale")
            file = self._draft.array(f"{name}-emission", values)
        return {"kind": "grid", "file": file, "scale": colour.simple(absorbed * light)}

    def _interpolated(self, parameters: Parameters, name: str) -> None:
        self._draft.report.note(
            parameters.at(name),
            f"{shown(name)} and what absorbs are multiplied at the voxels, and interpolated together",
        )

    def _coloured(self, name: str, directive: Directive) -> Medium | None:
        parameters = directive.parameters
        shape, matrix = self._box(directive)
        absorbed, scattered = (self._array(parameters, which, (*shape, 3), "rgb") for which in ("sigma_a", "sigma_s"))
        if absorbed is None and scattered is None:
            raise SourceError(f'{directive.where}: an rgbgrid needs "rgb sigma_a" or "rgb sigma_s"')
        one = np.ones((*shape, 3), np.float32)
        absorbed, scattered = (one if values is None else values for values in (absorbed, scattered))
        sigma_t = absorbed + scattered
        self._fades(sigma_t, directive.where)
        albedo = np.divide(scattered, sigma_t, out=np.zeros_like(sigma_t), where=sigma_t > 0)
        some = albedo[(sigma_t > 0).all(axis=-1)]
        fields: Fields = {
            "kind": "grid",
            "file": self._draft.array(name, _grey(sigma_t)),
            "scale": parameters.number("scale", 1.0),
        }
        if len(some) and np.allclose(some, some[0], rtol=1e-6, atol=1e-7):
            fields["albedo"] = colour.simple(np.clip(some[0], 0, 1))
        else:
            fields["albedo"] = 1.0
            fields["albedo_grid"] = {"file": self._draft.array(f"{name}-albedo", _grey(albedo))}
            self._draft.report.note(directive.where, "between voxels albedo and sigma_t are interpolated, not sigma_s")
        fields["phase"] = self._phase(parameters)
        if (light := self._array(parameters, "Le", (*shape, 3), "rgb")) is not None:
            self._interpolated(parameters, "Le")
            glow = self._draft.array(f"{name}-emission", _grey(absorbed * light))
            factor = parameters.number("scale", 1.0) * parameters.number("Lescale", 1.0) * Y_INTEGRAL
            fields["emission"] = {"kind": "grid", "file": glow, "scale": factor}
        return Medium({**fields, **placement(matrix)}, point(matrix, UNIT_CUBE))

    def _nanovdb(self, directive: Directive) -> Medium:
        parameters = directive.parameters
        name, where = parameters.string("filename", ""), parameters.at("filename")
        file = self._draft.refer(name, parameters.folder, where)
        absorbed, scattered = self._coefficients(parameters)
        matrix = self._world @ directive.to_world
        fields: Fields = {
            "kind": "grid",
            "file": file,
            "grid": "density",
            "scale": colour.simple(absorbed + scattered),
            "albedo": _ratio(scattered, absorbed + scattered),
            "phase": self._phase(parameters),
        }
        scale = parameters.number("Lescale", parameters.number("LeScale", 1.0))
        offset = parameters.number("temperatureoffset", parameters.number("temperaturecutoff", 0.0))
        warmth = parameters.number("temperaturescale", 1.0)
        box = None
        path = parameters.folder / name
        try:
            grid = read_grid(path, "density")
            size = np.array(grid.values.shape[2::-1], float)
            box = point(matrix @ grid.index_to_world, UNIT_CUBE * size)
            glows = scale > 0 and any(info.name == "temperature" for info in list_grids(path))
            hottest = float(read_grid(path, "temperature").values.max()) * warmth if glows else 0.0
        except VolumeError as error:
            self._draft.report.note(where, f"the grids are not checked, and nothing glows: {error}")
            hottest = 0.0
        if hottest > COLDEST and absorbed.any():
            if offset:
                self._draft.report.note(parameters.where, "temperatureoffset is not carried over: it is 0 here")
            self._draft.report.note(
                where,
                f"glows by Planck's law, as bright as pbrt's at {hottest:g} K; pbrt brings all temperatures' "
                "spectra to the same peak",
            )
            fields["emission"] = {
                "kind": "blackbody",
                "file": file,
                "grid": "temperature",
                "kelvin": warmth,
                "reference": hottest,
                "luminance": colour.luminance(colour.blackbody(hottest)) * Y_INTEGRAL * scale,
            }
        return Medium({**fields, **placement(matrix)}, box)


def _blackbody(kelvin: NDArray[np.float32]) -> Array:
    """(..., 3), by a table: a spectrum for every voxel would take too much room."""
    steps = np.linspace(COLDEST, max(float(kelvin.max()), COLDEST + 1), 4096)
    table = colour.blackbody(steps)
    return np.stack([np.interp(kelvin, steps, table[:, channel]) for channel in range(3)], axis=-1)


def _ratio(scattered: Array, sigma_t: Array) -> colour.Colour:
    return colour.simple(np.clip(np.divide(scattered, sigma_t, out=np.zeros(3), where=sigma_t > 0), 0, 1))


def _grey(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """One channel where all three are the same."""
    grey = bool((values[..., :1] == values).all())
    return values[..., 0] if grey else values
