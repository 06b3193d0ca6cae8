"""Pages of robots with loops: everything that they show is of the closed chain, or left out and said."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.kernels.export import bundle
from mafsil.messages import say
from mafsil.page.arm import Arm
from mafsil.page.assemble import own_views
from mafsil.page.content import content
from mafsil.page.session import Session, action_arguments
from mafsil.page.show import show
from mafsil.parallel import ClosedChain, DeltaRobot, StewartPlatform, three_rps
from tests.page.browser import Browser
from tests.page.node import run_module
from tests.page.test_page_core import SCRIPT, bits

ROBOTS = Path(__file__).parents[2] / "examples" / "robots"
PALLETISER = str(ROBOTS / "palletiser.xml")
GUISE = """
<mujoco><worldbody>
  <body name="crank"><inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/><joint name="a" axis="0 1 0"/>
    <body name="coupler" pos="0 0 0.2"><inertial pos="0.2 0 0" mass="2" diaginertia="0.02 0.02 0.02"/>
      <joint name="b" axis="0 1 0"/><site name="end" pos="0.4 0 0"/></body></body>
  <body name="rocker" pos="0.4 0 0"><inertial pos="0 0 0.1" mass="1" diaginertia="0.01 0.01 0.01"/>
    <joint name="c" axis="0 1 0"/><body name="top" pos="0 0 0.2"><inertial mass="0.1" pos="0 0 0"
      diaginertia="0.001 0.001 0.001"/></body></body>
