"""The composition root: what the service is made of, in the order in which it starts."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import structlog
from anyio import to_thread
from distributed import Security
from fastapi import Depends, FastAPI, HTTPException, Request, Response
from fastapi.responses import PlainTextResponse
from prometheus_client.exposition import choose_encoder
from sqlalchemy import Engine, text
from sqlalchemy.exc import SQLAlchemyError

from woodcock import __version__
from woodcock_server import certificate, preparation, problems
from woodcock_server.access import endpoints as sessions
from woodcock_server.access import guard
from woodcock_server.access.origin import LOOPBACK, SameOrigin
from woodcock_server.access.rate import RateLimit
from woodcock_server.batches import endpoints as batches
from woodcock_server.cluster import Cluster, embedded
from woodcock_server.comparisons import endpoints as comparisons
from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.devices import endpoints as devices
from woodcock_server.devices.checks import Checks
from woodcock_server.devices.service import discover
from woodcock_server.differences import endpoints as differences
from woodcock_server.differences.service import Differences
from woodcock_server.dispatcher import Dispatcher
from woodcock_server.events import Changes
from woodcock_server.farm import remote
from woodcock_server.gallery import endpoints as gallery
from woodcock_server.gallery import examples
from woodcock_server.jobs import endpoints as jobs
from woodcock_server.jobs import listing, repository, watching
from woodcock_server.jobs.limits import Limits
from woodcock_server.layers import endpoints as layers
from woodcock_server.layers.pictures import Pictures
from woodcock_server.metrics import CountRequests, Metrics
from woodcock_server.retention import endpoints as retention
from woodcock_server.retention import sweeper
from woodcock_server.retention.due import Rule
from woodcock_server.services import Provided, Services
from woodcock_server.storage import Storage, open_store
from woodcock_server.volumes import endpoints as volumes
from woodcock_server.volumes.parser import Parser
from woodcock_server.volumes.slices import Slices
from woodcock_server.webhooks.deliveries import Deliveries

log = structlog.get_logger()

#: Largest body of a request that is not an upload, bytes; a scene takes a few thousand.
BODY_LIMIT = 1 << 20


def create_app(settings: Settings) -> FastAPI:
    """The service as an ASGI application; devices, cluster and dispatcher start and stop with its lifespan.

    Raises OSError for a data folder, and sqlalchemy.exc.SQLAlchemyError for a database, that cannot be used; Exposed
    where other machines could reach a service that asks nobody who they are; CertificateError where there is none to
    join a farm with; NoStore.
    """
    (settings.data / "scratch").mkdir(parents=True, exist_ok=True)
    engine = open_database(settings.database)
    if not settings.insecure:
        guard.protect(engine, settings.host)
    storage = open_storage(settings, engine)
    _remove_orphans(engine, storage)
    secure = certificate.of(settings.certificates) if settings.scheduler else None
    changes, metrics = Changes(), Metrics()
    parser = Parser(settings.parse_memory, settings.parse_seconds)
    rule = Rule(settings.keep_days, settings.keep_size)
    limits = Limits(settings.owner_jobs, settings.owner_paths, settings.owner_storage)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with _cluster(settings, secure, storage) as cluster:
            checks = Checks(engine, cluster)
            dispatcher = Dispatcher(engine, storage, changes, cluster, checks, settings, metrics)
            own = [one.device for one in cluster.ready.values() if settings.prepare and not one.host]
            preparing = preparation.running(cluster, own)
            sweeping, watched = sweeper.running(engine, storage, rule), watching.running(engine, changes)
            deliveries = Deliveries(engine, settings.webhook_networks)
            async with checks.running(), dispatcher.running(), deliveries.running(), preparing, sweeping, watched:
                app.state.services = Services(
                    engine,
                    storage,
                    changes,
                    cluster,
                    checks,
                    dispatcher,
                    metrics,
                    parser,
                    Differences(storage),
                    Slices(parser, storage),
                    limits,
                    rule,
                    Pictures(storage),
                    settings.insecure,
                )
                yield
        storage.close()
        engine.dispose()

    app = FastAPI(
        title="Woodcock",
        summary="Renders participating media.",
        version=__version__,
        lifespan=lifespan,
        responses=problems.problem_schema(400, 421, 422, 429, 500, 503),
    )
    problems.install(app)
    uploads = volumes.router.prefix
    app.add_middleware(problems.BodyLimit, limit=BODY_LIMIT, special={uploads: settings.upload_limit})
    guarded: dict[str, Any] = {
        "dependencies": [Depends(guard.authorized)],
        "responses": problems.problem_schema(401, 403),
    }
    for endpoints in (jobs, layers, differences, batches, comparisons, volumes, devices, retention, examples):
        app.include_router(endpoints.router, **guarded)
    app.add_api_route("/metrics", scrape, methods=["GET"], response_class=PlainTextResponse, tags=["health"], **guarded)
    # Public: what tells nothing of anybody's work.
    app.include_router(sessions.router)
    app.include_router(gallery.router)
    app.mount("/web", gallery.static)
    app.mount("/examples", examples.static)
    app.add_api_route("/healthz", healthz, methods=["GET"], tags=["health"])
    app.add_api_route("/readyz", readyz, methods=["GET"], responses=problems.problem_schema(503), tags=["health"])
    app.add_middleware(RateLimit, rate=settings.request_rate)
    app.add_middleware(CountRequests, metrics=metrics)
    app.add_middleware(SameOrigin, names=_names(settings))
    return app


@asynccontextmanager
async def _cluster(settings: Settings, secure: Security | None, storage: Storage) -> AsyncIterator[Cluster]:
    """Of this machine's devices, or those of a farm."""
    if settings.scheduler is not None and secure is not None:
        async with remote.joined(settings.scheduler, secure, settings.files_port, storage) as farm:
            yield farm
        return
    found = await to_thread.run_sync(discover)
    able = [device.id for device in found if device.ready]
    async with embedded(able, storage.scratch, settings.worker_memory) as client:
        yield Cluster(client, found, storage.volume_files)


