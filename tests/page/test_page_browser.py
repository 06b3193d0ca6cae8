"""The page in headless Chromium, opened from disk: real pointer and keys, both languages, replayed to the same bits."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.page import Session, show
from tests.page.browser import Browser

CONTROL = 2


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pages")
    for name in ("panda", "ur5e"):
        show(name, language="en").write(folder / f"{name}.html")
    return folder


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("chromium")) as browser:
        yield browser


@pytest.fixture
def browser(chromium: Browser) -> Iterator[Browser]:
    """A browser that made no request of its own and met no error during the test."""
    chromium.requests.clear()
    chromium.errors.clear()
    chromium.resize(1000, 640)
    yield chromium
    assert not chromium.errors
    assert all(url.startswith(("file:", "blob:")) for url in chromium.requests), chromium.requests
    assert sum(url.startswith("file:") for url in chromium.requests) == 1


def state(browser: Browser) -> dict[str, Any]:
    return browser.ask("mafsil.store.state")


def aside(browser: Browser) -> dict[str, Any]:
    """The Panda where it has another branch."""
    start = [0.8, 0.8, -0.8, -1.3201, 0.8, 1.348, -0.8]
    browser.ask(f"mafsil.store.do('set_joints', {{values: {start}}}); mafsil.stage.home()")
    return state(browser)


def tip(browser: Browser) -> tuple[float, float]:
    """Where the tip is on the screen."""
    left, top, _, _ = browser.box("#scene")
    found = browser.ask("mafsil.stage.drag.place()")
    return left + found["x"], top + found["y"]


def settle(browser: Browser) -> None:
    """Wait until what was done is drawn."""
    browser.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def enter(browser: Browser, selector: str, row: int, value: float) -> None:
    """Type a number into a field."""
    events = "f.dispatchEvent(new Event('input')); f.dispatchEvent(new Event('change'));"
    browser.ask(f"(f => {{ f.value = {value}; {events} }})(document.querySelectorAll('{selector}')[{row}])")


def slide(browser: Browser, row: int, share: float) -> None:
    """Move the slider of a joint by a share of its range, with the pointer."""
    left, top, width, height = browser.settled_box(f".joint:nth-of-type({row + 1}) input[type=range]")
    ranges = "document.querySelectorAll('.joint input[type=range]')"
    now = browser.ask(f"(e => (e.value - e.min) / (e.max - e.min))({ranges}[{row}])")
    y, start = top + height / 2, left + 8 + (width - 16) * now
    browser.drag((start, y), (start + (width - 16) * share, y))


def replayed(browser: Browser, folder: Path) -> Session:
    """The script that the page saves, run here."""
    for old in browser.downloads.iterdir():
        old.unlink()
    browser.ask("mafsil.unfold('code')")
    browser.click("#view-code [data-do=save]")
    browser.wait("true")
    for _ in range(200):
        files = [path for path in browser.downloads.iterdir() if path.suffix == ".py"]
        if files and files[0].stat().st_size:
            break
        browser.ask("new Promise(done => setTimeout(done, 30))")
    scope: dict[str, Any] = {}
    exec(files[0].read_text(encoding="utf-8"), scope)
    return scope["arm"]


def test_slide_drag_choose_push_and_replay(browser: Browser, pages: Path, tmp_path: Path) -> None:
    """Everything that a first visitor does; then the saved script gives the same state to the last bit."""
    browser.load(pages / "panda.html")
    begin = aside(browser)
    # 1. Slide.
    slide(browser, 1, -0.12)
    slid = state(browser)
    assert slid["q"][1] < begin["q"][1] - 0.2
    assert [q for k, q in enumerate(slid["q"]) if k != 1] == [q for k, q in enumerate(begin["q"]) if k != 1]
    # 2. Drag the tool.
    x, y = tip(browser)
    browser.drag((x, y), (x - 30, y + 24))
    dragged = state(browser)
    assert dragged["status"] == "solved"
    near = tip(browser)
    assert np.hypot(near[0] - x + 30, near[1] - y - 24) < 3
    # 3. Choose another branch by its label in the picture.
    browser.ask("mafsil.store.show({ghosts: true})")
    browser.wait("document.querySelector('#labels button')")
    row = int(browser.ask("document.querySelector('#labels button').dataset.row"))
    T = browser.ask("Array.from(mafsil.store.arm.kernels.tip_pose(mafsil.store.state.q)[0])")
    browser.click("#labels button")
    chosen = state(browser)
    assert np.abs(np.subtract(chosen["q"], dragged["q"])).max() > 0.1
    assert browser.ask("mafsil.store.journal.at(-1)") == {"do": "choose", "with": {"branch": row}}
    assert np.abs(mf.load("panda").forward_kinematics(chosen["q"]).ravel() - T).max() < 1e-9
    # 4. Keys move the tool.
    browser.ask("document.getElementById('scene').focus()")
    browser.key("ArrowUp", modifiers=CONTROL)
    assert browser.ask("mafsil.store.journal.at(-1).do") == "reach"
    # 5. The closed loop, pushed.
    browser.ask("mafsil.unfold('loop')")
    browser.click("#loop")
    browser.wait("mafsil.store.state.ticks > 100")
    enter(browser, ".forces input", 1, 40)
    browser.wait("mafsil.store.state.push[4] === 40")
    ticks = state(browser)["ticks"]
    browser.wait(f"mafsil.store.state.ticks > {ticks + 150}")
    pushed = state(browser)
    assert np.abs(np.subtract(pushed["q"], pushed["goal"])).max() > 1e-3
    browser.click("#loop")
    # 6. Save, replay.
    settle(browser)
    end = state(browser)
    browser.ask("mafsil.unfold('code')")
    settle(browser)
    lines = browser.ask("document.getElementById('journal').textContent").splitlines()
    assert [line.partition("(")[0] for line in lines if line.startswith("arm.")] == [
        "arm.set_joints", "arm.set_joint", "arm.reach", "arm.choose", "arm.reach",
        "arm.loop", "arm.simulate", "arm.push", "arm.simulate", "arm.loop",
    ]  # fmt: skip
    session = replayed(browser, tmp_path)
    assert session.q.tobytes() == np.array(end["q"], dtype=np.float64).tobytes()
    assert np.array(session.state.goal).tobytes() == np.array(end["goal"], dtype=np.float64).tobytes()


def test_the_free_joint_swings_while_the_tool_stays(browser: Browser, pages: Path, tmp_path: Path) -> None:
    """The slider of joint 7: the tip keeps its pose, one line for the gesture; at the end of the others a sentence."""
    browser.load(pages / "panda.html")
    T = browser.ask("Array.from(mafsil.store.arm.kernels.tip_pose(mafsil.store.state.q)[0])")
    start = state(browser)["q"]
    left, top, width, height = browser.settled_box("#swing-6")
    low, high = browser.ask("(e => [Number(e.min), Number(e.max)])(document.getElementById('swing-6'))")
    x, y = left + 8 + (width - 16) * (start[6] - low) / (high - low), top + height / 2
    browser.drag((x, y), (x + 0.06 * width, y))
    swung = state(browser)
    assert swung["status"] == "solved"
    assert 0.1 < swung["q"][6] - start[6] < 0.6
    assert np.abs(mf.load("panda").forward_kinematics(swung["q"]).ravel() - T).max() < 1e-8
    assert [one["do"] for one in browser.ask("mafsil.store.journal")] == ["swing"]
    settle(browser)
    assert replayed(browser, tmp_path).q.tobytes() == np.array(swung["q"], dtype=np.float64).tobytes()
    # Farther than the other joints can follow: the arm stays where it could still go, and the reason is said.
    browser.ask("(f => { f.value = f.max; f.dispatchEvent(new Event('input')); })(document.getElementById('swing-6'))")
    browser.wait("!document.getElementById('status').hidden")
    assert state(browser)["q"] == swung["q"]
    browser.ask("document.getElementById('swing-6').dispatchEvent(new Event('change'))")
    browser.wait("document.getElementById('status').hidden")


def test_out_of_reach_says_why(browser: Browser, pages: Path) -> None:
    """The tool goes along the boundary; the reason is a sentence with the numbers that prove it; one line."""
    browser.load(pages / "ur5e.html")
    left, top, width, _ = browser.box("#scene")
    browser.ask("mafsil.stage.camera.zoom(3); mafsil.store.show({ghosts: false})")
    settle(browser)
    x, y = tip(browser)
    browser.mouse("mousePressed", x, y, buttons=1)
    away = (
        "(T => Math.hypot(...[3, 7, 11].map(k => T[k] - mafsil.store.shown.wish[k])))"
        "(mafsil.store.arm.kernels.forward_kinematics(mafsil.store.state.q)[0])"
    )
    gaps = []
    for right in (200, 100, 4):
        browser.mouse("mouseMoved", left + width - right, top + 4, buttons=1)
        settle(browser)
        gaps.append(browser.ask(away))
        q = state(browser)["q"]
        assert browser.ask(f"mafsil.store.arm.settings.lower.every((low, k) => low <= {q}[k])")
    assert max(np.diff(gaps)) > 0
    assert len({tuple(np.round(tip(browser), 1)), (round(x, 1), round(y, 1))}) == 2, "it follows as far as it can"
    browser.wait("!document.getElementById('status').hidden")
    text = browser.ask("document.getElementById('status').textContent")
    assert text.startswith("out of reach: ")
    numbers = [float(word) for word in text.split() if word.replace(".", "").isdigit()]
    assert numbers[0] > numbers[1]
    browser.mouse("mouseReleased", left + width - 4, top + 4)
    settle(browser)
    assert browser.ask("document.getElementById('status').textContent") == text, (
        "the reason stays until the next action"
    )
    assert [one["do"] for one in browser.ask("mafsil.store.journal")] == ["reach"]


def test_languages_are_switched_live(browser: Browser, pages: Path) -> None:
    """Every sentence changes, the direction too; the state stays, mathematics and numbers keep their direction."""
    browser.load(pages / "panda.html")
    slide(browser, 2, 0.1)
    before = state(browser)
    browser.click("#language")
    assert browser.ask("[document.documentElement.lang, document.documentElement.dir]") == ["ar", "rtl"]
    assert state(browser) == before
    words = browser.ask(
        "[...document.querySelectorAll('summary, button.quiet:not(#units *, #theme, #menu), p.soft')]"
        ".map(e => e.textContent)"
    )
    assert all(any("\u0600" <= c <= "\u06ff" for c in word) or word == "English" for word in words), words
    browser.ask("mafsil.unfold('pose')")
    assert browser.ask("getComputedStyle(document.querySelector('#view-pose math')).direction") == "ltr"
    assert browser.ask("[...document.querySelectorAll('.joint bdi')].every(e => e.dir === 'ltr')")
    assert browser.ask("document.querySelectorAll('#view-pose mn').length") == 16
    assert browser.ask("document.getElementById('view-pose').open")
    browser.click("#language")
    assert browser.ask("[document.documentElement.lang, document.documentElement.dir]") == ["en", "ltr"]
    assert browser.ask("document.getElementById('view-pose').open")


def test_numbers_that_are_shown_are_those_of_python(browser: Browser, pages: Path) -> None:
    """Matrix, Jacobian, manipulability, gravity: what stands on the page against the robot's own."""
    browser.load(pages / "panda.html")
    for name in ("pose", "jacobian", "gravity", "dh"):
        browser.ask(f"mafsil.unfold('{name}')")
        settle(browser)
    browser.wait("document.querySelectorAll('#view-pose mn')[15].textContent === '1.0000'")
    browser.wait("document.querySelector('#view-jacobian dd').textContent")
    browser.wait("document.querySelector('#view-gravity .value').textContent")
    robot, q = mf.load("panda"), np.array(state(browser)["q"])
    read = "[...document.querySelectorAll('{}')].map(e => Number(e.textContent.replace('−', '-')))"
    settle(browser)
    assert (
        np.abs(np.array(browser.ask(read.format("#view-pose mn"))) - robot.forward_kinematics(q).ravel()).max() < 6e-5
    )
    J = robot.jacobian_body(q)
    assert np.abs(np.array(browser.ask(read.format("#view-jacobian mn"))) - J.ravel()).max() < 6e-5
    shown = browser.ask("[...document.querySelectorAll('#view-jacobian dd')].map(e => e.textContent)")
    assert np.allclose([float(x) for x in shown[0].split()], np.linalg.svd(J, compute_uv=False), atol=6e-4)
    assert float(shown[1]) == pytest.approx(np.sqrt(np.linalg.det(J @ J.T)), abs=6e-5)
    assert np.abs(np.array(browser.ask(read.format("#view-gravity .value"))) - robot.gravity_torque(q)).max() < 6e-3
    assert browser.ask("document.querySelectorAll('#view-dh tbody tr').length") == 7
    frames = browser.ask("(mafsil.store.show({frame: 6}), 1)")
    assert frames == 1


