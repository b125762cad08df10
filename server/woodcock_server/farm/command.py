"""`woodcock certificates`, `woodcock scheduler` and `woodcock worker`"""

from __future__ import annotations

import asyncio
import logging
import signal
import socket
from collections.abc import Coroutine
from contextlib import suppress
from datetime import timedelta
from pathlib import Path
from typing import Annotated, Any, NoReturn

import dask
import structlog
import typer
from distributed import Scheduler, Security

from woodcock_server import certificate, logs
from woodcock_server.cluster import HTTP, SETTINGS
from woodcock_server.config import Settings
from woodcock_server.devices.service import discover
from woodcock_server.farm import host
from woodcock_server.farm.signs import ALIVE, given
from woodcock_server.steady import keep_time
from woodcock_server.usable import settings_of

log = structlog.get_logger()

Certificates = Annotated[
    Path | None,
    typer.Option(help="Folder of ca.crt, tls.crt and tls.key.", show_default="WOODCOCK_CERTIFICATES"),
]


def certificates(
    folder: Annotated[Path, typer.Argument(help="Where ca.crt, tls.crt and tls.key are written.")],
    days: Annotated[int, typer.Option(min=1, help="How long the certificate is valid.")] = 3650,
) -> None:
    """Make the certificate by which service, scheduler and workers of a farm know each other.

    Every machine of the farm needs a copy of the folder. Who has it can run code on all of them.
    """
    try:
        certificate.write(folder, timedelta(days=days))
    except FileExistsError as error:
        _fail(f"{error.filename} is there already; remove it, and its neighbours, to make a new certificate.")
    except OSError as error:
        _fail(f"{error.filename} cannot be written: {error.strerror}.")
    typer.echo(f"{folder} holds the farm's certificate; copy it to each of its machines, and to nobody else.")


def scheduler(
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "0.0.0.0",
    port: Annotated[int, typer.Option(help="Port to listen on; 0 takes any.")] = 8786,
    certificates: Certificates = None,
) -> None:
    """Run the scheduler of a farm, which service and workers connect to, until Ctrl-C. It keeps nothing."""
    settings = settings_of(certificates=certificates)
    logs.configure(settings.log_format)
    _until_stopped(_schedule(host, port, _secure(settings)))


async def _schedule(host: str, port: int, secure: Security) -> None:
    keep_time()
    for name in ("distributed", "distributed.scheduler", "distributed.core"):
        logging.getLogger(name).setLevel(logging.WARNING)
    with dask.config.set(SETTINGS):
        try:
            started = Scheduler(host=host, port=port, protocol="tls://", security=secure, **HTTP)
            await started
        except OSError as error:
            _fail(f"Cannot listen on {host}:{port}: {error}.")
        async with started, given(lambda: [ALIVE]):
            typer.echo(f"The scheduler is ready: {started.address}")
            await started.finished()  # type: ignore[no-untyped-call]


def worker(
    scheduler: Annotated[
        str | None, typer.Option(help="The scheduler's address, tls://HOST:PORT.", show_default="WOODCOCK_SCHEDULER")
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Of this machine; no other one's.", show_default="the host's name")
    ] = None,
    certificates: Certificates = None,
) -> None:
    """Offer this machine's OpenCL devices to a farm until Ctrl-C, a process for each, whether its scheduler answers now
    or later.
    """
    given = {"scheduler": scheduler, "certificates": certificates, "worker_name": name}
    settings = settings_of(**given)
    if settings.scheduler is None:
        _fail("WOODCOCK_SCHEDULER (or --scheduler): whose workers these are; tls://HOST:PORT.")
    secure = _secure(settings)
    logs.configure(settings.log_format)
    found = discover(settings.worker_name or socket.gethostname()[:48])
    if not any(one.ready for one in found):
        _fail(f"No OpenCL device of this machine can be used{''.join(f'; {one.probe.fault}' for one in found)}.", 1)
    _until_stopped(host.work(settings.scheduler, secure, found, settings.worker_memory, prepare=settings.prepare))


def _secure(settings: Settings) -> Security:
    """Ends the command where there is no certificate."""
    try:
        return certificate.of(settings.certificates)
    except certificate.CertificateError as error:
        _fail(str(error))


def _fail(sentence: str, status: int = 2) -> NoReturn:
    typer.echo(sentence, err=True)
    raise typer.Exit(status)


def _until_stopped(work: Coroutine[Any, Any, None]) -> None:
    """Until SIGINT or SIGTERM."""

    async def run() -> None:
        task = asyncio.current_task()
        assert task is not None
        for number in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(number, task.cancel)
        with suppress(asyncio.CancelledError):
            await work

    asyncio.run(run())
