"""Moves in the shortest time: time_optimal along paths and lines, jerk_limited between points and through them."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.job.language.reading import parse_job
from mafsil.job.planning.planned_remarks import driving_limits
from mafsil.trajectory import check
from tests.job.test_job_planning import PANDA, SLOW, VIA, complaint, planned, refused

POINTS = "joints = [0.3, 0.4, 0.1, -1.2, 0.3, 1.9, 0.2]\n"
THROUGH = POINTS + "via = [[0.2, 0.2, 0.3, -2.0, 0.2, 1.5, 0.5], [-0.3, 0.5, 0.2, -1.7, 0.2, 2.0, 0.3]]\n"
LINE = 'pose = { position = [0.5, 0.1, 0.5] }\npath = "line"\n'


def leg_of(text):
    robot, plan = planned(text)
    return robot, plan, plan.legs[0].trajectory


@pytest.mark.parametrize("goal", [POINTS, THROUGH, LINE])
def test_the_shortest_time_keeps_all_limits_and_beats_every_law(goal):
    robot, plan, motion = leg_of(PANDA + f'[[move]]\n{goal}profile = "time_optimal"\n')
    limits, _ = driving_limits(parse_job(PANDA + f"[[move]]\n{goal}"), robot)
    assert check(motion, limits, tolerance=1e-6)
    t = np.linspace(0.0, motion.duration, 20001)
    u = motion.at(t)
    used = np.maximum((np.abs(u.v) / limits.velocity).max(axis=1), (np.abs(u.a) / limits.acceleration).max(axis=1))
    tip = robot.forward_kinematics(u.u)[:, :3, 3]
    speed = np.linalg.norm(np.gradient(tip, t, axis=0), axis=1)
    if goal is LINE:
        assert speed.max() <= 0.25 * (1 + 1e-4)
    else:
        assert np.median(used) > 0.999, "at every moment some limit decides"
    laws = [None] if goal is THROUGH else ["quintic", "trapezoid", "double_s"]
    for law in laws:
        profile = "" if law is None else f'profile = "{law}"\n'
        assert motion.duration < leg_of(PANDA + f"[[move]]\n{goal}{profile}")[2].duration * (1 + 1e-7)
    said = [remark for remark in plan.remarks if remark.key == "job.decided_by"]
    assert len(said) == 1
    assert "%" in said[0].sentence("en")
    assert said[0].sentence("ar") != said[0].sentence("en")


def test_a_nearly_singular_line_is_as_quick_as_it_can_be():
    """A smooth law along the same line takes up to twice as long; TOPP-RA, on a grid, 1.29 s."""
    robot, _, motion = leg_of(SLOW + 'profile = "time_optimal"\n')
    assert 1.2 < motion.duration < 1.29
    limits, _ = driving_limits(parse_job(SLOW), robot)
    assert check(motion, limits, tolerance=1e-6)


@pytest.mark.parametrize("goal", [POINTS, THROUGH, LINE])
def test_limited_jerk_is_limited(goal):
    text = PANDA + f'[limits]\njerk = 60\n[[move]]\n{goal}profile = "jerk_limited"\n'
    robot, _, motion = leg_of(text)
    limits, _ = driving_limits(parse_job(text), robot)
    assert np.isfinite(limits.jerk).all()
    assert check(motion, limits, tolerance=1e-6)
    if goal is not THROUGH:
        assert motion.duration > leg_of(PANDA + f'[[move]]\n{goal}profile = "time_optimal"\n')[2].duration
    end = motion.at(motion.duration)
    if goal is LINE:
        np.testing.assert_allclose(robot.forward_kinematics(end.u)[:3, 3], [0.5, 0.1, 0.5], atol=1e-6)
    else:
        np.testing.assert_allclose(end.u, [0.3, 0.4, 0.1, -1.2, 0.3, 1.9, 0.2], atol=1e-9)
    np.testing.assert_allclose(motion.at([0.0, motion.duration]).v, 0.0, atol=1e-9)


@pytest.mark.parametrize(
    "move",
    [POINTS + 'profile = "time_optimal"\n', POINTS + 'profile = "jerk_limited"\n', LINE + 'profile = "time_optimal"\n'],
)
def test_a_duration_is_kept_or_the_shortest_is_said(move):
    shortest = leg_of(PANDA + f"[[move]]\n{move}")[2].duration
    _, plan, slow = leg_of(PANDA + f"[[move]]\n{move}duration = {2 * shortest}\n")
    assert slow.duration == pytest.approx(2 * shortest)
    assert not [remark for remark in plan.remarks if remark.key in ("job.decided_by", "job.slow_line_velocity")]
    said = float(str(refused(PANDA + f"[[move]]\n{move}duration = {shortest / 2}\n").details["shortest"]))
    assert shortest <= said <= shortest + 1e-3


def test_profiles_that_do_not_fit_are_refused_with_what_does():
    fault = complaint(PANDA + f'[[move]]\n{VIA}profile = "cubic"\n')
    assert fault.key == "job.via_profile"
    assert "time_optimal" in fault.message("en")


def test_points_that_are_all_one_are_a_rest():
    text = PANDA + '[[move]]\njoints = [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6]\nprofile = "time_optimal"\n'
    motion = leg_of(text)[2]
    np.testing.assert_array_equal(motion.at(motion.duration).u, [0, -0.2, 0.1, -1.8, 0.1, 1.7, 0.6])


@pytest.mark.parametrize("robot", ["panda", "ur5e", "cobra600"])
@pytest.mark.parametrize("kind", ["computed_torque", "pd_gravity", "pid"])
def test_the_default_is_the_shortest_within_all_limits_unless_the_law_lags(robot, kind):
    """Jerk counts where the description has it; a straight line of the joints stays one."""
    arm = mf.load(robot)
    middle = np.clip(0.5, arm.limits.lower + 0.3, arm.limits.upper - 0.9)
    middle = np.where(arm.mechanism.angular, middle, np.clip(0.05, arm.limits.lower, arm.limits.upper))
    goal = middle + 0.1 * np.arange(1, arm.n + 1) * np.where(arm.mechanism.angular, 1.0, 0.1)
    head = f'robot = "{robot}"\n[controller]\nkind = "{kind}"\n[collision]\nself_collision = false\n'
    text = head + f"[start]\njoints = {middle.tolist()}\n[[move]]\njoints = {goal.tolist()}\n"

    def leg(more):
        return leg_of(text + more)[2]

    default, optimal, quintic = leg(""), leg('profile = "time_optimal"\n'), leg('profile = "quintic"\n')
    if kind != "computed_torque":
        assert default.duration == quintic.duration
        return
    assert optimal.duration * (1 - 1e-6) <= default.duration < 1.03 * optimal.duration < quintic.duration
    t = np.linspace(0.0, default.duration, 301)
    share = (default.at(t).u - middle) / (goal - middle)
    assert np.ptp(share, axis=1).max() < 1e-9
    if np.isfinite(arm.limits.jerk).all():
        assert (np.abs(default.jerk(t)) <= 0.7 * arm.limits.jerk * (1 + 1e-6)).all()
    # A duration that a quintic suits makes it one; a shorter one that is possible is kept.
    assert np.abs(leg(f"duration = {2 * quintic.duration}\n").at(0.0).a).max() < 1e-9
    short = 0.5 * (default.duration + quintic.duration)
    assert leg(f"duration = {short}\n").duration == pytest.approx(short)
