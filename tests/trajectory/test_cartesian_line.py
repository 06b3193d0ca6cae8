"""Straight moves stay on their line and on their branch, keep the rates, and say where and why they cannot."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.trajectory import Trajectory, cartesian_line, check
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.paths import CartesianPath

Q = np.array([0.1, -0.5, 0.2, -2.0, 0.1, 1.6, 0.7])


@pytest.fixture(scope="module")
def panda():
    return mf.load("panda")


def moved(T, offset, turn=(0.0, 0.0, 0.0)):
    goal = T.copy()
    goal[:3, 3] += offset
    goal[:3, :3] = T[:3, :3] @ rotation.exp(np.array(turn))
    return goal


@pytest.mark.capability("11-7", "11-38", "07-50")
@pytest.mark.parametrize("interpolation", ["straight", "screw"])
@pytest.mark.parametrize("law", ["quintic", "trapezoid"])
def test_the_tip_stays_on_the_path(panda, interpolation, law):
    T = panda.forward_kinematics(Q)
    goal = moved(T, [0.1, 0.2, -0.15], [0.3, -0.2, 0.4])
    outcome = cartesian_line(panda, Q, goal, law=law, interpolation=interpolation)
    assert outcome.status is PlanStatus.PLANNED
    motion = outcome.value
    assert isinstance(motion, Trajectory)
    t = np.linspace(0, motion.duration, 301)
    reached = panda.forward_kinematics(motion.at(t).u)
    wanted = CartesianPath(T, goal, interpolation).poses(motion.law.at(t).u[:, 0])
    assert np.abs(pose.error(reached, wanted)).max() <= 1e-6
    np.testing.assert_allclose(reached[-1], goal, atol=1e-9)
    np.testing.assert_allclose(motion.at([0.0, motion.duration]).v, 0.0, atol=1e-9)


def test_rates_are_the_jacobian_s(panda):
    """V_b = J_b qd along the path: the joint rates against the tip's twist, an independent method."""
    T = panda.forward_kinematics(Q)
    goal = moved(T, [0.1, 0.2, -0.15], [0.3, -0.2, 0.4])
    motion = cartesian_line(panda, Q, goal, duration=2.0).value
    t = motion.duration * np.arange(1, 16) / 16
    u, v, a = motion.at(t)
    s, rate, growth = motion.law.at(t)
    V, V_slope = CartesianPath(T, goal).twists(s[:, 0])
    J, J_rate = panda.jacobian_body(u), panda.jacobian_body_rate(u, v)
    np.testing.assert_allclose((J @ v[..., None])[..., 0], V * rate, atol=1e-5)
    acceleration = (J @ a[..., None] + J_rate @ v[..., None])[..., 0]
    np.testing.assert_allclose(acceleration, V_slope * rate**2 + V * growth, atol=1e-3)


def test_derivatives_are_derivatives(panda):
    T = panda.forward_kinematics(Q)
    motion = cartesian_line(panda, Q, moved(T, [0.2, 0.0, -0.2]), duration=1.5).value
    h = 1e-4
    t = np.array([0.31, 0.77, 1.21])
    ahead, behind, here = motion.at(t + h), motion.at(t - h), motion.at(t)
    np.testing.assert_allclose((ahead.u - behind.u) / (2 * h), here.v, atol=1e-6)
    np.testing.assert_allclose((ahead.v - behind.v) / (2 * h), here.a, atol=1e-5)
    np.testing.assert_allclose((ahead.a - behind.a) / (2 * h), motion.jerk(t), atol=1e-2)


@pytest.mark.capability("11-11")
def test_shortest_duration_touches_a_limit(panda):
    T = panda.forward_kinematics(Q)
    motion = cartesian_line(panda, Q, moved(T, [0.2, 0.1, -0.2])).value
    assert check(motion, panda.limits, tolerance=1e-6)
    assert not check(motion.scale_time(0.999), panda.limits, tolerance=1e-6)


def test_too_fast_is_named_or_stretched(panda):
    T = panda.forward_kinematics(Q)
    goal = moved(T, [0.2, 0.1, -0.2])
    refused = cartesian_line(panda, Q, goal, duration=0.2)
    assert refused.status is PlanStatus.RATE_LIMIT
    assert refused.details["joint"] in panda.joint_names
    assert refused.value.duration == pytest.approx(0.2)
    stretched = cartesian_line(panda, Q, goal, duration=0.2, stretch=True)
    assert stretched.status is PlanStatus.STRETCHED
    assert stretched.value.duration == pytest.approx(refused.details["shortest"])
    assert check(stretched.value, panda.limits, tolerance=1e-6)
    for outcome in (refused, stretched):
        assert str(refused.details["joint"]) in outcome.explain("en")
        assert outcome.explain("ar")


