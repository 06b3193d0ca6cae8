"""Runs against closed forms and SciPy; sampled loops against the pseudo-code in plain Python."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mafsil import one_joint
from mafsil.errors import InputError
from mafsil.one_joint import Desired, DiscreteLoop, JointArm, JointLaw, LoopConditions, SecondOrder, run_loop

ARM = JointArm.of(0.5, 1.0, 0.1, 0.1)
FLAT = JointArm.of(0.5, friction=0.1)


def sine(t):
    return np.sin(t), np.cos(t), -np.sin(t)


@pytest.mark.capability("10-12", "10-13", "10-14")
def test_the_arm():
    rng = np.random.default_rng(0)
    theta, speed, acceleration = rng.normal(size=(3, 50))
    tau = ARM.torque(theta, speed, acceleration)
    np.testing.assert_allclose(tau, 0.5 * acceleration + 0.981 * np.cos(theta) + 0.1 * speed)
    np.testing.assert_allclose(ARM.acceleration(theta, speed, tau), acceleration)
    np.testing.assert_allclose(tau, 0.5 * acceleration + ARM.bias(theta, speed))
    free = JointArm.of(0.5, 1.0, [0.1, 0.0])
    run = one_joint.simulate_joint(free, JointLaw.pid(), 0.0, 30.0, start=0.3, speed=1.0, step=2e-3)
    energy = free.energy(run.theta.T, run.speed.T)
    np.testing.assert_allclose(energy, energy[0] + 0 * energy, atol=1e-9)
    np.testing.assert_allclose(energy[0], [0.5 / 2 + 9.81 * 0.1 * np.sin(0.3), 0.5 / 2], rtol=1e-12)


@pytest.mark.capability("10-20", "10-21", "10-22")
def test_pd_is_a_spring_and_a_damper():
    law = JointLaw.pid([2.0, 5.0, 40.0], 0.0, 1.5)
    run = one_joint.simulate_joint(FLAT, law, 1.0, 4.0)
    loop = SecondOrder.of_joint(0.5, 1.6, law.kp)
    np.testing.assert_allclose(run.error, loop.response(run.t[0]), atol=1e-9)
    np.testing.assert_allclose(law.error_dynamics(FLAT).response(run.t[0], [1.0, 0.0]), run.error, atol=1e-9)
    np.testing.assert_allclose(run.parts[..., 0], law.kp[:, None] * run.error)
    np.testing.assert_allclose(run.torque, run.parts.sum(axis=-1))


@pytest.mark.capability("10-20")
def test_letters_of_laws():
    law = JointLaw.pid([1, 0, 0, 1, 1, 1, 0], [0, 1, 0, 0, 1, 1, 0], [0, 0, 1, 1, 0, 1, 0])
    assert law.letters.tolist() == ["P", "I", "D", "PD", "PI", "PID", ""]
    with pytest.raises(InputError):
        JointLaw.pid(-1.0)


@pytest.mark.capability("10-22", "10-34")
def test_pid_error_is_of_third_order():
    law = JointLaw.pid(2.205, 1.0, 2.0)
    run = one_joint.simulate_joint(FLAT, law, 1.0, 12.0)
    third = law.error_dynamics(FLAT)
    assert third.order == 3
    # e(0) = 1, e' = 0, M e'' = -(b + Kd) e' - Kp e - Ki 0.
    np.testing.assert_allclose(third.response(run.t, [1.0, 0.0, -2.205 / 0.5]), run.error, atol=1e-9)
    np.testing.assert_allclose(run.torque, run.parts.sum(axis=-1), atol=1e-12)
    with pytest.raises(InputError, match="of different order"):
        JointLaw.pid(1.0, [0.0, 1.0]).error_dynamics(FLAT)


@pytest.mark.capability("10-38", "10-40")
def test_exact_models_track_exactly():
    for law in (JointLaw.feedforward(ARM), JointLaw.computed_torque(ARM, 4.0, 0.5, 4.0)):
        run = one_joint.simulate_joint(ARM, law, sine, 6.0, start=0.0, speed=1.0)
        assert run.largest_error < 1e-9
    late = one_joint.simulate_joint(ARM, JointLaw.computed_torque(ARM, 4.0, 0.0, 4.0), sine, 6.0, start=-0.5, speed=1.0)
    np.testing.assert_allclose(late.error, SecondOrder.of(2.0, 1.0).response(late.t, 0.5, 0.0), atol=1e-9)


@pytest.mark.capability("10-38")
def test_continuous_runs_against_scipy():
    law = JointLaw.feedforward_pid(JointArm.of(0.4, 1.0, 0.08, 0.05), 3.0, 0.7, 1.0)

    def slope(t, y):
        u, v, a = sine(t)
        e = u - y[0]
        tau = 0.4 * a + 0.08 * 9.81 * np.cos(u) + 0.05 * v + 3.0 * e + 0.7 * y[2] + 1.0 * (v - y[1])
        return [y[1], (tau - 0.981 * np.cos(y[0]) - 0.1 * y[1]) / 0.5, e]

    run = one_joint.simulate_joint(ARM, law, sine, 5.0, start=0.4)
    peer = solve_ivp(slope, (0, 5), [0.4, 0, 0], "DOP853", run.t[::1000], rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(run.theta[::1000], peer.y[0], atol=1e-9)


@pytest.mark.capability("10-35", "10-42", "10-107", "10-103")
@pytest.mark.parametrize("kind", ["pid", "computed_torque", "feedforward"])
def test_compiled_loop_is_the_loop_with_callbacks(kind):
    model = JointArm.of(0.45, 1.0, 0.08, 0.1)
    gains = (2.205, 1.0, 2.0)
    law = {
        "pid": lambda: JointLaw.pid(*gains),
        "computed_torque": lambda: JointLaw.computed_torque(model, *gains),
        "feedforward": lambda: JointLaw.feedforward(model),
    }[kind]()
    loop = {
        "pid": lambda: DiscreteLoop(0.01, *gains, filter_time=0.02),
        "computed_torque": lambda: DiscreteLoop(
            0.01, *gains, inertia=lambda q: model.inertia + 0 * q, bias=model.bias, filter_time=0.02
        ),
        "feedforward": lambda: DiscreteLoop(
            0.01, inertia=lambda q: np.diag(model.inertia + 0 * q), bias=model.bias, feedforward=True
        ),
    }[kind]()
    run = one_joint.simulate_sampled(
        ARM, law, sine, 2.0, period=0.01, start=0.3, conditions=LoopConditions(filter_time=0.02)
    )
    state, torques = [np.array([0.3]), np.array([0.0])], []

    def command(tau):
        torques.append(tau)
        y = solve_ivp(
            lambda _, y: [y[1], (tau[0] - 0.981 * np.cos(y[0]) - 0.1 * y[1]) / 0.5],
            (0, 0.01), [state[0][0], state[1][0]], "DOP853", rtol=1e-11, atol=1e-13,
        ).y[:, -1]  # fmt: skip
        state[:] = [np.array([y[0]]), np.array([y[1]])]

    run_loop(loop, lambda: state[0], command, lambda t: Desired(*sine(t)), 201)
    np.testing.assert_allclose(np.array(torques)[:, 0], run.torque, atol=1e-7)


@pytest.mark.capability("10-103", "10-10")
def test_filter_and_quantum():
    """A constant speed is differenced to itself; a quantum makes steps q0 / dt, which the filter smooths."""
    loops = [DiscreteLoop(0.01, 0.0, 0.0, 1.0, filter_time=T) for T in (0.0, 0.1)]
    speeds = []
    for k in range(200):
        reading = 0.02 * np.round(0.33 * k * 0.01 / 0.02)
        speeds.append([float(-loop.update(reading, Desired(0.0))) for loop in loops])
    raw, smooth = np.array(speeds)[100:].T
    assert set(np.round(raw, 9)) == {0.0, 2.0}
    assert np.ptp(smooth) < 0.3
    assert smooth.mean() == pytest.approx(0.33, abs=0.05)


@pytest.mark.capability("10-30")
def test_anti_windup():
    """With a weak drive the integral winds up; holding it, or leading it back, cuts the overshoot."""
    law = JointLaw.pid(20.0, 8.0, 6.0)
    overshoot, cost = {}, {}
    for kind in ("off", "hold", "back_calculation"):
        conditions = LoopConditions(torque_limit=2.0, anti_windup=kind, tracking_time=0.3)
        run = one_joint.simulate_sampled(FLAT, law, 3.0, 40.0, period=5e-3, conditions=conditions)
        assert np.abs(run.torque).max() <= 2.0
        assert abs(run.error[-1]) < 2e-3
        overshoot[kind], cost[kind] = -run.error.min(), run.rms_error
    assert max(overshoot["hold"], overshoot["back_calculation"]) < 0.6 * overshoot["off"]
    assert max(cost["hold"], cost["back_calculation"]) < cost["off"]


@pytest.mark.capability("10-93")
def test_runs_that_grow_say_so():
    law = JointLaw.pid([2.205, 400.0], 0.0, 2.0)
    run = one_joint.simulate_sampled(FLAT, law, 1.0, 60.0, period=0.01, conditions=LoopConditions(delay=20))
    assert [bool(each) for each in run] == [True, False]
    assert np.isnan(run.theta[1, -1])
    assert "diverged" in next(each for each in run if not each).explain()
    np.testing.assert_array_equal(run.torque[0, :20], 0.0)


@pytest.mark.capability("10-84", "10-11", "10-30", "10-35")
@pytest.mark.parametrize("anti_windup", ["off", "hold", "back_calculation"])
def test_quantum_delay_and_limit_against_the_loop_in_plain_python(anti_windup):
    """Encoder steps, two periods of delay, a weak drive; M q'' + b q' = tau in closed form over each period."""
    T, M, b, kp, ki, kd, quantum, limit, lag, back = 0.01, 0.5, 0.1, 40.0, 30.0, 5.0, 0.01, 3.0, 0.02, 0.15
    conditions = LoopConditions(
        torque_limit=limit, anti_windup=anti_windup, tracking_time=back, delay=2, quantum=quantum, filter_time=lag
    )
    run = one_joint.simulate_sampled(
        FLAT, JointLaw.pid(kp, ki, kd), 1.0, 2.0, period=T, start=0.123, conditions=conditions
    )
    q, w, total, rate, before, late = 0.123, 0.0, 0.0, 0.0, None, [0.0, 0.0]
    a, e = np.exp(-T / lag), np.exp(-b * T / M)
    thetas, torques = [], []
    for _ in range(201):
        seen = quantum * np.round(q / quantum)
        rate = 0.0 if before is None else a * rate + (1 - a) * (seen - before) / T
        before, error = seen, 1.0 - seen
        grown = total + error * T
        tau = kp * error + ki * grown - kd * rate
        given = np.clip(tau, -limit, limit)
        if anti_windup == "hold" and (tau - given) * error > 0:
            grown = total
            given = np.clip(kp * error + ki * grown - kd * rate, -limit, limit)
        total = grown + (T * (given - tau) / (ki * back) if anti_windup == "back_calculation" else 0.0)
        late.append(given)
        acting = late.pop(0)
        thetas.append(q)
        torques.append(acting)
        steady = acting / b
        q, w = q + steady * T + (w - steady) * (1 - e) * M / b, steady + (w - steady) * e
    np.testing.assert_allclose(run.torque, torques, atol=1e-9)
    np.testing.assert_allclose(run.theta, thetas, atol=1e-9)


