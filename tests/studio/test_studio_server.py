"""The studio's server without a browser: who may speak, what is refused, what windows hear, how it ends."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mafsil.studio.broadcast as broadcast
import mafsil.studio.server as server
import mafsil.studio.studio as journal
from mafsil.errors import FileError, InputError
from mafsil.page import Session
from mafsil.studio import Studio
from mafsil.studio.broadcast import in_all_languages
from mafsil.studio.job_runner import complaint
from tests.studio.client import head, listening, place, post, put, raw

JOB = 'robot = "planar2r"\n\n[[move]]\njoints = [0.4, 0.3]\n\n[[move]]\njoints = [0.0, 0.1]\n'


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    with Studio("planar2r", language="en", job=(JOB, None), results=tmp_path / "results") as served:
        threading.Thread(target=served.serve, daemon=True).start()
        yield served
        served.server.shutdown()


def until(heard: Iterator[dict[str, Any]], kind: str, **values: object) -> dict[str, Any]:
    """The next message of a kind with these values."""
    return next(one for one in heard if one["kind"] == kind and all(one.get(k) == v for k, v in values.items()))


ORIGINS = ("https://example.org", "null", "http://127.0.0.1:1", "http://localhost", None)
HOSTS = ("example.org", "127.0.0.1", "localhost:1", "127.0.0.1.example.org", "", None)
CHANGE = [put("a-1", "set_joint", joint=0, value=0.5)]


@pytest.mark.parametrize("origin", ORIGINS)
def test_foreign_origins_are_refused(studio: Studio, origin: str | None) -> None:
    assert post(studio, "actions", CHANGE, Origin=origin)[0] == 403
    assert not studio.journal.lines()


@pytest.mark.parametrize("host", HOSTS)
@pytest.mark.parametrize("method", ["GET", "POST"])
def test_foreign_hosts_are_refused(studio: Studio, host: str | None, method: str) -> None:
    """Also where the page itself is asked for: a bent name learns nothing."""
    request = head(studio, place(studio, ""), method=method, Host=host, Origin=None)
    status, answer = raw(studio, request)
    assert status == 403
    assert studio.server.access.token.encode() not in answer


def test_two_hosts_or_origins_are_refused(studio: Studio) -> None:
    port = studio.server.server_port
    twice = head(studio, place(studio, ""), method="GET")[:-2]
    assert raw(studio, twice + b"Host: example.org\r\n\r\n")[0] == 403
    assert raw(studio, twice + b"Origin: https://example.org\r\n\r\n")[0] == 403
    assert raw(studio, head(studio, place(studio, ""), method="GET", Host=f"localhost:{port}", Origin=None))[0] == 200


@pytest.mark.parametrize("token", ["", "x", "{token}x", "..", "%2e", "{short}", "é"])
@pytest.mark.parametrize("path", ["", "events", "reports/1/report.html"])
def test_wrong_tokens_are_refused(studio: Studio, token: str, path: str) -> None:
    right = studio.server.access.token
    wrong = token.format(token=right, short=right[:-1])
    status, answer = raw(studio, head(studio, f"/{wrong}/{path}", method="GET", Origin=None))
    assert (status, json.loads(answer)) == (403, {"error": {"code": "403"}})


def test_no_port_but_loopback_and_no_telling_headers(studio: Studio) -> None:
    assert studio.server.server_address[0] == "127.0.0.1"
    with socket.create_connection(("127.0.0.1", studio.server.server_port)) as connection:
        connection.sendall(head(studio, place(studio, ""), method="GET", Connection="close"))
        answer = connection.makefile("rb").read().decode()
    for line in ("Cache-Control: no-store", "Referrer-Policy: no-referrer", "X-Content-Type-Options: nosniff"):
        assert line in answer
    assert "frame-ancestors 'none'" in answer
    assert "Python" not in answer.partition("\r\n\r\n")[0]
    assert "Access-Control" not in answer


def test_another_site_is_refused_even_with_the_address(studio: Studio) -> None:
    """A browser says so itself: `Sec-Fetch-Site`."""
    for site in ("cross-site", "same-site"):
        assert post(studio, "actions", CHANGE, Sec_Fetch_Site=site)[0] == 403
        assert raw(studio, head(studio, place(studio, ""), method="GET", Origin=None, Sec_Fetch_Site=site))[0] == 403
    assert post(studio, "actions", CHANGE, Sec_Fetch_Site="same-origin")[0] == 200


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({"Content_Length": "4100001"}, 413),
        ({"Content_Length": "99999999999999999999"}, 413),
        ({"Content_Length": "-1"}, 411),
        ({"Content_Length": None}, 411),
        ({"Transfer_Encoding": "chunked"}, 411),
        ({"Content_Type": "text/plain"}, 415),
    ],
)
def test_bodies_that_are_not_read(studio: Studio, changed: dict[str, str | None], status: int) -> None:
    assert post(studio, "actions", CHANGE, **changed)[0] == status
    assert not studio.journal.lines()


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"null",
        b"{",
        b"[]",
        b"[NaN]",
        b"\xff",
        b"[" * 50_000,
        b'[{"kind":"put"}]',
        b'[{"kind":"drop","id":"../x"}]',
    ],
)
def test_malformed_messages_are_refused_with_a_sentence(studio: Studio, text: bytes) -> None:
    status, answer = post(studio, "actions", text)
    assert status == 400
    assert answer["error"]["code"] == "studio.message"
    assert answer["error"]["en"] != answer["error"]["ar"]


def test_a_message_is_taken_whole_or_not_at_all(studio: Studio) -> None:
    wrong = [*CHANGE, put("a-2", "set_joint", joint=7, value=0)]
    assert post(studio, "actions", wrong)[0] == 400
    assert not studio.journal.lines()


def test_full_journal(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    """A line more is refused; the lines that are there can still be changed and taken back."""
    monkeypatch.setattr(journal, "MOST_LINES", 1)
    assert post(studio, "actions", CHANGE)[0] == 200
    status, answer = post(studio, "actions", [put("a-2", "set_joint", joint=0, value=1)])
    assert (status, answer["error"]["code"]) == (400, "studio.journal_full")
    assert post(studio, "actions", CHANGE)[0] == 200
    assert post(studio, "actions", [{"kind": "drop", "id": "a-1"}])[0] == 200
    assert not studio.journal.lines()


def test_requests_that_do_not_come_are_ended(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    """Byte by byte, slower than anybody waits: the connection is closed, windows go on."""
    monkeypatch.setattr(server, "PATIENCE", 0.5)
    with listening(studio) as heard, socket.create_connection(("127.0.0.1", studio.server.server_port)) as slow:
        slow.settimeout(20)
        began = time.monotonic()
        ended = False
        while not ended and time.monotonic() - began < 15:
            try:
                slow.sendall(b"G")
                time.sleep(0.1)
                slow.settimeout(0.05)
                ended = slow.recv(1) == b""
            except TimeoutError:
                continue
            except OSError:
                ended = True
        assert ended
        assert time.monotonic() - began < 10
        assert post(studio, "actions", CHANGE)[0] == 200
        assert until(heard, "put")["id"] == "a-1"


def test_silent_connections_give_way(studio: Studio) -> None:
    """The table is full of connections that say nothing: windows go on, and new ones get their answers at once."""
    address = ("127.0.0.1", studio.server.server_port)
    with listening(studio) as heard:
        assert next(heard)["kind"] == "all"
        silent = [socket.create_connection(address) for _ in range(server.MOST_CONNECTIONS + 4)]
        silent[-1].sendall(b"GET /no-token/ HTTP/1.1\r\nHost: x")
        time.sleep(0.3)
        began = time.monotonic()
        for k in range(3):
            assert post(studio, "actions", [put(f"a-{k}", "set_joint", joint=0, value=0.5)])[0] == 200
        assert time.monotonic() - began < server.PATIENCE / 2
        assert until(heard, "put")["id"] == "a-0"
        # The first ones were closed, the last ones still wait.
        assert silent[0].recv(1) == b""
        silent[-2].settimeout(0.1)
        with pytest.raises(TimeoutError):
            silent[-2].recv(1)
        for connection in silent:
            connection.close()


def test_too_many_windows_with_the_token(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    """Who has shown the token does not give way; what comes then is closed at once."""
    monkeypatch.setattr(server, "MOST_CONNECTIONS", 2)
    with listening(studio) as first, listening(studio) as second:
        assert {next(first)["kind"], next(second)["kind"]} == {"all"}
        assert post(studio, "actions", CHANGE)[0] == 0
    time.sleep(0.1)


TWICE = ("Content-Length: 2", "Content-Type: application/json", "Sec-Fetch-Site: same-origin", "Host: {host}",
         "Transfer-Encoding: chunked\r\nTransfer-Encoding: identity", "Origin: http://{host}")  # fmt: skip


@pytest.mark.parametrize("line", TWICE)
def test_headers_that_decide_are_given_once(studio: Studio, line: str) -> None:
    body = json.dumps(CHANGE).encode()
    begin = head(studio, place(studio, "actions"), "POST", len(body), Sec_Fetch_Site="same-origin")[:-2]
    again = line.format(host=f"127.0.0.1:{studio.server.server_port}").encode() + b"\r\n\r\n"
    assert raw(studio, begin + again + body)[0] == 403
    assert not studio.journal.lines()


def test_a_drive_that_holds_all_windows_is_refused(studio: Studio) -> None:
    """What counts is by how much a line grows: a loop may be left on for hours."""
    most = journal.MOST_AT_ONCE
    assert post(studio, "actions", [put("s-0", "loop", closed=True)])[0] == 200
    status, answer = post(studio, "actions", [put("s-1", "simulate", ticks=10_000_000)])
    assert (status, answer["error"]["code"]) == (400, "studio.ticks")
    assert str(most) in answer["error"]["en"]
    for k in (1, 2, 3):
        assert post(studio, "actions", [put("s-1", "simulate", ticks=k * most)])[0] == 200


def test_too_many_windows(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(broadcast, "MOST_WINDOWS", 1)
    with listening(studio) as heard:
        next(heard)
        assert raw(studio, head(studio, place(studio, "events"), method="GET"))[0] == 503


def test_a_window_that_does_not_keep_up_begins_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its queue is bounded; it is told that it is over, and hears everything when it joins again."""
    monkeypatch.setattr(broadcast, "MOST_WAITING", 5)
    kept: list[int] = []
    windows = broadcast.Broadcast(lambda: {"kind": "all", "kept": list(kept)})
    slow = windows.join()
    for k in range(20):
        kept.append(k)
        windows.send({"kind": "put", "k": k})
    assert windows.windows == 0
    assert slow.qsize() <= 6
    assert [slow.get() for _ in range(slow.qsize())][-1] is None
    assert json.loads(windows.join().get() or b"")["kept"] == list(range(20))


