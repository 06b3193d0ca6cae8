"""What a reader does with a report in headless Chromium, opened from disk: replays the run, takes its data."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from mafsil.csv_table import read_csv_table
from mafsil.job import Run
from mafsil.job.planning.limiting import most_used
from mafsil.messages import say
from mafsil.page import Session
from mafsil.report import write_results
from mafsil.report.replay import MOST_NUMBERS
from tests.page.browser import Browser
from tests.page.test_page_browser import bar_of_a_phone

DRAWN = "document.querySelector('.cursor') && window.mafsil && window.mafsil.timing.frames > 0"
"""That the script of a report has drawn its plots and the arm."""
TIME = "mafsil.player.replay.time"
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


def saved(browser: Browser, selector: str, suffix: str = ".csv") -> Path:
    """The file that a click saves."""
    browser.click(selector)
    end = time.monotonic() + 20
    while time.monotonic() < end:
        found = [path for path in browser.downloads.iterdir() if path.suffix == suffix and path.stat().st_size]
        if found:
            return found[0]
        time.sleep(0.05)
    raise TimeoutError("nothing was saved")


def settle(browser: Browser) -> None:
    """Wait until what was done is drawn."""
    browser.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def colours(browser: Browser) -> list[int]:
    """A small copy of the picture."""
    return browser.ask(
        "(() => { const c = document.createElement('canvas'), x = (c.width = 80, c.height = 50, c.getContext('2d'));"
        " mafsil.stage.paint(); x.drawImage(document.getElementById('scene'), 0, 0, 80, 50);"
        " return [...new Uint32Array(x.getImageData(0, 0, 80, 50).data.buffer)]; })()"
    )


def test_the_run_is_replayed(browser: Browser, results: Path, small_run: Run) -> None:
    """The slider moves the arm, the clock and the marks of all plots; play lets time pass."""
    browser.load(results / "report.html", "#t=0", DRAWN)
    before = colours(browser)
    end = small_run.recording.t[-1]
    slider = "(f => { f.value = 0.5; f.dispatchEvent(new Event('input')); })(document.getElementById('time'))"
    browser.ask(slider)
    assert browser.ask(TIME) == pytest.approx(end / 2)
    settle(browser)
    assert browser.ask("document.getElementById('clock').textContent") == f"{browser.ask(TIME):.2f} s"
    assert np.count_nonzero(np.subtract(colours(browser), before)) > 40
    marks = browser.ask("[...document.querySelectorAll('.cursor')].map(e => Number(e.getAttribute('x1')))")
    assert len(marks) == 6
    assert min(marks) > 52
    browser.click("#play")
    browser.wait(f"{TIME} > {end / 2} + 0.05")


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
    used, labels = most_used(small_run.plan, tape.t[rows])
    places = [k for k, head in enumerate(mine.heads) if head.startswith("limit_used[")]
    assert len(places) == len(labels) > 1
    numbers = np.array([[float(row[k]) for k in places] for row in mine.rows])
    assert np.allclose(numbers, 100.0 * used, rtol=SEVEN_DIGITS, atol=1e-9, equal_nan=True)


def test_both_languages(browser: Browser, results: Path, small_run: Run) -> None:
    """The button turns every text into Arabic and the page round, then back; the replay stays where it was."""
    browser.load(results / "report.html", "#t=0.5", DRAWN)
    before = browser.ask("document.body.innerText")
    browser.click("#language")
    settle(browser)
    assert browser.ask("[document.documentElement.lang, document.documentElement.dir]") == ["ar", "rtl"]
    assert browser.ask(TIME) == 0.5
    marked = (
        "#reading > section h2, h3, #hint, #home, #take, #tabs button,"
        " .share:not([data-do=svg]):not([data-do=csv]), .number .label, #reading > section th"
    )
    texts = f"[...document.querySelectorAll('{marked}')].filter(e => !e.closest('#views')).map(e => e.textContent)"
    assert not [text for text in browser.ask(texts) if not ARABIC.search(text)]
    labels = browser.ask(
        "[...document.querySelectorAll('[aria-label]')].filter(e => !e.closest('#views > *')).map(e => e.ariaLabel)"
    )
    assert all(map(ARABIC.search, labels)), labels
    arabic = say("report.verdict_good", language="ar"), say("report.footer", language="ar")
    shown = browser.ask("document.body.textContent")
    assert all(text.split(".")[0][:12] in shown for text in arabic)
    assert browser.ask("document.getElementById('scene').dir") == "ltr"
    browser.click("#language")
    settle(browser)
    assert browser.ask("document.documentElement.dir") == "ltr"
    assert browser.ask("document.body.innerText") == before


def tip(browser: Browser) -> tuple[float, float]:
    """Where the tip is on the screen."""
    left, top, _, _ = browser.box("#scene")
    found = browser.ask("mafsil.stage.drag.place()")
    return left + found["x"], top + found["y"]


def same_bits(one: object, other: object) -> bool:
    return np.array(one, dtype=np.float64).tobytes() == np.array(other, dtype=np.float64).tobytes()


def test_the_arm_is_taken_over_and_given_back(
    browser: Browser, results: Path, small_run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Grab the tool of a replay that plays, lead it, choose a branch, push; go back; the same bits in Python."""
    browser.load(results / "report.html", "#t=1", DRAWN)
    robot, tape = small_run.robot, small_run.recording
    # 1. The page shows the arm where the recording has it.
    shown = browser.ask("mafsil.store.state.q")
    row = int(np.searchsorted(tape.t, 1.0))
    assert np.abs(np.subtract(shown, tape.q[row])).max() < 2e-3
    # 2. The tool is dragged while the replay plays: it stops, the arm follows from there, and the cards are unfolded.
    browser.ask("document.getElementById('speed').value = '0.1'; mafsil.player.replay.speed = 0.1")
    browser.click("#play")
    browser.wait(f"{TIME} > 1.01")
    x, y = tip(browser)
    browser.drag((x, y), (x - 24, y - 30))
    settle(browser)
    led = browser.ask("mafsil.store.state")
    assert led["status"] == "solved"
    assert browser.ask("mafsil.store.shown.replay") is None
    assert [one["do"] for one in browser.ask("mafsil.store.journal")] == ["set_joints", "reach"]
    begin = browser.ask("mafsil.store.journal[0].with.values")
    assert np.abs(np.subtract(begin, shown)).max() < 0.1
    # 3. Branches stand beside it as ghosts; one is chosen, the loop is closed and the tip pushed.
    browser.ask("mafsil.store.do('set_joints', {values: [0.8, 0.8, -0.8, -1.3201, 0.8, 1.348, -0.8]})")
    browser.ask("mafsil.store.show({ghosts: true})")
    browser.wait("mafsil.stage.named.length > 0")
    browser.click("#labels button")
    browser.ask("mafsil.store.do('loop', {closed: true}); mafsil.store.do('push', {wrench: [0, 0, 0, 8, 0, 0]});")
    browser.ask("mafsil.store.do('simulate', {ticks: 200}); mafsil.store.do('loop', {closed: false})")
    end = browser.ask("mafsil.store.state.q")
    assert np.abs(np.subtract(end, led["q"])).max() > 1e-3
    # 4. Back to the replay, where it was; its slider moves the arm again, the journal stays.
    browser.click("#take")
    settle(browser)
    assert same_bits(browser.ask("mafsil.store.state.q"), begin)
    assert browser.ask(TIME) > 1.0
    browser.ask("(f => { f.value = 0; f.dispatchEvent(new Event('input')); })(document.getElementById('time'))")
    assert same_bits(browser.ask("mafsil.store.state.q"), tape.q[0].astype("<f4"))
    assert browser.ask("mafsil.store.journal.length") == 8
    # 5. The script does the run again and all that was done to its robot, to the last bit.
    monkeypatch.chdir(results)
    scope: dict[str, object] = {}
    browser.ask("mafsil.unfold('code')")
    exec(saved(browser, "[data-do=save]", ".py").read_text(encoding="utf-8"), scope)
    arm, run = scope["arm"], scope["run"]
    assert isinstance(arm, Session)
    assert isinstance(run, Run)
    assert same_bits(run.recording.q, tape.q)
    assert run.robot.n == robot.n
    assert same_bits(arm.q, end)
    assert same_bits(arm.q, browser.ask("mafsil.store.now.q"))


