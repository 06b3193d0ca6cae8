"""Runs that follow each other with one memory are one run, for every law that remembers something."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import add_delay, combine, current_loop, hold_pose
from mafsil.control.laws import LawMemory
from mafsil.control.laws.matrix_feedback import matrix_pid
from mafsil.errors import InputError
from mafsil.simulation import Plant
from mafsil.trajectory import quintic, sequence
from mafsil.trajectory.profiles import rest

ARM = mf.load("planar2r_point_masses")
A, B = np.array([0.3, 0.8]), np.array([0.5, 0.6])
PARTS = quintic(A, B, 0.2), rest(B, 0.2)
WHOLE = sequence(*PARTS)
IN_PLANE = mf.control.TaskCoordinates(rows=(3, 4))


def task_law():
    still = hold_pose(ARM.forward_kinematics(B))
    return mf.control.task_computed_torque(ARM, still, coordinates=IN_PLANE, integral=900.0)


def admittance():
    # Of no outer force: the virtual mass swings about a place beside the tip.
    wanted = mf.control.Impedance.of(2, inertia=1.0, damping=2.0, stiffness=50.0)
    still = hold_pose(ARM.forward_kinematics(B))
    return mf.control.admittance_control(ARM, wanted, still, lambda q, qd: np.zeros(2), coordinates=IN_PLANE)


WAITING = combine(
    mf.control.feedforward(ARM), mf.control.gravity_compensation(ARM, 300.0, 3.0, 900.0, effort_limit=[5.0, np.inf])
)
LAWS = {
    "pid": mf.control.pid(2, 300.0, 30.0, 900.0),
    "gravity": mf.control.gravity_compensation(ARM, 300.0, 30.0, 500.0),
    "torque": mf.control.computed_torque(ARM, integral=900.0),
    "matrix": matrix_pid(2, np.diag([300.0, 200.0]), 30.0 * np.eye(2), 400.0 * np.eye(2)),
    "task": task_law(),
    "force": mf.control.force_control(
        ARM, [0, 0, 0, 1.0, 2.0, 0], sensor=lambda q, qd: np.zeros(6), ki=3.0, damping=20.0
    ),
    "adaptive": mf.control.adaptive_control(ARM),
    "admittance": admittance(),
    "delayed": add_delay(mf.control.pid(2, 300.0, 30.0, 900.0), 0.004),
    "current": current_loop(mf.control.pid(2, 300.0, 30.0, 900.0), 300.0),
    "sum": combine(mf.control.feedforward(ARM), mf.control.pid(2, 300.0, 30.0, 900.0)),
}


def run(law, trajectory, memory=None, before=None, **changes):
    state = {} if before is None else {"q": before.q[-1], "qd": before.qd[-1]}
    plant = Plant(ARM, friction=False).with_payload(0.5)
    scenario = mf.Scenario(robot=ARM, trajectory=trajectory, law=law, plant=plant, saturate=False, **state)
    return mf.simulate(scenario, memory=memory, **changes)


@pytest.mark.parametrize("name", LAWS)
def test_two_runs_with_one_memory_are_one_run_and_without_it_they_are_not(name):
    law, memory = LAWS[name], LawMemory()
    whole, first = run(law, WHOLE, fused=False), run(law, PARTS[0], memory)
    second, fresh = run(law, PARTS[1], memory, first), run(law, PARTS[1], None, first)
    later = whole.t >= 0.2 - 1e-9
    np.testing.assert_allclose(second.q, whole.q[later], rtol=0, atol=1e-10)
    np.testing.assert_allclose(second.tau, whole.tau[later], rtol=0, atol=1e-7)
    assert np.abs(fresh.tau - whole.tau[later]).max() > 1e-4


def test_a_law_of_another_kind_begins_afresh_and_gains_that_change_make_no_jump():
    memory = LawMemory()
    first = run(LAWS["pid"], WHOLE, memory)
    stiffer = run(mf.control.pid(2, 600.0, 60.0, 1800.0), rest(B, 0.05), memory, first)
    # What carries the arm is what the integral holds; with another gain it is still that.
    held = first.tau[-1] - 300.0 * (B - first.q[-1]) + 30.0 * first.qd[-1]
    np.testing.assert_allclose(
        stiffer.tau[0], held + 600.0 * (B - first.q[-1]) - 60.0 * first.qd[-1], atol=2.0 * np.abs(B - first.q[-1]).max()
    )
    other = run(LAWS["adaptive"], rest(B, 0.05), memory, first)
    np.testing.assert_array_equal(other.tau, run(LAWS["adaptive"], rest(B, 0.05), None, first).tau)


@pytest.mark.parametrize("name", ["pid", "torque", "waiting", "sum"])
def test_compiled_runs_hand_on_what_their_law_remembers(name):
    """A compiled run, one in Python, a compiled one: each goes on with the integral of the one before."""
    law, memory, tape = (LAWS | {"waiting": WAITING})[name], LawMemory(), None
    whole, begin = run(law, sequence(PARTS[0], rest(B, 0.1), rest(B, 0.1)), fused=False), 0
    for trajectory, fused in ((PARTS[0], True), (rest(B, 0.1), False), (rest(B, 0.1), True)):
        tape = run(law, trajectory, memory, tape, fused=fused)
        assert tape.metadata["fused"] == fused
        here = slice(begin, begin + len(tape.t))
        np.testing.assert_allclose(tape.tau, whole.tau[here], rtol=0, atol=1e-7)
        begin += len(tape.t) - 1
    with pytest.raises(InputError, match="memory"):
        run(law, WHOLE, memory={})
