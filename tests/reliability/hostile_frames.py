"""F4: hostile frames and requests against a studio: refused, nothing lost, windows served all the while.

`python -m tests.reliability.hostile_frames --frames 100000 --resume DIR`

Foreign origins, hosts and tokens, requests that are no HTTP, bodies without or with a false length, texts that are no
JSON, messages with a piece cut out, doubled or exchanged, numbers out of range, paths that climb. Between them a window
does its work and another listens: every line of theirs is in the journal and was heard once, in order.
"""

from __future__ import annotations

import json
import random
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from mafsil.studio import Studio
from tests.reliability import figures
from tests.studio.client import head, listening, place, post, put, raw

GOOD_EVERY = 100
SLOW = 2.0
"""A window waits no longer for an answer [s], with hostile frames coming in."""
REFUSED = {0, 400, 403, 404, 411, 413, 414, 415, 422, 431, 501, 505}


def work(seed: int, frames: int) -> dict[str, int]:
    """Counts of frames by what became of them; a fault counts as bad."""
    dice = random.Random(seed)
    count: dict[str, int] = dict.fromkeys(
        ("frames", "refused", "valid_by_chance", "good", "bad_accepted", "bad_status", "bad_slow"), 0
    )
    with Studio("planar2r", language="en") as studio:
        threading.Thread(target=studio.serve, daemon=True).start()
        with listening(studio) as heard:
            next(heard)
            for frame in range(frames):
                _hostile(studio, dice, count)
                if frame % GOOD_EVERY == 0:
                    _good(studio, count, count["good"])
            lost = _lost(studio, heard, count["good"])
        studio.server.shutdown()
    return count | lost


def _hostile(studio: Studio, dice: random.Random, count: dict[str, int]) -> None:
    """One frame; only a message of which a piece was changed may be good by chance."""
    kind = dice.choice(KINDS)
    status, _ = raw(studio, kind(studio, dice))
    count["frames"] += 1
    if status in REFUSED:
        count["refused"] += 1
    elif status != 200:
        count["bad_status"] += 1
    elif kind is mutated:
        count["valid_by_chance"] += 1
    else:
        count["bad_accepted"] += 1


def _good(studio: Studio, count: dict[str, int], k: int) -> None:
    began = time.perf_counter()
    status, _ = post(studio, "actions", [put(f"good-{k}", "set_joint", joint=k % 2, value=0.001 * k)])
    count["bad_slow"] += time.perf_counter() - began > SLOW
    count["bad_status"] += status != 200
    count["good"] += 1


def _lost(studio: Studio, heard: Iterator[dict[str, Any]], good: int) -> dict[str, int]:
    """Lines of the window that are not in the journal, or were not heard just once and in order."""
    wanted = [(f"good-{k}", {"joint": k % 2, "value": 0.001 * k}) for k in range(good)]
    kept = [(line["id"], line["with"]) for line in studio.journal.lines() if line["id"].startswith("good-")]
    lines: list[object] = []
    for told in heard:
        if told["kind"] == "put" and told["id"].startswith("good-"):
            lines.append((told["id"], told["with"]))
            if told["id"] == wanted[-1][0]:
                break
    return {"bad_lost": int(kept != wanted), "bad_heard": int(lines != wanted)}


def body(studio: Studio, text: bytes, path: str = "actions", **changed: str | None) -> bytes:
    """A request with a body."""
    return head(studio, place(studio, path), "POST", len(text), **changed) + text


def message(dice: random.Random) -> bytes:
    """A good message."""
    joint, value = dice.randrange(2), dice.uniform(-3, 3)
    return json.dumps([put(f"evil-{dice.randrange(50)}", "set_joint", joint=joint, value=value)]).encode()


def foreign_origin(studio: Studio, dice: random.Random) -> bytes:
    """A page of another site, or of another port, or one that does not say where it comes from."""
    port = studio.server.server_port
    origins = ("https://example.org", "null", f"http://127.0.0.1:{port + 1}", f"https://127.0.0.1:{port}", None, "")
    return body(studio, message(dice), Origin=dice.choice(origins))


def foreign_host(studio: Studio, dice: random.Random) -> bytes:
    """A name that was bent to this machine."""
    port = studio.server.server_port
    host = dice.choice((f"example.org:{port}", "127.0.0.1", f"127.0.0.1:{port}.example.org", "", None, f"0:{port}"))
    return body(studio, message(dice), Host=host, Origin=f"http://{host}")


def another_site(studio: Studio, dice: random.Random) -> bytes:
    """What a browser marks as coming from elsewhere."""
    return body(studio, message(dice), Sec_Fetch_Site=dice.choice(("cross-site", "same-site", "no such thing")))


def wrong_token(studio: Studio, dice: random.Random) -> bytes:
    """Guesses, cuts and climbs."""
    token, text = studio.server.access.token, message(dice)
    guess = dice.choice(
        (token[:-1], token + "x", token.swapcase(), "", "..", "%2e%2e", "é" * 8, f"x/{token}", f"{token}x/{token}")
    )
    return head(studio, f"/{guess}/actions", length=len(text)) + text