_number = st.floats(-3, 3)
_action = st.one_of(
    st.tuples(st.just("set_joint"), st.fixed_dictionaries({"joint": st.integers(0, 1), "value": _number})),
    st.tuples(st.just("set_joints"), st.fixed_dictionaries({"values": st.lists(_number, min_size=2, max_size=2)})),
    st.tuples(st.just("loop"), st.fixed_dictionaries({"closed": st.booleans()})),
    st.tuples(st.just("push"), st.fixed_dictionaries({"wrench": st.lists(_number, min_size=6, max_size=6)})),
    st.tuples(st.just("simulate"), st.fixed_dictionaries({"ticks": st.integers(0, 20)})),
)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(_action, min_size=1, max_size=8))
def test_what_goes_over_the_wire_is_done_to_the_last_bit(studio: Studio, actions: list[tuple[str, Any]]) -> None:
    """Random actions: the journal of the server ends where the same calls of a session end."""
    for one in studio.journal.lines():
        assert post(studio, "actions", [{"kind": "drop", "id": one["id"]}])[0] == 200
    alone = Session(studio.arm.robot)
    for k, (name, arguments) in enumerate(actions):
        assert post(studio, "actions", [put(f"h-{k}", name, **arguments)])[0] == 200
        getattr(alone, name)(**arguments)
    assert np.array_equal(studio.journal.replay().q, alone.q)


