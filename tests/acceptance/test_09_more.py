"""Further worked numbers of dynamics: the six-joint arm of case 9-09, energies, task space, a free body."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.derivation import derive_dynamics, derive_lagrange
from mafsil.geometry import pose, wrench
from mafsil.geometry.relative_motion import point_acceleration
from mafsil.mechanics.stacked_form import stacked_form
from mafsil.model.library.textbook import planar2r_point_masses
from tests.acceptance.reading import Watched, cases, unread_after

DEFINITIONS = Watched(json.loads(Path(__file__).with_name("09-definitions.json").read_text("utf-8")), "09-definitions")
ARM_CASES = {name: case for name, case in cases("09-dynamics.json").items() if name in ("9-06", "9-10", "9-12", "9-18")}
CASES = ARM_CASES | cases("09-more.json")


def near(got, expected, tol):
    np.testing.assert_allclose(got, np.asarray(expected, float), rtol=tol, atol=tol)


@cache
def six_joint_arm() -> mf.Robot:
    given = DEFINITIONS["9-09"]["robot"]
    frames = [np.eye(4) for _ in given["com_positions"]]
    for frame, place in zip(frames, given["com_positions"], strict=True):
        frame[:3, 3] = place
    assert given["com_rotations"] == "identity"
    home = np.eye(4)
    home[:3, 3] = given["M_tip_position"]
    return mf.Robot.from_screws(
        given["S"],
        home,
        inertials=[mf.model.Inertial(m, np.zeros(3), I) for m, I in zip(given["masses"], given["I"], strict=True)],
        inertial_frames=frames,
        gravity=DEFINITIONS["9-09"]["g_vec"],
    )


def state() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """q, qd, qdd and the wrench that the tip exerts."""
    given = DEFINITIONS["9-09"]
    return tuple(np.array(given[name], float) for name in ("theta", "dtheta", "ddtheta", "Ftip"))


def body() -> mf.simulation.RigidBody:
    given = DEFINITIONS["9-04"]
    assert given["com"] == [0.0, -0.01, 0.07]  # where the body's own frame has it; the cases' {b} lies at the COM
    return mf.simulation.RigidBody(mf.model.Inertial(given["mass"], np.zeros(3), np.array(given["I_com"])))


@pytest.mark.capability("09-30", "09-32", "09-33", "09-37")
def test_wrench_of_a_rigid_body():
    given, expect = CASES["9-06"]["input"], CASES["9-06"]["expect"]
    assert (given["I"], given["m"]) == ("I_com of 9-04", body().inertial.mass)
    V, dV = given["V"], given["Vdot"]
    near(body().wrench(V, dV), expect["F"], 1e-9)
    near(body().moment(V, dV), expect["F"][:3], 1e-9)
    near(body().force(V, dV), expect["F"][3:], 1e-9)
    near(body().momentum(V), expect["P"], 1e-9)
    near(body().kinetic_energy(V), expect["K"], 1e-9)


@pytest.mark.capability("09-56", "09-57", "09-58")
def test_coriolis_matrix_and_passivity():
    assert CASES["9-10"]["input"]["state"] == "9-09"
    expect, robot, (q, qd, _, _) = CASES["9-10"]["expect"], six_joint_arm(), state()
    C = robot.coriolis_matrix(q, qd)
    near(C, expect["C_christoffel"], 1e-8)
    near(C @ qd, expect["Cdtheta"], 1e-8)
    near(robot.velocity_torque(q, qd), expect["Cdtheta"], 1e-8)
    Mdot = C + C.T
    near(Mdot, expect["Mdot"], 1e-8)
    h = 1e-6
    near((robot.mass_matrix(q + h * qd) - robot.mass_matrix(q - h * qd)) / (2 * h), expect["Mdot"], 1e-8)
    skew = Mdot - 2 * C
    assert abs(np.abs(skew + skew.T).max() - expect["max_abs_sym_part_christoffel"]) < 1e-12
    form = stacked_form(robot.mechanism, q, qd)
    other = Mdot - 2 * form.C_newton_euler
    near(np.abs(other + other.T).max(), expect["max_abs_sym_part_of_newton_euler_matrix"], 1e-8)
    near(form.C_newton_euler @ qd, expect["Cdtheta"], 1e-8)
    assert np.abs(C @ qd - np.array(expect["c_by_printed_9_83_is_wrong"])).max() > 0.04


@pytest.mark.capability("09-46", "09-77")
def test_moving_base():
    given, robot = CASES["9-12"]["input"], six_joint_arm()
    assert given["robot"] == "9-09"
    near(robot.mechanism.gravity, given["g_vec"], 0)
    q, qd, qdd = (np.array(given[name]) for name in ("theta", "dtheta", "ddtheta"))
    tau = robot.inverse_dynamics(q, qd, qdd, given["Ftip"], base_twist=given["V0"], base_acceleration=given["dV0_true"])
    near(tau, CASES["9-12"]["expect"]["tau"], 1e-8)


@pytest.mark.capability("09-41", "09-42", "09-44", "09-45", "09-48")
def test_twists_and_wrenches_of_the_recursion():
    assert CASES["9-18"]["input"]["state"] == "9-09"
    expect, robot, (q, qd, qdd, F_tip) = CASES["9-18"]["expect"], six_joint_arm(), state()
    near(robot.com_twists(q, qd)[-1], expect["V6"], 1e-8)
    true = robot.com_accelerations(q, qd, qdd)[-1]
    R = robot.forward_kinematics(q)[:3, :3]  # as the frame at the centre of mass, parallel to {s} at q = 0
    less = true - np.concatenate([np.zeros(3), R.T @ robot.mechanism.gravity])
    near(less, expect["dV6_minus_gravity"], 1e-8)
    F = robot.com_wrenches(q, qd, qdd, F_tip)
    near(F[1], expect["F1"], 1e-8)
    near(F[-1], expect["F6"], 1e-8)


@pytest.mark.capability("09-15", "09-49")
def test_energies_of_the_planar_arm():
    """Link by link as derived in letters, and in sum as compiled; m2 multiplies the whole bracket of K2."""
    given, expect, tol = CASES["9-21"]["inputs"], CASES["9-21"]["expected"], CASES["9-21"]["tol"]
    robot = mf.Robot(planar2r_point_masses(given["L"], given["m"]).with_gravity(np.array([0, -given["g"], 0])))
    q, qd = np.array(given["theta"]), np.array(given["dtheta"])
    (m1, m2), (L1, L2), g = given["m"], given["L"], given["g"]
    values = {"m1": m1, "m2": m2, "L1": L1, "L2": L2, "g": g, "theta1": q[0], "theta2": q[1]}
    values |= {"dtheta1": qd[0], "dtheta2": qd[1]}
    found = derive_lagrange(
        "m1*L1**2*dt1**2/2 + m2/2*(L1**2*dt1**2 + 2*L1*L2*cos(t2)*(dt1**2 + dt1*dt2) + L2**2*(dt1 + dt2)**2)",
        "(m1 + m2)*g*L1*sin(t1) + m2*g*L2*sin(t1 + t2)",
        ["t1", "t2"],
    )
    typed = {**values, "t1": q[0], "t2": q[1], "dt1": qd[0], "dt2": qd[1]}
    by_letter = {line.left[0].letter: line.sides[0].evaluate(typed) for line in found.lines[:3]}
    near(by_letter["K"], expect["K1"] + expect["K2"], tol)
    near(by_letter["P"], expect["P1"] + expect["P2"], tol)
    near(by_letter["L"], expect["L"], tol)
    near(robot.kinetic_energy(q, qd), expect["K1"] + expect["K2"], tol)
    near(robot.potential_energy(q), expect["P1"] + expect["P2"], tol)
    lines = {
        line.left[0].letter + line.left[0].index: line.sides[-1] for line in derive_dynamics(robot.mechanism).lines
    }
    letters = {name: lines[name].evaluate(_letters_of(lines, values)) for name in ("K1", "K2", "P1", "P2")}
    for name, value in letters.items():
        near(value, expect[name], tol)
    assert abs(letters["K2"] - expect["printed_K2_is_wrong"]) > 0.1


def _letters_of(lines, values):
    """The derivation's own letters, its numbers read from its first lines, with the state of the case."""
    numbers = {
        name: float(str(side).split()[0].replace("−", "-")) for name, side in lines.items() if isinstance(side, str)
    }
    return {**values, **numbers, "a1": values["L1"], "a2": values["L2"]}


