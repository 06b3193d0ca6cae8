"""The studio in headless Chromium: windows that share a robot, jobs run by Python, no request to anywhere else."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import FileError
from mafsil.simulation import Recording
from mafsil.studio import Studio
from mafsil.studio.opening import studio_of
from mafsil.studio.recordings import at
from tests.page.browser import Browser
from tests.page.test_page_browser import slide, state

JOB = """\
robot = "panda"

[simulation]
mass_error = 0.0

[[move]]
joints = [0.1, 0.2, 0.3, -1.5, 0.2, 1.5, 0.4]
"""


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    results = tmp_path_factory.mktemp("results")
    with Studio("panda", language="en", job=(JOB, None), results=results) as served:
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
    q = studio.journal.replay().q.tolist()
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


def write(window: Browser, old: str, new: str) -> None:
    """Replace words of the job, as somebody who types."""
    change = f"f.value = f.value.replace({json.dumps(old)}, {json.dumps(new)}); f.dispatchEvent(new Event('input'));"
    window.ask(f"(f => {{ {change} }})(document.getElementById('job'))")


def unfold(window: Browser, *views: str) -> None:
    for view in views:
        window.ask(f"mafsil.unfold('{view}')")
    window.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def run_job(window: Browser, recordings: int) -> None:
    """Press run, and wait until the recording is there."""
    window.wait("!document.getElementById('job-run').disabled")
    window.click("#job-run")
    window.wait(f"mafsil.link.heard.get('recordings').list.length === {recordings}")
    window.wait("mafsil.link.heard.get('run').status !== 'running'")


def test_a_job_is_written_run_replayed_and_compared(studio: Studio, windows: tuple[Browser, Browser]) -> None:
    first, second = windows
    for window in windows:
        unfold(window, "job", "recordings")
    # 1. What is wrong is said with its line, in both windows, and cannot be run.
    write(first, "robot =", "robt =")
    for window in windows:
        window.wait("document.querySelector('#job-wrong [data-line]')?.dataset.line === '1'")
        window.wait("document.getElementById('job-run').disabled")
    assert "robt" in second.ask("document.getElementById('job').value")
    second.click("#job-wrong button")
    assert second.ask("(f => f.value.slice(f.selectionStart, f.selectionEnd))(document.getElementById('job'))") == (
        'robt = "panda"'
    )
    # 2. The other window mends it and runs it; both see how it ends.
    write(second, "robt =", "robot =")
    run_job(second, 1)
    first.wait("mafsil.link.heard.get('run').status === 'done'")
    first.wait("document.querySelector('#job-outcome a')")
    #    The window that pressed run shows it; the other one does not until it is asked to.
    second.wait("mafsil.store.shown.replay?.first.number === 1")
    assert first.ask("mafsil.store.shown.replay") is None
    second.ask("mafsil.store.show({ chosen: [null, null], replay: null })")
    # 3. Another run with other masses.
    write(first, "mass_error = 0.0", "mass_error = 0.2")
    run_job(first, 2)
    tapes = [Recording.load(studio.jobs.results / f"job-{k}" / "recording") for k in (1, 2)]
    # 4. The last one is replayed from its card; then both, the second as a ghost: the arm is where the recording says.
    first.ask("document.getElementById('view-recordings').open = false")
    first.wait("document.querySelector('#job-outcome button')")
    first.ask("document.querySelector('#job-outcome button').click()")
    first.wait("mafsil.store.shown.replay?.first.number === 2")
    first.ask("mafsil.store.show({ chosen: [1, 2] })")
    first.wait("mafsil.store.shown.replay?.second && document.querySelector('#comparison p')")
    time = float(tapes[0].t[len(tapes[0].t) // 2])
    first.ask(f"mafsil.store.show({{ replay: {{ ...mafsil.store.shown.replay, time: {time}, playing: false }} }})")
    unfold(first)
    replay = first.ask("mafsil.store.shown.replay")
    for shown, tape in ((replay["q"], tapes[0]), (replay["ghost"], tapes[1])):
        exact = at(tape, np.array([time]))[0]
        assert np.abs(np.subtract(shown, exact)).max() < 1e-5
    first.click("#play")
    first.wait(f"mafsil.store.shown.replay.time > {time} + 0.1")
    # 5. Whoever moves the arm takes it over from there; the other window never was in the replay.
    first.click("#play")
    paused = first.ask("mafsil.store.state.q")
    act(first, 0, 0.5, gesture=False)
    assert first.ask("mafsil.store.shown.replay") is None
    q = settled(studio, first, second)
    assert q == [0.5, *paused[1:]]
    assert [one["do"] for one in first.ask("mafsil.store.journal.slice(-2)")] == ["set_joints", "set_joint"]
    first.click("#language")
    first.click("#language")
    assert first.ask("mafsil.store.shown.replay") is None
    #    The slider leads back to the replay, and leaves the journal alone.
    first.ask("(f => { f.value = 0; f.dispatchEvent(new Event('input')); })(document.getElementById('time'))")
    first.wait("mafsil.store.shown.replay?.q")
    exact = at(tapes[0], np.zeros(1))[0]
    assert np.abs(np.subtract(first.ask("mafsil.store.state.q"), exact)).max() < 1e-5
    assert first.ask("mafsil.store.now.q") == settled(studio, second) == q
    # 6. The report and its data come from the same server.
    report = first.ask("fetch(document.querySelector('#report').href).then(answer => answer.text())")
    assert report.startswith("<!doctype html>")
    assert first.ask("fetch('reports/1/results.json').then(answer => answer.json())")["status"] == "done"


def test_a_run_is_seen_while_it_is_computed(tmp_path: Path) -> None:
    """The planned path first, then the arm along what is computed, then the recording, which goes on where it was."""
    job = Path(__file__).parents[2] / "examples/jobs/pick_and_place_panda.toml"
    with studio_of([str(job)], 0) as served, Browser(tmp_path) as window:
        served.jobs.results = tmp_path / "results"
        threading.Thread(target=served.serve, daemon=True).start()
        window.load(served.address)
        # 1. A target that nothing reaches is named with its line as one types, and what helps is said.
        write_when_ready(window, "[0.48, -0.30, 0.32]", "[1.48, -0.30, 0.32]")
        window.wait("document.querySelector('#job-doubts [data-line]')")
        said = window.ask("document.getElementById('job-doubts').textContent")
        assert "out of reach" in said
        assert "move the pose or the base" in said
        line = int(window.ask("document.querySelector('#job-doubts [data-line]').dataset.line"))
        assert "1.48" in served.jobs.job["text"].split("\n")[line - 1]
        write_when_ready(window, "[1.48, -0.30, 0.32]", "[0.48, -0.30, 0.32]")
        window.wait("!document.querySelector('#job-doubts li')")
        # 2. The path of the plan is there before anything moves; then the arm follows.
        window.ask(
            "mafsil.link.store.listen(() => { window.first ||= mafsil.link.heard.has('motion') &&"
            " !mafsil.store.shown.replay && mafsil.link.heard.get('motion').path; })"
        )
        window.wait("!document.getElementById('job-run').disabled")
        window.click("#job-run")
        window.wait("mafsil.store.shown.replay && mafsil.link.heard.get('motion').t.length > 10")
        window.wait("mafsil.link.heard.get('run').status === 'done'")
        motion = window.ask("mafsil.link.heard.get('motion')")
        tape = Recording.load(served.jobs.results / f"{job.stem}-1" / "recording")
        assert np.all(np.diff(motion["t"]) > 0)
        assert motion["t"][-1] == pytest.approx(tape.duration, abs=0.05)
        assert np.abs(np.array(motion["q"]) - at(tape, np.array(motion["t"]))).max() < 1e-9
        path, tips = np.array(window.ask("window.first")), np.asarray(served.arm.robot.fk(tape.q))[:, :3, 3]
        apart = np.linalg.norm(path[:, None] - tips[None, ::2], axis=2).min(axis=1)
        assert apart.max() < 5e-3
        # 3. What is shown then is the recording.
        window.wait("mafsil.store.shown.replay?.first.number === 1")
        for key in ("3", "tip_error"):
            window.ask(
                f"(f => {{ f.value = '{key}'; f.dispatchEvent(new Event('change')); }})"
                "(document.getElementById('signal'))"
            )
            assert window.ask("document.querySelectorAll('#curves .curve').length") == 1
        # 4. What is carried goes with the tip in it, and waits again where the job says once the recording is closed.
        scene = served.recordings.of(1).scene
        assert scene is not None
        (part,) = (one for one in scene.carried if one.end > one.first)
        for frame in (0, part.first + 5, (part.first + part.end) // 2, len(scene.times) - 1):
            place = window.ask(PLACE_OF_PART % (float(scene.times[frame]), scene.carried.index(part)))
            assert np.abs(np.subtract(place, part.poses[frame, :3])).max() < 1e-4
        assert np.ptp(part.poses[:, :3], axis=0).max() > 0.3
        window.ask("mafsil.store.show({ chosen: [null, null], replay: null, left: null })")
        window.wait("!mafsil.player.scenery.points.length")
        assert not window.errors
        served.server.shutdown()


PLACE_OF_PART = """(([time, k]) => {
  document.getElementById("time").value = time / mafsil.player.end;
  document.getElementById("time").dispatchEvent(new Event("input"));
  const { scenery, replay, period } = mafsil.player, tip = mafsil.store.arm.kernels.forward_kinematics(replay.q)[0];
  return Array.from(scenery.poses(replay.time / period, tip)[k].slice(12, 15));
})([%r, %r])"""


def write_when_ready(window: Browser, old: str, new: str) -> None:
    """Replace words of the job once they stand there."""
    window.wait(f"document.getElementById('job')?.value.includes({json.dumps(old)})")
    write(window, old, new)


def test_python_finds_configurations(studio: Studio, windows: tuple[Browser, Browser]) -> None:
    first, second = windows
    unfold(first, "configurations")
    T = first.ask("Array.from(mafsil.store.arm.kernels.forward_kinematics(mafsil.store.state.q)[0])")
    first.click("#find")
    first.wait("document.querySelector('#configurations button')")
    first.click("#language")
    first.click("#language")
    rows = "document.querySelectorAll('#configurations button:not(:disabled)')"
    assert first.ask(f"{rows}.length") >= 1
    first.ask(f"{rows}[0].click()")
    q = settled(studio, first, second)
    assert first.ask("mafsil.store.journal.at(-1).do") == "set_joints"
    assert np.abs(studio.arm.robot.forward_kinematics(q).ravel() - T).max() < 1e-8


def test_both_languages(windows: tuple[Browser, Browser]) -> None:
    """Every card of the studio in Arabic, right to left, and back."""
    first, _ = windows
    unfold(first, "job", "recordings", "configurations", "server")
    first.click("#language")
    assert first.ask("document.documentElement.dir") == "rtl"
    words = first.ask("document.getElementById('views').textContent")
    assert all(word in words for word in ("المهمة", "التسجيلات", "الخادم"))
    first.click("#language")
    assert "Recordings" in first.ask("document.getElementById('views').textContent")


def test_what_is_done_without_the_server_is_sent_later(tmp_path: Path) -> None:
    """The server goes and comes back at the same place: nothing that was done meanwhile is lost."""
    with Studio("planar2r", language="en") as served, Browser(tmp_path) as window:
        thread = threading.Thread(target=served.serve, daemon=True)
        thread.start()
        window.load(served.address)
        window.wait("mafsil.link.connected")
        token, port = served.server.access.token, served.server.server_port
        served.server.shutdown()
        served.server.close()
        window.wait("!mafsil.link.connected")
        act(window, 1, 0.75, gesture=False)
        with Studio("planar2r", language="en", port=port) as again:
            again.server.access = replace(again.server.access, token=token)
            threading.Thread(target=again.serve, daemon=True).start()
            window.wait("mafsil.link.connected && !mafsil.link.pending.size")
            assert again.journal.replay().q[1] == 0.75
            again.server.shutdown()


def test_a_view_of_ones_own(tmp_path: Path) -> None:
    """The file of docs/adding_a_view.md in a studio: its kernel, both languages, its action in every window."""
    text = (Path(__file__).resolve().parents[2] / "docs" / "adding_a_view.md").read_text(encoding="utf-8")
    (tmp_path / "mass.js").write_text(text.split('VIEW = """\n')[1].split('"""')[0], encoding="utf-8")
    served = studio_of(["panda"], 0, [str(tmp_path / "mass.js")])
    with served, Browser(tmp_path) as window:
        threading.Thread(target=served.serve, daemon=True).start()
        window.load(served.address)
        window.wait("mafsil.link.connected && document.getElementById('mass-height').textContent")
        robot = served.arm.robot
        shown = float(window.ask("document.getElementById('mass-height').textContent").split()[0].replace("−", "-"))
        assert shown == pytest.approx(robot.center_of_mass(served.arm.start)[2], abs=6e-5)
        window.click("#mass-middle")
        assert settled(served, window) == ((robot.limits.lower + robot.limits.upper) / 2).tolist()
        assert [one["do"] for one in served.journal.lines()] == ["set_joints"]
        title = "document.querySelector('#view-mass summary').textContent"
        first = window.ask(title)
        window.click("#language")
        assert {first, window.ask(title)} == {"Centre of mass", "مركز الكتلة"}
        assert not window.errors
        served.server.shutdown()


def test_a_view_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="missing"):
        studio_of(["panda"], 0, [str(tmp_path / "missing.js")])
