"""Laws against the equations they stand for; gains against the roots they promise."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil import one_joint
from mafsil.control import (
    Gains,
    Impedance,
    Law,
    as_law,
    block_diagram,
    combine,
    computed_torque,
    encoder_loop,
    energy_certificate,
    feedforward,
    gravity_compensation,
    hold_pose,
    pid,
    saturate,
    sliding_certificate,
)
from mafsil.control.analysis import words_for
from mafsil.control.contact import hybrid_certificate
from mafsil.control.joints import set_point_condition
from mafsil.errors import InputError
from mafsil.trajectory import Motion
from mafsil.trajectory.profiles import rest

SOFT = Impedance.of(6, inertia=1.0, stiffness=1.0)


@pytest.fixture(scope="module")
def panda():
    return mf.load("panda")


def state(shape, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(5, *shape))


@pytest.mark.capability("10-51", "10-40")
@pytest.mark.parametrize("batch", [(), (4,), (2, 3)])
def test_computed_torque_makes_the_error_linear(panda, batch):
    """With the true model, e'' = -Kd e' - Kp e, whatever the state."""
    q, qd, u, v, a = state((*batch, 7))
    law = computed_torque(panda, natural_frequency=[3, 4, 5, 6, 7, 8, 9], damping_ratio=0.7)
    qdd = panda.forward_dynamics(q, qd, law(0.0, q, qd, Motion(u, v, a)))
    w = np.arange(3.0, 10.0)
    np.testing.assert_allclose(a - qdd, -1.4 * w * (v - qd) - w**2 * (u - q), atol=1e-9)
    assert isinstance(law, Law)
    assert law.session(1e-3) is law


@pytest.mark.capability("10-38")
def test_feedforward_ignores_the_state(panda):
    q, qd, u, v, a = state((7,))
    law = feedforward(panda)
    np.testing.assert_array_equal(law(0.0, q, qd, Motion(u, v, a)), panda.inverse_dynamics(u, v, a))
    assert law.session(1.0) is law


@pytest.mark.capability("10-52")
def test_gravity_compensation_holds_the_arm(panda):
    q, _, u, v, a = state((7,))
    rest = gravity_compensation(panda, kp=50.0, kd=5.0)(0.0, q, np.zeros(7), Motion(q, np.zeros(7), a))
    np.testing.assert_allclose(panda.forward_dynamics(q, np.zeros(7), rest), 0.0, atol=1e-9)
    pulled = gravity_compensation(panda, kp=50.0, kd=5.0)(0.0, q, np.zeros(7), Motion(u, v, a))
    np.testing.assert_allclose(pulled - rest, 50.0 * (u - q) + 5.0 * v, atol=1e-12)


@pytest.mark.capability("10-20", "10-49")
def test_integral_sums_the_error():
    law = pid(2, kp=0.0, ki=[2.0, 3.0]).session(0.1)
    zero = np.zeros(2)
    reference = Motion(np.array([1.0, -1.0]), zero, zero)
    for count in range(1, 5):
        np.testing.assert_allclose(law(0.0, zero, zero, reference), [0.2 * count, -0.3 * count])
    fresh = law.session(0.1)
    np.testing.assert_allclose(fresh(0.0, zero, zero, reference), [0.2, -0.3])


def test_sessions_share_nothing(panda):
    law = computed_torque(panda, natural_frequency=5.0, integral=10.0)
    q, qd, u, v, a = state((7,))
    one, two = law.session(0.01), law.session(0.01)
    first = one(0.0, q, qd, Motion(u, v, a))
    one(0.0, q, qd, Motion(u, v, a))
    np.testing.assert_array_equal(two(0.0, q, qd, Motion(u, v, a)), first)
    assert not np.array_equal(first, law(0.0, q, qd, Motion(u, v, a)))


@pytest.mark.capability("10-3")
def test_laws_add(panda):
    q, qd, u, v, a = state((7,))
    parts = feedforward(panda), pid(7, kp=3.0, kd=1.0, ki=2.0)
    both = combine(*parts)
    reference = Motion(u, v, a)
    np.testing.assert_allclose(both(0.0, q, qd, reference), sum(part(0.0, q, qd, reference) for part in parts))
    run = both.session(0.5)
    np.testing.assert_allclose(run(0, q, qd, reference) - both(0, q, qd, reference), u - q, atol=1e-12)


def test_saturation_clips_elementwise():
    np.testing.assert_array_equal(saturate(np.array([3.0, -3.0, 9.0]), np.array([2.0, 2.0, np.inf])), [2.0, -2.0, 9.0])


