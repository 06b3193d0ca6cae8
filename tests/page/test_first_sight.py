"""What a stranger sees first: a home one would print, links that hang together, a sharp picture that is filled."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Checker, distance
from mafsil.job.planning import resting
from mafsil.job.planning.resting import CLEAR, home_configuration
from mafsil.model import Capsule, library
from mafsil.model.appearance import part_of, reach
from mafsil.page import Session, show
from mafsil.scene import Drawing
from tests.page.browser import Browser
from tests.page.test_pages_of_loops import CLOSED
from tests.sizes import few

TOUCHING = 0.012
"""Gap between joined links that nobody sees, as share of the reach."""
LOOPS = ("examples/robots/palletiser.xml", "examples/robots/stewart.xml")
ROBOTS = (*library.robots(), "examples/robots/ur5.urdf")


@pytest.mark.parametrize("name", library.robots())
def test_the_home_configuration_is_dextrous_free_and_within_the_limits(name: str) -> None:
    robot = mf.load(name)
    q = home_configuration(robot)
    assert np.all((q > robot.limits.lower) & (q < robot.limits.upper))
    assert Checker(robot, clearance=CLEAR).free(q)
    drawn = Checker(robot).random_configurations(2000)
    J = np.asarray(robot.jacobian_body(np.vstack([q, drawn])))
    values = np.linalg.svd(J if robot.n >= 6 else J[:, 3:], compute_uv=False)
    regular = values[:, int((values.max(axis=0) > 1e-9).sum()) - 1]
    assert regular[0] >= np.quantile(regular[1:], 0.25)
    T = robot.fk(q)
    if robot.n >= 6 and name not in ("puma560", "rrprrr", "rrprrr_upright", "stanford_arm"):
        assert T[2, 2] == pytest.approx(-1.0), "the tool points down"


def test_makers_postures_are_found() -> None:
    """What Universal Robots and Franka call home or ready, but for the turn of the flange."""
    assert np.rad2deg(home_configuration(mf.load("ur5e"))) == pytest.approx([0, -90, -90, -90, 90, 0])
    assert np.rad2deg(home_configuration(mf.load("panda"))) == pytest.approx([0, -45, 0, -135, 0, 90, 0])


def test_a_home_is_computed_once_for_a_robot(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("MAFSIL_CACHE", str(tmp_path / "cache"))
    made: list[str] = []
    honest = resting._home_candidates
    monkeypatch.setattr(resting, "_home_candidates", lambda robot, rest: made.append(robot.name) or honest(robot, rest))
    homes = [home_configuration(mf.load(name)) for name in ("planar3r", "planar3r", "spatial3r")]
    assert made == [mf.load(name).name for name in ("planar3r", "spatial3r")]
    assert np.array_equal(homes[0], homes[1])


@pytest.mark.parametrize("name", ROBOTS)
def test_joined_links_touch_wherever_the_joints_are(name: str) -> None:
    robot = mf.load(name)
    size = reach(robot.mechanism)
    bounds = np.clip([robot.limits.lower, robot.limits.upper], -max(np.pi, size), max(np.pi, size))
    gaps = gaps_of_joints(robot, np.random.default_rng(1).uniform(*bounds, (50, robot.n)))
    assert max(gaps.values()) < TOUCHING, gaps


LINKAGES = (
    "four_bar", "watt", "three_rpr", "scotch_yoke", "five_bar", "stephenson", "peaucellier", "quick_return", "rccc",
    "parallelogram", "bennett", "universal_shaft", "stewart_gough", "three_rrr", "three_prs", "tripteron", "eclipse",
    "three_upu", "screw_press", "elliptic_trammel", "slotted_slider_crank", "three_cranks", "hand", "planar_platform",
)  # fmt: skip
CHAINS = {path: path for path in LOOPS} | {name: of for name, of in CLOSED.items() if name != "palletiser"}


@pytest.mark.parametrize("name", [*CHAINS, *few(LINKAGES, 4)])
def test_links_of_loops_touch_where_the_loops_are_closed(name: str) -> None:
    """At joints that close loops too, wherever the driven joints lead."""
    session = Session(show(CHAINS.get(name) or getattr(mf.mobility.library, name)(), language="en").robot)
    robot, rng, places = session.arm.robot, np.random.default_rng(1), [session.q]
    step = 0.1 * min(1.0, reach(robot.mechanism))
    for _ in range(50):
        joint = int(rng.choice(session.arm.settings["driven"]))
        session.set_joint(joint, float(session.q[joint] + step * rng.uniform(-1, 1)))
        places.append(session.q)
    gaps = gaps_of_joints(robot, np.array(places))
    assert gaps.keys() >= {loop.name for loop in robot.mechanism.loops}
    assert max(gaps.values()) < TOUCHING, gaps


def gaps_of_joints(robot: mf.Robot, q: np.ndarray) -> dict[str, float]:
    """The largest gap of what is drawn on both sides of each joint, as share of the reach."""
    mechanism = robot.mechanism
    drawing, size, names = Drawing(mechanism), reach(mechanism), mechanism.link_names
    poses, heads, found = np.asarray(robot.link_poses(q)), part_of(mechanism), dict[str, float]()
    parts = {head: [k for k in range(len(heads)) if heads[k] == head] for head in set(heads)}
    for joint in (*mechanism.joints, *mechanism.loops):
        if not joint.moves:
            continue
        sides = [names.index(joint.parent), names.index(joint.child)]
        ends = [
            [(one.geometry, poses[:, k] @ one.T_lg) for k in parts[heads[side]] for one in drawing.pieces[k]]
            for side in sides
        ]
        rod = drawing.rod(sides[1])
        if rod is not None and rod.parent == sides[0]:
            ends[1] += rods(rod, poses, sides[1])
        if ends[0] and ends[1]:
            gaps = [np.asarray(distance(a, b, T_a, T_b).distance) for a, T_a in ends[0] for b, T_b in ends[1]]
            found[joint.name] = float(np.min(gaps, axis=0).max()) / size
    return found


def rods(rod: Any, poses: np.ndarray, k: int) -> list[tuple[Any, np.ndarray]]:
    """A rod as the page draws it: of another length in every configuration, so as a row of balls."""
    begin, end = (
        poses[:, link, :3, :3] @ np.array(at) + poses[:, link, :3, 3]
        for link, at in ((rod.parent, rod.place), (k, rod.end))
    )
    found = []
    for share in np.linspace(0.0, 1.0, 9):
        T = np.tile(np.eye(4), (len(poses), 1, 1))
        T[:, :3, 3] = begin + share * (end - begin)
        found.append((Capsule(rod.radius, 1e-6), T))
    return found


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A window on a machine without a graphics processor."""
    with Browser(tmp_path_factory.mktemp("sight"), (1280, 800)) as found:
        yield found
        assert not found.errors


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pages")


