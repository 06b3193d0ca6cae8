"""The studio's server: an action on its way from one window to another, beside the least that HTTP in Python costs.

python benchmarks/studio.py [--quick]

"action" is the time from the request of a window until another hears the line, both plain sockets of one process, the
connection kept open: host, origin and token are asked, the message read and checked, the journal changed, the line
told. "floor" is the same request to `http.server` with a handler that reads the body and says 200, nothing else, on a
connection that is kept open too. "refused" is a request of a foreign origin on a connection of its own.
"""

from __future__ import annotations

import argparse
import json
import socket
import sys
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.studio import Studio  # noqa: E402
from tests.studio.client import head, listening, place, put, raw  # noqa: E402


class Least(BaseHTTPRequestHandler):
    """Reads a body and says 200."""

    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(200)
        self.send_header("Content-Length", "2")
        self.end_headers()
        self.wfile.write(b"{}")

    def log_message(self, format: str, *args: object) -> None:
        """Nothing."""


def median(times: list[float]) -> float:
    """[us]"""
    return 1e6 * sorted(times)[len(times) // 2]


def timed(ask: Callable[[int], None], count: int) -> float:
    """Median time of a request [us], after a few that do not count."""
    times: list[float] = []
    for k in range(count + 20):
        began = time.perf_counter()
        ask(k)
        times.append(time.perf_counter() - began)
    return median(times[20:])


def answered(connection: socket.socket, request: bytes) -> None:
    """Send a request and read its answer, whose body has two bytes."""
    connection.sendall(request)
    answer = b""
    while not answer.endswith(b"\r\n\r\n{}"):
        answer += connection.recv(4096)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    count = 200 if parser.parse_args().quick else 3000
    print(machine())
    bare = ThreadingHTTPServer(("127.0.0.1", 0), Least)
    threading.Thread(target=bare.serve_forever, daemon=True).start()
    with Studio("panda", language="en") as studio:
        threading.Thread(target=studio.serve, daemon=True).start()

        def request(k: int) -> bytes:
            text = json.dumps([put("w-1", "set_joint", joint=1, value=0.001 * (k % 900))]).encode()
            return head(studio, place(studio, "actions"), "POST", len(text)) + text

        with socket.create_connection(("127.0.0.1", bare.server_port)) as connection:
            floor = timed(lambda k: answered(connection, request(k)), count)
        with (
            socket.create_connection(("127.0.0.1", studio.server.server_port)) as connection,
            listening(studio) as heard,
        ):
            next(heard)

            def act(k: int) -> None:
                answered(connection, request(k))
                while next(heard)["kind"] != "put":
                    pass

            action = timed(act, count)
        wrong = head(studio, place(studio, "actions"), "POST", 2, Origin="https://example.org") + b"{}"
        refused = timed(lambda _: _refused(studio, wrong), count)
        studio.server.shutdown()
    print(f"floor: POST to a handler that does nothing   {floor:8.0f} us")
    print(f"action: from one window to another           {action:8.0f} us   {action / floor:.2f} of the floor")
    print(f"refused: foreign origin, new connection      {refused:8.0f} us   {1e6 / refused:.0f} a second")
    return 0


def _refused(studio: Studio, request: bytes) -> None:
    assert raw(studio, request)[0] == 403


if __name__ == "__main__":
    sys.exit(main())