@pytest.mark.capability("10-28", "10-33")
def test_gains_place_the_roots():
    gains = Gains.from_natural_frequency(1, 4.0, 0.5)
    roots = np.roots([1.0, gains.kd[0], gains.kp[0]])
    np.testing.assert_allclose(np.abs(roots), 4.0)
    np.testing.assert_allclose(roots.real, -2.0)
    bound = 2 * 0.5 * 4.0**3
    stable = Gains.from_natural_frequency(1, 4.0, 0.5, 0.999 * bound)
    assert (np.roots([1.0, stable.kd[0], stable.kp[0], stable.ki[0]]).real < 0).all()
    with pytest.raises(InputError, match="integral"):
        Gains.from_natural_frequency(1, 4.0, 0.5, bound)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda r: computed_torque(r, natural_frequency=[1.0, 2.0]), "natural_frequency"),
        (lambda r: computed_torque(r, natural_frequency=np.nan), "natural_frequency"),
        (lambda r: computed_torque(r, damping_ratio=-1.0), "damping_ratio"),
        (lambda r: gravity_compensation(r, kp=-1.0, kd=0.0), "kp"),
        (lambda r: pid(3, kp=[1.0, 2.0]), "kp"),
    ],
)
def test_wrong_input_is_named(panda, call, words):
    with pytest.raises(InputError, match=words):
        call(panda)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: pid(0, 1.0), "n: expected a whole number from 1"),
        (lambda: pid(np.array([1.0, 2.0]), 1.0), "n: expected a whole number"),
        (lambda: mf.control.matrix_pid([[1.0]], 1.0), "n: expected a whole number"),
        (lambda: mf.control.impedance_control("ur5e", SOFT, np.eye(4)), "reference: expected a function of time"),
        (lambda: mf.control.task_computed_torque("ur5e", "there"), "reference: expected a function of time"),
        (
            lambda: mf.control.admittance_control("ur5e", SOFT, hold_pose(np.eye(4)), None),
            "sensor: expected a function",
        ),
        (
            lambda: mf.control.impedance_by_force("ur5e", SOFT, hold_pose(np.eye(4)), None),
            "sensor: expected a function",
        ),
    ],
)
def test_what_makes_no_law_is_said_where_it_is_made(made, words):
    with pytest.raises(InputError, match=words):
        made()


@pytest.mark.capability("10-2", "10-3")
def test_a_plain_function_is_a_law():
    def pull(t, q, qd, reference):
        return 3.0 * (reference.u - q) - qd

    still = Motion(np.array([0.3, 0.1]), np.zeros(2), np.zeros(2))
    law = combine(pull, pid(2, kp=2.0))
    np.testing.assert_allclose(law.session(1e-3)(0.0, np.zeros(2), np.zeros(2), still), 5.0 * still.u)
    assert as_law(law) is law
    for wrong in (3, None, lambda t, q: q, Gains):
        with pytest.raises(InputError, match="Law"):
            as_law(wrong)
    with pytest.raises(InputError, match="laws"):
        combine()


LINK = """<robot name="link"><link name="base"/><link name="arm"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.49" izz="0.49" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="joint" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 -1 0"/>
<limit lower="-9" upper="9" effort="1.6" velocity="9"/><dynamics damping="0.1"/></joint></robot>"""


@pytest.mark.capability("10-20", "10-30")
@pytest.mark.parametrize("anti_windup", ["off", "hold"])
def test_an_integral_that_waits_at_the_limit_is_that_of_the_one_joint_loop(tmp_path, anti_windup):
    """The link of one joint in both simulations, thrown up with 1.6 N m: the same motion, to rounding."""
    (tmp_path / "link.urdf").write_text(LINK)
    robot = mf.load(tmp_path / "link.urdf")
    law = pid(1, 8.0, 2.0, 6.0, effort_limit=1.6 if anti_windup == "hold" else None)
    run = mf.simulate(
        mf.Scenario(
            robot=robot, trajectory=rest([1.2], 4.0), q=[-1.0], qd=[0.0], law=law, period=0.01, step=1e-3,
            integrator="rk4",
        )
    )  # fmt: skip
    known = one_joint.simulate_sampled(
        one_joint.JointArm.of(0.5, 1.0, 0.1, 0.1), one_joint.JointLaw.pid(8.0, 6.0, 2.0), 1.2, 4.0, period=0.01,
        start=-1.0, conditions=one_joint.LoopConditions(torque_limit=1.6, anti_windup=anti_windup, tachometer=True),
    )  # fmt: skip
    np.testing.assert_allclose(run.q[:, 0], known.theta, atol=1e-8)
    assert (run.q.max() < 1.5) == (anti_windup == "hold"), "without it the link goes over by three radians"
    with pytest.raises(InputError, match="effort_limit"):
        pid(1, 8.0, effort_limit=0.0)