FILLED = (
    "(() => { const { stage } = mafsil, { camera, width, height } = stage;"
    " const seen = stage.outermost().map(p => camera.project(p, width, height));"
    " const share = (way, all) => (Math.max(...seen.map(p => p[way])) - Math.min(...seen.map(p => p[way]))) / all;"
    " const inside = seen.every(p => p.x >= 0 && p.y >= 0 && p.x <= width && p.y <= height);"
    " return [Math.max(share('x', width), share('y', height)), inside]; })()"
)
LABELS = (
    "[...document.querySelectorAll('#labels button, #compass, #scale, #hint, #status, #clock, #move-name, #postures')]"
    ".filter(e => e.checkVisibility({ visibilityProperty: true })).map(e => {"
    " const b = e.getBoundingClientRect();"
    " return [e.id || `ghost ${e.textContent}`, b.left, b.top, b.right, b.bottom]; })"
)


@pytest.mark.parametrize("name", few((*ROBOTS, *LOOPS), 6))
def test_the_arm_fills_the_picture_and_labels_leave_one_another_alone(
    browser: Browser, folder: Path, name: str
) -> None:
    for size, phone in (((1280, 800), False), ((390, 800), True)):
        browser.resize(*size, phone=phone)
        browser.load(show(name, language="en").write(folder / f"{Path(name).stem}.html"))
        share, inside = browser.ask(FILLED)
        assert inside
        assert 0.45 <= share <= 0.9
        assert browser.ask("mafsil.stage.named.length") == 0, "ghosts are shown when they are asked for"
        for refusal in ("null", "{ key: 'why_not_found', values: { attempts: 40, steps: 60 } }"):
            for turn in ((0, 0), (150, 40), (40, -30)):
                browser.ask(f"mafsil.stage.camera.turn(...{list(turn)})")
                browser.ask(f"mafsil.store.show({{ ghosts: true, refusal: {refusal} }})")
                browser.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
                boxes = browser.ask(LABELS)
                assert sum(box[0].startswith("ghost") for box in boxes) == browser.ask("mafsil.stage.named.length")
                assert not overlapping(boxes)
            browser.ask("mafsil.speak()")