def test_a_report_opens_the_script_that_it_saved(browser: Browser, results: Path, tmp_path: Path) -> None:
    """Taken over by the button and by a slider; both languages; the script's lines lead there again."""
    browser.load(results / "report.html", "#t=0.4", DRAWN)
    browser.click("#take")
    settle(browser)
    for _ in range(2):
        assert browser.ask("document.documentElement.scrollWidth <= innerWidth")
        assert browser.ask("document.getElementById('take').textContent").strip()
        browser.click("#language")
        settle(browser)
    browser.ask("mafsil.store.do('set_joint', {joint: 2, value: 0.5})")
    q = browser.ask("mafsil.store.now.q")
    browser.ask("mafsil.unfold('code')")
    text = saved(browser, "[data-do=save]", ".py").read_text(encoding="utf-8")
    assert 'run = solve_file("job.toml")' in text
    assert "  # t = 0.400 s" in text
    again = tmp_path / "again.html"
    again.write_bytes((results / "report.html").read_bytes())
    browser.load(again, "#t=0", DRAWN)
    browser.ask(
        "(text => { const carried = new DataTransfer(), input = document.getElementById('script');"
        " carried.items.add(new File([text], 'script.py')); input.files = carried.files;"
        f" input.dispatchEvent(new Event('change')); }})({json.dumps(text)})"
    )
    browser.wait("mafsil.store.journal.length === 2")
    assert same_bits(browser.ask("mafsil.store.now.q"), q)
    browser.requests[:] = browser.requests[-1:]