@pytest.mark.capability("09-73")
def test_kinematics_and_mass_parameters_separate():
    given, expect, tol = CASES["9-23"]["inputs"], CASES["9-23"]["expected"], CASES["9-23"]["tol"]
    q, qd, qdd = (np.array(given[name]) for name in ("theta", "dtheta", "ddtheta"))

    def arm(masses):
        return mf.Robot(planar2r_point_masses(given["L"], masses).with_gravity(np.array(given["g_vec"], float)))

    robot = arm(given["m"])
    per_link = np.einsum("ilp,lp->il", robot.regressor(q, qd, qdd), robot.inertial_parameters)
    Y = per_link[:, -2:] / np.array(given["m"])
    near(Y, expect["Y"], tol)
    near(np.stack([arm(unit).inverse_dynamics(q, qd, qdd) for unit in ([1, 1e-300], [1e-300, 1])], axis=1), Y, tol)
    near(Y @ given["m"], expect["tau"], tol)
    near(robot.inverse_dynamics(q, qd, qdd), expect["tau"], tol)


@pytest.mark.capability("09-67", "09-69", "09-70")
def test_task_space_with_a_tip_wrench():
    case, robot, (q, qd, _, F_tip) = CASES["9-25"], six_joint_arm(), state()
    expect, tol, tau = case["expected"], case["tol"], case["inputs"]["tau"]
    assert case["inputs"]["state"] == "9-09"
    body_form, space_form = robot.task_space(q, qd), robot.task_space(q, qd, expressed_in="space")
    near(np.linalg.cond(body_form.J), expect["cond_J"], tol)
    near(np.diag(body_form.Lambda), expect["Lambda_body_diag"], tol)
    near(body_form.eta, expect["eta_body"], tol)
    near(space_form.eta, expect["eta_space"], tol)
    T_sb = robot.forward_kinematics(q)
    T_bs = np.linalg.inv(T_sb)
    near(wrench.transform(T_bs, body_form.eta), expect["eta_space"], tol)
    dV = body_form.acceleration(body_form.task_force(tau), F_tip)
    near(dV, expect["dV_body"], tol)
    near(body_form.acceleration(np.zeros(6), F_tip), expect["dV_body_tau_zero"], tol)
    near(body_form.force(expect["dV_body"], F_tip), np.linalg.solve(body_form.J.T, tau), 1e-5)
    qdd = robot.forward_dynamics(q, qd, tau, F_tip)
    near(robot.jacobian_body(q) @ qdd + robot.jacobian_body_rate(q, qd) @ qd, expect["dV_body"], tol)
    F_space = wrench.transform(T_bs, F_tip)
    dV_space = space_form.acceleration(space_form.task_force(tau), F_space)
    near(pose.adjoint(T_sb) @ dV, dV_space, tol)


@pytest.mark.capability("09-23", "09-26", "09-31")
def test_force_at_a_point_of_a_free_body():
    case = CASES["9-27"]
    given, expect, tol = case["inputs"], case["expected"], case["tol"]
    assert (given["I"], given["m"]) == ("I_com of 9-04", body().inertial.mass)
    F = mf.Wrench.from_force(given["r"], given["f"])
    near(F.array, expect["F"], tol)
    dV = body().acceleration(given["V"], F.array)
    near(dV, expect["dV"], tol)
    near(point_acceleration(given["V"], dV), expect["a_com"], tol)
    near(np.array(given["f"]) / given["m"], expect["a_com"], tol)
    near(mf.Twist(given["V"]).power(F), expect["power"], tol)


def test_every_key_of_every_case_is_read(request):
    del request  # an argument, so that the guard does not call itself
    assert unread_after(globals(), CASES) == []
    assert DEFINITIONS.unread() == []