def overlapping(boxes: list[tuple[str, float, float, float, float]]) -> list[tuple[str, str]]:
    """Pairs of labels of which one covers a part of the other."""
    return [
        (name, other)
        for k, (name, left, top, right, bottom) in enumerate(boxes)
        for other, a, b, c, d in boxes[:k]
        if min(right, c) - max(left, a) > 0.5 and min(bottom, d) - max(top, b) > 0.5
    ]


@pytest.mark.parametrize("turns", [(0, 4000), (900, -4000)])
def test_the_eye_stays_above_the_floor(browser: Browser, folder: Path, turns: tuple[int, int]) -> None:
    browser.resize(1280, 800)
    browser.load(show("planar2r", language="en").write(folder / "planar2r.html"))
    browser.ask(f"mafsil.stage.camera.turn({turns[0]}, {turns[1]})")
    for _ in range(30):
        browser.ask("mafsil.stage.camera.slide(40, -200); mafsil.stage.camera.zoom(1.1)")
        assert browser.ask("mafsil.stage.camera.eye[2] > mafsil.data.scene.floor")


def test_the_compass_looks_along_axes_and_two_clicks_bring_a_link_near(browser: Browser, folder: Path) -> None:
    browser.resize(1280, 800)
    browser.load(show("ur5e", language="en").write(folder / "ur5e.html"))
    for name, way in (("x", (1, 0, 0)), ("z", (0, 0, 1)), ("y", (0, 1, 0))):
        browser.click(f"#compass button.{name}")
        assert browser.ask("mafsil.stage.camera.away") == pytest.approx(way, abs=0.06)
        assert browser.ask(FILLED)[1]
    before = browser.ask("mafsil.stage.camera.distance")
    browser.ask("mafsil.stage.focus((({x, y}) => ({offsetX: x, offsetY: y - 30}))(mafsil.stage.drag.place()))")
    assert browser.ask("mafsil.stage.camera.distance") < 0.6 * before


def test_at_rest_edges_are_sharp_without_a_graphics_processor(browser: Browser, folder: Path) -> None:
    """At rest there are more dots than the screen has, and outlines of the arm are at most two of the screen wide."""
    browser.resize(1280, 800)
    browser.load(show("panda", language="en").write(folder / "panda.html"))
    browser.ask("mafsil.draw()")
    assert browser.ask("mafsil.stage.kind") == "light"
    browser.wait("mafsil.stage.canvas.width / mafsil.stage.canvas.clientWidth >= 1.45")
    steepest = browser.ask(
        "(() => { const s = mafsil.stage.canvas, c = document.createElement('canvas');"
        " c.width = s.clientWidth; c.height = s.clientHeight; const x = c.getContext('2d');"
        " x.fillStyle = '#dde0e2'; x.fillRect(0, 0, c.width, c.height); x.drawImage(s, 0, 0, c.width, c.height);"
        " const p = x.getImageData(0, 0, c.width, c.height).data, steps = [];"
        " for (let k = 8; k < p.length; k += 4) steps.push(Math.abs(p[k] - p[k - 8]));"
        " return steps.sort((a, b) => b - a)[500]; })()"
    )
    assert steepest > 60
