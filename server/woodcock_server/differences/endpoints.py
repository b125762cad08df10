"""/api/v1/jobs/{id}/differences"""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Query, Response

from woodcock_server.differences.schemas import Difference, Map
from woodcock_server.jobs import repository, service
from woodcock_server.jobs.endpoints import Existing
from woodcock_server.jobs.schemas import PREFIX
from woodcock_server.layers.endpoints import FOREVER, Halves
from woodcock_server.layers.halves import halves, scale_of
from woodcock_server.problems import problem_schema
from woodcock_server.services import Provided

router = APIRouter(prefix=f"{PREFIX}/{{id}}/differences/{{other}}", tags=["differences"])


def _other(other: str, services: Provided) -> repository.Row:
    with services.engine.connect() as connection:
        return service.existing(connection, other)


Other = Annotated[repository.Row, Depends(_other)]


@router.get("", responses=problem_schema(404, 409))
async def get_difference(
    row: Existing,
    other: Other,
    services: Provided,
    flip: Annotated[bool, Query(description="With FLIP, which takes seconds, of large pictures a minute.")] = True,
) -> Difference:
    """How far a job's picture is from another job's, the reference, and whether that is noise or bias."""
    return await services.differences.numbers(row, other, flip=flip)


@router.get(
    "/{map}",
    response_class=Halves,
    responses={
        200: {
            "headers": {
                "Woodcock-Scale": {"description": "What the halves are to be multiplied by, a power of two."},
            }
        },
        **problem_schema(404, 409),
    },
)
async def get_difference_map(row: Existing, other: Other, map: Map, services: Provided) -> Response:
    """Where a job's picture I differs from a reference R: little-endian half floats, as layers, one or three a pixel.

    `difference` is I - R, `absolute` its size, `relative` (I - R)² / (R² + ε), `smape` |I - R| / (|I| + |R|), `flip`
    HDR-FLIP, `z` the z-score (I - R) / √(var I + var R): of noise alone its square is 1 on average.
    """
    found = await services.differences.map(row, other, map)
    scale = scale_of(found)
    headers = {"Cache-Control": FOREVER, "Woodcock-Scale": repr(scale)}
    return Halves(halves(found, scale), headers=headers)