@pytest.mark.capability("10-12")
def test_errors_are_read_at_times_and_runs_that_grew_say_when():
    law = JointLaw.pid(2.205, 0.0, 2.0)
    run = one_joint.simulate_joint(FLAT, law, 1.0, 4.0, step=0.02)
    exact = SecondOrder.of_joint(0.5, 2.1, 2.205).response([0.5, 2.0, 4.0])
    np.testing.assert_allclose(run.error_at([0.5, 2.0, 4.0]), exact, atol=1e-6)
    assert run.rms_error == pytest.approx(np.sqrt(np.trapezoid(run.error**2, run.t) / 4.0))
    late = LoopConditions(delay=20)
    wild = one_joint.simulate_sampled(FLAT, JointLaw.pid(400.0, 0.0, 2.0), 1.0, 60.0, period=0.01, conditions=late)
    last = np.flatnonzero(np.isfinite(wild.theta))[-1]
    assert f"{wild.t[last]:.6g} s" in wild.explain()


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: one_joint.simulate_joint(ARM, JointLaw.pid(1.0), 0.0, 1.0, step=0.3),
        lambda: one_joint.simulate_joint(ARM, JointLaw.pid(1.0), 0.0, -1.0),
        lambda: one_joint.simulate_joint(ARM, JointLaw.pid(1.0), lambda t: t, 1.0),
        lambda: one_joint.simulate_joint(ARM, JointLaw.pid(1.0), np.zeros(3), 1.0),
        lambda: one_joint.simulate_joint(ARM, JointLaw.pid([1.0, 2.0]), 0.0, 1.0, start=np.zeros(3)),
        lambda: one_joint.simulate_joint(ARM, "pid", 0.0, 1.0),
        lambda: one_joint.simulate_joint("arm", JointLaw.pid(1.0), 0.0, 1.0),
        lambda: one_joint.simulate_joint(ARM, JointLaw.pid(1.0), np.nan, 1.0),
        lambda: one_joint.simulate_sampled(ARM, JointLaw.pid(1.0), 0.0, 1.0, period=0.01, substeps=0),
        lambda: LoopConditions(anti_windup="some"),
        lambda: LoopConditions(delay=-1),
        lambda: DiscreteLoop(0.01, inertia=lambda q: q),
        lambda: DiscreteLoop(0.01, 1.0).update([np.nan], Desired(0.0)),
        lambda: JointArm.of(0.0),
    ],
)
def test_wrong_input(wrong):
    with pytest.raises(InputError):
        wrong()
