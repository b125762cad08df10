"""Laws of the volume rendering equation that hold for any scene, given the right numbers: `checks.py` asks them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from woodcock.emission import blackbody
from woodcock.film import Film, weights
from woodcock.layout import Layout
from woodcock.plan import integrator
from woodcock.scene import (
    BlackbodyEmission,
    ConstantEmission,
    ConstantLight,
    ConstantVolume,
    DielectricMaterial,
    EmissiveMaterial,
    NullMaterial,
    RoughDielectricMaterial,
    Scene,
    Spectrum,
    Surface,
    TransmittanceIntegrator,
    Volume,
    VolumetricPathIntegrator,
)

#: Optical depth through the whole scene at which laws are asked: neither empty nor slow.
DEPTH = 3.0

#: An albedo that still counts as scattering, an emission that counts as one, so that the program stays the same; of
#: neither anything is to be seen.
FAINT = 1e-30

#: What a light shines by.
STRENGTHS = {
    "constant": "radiance",
    "image": "scale",
    "directional": "irradiance",
    "sun": "irradiance",
    "point": "intensity",
    "spot": "intensity",
}


class DoesNotApply(Exception):  # noqa: N818 - it says what is so
    """Why a law cannot be asked of a scene."""


class Render(Protocol):
    """A picture of a scene; own: by the program that is asked. Raises DoesNotApply."""

    def __call__(self, scene: Scene, /, *, own: bool = True, samples: int | None = None) -> Film: ...


@dataclass(frozen=True)
class Answer:
    """How far a picture's mean, or without noise any value, is off; noise: its standard error; scale: of the values."""

    deviation: float
    noise: float
    scale: float


@dataclass(frozen=True)
class Law:
    """ask(scene, layout, render): the scene as it is and its layout. Raises DoesNotApply."""

    name: str
    says: str
    ask: Callable[[Scene, Layout, Render], Answer]


# What the laws are


def white_furnace(scene: Scene, layout: Layout, render: Render) -> Answer:
    lossless = [_changed(volume, albedo=1.0) for volume in map(_dark, scene.volumes)]
    return _uniform(render(_thin(_enclosed(scene, lossless, 1.0), layout)), 1.0)


def isothermal_furnace(scene: Scene, layout: Layout, render: Render) -> Answer:
    found = [volume.emission for volume in scene.volumes if _has_one_temperature(volume)]
    if not found:
        raise DoesNotApply("no medium of one temperature emits")
    if len(found) < len(scene.volumes) and integrator(scene) != "volumetric_path":
        raise DoesNotApply("a medium absorbs and does not emit by one temperature")
    black = next((emission for emission in found if isinstance(emission, BlackbodyEmission)), None)
    radiance = np.ones(3) if black is None else blackbody.radiance(black, np.array(black.kelvin))
    thin = _thin(scene, layout)
    media = [
        _at(volume, radiance) if _has_one_temperature(volume) else _changed(_dark(volume), albedo=1.0)
        for volume in thin.volumes
    ]
    return _uniform(render(_enclosed(thin, media, _spectrum(radiance))), radiance)


def darkness(scene: Scene, layout: Layout, render: Render) -> Answer:
    lights = [_shining(light, 0.0) for light in scene.lights]
    surfaces = [_emitting(surface, 0.0) for surface in scene.surfaces]
    changes = {"lights": tuple(lights), "surfaces": tuple(surfaces), "volumes": tuple(map(_dark, scene.volumes))}
    film = render(_thin(scene.model_copy(update=changes), layout)).layer("")
    return Answer(float(np.abs(film.mean).max()), 0.0, 1.0)


def absorption(scene: Scene, layout: Layout, render: Render) -> Answer:
    if scene.surfaces or any(isinstance(v, ConstantVolume) and v.shape.kind == "mesh" for v in scene.volumes):
        raise DoesNotApply("the integrator that it is compared with knows no surfaces and no meshes")
    absorbing = [_changed(volume, albedo=FAINT) for volume in map(_dark, scene.volumes)]
    changed = _thin(_enclosed(scene, absorbing, 1.0), layout)
    film = render(changed).layer("")
    without = {"integrator": TransmittanceIntegrator(), "layers": (), "orders": None}
    exact = render(changed.model_copy(update=without), own=False, samples=256).layer("")
    # A scene of colours may be grey without its lights and albedos.
    deviation = (film.mean.mean(axis=(0, 1)) - exact.mean.mean(axis=(0, 1))) @ weights(film.channels)
    return Answer(float(deviation), film.mean_luminance_error(), exact.mean_luminance())


def squared_transmittance(scene: Scene, layout: Layout, render: Render) -> Answer:
    thin = _thin(_enclosed(scene, list(map(_dark, scene.volumes)), 1.0), layout)
    half = thin.model_copy(update={"volumes": tuple(_thinned(volume, 0.5) for volume in thin.volumes)})
    whole, root = (render(each, samples=1).layer("").mean for each in (thin, half))
    return Answer(float(np.abs(whole - root**2).max()), 0.0, 1.0)


ISOTHERMAL = Law(
    "isothermal furnace", "Between walls of its own temperature no medium is to be seen.", isothermal_furnace
)
DARKNESS = Law("darkness", "Where nothing shines, every pixel is 0.", darkness)
OF_RANDOM_PATHS = (
    Law("white furnace", "Where nothing absorbs and light comes from everywhere, every pixel is 1.", white_furnace),
    ISOTHERMAL,
    DARKNESS,
    Law(
        "absorption",
        "Where nothing scatters, random paths have the mean of the integrator without random numbers.",
        absorption,
    ),
)
WITHOUT_NOISE = (
    Law("squared transmittance", "Twice the medium transmits the square.", squared_transmittance),
    ISOTHERMAL,
    DARKNESS,
)


