"""Worked numbers of the specification, parts 07, 09 and 10, through solvers, laws and the simulation."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import computed_torque, gravity_compensation, pid
from mafsil.geometry import pose
from mafsil.model import Friction, Inertial, Joint, JointKind, Link, Mechanism
from mafsil.model.library.textbook import planar2r, planar2r_point_masses
from mafsil.simulation import Plant
from mafsil.solvers import damped_step
from mafsil.trajectory import Motion
from mafsil.trajectory.profiles import rest

CASES = {
    case["id"].split(" ")[0]: case for case in json.loads(Path(__file__).with_name("10-closed-loops.json").read_text())
}


def agree(got, expected, tol):
    expected = np.asarray(expected, dtype=float)
    assert np.all(np.abs(np.asarray(got) - expected) <= tol * np.maximum(1.0, np.abs(expected)))


class Passive:
    """No efforts at all."""

    def __call__(self, t, q, qd, reference):
        return np.zeros_like(q)

    def session(self, period):
        return self


def one_joint_arm(given):
    """M theta'' + b theta' + m g r cos(theta) = tau."""
    mass, r = given["m"], given["r"]
    body = Inertial(mass, np.array([r, 0.0, 0.0]), np.diag([0.0, 0.0, given["M"] - mass * r**2]))
    joint = Joint("hinge", JointKind.REVOLUTE, "base", "arm", friction=Friction(viscous=given["b"]))
    return mf.Robot(
        Mechanism.assemble("one_joint", [Link("base"), Link("arm", body)], [joint], gravity=(0.0, -given["g"], 0.0))
    )


def run(robot, law, start, duration, step, integrator, rate=0.0, goal=0.0):
    reference = rest(np.broadcast_to(goal, (robot.n,)), duration)
    start, rate = (np.broadcast_to(np.asarray(x, dtype=float), (robot.n,)) for x in (start, rate))
    scenario = mf.Scenario(
        robot=robot, trajectory=reference, law=law, q=start, qd=rate, step=step, integrator=integrator
    )
    return mf.simulate(scenario)


def continuous(states):
    """The limit of vanishing sampling period, from periods h, h/2, h/4 with errors in powers of h."""
    a, b, c = states
    return (a - 6 * b + 8 * c) / 3


@pytest.mark.capability("09-65", "10-12", "10-15")
def test_one_joint_arm_by_explicit_euler():
    case = CASES["9-14"]
    given, expected = case["input"], case["expect"]
    recording = run(one_joint_arm(given), Passive(), 0.0, given["h"] * given["N"], given["h"], "euler")
    agree(recording.q[-1], expected["theta_end"], 1e-9)
    agree(recording.qd[-1], expected["dtheta_end"], 1e-9)
    fine = run(one_joint_arm(given), Passive(), 0.0, given["h"] * given["N"], 1e-3, "rk4")
    agree([fine.q[-1, 0], fine.qd[-1, 0]], [expected["reference_theta"], expected["reference_dtheta"]], 1e-9)


@pytest.mark.capability("09-65", "09-7")
def test_planar_arm_in_free_fall():
    case = CASES["9-15"]
    expected, start = case["expect"], case["input"]["theta0"]
    robot = mf.Robot(planar2r_point_masses([0.8, 0.5], [2.0, 1.5]))
    for step, key in ((0.01, "euler_h_0_01"), (0.005, "euler_h_0_005")):
        recording = run(robot, Passive(), start, 0.5, step, "euler")
        agree(np.concatenate([recording.q[-1], recording.qd[-1]]), expected[key], 1e-8)
        if key == "euler_h_0_01":
            energy = robot.kinetic_energy(recording.q, recording.qd) + robot.potential_energy(recording.q)
            agree(energy[[0, -1]], [expected["energy0"], expected["energy_euler_h_0_01"]], 1e-8)
    fine = run(robot, Passive(), start, 0.5, 5e-4, "rk4")
    agree(np.concatenate([fine.q[-1], fine.qd[-1]]), expected["reference_state"], 1e-8)


@pytest.mark.capability("09-64")
def test_sign_of_an_external_wrench():
    case = CASES["9-20"]
    robot = mf.Robot(planar2r_point_masses([0.8, 0.5], [2.0, 1.5]).with_gravity(np.zeros(3)))
    q = np.array([0.0, np.pi / 2])
    R = robot.forward_kinematics(q)[:3, :3]
    push = np.concatenate([np.zeros(3), R.T @ case["input"]["force_ON_tip_in_space_axes"]])
    qdd = Plant(robot).acceleration(q, np.zeros(2), np.zeros(2), push)
    agree(qdd, case["expect"]["ddtheta"], 1e-9)
    agree(R @ (robot.jacobian_body(q) @ qdd)[3:], case["expect"]["tip_acceleration_space"], 1e-9)


