"""Things of a job that are placed by the pointer: only the numbers of their place change, and they mean that place."""

from __future__ import annotations

import json
import threading
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mafsil.geometry import rotation
from mafsil.job.language.reading import parse_job
from mafsil.report.replay import waiting_scene
from mafsil.studio.opening import robot_of_job, studio_of
from mafsil.studio.placing import is_placed, placeable, placed_text, things_data
from tests.page.browser import Browser
from tests.page.test_application import HANDLE, SETTLED, WALL

JOBS = sorted(Path("examples/jobs").glob("*.toml"))
POLISH = WALL.with_name("polish_a_plate_puma560.toml")
MANY_WAYS = """
robot = "ur5e"
angles = "{angles}"
lengths = "{lengths}"

[frame.cell] # position = [9, 9, 9], of nothing
position = [{far}, 0, 0]
rpy = [0, 0, {quarter}]

[[obstacle]]
name = "dotted" # rpy = [7, 7, 7]
box = [{near}, {near}, {near}]
position = [
  {far}, # x
  0, 0,
]

[[obstacle]]
frame = "cell"
sphere = {near}
position = [0, {near}, 0]

[[surface]]
normal = [0, 0, 2]
point = [0, 0, {near}]
stiffness = 1e4

[[surface]]
sphere = {near}
point = [0, {far}, {near}]
stiffness = 1e4

[[guide]]
point = [0, {far}, {near}]
direction = [0, 1, 0]
stiffness = 1e3

[[move]]
pose = {{ rpy = [{half}, 0, 0], position = [{far}, {near}, {near}] }}
[[move]]
pose.position = [{far}, {near}, {far}]
[[move]]
relative = "tool"
position = [0, 0, {near}]
[[move]]
[move.pose]
frame = "cell"
position = [{near}, 0, {far}]
[[move]]
pose = {{ position = [{far}, 0, {near}], look_at = [{far}, 0, 0] }}
[[move]]
pose = {{ quaternion = [0, 1, 0, 0], position = [{far}, 0, {near}] }}
"""
NUMBERS: dict[str, Any] = {"metres": {"near": 0.1, "far": 0.4}, "millimetres": {"near": 100, "far": 400}}
TURNS: dict[str, Any] = {"degrees": {"quarter": 90, "half": 180}, "radians": {"quarter": 1.5708, "half": 3.1416}}


def texts() -> dict[str, tuple[str, str, Path]]:
    """Every example, and a job that says poses in every way there is, in all units."""
    found = {path.stem: (path.read_text(encoding="utf-8"), path.name, path.parent) for path in JOBS}
    for lengths, angles in (("metres", "degrees"), ("millimetres", "degrees"), ("millimetres", "radians")):
        text = MANY_WAYS.replace(
            'relative = "tool"\nposition = [0, 0, {near}]', 'pose = {{ relative = "tool", position = [0, 0, {near}] }}'
        )
        text = text.format(lengths=lengths, angles=angles, **NUMBERS[lengths], **TURNS[angles])
        found[f"{lengths} {angles}"] = text, "job.toml", Path()
    return found


def without_numbers(data: Any) -> Any:
    """The same with every list of numbers as long as it is, and without orientations, which may be added."""
    if isinstance(data, dict):
        turns = ("rpy", "quaternion", "look_at")
        return {key: without_numbers(value) for key, value in data.items() if key not in turns}
    if isinstance(data, list):
        plain = all(isinstance(one, int | float) for one in data)
        return len(data) if plain else [without_numbers(one) for one in data]
    return data


@pytest.mark.parametrize("name", texts())
def test_a_thing_is_where_it_was_placed_and_nothing_else_has_changed(name: str, tmp_path: Path) -> None:
    text, source, folder = texts()[name]
    (tmp_path / "job.toml").write_text(text, encoding="utf-8")
    robot, rng = robot_of_job(folder / source if folder != Path() else tmp_path / "job.toml"), np.random.default_rng(4)
    job = parse_job(text, source, folder=folder)
    things = placeable(job, text)
    goals = sum(move.pose is not None and move.pose.relative is None for move in job.move)
    around = len((*job.obstacle, *job.surface, *job.guide, *job.hole))
    named = name in ("conveyor_panda", "pallet_panda")  # whose targets have names, and stand once
    assert len(things) == goals + around or (named and len(things) < goals + around)
    for turns in (False, True):
        scene = waiting_scene(job, robot, folder, text)
        for thing, data in zip(things, things_data(job, things), strict=False):
            before = thing.pose(scene)
            after = np.array(before)
            after[:3, 3] += 0.01 * rng.integers(-9, 9, 3)
            if turns and data["turns"]:
                after[:3, :3] = rotation.exp(rng.normal(size=3)) @ after[:3, :3]
            new = placed_text(text, job, thing, before, after)
            again = parse_job(new, source, folder=folder)
            assert is_placed(thing, waiting_scene(again, robot, folder, new), before, after), (thing, new)
            assert without_numbers(tomllib.loads(new)) == without_numbers(tomllib.loads(text))
            assert len(set(text.splitlines()) - set(new.splitlines())) <= 4
            assert new.count("#") == text.count("#") - ("# x" in text and "# x" not in new)
            if not turns:
                assert tomllib.loads(new).keys() == tomllib.loads(text).keys()
                assert new.count("rpy") == text.count("rpy"), "what was not turned keeps what it says"


