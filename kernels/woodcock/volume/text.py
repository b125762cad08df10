"""The device's text for one medium. Nothing chooses between chunks of a field that is one; what is grey in the whole
scene is a `real`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from woodcock.emission import blackbody, constant
from woodcock.emission import grid as emission_grid
from woodcock.layout import Record
from woodcock.scene import BlackbodyEmission, ConstantEmission, ConstantVolume, GridEmission, GridVolume
from woodcock.space import Array, Space
from woodcock.volume.field import FIELDS, Buffer, Field
from woodcock.volume.media import Medium


@dataclass
class Composed:
    """kinds: by concept; records: in order; buffers: members of `struct world`; files: to include, after the structs
    and before `struct world`; text: after it; facts: for the report; dense_glow: is all emission where tentative
    collisions are dense (glow.py)?"""

    kinds: dict[str, tuple[str, ...]] = field(default_factory=dict)
    records: list[Record] = field(default_factory=list)
    buffers: dict[str, Buffer] = field(default_factory=dict)
    files: list[str] = field(default_factory=list)
    text: str = ""
    facts: dict[str, Any] = field(default_factory=dict)
    dense_glow: bool = False

    def use(self, concept: str, kind: str, *files: str) -> None:
        if kind not in self.kinds.get(concept, ()):
            self.kinds[concept] = (*self.kinds.get(concept, ()), kind)
        self.files += [file for file in files if file not in self.files]


@dataclass(frozen=True)
class Writer:
    """Writes the functions of one medium and puts what they need into `composed`. grey: is every σ_t of the scene?"""

    composed: Composed
    name: str
    medium: Medium
    space: Space
    grey: bool
    most_bytes: int

    def constant(self) -> str:
        volume = self.medium.volume
        assert isinstance(volume, ConstantVolume)
        fields = {"sigma_t": self._sigma_t_type(), "albedo": "colour"}
        values = {"sigma_t": self._coefficient(np.array(volume.sigma_t)), "albedo": np.atleast_1d(volume.albedo)}
        self._record("medium", "constant", self.name, fields, values)
        sigma_t = self._sigma_t("")
        return "".join((
            self._function("coefficient", "sigma_t", "vector p, words w", f"    return {sigma_t};\n"),
            self._function("coefficient", "sigma_t_exact", "vector p", f"    return {sigma_t};\n"),
            self._function("spectrum", "albedo", "vector p, words w", f"    return {self._numbers('albedo')};\n"),
            self._emission("", self._numbers("albedo")),
        ))  # fmt: skip

    def grid(self, *, alone: bool) -> str:
        """alone: no other grid is tracked, so that no point outside this one's bounds is asked for."""
        volume, density = self.medium.volume, self.medium.density
        assert isinstance(volume, GridVolume)
        assert density is not None
        to_scene = self.medium.to_scene(density)
        fields = {"to_local": "affine", "size": "vector3", "sigma_t": self._sigma_t_type(), "albedo": "colour"}
        values = {
            "to_local": self.space.affine(to_scene),
            "size": np.array(density.size, float),
            "sigma_t": self._coefficient(np.array(volume.scale) * density.step),
            "albedo": np.atleast_1d(volume.albedo) * (self.medium.albedo.step if self.medium.albedo else 1.0),
        }
        self._record("medium", "grid", self.name, fields, values)
        text = self._field("density", density)
        value = "real" if density.channels == 1 else "spectrum"
        holds = f"field_holds({self._of('density')}, p)"
        inside = "" if alone else f"    value = {_pick(value, holds)};\n"
        sigma_t = f"{inside}    return {self._sigma_t('value', density.channels)};\n"
        tap = f"    {value} value = {self.name}_density_at(world, p, w);\n"
        exact = f"    {value} value = {self.name}_density_exact(world, p);\n"
        text += self._function("coefficient", "sigma_t", "vector p, words w", tap + sigma_t)
        text += self._function("coefficient", "sigma_t_exact", "vector p", exact + sigma_t)

        albedo = albedo_exact = self._numbers("albedo")
        if self.medium.albedo:
            text += self._field("albedo", self.medium.albedo)
            albedo = self._times(albedo, f"{self.name}_albedo_there(world, p, w)", self.medium.albedo)
            albedo_exact = self._times(albedo_exact, f"{self.name}_albedo_there_exact(world, p)", self.medium.albedo)
        text += self._function("spectrum", "albedo", "vector p, words w", f"    return {albedo};\n")
        if self.medium.emission:
            text += self._field("emission", self.medium.emission)
        return text + self._emission("" if alone else holds, albedo_exact)

    def minorant(self) -> str:
        """A lower bound on σ_t in the cell of a walk, by the arithmetic of σ_t itself: rounding keeps it one."""
        assert self.medium.density is not None
        channels = self.medium.density.channels
        name = f"world->minorant_{self.name.removeprefix('medium_')}"
        values = ", ".join(f"majorant_cell(world, walk, {name}_{channel})" for channel in range(channels))
        value = f"real value = {values}" if channels == 1 else f"spectrum value = spectrum_of({values})"
        body = f"    {value};\n    return {self._sigma_t('value', channels)};\n"
        return self._function("coefficient", "minorant", "const majorant_walk *walk", body)

    def pair(self) -> str:
        """σ_t at two points of one cell of the medium's voxels, added: each voxel is fetched once."""
        density = self.medium.density
        assert density is not None
        value, points = "real" if density.channels == 1 else "spectrum", "vector p, vector q"
        if density.nearest:
            once = f"{self.name}_density_exact(world, p)"
            body = f"    return {f'2.f * {once}' if value == 'real' else f'spectrum_scale({once}, (real)2.f)'};\n"
        else:
            body = f"    field_cell cell = field_cell_of({self._of('density')}, p);\n"
            body += "    field_cell other = field_cell_at(&cell, p, q);\n"
            body += self._corners("density", density, "(field_weight(&cell, corner) + field_weight(&other, corner))")
        text = self._function(value, "density_pair", points, body)
        body = f"    {value} value = {self.name}_density_pair(world, p, q);\n"
        body += f"    return {self._sigma_t('value', density.channels)};\n"
        return text + self._function("coefficient", "sigma_t_pair", points, body)

    # Emission

    def _emission(self, holds: str, albedo: str) -> str:
        """holds: a mask, where the medium may be asked for beyond its bounds."""
        emission, field = self.medium.volume.emission, self.medium.emission
        if emission is None:
            return ""
        place = f"&world->scene->{self.name}_emission_numbers"
        epsilon, absorbed = f"emission_constant_epsilon({place})", False
        there = f"{self.name}_emission_there_exact(world, p)"
        once = {f"{self.name}_sigma_t_exact(world, p)": f"{self.name}_sigma_t(world, p, w)"}
        match emission:
            case ConstantEmission(epsilon=value):
                self._emission_record("constant", constant.FIELDS, constant.record(np.atleast_1d(value), self.space))
            case GridEmission():
                assert field is not None
                self._emission_record(
                    "grid", emission_grid.FIELDS, emission_grid.record(emission, field.step, self.space)
                )
                spectrum = there if field.channels == 3 else f"spectrum_grey({there})"
                epsilon = f"emission_grid_epsilon({place}, {spectrum})"
                once[there] = f"{self.name}_emission_there(world, p, w)"
            case BlackbodyEmission() if field is None:
                radiance = blackbody.radiance(emission, np.array(emission.kelvin))
                self._emission_record("constant", constant.FIELDS, constant.record(radiance, self._lengthless()))
                absorbed = True
            case BlackbodyEmission():
                table = blackbody.table(emission, field.largest, self.space)
                record = blackbody.record(emission, field.largest, field.step, table)
                self._emission_record("blackbody", blackbody.FIELDS, record)
                self.composed.buffers[f"{self.name}_emission_table"] = Buffer.of(table.astype(np.float32).reshape(-1))
                epsilon = f"emission_blackbody_radiance({place}, world->{self.name}_emission_table, {there})"
                absorbed = True
        body = f"    spectrum epsilon = {epsilon};\n"
        if absorbed:
            sigma_t = f"{self.name}_sigma_t_exact(world, p)"
            body += f"""\
    spectrum absorbed = spectrum_add(spectrum_grey((real)1.f), spectrum_scale({albedo}, (real)-1.f));
    epsilon = spectrum_multiply(epsilon, {_scaled("absorbed", sigma_t, self.grey)});
"""
        elif holds:
            body += f"    epsilon = {_pick('spectrum', holds, 'epsilon')};\n"
        body += "    return epsilon;\n"
        text = self._function("spectrum", "emission", "vector p", body)
        for exact, tap in once.items():
            body = body.replace(exact, tap)
        return text + self._function("spectrum", "emission_once", "vector p, words w", body)

    def _emission_record(self, kind: str, fields: Mapping[str, str], values: Mapping[str, Any]) -> None:
        self._record("emission", kind, f"{self.name}_emission_numbers", fields, values)
        self.composed.use("emission", kind, f"emission/{kind}.h")

    def _lengthless(self) -> Space:
        """For radiance, where a kind records radiance per length."""
        return Space(radiance_exponent=self.space.radiance_exponent)

    # Fields

    def _field(self, part: str, field: Field) -> str:
        """The lookups of a field: `_at` one tap and `_exact`, in its own space; `_there` in the medium's, 0 outside."""
        name, value = f"{self.name}_{part}", "real" if field.channels == 1 else "spectrum"
        density = self.medium.density
        assert density is not None
        if self.medium.place(part) == part:
            own = field.record(self.medium.to_scene(density), self.medium.to_scene(field))
            self._record("volume", "field", f"{name}_field", FIELDS, own)
        self.composed.use("storage", field.storage, "volume/field.h", f"volume/field_{field.storage}.h")
        text = self._fetch(name, field)
        nearest = f"{name}_fetch(world, field_nearest({self._of(part)}, p))"
        if field.nearest:
            one, full = f"    return {nearest};\n", f"    return {nearest};\n"
        else:
            one = f"    return {name}_fetch(world, field_trilinear({self._of(part)}, p, w));\n"
            cell = f"    field_cell cell = field_cell_of({self._of(part)}, p);\n"
            full = cell + self._corners(part, field, "field_weight(&cell, corner)")
        text += self._function(value, f"{part}_at", "vector p, words w", one)
        text += self._function(value, f"{part}_exact", "vector p", full)
        if part != "density":
            holds = f"field_holds({self._of(part)}, q)"
            q = f"affine_point({self._of(part)}.from_local, p)" if self.medium.place(part) == part else "p"
            inside = f"    vector q = {q};\n    {value} value = "
            outside = f";\n    return {_pick(value, holds)};\n"
            one, full = f"{name}_at(world, q, w)", f"{name}_exact(world, q)"
            if part == "albedo" or (part == "emission" and isinstance(self.medium.volume.emission, GridEmission)):
                text += self._function(value, f"{part}_there", "vector p, words w", f"{inside}{one}{outside}")
            text += self._function(value, f"{part}_there_exact", "vector p", f"{inside}{full}{outside}")
        return text

    def _corners(self, part: str, field: Field, weight: str) -> str:
        """The sum of the cell's corners, each times its weight."""
        corner = f"{self.name}_{part}_fetch(world, field_corner({self._of(part)}, &cell, corner))"
        value, zero, added = "real", "(real)0.f", f"sum + {weight} * {corner}"
        if field.channels > 1:
            value, zero = "spectrum", f"spectrum_grey({zero})"
            added = f"spectrum_add(sum, spectrum_scale({corner}, {weight}))"
        return f"""\
    {value} sum = {zero};
    for (int corner = 0; corner < 8; ++corner) sum = {added};
    return sum;
"""

    def _fetch(self, name: str, field: Field) -> str:
        """What is stored of a voxel, from the chunk that it lies in."""
        value, shift = "real" if field.channels == 1 else "spectrum", field.shift(self.most_bytes)
        chunks = field.chunks(shift)
        names = [f"{name}_voxels" + f"_{index}" * (len(chunks) > 1) for index in range(len(chunks))]
        self.composed.buffers.update(zip(names, chunks, strict=True))
        if len(chunks) == 1:
            index = "at.brick << 6 | at.voxel"
            body = f"    const integer index = {index if value == 'real' else f'3 * ({index})'};\n"
            body += f"    return {_stored(field, f'world->{names[0]}', 'index')};\n"
        else:
            index = f"(at.brick & {(1 << shift) - 1}) << 6 | at.voxel"
            body = f"""\
    const integer index = {index if value == "real" else f"3 * ({index})"}, chunk = at.brick >> {shift};
    {value} value = {"(real)0.f" if value == "real" else "spectrum_grey((real)0.f)"};
    mask here;
"""
            for number, chunk in enumerate(names):
                found = _stored(field, f"world->{chunk}", "pick((integer)0, index, here)")
                body += f"    here = test(chunk == {number});\n"
                body += f"    if (some(here)) value = {_pick(value, 'here', found, 'value')};\n"
            body += "    return value;\n"
        return f"static inline {value} {name}_fetch(const struct world *world, field_place at) {{\n{body}}}\n"

    # Numbers

    def _record(
        self, concept: str, kind: str, member: str, fields: Mapping[str, str], values: Mapping[str, Any]
    ) -> None:
        self.composed.records.append(Record(concept, kind, member, fields, values))

    def _of(self, part: str) -> str:
        return f"&world->scene->{self.name}_{self.medium.place(part)}_field"

    def _sigma_t_type(self) -> str:
        return "float" if self.grey else "colour"

    def _coefficient(self, sigma_t: Array) -> Array:
        """σ_t in the device's units, (), or (1,) or (3,) where the scene's are colours."""
        return self.space.coefficients(sigma_t if self.grey else np.atleast_1d(sigma_t))

    def _sigma_t(self, value: str, channels: int = 1) -> str:
        number = f"world->scene->{self.name}.sigma_t"
        if self.grey:
            return f"{value} * {number}" if value else f"(real){number}"
        colour = f"spectrum_uniform({number})"
        return _scaled(colour, value, channels == 1) if value else colour

    def _numbers(self, member: str) -> str:
        return f"spectrum_uniform(world->scene->{self.name}.{member})"

    def _times(self, colour: str, value: str, field: Field) -> str:
        return _scaled(colour, value, field.channels == 1)

    def _function(self, type_: str, part: str, parameters: str, body: str) -> str:
        if type_ == "coefficient":
            type_ = "real" if self.grey else "spectrum"
        return f"static inline {type_} {self.name}_{part}(const struct world *world, {parameters}) {{\n{body}}}\n"


def _scaled(colour: str, value: str, grey: bool) -> str:
    return f"spectrum_scale({colour}, {value})" if grey else f"spectrum_multiply({colour}, {value})"


def _pick(type_: str, chosen: str, yes: str = "value", no: str = "") -> str:
    """`yes` where chosen, else `no` or 0."""
    if type_ == "real":
        return f"pick({no or '(real)0.f'}, {yes}, {chosen})"
    return f"spectrum_pick({no or 'spectrum_grey((real)0.f)'}, {yes}, {chosen})"


def _stored(field: Field, buffer: str, index: str) -> str:
    if field.channels == 1:
        return f"field_{field.storage}({buffer}, {index})"
    parts = ", ".join(f"field_{field.storage}({buffer}, {index} + {channel})" for channel in range(3))
    return f"spectrum_of({parts})"
