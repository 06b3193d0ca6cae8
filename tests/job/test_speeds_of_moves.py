"""Speeds and accelerations of single moves, and the units of a file in degrees and millimetres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mafsil.errors import JobError
from mafsil.job import parse_job
from mafsil.job.planning.plan import Plan
from mafsil.job.solve import prepare

HEAD = 'robot = "ur5e"\n{units}\n[limits]\n{limits}\n[start]\njoints = {start}\n'
Q = np.array([0.3, -1.4, 1.5, -1.6, -1.5, 0.2])


def planned(moves: str, limits: str = "", units: str = "", start: np.ndarray = Q) -> Plan:
    text = HEAD.format(units=units, limits=limits, start=start.tolist()) + moves
    found = prepare(parse_job(text), text, Path())
    assert isinstance(found, tuple)
    return found[1]


def tip_rates(plan: Plan, leg: int) -> tuple[float, float, float]:
    """Largest speed [m/s], acceleration [m/s^2] and angular speed [rad/s] of the tip, by differences of poses."""
    part, robot = plan.legs[leg].trajectory, plan.legs[leg].load.robot
    t = np.linspace(0.0, part.duration, 4001)
    T = np.asarray(robot.forward_kinematics(part.at(t).u))
    v = np.gradient(T[:, :3, 3], t, axis=0)
    a = np.gradient(v, t, axis=0)
    turn = T[:-1, :3, :3].swapaxes(-1, -2) @ T[1:, :3, :3]
    angle = np.arccos(np.clip((np.trace(turn, axis1=1, axis2=2) - 1) / 2, -1, 1))
    speed, acceleration = np.linalg.norm(v, axis=1).max(), np.linalg.norm(a[5:-5], axis=1).max()
    return float(speed), float(acceleration), float(angle.max() / t[1])


LINE = """
[[move]]
path = "line"
profile = "{profile}"
{own}
pose = {{ position = [0.0, 0.12, -0.05], relative = "space" }}
"""
TURN = """
[[move]]
path = "line"
tip_angular_speed = {w}
pose = {{ position = [0, 0, 0], rpy = [0, 0, {a}], relative = "tool" }}
"""


@pytest.mark.parametrize("profile", ["quintic", "trapezoid", "time_optimal"])
def test_a_move_has_its_own_speed_of_the_tip(profile: str) -> None:
    plan = planned(LINE.format(profile=profile, own="tip_speed = 0.04") + LINE.format(profile=profile, own=""))
    assert tip_rates(plan, 0)[0] == pytest.approx(0.04, rel=0.02)
    assert tip_rates(plan, 1)[0] > 0.1
    slow = planned(LINE.format(profile=profile, own="tip_acceleration = 0.05"))
    assert tip_rates(slow, 0)[1] <= 0.05 * 1.05


def test_a_turn_has_its_own_angular_speed_in_the_unit_of_the_file() -> None:
    radians = planned(TURN.format(w=0.2, a=0.6))
    asked = TURN.format(w=np.degrees(0.2), a=np.degrees(0.6))
    degrees = planned(asked, units='angles = "degrees"', start=np.degrees(Q))
    assert tip_rates(radians, 0)[2] == pytest.approx(0.2, rel=0.01)
    assert degrees.duration == pytest.approx(radians.duration, rel=1e-9)


def test_millimetres_per_second() -> None:
    text = LINE.replace("[0.0, 0.12, -0.05]", "[0, 120, -50]").format(profile="quintic", own="tip_speed = 40")
    plan = planned(text, units='lengths = "millimetres"')
    assert tip_rates(plan, 0)[0] == pytest.approx(0.04, rel=0.02)


@pytest.mark.parametrize("profile", ["quintic", "trapezoid", "time_optimal", "jerk_limited"])
def test_no_joint_is_faster_than_its_move_allows(profile: str) -> None:
    goal = np.add(Q, [0.8, 0.3, -0.4, 0.2, 0.1, 1.0]).tolist()
    moves = f'[[move]]\nprofile = "{profile}"\njoint_speed = 0.25\njoints = {goal}\n'
    moves += f'[[move]]\nprofile = "{profile}"\njoint_acceleration = 0.3\njoints = {Q.tolist()}\n'
    plan = planned(moves)
    first, second = (plan.legs[k].trajectory for k in (0, 1))
    rates = np.abs(first.at(np.linspace(0, first.duration, 3001)).v)
    assert rates.max() == pytest.approx(0.25, rel=0.01)
    accelerations = np.abs(second.at(np.linspace(0, second.duration, 3001)[1:-1]).a)
    assert accelerations.max() <= 0.3 * 1.001
    assert accelerations.max() > 0.3 * 0.9


def test_blended_moves_keep_the_lowest() -> None:
    one = LINE.format(profile="time_optimal", own="tip_speed = 0.05").replace("[[move]]", "[[move]]\nblend = 0.02")
    two = LINE.format(profile="time_optimal", own="").replace("[0.0, 0.12, -0.05]", "[0.0, 0.0, -0.1]")
    plan = planned(one + two)
    assert tip_rates(plan, 0)[0] <= 0.05 * 1.02


def test_limits_of_a_file_in_degrees_are_degrees(tmp_path: Path) -> None:
    """For joints without limits of their own: 100 of a file in degrees are 100 deg/s^2, and the remark says so."""
    plans = [
        planned(
            f"[[move]]\njoints = {(unit * (Q + 0.5)).tolist()}\n", f"acceleration = {unit * 1.5}", units, start=unit * Q
        )
        for unit, units in ((1.0, ""), (180 / np.pi, 'angles = "degrees"'))
    ]
    assert plans[0].duration == pytest.approx(plans[1].duration, rel=1e-9)
    (said,) = [each.sentence("en") for each in plans[1].remarks if each.key == "job.acceleration_assumed"]
    assert "1.5 rad/s²" in said


@pytest.mark.parametrize(
    ("moves", "key"),
    [
        (f"[[move]]\ntip_speed = 0.1\njoints = {Q.tolist()}\n", "job.no_effect"),
        ("[[move]]\ntip_speed = 0.1\npose = { position = [0.4, 0.1, 0.3] }\n", "job.tip_bound"),
        ("[[move]]\njoint_speed = 1.0\npause = 1.0\n", "job.no_effect"),
        (f"[[move]]\njoint_speed = 0.0\njoints = {Q.tolist()}\n", "job.bound"),
        (f"[[move]]\njoint_speed = nan\njoints = {Q.tolist()}\n", "job.bound"),
    ],
)
def test_what_has_no_effect_is_refused(moves: str, key: str) -> None:
    with pytest.raises(JobError) as caught:
        planned(moves)
    assert caught.value.key == key


@pytest.mark.parametrize("own", ["joint_jerk = 2.0", "tip_jerk = 0.8"])
def test_a_move_keeps_its_own_jerk(own: str) -> None:
    plan = planned(LINE.replace('profile = "{profile}"\n', "").format(own=own))
    part, robot = plan.legs[0].trajectory, plan.legs[0].load.robot
    t = np.linspace(0.0, part.duration, 2001)
    p = np.asarray(robot.forward_kinematics(part.at(t).u))[:, :3, 3] - robot.forward_kinematics(Q)[:3, 3]
    along = np.linalg.norm(p, axis=1)
    a = np.gradient(np.gradient(along, t), t) if own.startswith("tip") else part.at(t).a
    steps = np.abs(np.diff(a[5:-5], axis=0)).max() / t[1]
    least = 0.9 if own.startswith("tip") else 0.5
    assert least * float(own.split()[-1]) < steps < 1.02 * float(own.split()[-1])


@pytest.mark.parametrize(
    ("own", "line"),
    [("tip_jerk = 1\nblend = 0.01", 10), ("joint_jerk = 1", 10), ('tip_jerk = 1\npath = "screw"', 10)],
)
def test_a_jerk_that_would_not_be_kept_is_refused(own: str, line: int) -> None:
    move = LINE.format(profile="quintic", own=own)
    move = move.replace('path = "line"\n', "") if "screw" in own else move
    with pytest.raises(JobError, match="the jerk is limited where"):
        planned(move + LINE.format(profile="time_optimal", own=""))
