"""Exciting motions: inside all limits, at rest at both ends, better than chance, the same again for the same seed."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import FileError, InputError
from mafsil.identification import MotionLog, identify
from mafsil.trajectory.motion import Trajectory
from tests.identification.simulated import different, effort, torque_errors


@pytest.mark.parametrize("name", ["puma560", "ur5e", "scara_rrrp"])
def test_limits_are_kept_and_the_condition_is_good(name):
    robot = mf.load(name)
    motion = mf.identification.excitation_trajectory(robot, period=8.0, improvements=120)
    first_draw = mf.identification.excitation_trajectory(robot, period=8.0, candidates=1, improvements=0)
    assert motion.condition_number < 30
    assert motion.condition_number < first_draw.condition_number
    q, qd, qdd = motion.at(np.linspace(0, motion.duration, 4000))
    limits = robot.limits
    assert (q >= limits.lower).all()
    assert (q <= limits.upper).all()
    assert (np.abs(qd) <= limits.velocity).all()
    tau = effort(robot, q, qd, qdd)
    assert (np.abs(tau).max(axis=0) <= 1.05 * limits.effort).all()


def test_it_is_a_trajectory_that_rests_at_its_ends():
    motion = mf.identification.excitation_trajectory(mf.load("planar2r"), candidates=5, improvements=10)
    assert isinstance(motion, Trajectory)
    for t in (0.0, motion.period, motion.duration):
        assert np.abs(motion.at(t).v).max() < 1e-12
        assert np.abs(motion.at(t).a).max() < 1e-11
        assert np.allclose(motion.at(t).u, motion.centre)
    assert np.allclose(motion.at([-1.0, motion.duration + 1]).u, motion.centre)
    t, h = np.linspace(0.5, 20, 50), 1e-5
    ahead, behind = motion.at(t + h), motion.at(t - h)
    assert np.allclose((ahead.u - behind.u) / (2 * h), motion.at(t).v, atol=1e-7)
    assert np.allclose((ahead.v - behind.v) / (2 * h), motion.at(t).a, atol=1e-7)
    assert np.allclose((ahead.a - behind.a) / (2 * h), motion.jerk(t), atol=1e-6)
    assert motion.breaks().tolist() == [0.0, motion.duration]
    assert motion.n == 2


def test_the_seed_decides():
    robot = mf.load("planar2r")
    a, b, c = (
        mf.identification.excitation_trajectory(robot, candidates=4, improvements=5, seed=seed) for seed in (3, 3, 4)
    )
    assert np.array_equal(a.sine, b.sine)
    assert a.condition_number == b.condition_number
    assert not np.array_equal(a.sine, c.sine)


def test_a_given_start_is_kept_and_candidates_can_be_refused():
    robot = mf.load("puma560")
    start = [0.3, 0.5, -0.5, 0.2, 0.4, 0.0]
    motion = mf.identification.excitation_trajectory(
        robot, centre=start, candidates=10, improvements=10, accept=lambda q: q[:, 0].min() > -2
    )
    assert np.array_equal(motion.centre, start)
    q = motion.at(np.linspace(0, 10, 1000)).u
    assert (q >= robot.limits.lower).all()
    assert (q <= robot.limits.upper).all()
    assert q[:, 0].min() > -2.1
    with pytest.raises(InputError, match="none of 4 candidates"):
        mf.identification.excitation_trajectory(robot, candidates=2, improvements=2, accept=lambda q: False)


def test_an_exciting_log_makes_a_good_model(tmp_path):
    described, truth = different("ur5e", 0)
    motion = mf.identification.excitation_trajectory(described, improvements=80)
    t = np.arange(0, motion.duration, 2e-3)
    q, qd, qdd = motion.at(t)
    tau = effort(truth, q, qd, qdd)
    tau = tau + 0.02 * np.sqrt((tau**2).mean(axis=0)) * np.random.default_rng(0).normal(size=tau.shape)
    result = identify(described, MotionLog(t=t, q=np.round(q, 5), tau=tau))
    assert result.identifiable_count == len(result.parameters)
    assert result.condition_number < 100
    assert torque_errors(result.robot, truth, 0).max() < 3.0
    motion.save(tmp_path / "motion.csv", rate=50)
    table = np.genfromtxt(tmp_path / "motion.csv", delimiter=",", names=True, deletechars="")
    assert len(table) == 50 * motion.duration + 1
    assert np.allclose(table[f"q[{described.joint_names[1]}]"], motion.at(table["t"]).u[:, 1])
    with pytest.raises(FileError, match="cannot be written"):
        motion.save(tmp_path / "nowhere" / "motion.csv")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("harmonics", 1),
        ("candidates", 0),
        ("speed", 1.5),
        ("period", 0),
        ("centre", [9, 0, 0, 0, 0, 0]),
        ("centre", [0]),
    ],
)
def test_numbers_out_of_range(name, value):
    with pytest.raises(InputError, match=name):
        mf.identification.excitation_trajectory(mf.load("puma560"), **{name: value})
