"""The flip-book: one picture in several views of one size, turned by digits or buttons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from woodcock.film import Film, weights
from woodcock.image import tone_map, white_of
from woodcock.pages import words
from woodcock.pages.legend import legend
from woodcock.pages.pictures import LARGEST, Scale, both_ways, data_uri, decades, shrunk
from woodcock.space import Array

if TYPE_CHECKING:
    from woodcock.reference import Reference


@dataclass(frozen=True)
class Frame:
    """says: what its colours mean; uri: a PNG; legend: of false colour, None where colours are the picture's."""

    name: str
    says: str
    uri: str
    legend: Markup | None = None


def frames(film: Film, reference: Reference | None) -> list[Frame]:
    """The views of a film, with those that a reference adds; radiance in all of them at one exposure."""
    beauty, mean = film.layer("").mean, film.mean_luminance()
    white = white_of(beauty)
    exposure = f"{words.number(white)} is near white" if white > 0 else "black"
    found = [radiance_frame("Result", f"Radiance as a preview shows it; {exposure}.", beauty, white)]
    squares = (film.layer("").variance() if film.bound is None else film.bound**2) @ weights(film.channels)
    known = np.isfinite(squares).all()
    name, what = (
        ("Standard error", "Standard error")
        if film.bound is None
        else ("Error bound", "What the radiance may be off by, at most")
    )
    if known:
        text = f"{what} of each pixel’s mean, its channels weighted by luminance."
        scale = decades(np.sqrt(squares), "radiance")
        found.append(coloured_frame(name, text, squares, scale, mean, root=True))
    if film.count.min() < film.count.max():
        count = film.count.astype(float)
        scale = Scale(float(count.min()), float(count.max()), "samples")
        found.append(coloured_frame("Samples", "Samples of each pixel; more where it was noisier.", count, scale))
    if reference is not None:
        found.append(radiance_frame("Reference", f"{reference.name}, at the same exposure.", reference.mean, white))
        off = beauty @ weights(film.channels) - reference.mean @ weights(reference.mean.shape[-1])
        text = "Luminance of the result minus that of the reference: red is too bright, blue too dark."
        found.append(coloured_frame("Error", text, off, both_ways(off, "radiance"), mean))
    return found


def radiance_frame(name: str, says: str, radiance: Array, white: float, largest: int = LARGEST) -> Frame:
    pixels = tone_map(radiance, white).astype(np.float32)
    return Frame(name, says, data_uri(shrunk(pixels, largest)))


def coloured_frame(
    name: str,
    says: str,
    values: Array,
    scale: Scale | None,
    mean: float = 0.0,
    *,
    root: bool = False,
    largest: int = LARGEST,
) -> Frame:
    """In false colour. values: (height, width); mean: what the legend's shares are of, 0 for none; root: colour the
    values' square roots, after they have been averaged over what becomes one pixel of the page.

    Without a scale the numbers are all 0.
    """
    small = shrunk(values[..., None], largest)[..., 0].astype(float)
    if scale is None:
        return Frame(name, f"{says} It is 0 everywhere.", data_uri(np.zeros((*small.shape, 3))))
    small = np.sqrt(small.clip(0)) if root else small
    return Frame(name, says, data_uri(scale.colours(small)), legend(scale, mean))
