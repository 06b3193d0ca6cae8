"""What a reader does with a report in headless Chromium, opened from disk: replays the run, takes its data."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from mafsil.csv_table import read_csv_table
from mafsil.job import Run
from mafsil.messages import say
from mafsil.report import write_results
from tests.page.browser import Browser

DRAWN = "document.querySelector('.cursor') && replay"
"""That the script of a report has drawn its plots and the arm."""
ARABIC = re.compile("[\u0600-\u06ff]")
SEVEN_DIGITS = 6e-7
"""Half a unit of the seventh digit, relative, and the rounding to single precision."""


@pytest.fixture(scope="module")
def results(small_run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results") / "out"
    write_results(small_run, folder)
    return folder


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Browser]:
    """A browser that asks for nothing but the report, and meets no error."""
    with Browser(tmp_path) as window:
        window.requests.clear()
        yield window
        assert not window.errors
        assert sum(url.startswith("file:") for url in window.requests) == 1
        assert all(url.startswith(("file:", "blob:")) for url in window.requests), window.requests


def saved(browser: Browser, selector: str) -> Path:
    """The file that a click saves."""
    browser.click(selector)
    end = time.monotonic() + 20
    while time.monotonic() < end:
        found = [path for path in browser.downloads.iterdir() if path.suffix == ".csv" and path.stat().st_size]
        if found:
            return found[0]
        time.sleep(0.05)
    raise TimeoutError("nothing was saved")


def colours(browser: Browser) -> list[int]:
    """A small copy of the picture."""
    return browser.ask(
        "(() => { const c = document.createElement('canvas'), x = (c.width = 80, c.height = 50, c.getContext('2d'));"
        " replay.paint(); x.drawImage(by('scene'), 0, 0, 80, 50);"
        " return [...new Uint32Array(x.getImageData(0, 0, 80, 50).data.buffer)]; })()"
    )


def test_the_run_is_replayed(browser: Browser, results: Path, small_run: Run) -> None:
    """The slider moves the arm, the clock and the marks of all plots; play lets time pass."""
    browser.load(results / "report.html", "#t=0", DRAWN)
    before = colours(browser)
    end = small_run.recording.t[-1]
    slider = "(f => { f.value = 0.5; f.dispatchEvent(new Event('input')); })(by('time'))"
    browser.ask(slider)
    assert browser.ask("clock.t") == pytest.approx(end / 2)
    assert browser.ask("by('clock').textContent") == f"{browser.ask('clock.t'):.2f} s"
    assert np.count_nonzero(np.subtract(colours(browser), before)) > 40
    marks = browser.ask("[...document.querySelectorAll('.cursor')].map(e => Number(e.getAttribute('x1')))")
    assert len(marks) == 4
    assert min(marks) > 52
    browser.click("#play")
    browser.wait(f"clock.t > {end / 2} + 0.05")


def test_the_data_are_saved_offline(browser: Browser, results: Path, small_run: Run) -> None:
    """Columns named as in recording.csv, and its numbers at the same times, to seven digits."""
    browser.load(results / "report.html", "#t=0", DRAWN)
    mine, tape = read_csv_table(saved(browser, "#save-table")), small_run.recording
    t = mine.numbers([mine.time_column()])[:, 0]
    mine.require_increasing(t)
    rows = np.abs(tape.t[:, None] - t).argmin(axis=0)
    assert len(t) > 100
    assert np.allclose(t, tape.t[rows], rtol=SEVEN_DIGITS, atol=0)
    curves = {"q": tape.q, "qd": tape.qd, "tau": tape.tau, "q_error": tape.q - tape.q_ref}
    for name, values in curves.items():
        places = mine.joint_columns(name, small_run.robot.joint_names, required=True)
        assert places is not None
        assert np.allclose(mine.numbers(places), values[rows], rtol=SEVEN_DIGITS, atol=1e-12)


def test_both_languages(browser: Browser, results: Path, small_run: Run) -> None:
    """The button turns every text into Arabic and the page round, then back; the replay stays where it was."""
    browser.load(results / "report.html", "#t=0.5", DRAWN)
    before = browser.ask("document.body.innerText")
    browser.click("#language")
    assert browser.ask("[document.documentElement.lang, document.documentElement.dir]") == ["ar", "rtl"]
    assert browser.ask("clock.t") == 0.5
    texts = "[...document.querySelectorAll('h2, h3, #hint, #view, .share, .number .label, th')].map(e => e.textContent)"
    assert not [text for text in browser.ask(texts) if not ARABIC.search(text)]
    labels = browser.ask("[...document.querySelectorAll('[aria-label]')].map(e => e.ariaLabel)")
    assert all(map(ARABIC.search, labels)), labels
    arabic = say("report.verdict_good", language="ar"), say("report.footer", language="ar")
    shown = browser.ask("document.body.textContent")
    assert all(text.split(".")[0][:12] in shown for text in arabic)
    assert browser.ask("document.getElementById('scene').dir") == "ltr"
    browser.click("#language")
    assert browser.ask("document.documentElement.dir") == "ltr"
    assert browser.ask("document.body.innerText") == before