@pytest.mark.capability("11-10")
def test_leaving_the_reach_is_placed(panda):
    """The tip moves outwards until the arm is straight: the place agrees with a direct search along the line."""
    T = panda.forward_kinematics(Q)
    outcome = cartesian_line(panda, Q, moved(T, [1.0, 0.0, 0.0]))
    assert outcome.value is None
    assert outcome.status in (PlanStatus.NOT_FOUND, PlanStatus.ORIENTATION_NOT_FOUND, PlanStatus.SINGULAR)
    place = outcome.details["place"]
    beyond = mf.solve_ik(panda, moved(T, [place + 0.05, 0.0, 0.0]), limits=False, restarts=31)
    before = mf.solve_ik(panda, moved(T, [place - 0.01, 0.0, 0.0]), limits=False, restarts=31)
    assert before.all_solved
    assert not beyond.all_solved
    assert outcome.explain("en")
    assert outcome.explain("ar")


def test_joint_limit_is_placed(panda):
    q = Q.copy()
    q[5] = 3.6
    T = panda.forward_kinematics(q)
    outcome = cartesian_line(panda, q, moved(T, [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]))
    other = cartesian_line(panda, q, moved(T, [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]))
    hit = next(o for o in (outcome, other) if o.status is PlanStatus.JOINT_LIMIT)
    assert 0.0 < hit.details["place"] < 1.0
    joint = panda.joint_names.index(hit.details["joint"])
    assert hit.details["limit"] in (panda.limits.lower[joint], panda.limits.upper[joint])
    assert hit.details["joint"] in hit.explain("en")
    assert hit.explain("ar")


@pytest.mark.capability("11-11")
def test_starting_at_a_singularity_is_named():
    planar = mf.load("ur5e")
    straight = np.zeros(6)
    T = planar.forward_kinematics(straight)
    outcome = cartesian_line(planar, straight, moved(T, [-0.2, 0.0, 0.0]))
    assert outcome.status is PlanStatus.SINGULAR
    assert outcome.details["margin"] < 1e-6
    assert outcome.explain("en")
    assert outcome.explain("ar")


def test_paths_interpolate():
    rng = np.random.default_rng(1)
    A, B = pose.exp(rng.normal(size=(2, 6)))
    for interpolation in ("straight", "screw"):
        path = CartesianPath(A, B, interpolation)
        np.testing.assert_allclose(path.poses([0.0, 1.0]), [A, B], atol=1e-13)
        s, h = np.linspace(0.1, 0.9, 7), 1e-6
        measured = pose.error(path.poses(s - h), path.poses(s + h)) / (2 * h)
        V, _ = path.twists(s)
        np.testing.assert_allclose(measured, V, atol=1e-8)
        slope = (path.twists(s + h)[0] - path.twists(s - h)[0]) / (2 * h)
        np.testing.assert_allclose(slope, path.twists(s)[1], atol=1e-8)
    line = CartesianPath(A, B).poses(np.linspace(0, 1, 5))[:, :3, 3]
    np.testing.assert_allclose(np.diff(line, 2, axis=0), 0.0, atol=1e-13)
    assert CartesianPath(A, B).length == pytest.approx(np.linalg.norm(B[:3, 3] - A[:3, 3]))
    screw = CartesianPath(A, B, "screw")
    way = np.diff(screw.poses(np.linspace(0, 1, 20_001))[:, :3, 3], axis=0)
    assert screw.length == pytest.approx(np.linalg.norm(way, axis=1).sum(), rel=1e-8)
    assert screw.length > CartesianPath(A, B).length


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda r, T: cartesian_line(r, Q, T, law="fast"), "fast"),
        (lambda r, T: cartesian_line(r, Q, T, interpolation="bent"), "bent"),
        (lambda r, T: cartesian_line(r, Q[:6], T), "q_start"),
        (lambda r, T: cartesian_line(r, np.stack([Q, Q]), T), "q_start"),
        (lambda r, T: cartesian_line(r, Q, np.stack([T, T])), "T_goal"),
        (lambda r, T: cartesian_line(r, Q, T * np.nan), "T_goal"),
        (lambda r, T: cartesian_line(r, Q, T, duration=-1.0), "duration"),
        (
            lambda r, T: cartesian_line(
                mf.load("planar3r"), Q[:3], mf.load("planar3r").forward_kinematics(Q[:3] + 0.1)
            ),
            "duration",
        ),
    ],
)
def test_wrong_input_is_named(panda, call, words):
    with pytest.raises(InputError, match=words):
        call(panda, panda.forward_kinematics(Q))
