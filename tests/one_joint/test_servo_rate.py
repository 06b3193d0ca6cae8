"""The update rate: what more ticks gain, and from when on nothing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from mafsil import one_joint as oj
from mafsil.errors import InputError

ARM, LAW = oj.JointArm.of(0.5, friction=0.1), oj.JointLaw.pid(51.005, 0.0, 10.0)
PERIODS = [0.001, 0.1, 0.005, 0.02, 0.002, 0.05, 0.01]


@pytest.mark.capability("10-104", "10-9")
def test_periods_are_held_against_the_shortest_one():
    found = oj.sweep_rate(ARM, LAW, 1.0, 3.0, PERIODS)
    assert found.period.tolist() == sorted(PERIODS, reverse=True)
    assert [each.name for each in found.status] == ["GROWS", *["TOO_SLOW"] * 2, *["ENOUGH"] * 4]
    assert not found
    # A double root at -(b + Kd) / (2 M) = -10.1 / s: a tenth of its time constant.
    np.testing.assert_allclose(found.advised, 1 / 10.1 / 10, rtol=1e-6)
    np.testing.assert_allclose(found.longest, 0.01)
    # The loop by itself: x = (q, w) under a held torque, the speed differenced.
    for h, rms in zip(found.period[1:], found.rms[1:], strict=True):
        A = expm(np.array([[0, 1, 0], [0, -0.2, 2.0], [0, 0, 0]]) * h)
        x, before, errors = np.zeros(2), 0.0, []
        for _ in range(round(3.0 / h) + 1):
            errors.append(1.0 - x[0])
            tau = 51.005 * (1.0 - x[0]) - 10.0 * (x[0] - before) / h
            before = x[0]
            x = A[:2, :2] @ x + A[:2, 2] * tau
        assert rms == pytest.approx(np.sqrt(np.trapezoid(np.square(errors), dx=h) / 3.0), rel=1e-7)
    assert oj.sweep_rate(ARM, LAW, 1.0, 3.0, [0.002, 0.001])


def test_all_too_slow_and_refusals():
    hopeless = oj.sweep_rate(ARM, LAW, 1.0, 4.0, [0.4, 0.2])
    assert [each.name for each in hopeless.status] == ["GROWS", "GROWS"]
    assert np.isnan(hopeless.longest).all()
    assert next(iter(hopeless)).explain("ar") != next(iter(hopeless)).explain("en")
    for wrong in (
        lambda: oj.sweep_rate(ARM, LAW, 1.0, 3.0, [0.0]),
        lambda: oj.sweep_rate(ARM, LAW, 1.0, 3.0, 0.1),
        lambda: oj.sweep_rate(ARM, oj.JointLaw.pid([1.0, 2.0]), 1.0, 3.0, [0.1]),
        lambda: oj.sweep_rate(ARM, LAW, 1.0, 3.0, [0.1], gain=2.0),
    ):
        with pytest.raises(InputError):
            wrong()