def test_a_report_stays_small(results: Path, small_run: Run) -> None:
    """The page of the robot is below 300 kB; what a run adds is bounded by its rows and by the frames of its replay."""
    size = (results / "report.html").stat().st_size
    plots = 4 * small_run.robot.n + small_run.robot.n + 12
    assert size < 300_000 + 16 / 3 * (small_run.job.report.rows + 64) * plots + 16 / 3 * MOST_NUMBERS
    assert size < 400_000


def test_outlines_are_drawn_without_webgl(browser: Browser, results: Path) -> None:
    browser.load(results / "report.html", "#flat", DRAWN)
    assert browser.ask("mafsil.stage.kind") == "flat"
    assert len(set(colours(browser))) > 40


def test_on_a_phone_the_arm_stays_in_view_while_its_sliders_move(browser: Browser, results: Path) -> None:
    """Nothing is wider than the screen, in both languages; the picture stands above the cards however far one reads."""
    browser.resize(390, 800, phone=True)
    browser.load(results / "report.html", "#t=0.5", DRAWN)
    browser.click("#take")
    settle(browser)
    for _ in range(2):
        assert browser.ask("document.documentElement.scrollWidth") <= 390
        browser.ask("document.querySelectorAll('.joint')[6].scrollIntoView({block: 'end'})")
        settle(browser)
        top = browser.ask("document.getElementById('stage').getBoundingClientRect().top")
        assert -1 <= top <= 1
        assert browser.ask("document.querySelectorAll('.joint')[6].getBoundingClientRect().top") > 240
        browser.ask("document.getElementById('language').click()")
        settle(browser)


@pytest.mark.parametrize("width", [360, 412])
def test_a_phone_has_its_bar_in_one_row_and_tables_that_fit(browser: Browser, results: Path, width: int) -> None:
    browser.resize(width, 800, phone=True)
    browser.load(results / "report.html", "#t=0.5", DRAWN)
    bar_of_a_phone(browser)
    for language in ("en", "ar"):
        assert browser.ask("[...document.querySelectorAll('.wide')].every(e => e.scrollWidth <= e.clientWidth)")
        heads = browser.ask("[...document.querySelectorAll('#joints th')].map(e => e.textContent)")
        cells = browser.ask(
            "[...document.querySelectorAll('#joints tbody tr:first-child td')].map(e => e.dataset.head)"
        )
        assert cells == heads, language
        browser.ask("mafsil.speak()")


def test_paper_shows_key_frames_and_nothing_to_press(browser: Browser, results: Path) -> None:
    """A4 at 96 dots an inch: what is wider would be cut."""
    browser.load(results / "report.html", "#t=0.5", DRAWN)
    browser.ask("mafsil.player.strip()")
    browser.resize(794, 1123, media="print")
    settle(browser)
    assert browser.ask("document.documentElement.scrollWidth") <= 794
    seen = "[...document.querySelectorAll('{}')].filter(e => e.checkVisibility()).map(e => e.outerHTML.slice(0, 90))"
    assert len(browser.ask(seen.format("#strip canvas"))) == 5
    assert browser.ask(seen.format("#top button, #tree button, #bar *, input, #stage button")) == []
    browser.ask("mafsil.player.strip()")  # once more, where there is no picture to copy
    browser.resize(1280, 860)


def test_the_replay_is_led_by_keys_and_every_control_has_a_name(browser: Browser, results: Path) -> None:
    browser.load(results / "report.html", "#t=0.5", DRAWN)
    nameless = browser.ask(
        "[...document.querySelectorAll('button, input, select, canvas, pre, summary')].filter(e =>"
        " !(e.getAttribute('aria-label') || e.textContent.trim() || e.closest('label')?.textContent.trim()))"
        ".map(e => e.outerHTML)"
    )
    assert nameless == []
    browser.ask("document.activeElement.blur()")
    browser.key(" ")
    browser.wait(f"{TIME} > 0.55")
    browser.key(" ")
    assert browser.ask("mafsil.store.shown.replay.playing") is False
    browser.ask("document.getElementById('scene').focus()")
    browser.key("ArrowUp", modifiers=2)
    assert [one["do"] for one in browser.ask("mafsil.store.journal")] == ["set_joints", "reach"]


