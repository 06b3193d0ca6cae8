"""The server: HTTP on the loopback interface, messages to windows as an event stream.

Every request passes four gates before anything of it is read: connections are counted, requests have a time, `Access`
knows host, origin and token, and bodies have a length and a limit.

Who may speak with the server: pages that it has served itself, under a token that nobody can guess.

A page of another site can make the browser send requests here, but it cannot read the token; a name that was bent to
this machine (DNS rebinding) arrives under a foreign Host.
"""

from __future__ import annotations

import hmac
import json
import queue
import secrets
import socket
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from email.message import Message
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, ClassVar, cast

from mafsil.errors import InputError, MafsilError
from mafsil.messages import say
from mafsil.studio.broadcast import Broadcast, Full, encode, in_all_languages

TOKEN_BYTES = 24
_LOCAL = ("127.0.0.1", "localhost")
_ONCE = ("Host", "Origin", "Sec-Fetch-Site", "Content-Length", "Content-Type", "Transfer-Encoding")
"""Headers that decide something: given twice, two readers of a request may each believe another one."""
LOOPBACK = "127.0.0.1"
MOST_CONNECTIONS = 96
PATIENCE = 15.0
"""How long a request may take to arrive, and how long a connection without one stays open [s]."""
HEARTBEAT = 5.0
"""Between two signs of life to a window [s]: writing finds out that it is gone."""
LARGEST_BODY = 4_100_000
"""Of a request [bytes]: a job of a million letters, each of four bytes, and what is around it."""
JSON, HTML = "application/json", "text/html; charset=utf-8"
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "X-Frame-Options": "DENY",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}


@dataclass(frozen=True)
class Content:
    """What is sent back.

    Attributes:
        body: the bytes.
        kind: their media type.
    """

    body: bytes
    kind: str = JSON


Look = Callable[[str], Content | None]
"""From a path to what stands there; None if nothing does."""
Deed = Callable[[bytes], Mapping[str, Any]]
"""From the body of a request to the answer."""


class Server(ThreadingHTTPServer):
    """Serves one studio.

    Args:
        port: 0 for any that is free.
        look: what can be read.
        deeds: by path, what can be asked for.
        broadcast: where windows listen.
    """

    daemon_threads = True
    block_on_close = False
    request_queue_size = 64
    allow_reuse_address = True

    def __init__(self, port: int, look: Look, deeds: Mapping[str, Deed], broadcast: Broadcast) -> None:
        super().__init__((LOOPBACK, port), _Handler)
        self.access = Access(self.server_port)
        self.look, self.deeds, self.broadcast = look, deeds, broadcast
        self.refused = 0
        self._guard = threading.Lock()
        self._open: dict[socket.socket, float] = {}
        self._known: set[socket.socket] = set()

    @property
    def address(self) -> str:
        """Of the page."""
        return f"http://{LOOPBACK}:{self.server_port}/{self.access.token}/"

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection in a thread of its own, if there are not too many.

        Where there are, the oldest one that has not yet shown the token gives way: anyone can open such connections.
        """
        with self._guard:
            silent = [connection for connection in self._open if connection not in self._known]
            full = len(self._open) >= MOST_CONNECTIONS
            admitted = not full or bool(silent)
            if full and silent:
                self._open.pop(silent[0])
                _end(silent[0])
            if admitted:
                self._open[request] = time.monotonic()
        if admitted:
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        with self._guard:
            self._open.pop(request, None)
            self._known.discard(request)
        super().shutdown_request(request)

    def knows(self, connection: socket.socket) -> None:
        """A request with the token came: the connection no longer gives way to others."""
        with self._guard:
            self._known.add(connection)

    def awaits(self, connection: socket.socket, *, request: bool) -> None:
        """From now on a request is waited for, for a limited time; or something is sent, as long as it takes."""
        with self._guard:
            if connection in self._open:
                self._open[connection] = time.monotonic() if request else float("inf")

    def service_actions(self) -> None:
        """Between requests: close connections whose request does not come."""
        late = time.monotonic() - PATIENCE
        with self._guard:
            slow = [connection for connection, since in self._open.items() if since < late]
        for connection in slow:
            _end(connection)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A connection broke, which is its own affair."""

    def close(self) -> None:
        """Send every window home and stop listening."""
        self.broadcast.close()
        self.server_close()
        with self._guard:
            left = list(self._open)
        for connection in left:
            _end(connection)


