"""What is said of a job on its way."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import TypeAdapter

from woodcock.scene import Stop
from woodcock_client.models import Job
from woodcock_client.progress import samples


@pytest.mark.parametrize(
    ("target", "expected"),
    [
        ({"kind": "samples", "samples": 64}, "40 / 64 samples"),
        ({"kind": "seconds", "seconds": 3}, "40 samples in 1.2 / 3 s"),
        ({"kind": "relative_error", "relative_error": 0.01, "per": "tile"}, "40 samples to an error of 1.00%"),
    ],
)
def test_samples_are_told_against_what_the_contract_counts(target: dict[str, Any], expected: str) -> None:
    stop: Stop = TypeAdapter(Stop).validate_python(target)
    assert samples(Job.model_construct(samples=40, seconds=1.2, target=stop)) == expected