def test_plots_are_zoomed_together_in_the_chosen_unit_and_saved(
    browser: Browser, results: Path, small_run: Run
) -> None:
    """A drag shows a range of the time in every plot, also in the timeline; what is saved is what is seen."""
    browser.resize(1280, 800)
    browser.load(results / "report.html", "#t=0.1", DRAWN)
    choose = "(f => {{ f.value = {}; f.dispatchEvent(new Event('change')); }})(document.getElementById('signal'))"
    browser.ask(choose.format("'0'"))
    settle(browser)
    assert browser.ask("document.querySelectorAll('#docked .curve').length") == small_run.robot.n
    left, top, width, height = browser.settled_box("#docked .plot > svg")
    at, middle = (lambda share: left + 52 + (width - 62) * share), top + height / 2
    end = browser.ask("mafsil.motion.docked.last")
    browser.drag((at(0.25), middle), (at(0.5), middle))
    windows = browser.ask("mafsil.motion.axis.plots.map(one => [one.from, one.to])")
    assert len(windows) == 1 + browser.ask("mafsil.motion.plots.length")
    assert all(abs(a - 0.25 * end) < 0.01 * end and abs(b - 0.5 * end) < 0.01 * end for a, b in windows)
    browser.mouse("mouseMoved", at(0.5), middle)
    probes = "mafsil.motion.axis.plots.map(one => one.probeLine.getAttribute('visibility'))"
    assert set(browser.ask(probes)) == {"visible"}
    # In degrees the table is that of the recording, and only what is seen of it.
    browser.click("#angles")
    lines = browser.ask("mafsil.motion.plots[0].table()").strip().split("\n")
    assert lines[0] == ",".join(["t [s]", *(f"{name} [°]" for name in small_run.robot.joint_names)])
    rows = np.array([line.split(",") for line in lines[1:]], float)
    assert windows[0][0] <= rows[0, 0] <= rows[-1, 0] <= windows[0][1]
    tape = small_run.recording
    exact = np.stack([np.interp(rows[:, 0], tape.t, column) for column in tape.q.T], axis=1)
    assert np.abs(np.deg2rad(rows[:, 1:]) - exact).max() < 1e-6
    picture = browser.ask("mafsil.motion.plots[0].picture()")
    assert picture.count("<path") == small_run.robot.n
    assert "style=" not in picture
    assert "var(" not in picture
    browser.ask("document.querySelector('#docked svg').dispatchEvent(new Event('dblclick'))")
    assert browser.ask("mafsil.motion.axis.window") is None


OVERLAPS = """(() => {
  const shown = (e) => e.textContent && e.checkVisibility({ visibilityProperty: true });
  const boxes = [...document.querySelectorAll("#hint, #scale, #clock, #move-name, #status, #labels button")].filter(shown)
    .map((e) => [e.id, e.getBoundingClientRect()]), found = [];
  const [x, y, z] = ["x", "y", "z"].map((k) => document.querySelector(`#compass .${k}:is(button)`).getBoundingClientRect());
  for (const [a, b] of [[x, y], [y, z], [x, z]]) if (Math.hypot(a.left - b.left, a.top - b.top) < 23) found.push("compass");
  boxes.forEach(([name, a], k) => boxes.slice(0, k).forEach(([other, b]) => {
    if (a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom) found.push(`${name} ${other}`);
  }));
  return [boxes.map(([name]) => name), found];
})()"""  # noqa: E501


def test_no_label_lies_on_another(browser: Browser, results: Path) -> None:
    """Clock, move, reason, hint, scale and axes, on a screen and on a phone, in both languages."""
    browser.load(results / "report.html")
    for size, phone in (((1280, 800), False), ((390, 800), True)):
        browser.resize(*size, phone=phone)
        for _ in ("en", "ar"):
            browser.ask("mafsil.say({ key: 'why_limits', values: { count: 3, excess: '0.1234 rad' } })")
            browser.ask("mafsil.frame(performance.now())")
            shown, found = browser.ask(OVERLAPS)
            assert browser.ask("document.getElementById('top').clientHeight") <= 60, "the bar is one row"
            assert {"scale", "clock", "move-name", "status"} <= set(shown)
            assert found == []
            browser.ask("mafsil.speak()")
    browser.resize(1280, 860)


def test_axe_finds_nothing(browser: Browser, results: Path) -> None:
    browser.resize(1280, 800)
    browser.load(results / "report.html", "", DRAWN)
    for _ in ("en", "ar"):
        for tab in browser.ask("mafsil.tabs"):
            browser.ask(f"mafsil.turn('{tab}')")
            settle(browser)
            assert browser.violations() == []
        browser.click("#language")
