"""What a run says of itself: nothing green that is not, each miss with its cause, in both languages."""

import json
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mafsil.cli.main import main
from mafsil.errors import InputWarning, JobError
from mafsil.job import Run, parse_job, solve
from mafsil.job.judging.holding import overloads, planned_overloads
from mafsil.job.judging.judgement import Summary, summary
from mafsil.job.judging.symptoms import split
from mafsil.messages.quantities import digits, quantity
from mafsil.report.contents import verdict
from mafsil.report.replay import part_tracks
from mafsil.report.results import as_data
from tests.reliability.job_verdicts import judged

SOFT = """
robot = "puma560"
angles = "degrees"
[start]
pose = { position = [0.50, 0.0, 0.15], rpy = [180, 0, 0] }
[controller]
kind = "pd_gravity"
kp = 5
kd = 20
friction = false
[[move]]
name = "above the part"
pose = { position = [0.45, 0.25, 0.05], rpy = [180, 0, 0] }
[[move]]
name = "grip"
pick = { name = "part", mass = 2.0, size = [0.05, 0.05, 0.05] }
[[move]]
name = "across"
pose = { position = [0.45, -0.25, 0.05], rpy = [180, 0, 0] }
[[move]]
place = true
"""
TURN = """
robot = "puma560"
angles = "degrees"
[start]
pose = { position = [0.45, 0.2, 0.05], rpy = [180, 0, 0] }
[controller]
kind = "pd_gravity"
kp = [3000, 4000, 2000, 300, 300, 0.05]
kd = [300, 400, 150, 12, 12, 0.01]
friction = false
[[move]]
name = "turn the tool"
pose = { position = [0.45, 0.2, 0.05], rpy = [180, 0, 90] }
"""
REACH = """
robot = "panda"
[start]
joints = [0, -0.4, 0, -2.0, 0, 1.8, 0.8]
[simulation]
step = 0.002
[[move]]
name = "there"
joints = [0.3, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]
"""
RUBBING = """<robot name="gripper"><link name="hand"/>
<link name="jaw"><inertial><mass value="0.3"/><origin xyz="0.1 0 0"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="squeeze" type="revolute"><parent link="hand"/><child link="jaw"/><axis xyz="0 0 1"/>
<limit lower="-1.5" upper="0.5" velocity="2" effort="8"/><dynamics friction="{friction}" damping="0"/></joint>
</robot>"""


@cache
def solved(text: str, folder: Path = Path()) -> tuple[Run, Summary]:
    run = solve(parse_job(text), text, folder)
    assert isinstance(run, Run), run.explain()
    return run, summary(run)


def sentences(run: Run, level: str) -> list[str]:
    return [remark.sentence("en") for remark in run.remarks if remark.level == level]


def test_a_soft_arm_misses_every_target_and_says_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run, numbers = solved(SOFT)
    assert len(numbers.not_reached) == numbers.targets == 4
    assert verdict(run, "en").text == "targets not reached: 4 of 4"
    said = sentences(run, "failure")
    assert "move 1 'above the part' does not reach its target: the tip is 271 mm and 29.3° off" in said[0]
    assert "cause: joint friction; without it " in said[0]
    assert "remedy, verified by simulation: friction = true in [controller]" in said[0] or "worth trying" in said[0]
    assert "the part was not gripped" in said[1]
    assert not any("targets reached" in sentence for sentence in sentences(run, "good"))
    (tmp_path / "soft.toml").write_text(SOFT, encoding="utf-8")
    assert main(["run", str(tmp_path / "soft.toml"), "--out", str(tmp_path / "out")]) == 1
    shown = capsys.readouterr()
    assert shown.err.startswith("mafsil: move 1 'above the part' does not reach")
    assert "0 of 4" in shown.out
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "not reached: 271 mm and 29.3° off" in page
    assert 'class="chip failure"' in page
    targets = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))["targets"]
    assert [target["reached"] for target in targets] == [False] * 4
    assert targets[0]["position_error"] == pytest.approx(0.2713, abs=1e-3)
    assert targets[0]["tolerance"] == {
        "position": 1e-3,
        "orientation": np.radians(0.5),
        "joints": [np.radians(0.5)] * 6,
    }


