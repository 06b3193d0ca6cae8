"""Linear-quadratic gains: Riccati's equation, the cost that it promises, and no gain that is cheaper."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import linear_quadratic
from mafsil.errors import InputError
from mafsil.simulation import Plant, Scenario
from mafsil.trajectory import quintic
from mafsil.trajectory.profiles import rest


@pytest.mark.capability("10-2")
@pytest.mark.parametrize("name", ["planar2r", "puma560"])
def test_the_gain_is_optimal(name):
    robot = mf.load(name)
    n = robot.n
    law = linear_quadratic(robot, np.full(n, 0.3), position=400.0, rate=2.0, effort=1e-2)
    Q, R = np.diag([400.0] * n + [2.0] * n), 1e-2 * np.eye(n)
    A, B, P, K = law.A, law.B, law.cost, law.gain
    rest_of_it = A.T @ P + P @ A - P @ B @ np.linalg.solve(R, B.T @ P) + Q
    assert np.abs(rest_of_it).max() < 1e-6 * np.abs(P @ B @ K).max()
    assert (np.linalg.eigvalsh(P) > 0).all()
    assert (law.roots.real < 0).all()
    # Kalman: every gain margin from a half up.
    for factor in (0.51, 1.0, 10.0):
        assert (np.linalg.eigvals(A - factor * B @ K).real < 0).all()


@pytest.mark.capability("10-2")
def test_a_small_error_costs_what_is_promised_and_other_gains_cost_more():
    robot = mf.load("planar2r")
    pose, away = np.array([0.4, 0.7]), np.array([1e-4, -2e-4])
    law = linear_quadratic(robot, pose, position=400.0, rate=2.0, effort=1e-2)

    def spent(each):
        run = mf.simulate(
            Scenario(
                robot=robot, plant=Plant(robot, friction=False), trajectory=rest(pose, 4.0), law=each, q=pose - away,
                qd=np.zeros(2), step=2.5e-4, integrator="rk4", saturate=False,
            )
        )  # fmt: skip
        effort = run.tau - robot.gravity_torque(pose)
        each_moment = 400.0 * (pose - run.q) ** 2 + 2.0 * run.qd**2 + 1e-2 * effort**2
        return np.trapezoid(each_moment.sum(axis=1), run.t)

    x = np.concatenate([away, np.zeros(2)])
    best = spent(law)
    assert best == pytest.approx(x @ law.cost @ x, rel=2e-3)
    for weights in ((100.0, 2.0), (1600.0, 2.0), (400.0, 20.0)):
        other = linear_quadratic(robot, pose, position=weights[0], rate=weights[1], effort=1e-2)
        assert spent(other) > best * 1.001


def test_it_follows_motions_and_refuses_nonsense():
    robot = mf.load("planar2r")
    path = quintic(np.zeros(2), np.array([0.8, -0.5]), 1.0)
    law = linear_quadratic(robot, [0.4, -0.25])
    run = mf.simulate(Scenario(robot=robot, trajectory=path, law=law, saturate=False))
    assert run
    assert np.abs(run.q - run.q_ref).max() < 5e-3
    assert law(0.0, np.zeros((3, 2)), np.zeros((3, 2)), path.at(0.5)).shape == (3, 2)
    for wrong in ({"effort": 0.0}, {"position": -1.0}, {"rate": np.nan}):
        with pytest.raises(InputError):
            linear_quadratic(robot, [0.0, 0.0], **wrong)
    with pytest.raises(InputError, match="pose"):
        linear_quadratic(robot, [0.0])
