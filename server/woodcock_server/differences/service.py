"""Differences of finished pictures: computed one at a time, for they take memory, and kept within bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from typing import Any, get_args

import numpy as np
from anyio import Lock, to_thread
from numpy.typing import NDArray

from woodcock import metrics
from woodcock.compare.noise import judge, z_scores
from woodcock.compare.rendered import Rendered
from woodcock.image import ImageError
from woodcock.series import held_against
from woodcock_server.differences.schemas import Difference, Map
from woodcock_server.jobs.schemas import PREFIX
from woodcock_server.jobs.states import State
from woodcock_server.layers.cache import Cache
from woodcock_server.problems import Conflict
from woodcock_server.storage import Storage

#: Pairs whose numbers are kept, and bytes of FLIP's maps, which take seconds to make.
PAIRS, FLIPS = 256, 64 << 20

Row = Mapping[str, Any]

#: Seconds that FLIP may take, by `metrics.flip_seconds`.
MOST_SECONDS = 120.0


class NoFlip(Exception):  # noqa: N818 - it is an answer
    """There is none for these pictures."""


class Differences:
    """Of pairs of rows of jobs: the picture, and the reference."""

    def __init__(self, storage: Storage) -> None:
        self._storage = storage
        self._turn, self._flip_turn = Lock(), Lock()
        self._flips = Cache(FLIPS)
        # A finished picture never changes.
        self._known = lru_cache(PAIRS)(self._measured)

    async def numbers(self, picture: Row, reference: Row, *, flip: bool) -> Difference:
        """flip: with FLIP, which may take a minute. Raises Conflict."""
        check(picture, reference)
        ids = picture["id"], reference["id"]
        async with self._turn:
            found = await to_thread.run_sync(self._known, *ids)
        mean = None
        if flip:
            with suppress(NoFlip):
                mean = float((await self._flip(picture, reference)).mean(dtype=np.float64))
        return found.model_copy(update={"flip": mean})

    async def map(self, picture: Row, reference: Row, name: Map) -> NDArray[np.float32]:
        """(height, width, channels). Raises Conflict."""
        check(picture, reference)
        if name != "flip":
            async with self._turn:
                return await to_thread.run_sync(self._mapped, picture["id"], reference["id"], name)
        try:
            return await self._flip(picture, reference)
        except NoFlip:
            raise Conflict(
                "FLIP has no answer here: the reference is black, the pictures are too large, or the package "
                "flip-evaluator is not installed."
            ) from None

    async def _flip(self, picture: Row, reference: Row) -> NDArray[np.float32]:
        """Raises NoFlip."""
        ids = picture["id"], reference["id"]

        def made() -> dict[str, NDArray[np.float32]]:
            mine, its = (one.mean for one in self._loaded(*ids))
            errors = metrics.flip_errors(mine, its) if metrics.flip_seconds(its) < MOST_SECONDS else None
            if errors is None:
                raise NoFlip
            return {"flip": errors.astype(np.float32)}

        async with self._flip_turn:
            return (await to_thread.run_sync(self._flips.get, ids, made))["flip"]

    def _measured(self, picture_id: str, reference_id: str) -> Difference:
        picture, reference = self._loaded(picture_id, reference_id)
        verdict = judge(picture, reference)
        its = None if verdict["shared"] else reference.variance
        with np.errstate(over="ignore"):  # what is relative to a black reference
            numbers = held_against(picture.mean, picture.variance, reference.mean, its, flip_within=0)
        path = f"{PREFIX}/{picture_id}/differences/{reference_id}"
        return Difference.model_validate(
            {
                **{key: numbers[key] for key in ("mse", "smape", "bias")},
                "rel_mse": numbers["rel_mse"] if reference.mean.any() and math.isfinite(numbers["rel_mse"]) else None,
                "flip": None,
                "noise": None if picture.variance is None else metrics.noise(picture.variance),
                "reference_noise": numbers["reference_mse"],
                "reference_mean": metrics.bias(reference.mean, np.zeros(())),
                "job": picture_id,
                "reference": reference_id,
                "verdict": verdict,
                "maps": {
                    name: f"{path}/{name}" for name in get_args(Map) if name != "z" or verdict["scatter"] is not None
                },
            }
        )

    def _mapped(self, picture_id: str, reference_id: str, name: Map) -> NDArray[np.float32]:
        picture, reference = self._loaded(picture_id, reference_id)
        mine, its = picture.mean, reference.mean
        match name:
            case "difference":
                found = mine - its
            case "absolute":
                found = np.abs(mine - its)
            case "relative":
                found = metrics.relative_squares(mine, its)
            case "smape":
                found = metrics.symmetric_errors(mine, its)
            case _:
                scores = z_scores(picture, reference)
                if scores is None:
                    raise Conflict(
                        "There are no z-scores of these pictures: they have no noise, fewer than two samples, or the "
                        "same random numbers, so that their variances do not tell how far they should differ."
                    )
                found = scores
        with np.errstate(over="ignore"):
            return found.astype(np.float32)

    def _loaded(self, picture_id: str, reference_id: str) -> tuple[Rendered, Rendered]:
        """Raises Conflict."""
        try:
            mine, its = (
                Rendered.load(self._storage.job_file(each, "image.exr")) for each in (picture_id, reference_id)
            )
            return mine.beside(its), its.beside(mine)
        except ImageError as error:
            raise Conflict(f"These pictures cannot be compared: {self._storage.by_id(str(error))}") from None


def check(picture: Row, reference: Row) -> None:
    """Raises Conflict for jobs that cannot be compared, by their rows."""
    for row in (picture, reference):
        if row["state"] != State.SUCCEEDED:
            raise Conflict(f"Job {row['id']} is {row['state']}. Only jobs that have succeeded are compared.")
    mine, its = ((row["scene"]["film"]["width"], row["scene"]["film"]["height"]) for row in (picture, reference))
    if mine != its:
        raise Conflict(
            f"Job {picture['id']} is {mine[0]} × {mine[1]} pixels, and {reference['id']} {its[0]} × {its[1]}. Only "
            "pictures of one size are compared."
        )
