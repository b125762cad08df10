"""The media of a scene, read: their fields, where they are, how dense at most, and what they emit."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from woodcock.emission import blackbody
from woodcock.formats import Grid
from woodcock.majorant.control import Stored
from woodcock.majorant.grid import Bounded, Floats
from woodcock.scene import BlackbodyEmission, ConstantEmission, ConstantVolume, GridEmission, GridVolume, Volume
from woodcock.space import Array
from woodcock.volume import grid as grids
from woodcock.volume.field import Field

Read = Callable[[str, str | None], Grid]


@dataclass(frozen=True)
class Medium:
    """A volume, read. The fields are a grid medium's: its density, and grids beside it, each in a place of its own."""

    volume: Volume
    density: Field | None = None
    albedo: Field | None = None
    emission: Field | None = None

    def to_scene(self, field: Field) -> Array:
        """(4, 4) from a field's voxels."""
        assert isinstance(self.volume, GridVolume)
        return grids.to_scene(self.volume, field.grid)

    def place(self, part: str) -> str:
        """The field whose record says where the voxels of `part` are: the density's, if they are the same."""
        field, density = getattr(self, part), self.density
        assert field is not None
        assert density is not None
        same = field.size == density.size and np.array_equal(self.to_scene(field), self.to_scene(density))
        return "density" if same else part

    @property
    def bound(self) -> Array:
        """(1,) or (3,): the largest σ_t of every channel."""
        if self.density is None:
            assert isinstance(self.volume, ConstantVolume)
            return np.atleast_1d(np.array(self.volume.sigma_t))
        assert isinstance(self.volume, GridVolume)
        return np.atleast_1d(np.array(self.volume.scale)) * _largest(self.density)

    @property
    def temperature(self) -> float:
        """The highest, in kelvin; 0 for a medium that is no black body."""
        emission = self.volume.emission
        if not isinstance(emission, BlackbodyEmission):
            return 0.0
        return emission.kelvin * (self.emission.largest if self.emission else 1.0)

    @property
    def epsilon(self) -> Array:
        """(1,) or (3,): the largest ε, or what it is at most."""
        match self.volume.emission:
            case None:
                return np.zeros(1)
            case ConstantEmission(epsilon=value):
                return np.atleast_1d(np.array(value))
            case GridEmission(scale=scale):
                assert self.emission is not None
                return np.atleast_1d(np.array(scale)) * self.emission.largest
            case BlackbodyEmission() as emission:
                least = np.min(self.volume.albedo) if self.albedo is None else 0.0
                return self.bound * (1 - least) * blackbody.radiance(emission, np.array(self.temperature))

    @property
    def scatters(self) -> bool:
        return bool(np.max(self.bound) > 0 and np.max(self.volume.albedo) > 0)

    @property
    def emits(self) -> bool:
        return bool(np.max(self.epsilon) > 0)

    @property
    def grey(self) -> bool:
        """Is σ_t one number for all channels?"""
        return self.bound.size == 1

    @property
    def coloured(self) -> bool:
        """Is any of σ_t, albedo and ε not one number for all channels?"""
        fields = (field for field in (self.density, self.albedo, self.emission) if field)
        spectra = itertools.chain((self.bound, self.epsilon, np.atleast_1d(np.array(self.volume.albedo))))
        return any(field.channels > 1 for field in fields) or any(spectrum.size > 1 for spectrum in spectra)

    def bounded(self) -> Bounded:
        """What majorants are made from, for a grid medium."""
        assert self.density is not None
        assert isinstance(self.volume, GridVolume)
        field, scale = self.density, np.atleast_1d(np.array(self.volume.scale, float))
        most = float(scale.max())
        weights = (scale / most if most > 0 else scale).astype(np.float32)

        def slab(first: int, stop: int) -> Floats:
            values = field.decoded(first, stop)
            return values if values.ndim == 3 else np.asarray((values * weights).max(axis=-1))

        return Bounded(slab, most, field.size, 0.5 if field.nearest else 1.0, self.to_scene(field))

    def stored(self) -> Stored:
        """What controls are made from, for a grid medium."""
        assert self.density is not None
        assert isinstance(self.volume, GridVolume)
        field, bounded = self.density, self.bounded()

        def slab(channel: int) -> Callable[[int, int], Floats]:
            def of(first: int, stop: int) -> Floats:
                values = field.stored(first, stop)
                return values if values.ndim == 3 else values[..., channel]

            return of

        channels = tuple(replace(bounded, slab=slab(channel), scale=1.0) for channel in range(field.channels))
        return Stored(channels, np.atleast_1d(np.array(self.volume.scale, float)) * field.step)


def read_media(volumes: Sequence[Volume], read: Read) -> tuple[Medium, ...]:
    """Raises VolumeError for files that cannot be read, or that hold no such quantity."""
    return tuple(_grid(volume, read) if isinstance(volume, GridVolume) else Medium(volume) for volume in volumes)


def corners(field: Field, to_scene: Array) -> Array:
    """(8, 3), in the scene."""
    unit = np.array(list(np.ndindex(2, 2, 2))) * np.array(field.size)
    return np.asarray(unit @ to_scene[:3, :3].T + to_scene[:3, 3])


def strongest(medium: Medium, extent: float) -> float:
    """No ray gains more radiance than this from a medium over `extent`, a length of the scene: ∫ ε, or hottest B."""
    thin = float(np.max(medium.epsilon)) * extent
    if isinstance(medium.volume.emission, BlackbodyEmission):
        return min(thin, float(blackbody.radiance(medium.volume.emission, np.array(medium.temperature)).max()))
    return thin


def _grid(volume: GridVolume, read: Read) -> Medium:
    nearest, allowed = volume.interpolation == "nearest", volume.storage_error

    def field(file: str, name: str | None, what: str, most: float = np.inf, *, colours: bool = True) -> Field:
        grid = read(file, name)
        largest = grids.check_values(grid, file, what, most, colours=colours)
        return Field.of(grid, largest, allowed, nearest=nearest)

    grid = read(volume.file, volume.grid)
    density = Field.of(grid, grids.check(grid, volume.file), allowed, nearest=nearest)
    albedo = emission = None
    if volume.albedo_grid:
        albedo = field(volume.albedo_grid.file, volume.albedo_grid.grid, "albedos", 1.0)
    match volume.emission:
        case GridEmission(file=file, grid=name):
            emission = field(file, name, "emission")
        case BlackbodyEmission(file=str() as file, grid=name):
            emission = field(file, name or "temperature", "temperatures", colours=False)
    return Medium(volume, density, albedo, emission)


def _largest(field: Field) -> Array:
    """(1,) or (3,): the largest stored value of every channel."""
    if field.channels == 1:
        return np.array([field.largest * (1 + field.error)])
    return np.asarray(field.grid.values.max(axis=(0, 1, 2)).astype(np.float64) + field.error * field.largest)
