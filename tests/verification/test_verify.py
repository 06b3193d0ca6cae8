"""`verify`: agrees on sound robots, catches every wrong operation, says what it did, in both languages."""

from __future__ import annotations

import importlib.util
import json
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import mafsil as mf
import mafsil.expression as ex
from mafsil.cli.main import main
from mafsil.errors import InputError, ModelError
from mafsil.mechanics import articulated_body
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.mechanics.quantities import inverse_dynamics, kinematics, link_motion
from mafsil.model import Actuator, Friction, Inertial, Joint, JointKind, Link, Mechanism, Mimic, library
from mafsil.robot import Robot
from mafsil.verification import Check, verify
from tests.oracles.random_tree import branched_tree, random_tree
from tests.reliability.slips import Survey
from tests.sizes import size
from tests.verification.mutants import Mutant, Way, calls, evaluated, mutated, places

MUTANTS_EACH = size(1, 3)
ARM = "stanford_arm"


@pytest.fixture(scope="module")
def arm() -> Robot:
    return mf.load(ARM)


WAYS = [way for way, _ in calls(mf.load(ARM))]


@pytest.mark.capability("09-5", "09-9", "09-59")
@pytest.mark.parametrize("name", [ARM, "panda", "planar2r_point_masses", "tree"])
def test_sound_robots_agree(name: str) -> None:
    mechanism = random_tree(np.random.default_rng(4), most_joints=6) if name == "tree" else library.load(name)
    report = mf.verify(Robot(mechanism), states=4, seed=1)
    assert report.ok, report.explain()
    skipped = [("task_space", "verification.no_margin")] if name == "tree" else []
    assert list(report.left_out) == skipped
    assert {check.routine.partition("(")[0] for check in report.checks} >= set(CATALOGUE)
    assert report.worst.error < 1e-11


@pytest.mark.parametrize("way", WAYS, ids=[f"{w.routine}-{'+'.join(w.optional)}-{w.frame or 'tip'}" for w in WAYS])
def test_every_injected_slip_is_caught(arm: Robot, way: Way) -> None:
    """One sign or one sine exchanged in a routine's expression; slips that change no number are none."""
    mechanism, tape = arm.mechanism, way.tape(arm.mechanism)
    rng = np.random.default_rng(sum(map(ord, way.routine)))
    row = CATALOGUE[way.routine]
    sizes = {"q": arm.n, "qd": arm.n, "qdd": arm.n, "tau": arm.n}
    probe = [rng.uniform(-1, 1, (3, sizes.get(name, 6))) for name in (*row.inputs, *way.optional)]
    truth = evaluated(mechanism, way, tape, probe)
    caught = 0
    for number in rng.permutation(places(tape)):
        wrong = mutated(tape, int(number))
        if np.abs(evaluated(mechanism, way, wrong, probe) - truth).max() <= 1e-9:
            continue
        report = verify(Mutant(mechanism, way, wrong), states=3)
        assert way.routine in {check.routine.partition("(")[0] for check in report.failed}, (way, number)
        assert not report.ok
        caught += 1
        if caught == MUTANTS_EACH:
            break
    assert caught, "no operation whose exchange shows"


def _fallen_up(tree: BodyTree) -> BodyTree:
    return replace(tree, gravity=-tree.gravity)


SHARED_SLIPS = {
    "gravity": (inverse_dynamics, "inverse_dynamics", lambda f: lambda tree, *x: f(_fallen_up(tree), *x)),
    "tip wrench": (inverse_dynamics, "_add_tip_wrench", lambda f: lambda tree, F, *lists: f(tree, -F, *lists)),
    "bracket": (kinematics, "bracket", lambda f: lambda a, b: -f(a, b)),
    "centripetal": (link_motion, "spin_acceleration", lambda f: lambda omega, alpha: f(ex.zeros(3, 1), alpha)),
}
"""Slips in the builders that many routines share."""


