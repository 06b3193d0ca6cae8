"""Gains of every law vary from run to run: each run of a batch is the run of a law with those gains alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.arrays import frozen
from mafsil.control import (
    Gains,
    Impedance,
    adaptive_control,
    add_delay,
    combine,
    computed_torque,
    feedforward,
    force_control,
    hold_pose,
    impedance_control,
    linear_quadratic,
    model_predictive,
    pid,
    sliding_mode,
    task_computed_torque,
)
from mafsil.control.analysis import min_max  # fmt: skip
from mafsil.control.laws import ComputedTorque, TipMotion
from mafsil.errors import InputError
from mafsil.job import Run, parse_job, solve
from mafsil.simulation import Scenario, Variation, monte_carlo, simulate
from mafsil.simulation.scaled_gains import in_rows, scale_gains, with_scaled_gains
from mafsil.trajectory import line_path, quintic, time_law

ARM = mf.load("puma560")
START, END = np.array([0.2, 0.6, -0.9, 0.1, 0.7, 0.3]), np.array([0.25, 0.55, -0.85, 0.15, 0.75, 0.35])
PATH = quintic(START, END, 0.12)
T = ARM.forward_kinematics(START)
TIP = TipMotion(line_path(T, ARM.forward_kinematics(END)), time_law("quintic").unit().scale_time(0.12))
SOFT = Impedance.of(6, damping=[2, 2, 2, 60, 60, 60], stiffness=[20, 20, 20, 400, 400, 400])
LAWS = {
    "computed_torque": computed_torque(ARM), "sliding_mode": sliding_mode(ARM, width=0.1), "min_max": min_max(ARM),
    "adaptive": adaptive_control(ARM), "model_predictive": model_predictive(ARM, horizon=4),
    "linear_quadratic": linear_quadratic(ARM, START), "impedance": impedance_control(ARM, SOFT, hold_pose(T)),
    "task_computed_torque": task_computed_torque(ARM, TIP),
    "feedforward": combine(feedforward(ARM), pid(6, 200.0, 20.0, 50.0)),
    "delayed": add_delay(impedance_control(ARM, SOFT, TIP), 0.002),
}  # fmt: skip


@pytest.mark.parametrize("name", LAWS)
def test_each_run_is_that_of_its_own_gains(name):
    given = Scenario(robot=ARM, trajectory=PATH, law=LAWS[name], saturate=False, integrator="semi_implicit_euler")
    found = monte_carlo(given, Variation(gains=(0.7, 1.4)), 3, seed=2)
    for k, factor in enumerate(found.variants.gains.tolist()):
        alone = simulate(replace(given, law=scale_gains(LAWS[name], np.array(factor))), fused=False)
        error = float(alone.tip_position_error.max())
        assert found.outcomes.tip_error[k] == pytest.approx(error, rel=1e-7, abs=1e-12), factor
    unchanged = simulate(given, fused=False)
    same = simulate(replace(given, law=scale_gains(LAWS[name], np.array(1.0))), fused=False)
    assert np.array_equal(unchanged.q, same.q)
    other = simulate(replace(given, law=scale_gains(LAWS[name], np.array(1.4))), fused=False)
    assert np.abs(unchanged.q - other.q).max() > 0.0


def test_of_a_predictive_law_without_limits_the_gain_is_scaled():
    law = replace(LAWS["model_predictive"], limit=frozen(np.full(6, np.inf)))
    there = PATH.at(0.06)
    q, qd = there.u + 0.01, there.v - 0.02
    known = ARM.inverse_dynamics(q, qd, there.a)
    for factor in (0.5, 2.0):
        found = scale_gains(law, np.array(factor))(0.06, q, qd, there) - known
        np.testing.assert_allclose(found, factor * (law(0.06, q, qd, there) - known), rtol=1e-9, atol=1e-9)


def test_laws_without_gains_are_refused_and_laws_of_one_state_get_rows():
    class Own:
        def __call__(self, t, q, qd, reference):
            return 0.0 * q

        def session(self, period):
            return self

    for law in (Own(), feedforward(ARM), combine(feedforward(ARM), Own())):
        with pytest.raises(InputError, match="gains"):
            with_scaled_gains(law, np.ones(2))
    assert in_rows(LAWS["sliding_mode"], 3) is LAWS["sliding_mode"]
    zero = Gains.of(6, 0.0, 0.0)
    assert np.all(scale_gains(ComputedTorque(ARM, zero), np.array(2.0)).gains.kp == 0.0)
    press = force_control(ARM, [0, 0, 0, 0, 0, -5.0], sensor=lambda q, qd: np.zeros(6), kp=1.0, ki=2.0, damping=3.0)
    assert np.array_equal(scale_gains(press, np.array(3.0)).ki, 3.0 * press.ki)


PRESS = """
robot = "puma560"
[start]
pose = { position = [0.5, 0.1, 0.004], rpy = [3.14159265358979, 0, 0] }
[tolerance]
position = 0.01
[controller]
kind = "KIND"
[simulation]
friction = false
settle = 0.05
[[surface]]
point = [0, 0, 0]
normal = [0, 0, 1]
stiffness = 2e4
damping = 150
[variation]
runs = 2
gains = [0.8, 1.2]
[[move]]
path = "line"
pose = { position = [0.5, 0.1, -0.001], rpy = [3.14159265358979, 0, 0] }
"""


@pytest.mark.parametrize("kind", ["hybrid", "admittance"])
def test_jobs_that_touch_vary_the_gains_of_laws_of_the_tip(kind):
    text = PRESS.replace("KIND", kind)
    found = solve(parse_job(text), text, Path())
    assert isinstance(found, Run)
    assert found.variation is not None
    assert found.variation.done == 2
    errors = found.variation.drawn.outcomes.tip_error
    assert np.isfinite(errors).all()
    assert errors[0] != errors[1]
    driven = found.driven[0]
    given = replace(driven.scenario, integrator="semi_implicit_euler")
    factor = float(found.variation.drawn.variants.gains[0])
    alone = simulate(replace(given, law=scale_gains(given.law, np.array(factor))))
    assert errors[0] == pytest.approx(float(alone.tip_position_error.max()), rel=1e-6)
