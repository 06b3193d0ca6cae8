"""Friction laws, stiction that really holds, dither, stick-slip against the loop."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mafsil import one_joint
from mafsil.errors import InputError
from mafsil.one_joint import JointArm, JointLaw, LoopConditions
from mafsil.one_joint.drives import SpeedFriction
from mafsil.one_joint.drives.dry_friction import HoldingStatus

LAWS = {
    "viscous": SpeedFriction.viscous_only(0.3),
    "coulomb": SpeedFriction.coulomb(0.5),
    "static_viscous": SpeedFriction.static_viscous(0.5, 0.2),
    "static_kinetic": SpeedFriction.static_kinetic(0.9, 0.6),
    "static_kinetic_viscous": SpeedFriction.static_kinetic_viscous(0.9, 0.6, 0.1),
    "stribeck": SpeedFriction.stribeck(0.9, 0.6, 0.1, 0.05, 2.0),
}


@pytest.mark.capability("10-16", "10-15")
def test_six_laws():
    w = np.array([-2.0, -0.05, 0.05, 2.0])
    expected = {
        "viscous": 0.3 * w,
        "coulomb": 0.5 * np.sign(w),
        "static_viscous": 0.5 * np.sign(w) + 0.2 * w,
        "static_kinetic": 0.6 * np.sign(w),
        "static_kinetic_viscous": 0.6 * np.sign(w) + 0.1 * w,
        "stribeck": (0.6 + 0.3 * np.exp(-((w / 0.05) ** 2))) * np.sign(w) + 0.1 * w,
    }
    for name, law in LAWS.items():
        np.testing.assert_allclose(law.torque(w), expected[name], atol=1e-15)
        low, high = law.interval([0.0, 1.0])
        assert low[0] == -law.static
        assert high[0] == law.static
        assert low[1] == high[1] == law.torque(1.0)


@pytest.mark.capability("10-16", "10-17")
@given(st.floats(0.0, 3.0), st.floats(0.0, 1.0), st.floats(-5, 5), st.floats(-2, 2))
def test_at_rest_friction_balances_what_it_can(static, part, applied, speed):
    law = SpeedFriction.of(static, part * static, 0.2)
    taken = float(law.torque(0.0, applied))
    holding = law.holds(applied)
    assert abs(taken) <= static
    assert (taken == applied) == bool(holding)
    assert holding.status is (HoldingStatus.HOLDS if abs(applied) <= static else HoldingStatus.MOVES)
    assert float(law.torque(speed)) * speed >= 0.0, "friction never drives"


@pytest.mark.capability("10-17")
def test_arm_held_by_stiction_does_not_creep():
    arm = JointArm.of(0.5, 1.0, 0.1, SpeedFriction.static_kinetic([1.0, 0.9], 0.6))
    np.testing.assert_array_equal(arm.moves_from_rest(0.0, 0.0), [False, True])
    np.testing.assert_array_equal(arm.acceleration(0.0, 0.0, 0.0) == 0.0, [True, False])
    run = one_joint.simulate_sampled(arm, JointLaw.pid(), 0.0, 100.0, period=0.01)
    assert (run.theta[0] == 0.0).all(), "set-valued: not a tanh that creeps"
    assert run.theta[1, -1] < -0.1


@pytest.mark.capability("10-16")
@pytest.mark.parametrize("name", LAWS)
def test_free_slide_stops_where_it_should(name):
    law = LAWS[name]
    run = one_joint.simulate_sampled(JointArm.of(0.5, friction=law), JointLaw.pid(), 0.0, 20.0, period=0.01, speed=1.0)
    assert (np.abs(np.diff(run.speed)) <= 0.02 * 1.2).all()
    # Work of friction = energy lost: integral of tau w dt.
    lost = np.trapezoid(law.torque(run.speed) * run.speed, run.t)
    assert lost == pytest.approx(0.25 - 0.25 * run.speed[-1] ** 2, abs=2e-5)
    if law.dry:
        assert run.speed[-1] == 0.0
        assert (run.theta[-100:] == run.theta[-1]).all()


@pytest.mark.capability("10-16")
def test_coulomb_slide_in_closed_form():
    b, M, w0 = 0.5, 0.5, 1.3
    run = one_joint.simulate_sampled(
        JointArm.of(M, friction=SpeedFriction.coulomb(b)), JointLaw.pid(), 0.0, 3.0, period=0.07 / 0.7 / 2, speed=w0
    )
    assert run.theta[-1] == pytest.approx(M * w0**2 / (2 * b), abs=1e-12)


@pytest.mark.capability("10-105")
def test_stick_slip_of_the_loop_is_the_closed_form():
    friction = SpeedFriction.static_kinetic(0.9, 0.6)
    cycle = one_joint.drives.stick_slip(0.5, 20.0, 0.9, 0.6, 0.1)
    run = one_joint.simulate_sampled(
        JointArm.of(0.5, friction=friction),
        JointLaw.pid(20.0),
        lambda t: (0.1 * t, 0.1 + 0 * t, 0 * t),
        6.0,
        period=1e-4,
        substeps=1,
    )
    started = run.t[1:][(run.speed[1:] > 0) & (run.speed[:-1] == 0)]
    assert started[0] == pytest.approx(float(cycle.first_motion), abs=4e-4)
    np.testing.assert_allclose(np.diff(started), cycle.period, atol=1e-3)
    assert run.speed.max() == pytest.approx(float(cycle.peak_speed), rel=1e-3)
    assert not one_joint.drives.stick_slip(0.5, 20.0, 0.6, 0.6, 0.1)


@pytest.mark.capability("10-105", "10-19")
def test_pid_hunts_only_if_static_is_above_kinetic_friction():
    law = JointLaw.pid(20.0, 10.0, 2.0)
    arm = JointArm.of(0.5, friction=SpeedFriction.static_kinetic([0.9, 0.6], 0.6))
    run = one_joint.simulate_sampled(arm, law, 1.0, 200.0, period=0.01, substeps=2)
    late = np.abs(run.error[:, -10000:]).max(axis=1)
    assert late[0] > 0.01
    assert late[1] < 1e-3


@pytest.mark.capability("10-19")
def test_dither_is_the_mean_of_coulomb_friction():
    phase = (np.arange(200001) + 0.5) / 200001 * 2 * np.pi
    for w in (-1.5, -0.3, 0.0, 0.7):
        mean = 0.4 * np.sign(w + np.sin(phase)).mean()
        assert float(one_joint.drives.dithered_friction(0.4, w, 1.0)) == pytest.approx(mean, abs=1e-5)


@pytest.mark.capability("10-105", "10-19")
def test_slow_reversals_leave_a_lobe_that_a_friction_model_or_high_gains_take_away():
    friction = SpeedFriction.static_kinetic_viscous(0.5, 0.4, 0.1)
    arm, blind = JointArm.of(0.5, friction=friction), JointArm.of(0.5, friction=0.1)

    def slow(t):
        return 0.3 * np.sin(0.8 * t), 0.24 * np.cos(0.8 * t), -0.192 * np.sin(0.8 * t)

    def run(law, joint=arm):
        return one_joint.simulate_sampled(joint, law, slow, 6.0, period=1e-3, speed=0.24, substeps=2)

    def errors(law, joint=arm):
        return np.abs(run(law, joint).error)

    lobes, plain = run(JointLaw.pid(20.0, 0.0, 2.0)), errors(JointLaw.pid(20.0, 0.0, 2.0))
    assert plain.max() > 5 * errors(JointLaw.pid(20.0, 0.0, 2.0), blind).max()
    # At a turn of the reference the joint stands until its torque has grown to the static friction of the other sense.
    at = int(np.argmin(np.abs(lobes.t - 0.5 * np.pi / 0.8)))
    stopped = at + int(np.argmax(lobes.speed[at:] == 0.0))
    until = stopped + int(np.argmax(lobes.speed[stopped:] != 0.0))
    assert lobes.t[until] - lobes.t[stopped] > 0.1
    assert lobes.torque[until - 1] == pytest.approx(-0.5, abs=2e-3)
    high = errors(JointLaw.pid(200.0, 0.0, 10.0))
    modelled = errors(JointLaw.feedforward_pid(arm, 20.0, 0.0, 2.0))
    assert max(high.max(), modelled.max()) < 0.2 * plain.max()


@pytest.mark.capability("10-105", "10-19")
def test_dither_loosens_a_joint_that_sticks():
    """A sine on the torque, larger than the static friction: the joint comes to its goal, trembling a little."""
    arm, law = JointArm.of(0.5, friction=SpeedFriction.static_kinetic(0.5, 0.45)), JointLaw.pid(8.0, 0.0, 4.0)
    conditions = LoopConditions(dither=[0.0, 1.5], dither_frequency=60.0)
    run = one_joint.simulate_sampled(arm, law, 0.05, 6.0, period=1e-3, conditions=conditions, substeps=2)
    late = run.error[:, -500:]
    assert (late[0] == 0.05).all(), "8 N m/rad times 0.05 rad is less than what friction holds"
    assert abs(late[1].mean()) < 3e-3
    assert np.ptp(late[1]) < 4e-3
    # What acts is the law's torque and the sine.
    parts = run.parts.sum(axis=-1)
    np.testing.assert_allclose(run.torque[1] - parts[1], 1.5 * np.sin(60.0 * run.t[1]), atol=1e-9)
    with pytest.raises(InputError, match="dither_frequency"):
        one_joint.simulate_sampled(
            arm, law, 0.05, 1.0, period=0.02, conditions=LoopConditions(dither=0.1, dither_frequency=200.0)
        )


@pytest.mark.capability("10-19", "10-38")
def test_friction_in_the_model_removes_the_error_of_feedforward():
    friction = SpeedFriction.static_kinetic_viscous(0.3, 0.3, 0.1)
    arm = JointArm.of(0.5, 1.0, 0.1, friction)
    blind = JointArm.of(0.5, 1.0, 0.1, 0.1)

    def reference(t):
        return 0.5 * t - 0.25 * np.sin(2 * t), 0.5 - 0.5 * np.cos(2 * t), np.sin(2 * t)

    errors = [
        one_joint.simulate_sampled(arm, JointLaw.feedforward(model), reference, 3.0, period=1e-3).largest_error
        for model in (arm, blind)
    ]
    assert errors[0] < 0.01 < 0.3 < errors[1]


@pytest.mark.capability("10-19")
def test_dither_of_any_amplitude_and_beyond_its_speed():
    phase = (np.arange(200001) + 0.5) / 200001 * 2 * np.pi
    mean = [0.4 * np.sign(w + 2.5 * np.sin(phase)).mean() for w in (-3.0, 1.0, 2.0)]
    np.testing.assert_allclose(one_joint.drives.dithered_friction(0.4, [-3.0, 1.0, 2.0], 2.5), mean, atol=1e-5)


@pytest.mark.capability("10-12", "10-17")
def test_stiction_and_the_weight_of_the_link():
    arm = JointArm.of(0.5, 2.0, 0.3, SpeedFriction.static_kinetic(1.0, 0.6), gravity=9.81)
    assert float(arm.gravity_moment) == pytest.approx(2.0 * 9.81 * 0.3)
    weight = 5.886 * np.cos(1.2)
    np.testing.assert_array_equal(
        arm.moves_from_rest(1.2, weight + np.array([-1.01, -0.99, 0.99, 1.01])), [True, False, False, True]
    )
    assert float(arm.torque(1.2, 0.0, 0.0)) == pytest.approx(weight), "at rest nothing is taken for friction"


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: SpeedFriction.of(0.5, 0.6),
        lambda: SpeedFriction.of(-0.5),
        lambda: SpeedFriction.stribeck(0.9, 0.6, 0.1, 0.0),
        lambda: LAWS["coulomb"].holds(np.nan),
        lambda: one_joint.drives.stick_slip(0.5, 20.0, 0.5, 0.6, 0.1),
        lambda: one_joint.simulate_joint(JointArm.of(0.5, friction=LAWS["coulomb"]), JointLaw.pid(1.0), 0.0, 1.0),
    ],
)
def test_wrong_input(wrong):
    with pytest.raises(InputError):
        wrong()
