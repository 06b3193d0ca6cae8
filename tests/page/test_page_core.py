"""Actions of the page in Node.js and in Python: the same states to the last bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.kernels.export import bundle
from mafsil.page.session import ACTIONS, Session, action_arguments, pose_from
from tests.page.node import run_module

SCRIPT = """
import fs from "node:fs";
import { loadKernels } from "./page/core/kernels.js";
import { Store } from "./page/core/store.js";
import { ACTIONS } from "./page/core/actions.js";
import { script } from "./page/core/journal.js";
const io = JSON.parse(fs.readFileSync("io.json"));
const kernels = await loadKernels(fs.readFileSync("bundle.wasm"), io.layout);
const store = new Store({ settings: io.settings, kernels });
const states = io.actions.map((action) => { store.do(action.do, action.with); return store.state; });
const text = script(store.journal, io.args, io.robot);
const signed = (_, value) => (Object.is(value, -0) ? "-0" : value);
process.stdout.write(JSON.stringify({ states, text, actions: Object.keys(ACTIONS) }, signed));
"""
EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "robots"
TURNED = [0.2, 0.9, -0.1, 0.3]
ROBOTS = ("panda", "ur5e", "puma560", "scara_rrrp", "cobra600", "spatial3r")


def bits(values: Any) -> bytes:
    return np.array([float(value) for value in values]).tobytes()


def actions_of(session: Session) -> list[dict[str, Any]]:
    """Something of everything, refusals included; poses on all branches."""
    rng, arm = np.random.default_rng(5), session.arm
    todo: list[dict[str, Any]] = [{"do": "set_joint", "with": {"joint": k, "value": 0.1 * k + 0.3}} for k in range(3)]
    todo.append({"do": "set_joints", "with": {"values": (arm.start + rng.uniform(-0.2, 0.2, arm.robot.n)).tolist()}})
    position = arm.robot.forward_kinematics(arm.start)[:3, 3]
    for shift in ([0.0, 0.0, 0.0], [0.05, -0.02, 0.03], [9.0, 0.0, 0.0]):
        where = (np.round(position + shift, 6) if any(shift) else position).tolist()
        todo.append({"do": "search", "with": {"position": where, "quaternion": TURNED}})
        if arm.form is not None:
            todo += [{"do": "choose", "with": {"branch": row}} for row in range(arm.form.pattern.branches)]
            todo += [
                {"do": "reach", "with": {"position": where, "quaternion": TURNED, "branch": row}}
                for row in range(arm.form.pattern.branches)
            ]
    for joint in arm.settings["locked"]:
        todo += [
            {"do": "swing", "with": {"joint": joint, "value": value, "branch": row}}
            for value in (-0.3, 0.2, 0.9)
            for row in range(arm.form.pattern.branches if arm.form else 0)
        ]
    if arm.has_dynamics:
        todo += [
            {"do": "loop", "with": {"closed": True}},
            {"do": "push", "with": {"wrench": [0.0, 1.0, 0.0, 15.0, -3.0, 5.0]}},
            {"do": "simulate", "with": {"ticks": 40}},
            {"do": "set_joint", "with": {"joint": 1, "value": 0.4}},
            {"do": "push", "with": {"wrench": [0.0] * 6}},
            {"do": "simulate", "with": {"ticks": 25}},
            {"do": "loop", "with": {"closed": False}},
        ]
    return todo


def in_node(session: Session, todo: list[dict[str, Any]], folder: Path) -> dict[str, Any]:
    module = bundle(session.arm.kernels)
    (folder / "bundle.wasm").write_bytes(module.code)
    io = {
        "layout": module.layout, "settings": session.arm.settings, "actions": todo, "args": action_arguments(),
        "robot": json.dumps(session.arm.robot.name),
    }  # fmt: skip
    (folder / "io.json").write_text(json.dumps(io))
    return json.loads(run_module(SCRIPT, folder))


@pytest.mark.parametrize("name", ROBOTS)
def test_same_states_to_the_last_bit(name: str, tmp_path: Path) -> None:
    session = Session(name)
    todo = actions_of(session)
    found = in_node(session, todo, tmp_path)
    ends: set[str] = set()
    for action, seen in zip(todo, found["states"], strict=True):
        session.do([action])
        state = session.state
        ends.add(state.status)
        for key in ("q", "qd", "goal", "push"):
            assert bits(seen[key]) == bits(getattr(state, key)), (action, key)
        assert (seen["status"], seen["ticks"], seen["loop"]) == (state.status, state.ticks, state.loop), action
        assert bool(seen["reason"]) == (state.status not in ("ready", "solved"))
    assert {"ready", "solved", "not_found"} <= ends
    assert len(session.arm.places) < 6 or ends & {"beyond_limits", "no_branch"}
    assert found["actions"] == list(ACTIONS)
    scope: dict[str, Any] = {}
    exec(found["text"], scope)  # the journal itself
    assert scope["arm"].q.tobytes() == session.q.tobytes()


def random_actions(session: Session, count: int, seed: int) -> list[dict[str, Any]]:
    """Anything that this robot can do, in any order, with numbers from inside and outside of its limits."""
    rng, arm = np.random.default_rng(seed), session.arm
    reach, movable = arm.settings["radius"] or 1.0, arm.settings["driven"] or list(range(arm.robot.n))
    kinds = ["set_joint", "set_joints"] if arm.closed is not None else ["set_joint", "set_joints", "search"]
    kinds += ["choose", "reach"] * (arm.form is not None) + ["swing"] * bool(arm.settings["locked"])
    kinds += ["loop", "push", "simulate"] * arm.has_dynamics
    rows = arm.form.pattern.branches if arm.form is not None else 0

    def given(kind: str) -> dict[str, Any]:
        pose = {
            "position": (np.array(arm.settings["centre"]) + rng.uniform(-0.8, 0.8, 3) * reach).round(6).tolist(),
            "quaternion": rng.normal(size=4).round(9).tolist(),
        }
        return {
            "set_joint": {"joint": int(rng.choice(movable)), "value": float(rng.uniform(-2, 2))},
            "set_joints": {"values": (arm.start + rng.uniform(-0.6, 0.6, arm.robot.n)).tolist()},
            "search": pose,
            "choose": {"branch": int(rng.integers(max(rows, 1)))},
            "reach": pose | {"branch": int(rng.integers(max(rows, 1)))},
            "swing": {"joint": (arm.settings["locked"] or [0])[0], "value": float(rng.uniform(-2, 2)), "branch": 0},
            "loop": {"closed": bool(rng.integers(2))},
            "push": {"wrench": rng.uniform(-20, 20, 6).tolist()},
            "simulate": {"ticks": int(rng.integers(1, 12))},
        }[kind]

    return [{"do": kind, "with": given(kind)} for kind in rng.choice(kinds, count).tolist()]


@pytest.mark.parametrize("name", ["panda", "ur5e", "cobra600", str(EXAMPLES / "palletiser.xml")])
@pytest.mark.filterwarnings("ignore::mafsil.errors.ModelWarning")
def test_two_hundred_random_actions_end_in_the_same_bits(name: str, tmp_path: Path) -> None:
    session, again = Session(name), Session(name)
    todo = random_actions(session, 200, 7)
    for action, state in zip(todo, in_node(session, todo, tmp_path)["states"], strict=True):
        session.do([action])
        assert session.status == state["status"], action
        assert bits(session.q) == bits(state["q"]), action
        assert bits(session.state.qd) == bits(state["qd"]), action
    again.do(todo)
    assert bits(again.q) == bits(session.q)


def test_a_free_joint_swings_while_the_tip_stays() -> None:
    """Where it is solved the joint has its value and the tip its pose; else nothing has moved. Others are refused."""
    session = Session("panda")
    T = session.arm.robot.forward_kinematics(session.q)
    seen: set[str] = set()
    for value in np.linspace(-2.8, 2.8, 15):
        for row in range(8):
            before = session.q
            session.swing(joint=6, value=float(value), branch=row)
            seen.add(session.status)
            if session.status == "solved":
                assert session.q[6] == value
                assert np.abs(session.arm.robot.forward_kinematics(session.q) - T).max() < 1e-8
            else:
                assert session.q.tobytes() == before.tobytes()
    assert seen >= {"solved", "beyond_limits"}
    for name, joint in (("panda", 3), ("ur5e", 5)):
        with pytest.raises(InputError) as caught:
            Session(name).swing(joint, 0.1, 0)
        assert caught.value.key == "session.not_free"


def test_solved_is_solved() -> None:
    """What session and page call solved brings the tip there, within the limits."""
    session = Session("panda")
    limits = session.arm.robot.limits
    for position in ([0.4, 0.2, 0.5], [0.3, -0.4, 0.3], [0.5, 0.0, 0.2]):
        T = np.reshape(pose_from(position, TURNED), (4, 4))
        session.search(position, TURNED)
        assert session.status == "solved"
        assert np.abs(session.arm.robot.forward_kinematics(session.q) - T).max() < 1e-8
        for row in range(8):
            session.reach(position, TURNED, branch=row)
            if session.status == "solved":
                assert np.abs(session.arm.robot.forward_kinematics(session.q) - T).max() < 1e-8
                assert (session.q >= limits.lower - 1e-9).all()
                assert (session.q <= limits.upper + 1e-9).all()
    before = session.q
    session.search([5.0, 0.0, 0.0], TURNED)
    assert session.status == "not_found"
    assert np.array_equal(session.q, before)


def test_a_robot_without_closed_form() -> None:
    session = Session("spatial3r")
    with pytest.raises(InputError, match="closed form"):
        session.choose(0)


def test_a_robot_without_masses() -> None:
    """No loads and no loop, on its page neither; the rest works."""
    bare = mf.Robot.from_dh([(0.5, 0.0, 0.0, 0.0), (0.4, 0.0, 0.0, 0.0)], convention="classic")
    session = Session(bare)
    assert not session.arm.has_dynamics
    assert not {"closed_loop", "gravity_torque"} & set(session.arm.kernels)
    with pytest.raises(InputError, match="masses"):
        session.loop(True)
    session.set_joint(0, 0.3)
    assert session.q[0] == 0.3


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("set_joint", {"joint": 7, "value": 0.0}), ("set_joint", {"joint": -1, "value": 0.0}),
        ("set_joints", {"values": [0.0]}), ("push", {"wrench": [1.0]}), ("choose", {"branch": 8}),
        ("search", {"position": [0.1, 0.2], "quaternion": [1, 0, 0, 0]}),
        ("reach", {"position": [0.1, 0.2, 0.3], "quaternion": [0, 0, 0, 0], "branch": 0}),
        ("search", {"position": [0.1, 0.2, float("nan")], "quaternion": [1, 0, 0, 0]}),
        ("jump", {}),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(name: str, given: dict[str, Any]) -> None:
    with pytest.raises(InputError):
        Session("panda").do([{"do": name, "with": given}])


def test_a_gesture_is_one_line(tmp_path: Path) -> None:
    """Sliding, dragging and letting time pass give one line each, which alone leads to the same state."""
    session = Session("ur5e")
    script = SCRIPT.replace(
        "io.actions.map((action) => { store.do(action.do, action.with); return store.state; })",
        "io.actions.map((action) => { store.do(action.do, action.with, { gesture: true }); return store.state; })",
    )
    todo = [{"do": "set_joint", "with": {"joint": 1, "value": -0.1 * k}} for k in range(9)]
    todo += [{"do": "set_joint", "with": {"joint": 2, "value": 0.1 * k}} for k in range(9)]
    todo += [{"do": "search", "with": {"position": [0.4, 0.1 + 0.01 * k, 0.3], "quaternion": TURNED}} for k in range(9)]
    todo += [{"do": "loop", "with": {"closed": True}}, {"do": "push", "with": {"wrench": [0, 0, 0, 9, 0, 0]}}]
    todo += [{"do": "simulate", "with": {"ticks": 16}} for _ in range(5)]
    module = bundle(session.arm.kernels)
    (tmp_path / "bundle.wasm").write_bytes(module.code)
    io = {
        "layout": module.layout,
        "settings": session.arm.settings,
        "actions": todo,
        "args": action_arguments(),
        "robot": '"ur5e"',
    }
    (tmp_path / "io.json").write_text(json.dumps(io))
    found = json.loads(run_module(script, tmp_path))
    lines = [row for row in found["text"].split("\n") if row.startswith("arm.")]
    assert [row.split("(")[0] for row in lines] == [
        "arm.set_joint", "arm.set_joint", "arm.search", "arm.loop", "arm.push", "arm.simulate",
    ]  # fmt: skip
    assert lines[-1] == "arm.simulate(ticks=80)"
    scope: dict[str, Any] = {}
    exec(found["text"], scope)
    assert scope["arm"].q.tobytes() == bits(found["states"][-1]["q"])