def test_a_wrong_orientation_is_a_miss() -> None:
    run, numbers = solved(TURN)
    (judged,) = numbers.not_reached
    assert judged.position_error < 1e-4
    assert np.degrees(judged.orientation_error) == pytest.approx(89.99, abs=0.02)
    assert "90° off" in sentences(run, "failure")[0]


@pytest.mark.parametrize(
    ("friction", "compensated", "reached"), [(3.0, False, False), (3.0, True, True), (0.0, False, True)]
)
def test_a_joint_that_friction_holds_misses_its_goal_unless_it_is_compensated(
    tmp_path: Path, friction: float, compensated: bool, reached: bool
) -> None:
    (tmp_path / "gripper.urdf").write_text(RUBBING.format(friction=friction), encoding="utf-8")
    text = 'robot = "gripper.urdf"\n[start]\njoints = [-0.3]\n[[move]]\njoints = [-1.0]\n'
    run, numbers = solved(text + f"[controller]\nfriction = {str(compensated).lower()}\n", tmp_path)
    assert (not numbers.not_reached) == reached
    assert (verdict(run).level == "failure") != reached
    if not reached:
        assert "squeeze is 40.1° off" in sentences(run, "failure")[0]
        assert "cause: joint friction; without it " in sentences(run, "failure")[0]
        assert "remedy, verified by simulation: friction = true in [controller]" in sentences(run, "failure")[0]


def test_a_part_that_is_missed_stays_where_it_lies() -> None:
    run, _ = solved(SOFT)
    held = [driven for driven in run.driven if driven.stretch.carried is not None]
    assert [driven.gripped for driven in held] == [False]
    assert held[0].carried is None
    assert held[0].scenario.true_plant.robot is run.robot, "the arm moves on empty"
    (lying,) = (one.track for one in part_tracks(run, np.linspace(0.0, 2.0, 9)) if one.body.name == "part")
    goal = run.plan.legs[1].trajectory.at(0.0).u
    np.testing.assert_allclose(lying, np.tile(np.asarray(run.robot.forward_kinematics(goal)), (9, 1, 1)), atol=1e-12)
    taken, _ = solved(SOFT.replace("kp = 5\nkd = 20\n", "").replace("0.25, 0.05]", "0.05, 0.1]"))
    assert all(driven.gripped for driven in taken.driven)


def test_tolerances_of_the_job_and_of_a_move() -> None:
    assert not solved(REACH)[1].not_reached
    assert solved(REACH + "tolerance = { joints = 1e-7 }\n")[1].not_reached
    assert solved("tolerance = { joints = 1e-7 }\n" + REACH)[1].not_reached
    assert not solved("tolerance = { joints = 1e-7 }\n" + REACH + "tolerance = { joints = 0.1 }\n")[1].not_reached
    each = "tolerance = { joints = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 1e-7] }\n"
    assert [judged.goal for judged in solved(each + REACH)[1].not_reached] == ["joints"]
    degrees = solved(SOFT + "[tolerance]\norientation = 40\nposition = 0.4\n")[1]
    assert not degrees.not_reached
    with pytest.raises(JobError) as caught:
        solved("tolerance = { joints = [0.1] }\n" + REACH)
    assert caught.value.key == "job.list_count"


@pytest.mark.parametrize(
    "move",
    [
        "pause = 1.0\ntolerance = { position = 0.1 }",
        "pose = { position = [0.4, 0.0, 0.4] }\ntolerance = { joints = 0.1 }",
        "joints = [0, -0.4, 0, -2.0, 0, 1.8, 0.8]\ntolerance = { orientation = 0.1 }",
    ],
)
def test_tolerances_without_effect_are_refused(move: str) -> None:
    with pytest.raises(JobError) as caught:
        parse_job(REACH + f"[[move]]\n{move}\n")
    assert caught.value.key == "job.no_tolerance"
    assert caught.value.details["line"]


def test_an_arm_that_cannot_hold_its_part_says_so_and_gives_way() -> None:
    run, _ = solved(REACH + "[[move]]\npick = { mass = 50 }\n[[move]]\njoints = [0, 0.6, 0, -0.9, 0, 1.8, 0.8]\n")
    assert verdict(run).text == "the arm gives way"
    said = sentences(run, "failure")
    assert any(s.startswith("holding 50 kg (part) at ") and "of the effort of joint6" in s for s in said)
    assert any(s.startswith("the arm gives way: joint") for s in said)
    assert not any("+" in s or "e-" in s for s in said)


