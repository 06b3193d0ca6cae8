"""Feedback with full matrices of gains against the equations that the errors should obey."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    computed_torque,
    energy_certificate,
    gravity_compensation,
    matrix_computed_torque,
    matrix_gravity_compensation,
    matrix_pid,
)
from mafsil.control.analysis import words_for
from mafsil.errors import InputError
from mafsil.model.library.textbook import planar2r_point_masses
from mafsil.simulation import Plant, Scenario, simulate
from mafsil.trajectory import Motion
from mafsil.trajectory.profiles import rest

ARM = mf.Robot(planar2r_point_masses((1.0, 0.8), (2.0, 1.0)))
KP, KD, KI = np.array([[60.0, 20.0], [20.0, 30.0]]), np.array([[12.0, -3.0], [-3.0, 8.0]]), np.diag([4.0, 2.0])
Q, QD = np.array([0.3, 0.8]), np.array([0.5, -0.2])
WANTED = Motion(np.array([0.9, -0.5]), np.array([0.2, 0.1]), np.array([-0.4, 0.7]))


@pytest.mark.capability("10-51", "10-40")
def test_errors_of_computed_torque_act_on_each_other_as_the_matrices_say():
    law = matrix_computed_torque(ARM, KP, KD, KI)
    qdd = ARM.forward_dynamics(Q, QD, law(0.0, Q, QD, WANTED))
    np.testing.assert_allclose(WANTED.a - qdd, -KD @ (WANTED.v - QD) - KP @ (WANTED.u - Q), atol=1e-9)
    session, integral = law.session(0.01), np.zeros(2)
    for _ in range(3):
        integral += 0.01 * (WANTED.u - Q)
        qdd = ARM.forward_dynamics(Q, QD, session(0.0, Q, QD, WANTED))
        left = WANTED.a - qdd + KD @ (WANTED.v - QD) + KP @ (WANTED.u - Q) + KI @ integral
        np.testing.assert_allclose(left, 0.0, atol=1e-9)


@pytest.mark.capability("10-20", "10-51", "10-52")
def test_without_inertia_and_of_diagonals_it_is_the_law_of_each_joint():
    e, rate = WANTED.u - Q, WANTED.v - QD
    np.testing.assert_allclose(matrix_pid(2, KP, KD)(0.0, Q, QD, WANTED), KP @ e + KD @ rate, atol=1e-12)
    held = matrix_gravity_compensation(ARM, KP, KD)(0.0, Q, QD, WANTED)
    np.testing.assert_allclose(held, KP @ e + KD @ rate + ARM.gravity_torque(Q), atol=1e-12)
    single = matrix_computed_torque(ARM, 100.0, 20.0)(0.0, Q, QD, WANTED)
    np.testing.assert_allclose(single, computed_torque(ARM, natural_frequency=10.0)(0.0, Q, QD, WANTED), atol=1e-9)
    batch = matrix_computed_torque(ARM, KP, KD)(0.0, np.tile(Q, (3, 1)), np.tile(QD, (3, 1)), WANTED)
    np.testing.assert_allclose(batch, np.tile(matrix_computed_torque(ARM, KP, KD)(0.0, Q, QD, WANTED), (3, 1)))
    assert words_for(matrix_pid(2, KP)).name == "pid"
    assert words_for(matrix_computed_torque(ARM, KP, KD)).name == "computed_torque"


@pytest.mark.capability("10-53", "10-51")
def test_the_energy_of_coupled_springs_falls():
    law, goal = matrix_gravity_compensation(ARM, KP, KD), np.array([0.9, -0.5])
    plant = Plant(ARM, friction=False)
    run = simulate(Scenario(robot=ARM, plant=plant, trajectory=rest(goal, 1.0), law=law, q=Q, qd=QD, step=1e-3,
                            integrator="rk4", saturate=False))  # fmt: skip
    proof = energy_certificate(ARM, law, goal, run.t, run.q, run.qd)
    assert proof
    e = goal - run.q
    np.testing.assert_allclose(proof.spring, 0.5 * np.einsum("ki,ij,kj->k", e, KP, e), rtol=1e-12)
    np.testing.assert_allclose(proof.kinetic, ARM.kinetic_energy(run.q, run.qd), rtol=1e-12)
    np.testing.assert_allclose(proof.energy, proof.spring + proof.kinetic, rtol=1e-12)
    np.testing.assert_allclose(proof.power, -np.einsum("ki,ij,kj->k", run.qd, KD, run.qd), rtol=1e-12)
    assert np.abs(proof.balance).max() < 3e-3 * proof.energy[0]
    single = energy_certificate(ARM, gravity_compensation(ARM, 30.0, 6.0), goal, run.t, run.q, run.qd)
    np.testing.assert_allclose(single.spring, 15.0 * (e**2).sum(axis=1), rtol=1e-12)
    with pytest.raises(InputError):
        energy_certificate(ARM, matrix_computed_torque(ARM, KP, KD), goal, run.t, run.q, run.qd)


def test_matrices_that_are_no_gains_are_refused():
    for wrong in ([[1.0, 2.0], [0.0, 1.0]], [[1.0, 2.0], [2.0, 1.0]], -1.0, [1.0, 2.0, 3.0], np.nan):
        with pytest.raises(InputError, match="kp"):
            matrix_pid(2, wrong)