@pytest.mark.parametrize("slip", SHARED_SLIPS)
def test_slips_in_shared_builders_are_caught(arm: Robot, slip: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """In every routine whose expression changes by it."""
    module, function, wrong = SHARED_SLIPS[slip]
    sound = {way: way.tape(arm.mechanism) for way in WAYS}
    monkeypatch.setattr(module, function, wrong(getattr(module, function)))
    changed = {way: way.tape(arm.mechanism) for way in WAYS}
    monkeypatch.undo()
    touched = {way for way in WAYS if repr(changed[way].nodes) != repr(sound[way].nodes)}
    assert touched, f"nothing depends on {function}"
    unnoticed = [way for way, s in calls(arm) if way in touched and not Survey(arm, way, s, changed[way]).is_caught]
    assert not unnoticed


def test_slips_in_articulated_bodies_are_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Long chains have a forward dynamics of their own."""
    snake = Robot(branched_tree(40, np.random.default_rng(2)))
    way, s = next((way, s) for way, s in calls(snake) if way == Way("forward_dynamics", ("tip_wrench",)))
    assert not Survey(snake, way, s).is_caught
    true, asked = articulated_body._add_tip_wrench, []
    monkeypatch.setattr(
        articulated_body, "_add_tip_wrench", lambda tree, F, bias: (asked.append(F), true(tree, -F, bias))
    )
    wrong = Survey(snake, way, s)
    assert asked, "the chain is too short"
    assert wrong.is_caught


@pytest.mark.parametrize("peer", ["pinocchio", "mujoco"])
@pytest.mark.parametrize("name", [ARM, "tree"])
def test_against_a_peer(peer: str, name: str) -> None:
    pytest.importorskip(peer)
    mechanism = random_tree(np.random.default_rng(2), most_joints=7, helical=False) if name == "tree" else None
    report = verify(mf.load(name) if mechanism is None else Robot(mechanism), against=peer, states=3)
    assert report.ok, report.explain()
    assert any(check.method == f"verification.{peer}" for check in report.checks)
    assert any(peer in routine for routine, _ in report.left_out)


def test_mujoco_is_not_asked_about_helical_joints() -> None:
    pytest.importorskip("mujoco")
    body = Inertial(1.0, np.array([0.2, 0.0, 0.1]), np.eye(3) * 0.1)
    joint = Joint("screw", JointKind.HELICAL, "base", "nut", pitch=0.1, friction=Friction(0.1, 0.2, 0.3))
    robot = Robot(Mechanism.assemble("screw", [Link("base"), Link("nut", body)], [joint]))
    report = verify(robot, against="mujoco", states=2)
    assert report.ok, report.explain()
    assert "helical" in report.explain("en")
    assert "لولبية" in report.explain("ar")


def test_a_refusal_is_right_only_where_the_mass_matrix_is_singular() -> None:
    joints = [Joint(f"joint{k}", JointKind.REVOLUTE, f"link{k - 1}", f"link{k}") for k in (1, 2)]
    links = [Link("link0"), Link("link1"), Link("link2", Inertial(1.0, np.array([0.1, 0, 0]), np.eye(3) * 0.01))]
    report = verify(Robot(Mechanism.assemble("coaxial", links, joints)), states=2)
    assert report.ok, report.explain()
    assert any(check.reason for check in report.checks)
    assert "joint1" in report.explain()


def test_a_last_link_without_inertia_about_its_axis() -> None:
    """The refusal of the compiled routine is confirmed by the other method, rounding on its diagonal or not."""
    rod = Inertial(1.0, np.array([0, 0, 0.1]), np.diag([0.01, 0.01, 0.0]))
    links = [Link("a"), Link("b", Inertial(1.0, np.array([0.1, 0, 0]), np.eye(3) * 0.01)), Link("c", rod)]
    joints = [
        Joint("first", JointKind.REVOLUTE, "a", "b", axis=np.array([0, 1.0, 0])),
        Joint("second", JointKind.REVOLUTE, "b", "c"),
    ]
    report = verify(Robot(Mechanism.assemble("rod", links, joints)))
    assert report.ok, report.explain()
    assert {"second" in check.reason for check in report.checks if check.reason} == {True}


def test_the_report_says_which_peers_were_asked(arm: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        import_module("mafsil.verification.verify"), "find_spec", lambda name: None if name == "mujoco" else name
    )
    report = verify(arm, states=1)
    assert dict(report.peers) == {"pinocchio": "verification.peer_idle", "mujoco": "verification.peer_missing"}
    assert "mujoco is not installed" in report.explain("en")
    assert "mujoco غير مثبّتة" in report.explain("ar")
    assert report.to_dict()["peers"] == {"pinocchio": "idle", "mujoco": "missing"}


def test_wrong_arguments(arm: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    for call, key in (
        (lambda: verify(3), "robot.source"),
        (lambda: verify(arm, against="drake"), "input.choice"),
        (lambda: verify(arm, states=0), "verification.states"),
        (lambda: verify(Robot(Mechanism.assemble("table", [Link("top")], []))), "robot.no_joints"),
    ):
        with pytest.raises((InputError, ModelError)) as caught:
            call()
        assert caught.value.key == key
        assert caught.value.message("ar") != caught.value.message("en")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(import_module("mafsil.verification.verify"), "find_spec", lambda name: None)
    with pytest.raises(InputError, match="not installed"):
        verify(arm, against="pinocchio")


def test_the_report_says_what_differs(arm: Robot) -> None:
    way = Way("gravity_torque")
    tape = way.tape(arm.mechanism)
    report = verify(Mutant(arm.mechanism, way, mutated(tape, places(tape)[-1])), states=2)
    assert not report.ok
    for language, word in (("en", "DIFFERS"), ("ar", "يخالف")):
        assert word in report.explain(language)
    assert any(row[0] == "gravity_torque" for row in report.table("en"))
    data = report.to_dict()
    assert not data["ok"]
    json.dumps(replace(report, checks=report.checks[:1]).to_dict())
    assert not Check("x", "verification.screws", float("nan"), 1.0).passed


def test_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "planar2r", "--states", "3"]) == 0
    out = capsys.readouterr().out
    assert "inverse_dynamics" in out
    assert main(["verify", "planar2r", "--json", "--lang", "ar"]) == 0
    assert json.loads(capsys.readouterr().out)["ok"]
    assert main(["verify", "planar2r", "--against", "drake"]) == 2
    assert main(["verify", "planar2r", "--states", "2", "--against", "pinocchio", "mujoco", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["peers"] == {"pinocchio": "compared", "mujoco": "compared"}


FINGERS = """<robot name="hand"><link name="palm"/><link name="a">{mass}</link><link name="b">{mass}</link>
<joint name="j1" type="prismatic"><parent link="palm"/><child link="a"/><axis xyz="0 1 0"/>
<limit lower="0" upper="0.04" effort="20" velocity="0.2"/><dynamics damping="0.3" friction="0.1"/></joint>
<joint name="j2" type="prismatic"><parent link="palm"/><child link="b"/><axis xyz="0 -1 0"/>
<limit lower="0" upper="0.04" effort="20" velocity="0.2"/><dynamics damping="0.3"/><mimic joint="j1"/></joint>
</robot>""".format(
    mass='<inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def coupled_hand() -> Robot:
    """A finger and its follower, and a thumb that follows a turning wrist by half and backwards; uneven friction."""
    body = Inertial(0.3, np.array([0.02, 0.03, 0.1]), np.diag([0.01, 0.02, 0.025]))
    joints = [
        Joint("turn", JointKind.REVOLUTE, "base", "palm", friction=Friction(0.2, 0.1)),
        Joint("left", JointKind.PRISMATIC, "palm", "a", friction=Friction(0.3), actuator=Actuator(armature=0.1)),
        Joint("right", JointKind.PRISMATIC, "palm", "b", friction=Friction(0.3), mimic=Mimic("left", -1.0, 0.01)),
        Joint(
            "thumb", JointKind.REVOLUTE, "palm", "c", axis=np.array([1.0, 0, 0]), friction=Friction(0.3, 0.2, 0.4, 0.1),
            mimic=Mimic("turn", -0.5, 0.3), actuator=Actuator(1e-4, 30.0),
        ),
    ]  # fmt: skip
    return Robot(Mechanism.assemble("hand", [Link(name, body) for name in ("base", "palm", "a", "b", "c")], joints))


def test_followers_take_part_in_friction() -> None:
    """Two fingers of 0.3 N s/m each are 0.6 N s/m at the leader, by virtual work."""
    robot = Robot(mf.model.urdf.read(FINGERS))
    assert robot.n == 1
    assert robot.friction_torque([1.0])[0] == pytest.approx(0.7)
    report = verify(robot)
    assert report.ok, report.explain()
    assert {check.routine for check in report.checks} >= {"friction_torque", "friction_regressor"}


@pytest.mark.parametrize("peer", ["pinocchio", "mujoco"])
def test_followers_are_compared_with_peers(peer: str) -> None:
    pytest.importorskip(peer)
    report = verify(coupled_hand(), peer)
    assert report.ok, report.explain()
    compared = {check.routine for check in report.checks if check.method == f"verification.{peer}"}
    assert compared >= {"forward_kinematics", "mass_matrix", "gravity_torque", "inverse_dynamics", "forward_dynamics"}
    assert compared >= ({"kinetic_energy", "potential_energy"} if peer == "mujoco" else {"coriolis_matrix"})
    assert ("inverse_dynamics_derivatives" in compared) == (peer == "pinocchio")


def test_friction_without_followers_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the second method forgot until it knew of followers."""
    robot = coupled_hand()
    alone = replace(robot.mechanism, joints=tuple(replace(j, mimic=None) for j in robot.mechanism.joints[:3]),
                    links=robot.mechanism.links[:4])  # fmt: skip
    monkeypatch.setattr(
        Robot, "friction_torque", lambda self, qd, smoothing=1e-3: Robot(alone)._friction.torque(
            np.concatenate([qd, 0 * qd[:, :1]], axis=1), smoothing)[:, :2]
    )  # fmt: skip
    assert [check.routine for check in verify(robot).failed] == ["friction_torque"]


@pytest.mark.parametrize("peer", ["pinocchio", "mujoco"])
def test_what_cannot_be_compared_is_said(peer: str) -> None:
    links = [Link("base"), Link("arm", Inertial(2.0, np.array([0.2, 0, 0]), np.eye(3) * 0.01)), Link("hand")]
    joints = [Joint("elbow", JointKind.REVOLUTE, "base", "arm"), Joint("wrist", JointKind.REVOLUTE, "arm", "hand")]
    report = verify(Robot(Mechanism.assemble("limp", links, joints)), peer, states=2)
    left_out = {routine for routine, _ in report.left_out}
    assert left_out >= {"task_space", "forward_dynamics (way back)", f"forward_dynamics, {peer}"}
    assert not left_out.intersection(check.routine for check in report.checks)
    assert "cannot be inverted" in report.explain("en")


def test_several_peers_at_once(arm: Robot) -> None:
    pytest.importorskip("pinocchio")
    pytest.importorskip("mujoco")
    report = verify(arm, ["pinocchio", "mujoco"], states=2)
    assert {check.method for check in report.checks} >= {"verification.pinocchio", "verification.mujoco"}
    with pytest.raises(InputError, match="drake"):
        verify(arm, ["pinocchio", "drake"])