def open_storage(settings: Settings, engine: Engine) -> Storage:
    """Where the service keeps files. Raises OSError, NoStore."""
    if settings.store is None:
        return Storage(settings.data)
    store = open_store(settings.store)
    from woodcock_server.bucket import BucketStorage  # only now: it needs what not every installation has

    return BucketStorage(settings.data, engine, store, settings.copies_size)


def _names(settings: Settings) -> set[str]:
    """By which the service may be asked; none for any."""
    given = set(filter(None, settings.names.lower().split(",")))
    return given | {*LOOPBACK, settings.host} if given or guard.is_loopback(settings.host) else set()


def _remove_orphans(engine: Engine, storage: Storage) -> None:
    """Folders of jobs that are no more, which a server left that was killed."""
    folders = storage.folders()  # first: whatever has one by now has a row
    with engine.connect() as connection:
        known = repository.folders(connection)
    for orphan in folders - known:
        storage.remove_job(orphan)


def healthz() -> dict[str, str]:
    """That the process answers: no reason to start it again, whatever else is amiss."""
    return {"status": "ok", "version": __version__}


def readyz(services: Provided) -> dict[str, Any]:
    """Whether the service can do its work: the database, the data folder, a device."""
    try:
        services.storage.try_writing()
    except OSError as error:
        raise HTTPException(503, f"The data folder cannot be written: {error.strerror}.") from None
    try:
        with services.engine.connect() as connection:
            connection.execute(text("SELECT 1"))
            fault = services.dispatcher.fault(connection)
            distrusted = services.checks.distrusted(connection)
    except SQLAlchemyError as error:
        log.error("the database does not answer", error=str(error))
        raise HTTPException(503, "The database does not answer; the server's log says why.") from None
    if fault:
        raise HTTPException(503, fault)
    trusted = sum(device.ready for device in services.devices) - len(distrusted)
    return {"status": "ok", "version": __version__, "devices": trusted}


def scrape(request: Request, services: Provided) -> Response:
    """What this server has done since it started, for Prometheus."""
    metrics = services.metrics
    try:
        with services.engine.connect() as connection:
            for state, count in listing.states(connection).items():
                metrics.jobs.labels(state).set(count)
    except SQLAlchemyError as error:  # What this server did is its own to tell.
        log.error("the database does not answer", error=str(error))
        metrics.jobs.clear()
    encode, kind = choose_encoder(request.headers.get("accept", ""))
    return Response(encode(metrics.registry), headers={"Content-Type": kind})
