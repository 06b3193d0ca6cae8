"""Root locus, margins and sampled stability against roots, frequency sweeps and runs."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mafsil import one_joint
from mafsil.errors import InputError
from mafsil.one_joint import JointArm, JointLaw, LoopConditions
from mafsil.one_joint.root_locus import LocusStatus

ARM = JointArm.of(0.5, friction=0.1)
NOMINAL = JointLaw.pid(2.205, 1.0, 2.0)


@pytest.mark.capability("10-29")
def test_locus_over_ki():
    """From the critically damped PD loop: meeting at -0.7 for Ki = 0.686, crossing at Ki = 9.261."""
    locus = one_joint.root_locus([0.5, 2.1, 2.205, 0.0], [1.0], np.linspace(0.0, 12.0, 400))
    np.testing.assert_allclose(locus.meeting_gains, [0.0, 0.686], atol=1e-9)
    np.testing.assert_allclose(locus.meetings, [-2.1, -0.7], atol=1e-7)
    crossing = locus.crossing_gains > 0
    np.testing.assert_allclose([locus.crossing_gains[crossing], locus.crossings[crossing]], [[9.261], [2.1]])
    assert locus.status is LocusStatus.SOMETIMES
    inside = (locus.gains > 0) & (locus.gains < 9.261)
    np.testing.assert_array_equal(locus.stable, inside)
    assert np.abs(np.diff(locus.roots, axis=0))[20:].max() < 0.2, "branches go on without jumps"
    assert "crossing" in repr(locus)
    at_one = one_joint.root_locus([0.5, 2.1, 2.205, 0.0], 1.0 * np.ones(1), 1.0).roots[0]
    np.testing.assert_allclose(
        np.sort_complex(at_one), np.sort_complex([-2.92666, -0.636668 + 0.527281j, -0.636668 - 0.527281j]), atol=1e-5
    )


@pytest.mark.capability("10-29")
@pytest.mark.parametrize(
    ("kp", "expected"),
    [(2.205, [-0.7]), (2.94, [-1.4]), (2.5, [-1.9416, -0.8584]), (3.5, [])],
)
def test_meetings_of_the_ki_locus_by_kp(kp, expected):
    """One, a triple root, two or none, by Kp against (b + Kd)^2 / (3 M) = 2.94 and its three quarters."""
    locus = one_joint.root_locus([0.5, 2.1, kp, 0.0], [1.0], [0.0, 1.0])
    found = np.sort(locus.meetings.real[locus.meeting_gains > 1e-9])
    assert np.abs(locus.meetings.imag).max(initial=0.0) < 1e-6
    np.testing.assert_allclose(np.unique(np.round(found, 4)), expected, atol=1e-3)


@pytest.mark.capability("10-29")
@given(st.lists(st.floats(-3, 1), min_size=2, max_size=4, unique=True), st.floats(-4, -0.2))
@example([-1.0, -1.1682969643869234], -1.0)
@example([-1.0, -0.5], -1.0)
def test_crossings_and_meetings_satisfy_the_equation(poles, zero):
    D, N = np.poly(poles), np.array([1.0, -zero])
    locus = one_joint.root_locus(D, N, [0.0, 1.0, 10.0])
    for K, s in [
        *zip(locus.meeting_gains, locus.meetings, strict=True),
        *zip(locus.crossing_gains, 1j * locus.crossings, strict=True),
    ]:
        p = D.astype(complex).copy()
        p[-2:] += K * N
        size = np.polyval(np.abs(p), abs(s))
        assert abs(np.polyval(p, s)) <= 1e-6 * size + 1e-9
    for K in locus.meeting_gains:
        p = D.copy()
        p[-2:] += K * N
        r = np.roots(p)
        gaps = np.abs(r[:, None] - r) + 1e9 * np.eye(len(r))
        assert gaps.min() < 1e-2


@pytest.mark.capability("10-93")
def test_delay_margin_of_the_nominal_loop():
    found = one_joint.joint_margins(ARM, NOMINAL)
    assert float(found.delay) == pytest.approx(0.334266, abs=1e-6)
    assert float(found.phase) == pytest.approx(float(found.delay * found.crossover))
    assert one_joint.first_unstable_delay(ARM, NOMINAL, 0.01) == 33
    low = float(found.gain_below)
    assert one_joint.routh_hurwitz([0.5, 0.1 + 2.0 * low * 1.001, 2.205 * low * 1.001, low * 1.001])
    assert not one_joint.routh_hurwitz([0.5, 0.1 + 2.0 * low * 0.999, 2.205 * low * 0.999, low * 0.999])


@pytest.mark.capability("10-93")
@given(st.floats(0.2, 20), st.floats(0.1, 5), st.floats(0.0, 0.95))
def test_margins_against_a_sweep(kp, kd, part):
    ki = part * float(one_joint.ki_limit(0.5, 0.1 + kd, kp))
    found = one_joint.joint_margins(ARM, JointLaw.pid(kp, ki, kd))
    assert found
    w = float(found.crossover)
    s = 1j * w
    L = (kd * s * s + kp * s + ki) / (s * s * (0.5 * s + 0.1))
    assert abs(L) == pytest.approx(1.0, rel=1e-7)
    # With the delay of the margin the loop passes through -1.
    assert L * np.exp(-s * float(found.delay)) == pytest.approx(-1.0, abs=1e-6)


@pytest.mark.capability("10-93")
def test_margins_of_a_loop_with_much_phase_against_a_sweep():
    """Of a first-order lag and of a double one with a zero: phases beyond two radians, by reading a fine sweep."""
    w = np.geomspace(1e-2, 1e2, 200_001)
    for N, D in (
        ([3.0], [1.0, 1.0]),
        ([1.5], [1.0, 1.0]),
        ([2.0, 9.0], [1.0, 0.5, 4.0]),
        ([1.5, 0.3], [1.0, 0.2, 0.0]),
    ):
        found = one_joint.margins(N, D)
        L = np.polyval(N, 1j * w) / np.polyval(D, 1j * w)
        at = np.flatnonzero(np.diff(np.sign(np.abs(L) - 1.0)))
        phase = np.mod(np.angle(L[at]) + np.pi, 2 * np.pi)
        assert float(found.phase) == pytest.approx(np.minimum(phase, 2 * np.pi - phase).min(), abs=1e-3)
        assert float(found.delay) == pytest.approx((phase / w[at]).min(), rel=1e-3)
    assert np.isinf(one_joint.margins([0.5], [1.0, 1.0]).delay), "no crossover: no delay makes it unstable"


@pytest.mark.capability("10-93", "10-9")
def test_spectral_radius_is_what_runs_show():
    for law, delay in ((NOMINAL, 0), (NOMINAL, 30), (NOMINAL, 36), (JointLaw.pid(2.205, 0.0, 2.0), 10)):
        stability = one_joint.sampled_stability(ARM, law, 0.01, delay)
        run = one_joint.simulate_sampled(
            ARM, law, 0.0, 20.0, period=0.01, start=1.0, conditions=LoopConditions(delay=delay)
        )
        size = np.abs(run.error).reshape(-1)[:2000].reshape(4, 500).max(axis=1)
        assert (size[3] < size[2]) == bool(stability)
        grown = (size[3] / size[2]) ** (1 / 500)
        assert grown == pytest.approx(float(stability.spectral_radius), abs=2e-3)
    assert one_joint.step_matrix(ARM, JointLaw.pid([1.0, 2.0]), 0.01, 2).shape == (2, 6, 6)


@pytest.mark.capability("10-104", "10-9")
def test_rate_of_the_loop():
    """Faster loops come near the continuous one, in proportion to the period, and then gain nothing."""
    still = one_joint.simulate_joint(ARM, NOMINAL, 1.0, 10.0).rms_error
    periods = [0.08, 0.04, 0.02, 0.01]
    errors = [abs(one_joint.simulate_sampled(ARM, NOMINAL, 1.0, 10.0, period=T).rms_error - still) for T in periods]
    assert errors == sorted(errors, reverse=True)
    assert errors[3] < 0.2 * errors[0]
    assert not one_joint.sampled_stability(ARM, NOMINAL, 0.6)


def test_answers_of_batches():
    found = one_joint.margins([[1.0, 1.0], [1.0, -5.0]], [1.0, 2.0, 0.0])
    assert [bool(each) for each in found] == [True, False]
    assert np.isnan(found.delay[1])
    assert "1 of 2" in repr(found)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: one_joint.root_locus([1.0, 2.0], [1.0, 2.0, 3.0], [1.0]),
        lambda: one_joint.root_locus([1.0, 2.0], [0.0], [1.0]),
        lambda: one_joint.root_locus([1.0, 2.0], [1.0], [-1.0]),
        lambda: one_joint.margins([1.0, 2.0, 3.0], [1.0, 2.0]),
        lambda: one_joint.joint_margins(ARM, JointLaw.feedforward(ARM)),
        lambda: one_joint.sampled_stability(ARM, NOMINAL, 0.0),
        lambda: one_joint.step_matrix(ARM, JointLaw.feedforward(ARM), 0.01),
    ],
)
def test_wrong_input(wrong):
    with pytest.raises(InputError):
        wrong()