def test_a_job_is_stopped(studio: Studio) -> None:
    """Also a long one, at once; nothing is written."""
    long = JOB.replace("[[move]]\njoints = [0.4, 0.3]", "[[move]]\njoints = [0.4, 0.3]\nduration = 500.0", 1)
    with listening(studio) as heard:
        next(heard)
        assert post(studio, "job", {"text": long, "window": "w"})[0] == 200
        assert post(studio, "job/run", {})[0] == 200
        assert post(studio, "job/run", {})[1]["error"]["code"] == "studio.running"
        until(heard, "run", status="running", stage="stage_simulating")
        began = time.monotonic()
        assert post(studio, "job/stop", {})[0] == 200
        until(heard, "run", status="stopped")
        assert time.monotonic() - began < 5
    assert not list(studio.jobs.results.glob("*"))


def test_errors_of_jobs_name_the_line(studio: Studio) -> None:
    """What the text says, and what does not fit the robot, at once; and again when it is run."""
    with listening(studio) as heard:
        next(heard)
        post(studio, "job", {"text": JOB.replace("robot =", "robt ="), "window": "w"})
        assert until(heard, "job")["wrong"]["line"] == 1
        post(studio, "job", {"text": JOB.replace("0.4, 0.3", "0.4, 0.3, 0.2"), "window": "w"})
        assert until(heard, "job")["wrong"]["line"] == 4
        post(studio, "job/run", {})
        assert until(heard, "run", status="wrong")["line"] == 4
        assert post(studio, "job/save", {})[1]["error"]["code"] == "studio.no_job_file"