def wrong_path(studio: Studio, dice: random.Random) -> bytes:
    """Paths that are none, and files that are not those of a report."""
    paths = (
        "etc/passwd",
        "reports/1/../../../etc/passwd",
        "reports/-1/report.html",
        "reports/9/report.html",
        "Actions",
    )
    path = dice.choice((*paths, "reports/1/%2e%2e/x", "x" * dice.randrange(70_000), "reports/" + "9" * 30 + "/x"))
    return head(studio, place(studio, path), method=dice.choice(("GET", "POST")), length=0)


def false_length(studio: Studio, dice: random.Random) -> bytes:
    """Lengths that are none, larger than allowed, or larger than what comes; chunks."""
    text = message(dice)
    length = dice.choice(("-1", "1e3", "99999999999999999999", "4100001", str(len(text) + 5), "", "٣", "0x10"))
    chunked = {"Transfer_Encoding": "chunked"} if dice.random() < 0.3 else {}
    return body(studio, text, Content_Length=length, **chunked)


def other_type(studio: Studio, dice: random.Random) -> bytes:
    """Bodies that a form of another page could send without asking."""
    kinds = ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data", None)
    return body(studio, message(dice), Content_Type=dice.choice(kinds))


def no_json(studio: Studio, dice: random.Random) -> bytes:
    """Bytes, halves of messages, nests."""
    text = message(dice)
    texts = (dice.randbytes(dice.randrange(2000)), text[: dice.randrange(len(text))], b"[" * 100_000, b'{"a":' * 20_000)
    return body(studio, dice.choice((*texts, b"", b"null", b"[]", b"{}", b"[NaN]", b"\xff\xfe[\x00]\x00")))


def out_of_range(studio: Studio, dice: random.Random) -> bytes:
    """Actions that no window could do."""
    wrong: tuple[str, Mapping[str, Any]] = dice.choice(
        (
            ("set_joint", {"joint": 2, "value": 0}), ("set_joint", {"joint": -1, "value": 0}),
            ("set_joint", {"joint": 0.5, "value": 0}), ("set_joint", {"joint": 0, "value": None}),
            ("set_joint", {"joint": 0, "value": 10**400}), ("set_joint", {"joint": 0, "value": 0, "more": 1}),
            ("set_joint", {"joint": True, "value": 0}), ("set_joints", {"values": [0]}),
            ("set_joints", {"values": [0] * 300}), ("set_joints", {"values": "12"}), ("push", {"wrench": [0] * 5}),
            ("simulate", {"ticks": 10**8}), ("simulate", {"ticks": -1}), ("loop", {"closed": 1}), ("__init__", {}),
            ("search", {"position": [0, 0, 0], "quaternion": [0, 0, 0, 0]}), ("do", {"actions": []}),
            ("search", {"position": [0, 0], "quaternion": [1, 0, 0, 0]}), ("choose", {"branch": 99}),
        )
    )  # fmt: skip
    path = dice.choice(("actions", "actions", "job", "job/run", "compare", "configurations", "recording", "job/save"))
    what = [put(f"evil-{dice.randrange(50)}", wrong[0], **wrong[1])]
    return body(studio, json.dumps(what if path == "actions" else [what]).encode(), path)


def mutated(studio: Studio, dice: random.Random) -> bytes:
    """A good message with a piece cut out, doubled or exchanged."""
    text = bytearray(message(dice))
    for _ in range(dice.randrange(1, 6)):
        a, b = sorted(dice.randrange(len(text) + 1) for _ in range(2))
        piece = dice.choice((b"", bytes(text[a:b]) * 2, dice.randbytes(3), b"9" * 20, b'"', b"[", b"-"))
        text[a : min(b, a + 4)] = piece
        if not text:
            break
    return body(studio, bytes(text))


def no_http(studio: Studio, dice: random.Random) -> bytes:
    """Bytes that are no request, lines and heads that are too long."""
    start = head(studio, place(studio, ""), method="GET", length=None)
    many = b"".join(b"X-%d: y\r\n" % k for k in range(200))
    long = b"GET /" + b"a" * 70_000 + b" HTTP/1.1\r\n\r\n"
    texts = (dice.randbytes(500), long, start[:-2] + many + b"\r\n", start[: dice.randrange(20)], b"\r\n" * 50)
    return dice.choice(
        (*texts, b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"BREW / HTTP/1.1\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n")
    )


KINDS: tuple[Callable[[Studio, random.Random], bytes], ...] = (
    foreign_origin, foreign_host, another_site, wrong_token, wrong_path, false_length, other_type, no_json,
    out_of_range, mutated, no_http,
)  # fmt: skip

if __name__ == "__main__":
    sys.exit(not figures.run("F4", figures.arguments(__doc__ or "", "frames", 100_000, 10_000), work)["passed"])