@pytest.mark.capability("10-10", "10-11", "10-103")
@pytest.mark.parametrize("filter_time", [0.0, 0.03])
def test_a_law_behind_encoders_is_the_sampled_loop_of_one_joint(tmp_path, filter_time):
    """Steps of 10 mrad, differenced rates and their filter: the same motion in both simulations, to rounding."""
    (tmp_path / "link.urdf").write_text(LINK)
    robot = mf.load(tmp_path / "link.urdf")
    law = encoder_loop(pid(1, 8.0, 2.0, 1.0), 0.01, filter_time=filter_time)
    run = mf.simulate(
        mf.Scenario(
            robot=robot, trajectory=rest([0.4], 2.0), q=[-0.3], qd=[0.0], law=law, period=0.01, step=1e-3,
            integrator="rk4", saturate=False,
        )
    )  # fmt: skip
    known = one_joint.simulate_sampled(
        one_joint.JointArm.of(0.5, 1.0, 0.1, 0.1), one_joint.JointLaw.pid(8.0, 1.0, 2.0), 0.4, 2.0, period=0.01,
        start=-0.3, conditions=one_joint.LoopConditions(quantum=0.01, filter_time=filter_time),
    )  # fmt: skip
    np.testing.assert_allclose(run.q[:, 0], known.theta, atol=1e-8)
    assert run.metadata["law"] == "JointFeedback"
    assert block_diagram(law).blocks[-1].text == "Δq = 0.01"
    assert words_for(law).name == "encoder_loop"


def test_encoders_of_many_joints_have_steps_of_their_own():
    seen = []

    def watched(t, q, qd, reference):
        seen.append((q, qd))
        return 0.0 * q

    law, still = encoder_loop(watched, [0.1, 0.0]), Motion(*np.zeros((3, 2)))
    session = law.session(0.5)
    for q in ([[0.16, 0.16], [1.0, 2.0]], [[0.31, 0.2], [1.04, 2.0]]):
        session(0.0, np.array(q), np.full((2, 2), np.nan), still)
    np.testing.assert_allclose(seen[0], [[[0.2, 0.16], [1.0, 2.0]], np.zeros((2, 2))])
    np.testing.assert_allclose(seen[1], [[[0.3, 0.2], [1.0, 2.0]], [[0.2, 0.08], [0.0, 0.0]]], atol=1e-12)
    for wrong in (lambda: encoder_loop(watched, -0.1), lambda: encoder_loop(3, 0.1),
                  lambda: encoder_loop(watched, 0.1, filter_time=np.inf)):  # fmt: skip
        with pytest.raises(InputError):
            wrong()


@pytest.mark.parametrize(
    "certificate",
    [
        lambda: energy_certificate(mf.load("planar2r"), Gains.of(2, 1.0, 1.0), [0, 0], [0, 1], *np.zeros((2, 2, 2))),
        lambda: sliding_certificate(pid(2, 1.0), mf.load("planar2r"), rest([0, 0], 1.0), [0, 1], *np.zeros((2, 2, 2))),
        lambda: hybrid_certificate(pid(2, 1.0), [0, 1, 2], *np.zeros((2, 3, 2))),
        lambda: set_point_condition(pid(2, 1.0)),
    ],
)
def test_certificates_of_other_laws_are_refused(certificate):
    with pytest.raises(InputError, match="law: expected"):
        certificate()


@pytest.mark.parametrize(
    "call",
    [
        lambda: mf.control.add_delay(pid(2, 1.0), None),
        lambda: mf.control.selection(3, 3, 3),
        lambda: mf.control.contact.constrained_dynamics(3.0, [0.0], [[1.0]], [0.0]),
        lambda: mf.control.contact.contact_mode([1.0, 2.0], 1.0, 0.3),
        lambda: mf.control.constraint_table((True,), ("hard",), ("x",)),
        lambda: mf.control.recommend_controller(None, None),
        lambda: mf.control.analysis.impedance_class(None, SOFT),
        lambda: mf.control.motor_feedback(mf.load("planar2r"), 1.0, 1.0),
        lambda: mf.control.citation(["hogan1985"]),
        lambda: mf.control.contact.constraint_in_joints([[1.0, 0.0]], np.eye(3)),
        lambda: mf.control.contact.free_speed([1.0, 2.0], 0.5, 1.0, 2.0, 1.0, 0.1),
        lambda: one_joint.joint_margins(mf.load("planar2r"), one_joint.JointLaw.pid(1.0)),
        lambda: one_joint.sampled_stability(one_joint.JointArm.of(1.0), pid(1, 1.0), 0.01),
        lambda: one_joint.sweep_rate(one_joint.JointArm.of(1.0), pid(1, 1.0), 1.0, 1.0, [0.1]),
    ],
)
def test_things_of_another_kind_are_named(call):
    with pytest.raises(InputError):
        call()