def test_a_typed_pose_is_reached(browser: Browser, pages: Path) -> None:
    browser.load(pages / "ur5e.html")
    browser.ask("mafsil.unfold('pose')")
    browser.wait("document.querySelectorAll('#view-pose input')[2].value")
    z = float(browser.ask("document.querySelectorAll('#view-pose input')[2].value"))
    enter(browser, "#view-pose input", 2, z - 0.05)
    assert state(browser)["status"] == "solved"
    assert mf.load("ur5e").forward_kinematics(state(browser)["q"])[2, 3] == pytest.approx(z - 0.05, abs=2e-4)


def test_undo_goes_back(browser: Browser, pages: Path) -> None:
    browser.load(pages / "ur5e.html")
    begin = state(browser)
    slide(browser, 0, 0.2)
    assert state(browser) != begin
    browser.click("#undo")
    assert state(browser) == begin


@pytest.mark.parametrize("ending", ["", "#flat"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_picture_is_drawn(browser: Browser, pages: Path, tmp_path: Path, scheme: str, ending: str) -> None:
    """With WebGL and without, light and dark: the robot's colours are on the canvas."""
    browser.resize(1000, 640, scheme=scheme)
    browser.load(pages / f"{'ur5e' if ending else 'panda'}.html", ending)
    assert browser.ask("mafsil.stage.kind") == ("flat" if ending else "light")
    count = browser.ask(
        "(() => { const c = document.createElement('canvas'), s = document.getElementById('scene');"
        " c.width = 90; c.height = 60; const x = c.getContext('2d');"
        " mafsil.stage.paint(); x.drawImage(s, 0, 0, 90, 60);"
        " return new Set(new Uint32Array(x.getImageData(0, 0, 90, 60).data.buffer)).size; })()"
    )
    assert count > 60
    browser.picture(tmp_path / "page.png")


VEILED = 240
"""Of 14,400 places of the picture, some 2,400 of which show the arm."""


def test_a_ghost_in_the_place_of_the_arm_leaves_its_colours(browser: Browser, pages: Path) -> None:
    """At its start the Panda has a branch that stands where the arm does but for a roll: hardly a place turns green."""
    browser.load(pages / "panda.html")
    aside(browser)
    count = (
        "(() => { const c = document.createElement('canvas'), s = document.getElementById('scene');"
        " c.width = c.height = 120; const x = c.getContext('2d'); mafsil.stage.paint(); x.drawImage(s, 0, 0, 120, 120);"
        " const p = x.getImageData(0, 0, 120, 120).data; let n = 0;"
        " for (let k = 0; k < p.length; k += 4) n += p[k + 1] > p[k] + 12; return n; })()"
    )
    browser.ask("mafsil.store.show({ghosts: true})")
    with_ghosts = browser.ask(count)
    assert browser.ask("mafsil.stage.named.length") == 1
    browser.ask("mafsil.store.show({ghosts: false})")
    assert browser.ask(count) <= with_ghosts < browser.ask(count) + VEILED


def bar_of_a_phone(browser: Browser) -> None:
    """One row, from which nothing stands out; the rest behind one button; what is pressed at least 24 pixels large."""
    for _ in ("en", "ar"):
        assert browser.ask("document.getElementById('top').clientHeight") <= 50
        for opens in (True, False):
            browser.click("#menu")
            assert browser.ask("document.getElementById('menu').ariaExpanded") == str(opens).lower()
            assert browser.ask("document.getElementById('settings').checkVisibility()") is opens
            assert browser.ask("document.documentElement.scrollWidth <= screen.width")
            assert browser.small_targets() == []
        browser.ask("mafsil.speak()")


@pytest.mark.parametrize("width", [360, 412])
def test_on_a_phone_nothing_is_wider_than_the_screen(browser: Browser, pages: Path, width: int) -> None:
    browser.resize(width, 800, phone=True)
    browser.load(pages / "panda.html")
    for name in ("pose", "jacobian", "gravity", "loop", "dh"):
        browser.ask(f"mafsil.unfold('{name}')")
    left, _, wide, height = browser.box("#stage")
    assert left >= 0
    assert wide >= width - 60
    assert height >= 250
    bar_of_a_phone(browser)


def test_every_control_has_a_name_and_is_reached_by_keys(browser: Browser, pages: Path) -> None:
    browser.load(pages / "panda.html")
    nameless = browser.ask(
        "[...document.querySelectorAll('button, input, canvas, pre')].filter(e => !(e.getAttribute('aria-label') ||"
        " e.textContent.trim() || e.closest('label')?.textContent.trim())).map(e => e.outerHTML)"
    )
    assert nameless == []
    seen: set[str] = set()
    for _ in range(24):
        browser.key("Tab")
        seen.add(browser.ask("document.activeElement.id || document.activeElement.tagName"))
    assert {"scene", "language", "INPUT", "SUMMARY"} <= seen


def test_a_hostile_name_stays_a_name(browser: Browser, tmp_path: Path) -> None:
    """Names come from files of strangers: they become text and never markup, script or direction."""
    name = "</script><img src=x onerror=alert(1)> \u202e'\"&"
    mechanism = replace(mf.load("planar2r").mechanism, name=name)
    show(mf.Robot(mechanism)).write(tmp_path / "hostile.html")
    browser.load(tmp_path / "hostile.html")
    assert browser.ask("document.querySelectorAll('img').length") == 0
    assert "onerror=alert(1)" in browser.ask("document.querySelector('h1').textContent")
    assert "\u202e" not in browser.ask("document.querySelector('h1').textContent")


def test_in_a_notebook_it_runs_in_a_frame_of_its_own(browser: Browser, tmp_path: Path) -> None:
    """What a notebook shows under the cell: a sandboxed frame, whose page draws and cannot reach the page around it."""
    frame = show("planar3r")._repr_html_()
    reply = (
        "<script>window.mafsil = {timing: {frames: 1}}; const f = document.querySelector('iframe');"
        " window.reached = false; f.onload = () => { try { window.reached = Boolean(f.contentDocument.body); }"
        " catch { window.reached = false; } window.loaded = true; };</script>"
    )
    (tmp_path / "notebook.html").write_text(f"<!doctype html><body>{frame}{reply}</body>", encoding="utf-8")
    browser.load(tmp_path / "notebook.html")
    browser.wait("window.loaded || document.readyState === 'complete'")
    assert browser.ask("window.reached") is False
    assert "allow-same-origin" not in frame
    browser.picture(tmp_path / "notebook.png")


def test_ten_minutes_of_the_loop_leave_no_growth(browser: Browser, pages: Path) -> None:
    """600,000 ticks in the pieces in which frames ask for them: one line of the journal, no more memory."""
    browser.load(pages / "ur5e.html")
    browser.ask("mafsil.store.do('loop', {closed: true}); mafsil.store.do('push', {wrench: [0, 0, 0, 5, 0, 0]});")
    run = "for (let k = 0; k < {}; k++) mafsil.store.do('simulate', {{ticks: 16}}, {{gesture: true}});"
    browser.ask(run.format(2000))
    before = browser.memory()
    browser.ask(run.format(35500))
    after = browser.memory()
    assert state(browser)["ticks"] == 600_000
    assert browser.ask("mafsil.store.journal.length") == 3
    assert after - before < 1_000_000


def test_ten_minutes_of_pictures_leave_no_growth(browser: Browser, pages: Path) -> None:
    """36,000 frames of the closed loop, ten minutes at 60 a second, every card open: no more memory, no more listeners.

    Frames are led by the test instead of the screen, one right after the other. Pixels are left out, which software
    would need an hour for; all that the picture is made of is built each time.
    """
    browser.load(pages / "ur5e.html")
    browser.ask("document.querySelectorAll('details').forEach(card => { card.open = true; })")
    settle(browser)
    browser.ask("window.requestAnimationFrame = () => 0; mafsil.stage.renderer.render = () => {};")
    browser.ask("document.getElementById('loop').click(); mafsil.store.do('push', {wrench: [0, 0, 0, 5, 0, 0]});")
    browser.ask("window.moment = performance.now();")
    run = "for (let k = 0; k < 1000; k++) mafsil.frame(window.moment += 1000 / 60);"

    def pictures(thousands: int) -> tuple[int, int, int]:
        for k in range(thousands):
            plotted = "true" if k % 12 == 0 else "false"  # six joints over ten seconds: most of the time of a frame
            browser.ask(f"document.getElementById('view-plot').open = {plotted}")
            browser.ask(run)
        return browser.memory(), browser.counted("JSEventListeners"), browser.counted("Nodes")

    before = pictures(2)
    begin = state(browser)["ticks"]
    after = pictures(36)
    assert state(browser)["ticks"] - begin == pytest.approx(600_000, abs=2)
    assert browser.ask("mafsil.store.journal.length") == 3
    assert after[0] - before[0] < 1_000_000
    assert after[1] <= before[1]
    assert after[2] <= before[2] + 100


def test_a_robot_of_prismatic_joints_and_one_without_closed_form(browser: Browser, tmp_path: Path) -> None:
    """The page of any robot: search where there is no closed form, no loads where there are no masses."""
    for name in ("scara_rrrp", "rrprrr", "spatial3r"):
        show(name).write(tmp_path / f"{name}.html")
        browser.requests.clear()
        browser.load(tmp_path / f"{name}.html")
        x, y = tip(browser)
        browser.drag((x, y), (x - 12, y + 8))
        assert (state(browser)["status"] == "solved") == (browser.ask("mafsil.store.journal.length") == 1)
        assert name != "scara_rrrp" or state(browser)["status"] == "solved"
        assert not browser.errors


def test_a_view_of_ones_own(browser: Browser, tmp_path: Path) -> None:
    """The file of docs/page.md: its card stands in its place, in both languages, and follows the arm."""
    text = (Path(__file__).resolve().parents[2] / "docs" / "page.md").read_text(encoding="utf-8")
    (tmp_path / "height.js").write_text(text.split("write_text('''\n")[1].split("'''")[0], encoding="utf-8")
    show("panda", language="en", views=[tmp_path / "height.js"]).write(tmp_path / "own.html")
    browser.load(tmp_path / "own.html")
    assert browser.ask("[...document.querySelectorAll('details')].map(e => e.id).slice(0, 3)") == [
        "view-joints", "view-height", "view-pose",
    ]  # fmt: skip
    slide(browser, 1, -0.1)
    settle(browser)
    shown = float(browser.ask("document.querySelector('#view-height bdi').textContent").split()[0].replace("−", "-"))
    assert shown == pytest.approx(mf.load("panda").forward_kinematics(state(browser)["q"])[2, 3], abs=6e-5)
    browser.click("#language")
    assert browser.ask("document.querySelector('#view-height summary').textContent") == "ارتفاع الأداة"


def test_a_view_with_its_own_kernel_and_action(browser: Browser, tmp_path: Path) -> None:
    """The file of docs/adding_a_view.md: its kernel, its action as lines of the journal, the same bits in Python."""
    text = (Path(__file__).resolve().parents[2] / "docs" / "adding_a_view.md").read_text(encoding="utf-8")
    (tmp_path / "mass.js").write_text(text.split('VIEW = """\n')[1].split('"""')[0], encoding="utf-8")
    show("panda", language="en", views=[tmp_path / "mass.js"]).write(tmp_path / "mass.html")
    browser.load(tmp_path / "mass.html")
    slide(browser, 1, -0.1)
    settle(browser)
    shown = float(browser.ask("document.getElementById('mass-height').textContent").split()[0].replace("−", "-"))
    robot = mf.load("panda")
    assert shown == pytest.approx(robot.center_of_mass(state(browser)["q"])[2], abs=6e-5)
    browser.click("#mass-middle")
    q = (robot.limits.lower + robot.limits.upper) / 2
    assert np.array(state(browser)["q"]).tobytes() == q.tobytes()
    assert [one["do"] for one in browser.ask("mafsil.store.journal")] == ["set_joint", "set_joints"]
    settle(browser)
    assert replayed(browser, tmp_path).q.tobytes() == q.tobytes()
    browser.click("#language")
    assert browser.ask("document.querySelector('#view-mass summary').textContent") == "مركز الكتلة"
    refused = "(() => { try { mafsil.store.learn({push: () => []}); return ''; } catch (e) { return e.message; } })()"
    assert browser.ask(refused) == "two actions are called push"


def test_the_loop_is_plotted(browser: Browser, pages: Path) -> None:
    """Joints over time are kept while the loop is closed and the card is open, and drawn in their colours."""
    browser.load(pages / "ur5e.html")
    browser.ask("mafsil.unfold('plot')")
    browser.ask("document.getElementById('loop').click(); mafsil.store.do('push', {wrench: [0, 0, 0, 0, 30, 10]})")
    browser.wait("mafsil.history.length > 12")
    browser.ask("document.getElementById('plot-values').click()")
    settle(browser)
    seen = browser.ask(
        "(() => { const c = document.querySelector('.curves');"
        " const pixels = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
        " return new Set(new Uint32Array(pixels.buffer)).size; })()"
    )
    assert seen > 20
    kept = browser.ask("[mafsil.history.at(0, 0), mafsil.history.at(mafsil.history.length - 1, 0)]")
    assert kept[1] > kept[0]
    browser.ask("document.getElementById('loop').click()")
    settle(browser)
    assert browser.ask("mafsil.history.length") == 0


def test_names_of_ghosts_stay_in_the_picture_of_a_phone(browser: Browser, pages: Path) -> None:
    """Where names would hide the arm, numbers stand; those of the list, with the name as label."""
    browser.resize(390, 800, phone=True)
    browser.load(pages / "ur5e.html")
    browser.ask("mafsil.store.show({ghosts: true})")
    for _ in range(2):
        settle(browser)
        labels = browser.ask(
            "[...document.querySelectorAll('#labels button:not([hidden])')].map(e => {"
            " const b = e.getBoundingClientRect(),"
            " s = document.getElementById('stage').getBoundingClientRect(); return [e.textContent, e.ariaLabel,"
            " b.left >= s.left && b.right <= s.right && b.top >= s.top && b.bottom <= s.bottom]; })"
        )
        assert labels
        assert all(text.isdigit() and len(name) > 3 and inside for text, name, inside in labels), labels
        browser.ask("mafsil.speak()")


def opened(browser: Browser, text: str) -> str:
    """Choose a file with this text; what the page says then."""
    browser.ask(
        "(text => { const carried = new DataTransfer(), input = document.getElementById('script');"
        " carried.items.add(new File([text], 'script.py')); input.files = carried.files;"
        " document.querySelector('#view-code [role=status]').textContent = '';"
        f" input.dispatchEvent(new Event('change')); }})({json.dumps(text)})"
    )
    said = "document.querySelector('#view-code [role=status]').textContent"
    browser.wait(said)
    return browser.ask(said)


def test_a_script_opens_in_the_page(browser: Browser, pages: Path) -> None:
    """What Python did the page does again, to the last bit; what it does not understand leaves all as it was."""
    lines = [
        "arm.set_joint(joint=3, value=-1.2)", "arm.choose(branch=2)",
        "arm.search(position=[0.4, 0.2, 0.5], quaternion=[0, 1, 0, 0])", "arm.loop(closed=True)",
        "arm.push(wrench=[0, 0, 0, 0, 20, 0])", "arm.simulate(ticks=250)",
    ]  # fmt: skip
    text = "from mafsil.page import Session\n\narm = Session('panda')\n" + "\n".join(lines)
    scope: dict[str, Any] = {}
    exec(text, scope)
    browser.load(pages / "panda.html")
    slide(browser, 1, 0.1)
    assert opened(browser, text).startswith("opened: 6")
    end = state(browser)
    assert np.array(end["q"], dtype=np.float64).tobytes() == scope["arm"].q.tobytes()
    browser.ask("mafsil.unfold('code')")
    settle(browser)
    shown = browser.ask("document.getElementById('journal').textContent").splitlines()
    assert [line.split("(")[0] for line in shown[3:]] == [line.split("(")[0] for line in lines]
    for bad in ("arm.set_joint(joint=9, value=0)", "arm.push(wrench=[1])", "arm.set_joint(-1, 0)", "import os"):
        assert opened(browser, text + "\n" + bad).startswith("line 10 ")
        assert state(browser) == end
    assert "'ur5e'" in opened(browser, text.replace("panda", "ur5e"))


def test_a_changed_table_draws_its_arm(browser: Browser, pages: Path) -> None:
    """An edited row: the new arm's skeleton, its distance, its Python; back to the arm that is."""
    browser.load(pages / "panda.html")
    browser.ask("mafsil.unfold('dh')")
    browser.wait("document.querySelector('#view-dh input').value")
    before = browser.ask("mafsil.stage.items().length")
    enter(browser, "#view-dh input", 4 * 2 + 2, 0.5)
    browser.wait("document.getElementById('dh-code').textContent")
    assert browser.ask("mafsil.stage.items().length") > before + 20
    scope: dict[str, Any] = {}
    exec(browser.ask("document.getElementById('dh-code').textContent"), scope)
    q = state(browser)["q"]
    tips = [robot.forward_kinematics(q)[:3, 3] for robot in (mf.load("panda"), scope["robot"])]
    shown = float(browser.ask("document.querySelector('#view-dh p bdi').textContent").split()[0])
    assert shown == pytest.approx(np.linalg.norm(tips[0] - tips[1]), abs=6e-5)
    assert shown > 0.1
    browser.click("#dh-back")
    assert browser.ask("mafsil.stage.items().length") == before


def test_a_grasp_is_drawn_and_judged(browser: Browser, pages: Path) -> None:
    """Friction slides it from held to not held, with the wrench that proves it; a finger is dragged and led by keys."""
    browser.load(pages / "ur5e.html")
    browser.ask("mafsil.unfold('grasp')")
    code = "document.getElementById('grasp-code').textContent"
    browser.wait(code)
    assert browser.ask("document.querySelector('.verdict').textContent").startswith("force closure")
    assert browser.ask("document.querySelectorAll('.grasp .wrench *').length") == 0
    enter(browser, "#friction", 0, 0)
    browser.wait("document.querySelector('.verdict.open')")
    assert browser.ask("document.querySelectorAll('.grasp .wrench *').length") == 2
    scope: dict[str, Any] = {}
    exec(browser.ask(code), scope)
    assert not scope["grasp"].closure()
    before = browser.ask("mafsil.grasp.fingers[0]")
    left, top, width, height = browser.box(".grasp circle")
    x, y = left + width / 2, top + height / 2
    browser.drag((x, y), (x + 40, y + 6))
    assert browser.ask("mafsil.grasp.fingers[0]") > before + 0.1
    dragged = browser.ask("mafsil.grasp.fingers[0]")
    browser.key("ArrowRight")
    assert browser.ask("mafsil.grasp.fingers[0]") == pytest.approx(dragged + 0.02)
    browser.click("[data-do=finger_more]")
    browser.wait("document.querySelectorAll('.grasp circle').length === 3")