def test_only_files_of_results_are_served(studio: Studio, tmp_path: Path) -> None:
    with listening(studio) as heard:
        next(heard)
        post(studio, "job/run", {})
        until(heard, "run", status="done")
    (tmp_path / "results" / "job-1" / "secret.txt").write_text("secret")
    found = {
        name: raw(studio, head(studio, place(studio, f"reports/1/{name}"), method="GET", Origin=None))[0]
        for name in ("report.html", "recording.csv", "secret.txt", "../job-1/report.html", "%72eport.html", "")
    }
    assert found == {
        "report.html": 200, "recording.csv": 200, "secret.txt": 404, "../job-1/report.html": 404,
        "%72eport.html": 404, "": 200,
    }  # fmt: skip


def test_port_that_is_taken(studio: Studio) -> None:
    with pytest.raises(InputError, match="cannot be used"):
        Studio("planar2r", port=studio.server.server_port)


@pytest.mark.parametrize("busy", [False, True])
def test_ctrl_c_ends_cleanly(tmp_path: Path, busy: bool) -> None:
    """With a window that listens, and in the midst of a run: with the exit code of every command."""
    (tmp_path / "long.toml").write_text(JOB.replace("[0.4, 0.3]", "[0.4, 0.3]\nduration = 900.0"))
    process = subprocess.Popen(
        [sys.executable, "-m", "mafsil.cli", "studio", "long.toml"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    assert process.stdout is not None
    found = re.search(r"http://127\.0\.0\.1:(\d+)/([\w-]+)/", process.stdout.readline())
    assert found
    port, token = int(found[1]), found[2]
    with socket.create_connection(("127.0.0.1", port), timeout=60) as window:
        local = f"Host: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\n"
        window.sendall(f"GET /{token}/events HTTP/1.1\r\n{local}\r\n".encode())
        assert window.recv(4096)
        if busy:
            with socket.create_connection(("127.0.0.1", port), timeout=60) as other:
                rest = "Content-Type: application/json\r\nContent-Length: 2\r\n\r\n{}"
                other.sendall(f"POST /{token}/job/run HTTP/1.1\r\n{local}{rest}".encode())
                assert b" 200 " in other.recv(100)
            time.sleep(0.8)
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=30)
        while window.recv(65536):
            pass
    assert process.returncode == 130
    assert complaint == "mafsil: stopped by the user\n"
    # A run leaves all of its results or nothing.
    left = list(tmp_path.glob("mafsil-results/*"))
    assert all((folder / "report.html").is_file() for folder in left)


def test_what_a_studio_opens_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot, a job, the results of a job, two recordings; and what does not go together."""
    from mafsil.studio.opening import robot_of_job, studio_of

    monkeypatch.chdir(tmp_path)
    Path("lift.toml").write_text(JOB)
    with studio_of(["lift.toml"], 0) as opened:
        assert opened.jobs.job["text"] == JOB
        opened.jobs.start()
        for _ in range(400):
            if not opened.jobs.running:
                break
            time.sleep(0.05)
        assert opened.jobs.run["status"] == "done"
        opened.jobs.edit(JOB + "\n# more\n", "w")
        opened.jobs.save()
    assert Path("lift.toml").read_text() == JOB + "\n# more\n"
    assert robot_of_job("lift.toml").n == 2
    results = "mafsil-results/lift-1"
    with studio_of([results, f"{results}/recording.npz"], 0) as opened:
        assert opened.arm.robot.name == "planar2r"
        assert [one["title"] for one in opened.recordings.list_recordings()["list"]] == ["lift-1", "lift-1"]
        assert opened.recordings.compare(1, 2)["largest"] == 0.0
    with pytest.raises(InputError, match="other joints"):
        studio_of(["panda", results], 0)
    with pytest.raises(InputError, match="one robot or job"):
        studio_of(["panda", "lift.toml"], 0)
    with pytest.raises(FileError):
        studio_of(["nothing.npz"], 0)


def test_numbers_in_arabic_sentences_stand_in_isolates() -> None:
    """A degree after a number goes to its other side where the letters before are Arabic, unless both are isolated."""
    said = {"en": "joint2 is 0.977° off", "ar": "يبعد joint2 عنه 0.977°"}
    assert in_all_languages(said.__getitem__) == {
        "en": said["en"],
        "ar": "يبعد \u2066joint2\u2069 عنه \u20660.977°\u2069",
    }
    error = complaint(InputError("input.choice", name="do", value="a 1.5°", known="x"))
    assert "\u2066" in error["sentence"]["ar"]
    assert "\u2066" not in error["sentence"]["en"]


def test_a_joint_that_is_not_free_does_not_swing(studio: Studio) -> None:
    """What the session would refuse never stands in the journal."""
    line = {"kind": "put", "id": "w-1", "do": "swing", "with": {"joint": 0, "value": 0.1, "branch": 0}}
    assert post(studio, "actions", [line])[0] in (400, 422)
    assert not studio.journal.lines()
