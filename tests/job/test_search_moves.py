"""Moves that a signal or a force ends early, and arms that are led by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import JobError
from mafsil.job import Refusal, Run, parse_job, solve
from mafsil.job.planning.searching import StoppedMotion
from mafsil.job.solve import prepare
from mafsil.trajectory import quintic

TOUCH = """
robot = "panda"
angles = "degrees"
[start]
pose = { position = [0.45, 0.1, 0.22], rpy = [180, 0, 0] }
[controller]
kind = "impedance"
tip_stiffness = 1500
[tolerance]
position = 0.02
[[surface]]
point = [0, 0, 0.2]
normal = [0, 0, 1]
stiffness = 5e3
damping = 200
[[move]]
name = "touch"
pose = { relative = "space", position = [0, 0, -0.05] }
path = "line"
tip_speed = 0.02
until_force = 8
[[move]]
name = "back"
pose = { relative = "space", position = [0, 0, 0.03] }
path = "line"
"""
GATE = """
robot = "panda"
angles = "degrees"
[input.edge]
changes = [[1.0, true]]
[start]
pose = { position = [0.45, 0.2, 0.4], rpy = [180, 0, 0] }
[[move]]
name = "scan"
pose = { relative = "space", position = [0, -0.3, 0] }
path = "line"
tip_speed = 0.1
until = { edge = true }
[[move]]
pose = { relative = "space", position = [0, 0, 0.05] }
path = "line"
"""
HAND = """
robot = "ur5e"
angles = "degrees"
[start]
joints = [0, -90, 90, -90, -90, 0]
[controller]
kind = "admittance"
tip_mass = 5
tip_stiffness = [0, 0, 2000]
tip_damping = [40, 40, 200]
rotational_stiffness = 200
[[disturbance]]
start = 0.2
duration = 0.8
wrench = [0, 0, 0, 10, 0, 0]
[[move]]
pause = 2
"""


def planned(text):
    found = prepare(parse_job(text, "job.toml"), text, Path())
    return found if isinstance(found, Refusal) else found[1]


def driven(text):
    return solve(parse_job(text, "job.toml"), text, Path())


@given(st.floats(0.05, 1.8), st.floats(0.01, 0.3))
@settings(max_examples=20, deadline=None)
def test_a_stopped_motion_keeps_its_path_and_its_derivatives(stop, brake):
    whole = quintic(np.zeros(2), np.array([1.0, -2.0]), 2.5)
    motion = StoppedMotion(whole, stop, brake)
    t = np.linspace(0.0, motion.duration, 41)[1:-1]
    t = t[np.abs(t - stop) > 1e-4]
    step = 1e-6
    before, after, here = motion.at(t - step), motion.at(t + step), motion.at(t)
    np.testing.assert_allclose((after.u - before.u) / (2 * step), here.v, atol=1e-7)
    np.testing.assert_allclose((after.v - before.v) / (2 * step), here.a, atol=1e-5)
    np.testing.assert_allclose((after.a - before.a) / (2 * step), motion.jerk(t), atol=1e-3)
    np.testing.assert_allclose(here.u[:, 1], -2.0 * here.u[:, 0], atol=1e-12)
    assert np.abs(motion.at(motion.duration).v).max() < 1e-12


def test_a_force_ends_a_move_and_the_next_one_starts_there():
    run = driven(TOUCH)
    assert isinstance(run, Run)
    assert run, run.explain("en")
    leg, end = run.plan.legs[0], run.plan.starts[1]
    force = np.linalg.norm(run.recording.contact_wrench[:, 3:], axis=1)
    stop = np.searchsorted(run.recording.t, leg.stopped)
    assert force[stop - 3] < 8.0 <= force[stop + 1]
    assert force.max() < 8.5
    place = np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(leg.trajectory.duration).u))
    last = np.asarray(leg.load.robot.forward_kinematics(run.plan.legs[1].trajectory.at(9.0).u))
    assert place[2, 3] == pytest.approx(0.2 - 8.0 / 1500.0, abs=2e-3)
    assert last[2, 3] - place[2, 3] == pytest.approx(0.03, abs=1e-6)
    assert end < 2.0


def test_a_search_that_finds_nothing_fails_and_a_plan_alone_says_that_it_does_not_know():
    run = driven(TOUCH.replace("until_force = 8", "until_force = 800"))
    assert not run
    assert "without a contact force of 800 N" in run.explain("en")
    plan = planned(TOUCH)
    assert any(remark.key == "job.search_open" for remark in plan.remarks)


def test_a_signal_ends_a_move_at_its_tick():
    plan = planned(GATE)
    leg = plan.legs[0]
    stopped = leg.trajectory
    assert isinstance(stopped, StoppedMotion)
    assert stopped.stop == pytest.approx(1.0, abs=1.1e-3)
    tip = np.asarray(leg.load.robot.forward_kinematics(stopped.at(stopped.duration).u))
    assert 0.1 < tip[1, 3] < 0.12
    assert driven(GATE)


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (GATE, "[[1.0, true]]", "[[9.0, true]]", "reaches the end of its path before edge = true"),
        (GATE, 'until = { edge = true }\n', 'until = { edge = true }\nblend = 0.01\n', "leave out blends"),
    ],
)  # fmt: skip
def test_searches_that_cannot_be_are_refused_with_their_move(text, old, new, said):
    found = planned(text.replace(old, new))
    assert isinstance(found, Refusal)
    assert said in found.explain("en")


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (TOUCH, TOUCH[TOUCH.index("[[surface]]") : TOUCH.index("[[move]]")], "", "needs something to touch"),
        (TOUCH, "until_force = 8", "until_force = 8\nblend = 0.01", "goes neither with 'until' nor with 'blend'"),
        (GATE, "until = { edge = true }", "until = { edge = 3 }", "edge"),
        (HAND, "tip_damping = [40, 40, 200]\n", "", "nothing brakes the arm"),
        (HAND, "[40, 40, 200]", "[40, 40]", "is one number, or three"),
        (HAND, 'kind = "admittance"\ntip_mass = 5', 'kind = "computed_torque"', "tip_stiffness"),
    ],
)
def test_wrong_keys_are_refused_with_their_line(text, old, new, said):
    with pytest.raises(JobError, match=r"job\.toml:") as caught:
        parse_job(text.replace(old, new, 1), "job.toml")
    assert said in str(caught.value)


def test_a_hand_leads_an_arm_as_far_as_its_impulse_and_the_damper_say():
    run = driven(HAND)
    assert run, run.explain("en")
    tips, planned_tips = run.tips(slice(-1, None))
    np.testing.assert_allclose((tips - planned_tips)[0, :3, 3], [0.0, 10.0 * 0.8 / 40.0, 0.0], atol=2e-3)
    assert any(remark.key == "job.guided" for remark in run.remarks)
    assert not any(remark.key.startswith("job.unstable") for remark in run.remarks)
