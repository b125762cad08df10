"""What the row says of the Film, over restarts and crashes."""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np

from woodcock.film import Film
from woodcock_server.books import Books

FACTS: Any = {"id": "cpu0", "seconds": {"build": 1.0}}


def film(samples: int) -> Film:
    zeros = np.zeros((2, 2, 1))
    return Film(np.full((2, 2), samples, np.uint32), zeros, zeros, ("Y",), ((0, samples),))


def row(**columns: Any) -> Any:
    """As it comes back from the database."""
    return json.loads(json.dumps({"usage": {}, "series": [], "spent": {}, "kept": None, **columns}))


def test_books_fit_the_film_that_a_crash_leaves() -> None:
    books = Books(row())
    books.prepared("cpu0", FACTS)
    books.rendered("cpu0", film(4), 1.0, "a")
    books.series.append({"samples": 4.0})  # type: ignore[typeddict-item]
    written = [row(**books.columns())]
    books.kept(film(4))
    books.rendered("cpu0", film(6), 2.0, "b")
    books.series.append({"samples": 10.0})  # type: ignore[typeddict-item]
    books.spent["write"] += 0.5
    written.append(row(**books.columns()))
    for columns, found, rendered, seconds, points in (
        (written[0], film(4), 4, 1.0, 1),
        (written[1], film(4), 4, 1.0, 1),  # the crash came before the film of 10
        (written[1], film(10), 10, 3.0, 2),  # and after it
    ):
        again = Books(copy.deepcopy(columns))
        again.resume(found)
        assert (again.usage["cpu0"]["samples"], again.device_seconds) == (rendered, seconds)
        assert sum(again.usage["cpu0"]["programs"].values()) == rendered
        assert len(again.series) == points
        again.prepared("cpu0", FACTS)
        again.prepared("cpu1", {**FACTS, "id": "cpu1"})
        assert again.device_seconds == seconds, "what was rendered before stays"
        assert again.columns()["kept"]["samples"] == rendered
    assert Books(written[1]).spent == {"merge": 0.0, "check": 0.0, "write": 0.5}


def test_a_film_that_is_lost_takes_its_books_along() -> None:
    books = Books(row(usage={"cpu0": {"samples": 7}}, series=[{"samples": 7.0}], spent={"merge": 2.0}))
    assert (books.usage, books.series, books.device_seconds) == ({}, [], 0)
    assert books.spent["merge"] == 2, "the time is spent all the same"
