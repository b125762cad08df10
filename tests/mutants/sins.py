"""The list of deliberate bugs."""

from __future__ import annotations

from tests.mutants import host, kinds, sampling, transport, trust
from tests.mutants.sin import Sin

SINS: tuple[Sin, ...] = (*transport.SINS, *sampling.SINS, *kinds.SINS, *host.SINS, *trust.SINS)
