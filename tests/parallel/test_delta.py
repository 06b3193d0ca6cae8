"""The Delta robot and the elimination of one unknown: laws on random input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil import parallel as pa
from mafsil.errors import InputError


@pytest.mark.capability("08-11", "08-35")
@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000))
def test_there_and_back(seed):
    rng = np.random.default_rng(seed)
    robot = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0)
    p = rng.uniform([-0.3, -0.3, -1.1], [0.3, 0.3, -0.6], size=(20, 3))
    both = robot.angles(p)
    for mode in (0, 1):
        q = both[..., mode]
        ends = robot.positions(q)
        assert np.nanmin(np.abs(ends - p[:, None]).max(axis=2), axis=1).max() < 1e-9
        gap = np.linalg.norm(ends[:, :, None] - robot.elbows(q)[:, None], axis=-1) - robot.forearm
        assert np.nanmax(np.abs(gap)) < 1e-10


@pytest.mark.capability("08-11", "08-37")
def test_rates_and_torques():
    rng = np.random.default_rng(0)
    robot, h = pa.DeltaRobot(0.4, 0.1, 0.5, 1.0), 1e-6
    q = rng.uniform(0, 0.8, size=(30, 3))
    p = robot.positions(q)[:, 0]
    J = robot.jacobian(q, p)
    for k in range(3):
        step = h * np.eye(3)[k]
        difference = (robot.positions(q + step)[:, 0] - robot.positions(q - step)[:, 0]) / (2 * h)
        np.testing.assert_allclose(J[..., k], difference, atol=1e-7)
    force = rng.normal(size=(30, 3))
    np.testing.assert_allclose(robot.torques(q, p, force), np.einsum("kij,ki->kj", J, force), atol=1e-10)
    assert robot.singularity(q, p)
    assert np.isnan(robot.angles([0, 0, -5.0])).all()
    with pytest.raises(InputError, match="arm"):
        pa.DeltaRobot(0.4, 0.1, -0.5, 1.0)


@pytest.mark.capability("08-24", "08-28")
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_resultant_is_the_product_of_differences(seed):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=3), rng.normal(size=2)
    f, g = np.polynomial.polynomial.polyfromroots(a), np.polynomial.polynomial.polyfromroots(b)
    expected = np.prod(a[:, None] - b)
    assert abs(pa.resultant(f, g)) == pytest.approx(abs(expected), rel=1e-8, abs=1e-10)
    shared = np.polynomial.polynomial.polyfromroots([b[0], 3.0])
    assert abs(pa.resultant(f, f * 1.0)) < 1e-9
    assert abs(pa.resultant(shared, g)) < 1e-9
    x, c = rng.uniform(-3, 3), rng.normal(size=3)
    t = np.tan(x / 2)
    value = pa.half_angle_polynomial(*c) @ t ** np.arange(3)
    assert value == pytest.approx((1 + t * t) * (c[0] + c[1] * np.cos(x) + c[2] * np.sin(x)), rel=1e-9, abs=1e-9)
    coefficients = pa.eliminant(lambda t: np.polynomial.polynomial.polyval(t, f), 5)
    np.testing.assert_allclose(coefficients[:4], f, atol=1e-10)
    assert len(pa.trimmed(coefficients)) == 4
    with pytest.raises(InputError, match="degree"):
        pa.sylvester_matrix(np.ones(1), f)


@pytest.mark.capability("08-28")
def test_three_rps_is_found_by_its_legs():
    rng = np.random.default_rng(1)
    robot, legs = pa.ThreeRPS(1.0, 0.5), pa.three_rps(1.0, 0.5, 1.0)
    for change in 0.08 * rng.normal(size=(5, 3)):
        there = pa.leg_forward(legs, change)
        assert there
        found = robot.modes(np.sqrt(1.25) + change)
        assert len(found.t) == 16
        assert found.error < 1e-12
        assert np.linalg.norm(found.T[:, :3, 3] - there.T[:3, 3], axis=1).min() < 1e-8
        for theta in found.theta:
            B = robot.joints(np.sqrt(1.25) + change, theta)
            np.testing.assert_allclose(np.linalg.norm(B - np.roll(B, 1, axis=0), axis=1), 0.5 * 3**0.5, atol=1e-9)
