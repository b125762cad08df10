"""The channels of a picture, by their names in an EXR, and their order: it is decided here and nowhere else."""

from __future__ import annotations

from woodcock.scene import LayerName, Scene

#: Suffixes of a layer's channels, as is usual in EXR files; empty where they are the beauty's.
SUFFIXES: dict[LayerName, str] = {
    "albedo": "",
    "normal": "XYZ",
    "depth": "Z",
    "optical_depth": "Y",
    "transmittance": "Y",
    "position": "XYZ",
}


def beauty_names(channels: int) -> tuple[str, ...]:
    """R, G, B or, of a grey scene, Y."""
    return ("R", "G", "B") if channels == 3 else ("Y",)


def order_layers(scene: Scene) -> tuple[str, ...]:
    """`order.0` to `order.n` and `order.rest`, whose sum is the beauty; empty where the scene does not ask."""
    return () if scene.orders is None else (*(f"order.{n}" for n in range(scene.orders + 1)), "order.rest")


def layer_names(scene: Scene, channels: int) -> tuple[str, ...]:
    """Every channel of the scene's Film in order: the beauty, the orders of scattering, then the layers as asked for.

    channels: of the beauty, 1 or 3.
    """
    beauty = beauty_names(channels)
    names = [*beauty, *(f"{layer}.{suffix}" for layer in order_layers(scene) for suffix in beauty)]
    names += [f"{layer}.{suffix}" for layer in scene.layers for suffix in SUFFIXES[layer] or beauty]
    return tuple(names)


def is_radiance(name: str) -> bool:
    """Whether a channel holds radiance: the beauty's and the orders' do, and they alone come with a variance.

    The other layers are what camera rays meet first. They vary over a pixel because the scene does, and nobody
    integrates them: their variance would say nothing of an error.
    """
    return "." not in name or name.startswith("order.")


def exponents(names: tuple[str, ...], radiance: int, length: int) -> list[int]:
    """The power of two that a kernel's number is to be scaled by, for each channel, given those of its `Space`."""
    # Positions leave the kernel in the scene's own units: they have an origin, not only a scale.
    units: dict[str, int] = {"depth": length}
    return [radiance if is_radiance(name) else units.get(name.partition(".")[0], 0) for name in names]
