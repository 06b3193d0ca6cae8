"""The studio in headless Chromium: windows that share a robot, jobs run by Python, no request to anywhere else."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator

import pytest

from mafsil.studio import Studio
from tests.page.browser import Browser
from tests.page.test_page_browser import slide, state


@pytest.fixture(scope="module")
def studio() -> Iterator[Studio]:
    with Studio("panda", language="en") as served:
        threading.Thread(target=served.serve, daemon=True).start()
        yield served
        served.server.shutdown()


@pytest.fixture(scope="module")
def windows(studio: Studio, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Browser, Browser]]:
    """Two windows of one studio, which ask nothing of anybody else and meet no error."""
    with Browser(tmp_path_factory.mktemp("first")) as first, Browser(tmp_path_factory.mktemp("second")) as second:
        for window in (first, second):
            window.requests.clear()
            window.load(studio.address)
            window.wait("mafsil.link.connected")
        yield first, second
        for window in (first, second):
            assert not window.errors
            assert window.requests
            assert all(url.startswith((studio.address, "blob:")) for url in window.requests), window.requests


def settled(studio: Studio, *windows: Browser) -> list[float]:
    """The coordinates that all windows and Python agree on, to the last bit, when nothing is on its way."""
    for window in windows:
        window.wait("!mafsil.link.pending.size")
    lines = [[one["do"], one["with"]] for one in studio.journal.lines()]
    for window in windows:
        window.wait(f"mafsil.store.journal.length === {len(lines)}")
        assert [[one["do"], one["with"]] for one in window.ask("mafsil.store.journal")] == lines
    q = studio.journal.replayed().q.tolist()
    for window in windows:
        assert state(window)["q"] == q
    return q


def act(window: Browser, joint: int, value: float, *, gesture: bool) -> None:
    """Move a joint as its slider does."""
    how = json.dumps({"gesture": gesture})
    window.ask(f"mafsil.store.do('set_joint', {{joint: {joint}, value: {value}}}, {how})")


def test_a_second_window_follows(studio: Studio, windows: tuple[Browser, Browser]) -> None:
    first, second = windows
    before = state(second)["q"]
    slide(first, 1, -0.12)
    q = settled(studio, first, second)
    assert q[1] < before[1] - 0.2
    assert len(studio.journal.lines()) == 1


def test_both_windows_at_once(studio: Studio, windows: tuple[Browser, Browser]) -> None:
    """What is done in both at the same time is in the journal once each, in one order for all."""
    first, second = windows
    count = len(studio.journal.lines())
    for k in range(20):
        act(first, 0, 0.01 * k, gesture=True)
        act(second, 3, -1 - 0.02 * k, gesture=k % 2 == 1)
    q = settled(studio, first, second)
    assert q[0] == 0.01 * 19
    assert q[3] == -1 - 0.02 * 19
    assert len(studio.journal.lines()) > count + 2
    first.ask("mafsil.store.release()")
    second.ask("mafsil.store.undo()")
    settled(studio, first, second)
