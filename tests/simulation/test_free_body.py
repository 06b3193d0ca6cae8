"""A single rigid body in motion: momentum in space, energy, the centre of mass, a symmetric top's precession."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError

BODY = mf.simulation.RigidBody(
    mf.model.Inertial(2.0, np.array([0.1, 0.05, -0.2]), np.diag([0.1, 0.25, 0.2]) + 0.01 * np.ones((3, 3)))
)
SPIN = np.array([1.0, 8.0, 0.1, 0.3, 0.2, 0.1])


@pytest.mark.capability("09-31")
@pytest.mark.row("R10")
def test_a_tumbling_body_keeps_energy_and_momentum():
    moved = mf.simulation.free_body_motion(BODY, np.eye(4), SPIN, duration=5.0, tolerance=1e-13)
    assert moved.succeeded
    P = moved.momentum_space
    assert np.abs(P - P[0]).max() < 1e-10 * np.abs(P).max()
    assert np.ptp(moved.energy) < 1e-11 * moved.energy[0]
    R = moved.T[:, :3, :3]
    assert np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max() < 1e-14


@pytest.mark.capability("09-31")
def test_the_centre_of_mass_falls_as_a_point(tmp_path):
    moved = mf.simulation.free_body_motion(BODY, np.eye(4), SPIN, duration=2.0, gravity=(0, 0, -9.81), tolerance=1e-12)
    com = moved.T[:, :3, :3] @ BODY.inertial.com + moved.T[:, :3, 3]
    start = SPIN[3:] + np.cross(SPIN[:3], BODY.inertial.com)
    wanted = BODY.inertial.com + moved.t[:, None] * start + np.outer(moved.t**2 / 2, [0, 0, -9.81])
    np.testing.assert_allclose(com, wanted, atol=1e-9)
    assert np.ptp(moved.energy) < 1e-9 * np.abs(moved.energy).max()


def test_a_symmetric_top_precesses_as_theory_says():
    top = mf.simulation.RigidBody(mf.model.Inertial(1.0, np.zeros(3), np.diag([0.2, 0.2, 0.5])))
    w = np.array([1.0, 0.0, 4.0])
    moved = mf.simulation.free_body_motion(top, np.eye(4), [*w, 0, 0, 0], duration=6.0, tolerance=1e-12)
    rate = (0.5 - 0.2) / 0.2 * w[2]
    np.testing.assert_allclose(moved.V[:, 0], np.cos(rate * moved.t), atol=1e-9)
    np.testing.assert_allclose(moved.V[:, 1], np.sin(rate * moved.t), atol=1e-9)


def test_a_wrench_moves_the_body_as_a_robot_s_link_would():
    """A wrench over time: the rate of momentum in space is the wrench in space."""

    def F(t, T, V):
        return np.array([np.sin(3 * t), 0.2, 0.0, 1.0, -0.5 * t, 0.3])

    moved = mf.simulation.free_body_motion(BODY, np.eye(4), SPIN, F, duration=1.0, tolerance=1e-12)
    from mafsil.geometry import pose, wrench

    F_s = wrench.transform(pose.inverse(moved.T), np.stack([F(t, None, None) for t in moved.t]))
    P = moved.momentum_space
    from scipy.interpolate import CubicSpline

    gained = CubicSpline(moved.t, F_s).integrate(0.0, 1.0)
    np.testing.assert_allclose(P[-1] - P[0], gained, atol=1e-4)
    constant = mf.simulation.free_body_motion(BODY, np.eye(4), np.zeros(6), [0, 0, 0.1, 0, 0, 0], duration=1.0)
    assert constant.V[-1, 2] > 0.0


def test_wrong_arguments_are_named():
    with pytest.raises(InputError, match="body"):
        mf.simulation.free_body_motion(3, np.eye(4), SPIN, duration=1.0)
    with pytest.raises(InputError, match="duration"):
        mf.simulation.free_body_motion(BODY, np.eye(4), SPIN, duration=0.0)
    with pytest.raises(InputError, match="V"):
        mf.simulation.free_body_motion(BODY, np.eye(4), SPIN[:5], duration=1.0)
    with pytest.raises(InputError):
        mf.simulation.free_body_motion(BODY, 2 * np.eye(4), SPIN, duration=1.0)


def test_a_blow_up_is_a_status():
    with np.errstate(all="ignore"):
        moved = mf.simulation.free_body_motion(
            BODY, np.eye(4), SPIN, lambda t, T, V: 1e3 * V * np.abs(V), duration=5.0, most_steps=20_000
        )
    assert not moved.succeeded
    assert np.isfinite(moved.V).all()
    assert moved.explain("ar") != moved.explain("en")
