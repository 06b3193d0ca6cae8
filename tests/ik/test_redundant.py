"""Seven joints: every configuration for a value of the free parameter, and the intervals that it may take."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik import inverse_kinematics, redundancy
from mafsil.ik.result import IKStatus

TURN = 2 * np.pi


def apart(found, q):
    """Largest difference of angles up to whole turns."""
    return np.abs((found - q + np.pi) % TURN - np.pi).max(axis=-1)


def random_configurations(robot, count, seed):
    return np.random.default_rng(seed).uniform(robot.limits.lower, robot.limits.upper, (count, robot.n))


def srs(offset=0.0):
    """Shoulder and wrist of three axes each, the elbow beside the line between them by an offset."""
    x, y, z = np.eye(3)
    axes = [z, y, z, -y, z, y, z]
    places = [0 * z, 0 * z, 0 * z, 0.4 * z + offset * x, 0.8 * z, 0.8 * z, 0.8 * z]
    home = np.eye(4)
    home[2, 3] = 0.9
    return mf.Robot.from_screws(
        np.array([np.concatenate([w, np.cross(r, w)]) for w, r in zip(axes, places, strict=True)]), home
    )


def random_arm(seed):
    """Seven axes anywhere."""
    rng = np.random.default_rng(seed)
    w, r = rng.normal(size=(2, 7, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    return mf.Robot.from_screws(np.concatenate([w, np.cross(r, w)], axis=1), pose.exp(rng.normal(size=6)))


@pytest.mark.capability("07-45", "07-4", "07-1")
@pytest.mark.parametrize("name", ["iiwa7", "panda", "fr3"])
def test_the_planted_posture_comes_back_and_nothing_is_wrong(name):
    robot = mf.load(name)
    form = redundancy(robot)
    q = random_configurations(robot, 500, 1)
    T, value = robot.forward_kinematics(q), form.value(q)
    found = form.solve(T, value[:, None])
    there = np.isfinite(found.residual)
    assert found.q.shape == (500, 1, 8, 7)
    assert (np.isfinite(found.q).all(axis=-1) == there).all()
    assert found.residual[there].max() < 1e-10
    away = np.where(there, apart(np.nan_to_num(found.q), q[:, None, None]), np.inf)
    assert away.min(axis=(1, 2)).max() < 1e-7
    assert found.within.any(axis=(1, 2)).all()
    # Within means within; configurations differ; each has the parameter that was asked for.
    inside = (found.q >= robot.limits.lower - 1e-12) & (found.q <= robot.limits.upper + 1e-12)
    assert (inside.all(axis=-1) & there == found.within).all()
    for k in range(50):
        some = found.q[k, 0][there[k, 0]]
        assert (apart(some[:, None], some[None]) + 9 * np.eye(len(some))).min() > 1e-6
        assert apart(form.value(some)[:, None], value[k]).max() < 1e-9


@pytest.mark.capability("07-45")
def test_eight_postures_wherever_the_wrist_of_a_round_arm_can_be_reached():
    robot = mf.load("iiwa7")
    form = redundancy(robot)
    T = robot.forward_kinematics(random_configurations(robot, 100, 2))
    swept = form.sweep(T, 24)
    assert swept.labelled
    assert np.isfinite(swept.residual).all()
    # One branch is one curve: along the arm angle it does not leap.
    turned = apart(swept.q[:, 1:], swept.q[:, :-1])
    assert np.median(turned) < 1.0
    elbow = swept.q[..., 3]
    assert (np.ptp(np.cos(elbow), axis=1) < 1e-9).all()


@pytest.mark.capability("07-45")
@pytest.mark.parametrize("offset", [0.0, 0.05])
def test_elbows_beside_the_line_and_both_elbows(offset):
    robot = srs(offset)
    form = redundancy(robot)
    assert form.parameter == "arm angle"
    q = np.random.default_rng(3).uniform(-3, 3, (300, 7))
    found = form.solve(robot.forward_kinematics(q), form.value(q)[:, None])
    assert apart(found.q, q[:, None, None]).min(axis=(1, 2)).max() < 1e-7
    assert found.residual.max() < 1e-10
    assert (np.abs(found.q[:, 0, 0, 3] - found.q[:, 0, 4, 3]) > 1e-6).mean() > 0.9


@pytest.mark.capability("07-45", "07-4")
def test_stretched_folded_and_singular_wrists_are_never_a_wrong_pose():
    robot = srs()
    form = redundancy(robot)
    rng = np.random.default_rng(4)
    q = rng.uniform(-3, 3, (60, 7))
    q[:20, 3] = 0.0
    q[20:40, 5] = 0.0
    q[40:, 1] = 0.0
    T = robot.forward_kinematics(q)
    for angle in (0.0, 1.0, -2.5):
        found = form.solve(T, np.array([angle]))
        assert np.nanmax(found.residual) < 1e-7
        assert np.isfinite(found.residual).any(axis=(1, 2)).all()
    # The arm stretched out has no arm angle of its own: any value gives the same elbow.
    assert np.isnan(form.value(q[:20])).all()
    far = T.copy()
    far[:, :3, 3] *= 9.0
    assert np.isnan(form.solve(far, np.array([0.3])).residual).all()
    assert not form.solve(far, np.array([0.3])).within.any()


@pytest.mark.capability("07-45", "07-4")
@pytest.mark.parametrize("name", ["iiwa7", "panda"])
def test_intervals_end_where_a_limit_or_the_reach_does(name):
    robot = mf.load(name)
    form = redundancy(robot)
    q = random_configurations(robot, 6, 5)
    for one, T in zip(q, robot.forward_kinematics(q), strict=True):
        families = form.families(T)
        here = float(form.value(one))
        assert any(f.low - 1e-6 <= here + turn <= f.high + 1e-6 for f in families for turn in (-TURN, 0.0, TURN))
        for f in families:
            assert f.parameter == form.parameter
            assert f.low < f.high
            for share in (0.0, 0.3, 0.7, 1.0):
                configuration = f.at(f.low + share * (f.high - f.low))
                assert np.abs(robot.forward_kinematics(configuration) - T).max() < 1e-8
                assert (configuration >= robot.limits.lower - 1e-9).all()
                assert (configuration <= robot.limits.upper + 1e-9).all()
            if f.high - f.low > TURN - 1e-6:
                continue
            for beyond in (f.low - 1e-6, f.high + 1e-6):
                assert not form.solve(T, np.array([beyond])).within[0, f.branch]


@pytest.mark.capability("07-45", "07-44")
def test_an_arm_of_no_shape_is_solved_by_a_held_joint():
    robot = random_arm(6)
    q = np.random.default_rng(7).uniform(-3, 3, (3, 7))
    T = robot.forward_kinematics(q)
    for held in (None, "joint6"):
        form = redundancy(robot, held)
        found = form.solve(T, form.value(q)[:, None])
        assert not found.labelled
        assert form.families(T[0]) == ()
        away = np.where(np.isnan(found.residual), np.inf, apart(np.nan_to_num(found.q), q[:, None, None]))
        assert away.min(axis=(1, 2)).max() < 1e-6
    answer = inverse_kinematics(robot, T[0], q0=q[0])
    assert answer.method == "elimination"
    assert not answer.complete
    assert apart(answer.q, q[0]).min() < 1e-6


@pytest.mark.capability("07-45", "07-4")
@pytest.mark.parametrize(("name", "free"), [("iiwa7", "arm angle"), ("panda", "joint7"), ("fr3", "joint7")])
def test_the_value_is_given_through_inverse_kinematics(name, free):
    robot = mf.load(name)
    form = redundancy(robot)
    q = random_configurations(robot, 1, 8)[0]
    T, value = robot.forward_kinematics(q), float(form.value(q))
    for given in (value, {free: value}):
        answer = inverse_kinematics(robot, T, free=given)
        assert answer.status is IKStatus.CONTINUUM
        assert answer.method == "closed form"
        assert apart(answer.q, q).min() < 1e-7
        assert answer.residual.max() < 1e-9
        assert not answer.complete
        assert len(answer.families) >= 1
    held = inverse_kinematics(robot, T, free={robot.joint_names[2]: float(q[2])})
    assert apart(held.q, q).min() < 1e-6
    np.testing.assert_allclose(held.q[:, 2], q[2], atol=1e-12)


def test_wrong_questions_are_refused_by_name():
    robot = mf.load("iiwa7")
    T = robot.forward_kinematics(np.full(7, 0.3))
    form = redundancy(robot)
    with pytest.raises(InputError, match="seven"):
        redundancy(mf.load("ur5e"))
    with pytest.raises(InputError, match="arm angle"):
        redundancy(robot, "elbow")
    with pytest.raises(InputError, match="arm angle"):
        inverse_kinematics(robot, T, free={"elbow": 0.1})
    with pytest.raises(InputError, match="one value"):
        inverse_kinematics(robot, T, free={"arm angle": 0.1, "A2": 0.1})
    with pytest.raises(InputError, match="task"):
        inverse_kinematics(robot, T, task="position", free=0.1)
    with pytest.raises(InputError, match="batch"):
        inverse_kinematics(robot, np.tile(T, (2, 1, 1)), free=0.1)
    for bad in (np.nan, np.inf, "x", [0.1, 0.2]):
        with pytest.raises(InputError):
            inverse_kinematics(robot, T, free=bad)
    for name in ("iiwa7", "panda"):
        one = redundancy(mf.load(name))
        for X in (np.full((4, 4), np.nan), 2 * np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0]), np.eye(3)):
            with pytest.raises(InputError):
                one.solve(X, np.array([0.1]))
            with pytest.raises(InputError):
                one.families(X)
        with pytest.raises(InputError):
            one.solve(np.eye(4), np.array([np.nan]))
        with pytest.raises(InputError, match="values"):
            one.solve(np.tile(T, (3, 1, 1)), np.zeros((2, 5)))
        with pytest.raises(InputError):
            one.families(np.tile(np.eye(4), (2, 1, 1)))
        with pytest.raises(InputError):
            one.value(np.zeros(6))
        assert one.solve(np.zeros((0, 4, 4)), np.zeros(3)).q.shape == (0, 3, 8, 7)
        assert one.solve(T, 0.3).q.shape == (1, 8, 7)
    assert form.solve(T, np.zeros(0)).q.shape == (0, 8, 7)