</worldbody><equality><connect body1="coupler" body2="top" anchor="0.4 0 0"/></equality>
<actuator>{actuator}</actuator></mujoco>
"""
DRIVEN = '<motor joint="a" ctrlrange="-9 9" ctrllimited="true"/>'
VIEWS = """
import fs from "node:fs";
import { VIEWS } from "./page/core/views.js";
IMPORTS
const io = JSON.parse(fs.readFileSync("io.json"));
const kernels = Object.fromEntries(io.kernels.map((name) => [name, () => []]));
const wanted = VIEWS.filter((one) => one.wanted?.({ settings: io.data.settings, kernels }, io.data) ?? true);
process.stdout.write(JSON.stringify(wanted.map((one) => one.name)));
"""
pytestmark = pytest.mark.filterwarnings("ignore::mafsil.errors.ModelWarning")


def four_bar(folder: Path, actuator: str = DRIVEN) -> mf.Robot:
    file = folder / "four_bar.xml"
    file.write_text(GUISE.format(actuator=actuator), encoding="utf-8")
    return mf.load(file)


def freely_hung(folder: Path) -> mf.Robot:
    """The four bars with one more joint at their end that nobody drives: the motor does not decide where it is."""
    file = folder / "hung.xml"
    end = '<body name="tip" pos="0 0 -0.1"><joint name="d" axis="0 1 0"/><inertial mass="1" pos="0 0 -0.1" '
    end += 'diaginertia="0.01 0.01 0.01"/></body>'
    text = GUISE.format(actuator=DRIVEN).replace('<site name="end" pos="0.4 0 0"/>', end)
    file.write_text(text, encoding="utf-8")
    return mf.load(file)


def robots(tmp_path: Path) -> list[mf.Robot]:
    return [mf.load(PALLETISER), four_bar(tmp_path)]


def shown_of(arm: Arm, folder: Path) -> list[str]:
    """The cards of a page."""
    data = content(arm, "en", "robot")
    module = VIEWS.replace("IMPORTS", "\n".join(f'import "./{path}";' for path in own_views()))
    given = {"data": {**data, "kernels": None}, "kernels": list(arm.kernels)}
    (folder / "io.json").write_text(json.dumps(given))
    return json.loads(run_module(module, folder))


def test_every_card_is_of_the_closed_chain_or_left_out(tmp_path: Path) -> None:
    for robot in robots(tmp_path):
        arm = Arm(robot)
        assert set(arm.kernels) == {
            "link_poses", "forward_kinematics", "tip_pose", "closed_following", "tree_jacobian", "closed_efforts",
        }  # fmt: skip
        assert set(shown_of(arm, tmp_path)) == {"loops", "joints", "pose", "jacobian", "gravity", "code", "grasp"}
        data = content(arm, "en", "robot")
        assert data["dh"] is None
        assert data["branches"] is None
        names = [robot.joint_names[k] for k in data["settings"]["driven"]]
        assert names == [joint.name for joint in robot.mechanism.coordinates if joint.actuated]
        for language in ("en", "ar"):
            for key in ("loops_move", "loops_left_out", "loops_no_loads", "why_loops", "view_loops", "hint_loops"):
                assert say(f"page.{key}", language=language)


def test_loops_stay_closed_whatever_is_done(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    for robot in robots(tmp_path):
        session, chain = Session(robot), ClosedChain(robot)
        assert chain.error(session.q) < 1e-9
        moved = 0
        for _ in range(30):
            joint = int(rng.choice(chain.actuated))
            before, value = session.q, float(rng.uniform(-1.2, 1.2))
            session.set_joint(joint, value)
            assert chain.error(session.q) < 1e-9
            if session.status == "ready":
                assert session.q[joint] == pytest.approx(value, abs=1e-12)
                moved += 1
            else:
                assert session.status == "loops_open"
                np.testing.assert_array_equal(session.q, before)
            still = 0 * session.q
            tau = session._call("closed_efforts", session.state.q, still, still)[0]
            np.testing.assert_allclose(tau, chain.inverse_dynamics(session.q, still, still).tau, atol=1e-9)
        assert moved > 10
        session.set_joints(rng.uniform(-0.3, 0.3, robot.n).tolist())
        assert chain.error(session.q) < 1e-9


def test_loads_are_those_of_the_loops() -> None:
    """By virtual work: the effort of a driven joint is the slope of the potential energy along the closed motion."""
    session = Session(mf.load(PALLETISER))
    session.set_joints([0.2, 0.0, -0.1, 0.0])
    robot, chain, h = session.arm.robot, ClosedChain(session.arm.robot), 1e-5
    still = 0 * session.q
    tau = session._call("closed_efforts", session.state.q, still, still)[0]
    for k, joint in enumerate(chain.actuated):
        energies = []
        for way in (h, -h):
            q = session.q.copy()
            q[joint] += way
            energies.append(float(robot.potential_energy(chain.close_loops(q, hold=chain.actuated, tries=1).q)))
        assert tau[k] == pytest.approx((energies[0] - energies[1]) / (2 * h), abs=1e-6)
    assert np.abs(tau - np.asarray(robot.gravity_torque(session.q))[chain.actuated]).max() > 0.5


def test_the_page_moves_loops_to_the_same_bits(tmp_path: Path) -> None:
    session = Session(mf.load(PALLETISER))
    actions: list[dict[str, Any]] = [
        {"do": "set_joint", "with": {"joint": 0, "value": 0.3}},
        {"do": "set_joint", "with": {"joint": 2, "value": -0.2}},
        {"do": "set_joint", "with": {"joint": 2, "value": 9.0}},
        {"do": "set_joints", "with": {"values": [0.1, 0.2, 0.05, 0.0]}},
        {"do": "set_joints", "with": {"values": [2.0, 2.0, -2.0, 2.0]}},
    ]
    module = bundle(session.arm.kernels)
    io = {
        "settings": session.arm.settings, "actions": actions, "layout": dict(module.layout), "args": action_arguments(),
        "robot": "robot",
    }  # fmt: skip
    (tmp_path / "io.json").write_text(json.dumps(io))
    (tmp_path / "bundle.wasm").write_bytes(module.code)
    states = json.loads(run_module(SCRIPT, tmp_path))["states"]
    for action, state in zip(actions, states, strict=True):
        session.do([action])
        assert state["status"] == session.status
        assert bits(state["q"]) == bits(session.q)


LEGS = StewartPlatform.on_circles(
    1.0, 0.6, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
)
CLOSED = {
    "stewart": LEGS,
    "delta": DeltaRobot(base=0.2, platform=0.05, arm=0.25, forearm=0.6),
    "three_rps": three_rps(0.5, 0.3, 0.6),
    "slider_crank": mf.mobility.library.slider_crank(),
    "palletiser": PALLETISER,
}
COLUMNS = """
import fs from "node:fs";
import { loadKernels } from "./page/core/kernels.js";
import { tipJacobian } from "./page/loops/follow.js";
const { layout, settings, places } = JSON.parse(fs.readFileSync("io.json"));
const kernels = await loadKernels(fs.readFileSync("bundle.wasm"), layout);
const found = places.map((q) => tipJacobian(q, { settings, kernels }));
process.stdout.write(JSON.stringify(found.map(({ J, joints }) => ({ J: Array.from(J), joints }))));
"""


@pytest.mark.parametrize("name", CLOSED)
def test_platforms_and_linkages_are_robots_of_the_page(name: str, tmp_path: Path) -> None:
    """Their loops stay closed, whatever is done, and the Jacobian of the page is that of the closed chain."""
    session = Session(show(CLOSED[name], language="en").robot)
    chain, rng, places = ClosedChain(session.arm.robot), np.random.default_rng(5), []
    driven = session.arm.settings["driven"]
    assert driven == chain.actuated.tolist() or not any(j.actuated for j in session.arm.robot.mechanism.coordinates)
    for _ in range(20):
        joint = int(rng.choice(driven))
        session.set_joint(joint, float(session.q[joint] + 0.1 * rng.uniform(-1, 1)))
        assert chain.error(session.q) < 1e-9
        places.append(session.q)
    module = bundle(session.arm.kernels)
    io = {"layout": dict(module.layout), "settings": session.arm.settings, "places": [q.tolist() for q in places]}
    (tmp_path / "io.json").write_text(json.dumps(io))
    (tmp_path / "bundle.wasm").write_bytes(module.code)
    of_driven = (
        ClosedChain(session.arm.robot, tuple(session.arm.robot.joint_names[k] for k in driven))
        if driven != chain.actuated.tolist()
        else chain
    )
    for q, found in zip(places, json.loads(run_module(COLUMNS, tmp_path)), strict=True):
        assert found["joints"] == driven
        J = np.asarray(of_driven.jacobian_body(q))
        np.testing.assert_allclose(np.reshape(found["J"], J.shape), J, atol=1e-9 * max(1.0, np.abs(J).max()))


LEADING = """
import fs from "node:fs";
import { loadKernels } from "./page/core/kernels.js";
import { ledTo } from "./page/loops/follow.js";
const { layout, settings, starts, goals } = JSON.parse(fs.readFileSync("io.json"));
const arm = { settings, kernels: await loadKernels(fs.readFileSync("bundle.wasm"), layout) };
const found = goals.map((T, k) => {
  let at = { q: starts[k], miss: Infinity };
  const way = [];
  for (let gesture = 0; gesture < 30; gesture++) way.push(at = ledTo({ q: at.q }, T, arm));
  return way;
});
process.stdout.write(JSON.stringify(found));
"""


@pytest.mark.parametrize("name", CLOSED)
def test_the_tool_of_loops_is_led_to_what_is_reached_and_held_near_what_is_not(name: str, tmp_path: Path) -> None:
    session, rng = Session(show(CLOSED[name], language="en").robot), np.random.default_rng(2)
    robot, settings = session.arm.robot, session.arm.settings
    chain, driven, starts, goals = ClosedChain(robot), settings["driven"], [], []
    for far in (False, False, True, True):
        starts.append(session.q.tolist())
        for joint in driven:
            session.set_joint(joint, float(session.q[joint] + 0.05 * rng.uniform(-1, 1)))
        T = np.asarray(robot.forward_kinematics(session.q)).copy()
        T[:3, 3] += 5.0 * rng.normal(size=3) if far else 0.0
        goals.append(T.ravel().tolist())
    module = bundle(session.arm.kernels)
    io = {"layout": dict(module.layout), "settings": settings, "starts": starts, "goals": goals}
    (tmp_path / "io.json").write_text(json.dumps(io))
    (tmp_path / "bundle.wasm").write_bytes(module.code)
    for k, way in enumerate(json.loads(run_module(LEADING, tmp_path))):
        T, left = np.reshape(goals[k], (4, 4)), [one["miss"] for one in way]
        assert left == sorted(left, reverse=True)
        for q in (np.array(one["q"]) for one in way):
            assert chain.error(q) < 1e-9
            assert np.all(
                (q >= robot.limits.lower - 1e-12) & (q <= robot.limits.upper + 1e-12) | ~np.isin(range(robot.n), driven)
            )
        reached = np.asarray(robot.forward_kinematics(np.array(way[-1]["q"])))
        if k < 2 and name != "three_rps":  # whose tip first goes straight up alone, whatever its legs do
            assert np.abs(reached[:3, 3] - T[:3, 3]).max() < 2e-6
        elif name != "three_rps":  # whose legs are of any length
            assert left[-1] > 1.0


ANYTHING = """((seed, count) => {
  const { store, stage } = mafsil, { driven, n } = store.arm.settings, places = [];
  const random = () => (seed = (48271 * seed) % 2147483647) / 2147483647, about = () => 2 * random() - 1;
  const acts = [
    () => store.do("set_joint", { joint: driven[Math.floor(random() * driven.length)], value: 3 * about() }),
    () => store.do("set_joints", { values: Array.from({ length: n }, (_, k) => store.state.q[k] + about()) }),
    () => { stage.drag.start(0, 0); const { position, quaternion } = stage.drag.going;
      for (let k = 0; k < 4; k++) stage.drag.lead(position.map((x) => x + 0.3 * about()), quaternion); stage.drag.end(); },
    () => stage.drag.nudge([about(), about()], random() < 0.5),
    () => store.undo(),
    () => mafsil.measure({ angle: random() < 0.5 ? "deg" : "rad" }),
    () => { for (const field of document.querySelectorAll("#view-joints input")) if (random() < 0.3) {
      field.value = 4 * about(); field.dispatchEvent(new Event("input")); field.dispatchEvent(new Event("change")); } },
  ];
  for (let k = 0; k < count; k++) { acts[Math.floor(random() * acts.length)](); places.push(Array.from(store.state.q)); }
  return places;
})"""  # noqa: E501


def test_loops_are_closed_after_any_action_of_a_window(tmp_path: Path) -> None:
    """Joints set one by one and together, the tool led by pointer and keys, fields, undo: 100 of them in any order."""
    with Browser(tmp_path, (1280, 800)) as browser:
        for seed, (name, of) in enumerate(CLOSED.items(), 1):
            page = show(of, language="en")
            browser.load(page.write(tmp_path / f"{name}.html"))
            chain, places = ClosedChain(page.robot), np.array(browser.ask(f"{ANYTHING}({seed}, 100)"))
            assert max(chain.error(q) for q in places) < 1e-9
            assert len(np.unique(places, axis=0)) > 20
            assert not browser.errors


def test_what_would_be_of_the_open_tree_is_refused(tmp_path: Path) -> None:
    session = Session(mf.load(PALLETISER))
    with pytest.raises(InputError, match="not driven"):
        session.set_joint(1, 0.1)
    pose = [0.5, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0]
    for act in (
        lambda: session.search(*pose), lambda: session.reach(*pose, 0), lambda: session.choose(0),
        lambda: session.loop(True), lambda: session.simulate(3),
    ):  # fmt: skip
        with pytest.raises(InputError, match="closed loops"):
            act()
    assert len(Session(four_bar(tmp_path, "")).arm.settings["driven"]) == 1  # all may be motors: one moves the rest
    nobody = Session(freely_hung(tmp_path))
    assert nobody.arm.settings["driven"] == []
    assert "gravity" not in shown_of(nobody.arm, tmp_path)
    with pytest.raises(InputError, match="closed loops"):
        nobody.set_joints([0.0] * nobody.arm.robot.n)


def test_loops_without_masses_are_moved_and_loads_are_left_out(tmp_path: Path) -> None:
    mechanism = mf.mobility.mechanism_of(mf.mobility.library.four_bar())
    session = Session(mechanism)
    session.set_joint(0, 0.4)
    assert session.status == "ready"
    assert ClosedChain(mechanism).error(session.q) < 1e-9
    assert set(shown_of(session.arm, tmp_path)) == {"loops", "joints", "pose", "jacobian", "code", "grasp"}
