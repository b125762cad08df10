"""The list of deliberate bugs."""

from __future__ import annotations

from tests.mutants import contract, host, kinds, prediction, sampling, series, service, transport, trust
from tests.mutants.sin import Sin

SINS: tuple[Sin, ...] = (
    *transport.SINS,
    *sampling.SINS,
    *kinds.SINS,
    *host.SINS,
    *trust.SINS,
    *contract.SINS,
    *series.SINS,
    *service.SINS,
    *prediction.SINS,
)
