"""What a stranger may hand over: wrong shapes, text, infinite and missing numbers; each is named in both languages."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil import control, one_joint, simulation
from mafsil.control import Gains, Impedance
from mafsil.control.joints import MotionEstimator
from mafsil.errors import InputError
from mafsil.one_joint import Gear, JointArm, TrackingError, ViscousJoint
from mafsil.one_joint.drives import FrictionConditions
from mafsil.simulation.motion import differentiate

ARM = mf.load("planar2r")
TWO = JointArm.of([0.5, 0.6], 1.0, 0.1)
EYE = np.eye(4)
NAMED = {
    "kp": lambda: control.contact.force_error(np.ones((3, 2, 2)), 1.0, [1.0, 2.0], 0.0),
    "bias": lambda: control.contact.applied_wrench(np.zeros(6), np.eye(6), np.zeros(6), "none"),
    "damping": lambda: control.contact.least_virtual_mass("much", 1.0, 0.01),
    "stiffness": lambda: control.contact.guiding_line([0, 0, 0], [1, 0, 0], [1.0, 2.0]),
    "too small or too large": lambda: control.contact.admittance_radius(1.0, 1.0, 1.0, 1e308),
    "period": lambda: control.contact.effective_admittance(1.0, 1.0, 1.0, kp=1.0, kd=1.0, period=None),
    "n": lambda: Gains.of(None, 1.0, 1.0),
    "m": lambda: Impedance.of("two", inertia=1.0),
    "X": lambda: Impedance.of(2, inertia=1.0).acceleration([1.0], [0.0, 0.0], [0.0, 0.0]),
    "T_sd": lambda: control.hold_pose(np.full((4, 4), np.nan)),
    "A": lambda: control.contact.constant_constraint([[np.nan] * 6]),
    "axes": lambda: control.laws.target_in_axes(EYE, np.zeros(6), np.zeros(6), "cylinder"),
    "natural_frequency": lambda: control.compare_pose_errors(EYE, EYE, natural_frequency=0.0),
    "start": lambda: control.compare_pose_errors(np.zeros((0, 4, 4)), EYE),
    "trajectory": lambda: control.analysis.joint_or_task_space(ARM, "straight"),
    "law": lambda: control.block_diagram(3),
    "inertia": lambda: control.contact.constrained_dynamics(np.zeros((2, 2)), np.zeros(2), [1.0, 0.0], np.zeros(2)),
    "environment": lambda: control.contact.tip_wrench_of(ARM, "wall", np.zeros(2), np.zeros(2)),
    "filter_time": lambda: control.encoder_loop(control.pid(2, 1.0), 0.01, filter_time="slow"),
    "q": lambda: MotionEstimator(50.0, 0.01, np.zeros(2)).update([np.nan, 0.0]),
    "effort": lambda: control.saturate("all", np.ones(2)),
    "torque": lambda: ViscousJoint.of([1.0, 2.0], 1.0).speed([1.0, 2.0, 3.0]),
    "theta": lambda: TWO.energy([1.0, 2.0, 3.0], 0.0),
    "link_inertia": lambda: Gear.of([1.0, 2.0]).payload_sensitivity([1.0, 2.0, 3.0], 1.0),
    "speed": lambda: TrackingError.of([1.0, 2.0], 0.1, 1.0).ramp(np.zeros(3)),
    "friction": lambda: FrictionConditions.of("steel"),
    "gains": lambda: one_joint.root_locus([1.0, 1.0], [1.0], np.zeros((2, 2))),
    "goal": lambda: one_joint.steady_state_of_joints(1.0, lambda q: q, np.zeros((2, 2))),
    "gravity": lambda: one_joint.steady_state_of_joints(1.0, lambda q: "down", np.zeros(2)),
    "wanted": lambda: one_joint.gains_from_roots(1.0, 0.1, [[-1.0], [-1.0, -2.0]]),
    "desired": lambda: one_joint.DiscreteLoop(0.01, 1.0).update([0.0], None),
    "duration": lambda: one_joint.simulate_sampled(TWO, one_joint.JointLaw.pid(1.0), 0.0, [1.0, 2.0], period=0.01),
    "step [s]": lambda: one_joint.simulate_sampled(TWO, one_joint.JointLaw.pid(1.0), 0.0, 1e308, period=0.01),
    "steady_error": lambda: one_joint.measure_response([0.0, 1.0, 2.0], [1.0, 0.5, 0.1], steady_error=[0.0, 1.0]),
    "push": lambda: simulation.Plant(ARM).acceleration(np.zeros(2), np.zeros(2), np.zeros(2), "hard"),
    "p": lambda: simulation.RigidSurface.plane([0, 0, 0], [0, 0, 1]).distance(None),
    "values": lambda: differentiate([0.0, 1.0, 2.0], [1.0, 2.0]),
    "t": lambda: differentiate([0.0, 1.0, 1.0], [1.0, 2.0, 3.0]),
    "preferred": lambda: simulation.choose_integrator(simulation.Plant(ARM), np.zeros((1, 2)), 1e-3, "best"),
}


@pytest.mark.parametrize("name", NAMED)
def test_what_is_wrong_is_named(name):
    with pytest.raises(InputError) as caught:
        NAMED[name]()
    english, arabic = (caught.value.message(language) for language in ("en", "ar"))
    assert english != arabic
    if name not in ("step [s]", "preferred", "law"):
        assert name in english


@pytest.mark.capability("10-29")
def test_a_root_that_both_polynomials_share_is_double_where_the_other_one_meets_it():
    """(s + 1) (s + 0.5 + K): at K = 0.5 twice -1; of (s + 1) (s + 1.2 + K) never, for K >= 0."""
    found = one_joint.root_locus(np.poly([-1.0, -0.5]), [1.0, 1.0], [0.0, 1.0])
    np.testing.assert_allclose(found.meeting_gains, [0.5], rtol=1e-9)
    np.testing.assert_allclose(found.meetings, [-1.0], rtol=1e-9)
    assert not len(one_joint.root_locus(np.poly([-1.0, -1.2]), [1.0, 1.0], [0.0, 1.0]).meetings)
