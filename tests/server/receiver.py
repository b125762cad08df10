"""Who is told of the ends of jobs: a real HTTP server on the loopback that answers as a test wants."""

from __future__ import annotations

import base64
import hashlib
import hmac
import ssl
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from email.message import Message
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

#: Of 24 bytes, the one of the specification's libraries.
SECRET = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"

Answer = Callable[[BaseHTTPRequestHandler], None]


@dataclass(frozen=True)
class Heard:
    """A request. at: the address at which it came in."""

    at: str
    path: str
    headers: Message
    body: bytes

    def proven(self, secret: str = SECRET) -> bool:
        """As the text of standardwebhooks.com has it, without a line of the service's."""
        key = base64.b64decode(secret.split("_")[1])
        signed = f"{self.headers['webhook-id']}.{self.headers['webhook-timestamp']}.{self.body.decode()}"
        right = base64.b64encode(hmac.new(key, signed.encode(), hashlib.sha256).digest()).decode()
        recent = abs(time.time() - int(self.headers["webhook-timestamp"])) < 60
        return recent and self.headers["webhook-signature"] == f"v1,{right}"


def answer(status: int, **headers: str) -> Answer:
    def send(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(status)
        for name, value in headers.items():
            handler.send_header(name, value)
        handler.send_header("Content-Length", "2")
        handler.end_headers()
        handler.wfile.write(b"ok")

    return send


class Receiver:
    """answers: what requests get in turn, and 200 after these. connections: how many were accepted."""

    def __init__(self, *answers: Answer, port: int = 0, host: str = "127.0.0.1") -> None:
        self.heard: list[Heard] = []
        self.connections = 0
        self.closing = threading.Event()
        self._answers = list(answers)
        receiver = self

        class Server(ThreadingHTTPServer):
            request_queue_size = 64

            def process_request(self, request: Any, client_address: Any) -> None:
                receiver.connections += 1
                super().process_request(request, client_address)

            def handle_error(self, request: Any, client_address: Any) -> None:
                pass  # who told hangs up when he likes

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"]))
                receiver.heard.append(Heard(self.connection.getsockname()[0], self.path, self.headers, body))
                (receiver._answers.pop(0) if receiver._answers else answer(200))(self)

            def log_message(self, format: str, *args: object) -> None:
                pass

        self._server = Server((host, port), Handler)
        self.port: int = self._server.server_address[1]
        self.url = f"http://127.0.0.1:{self.port}/hook?of=test"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.02,))

    def speak_tls(self, context: ssl.SSLContext) -> None:
        self._server.socket = context.wrap_socket(self._server.socket, server_side=True)

    def __enter__(self) -> Receiver:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.closing.set()
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def wait(self, count: int, seconds: float = 15) -> list[Heard]:
        """What was heard, as soon as there are so many."""
        end = time.monotonic() + seconds
        while len(self.heard) < count:
            assert time.monotonic() < end, f"{len(self.heard)} of {count} came"
            time.sleep(0.02)
        return self.heard
