"""Impedance and admittance: virtual masses that are pushed, springs, walls that a sampled arm renders."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    Impedance,
    Wall,
    admittance_control,
    combine,
    hold_pose,
    impedance_control,
    linearize,
    null_space_feedback,
    task_computed_torque,
    task_dynamics,
)
from mafsil.control.contact import sampled_wall_radius, stiffest_wall
from mafsil.errors import InputError
from mafsil.simulation import Plant
from mafsil.trajectory import Motion
from tests.control.tip_runs import PANDA, POSITION, Q7, UR5E, Q, T, run


@pytest.mark.capability("10-78", "10-79", "10-81", "10-82")
@pytest.mark.parametrize("kind", ["impedance", "admittance"])
def test_a_tip_that_is_pushed_moves_as_its_virtual_mass(kind):
    """A constant push of 5 N along x: x(t) of the wanted mass, damper and spring."""
    wanted = Impedance.of(3, inertia=4.0, damping=30.0, stiffness=200.0)
    push = np.array([5.0, 0.0, 0.0])
    plant = Plant(PANDA, friction=False, environment=_Push(push))
    start = PANDA.forward_kinematics(Q7)
    if kind == "impedance":
        law = impedance_control(PANDA, wanted, hold_pose(start), coordinates=POSITION, sensor=lambda q, qd: push)
    else:
        law = admittance_control(PANDA, wanted, hold_pose(start), lambda q, qd: push, coordinates=POSITION)
    still = combine(law, _NullDamping(PANDA))
    found = run(PANDA, still, Q7, 1.0, plant=plant, step=5e-4)
    moved = PANDA.forward_kinematics(found.q)[:, :3, 3] - start[:3, 3]
    roots = Impedance.of(1, inertia=4.0, damping=30.0, stiffness=200.0).roots
    c = np.linalg.solve(np.array([[1.0, 1.0], roots]), [-5.0 / 200.0, 0.0])
    exact = 5.0 / 200.0 + (c * np.exp(np.outer(found.t, roots))).sum(axis=1).real
    np.testing.assert_allclose(moved[:, 0], exact, atol=3e-4)
    assert np.abs(moved[:, 1:]).max() < 1e-3


class _Push:
    """A constant force in {s} on the tip."""

    def __init__(self, force):
        self.force = force

    def wrench(self, T, V):
        turned = np.swapaxes(T[..., :3, :3], -1, -2) @ self.force
        return np.concatenate([np.zeros_like(turned), turned], axis=-1)


class _NullDamping:
    """Damping of what does not move the tip's origin."""

    def __init__(self, robot):
        self.robot = robot

    def __call__(self, t, q, qd, reference):
        now = task_dynamics(self.robot, q, qd, POSITION)
        return now.effort(np.zeros(3), -5.0 * (self.robot.mass_matrix(q) @ qd))

    def session(self, period):
        return self


@pytest.mark.capability("10-80")
def test_stiffness_alone_is_a_spring():
    wanted = Impedance.of(6, stiffness=[20.0, 20.0, 20.0, 400.0, 400.0, 400.0])
    away = T.copy()
    away[0, 3] -= 0.01
    law = impedance_control(UR5E, wanted, hold_pose(away))
    tau = law(0.0, Q, np.zeros(6), None) - UR5E.gravity_torque(Q)
    F = np.linalg.solve(task_dynamics(UR5E, Q).J.T, tau)
    np.testing.assert_allclose(F, [0, 0, 0, -4.0, 0, 0], atol=1e-9)
    with pytest.raises(InputError, match="mass"):
        wanted.acceleration(np.zeros(6), np.zeros(6), np.zeros(6))
    for of_mass in ("roots", "natural_frequency"):
        with pytest.raises(InputError, match="mass"):
            getattr(wanted, of_mass)


@pytest.mark.capability("10-84", "10-97")
def test_virtual_walls_that_a_sampled_arm_can_render():
    period, damping = 1e-3, 2.0
    assert stiffest_wall(damping, period) == 4000.0
    assert sampled_wall_radius(1.0, damping, 0.9 * 4000.0, period) < 1.0
    limit = next(K for K in np.geomspace(100.0, 1e6, 400) if sampled_wall_radius(1.0, damping, K, period) > 1.0)
    late = next(K for K in np.geomspace(1.0, 1e6, 400) if sampled_wall_radius(1.0, damping, K, period, delay=5) > 1.0)
    assert late < limit < 1.1 * stiffest_wall(damping, period)
    with pytest.raises(InputError, match="stiffness"):
        Wall([0, 0, 0], [0, 0, 1], stiffness=0.0)


@pytest.mark.capability("10-55", "10-102")
@pytest.mark.parametrize("law", ["impedance", "computed_torque"])
def test_a_redundant_arm_bears_its_gravity_beside_the_task_too(law):
    """Motions that leave the tip at rest obey e'' + 2 w e' + w^2 e = 0: a double root at -w, in any pose."""
    arm, w = mf.load("panda"), 3.0
    for q in np.array([[0.8, 0.8, -0.8, -1.3, 0.8, 1.3, -0.8], [0.2, -0.4, 0.1, -2.0, 0.1, 1.6, 0.5]]):
        T = arm.forward_kinematics(q)
        if law == "impedance":
            soft = Impedance.of(6, damping=[20, 20, 20, 200, 200, 200], stiffness=[40, 40, 40, 900, 900, 900])
            chosen = combine(impedance_control(arm, soft, hold_pose(T)), null_space_feedback(arm, natural_frequency=w))
        else:
            chosen = task_computed_torque(arm, hold_pose(T), natural_frequency=30.0, rest_frequency=w)
        loop = linearize(arm, q).close_loop(chosen, Motion(q, np.zeros(7), np.zeros(7)))
        friction = np.array([0.0 if j.friction is None else j.friction.viscous for j in arm.mechanism.coordinates])
        assert not friction.any()
        poles = loop.poles
        at_rest = np.sort(np.abs(poles + w))[:2]
        assert at_rest.max() < 2e-3 * w
        assert poles.real.max() < -0.5


@pytest.mark.capability("10-76")
def test_modes_of_an_impedance_have_their_damping_ratios():
    rng = np.random.default_rng(2)
    root, modes = rng.normal(size=(3, 3)), np.linalg.qr(rng.normal(size=(3, 3)))[0]
    w, zeta = np.array([2.0, 5.0, 11.0]), np.array([0.3, 1.4, 0.05])
    # x = S y with y'' + 2 zeta w y' + w^2 y = 0: D = S^-T S^-1, and so on.
    S = np.linalg.inv(root) @ modes
    back = np.linalg.inv(S)
    of = {
        name: back.T @ np.diag(x) @ back
        for name, x in (("inertia", w**0), ("damping", 2 * zeta * w), ("stiffness", w**2))
    }
    found = Impedance.of(3, **{name: (x + x.T) / 2 for name, x in of.items()})
    np.testing.assert_allclose(found.natural_frequency, w, rtol=1e-9)
    np.testing.assert_allclose(found.damping_ratio, zeta, rtol=1e-9)
    np.testing.assert_allclose(Impedance.of(2, inertia=2.0, damping=[3.0, 0.0]).damping_ratio, [np.inf, 0.0])