def test_rest_error_of_pd_under_gravity():
    case = CASES["pd_gravity_rest_error"]
    given, expected = case["input"], case["expected"]
    recording = run(one_joint_arm(given), pid(1, given["Kp"], given["Kd"]), -np.pi / 2, 40.0, 5e-3, "heun")
    agree(-recording.q[-1], expected["theta_e_inf"], case["tol"])
    agree(recording.tau[-1], expected["torque_inf"], case["tol"])


@pytest.mark.capability("10-32", "10-20")
def test_pd_and_pid_of_one_joint():
    case = CASES["pid_vs_pd_response"]
    given, expected = case["input"], case["expected"]
    robot = one_joint_arm(given)
    for ki, key in ((0.0, "theta_e_pd"), (given["Ki"], "theta_e_pid")):
        law = pid(1, given["Kp"], given["Kd"], ki)
        sampled = []
        for step in (2e-3, 1e-3, 5e-4):
            recording = run(robot, law, -np.pi / 2, 10.0, step, "rk4")
            sampled.append(-recording.q[np.round(np.array(expected["t"]) / step).astype(int), 0])
        agree(continuous(sampled), expected[key], case["tol"])


def planar_case(case):
    given = case["input"]["robot"]
    robot = mf.Robot(planar2r_point_masses([given["L1"], given["L2"]], [given["m1"], given["m2"]]))
    return robot, np.array(given["theta"]), np.array(given["theta_dot"])


@pytest.mark.capability("10-51", "10-52")
def test_computed_torque_of_the_planar_arm():
    case = CASES["planar2R_joint_computed_torque"]
    robot, q, qd = planar_case(case)
    given, expected = case["input"], case["expected"]
    reference = Motion(*(np.array(given[key]) for key in ("theta_d", "theta_d_dot", "theta_d_ddot")))
    law = computed_torque(robot, natural_frequency=np.sqrt(given["Kp"]), damping_ratio=given["Kd"] / 10.0)
    agree(law(0.0, q, qd, reference), expected["tau"], case["tol"])
    setpoint = reference._replace(v=np.zeros(2))
    slow = gravity_compensation(robot, given["Kp"], given["Kd"])
    agree(slow(0.0, q, qd, setpoint), expected["tau_PD_plus_gravity_setpoint"], case["tol"])


@pytest.mark.capability("10-52")
def test_pd_with_gravity_never_raises_its_lyapunov_function():
    case = CASES["pd_gravity_lyapunov"]
    robot, q, qd = planar_case(case)
    given, expected = case["input"], case["expected"]
    kp, kd, goal = (np.array(given[key]) for key in ("Kp", "Kd", "theta_d"))
    law = gravity_compensation(robot, kp, kd)

    def lyapunov(state):
        e = goal - state[..., :2]
        return (kp * e * e).sum(axis=-1) / 2 + robot.kinetic_energy(state[..., :2], state[..., 2:])

    sampled = []
    for step in (1e-3, 5e-4, 2.5e-4):
        recording = run(robot, law, q, 1.0, step, "rk4", rate=qd, goal=goal)
        states = np.concatenate([recording.q, recording.qd], axis=1)
        assert (np.diff(lyapunov(states)) <= 0.0).all()
        sampled.append(states[[0, (len(states) - 1) // 2, -1]])
    states = continuous(sampled)
    agree(lyapunov(states)[[0, 2]], [expected["V0"], expected["V_at_1s"]], case["tol"])
    agree(states[1], expected["state_at_0_5s"], case["tol"])
    agree(-(kd * states[1, 2:] ** 2).sum(), expected["Vdot_at_0_5s"], case["tol"])


@pytest.mark.capability("07-40")
def test_newton_iterates_of_the_planar_arm():
    case = CASES["ch07-newton-2R"]
    robot = mf.Robot(planar2r())
    q = np.radians(case["input"]["theta0_deg"])
    T = robot.forward_kinematics(np.radians(case["input"]["target_deg"]))
    iterates = [q]
    for _ in range(4):
        e = pose.error(robot.forward_kinematics(q), T)
        if len(iterates) == 1:
            agree(e, case["expected"]["V_b_first"], case["tol"])
        q = q + damped_step(robot.jacobian_body(q)[None], e[None], np.zeros(1))[0]
        iterates.append(q)
    agree(np.degrees(iterates), case["expected"]["iterates_deg"], case["tol"])
