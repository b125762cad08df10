"""/api/v1/jobs/{id}/layers and /api/v1/jobs/{id}/pixels"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, TypeVar

from anyio import to_thread
from fastapi import APIRouter, Header, HTTPException, Query, Response

from woodcock.image import ImageError
from woodcock_server.etags import UNCHANGED
from woodcock_server.jobs.endpoints import Existing
from woodcock_server.jobs.repository import Row
from woodcock_server.jobs.schemas import PREFIX
from woodcock_server.jobs.states import State
from woodcock_server.layers import values
from woodcock_server.layers.halves import halves, scale_of
from woodcock_server.layers.pictures import Picture, Unseen
from woodcock_server.layers.schemas import LayerList, Pixels
from woodcock_server.problems import Fault, InvalidRequest, problem_schema
from woodcock_server.services import Provided, Services

router = APIRouter(prefix=PREFIX, tags=["layers"])

FOREVER = "private, max-age=31536000, immutable"
ASK_AGAIN = "private, no-cache"

T = TypeVar("T")


class Halves(Response):
    media_type = "application/octet-stream"


Samples = Annotated[
    int | None,
    Query(
        ge=0, description="How many the picture has, if that is known: of a job that has ended the answer is for good."
    ),
]
Place = Annotated[int, Query(ge=0, lt=1 << 16, description="From the upper left corner, pixels.")]
Size = Annotated[int, Query(ge=1, le=1 << 16, description="Pixels.")]


@router.get("/{id}/layers", responses=problem_schema(404))
async def list_layers(row: Existing, services: Provided) -> LayerList:
    """What the picture is made of so far: the beauty, what the scene asks for, variances and counts of samples. None as
    long as nothing was kept of it."""

    def listed(picture: Picture) -> LayerList:
        return LayerList(
            width=picture.width,
            height=picture.height,
            samples=picture.samples,
            layers=values.described(picture, f"{PREFIX}/{row['id']}/layers"),
        )

    try:
        return await _looked(services, row, listed)
    except Unseen:
        if State(row["state"]).final:
            raise
        film = row["scene"]["film"]
        return LayerList(width=film["width"], height=film["height"], samples=0, layers=[])


@router.get(
    "/{id}/layers/{name}",
    response_class=Halves,
    responses={
        200: {
            "headers": {
                "Woodcock-Scale": {"description": "What the halves are to be multiplied by, a power of two."},
                "Woodcock-Samples": {"description": "Of a pixel that has all of them."},
            }
        },
        **UNCHANGED,
        **problem_schema(404),
    },
)
async def get_layer(
    row: Existing,
    name: str,
    services: Provided,
    samples: Samples = None,
    known: Annotated[str | None, Header(alias="If-None-Match")] = None,
) -> Response:
    """A layer's pixels: little-endian half floats, rows from the top, channels of a pixel beside each other.

    Values are half × `Woodcock-Scale`, to three digits; `pixels` and image.exr have all of them.
    """

    def packed(picture: Picture) -> Response:
        done = row["state"] == State.SUCCEEDED and samples == row["samples"]
        tag = f'"{picture.tag}"'
        headers = {"ETag": tag, "Cache-Control": FOREVER if done else ASK_AGAIN}
        if known is not None and tag in known:
            return Response(status_code=304, headers=headers)
        pixels = values.layer(picture, name)
        if pixels is None:
            raise HTTPException(
                404, f"Job {row['id']} has no layer {name}: it has {', '.join(values.layers_of(picture))}."
            )
        scale = scale_of(pixels)
        headers |= {"Woodcock-Scale": repr(scale), "Woodcock-Samples": str(picture.samples)}
        return Halves(halves(pixels, scale), headers=headers)

    return await _looked(services, row, packed)


@router.get("/{id}/pixels", responses=problem_schema(404))
async def get_pixels(
    row: Existing, services: Provided, x: Place, y: Place, width: Size = 1, height: Size = 1
) -> Pixels:
    """What every layer holds at a pixel, or on average in a rectangle of them, and how far that may be off."""

    def held(picture: Picture) -> Pixels:
        faults = _outside("x", "width", x, width, picture.width) + _outside("y", "height", y, height, picture.height)
        if faults:
            size = f"{picture.width} × {picture.height}"
            raise InvalidRequest(f"The picture has {size} pixels; these are not all in it.", *faults)
        found = values.values_in(picture, x, y, width, height)
        return Pixels(x=x, y=y, width=width, height=height, samples=picture.samples, layers=found)

    return await _looked(services, row, held)


def _outside(place: str, size: str, at: int, length: int, whole: int) -> list[Fault]:
    if at >= whole:
        return [Fault(field=place, message=f"must be less than {whole}")]
    return [Fault(field=size, message=f"must be {whole - at} at most, from {at} on")] if at + length > whole else []


async def _looked(services: Services, row: Row, look: Callable[[Picture], T]) -> T:
    """What is seen in the job's picture. Raises Unseen."""

    def seen() -> T:
        try:
            return look(services.pictures.of(row))
        except (ImageError, OSError):  # It was deleted meanwhile.
            raise Unseen(row, "its image.exr was deleted or cannot be read") from None

    return await to_thread.run_sync(seen, limiter=services.pictures.turns)