def laws_of(scene: Scene) -> tuple[Law, ...]:
    """Those that the scene's integrator must keep."""
    return OF_RANDOM_PATHS if integrator(scene) == "volumetric_path" else WITHOUT_NOISE


def _uniform(film: Film, expected: Any) -> Answer:
    film = film.layer("")
    if film.bound is not None:
        return Answer(float(np.abs(film.mean - expected).max()), 0.0, float(np.max(expected)))
    scale = np.broadcast_to(np.asarray(expected, float), film.channels if film.channels == 3 else 3)[: film.channels]
    return Answer(
        film.mean_luminance() - float(scale @ weights(film.channels)), film.mean_luminance_error(), float(scale.max())
    )


# Scenes with other numbers


def _enclosed(scene: Scene, volumes: list[Volume], radiance: Spectrum) -> Scene:
    """The volumes between walls that lose nothing, in an environment of one radiance and no other light."""
    environment = next((light for light in scene.lights if isinstance(light, ConstantLight)), None)
    if environment is None:
        raise DoesNotApply("the scene has no constant environment")
    lights = [_shining(light, radiance if light is environment else 0.0) for light in scene.lights]
    changes: dict[str, Any] = {"volumes": tuple(volumes), "lights": tuple(lights)}
    changes["surfaces"] = tuple(_lossless(surface, radiance) for surface in scene.surfaces)
    if integrator(scene) == "volumetric_path":
        changes["integrator"] = VolumetricPathIntegrator()
    return scene.model_copy(update=changes)


def _lossless(surface: Surface, radiance: Spectrum) -> Surface:
    match surface.material:
        case EmissiveMaterial() as material:
            # One that shines on one side is black on the other.
            changes: dict[str, Any] = {"radiance": _like(material.radiance, radiance), "two_sided": True}
        case NullMaterial():
            return surface
        case DielectricMaterial() | RoughDielectricMaterial():
            changes = {"ior": 1.0}
        case material:
            changes = {"reflectance": _like(material.reflectance, 1.0)}
    return surface.model_copy(update={"material": surface.material.model_copy(update=changes)})


def _emitting(surface: Surface, radiance: Spectrum) -> Surface:
    material = surface.material
    if not isinstance(material, EmissiveMaterial):
        return surface
    changes = {"radiance": _like(material.radiance, radiance)}
    return surface.model_copy(update={"material": material.model_copy(update=changes)})


def _shining(light: Any, strength: Spectrum) -> Any:
    name = STRENGTHS[light.kind]
    return light.model_copy(update={name: _like(getattr(light, name), strength)})


def _changed(volume: Volume, **numbers: float) -> Volume:
    if isinstance(volume, ConstantVolume) or volume.albedo_grid is None:
        return volume.model_copy(update={name: _like(getattr(volume, name), value) for name, value in numbers.items()})
    raise DoesNotApply("a grid holds the albedo")


def _dark(volume: Volume) -> Volume:
    name = {"constant": "epsilon", "grid": "scale", "blackbody": "luminance"}
    if volume.emission is None:
        return volume
    strength = name[volume.emission.kind]
    none = {strength: _like(getattr(volume.emission, strength), FAINT)}
    return volume.model_copy(update={"emission": volume.emission.model_copy(update=none)})


def _has_one_temperature(volume: Volume) -> bool:
    emission = volume.emission
    if isinstance(emission, BlackbodyEmission):
        return emission.file is None
    return isinstance(emission, ConstantEmission) and isinstance(volume, ConstantVolume)


def _at(volume: Volume, radiance: Any) -> Volume:
    """The medium in equilibrium with light of a radiance (3,): ε = σ_a B."""
    if not isinstance(volume.emission, ConstantEmission) or not isinstance(volume, ConstantVolume):
        return volume
    epsilon = np.array(volume.sigma_t) * (1 - np.array(volume.albedo)) * radiance
    emission = volume.emission.model_copy(update={"epsilon": _like(volume.emission.epsilon, _spectrum(epsilon))})
    return volume.model_copy(update={"emission": emission})


def _thin(scene: Scene, layout: Layout) -> Scene:
    """The scene with an optical depth of about DEPTH from end to end."""
    depth = _depth(layout)
    factor = DEPTH / depth if depth > 0 else 1.0
    return scene.model_copy(update={"volumes": tuple(_thinned(volume, factor) for volume in scene.volumes)})


def _depth(layout: Layout) -> float:
    """Of the largest σ_t over the length that a scene has on the device, about 1."""
    return sum(layout.space.coefficient(max(medium["sigma_t"])) for medium in layout.facts["media"])


def _thinned(volume: Volume, factor: float) -> Volume:
    name = "sigma_t" if isinstance(volume, ConstantVolume) else "scale"
    value = getattr(volume, name)
    thinner = tuple(one * factor for one in value) if isinstance(value, tuple) else value * factor
    return volume.model_copy(update={name: thinner})


def _like(value: Spectrum, number: Spectrum) -> Spectrum:
    """A number in the shape of another, so that what is grey or coloured stays so. Raises DoesNotApply."""
    if isinstance(value, tuple):
        return number if isinstance(number, tuple) else (number, number, number)
    if isinstance(number, tuple):
        if len(set(number)) > 1:
            raise DoesNotApply("what is grey in the scene would have to be coloured")
        return number[0]
    return number


def _spectrum(values: Any) -> Spectrum:
    values = np.asarray(values, float)
    return float(values) if values.ndim == 0 else (float(values[0]), float(values[1]), float(values[2]))
