"""What a job's row says of its Film: which device rendered how much of it, how its error fell, where the time went."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from woodcock.film import Film
from woodcock.report import Facts, Use
from woodcock.series import Point


class Books:
    """They are written before the checkpoint, beside those of the checkpoint that is there: a crash may leave either.

    usage: by device; spent: wall seconds of merge, check and write, by all attempts.
    """

    def __init__(self, row: Mapping[str, Any]) -> None:
        self.usage: dict[str, Use] = {}
        self.series: list[Point] = []
        self.spent: dict[str, float] = {"merge": 0.0, "check": 0.0, "write": 0.0, **row["spent"]}
        self._row = row
        self._kept: dict[str, Any] | None = None  # of the checkpoint on the disk

    @property
    def device_seconds(self) -> float:
        """In which devices rendered the Film."""
        return sum(use["render_seconds"] for use in self.usage.values())

    def resume(self, film: Film) -> None:
        """Those of the checkpoint that was found."""
        kept = self._row["kept"]
        said = kept if kept and kept["samples"] == film.mean_samples else self._row
        self.usage, self.series = said["usage"], said["series"]
        self.kept(film)

    def prepared(self, device: str, facts: Facts) -> None:
        """A device is ready; what it rendered in former attempts stays its own."""
        before = self.usage.get(device)
        self.usage[device] = {
            **facts,
            "id": device,
            "samples": before["samples"] if before else 0,
            "programs": before["programs"] if before else {},
            "render_seconds": before["render_seconds"] if before else 0.0,
            "evidence": None,
        }

    def rendered(self, device: str, film: Film, seconds: float, program: str) -> None:
        """A device took so long for a part of the Film, by the program of this hash."""
        use = self.usage[device]
        use["samples"] += film.samples
        use["programs"][program] = use["programs"].get(program, 0.0) + film.mean_samples
        use["render_seconds"] += seconds

    def columns(self) -> dict[str, Any]:
        """For the row, before the checkpoint is written."""
        return {"usage": self.usage, "series": self.series, "spent": self.spent, "kept": self._kept}

    def kept(self, film: Film) -> None:
        """The checkpoint is written."""
        self._kept = copy.deepcopy({"samples": film.mean_samples, "usage": self.usage, "series": self.series})