def _end(connection: socket.socket) -> None:
    with suppress(OSError):
        connection.shutdown(socket.SHUT_RDWR)


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server_version = "mafsil"
    sys_version = ""
    timeout = PATIENCE
    disable_nagle_algorithm: ClassVar[bool] = True

    @property
    def studio(self) -> Server:
        return cast("Server", self.server)

    def handle_one_request(self) -> None:
        self.studio.awaits(self.connection, request=True)
        super().handle_one_request()

    def do_GET(self) -> None:
        path = self._admitted(changes=False)
        if path is None:
            return
        self.studio.awaits(self.connection, request=False)
        if path == "events":
            self._stream()
            return
        found = self.studio.look(path)
        if found is None:
            self._refuse(404)
        else:
            self._send(200, found)

    def do_POST(self) -> None:
        path = self._admitted(changes=True)
        if path is None:
            return
        deed = self.studio.deeds.get(path)
        if deed is None:
            self._refuse(404)
            return
        body = self._body()
        if body is None:
            return
        self.studio.awaits(self.connection, request=False)
        try:
            self._send(200, Content(encode(deed(body))))
        except MafsilError as error:
            sentences = in_all_languages(error.message)
            status = 400 if isinstance(error, InputError) else 422
            self._send(status, Content(encode({"error": {"code": error.key, **sentences}})))
        except (OSError, MemoryError):
            raise
        except Exception as error:
            details = {"kind": type(error).__name__, "reason": str(error)}
            sentences = in_all_languages(lambda code: say("cli.internal", language=code, **details))
            self._send(500, Content(encode({"error": {"code": "cli.internal", **sentences}})))

    def _admitted(self, *, changes: bool) -> str | None:
        """What a request asks for, if it may ask."""
        if not self.studio.access.from_here(self.headers, changes=changes):
            self._refuse(403)
            return None
        path = self.studio.access.path(self.path)
        if path is None:
            self._refuse(403)
        else:
            self.studio.knows(self.connection)
        return path

    def _body(self) -> bytes | None:
        """The body of a request; None if it was refused unread."""
        length = self.headers.get("Content-Length", "")
        if "Transfer-Encoding" in self.headers or not (length.isascii() and length.isdigit()):
            self._refuse(411)
        elif len(length) > 9 or int(length) > LARGEST_BODY:
            self._refuse(413)
        elif self.headers.get_content_type() != JSON:
            self._refuse(415)
        else:
            body = self.rfile.read(int(length))
            if len(body) == int(length):
                return body
            self.close_connection = True
        return None

    def _stream(self) -> None:
        """Messages for a window, one after the other, until it is gone or does not keep up."""
        try:
            window = self.studio.broadcast.join()
        except Full:
            self._refuse(503)
            return
        try:
            self._head(200, "text/event-stream", None)
            while True:
                try:
                    message = window.get(timeout=HEARTBEAT)
                except queue.Empty:
                    self.wfile.write(b":\n\n")
                    continue
                if message is None:
                    return
                self.wfile.write(b"data: " + message + b"\n\n")
        finally:
            self.studio.broadcast.leave(window)

    def _send(self, status: int, content: Content) -> None:
        self._head(status, content.kind, len(content.body))
        self.wfile.write(content.body)

    def _refuse(self, status: int) -> None:
        """No, in a word; what is left of the request is not read."""
        self.studio.refused += 1
        self.close_connection = True
        self._send(status, Content(json.dumps({"error": {"code": str(status)}}).encode()))

    def _head(self, status: int, kind: str, length: int | None) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        if length is None:
            self.close_connection = True
        else:
            self.send_header("Content-Length", str(length))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing: paths hold the token."""


@dataclass(frozen=True)
class Access:
    """What a request has to bring.

    Attributes:
        port: at which the server listens.
        token: first part of every path.
    """

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(TOKEN_BYTES), repr=False)

    def path(self, target: str) -> str | None:
        """What is asked for behind the token; None if the token is missing or wrong.

        Args:
            target: of the request, such as `/<token>/events`.
        """
        given, _, rest = target.partition("?")[0].removeprefix("/").partition("/")
        right = hmac.compare_digest(given.encode("utf-8", "replace"), self.token.encode())
        return rest if right else None

    def from_here(self, headers: Message, *, changes: bool) -> bool:
        """Whether a request is for this server and comes from one of its own pages.

        Args:
            headers: of the request.
            changes: it is more than a look: then its origin must be said.
        """
        if any(len(headers.get_all(name) or ()) > 1 for name in _ONCE):
            return False
        hosts = [f"{name}:{self.port}" for name in _LOCAL]
        host = headers.get("Host", "").lower()
        if host not in hosts:
            return False
        origins = headers.get_all("Origin") or []
        if origins != [f"http://{host}"] and (changes or origins):
            return False
        return headers.get("Sec-Fetch-Site", "none") in ("same-origin", "none")