def test_parts_go_with_the_target_at_which_they_are_taken() -> None:
    text = Path("examples/jobs/around_a_wall_panda.toml").read_text(encoding="utf-8")
    job = parse_job(text)
    things = placeable(job, text)
    (part,) = [one for one in things_data(job, things) if one["kind"] == "part"]
    assert things[part["leads"]].keys == ("move", 1, "pose")


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("placing"), (1280, 800)) as window:
        yield window
        assert not window.errors


def grab(browser: Browser, thing: int, by: tuple[float, float] = (0, 0)) -> None:
    """Press at the dot or the origin of a thing of the job, and lead it by so many pixels."""
    left, top, _, _ = browser.box("#scene")
    at = f"[3, 7, 11].map(r => mafsil.player.scenery.gripOf({thing})[r])"
    found = browser.ask(f"mafsil.stage.camera.project({at}, mafsil.stage.width, mafsil.stage.height)")
    x, y = left + found["x"], top + found["y"]
    browser.drag((x, y), (x + by[0], y + by[1]))


def turn(browser: Browser, axis: int) -> None:
    """Lead a ring of what is held by 0.4 rad."""
    left, top, _, _ = browser.box("#scene")
    for share in np.arange(0.3, 6.0, 0.5):
        (x, y), (u, v) = browser.ask(f"{HANDLE}('turn', {axis}, {share})")
        browser.mouse("mouseMoved", left + x + 1, top + y)
        browser.mouse("mouseMoved", left + x, top + y)
        if browser.ask("[mafsil.stage.handle?.kind, mafsil.stage.handle?.axis]") == ["turn", axis]:
            browser.drag((left + x, top + y), (left + u, top + v))
            return
    raise AssertionError("no place of the ring is free")


def test_things_of_a_job_are_turned_shifted_and_brought_back(browser: Browser) -> None:
    """By rings, by the dot of a part; the text says so, undo brings both back, in the order in which they were done."""
    browser.resize(1280, 800)
    for path, name, table in ((WALL, "wall", "obstacle"), (POLISH, "plate", "surface")):
        with studio_of([str(path)], 0) as studio:
            threading.Thread(target=studio.serve, daemon=True).start()
            browser.load(studio.address)
            browser.wait(
                "mafsil.tab === 'job' && mafsil.player.scenery?.things.length && mafsil.store.journal.length === 1"
            )
            browser.ask("mafsil.stage.home()")
            browser.ask(SETTLED)
            first = text = studio.jobs.job["text"]
            kinds = browser.ask("mafsil.player.scenery.things.map(({ kind }) => kind)")
            thing = kinds.index("around") + [one.name for one in getattr(parse_job(text), table)].index(name)
            grab(browser, thing)
            assert browser.ask("mafsil.store.shown.selected") == thing
            for axis in (0, 2) if table == "obstacle" else (0,):
                before = np.reshape(browser.ask(f"mafsil.player.scenery.gripOf({thing})"), (4, 4))
                turn(browser, axis)
                wanted = np.reshape(browser.ask(f"mafsil.player.scenery.gripOf({thing})"), (4, 4))
                change = before[:3, :3].T @ wanted[:3, :3]
                assert np.allclose(change @ np.eye(3)[axis], np.eye(3)[axis], atol=1e-5)
                assert np.arccos((np.trace(change) - 1) / 2) > 0.1
                browser.wait(f"mafsil.link.heard.get('job').text !== {json.dumps(text)}")
                text = studio.jobs.job["text"]
                now = getattr(parse_job(text), table)[0 if table == "surface" else 1]
                if table == "surface":
                    assert now.normal == pytest.approx(wanted[:3, 2], abs=2e-6)
                else:
                    R = np.asarray(rotation.from_rpy(np.radians(now.rpy)))
                    assert np.allclose(R, wanted[:3, :3], atol=1e-5)
                    assert now.position == pytest.approx([0.6, 0.0, 0.225], abs=1e-6)
                browser.ask(SETTLED)
            if table == "obstacle":
                part, leads = kinds.index("part"), 1
                browser.ask("mafsil.store.do('set_joint', { joint: 0, value: 0.1 })")
                at = np.array(browser.ask(f"mafsil.player.scenery.gripOf({part})"))[[3, 7, 11]]
                grab(browser, part, (25, -40))
                browser.wait(f"mafsil.link.heard.get('job').text !== {json.dumps(text)}")
                moved = np.array(browser.ask(f"mafsil.player.scenery.gripOf({part})"))[[3, 7, 11]] - at
                assert np.linalg.norm(moved) > 0.02
                assert np.allclose(moved / 0.005, np.round(moved / 0.005), atol=1e-3)
                target = parse_job(studio.jobs.job["text"]).move[leads].pose
                assert target.position == pytest.approx(np.add([0.45, 0.30, 0.10], moved), abs=2e-6)
                browser.click("#undo")
                browser.wait(f"mafsil.link.heard.get('job').text === {json.dumps(text)}")
                assert browser.ask("mafsil.store.state.q[0]") == 0.1
                browser.click("#undo")
                assert browser.ask("mafsil.store.state.q[0]") != 0.1
                browser.click("#undo")
            browser.click("#undo")
            browser.wait(f"mafsil.link.heard.get('job').text === {json.dumps(first)}")
            browser.wait(f"document.getElementById('job').value === {json.dumps(first)}")
            browser.load("about:blank", drawn="true")
            studio.server.shutdown()
