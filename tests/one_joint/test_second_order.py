"""Closed forms of second order against integration and dense sampling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mafsil.errors import InputError
from mafsil.one_joint import Damping, ErrorDynamics, SecondOrder

FREQUENCIES = st.floats(0.1, 50.0)
RATIOS = st.one_of(st.floats(0.05, 8.0), st.floats(1 - 1e-6, 1 + 1e-6), st.sampled_from([1.0, 1 - 1e-12, 1 + 1e-12]))


@pytest.mark.capability("10-24", "10-25")
@given(FREQUENCIES, RATIOS, st.floats(-2, 2), st.floats(-20, 20))
def test_closed_form_is_the_solution(w, zeta, e0, v0):
    loop = SecondOrder.of(w, zeta)
    t = np.linspace(0.0, 6.0 / w, 9)
    e, rate = loop.error_and_rate(t, e0, v0)
    general = ErrorDynamics.of(1.0, 2 * zeta * w, w * w).derivatives(t, [e0, v0])
    scale = abs(e0) + abs(v0) / w + 1e-3
    np.testing.assert_allclose(e, general[:, 0], atol=3e-9 * scale)
    np.testing.assert_allclose(rate, general[:, 1], atol=3e-9 * scale * w * max(1, zeta))


@pytest.mark.capability("10-25")
@pytest.mark.parametrize("zeta", [0.0, 0.3, 1.0, 1.0 + 1e-9, 1.5, 40.0])
def test_against_an_independent_integration(zeta):
    t = np.linspace(0.0, 4.0, 9)
    peer = solve_ivp(
        lambda _, y: [y[1], -9.0 * y[0] - 6.0 * zeta * y[1]], (0, 4), [0.7, -2.0], "Radau", t, rtol=1e-10, atol=1e-12
    )
    e, rate = SecondOrder.of(3.0, zeta).error_and_rate(t, 0.7, -2.0)
    np.testing.assert_allclose(e, peer.y[0], atol=2e-8)
    np.testing.assert_allclose(rate, peer.y[1], atol=2e-7)


@pytest.mark.capability("10-27")
@given(FREQUENCIES, st.floats(0.05, 6.0), st.sampled_from([-1.0, 0.5, 2.0]), st.floats(-5, 5))
def test_measures_against_dense_samples(w, zeta, e0, speed):
    loop, v0 = SecondOrder.of(w, zeta), speed * w
    settled = float(loop.settling_time(e0, v0))
    before = loop.response(np.linspace(0.0, settled, 4001), e0, v0)
    after = loop.response(settled * (1 + 1e-9) + np.linspace(0.0, 30.0 / w, 4001), e0, v0)
    assert np.abs(after).max() <= 0.02 * abs(e0) * (1 + 1e-6)
    assert abs(before[-1]) == pytest.approx(0.02 * abs(e0), rel=1e-6)
    peak = max(0.0, float((-np.sign(e0) * np.concatenate([before, after])).max()))
    found = float(loop.opposite_peak(e0, v0))
    assert found >= peak * (1 - 1e-12) - 1e-12
    assert found == pytest.approx(peak, rel=2e-3, abs=2e-3 * abs(e0))


@pytest.mark.capability("10-27")
def test_overshoot_and_peak_time_of_a_step():
    loop = SecondOrder.of([2.0, 3.0, 5.0], [0.2, 0.5, 1.2])
    np.testing.assert_allclose(loop.overshoot, loop.opposite_peak(), atol=1e-14)
    e, rate = loop.error_and_rate(loop.peak_time[:2], 1.0, 0.0)
    np.testing.assert_allclose(rate[[0, 1], [0, 1]], 0.0, atol=1e-12)
    np.testing.assert_allclose(-e[[0, 1], [0, 1]], loop.overshoot[:2])
    assert np.isinf(loop.peak_time[2])


@pytest.mark.capability("10-25", "10-26")
def test_classes_and_time_constants():
    loop = SecondOrder.of(2.0, [0.0, 0.5, 1.0, 2.0])
    assert [Damping(k) for k in loop.damping] == [
        Damping.UNDAMPED, Damping.UNDERDAMPED, Damping.CRITICALLY_DAMPED, Damping.OVERDAMPED,
    ]  # fmt: skip
    assert Damping.OVERDAMPED.sentence("ar") != Damping.OVERDAMPED.sentence("en")
    np.testing.assert_allclose(loop.time_constants[3], [1 / (4 - 2 * np.sqrt(3)), 1 / (4 + 2 * np.sqrt(3))])
    assert np.isinf(loop.settling_time()[0])


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: SecondOrder.of(0.0, 1.0),
        lambda: SecondOrder.of(1.0, -0.1),
        lambda: SecondOrder.of([1.0, 2.0], [1.0, 1.0, 1.0]),
        lambda: SecondOrder.of_joint(-1.0, 1.0, 1.0),
        lambda: SecondOrder.of(1.0, 1.0).response(-1.0),
        lambda: SecondOrder.of(1.0, 1.0).response([np.nan]),
        lambda: SecondOrder.of(1.0, 1.0).settling_time(band=0.0),
    ],
)
def test_wrong_input(wrong):
    with pytest.raises(InputError):
        wrong()
