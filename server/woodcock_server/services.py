"""What the endpoints work with, made once by app.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Request
from sqlalchemy import Engine

from woodcock_server.cluster import Cluster
from woodcock_server.devices.checks import Checks
from woodcock_server.devices.service import Found
from woodcock_server.differences.service import Differences
from woodcock_server.dispatcher import Dispatcher
from woodcock_server.events import Changes
from woodcock_server.jobs.limits import Limits
from woodcock_server.layers.pictures import Pictures
from woodcock_server.metrics import Metrics
from woodcock_server.retention.due import Rule
from woodcock_server.storage import Storage
from woodcock_server.volumes.parser import Parser
from woodcock_server.volumes.slices import Slices


@dataclass(frozen=True)
class Services:
    engine: Engine
    storage: Storage
    changes: Changes
    cluster: Cluster
    checks: Checks
    dispatcher: Dispatcher
    metrics: Metrics
    parser: Parser
    differences: Differences
    slices: Slices
    limits: Limits
    retention: Rule
    pictures: Pictures
    insecure: bool  # nobody is asked for a token

    @property
    def devices(self) -> Sequence[Found]:
        """Those that there are now."""
        return self.cluster.devices


def _provide(request: Request) -> Services:
    services: Services = request.app.state.services
    return services


Provided = Annotated[Services, Depends(_provide)]