def test_holding_efforts_are_those_of_statics(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One arm of 1 m that turns about a level axis, 2 kg at its end, and a part of 3 kg: 5 g N m."""
    urdf = """<robot name="arm"><link name="a"/><link name="b"><inertial><origin xyz="1 0 0"/><mass value="2"/>
    <inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="tip"/>
    <joint name="lift" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" velocity="2" effort="EFFORT"/></joint>
    <joint name="end" type="fixed"><parent link="b"/><child link="tip"/><origin xyz="1 0 0"/></joint></robot>"""
    text = 'robot = "arm.urdf"\n[[move]]\njoints = [0.3]\n[[move]]\npick = { mass = 3 }\n[[move]]\njoints = [0.0]\n'
    for effort, held in ((40.0, False), (60.0, True)):
        (tmp_path / "arm.urdf").write_text(urdf.replace("EFFORT", str(effort)), encoding="utf-8")
        run, _ = solved.__wrapped__(text, tmp_path)  # the file behind the same text differs
        said = [s for s in sentences(run, "failure") if s.startswith("holding 3 kg")]
        assert bool(said) != held
        assert planned_overloads(run.job, run.plan) == overloads(run), "the same is said before anything moves"
        (tmp_path / "lift.toml").write_text(text, encoding="utf-8")
        assert main(["check-job", str(tmp_path / "lift.toml")]) == (0 if held else 1)
        assert ("holding 3 kg" in capsys.readouterr().err) != held
        if said:
            assert f"needs {quantity(5 * 9.81 / effort, 'share')} of the effort of lift" in said[0]


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        ("[simulation]\nstep = 0.002\nmass_error = 0.5\n", "the real masses differ"),
        ("[controller]\nfrequency = 4\n[simulation]\nstep = 0.002\nmass_error = 0.5\n", "the real masses differ"),
        (
            "[simulation]\nstep = 0.002\n[controller]\nfrequency = 2000\nrate = 500\n",
            "gains too high for 500 Hz",
        ),
        (
            '[controller]\nkind = "pd_gravity"\nkp = 20\nkd = 0.2\n[simulation]\nstep = 0.002\n',
            "pd_gravity with these gains lags behind",
        ),
        ("[[disturbance]]\nstart = 0.1\nduration = 9.0\nwrench = [0, 0, 0, 0, 0, 60]\n", "external force at the tip"),
    ],
)
def test_causes_are_named(change: str, cause: str) -> None:
    text = REACH.replace("[simulation]\nstep = 0.002\n", change)
    run, _ = solved(text + "tolerance = { joints = 0.003 }\n" if change.startswith("[[") is False else text)
    assert any(cause in sentence for sentence in sentences(run, "failure")), sentences(run, "failure")


def test_an_unknown_part_is_the_cause() -> None:
    more = "[[move]]\npick = { mass = 3.0, known = false }\n[[move]]\njoints = [0, -0.4, 0, -2.0, 0, 1.8, 0.8]\n"
    run, _ = solved(REACH + more)
    assert any("does not know the mass of the part" in sentence for sentence in sentences(run, "failure"))


def test_the_split_of_an_error_adds_up() -> None:
    for text in (SOFT, REACH + "[[disturbance]]\nstart = 0.1\nduration = 1\nwrench = [1, 2, 3, 10, 20, 30]\n"):
        run, _ = solved(text)
        for row in (20, 300):
            parts = split(run, run.driven[0], row)
            assert parts is not None
            np.testing.assert_allclose(sum(parts.parts().values()), parts.error, rtol=1e-8, atol=1e-12)


def test_actual_speed_and_acceleration_are_judged() -> None:
    push = "[[disturbance]]\nstart = 0.1\nduration = 0.004\nwrench = [0, 0, 1, 0, 0, 0]\n"
    run, numbers = solved(REACH + push)
    over = numbers.peak_acceleration > 1.02 * run.robot.limits.acceleration
    assert over.any()
    said = {remark.details["joint"]: remark for remark in run.remarks if remark.key == "job.acceleration_crossed"}
    for joint, is_over in zip(run.robot.joint_names, over, strict=True):
        assert (joint in said and said[joint].level == "failure") == is_over
    assert "exceeds its acceleration limit of" in sentences(run, "failure")[0]


@pytest.mark.parametrize("method", ["rk4", "semi_implicit_euler"])
def test_an_integrator_is_used_or_refused(method: str) -> None:
    stiff = (
        f'robot = "puma560"\n[simulation]\nmethod = "{method}"\n[[move]]\njoints = [0.3, 0.5, -1.8, 0.2, 0.5, 0.2]\n'
    )
    with pytest.raises(JobError) as caught:
        solved(stiff)
    assert caught.value.key == "job.stiff_method"
    assert "implicit_friction" in caught.value.message("en")
    run, _ = solved(stiff.replace("[simulation]", "[simulation]\nfriction = false"))
    assert as_data(run, summary(run))["simulation"]["method"] == method


def test_the_integrator_that_was_chosen_is_said() -> None:
    text = 'robot = "puma560"\n[[move]]\njoints = [0.3, 0.5, -1.8, 0.2, 0.5, 0.2]\n'
    run, numbers = solved(text)
    data = as_data(run, numbers)["simulation"]
    assert (data["method_requested"], data["method"]) == (None, "implicit_friction")
    assert any("implicit_friction" in sentence for sentence in sentences(run, "good"))
    named, _ = solved(text.replace("[[move]]", '[simulation]\nmethod = "implicit_friction"\n[[move]]'))
    assert not any("implicit_friction" in sentence for sentence in sentences(named, "good"))


def test_a_part_still_held_at_the_end_is_said() -> None:
    run, _ = solved(REACH + "[[move]]\npick = { mass = 0.1, name = 'bolt' }\n")
    assert any("'bolt' still in the tool" in sentence for sentence in sentences(run, "warning"))
    put, _ = solved(REACH + "[[move]]\npick = { mass = 0.1 }\n[[move]]\nplace = true\n[simulation.noise]\nseed = 1\n")
    assert not any("still in the tool" in sentence for sentence in sentences(put, "warning"))


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (0.2734, "m", "273 mm"),
        (1.2734, "m", "1.27 m"),
        (12e-6, "m", "12 µm"),
        (0.00051, "m", "0.51 mm"),
        (0.5, "rad", "28.6°"),
        (1e-16, "rad", "0°"),
        (2.0, "kg", "2 kg"),
        (2.3, "share", "230 %"),
        (1192132.68, "share", "119,000,000 %"),
        (0.9999, "m", "1,000 mm"),
        (-0.02, "m", "-20 mm"),
        (0.25, "s", "250 ms"),
        (float("inf"), "m", "inf m"),
    ],
)
def test_quantities_are_for_people(value: float, unit: str, shown: str) -> None:
    assert quantity(value, unit) == shown


def test_digits_never_have_an_exponent() -> None:
    for power in range(-30, 31):
        text = digits(1.2345 * 10.0**power)
        assert "e" not in text
        if power > -7:
            assert float(text.replace(",", "")) == pytest.approx(1.2345 * 10.0**power, rel=5e-3)


def test_what_an_integral_has_stored_is_no_noise():
    """Without noisy sensors nothing of the error of a PID law comes from noise, and the parts add up."""
    text = """
robot = "puma560"
[controller]
kind = "pid"
[simulation]
mass_error = 0.03
settle = 0.1
[[move]]
joints = [0.3, -0.2, 0.2, 0.2, -0.2, 0.3]
"""
    run = solve(parse_job(text), text, Path())
    for row in (0, 57, len(run.recording.t) - 1):
        parts = split(run, run.driven[0], row).parts()
        assert np.abs(parts["rest"]).max() < 1e-12
        e = run.recording.q_ref[row] - run.recording.q[row]
        assert np.abs(sum(parts.values()) - e).max() < 1e-9
    assert np.abs(parts["integral"]).max() > 1e-3
    assert "noise" not in run.explain("en")


@pytest.mark.parametrize("number", [200000, 200003])
def test_a_stretch_that_begins_where_another_ended_is_no_start_that_somebody_gave(number):
    """Arms that gave way, driven on and again for the causes: no warning of limits or degrees."""
    with warnings.catch_warnings(action="error", category=InputWarning):
        assert judged(number)["bad_words"] == 0
