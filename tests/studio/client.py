"""Requests to a studio, byte by byte: what a browser would send, and what it never would."""

from __future__ import annotations

import json
import socket
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from mafsil.studio import Studio


def head(studio: Studio, path: str, method: str = "POST", length: int | None = 0, **changed: str | None) -> bytes:
    """The head of a request as a window sends it; named headers are changed, None leaves one out."""
    port = studio.server.server_port
    headers: dict[str, str | None] = {
        "Host": f"127.0.0.1:{port}",
        "Origin": f"http://127.0.0.1:{port}",
        "Content-Type": "application/json",
        "Content-Length": None if length is None else str(length),
    }
    headers |= {name.replace("_", "-"): value for name, value in changed.items()}
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in headers.items() if value is not None)]
    return ("\r\n".join(lines) + "\r\n\r\n").encode("latin-1", "replace")


def place(studio: Studio, path: str) -> str:
    """A path under the token."""
    return f"/{studio.server.access.token}/{path}"


def raw(studio: Studio, request: bytes, *, patience: float = 20.0) -> tuple[int, bytes]:
    """Status and all that comes back on a connection of its own; 0 if the server says nothing."""
    with socket.create_connection(("127.0.0.1", studio.server.server_port), timeout=patience) as connection:
        parts: list[bytes] = []
        try:
            connection.sendall(request)
            connection.shutdown(socket.SHUT_WR)
            while part := connection.recv(65536):
                parts.append(part)
        except OSError:
            pass
    answer = b"".join(parts)
    words = answer.split(b" ", 2)
    status = int(words[1]) if answer.startswith(b"HTTP/1.") and words[1].isdigit() else 0
    return status, answer.partition(b"\r\n\r\n")[2]


def post(studio: Studio, path: str, body: object, **changed: str | None) -> tuple[int, Any]:
    """A request of a window, with headers changed."""
    data = body if isinstance(body, bytes) else json.dumps(body).encode()
    status, answer = raw(studio, head(studio, place(studio, path), "POST", len(data), **changed) + data)
    return status, json.loads(answer) if answer else None


def put(name: str, do: str, **given: object) -> Mapping[str, object]:
    """A change of the journal."""
    return {"kind": "put", "id": name, "do": do, "with": given}


@contextmanager
def listening(studio: Studio) -> Generator[Iterator[dict[str, Any]]]:
    """The messages that a window hears."""
    with socket.create_connection(("127.0.0.1", studio.server.server_port), timeout=30) as connection:
        connection.sendall(head(studio, place(studio, "events"), method="GET", length=None))
        yield _messages(connection)


def _messages(connection: socket.socket) -> Iterator[dict[str, Any]]:
    rest = b""
    while part := connection.recv(65536):
        rest += part
        *whole, rest = rest.split(b"\n\n")
        for event in whole:
            text = event.rpartition(b"\r\n\r\n")[2]
            if text.startswith(b"data: "):
                yield json.loads(text.removeprefix(b"data: "))
