"""`woodcock serve`"""

from __future__ import annotations

import asyncio
import errno
import gc
import signal
import socket
from pathlib import Path
from types import FrameType
from typing import Annotated, Any

import typer
import uvicorn

from woodcock_server import logs
from woodcock_server.access.guard import Exposed
from woodcock_server.app import create_app
from woodcock_server.certificate import CertificateError
from woodcock_server.check_config import Fault
from woodcock_server.check_config import check as check_config_of
from woodcock_server.config import Settings
from woodcock_server.usable import settings_of, usable

#: Who takes nothing of what is sent to it for so long is gone, seconds.
SILENT_SECONDS = 60
#: How long requests may take to end when the server stops, seconds.
GRACE_SECONDS = 5


class Server(uvicorn.Server):
    """Uvicorn, which at its end lets go of those who follow a job; they would stay for as long as it renders."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        # What is there by now stays: to look through all of it for garbage again and again would stop every answer.
        gc.collect()
        gc.freeze()
        if self.started:
            host, port = self.servers[0].sockets[0].getsockname()[:2]
            shown = f"[{host}]" if ":" in host else host
            typer.echo(f"Woodcock is ready: http://{shown}:{port}/")

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        super().handle_exit(sig, frame)
        # Devices are being tried, perhaps for minutes, and nothing is under way that must end well.
        if not self.started:
            signal.signal(sig, signal.SIG_DFL)
            signal.raise_signal(sig)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        app: Any = self.config.app
        app.state.services.changes.close()
        await super().shutdown(sockets)


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.", show_default="127.0.0.1")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 takes any.", show_default="8000")] = None,
    data: Annotated[
        Path | None, typer.Option(help="Folder of everything the service keeps.", show_default="the user's data folder")
    ] = None,
    insecure: Annotated[
        bool, typer.Option("--insecure", help="Ask nobody for a token, also where other machines reach the service.")
    ] = False,
    scheduler: Annotated[
        str | None,
        typer.Option(help="Render on the workers of the scheduler at tls://HOST:PORT.", show_default="on this machine"),
    ] = None,
    certificates: Annotated[
        Path | None,
        typer.Option(help="Folder of the farm's ca.crt, tls.crt and tls.key.", show_default="WOODCOCK_CERTIFICATES"),
    ] = None,
    check_config: Annotated[
        bool, typer.Option("--check-config", help="Say whether the service would start, and with what; change nothing.")
    ] = False,
) -> None:
    """Run the service and its gallery until Ctrl-C.

    Everything else is set by environment variables: WOODCOCK_DATABASE_URL, WOODCOCK_UPLOAD_LIMIT and so on.
    """
    settings = settings_of(
        host=host, port=port, data=data, insecure=insecure or None, scheduler=scheduler, certificates=certificates
    )
    try:
        listening = _listen(settings.host, settings.port)
    except OSError as error:
        typer.echo(_explain(error, settings), err=True)
        raise typer.Exit(2) from None
    if check_config:
        listening.close()
        said = list(check_config_of(settings))
        for sentence in said:
            typer.echo(sentence, err=isinstance(sentence, Fault))
        raise typer.Exit(2 if any(isinstance(sentence, Fault) for sentence in said) else 0)
    with listening:
        try:
            with usable(settings):
                app = create_app(settings)
        except (Exposed, CertificateError) as error:
            typer.echo(str(error), err=True)
            raise typer.Exit(2) from None
        logs.configure(settings.log_format)
        server = Server(uvicorn.Config(app, log_config=None, access_log=False, timeout_graceful_shutdown=GRACE_SECONDS))
        try:
            asyncio.run(server.serve([listening]))
        except KeyboardInterrupt:  # Uvicorn has stopped cleanly, and passes the signal on.
            raise typer.Exit(130) from None
        if not server.started:
            raise typer.Exit(1)


def _listen(host: str, port: int) -> socket.socket:
    """Bound before anything else starts: a port that is taken should cost no second. Raises OSError."""
    family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    listening = socket.socket(family, kind, protocol)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # Connections have it from here: a reader that stands still is dropped by the kernel, which buffers some MB for
        # it; nothing else is kept for any.
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, SILENT_SECONDS * 1000)
        listening.bind(address)
        listening.set_inheritable(False)
    except OSError:
        listening.close()
        raise
    return listening


def _explain(error: OSError, settings: Settings) -> str:
    match error.errno:
        case errno.EADDRINUSE:
            return f"Port {settings.port} of {settings.host} is taken; choose another with --port."
        case errno.EACCES:
            return f"Port {settings.port} needs privileges; choose one above 1023 with --port."
        case _:
            return f"Cannot listen on {settings.host}: {error.strerror}."
