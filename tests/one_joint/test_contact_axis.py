"""Force along one axis, walls, measures of records."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mafsil import one_joint
from mafsil.errors import InputError
from mafsil.one_joint import ForceLoop, SecondOrder
from mafsil.one_joint.wall_contact import WallStatus

POSITIVE = st.floats(0.1, 10.0)


@pytest.mark.capability("10-64", "10-65")
def test_mass_on_a_wall():
    """The closed form of third order against the mass, the wall and the law, integrated."""
    m, k, c, F_d = 2.0, 900.0, 5.0, 10.0
    loop = ForceLoop.of(0.5, 10.0, 60.0)

    def slope(_, y):
        x, v, total = y
        error = F_d - (k * x + c * v)
        return [v, (F_d + 0.5 * error + 10.0 * total - 60.0 * v - (k * x + c * v)) / m, error]

    t = np.linspace(0, 3, 31)
    y = solve_ivp(slope, (0, 3), [0, 0, 0], "DOP853", t, rtol=1e-11, atol=1e-13).y
    # e = F_d - k x - c v; its derivatives at 0 from the equation of motion.
    a0 = 1.5 * F_d / m
    e0, e1 = F_d, -c * a0
    j0 = (0.5 * e1 + 10.0 * e0 - 60.0 * a0 - c * a0) / m
    e2 = -k * a0 - c * j0
    got = loop.wall_dynamics(m, k, c).response(t, [e0, e1, e2])
    np.testing.assert_allclose(got, F_d - k * y[0] - c * y[1], atol=1e-7)
    assert loop.wall_dynamics(m, k, c).stability()
    assert not ForceLoop.of(0.5, 10.0).wall_dynamics(m, k).stability(), "without damping an integral destabilises"
    assert ForceLoop.of(0.5).wall_dynamics(m, k).order == 2


@pytest.mark.capability("10-66")
@given(st.floats(0.0, 3.0), st.floats(0.0, 20.0), st.sampled_from([0.0, 1e-6, 0.5, 20.0]), POSITIVE, st.floats(-2, 2))
def test_runaway_against_integration(kfp, kfi, damping, m, v0):
    t = np.array([0.2, 1.0, 3.0])
    peer = solve_ivp(
        lambda s, v: ((1 + kfp) * 2.0 + kfi * 2.0 * s - damping * v) / m,
        (0, 3),
        [v0],
        "LSODA",
        t,
        rtol=1e-10,
        atol=1e-10,
    ).y[0]
    got = ForceLoop.of(kfp, kfi, damping).free_speed(t, 2.0, m, v0)
    np.testing.assert_allclose(got, peer, rtol=1e-6, atol=1e-6)


@pytest.mark.capability("10-66")
def test_late_speed_is_what_the_speed_tends_to():
    loop = ForceLoop.of(0.5, 10.0, 20.0)
    late = np.array([3.0, 6.0])
    np.testing.assert_allclose(loop.late_speed(late, 2.0, 0.3), loop.free_speed(late, 2.0, 0.3), rtol=1e-9)
    # (1 + Kfp) F / K + Kfi F t / K - m Kfi F / K^2
    np.testing.assert_allclose(loop.late_speed(late, 2.0, 0.3), 0.15 + late - 0.3 * 20.0 / 400.0)


@pytest.mark.capability("10-66")
def test_cure_of_the_runaway():
    """Damping bounds the speed without an integral; with one the speed grows on."""
    late = [100.0, 200.0]
    assert np.ptp(ForceLoop.of(0.5, 0.0, 20.0).free_speed(late, 2.0, 1.0)) < 1e-12
    assert np.diff(ForceLoop.of(0.5, 10.0, 20.0).free_speed(late, 2.0, 1.0)) == pytest.approx(100.0)
    assert np.diff(ForceLoop.of(0.5, 0.0, 0.0).free_speed(late, 2.0, 1.0)) == pytest.approx(300.0)


@pytest.mark.capability("10-78")
@given(POSITIVE, st.floats(1.0, 50.0), st.floats(10, 300), st.floats(0.01, 0.2), st.floats(500, 5000), st.floats(-1, 1))
def test_first_contact_against_integration(D, B, K, ref, k, v0):
    contact = one_joint.simulate_wall_contact(D, B, K, reference=ref, wall_stiffness=k, start=-0.05, speed=v0)

    def free(_, y):
        return [y[1], (-B * y[1] - K * (y[0] - ref)) / D]

    def touch(_, y):
        return y[0]

    touch.terminal, touch.direction = True, 1
    first = solve_ivp(free, (0, 200), [-0.05, v0], "DOP853", events=touch, rtol=1e-10, atol=1e-13, max_step=0.5)
    assert len(first.t_events[0]) == bool(contact)
    assert float(contact.contact_time) == pytest.approx(first.t_events[0][0], rel=1e-6, abs=1e-8)
    touch.direction = -1

    def pressed(_, y):
        return [y[1], (-B * y[1] - K * (y[0] - ref) - k * y[0]) / D]

    start = [0.0, first.y_events[0][0][1]]
    second = solve_ivp(pressed, (0, 20), start, "DOP853", events=touch, rtol=1e-10, atol=1e-13, max_step=0.002 * 10)
    assert float(contact.peak_force) == pytest.approx(
        k * max(second.y[0].max(), float(contact.rest_position)), rel=2e-2
    )
    lost = len(second.t_events[0]) > 0
    assert (contact.status is WallStatus.LOST) == lost or abs(float(contact.contact_speed)) < 1e-6
    if lost and contact.status is WallStatus.LOST:
        assert float(contact.release) == pytest.approx(second.t_events[0][0], rel=1e-5, abs=1e-8)


def test_wall_that_is_not_reached():
    contact = one_joint.simulate_wall_contact(
        1.0, 20.0, 50.0, reference=-0.02, wall_stiffness=1000.0, start=-0.05, speed=[0.0, 5.0]
    )
    assert [bool(each) for each in contact] == [False, True]
    assert np.isnan(contact.contact_time[0])
    assert contact.rest_force[1] == 0.0
    with pytest.raises(InputError):
        one_joint.simulate_wall_contact(1.0, 20.0, 50.0, reference=0.1, wall_stiffness=1000.0, start=0.0)


@pytest.mark.capability("10-84", "10-97")
def test_virtual_walls():
    """K <= 2 b / T is passive; a free device alone bears more; both fall with the period and with delay."""
    m, b = 0.5, [0.5, 2.0]
    for T in (1e-3, 5e-3):
        passive = 2 * np.array(b) / T
        alone = one_joint.stiffest_stable_wall(m, b, T)
        assert (alone >= passive * (1 - 1e-2)).all()
    late = one_joint.stiffest_stable_wall(m, b, 1e-3, delay=2)
    assert (late < one_joint.stiffest_stable_wall(m, b, 1e-3)).all()
    assert one_joint.stiffest_stable_wall(m, 0.0, 1e-3) < 1e-3, "without friction no sampled wall is stable"
    # The limit is that of the loop: a run on both sides of it.
    limit = float(one_joint.stiffest_stable_wall(m, 2.0, 5e-3))
    arm = one_joint.JointArm.of(m, friction=2.0)
    for factor in (0.97, 1.03):
        run = one_joint.simulate_sampled(arm, one_joint.JointLaw.pid(factor * limit), 0.0, 5.0, period=5e-3, start=0.01)
        assert (np.abs(run.error[-100:]).max() < np.abs(run.error[400:500]).max()) == (factor < 1)


@pytest.mark.capability("10-27")
@given(st.floats(0.2, 3.0), st.sampled_from([-2.0, 1.0]), st.floats(-1, 1))
def test_measures_of_records_are_those_of_the_closed_form(zeta, step, rest):
    loop = SecondOrder.of(2.0, zeta)
    t = np.linspace(0.0, float(loop.settling_time()) * 2.5, 20001)
    measured = one_joint.measure_response(t, rest + loop.response(t, step), rest)
    assert measured
    assert float(measured.settling_time) == pytest.approx(float(loop.settling_time()), rel=1e-5)
    assert float(measured.overshoot) == pytest.approx(float(loop.overshoot), abs=1e-6)
    if zeta < 0.95:
        assert float(measured.peak_time) == pytest.approx(float(loop.peak_time), rel=1e-2)
    assert 0 < float(measured.rise_time) < float(measured.settling_time)
    guessed = one_joint.measure_response(t, rest + loop.response(t, step))
    assert float(guessed.steady_error) == pytest.approx(rest, abs=1e-3 * abs(step))


@pytest.mark.capability("10-27")
def test_between_samples_a_record_is_a_straight_line():
    t = np.array([0.0, 1.0, 3.0, 4.0, 6.0, 9.0])
    e = np.interp(t, [0.0, 4.0, 9.0], [1.0, 0.0, 0.0])
    found = one_joint.measure_response(t, e, 0.0)
    assert found.rise_time == pytest.approx(0.8 * 4.0)
    assert found.settling_time == pytest.approx(0.98 * 4.0)
    assert found.integral_absolute == pytest.approx(2.0)


@pytest.mark.capability("10-27")
def test_records_that_end_too_soon_say_so():
    t = np.linspace(0.0, 0.3, 100)
    slow = SecondOrder.of(2.0, 1.0).response(t)
    cut = one_joint.measure_response(t, [slow, np.ones(100)], [0.0, 1.0])
    assert [bool(each) for each in cut] == [False, False]
    assert np.isnan(cut.settling_time).all()
    assert cut.overshoot[0] == 0.0, "a record that is cut off has not overshot"
    assert "no step" in repr(cut)
    for wrong in (
        lambda: one_joint.measure_response([0.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
        lambda: one_joint.measure_response([0.0, 1.0], [1.0, 0.0, 0.0]),
        lambda: one_joint.measure_response([0.0, 1.0], [1.0, np.nan]),
    ):
        with pytest.raises(InputError):
            wrong()


def test_answers_speak_both_languages():
    for answer in (
        one_joint.simulate_wall_contact(2.0, 20.0, 100.0, reference=0.1, wall_stiffness=4000.0, start=-0.05),
        one_joint.ElasticJoint.of(1.0, 1.0, 100.0).allowed_bandwidth([1.0, 100.0]),
    ):
        assert answer.explain("ar") != answer.explain("en")
        assert answer.to_dict()["status"]
        assert repr(answer)


@pytest.mark.capability("10-27")
@pytest.mark.parametrize("zeta", [0.2, 1.0, 2.0])
def test_a_record_that_is_cut_off_shows_no_steady_error_of_its_own(zeta):
    """At three tenths of the settling time nothing is at rest: neither settling nor overshoot may be said."""
    loop = SecondOrder.of(2.0, zeta)
    t = np.linspace(0.0, 0.3 * float(loop.settling_time()), 400)
    cut = one_joint.measure_response(t, [loop.response(t), 5.0 * loop.response(t) - 1.0])
    assert [each.status.name for each in cut] == ["STILL_MOVING"] * 2
    assert np.isnan([cut.settling_time, cut.overshoot, cut.peak_time, cut.rise_time]).all()
    assert "steady" in next(iter(cut)).explain("en")
