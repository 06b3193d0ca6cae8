"""The first lines that beginners write wrongly: each is answered by a result, or by a sentence that helps.

A sentence helps if it says what was wrong, where, and what to do: the words listed with each call stand in it.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import control, figures
from mafsil import trajectory as tr
from mafsil.derivation import derive_fk
from mafsil.errors import MafsilError, MafsilWarning

ROOT = Path(__file__).parents[2]
PANDA, PUMA = mf.load("panda"), mf.load("puma560")
T = PUMA.forward_kinematics([0.1] * 6)
FAR = np.array([[1.0, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
ZEROS = np.zeros(7)
LEFT_OVER = """<robot xmlns:xacro="http://ros.org/wiki/xacro" name="x">
<xacro:property name="l" value="1"/><link name="a"/></robot>"""
BROKEN = '<robot name="x"><link name="a"></robot>'
JOINT = """<robot name="x"><link name="a"/><link name="b"/>
<joint name="j" type="{}"><parent link="a"/><child link="{}"/></joint></robot>"""

Call = Callable[[Path], object]


def in_file(text: str, name: str = "bad.urdf") -> Call:
    def load(folder: Path) -> mf.Robot:
        (folder / name).write_text(text, encoding="utf-8")
        return mf.load(folder / name)

    return load


def plain(call: Callable[[], object]) -> Call:
    return lambda _folder: call()


REFUSED: dict[str, tuple[Call, tuple[str, ...]]] = {
    "name misspelt": (plain(lambda: mf.load("ur5ee")), ("ur5ee", "did you mean", "ur5e")),
    "no file": (plain(lambda: mf.load("my_robot.urdf")), ("my_robot.urdf", "check the path")),
    "malformed XML": (in_file(BROKEN), ("bad.urdf", "1:34", "closing tag", "reverse order")),
    "joint type misspelt": (in_file(JOINT.format("revolut", "b")), ("'j'", "'revolut'", 'set type="revolute"')),
    "unknown child": (in_file(JOINT.format("revolute", "c")), ("'j'", "'c'", "declare the link")),
    "nothing to load": (plain(lambda: mf.load(None)), ("NoneType", "name of the library", "path")),
    "text of a file": (
        plain(lambda: mf.load((ROOT / "examples/robots/ur5.urdf").read_text())),
        ("text of a file", "write it to a file", "urdf.read"),
    ),
    "a job for a robot": (
        plain(lambda: mf.load(ROOT / "examples/jobs/pick_and_place_panda.toml")),
        ("this is a job", "mafsil run"),
    ),
    "too few coordinates": (plain(lambda: PANDA.forward_kinematics([0, 0])), ("q", "(2,)", "give 7 numbers")),
    "a column": (plain(lambda: PANDA.forward_kinematics(np.zeros((7, 1)))), ("q", "(7, 1)", "column", "ravel")),
    "no argument": (plain(PANDA.forward_kinematics), ("forward_kinematics", "q is missing")),
    "coordinates one by one": (plain(lambda: PANDA.forward_kinematics(*ZEROS)), ("7 arguments", "takes q", "one list")),
    "text": (plain(lambda: PANDA.forward_kinematics("home")), ("q", "real numbers", "str", "a list")),
    "a mapping": (plain(lambda: PANDA.forward_kinematics({"joint1": 0.1})), ("q", "real numbers", "dict", "a list")),
    "NaN": (plain(lambda: PANDA.forward_kinematics([np.nan] * 7)), ("q", "nan", "index (0,)", "replace or remove")),
    "complex numbers": (plain(lambda: PANDA.forward_kinematics([1j] * 7)), ("q", "real numbers", "complex")),
    "None": (plain(lambda: PANDA.forward_kinematics(None)), ("q", "real numbers", "NoneType", "a list")),
    "unknown frame": (plain(lambda: PANDA.forward_kinematics(ZEROS, frame="gripper")), ("'gripper'", "link7")),
    "frame misspelt": (plain(lambda: PANDA.forward_kinematics(ZEROS, frame="lnik3")), ("'lnik3'", "link3")),
    "keyword misspelt": (plain(lambda: PANDA.forward_kinematics(ZEROS, farme="link3")), ("'farme'", "frame")),
    "success of an answer": (plain(lambda: PANDA.ik(np.eye(4)).success), ("if answer",)),
    "solutions of an answer": (plain(lambda: PANDA.ik_all(PANDA.fk(np.zeros(7))).solutions), ("list(answer)",)),
    "text of a derivation": (plain(lambda: mf.load("planar2r").derive("fk").text), ("mf.derivation.to_text",)),
    "Grashof": (plain(lambda: mf.grashof), ("mf.mobility.FourBar(crank, coupler, rocker, ground).grashof",)),
    "masses that are not known": (plain(lambda: PANDA.with_mass_error(0.3)), ("with_scaled_inertia(1.3)",)),
    "method misspelt": (plain(lambda: PANDA.forward_kinematic), ("did you mean: forward_kinematics",)),
    "method of half a name": (plain(lambda: PANDA.inverse), ("inverse_dynamics",)),
    "accelerations forgotten": (plain(lambda: PANDA.inverse_dynamics(ZEROS, ZEROS)), ("qdd is missing", "q, qd, qdd")),
    "rates too few": (plain(lambda: PANDA.inverse_dynamics(ZEROS, ZEROS[:6], ZEROS)), ("qd", "(6,)", "give 7 numbers")),
    "a place for a pose": (
        plain(lambda: mf.inverse_kinematics(PUMA, [0.4, 0.1, 0.3])),
        ("T_sd", "(3,)", "4 by 4", "Pose.of", 'task="position"'),
    ),
    "place and angles for a pose": (
        plain(lambda: mf.inverse_kinematics(PUMA, [0.4, 0.1, 0.3, 0, 0, 0])),
        ("T_sd", "(6,)", "4 by 4", "from_rpy"),
    ),
    "no rotation": (
        plain(lambda: mf.inverse_kinematics(PUMA, np.ones((4, 4)))),
        ("T_sd", "last row", "zeros"),
    ),
    "arguments exchanged": (plain(lambda: mf.inverse_kinematics(T, PUMA)), ("robot", "ndarray", "first argument")),
    "initial guess too short": (plain(lambda: mf.solve_ik(PUMA, T, [0, 0, 0])), ("q0", "(3,)", "give 6 numbers")),
    "task misspelt": (plain(lambda: mf.solve_ik(PUMA, T, task="pos")), ("'pos'", "position")),
    "no unit quaternion": (plain(lambda: mf.Rotation.from_quaternion([0, 0, 0, 2])), ("(w, x, y, z)", "divide")),
    "convention misnamed": (
        plain(lambda: mf.Robot.from_dh([mf.DHRow()], "denavit")),
        ("'denavit'", "classic"),
    ),
    "Robot of a name": (plain(lambda: mf.Robot("panda")), ("Mechanism", "mafsil.load")),
    "postures of an answer": (
        lambda folder: figures.plot_configurations(PUMA, mf.inverse_kinematics(PUMA, T), folder / "b.png"),
        ("q", "SolutionSet", ".q: give that"),
    ),
    "page as picture": (
        lambda folder: figures.plot_mechanism(PUMA, folder / "a.html"),
        ("a.html", ".png", "end the"),
    ),
    "negative duration": (plain(lambda: tr.quintic([0], [1], -1)), ("duration", "positive", "-1")),
    "goal of another length": (plain(lambda: tr.quintic([0, 0], [1], 1)), ("goal", "(1,)", "give 2 numbers")),
    "duration forgotten": (plain(lambda: tr.quintic([0, 0], [1, 1])), ("quintic", "duration is missing")),
    "motion of another width": (
        plain(lambda: mf.Scenario(robot=PUMA, trajectory=tr.quintic([0], [1], 1), law=control.computed_torque(PUMA))),
        ("trajectory", "n = 6", "n = 1"),
    ),
    "no law": (
        plain(lambda: mf.simulate(mf.Scenario(robot=PUMA, trajectory=tr.quintic([0] * 6, [1] * 6, 1), law=None))),
        ("law", "NoneType"),
    ),
    "a robot for a scenario": (plain(lambda: mf.simulate(PUMA)), ("Scenario", "got a Robot")),
    "normal of length zero": (plain(lambda: mf.Contact((0, 0), (0, 0))), ("normal is zero", "give the direction")),
    "plane normal in space": (plain(lambda: mf.Contact((0, 0, 0), (0, 1))), ("normal", "(2,)", "give 3 numbers")),
    "no contacts": (plain(lambda: mf.Grasp([])), ("contacts", "at least one")),
    "no part": (plain(lambda: mf.grasp.plan_grasps("part.stl")), ("part.stl", "check the path")),
    "log before robot": (plain(lambda: mf.identify("log.csv", "panda")), ("log.csv", "log", "identify(robot, log)")),
    "language by its name": (plain(lambda: mf.language("arabic")), ("'arabic'", "en, ar")),
}
WARNED: dict[str, tuple[Call, tuple[str, ...]]] = {
    "left over xacro": (in_file(LEFT_OVER, "x.xacro"), ("x.xacro", "xacro:property", "ignored")),
    "degrees": (
        plain(lambda: mf.load("panda").forward_kinematics([0, -45, 0, -90, 0, 90, 45])),
        ("q", "-90 rad", "degrees", "numpy.radians"),
    ),
    "rotation in degrees": (plain(lambda: mf.Rotation.from_rpy([90, 0, 0])), ("90 rad", "degrees=True")),
    "coordinates of no solution": (plain(lambda: mf.solve_ik(PUMA, FAR).q), ("no solution", "if answer", "explain()")),
}
ACCEPTED: dict[str, Call] = {
    "Pose": plain(lambda: mf.inverse_kinematics(PUMA, mf.Pose(T))),
    "name of a robot": plain(lambda: mf.inverse_kinematics("puma560", T)),
    "rows of plain numbers": plain(lambda: mf.Robot.from_dh([[0, 0, 0, 0]], "classic")),
    "derivation of a Robot": plain(lambda: derive_fk(PUMA)),
    "picture of a Mechanism": lambda folder: figures.plot_mechanism(PUMA.mechanism, str(folder / "a.png")),
    "picture of a Robot": lambda folder: figures.plot_mechanism(PUMA, str(folder / "a.png")),
    "contacts as pairs": plain(lambda: mf.Grasp([((0, 0), (1, 0))])),
    "verification by name": plain(lambda: mf.verify("planar2r")),
}


@pytest.mark.parametrize(("call", "words"), REFUSED.values(), ids=REFUSED.keys())
def test_a_wrong_line_is_refused_in_words_that_help(call: Call, words: tuple[str, ...], tmp_path: Path) -> None:
    with pytest.raises(MafsilError) as caught:
        call(tmp_path)
    said = caught.value.message("en")
    assert [word for word in words if word not in said] == [], said
    arabic = caught.value.message("ar")
    assert arabic != said
    assert any("\u0600" <= c <= "\u06ff" for c in arabic)


@pytest.mark.parametrize(("call", "words"), WARNED.values(), ids=WARNED.keys())
def test_a_doubtful_line_is_answered_with_a_warning(call: Call, words: tuple[str, ...], tmp_path: Path) -> None:
    with pytest.warns(MafsilWarning) as caught:
        answer = call(tmp_path)
    assert answer is not None
    said = str(caught[0].message)
    assert [word for word in words if word not in said] == [], said


@pytest.mark.parametrize("call", ACCEPTED.values(), ids=ACCEPTED.keys())
def test_a_line_that_means_something_is_understood(call: Call, tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", MafsilWarning)
        call(tmp_path)


def test_lint_of_a_missing_file_shows_why_at_the_prompt() -> None:
    report = mf.lint("nope.urdf")
    assert not report.ok
    assert "nope.urdf" in repr(report)
    assert "check the path" in repr(report)
