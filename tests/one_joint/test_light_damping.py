"""Searches for limits of stability end where eigenvalues say so, not on a tolerance made for verdicts."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from mafsil import one_joint as oj


@pytest.mark.parametrize("mass", [1e-3, 1.0, 50.0])
@pytest.mark.parametrize("friction", [10.0**k for k in range(-12, 3, 2)])
def test_the_stiffest_wall_of_any_damping(mass, friction):
    """By 60 digits: the determinant of the step of theta, theta' is 1, or an eigenvalue is -1."""
    T = 1e-3
    with mpmath.workdps(60):
        m, b, t = (mpmath.mpf(x) for x in (mass, friction, T))
        x = b * t / m
        E, S, Q = mpmath.exp(-x), (1 - mpmath.exp(-x)) * m / b, (1 - mpmath.exp(-x)) / b
        P = (x - 1 + mpmath.exp(-x)) * m / b**2
        bounds = [(1 - E) / (S * Q - P * E)]
        flips = P * (1 + E) - S * Q
        bounds += [2 * (1 + E) / flips] if flips > 0 else []
        expected = float(min(bounds))
    assert float(oj.stiffest_stable_wall(mass, friction, T)) == pytest.approx(expected, rel=1e-9)


def test_a_lightly_damped_loop_is_stable_without_delay():
    law = oj.JointLaw.pid(0.001)
    assert oj.first_unstable_delay(oj.JointArm.of(1, friction=1e-6), law, 1e-3) == 1
    assert oj.first_unstable_delay(oj.JointArm.of(1), law, 1e-3) == 0
    assert np.isfinite(oj.stiffest_stable_wall(1.0, 0.0, 1e-3))
