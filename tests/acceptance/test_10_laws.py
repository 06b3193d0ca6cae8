"""Worked numbers of part 10 on many joints, forces, constraints and impedances, through the public face."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import (
    Gains,
    Impedance,
    TaskCoordinates,
    TaskTarget,
    admittance_control,
    computed_torque,
    constraint_table,
    energy_certificate,
    gravity_compensation,
    hybrid_control,
    impedance_by_force,
    impedance_control,
    selection,
    task_computed_torque,
    task_dynamics,
)
from mafsil.control.contact import (
    admittance_radius,
    constrained_dynamics,
    effective_admittance,
    force_error,
    free_speed,
    least_virtual_mass,
    sampled_force_radius,
)
from mafsil.model import Friction
from mafsil.model.library.textbook import planar2r_point_masses
from mafsil.simulation import Plant
from mafsil.trajectory import Motion
from mafsil.trajectory.profiles import rest
from tests.acceptance.reading import cases, unread_after
from tests.acceptance.test_10_closed_loops import continuous

MINE = (
    "planar2R_joint_computed_torque", "planar2R_task_computed_torque", "pd_gravity_lyapunov", "force_pi", "damper_env",
    "hybrid_planar2R_wall", "hybrid_curved_constraint", "impedance_admittance", "impedance_planar2R",
    "impedance_robot_meets_wall", "admittance_stability_limits", "pd_gravity_lyapunov_energy_balance",
    "force_law_free_space_runaway", "force_pi_sampled_one_step_delay",
)  # fmt: skip
CASES = {name: case for name, case in cases("10-control.json", "10-more.json").items() if name in MINE}
XY = TaskCoordinates(rows=(3, 4))
ZERO = np.zeros(6)


def agree(got, expected, tol):
    expected = np.asarray(expected, dtype=float)
    np.testing.assert_allclose(got, expected, rtol=tol, atol=tol)


def arm(given):
    """The planar arm of a case, with its state."""
    assert given["masses"] == "points at link ends"
    assert given["gravity"] == "-y"
    assert given["g"] == 9.81
    mechanism = planar2r_point_masses((given["L1"], given["L2"]), (given["m1"], given["m2"]))
    assert mechanism.gravity[1] == -9.81
    state = np.array(given["theta"]), np.array(given.get("theta_dot", [0.0, 0.0]))
    return mf.Robot(mechanism), *state


def target(T, X=(0.0, 0.0), V=(0.0, 0.0), A=(0.0, 0.0)):
    """A reference in the plane, away from a pose."""
    P = np.array(T)
    P[:2, 3] += X
    return lambda t: TaskTarget(P, np.array([0, 0, 0, *V, 0.0]), np.array([0, 0, 0, *A, 0.0]))


@pytest.mark.capability("10-48", "10-51", "10-52")
def test_joint_computed_torque():
    case = CASES["planar2R_joint_computed_torque"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    robot, q, qd = arm(given["robot"])
    law = computed_torque(
        robot,
        natural_frequency=np.sqrt(given["Kp"]),
        damping_ratio=given["Kd"] / 2 / np.sqrt(given["Kp"]),
        integral=given["Ki"],
    )
    reference = Motion(*(np.array(given[name]) for name in ("theta_d", "theta_d_dot", "theta_d_ddot")))
    agree(robot.mass_matrix(q), expected["M"], tol)
    agree(robot.velocity_torque(q, qd), expected["C_theta_dot"], tol)
    agree(robot.gravity_torque(q), expected["g"], tol)
    agree(law(0.0, q, qd, reference), expected["tau"], tol)
    joints = (replace(j, friction=Friction(0.7)) if j.moves else j for j in robot.mechanism.joints)
    rubbing = Plant(mf.Robot(replace(robot.mechanism, joints=tuple(joints))))
    rest = np.array(expected["tau"]) - expected["C_theta_dot"] - expected["g"] - 0.7 * qd
    agree(rubbing.acceleration(q, qd, np.array(expected["tau"])), np.linalg.solve(expected["M"], rest), tol)
    still = gravity_compensation(robot, given["Kp"], given["Kd"])
    set_point = Motion(reference.u, np.zeros(2), np.zeros(2))
    agree(still(0.0, q, qd, set_point), expected["tau_PD_plus_gravity_setpoint"], tol)


@pytest.mark.capability("10-57", "10-54", "10-58")
def test_task_computed_torque():
    case = CASES["planar2R_task_computed_torque"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    robot, q, qd = arm(given["robot"])
    T = robot.forward_kinematics(q)
    now = task_dynamics(robot, q, qd, XY)
    agree(T[:2, 3], expected["x"], tol)
    agree(now.V, expected["V"], tol)
    agree(now.J, expected["J"], tol)
    agree(now.inertia, expected["Lambda"], tol)
    agree(now.velocity_force, expected["gamma"], tol)
    agree(now.gravity_force, expected["eta"], tol)
    reference = target(T, given["X_e"], given["V_d"], given["V_d_dot"])
    w = np.sqrt(given["Kp"])
    law = task_computed_torque(
        robot, reference, coordinates=XY, natural_frequency=w, damping_ratio=given["Kd"] / (2 * w), integral=given["Ki"]
    )
    tau = law(0.0, q, qd, Motion(q, qd, qd))
    agree(tau, expected["tau"], tol)
    qdd = robot.forward_dynamics(q, qd, tau)
    agree(now.J @ qdd + now.J_rate @ qd, expected["resulting_V_dot"], tol)
    agree(np.linalg.solve(now.J, given["V_d_dot"] - now.J_rate @ qd), expected["theta_ddot_for_V_d_dot"], tol)


def set_point(given, robot, plant, step):
    """A run of PD with gravity compensation, its law, and the goal."""
    law = gravity_compensation(robot, given["Kp"], given["Kd"])
    goal = np.array(given["theta_d"])
    scenario = mf.Scenario(
        robot=robot,
        plant=plant,
        trajectory=rest(goal, np.max(given["t"]) if "t" in given else 1.0),
        law=law,
        q=given["robot"]["theta"],
        qd=given["robot"]["theta_dot"],
        step=step,
        integrator="rk4",
        saturate=False,
    )
    return law, goal, mf.simulate(scenario)


def without_sampling(given, robot, plant, times):
    """Positions and rates at some times (k, n) each, in the limit of a law that is called continuously."""
    found = []
    for step in (4e-4, 2e-4, 1e-4):
        _, _, run = set_point(given, robot, plant, step)
        rows = np.searchsorted(run.t, np.asarray(times) - 1e-9)
        found.append(np.stack([run.q[rows], run.qd[rows]]))
    return continuous(found)


@pytest.mark.capability("10-53")
def test_energy_of_a_set_point_falls():
    case = CASES["pd_gravity_lyapunov"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    robot, *_ = arm(given["robot"])
    law, goal, run = set_point(given, robot, None, 1e-3)
    proof = energy_certificate(robot, law, goal, run.t, run.q, run.qd)
    assert bool(proof) is expected["V_never_increases"]
    times = np.array([0.0, 0.5, 1.0])
    q, qd = without_sampling(given, robot, None, times)
    exact = energy_certificate(robot, law, goal, times, q, qd)
    agree(exact.energy[[0, 2]], [expected["V0"], expected["V_at_1s"]], tol)
    agree([*q[1], *qd[1]], expected["state_at_0_5s"], tol)
    agree(exact.power[1], expected["Vdot_at_0_5s"], tol)


@pytest.mark.capability("10-53")
def test_energy_is_dissipated_by_damping_and_friction():
    case = CASES["pd_gravity_lyapunov_energy_balance"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    robot, *_ = arm(given["robot"])
    viscous = given["robot"]["viscous"]
    joints = list(robot.mechanism.joints)
    for k, b in enumerate(viscous):
        joints[k] = replace(joints[k], friction=Friction(viscous=b))
    plant = Plant(mf.Robot(replace(robot.mechanism, joints=tuple(joints))))
    law, goal, run = set_point(given, robot, plant, 1e-4)
    proof = energy_certificate(robot, law, goal, run.t, run.q, run.qd, viscous=viscous)
    assert proof
    assert np.abs(proof.balance).max() < 3e-4 * proof.energy[0], "but for the law's being held over 0.1 ms"
    times = np.array([0.0, *given["t"]])
    q, qd = without_sampling(given, robot, plant, times)
    exact = energy_certificate(robot, law, goal, times, q, qd, viscous=viscous)
    agree(exact.energy[0], expected["V0"], tol)
    agree(exact.power[0], expected["V_dot_0"], tol)
    agree(exact.energy[1:], expected["V"], tol)
    agree(exact.energy[0] - exact.energy[1:], expected["dissipated"], tol)
    agree(q[1:], expected["theta"], tol)
    agree(qd[1:], expected["theta_dot"], tol)


@pytest.mark.capability("10-64", "10-65")
def test_force_error_under_a_constant_disturbance():
    case = CASES["force_pi"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    assert given["quasi_static"]
    assert given["F_e"] == "F_d - F_app"
    kp, ki, w = given["Kfp"], given["Kfi"], given["constant_wrench_disturbance"]
    agree(force_error(kp, ki, w, 0.0), expected["F_e_at_0"], tol)
    agree(force_error(kp, ki, w, 0.15), expected["F_e_at_0_15"], tol)
    agree(force_error(kp, ki, w, 1e3), expected["F_e_inf"], tol)
    ratio = force_error(kp, ki, w, expected["time_constant"]) / force_error(kp, ki, w, 0.0)
    agree(ratio, np.exp(-1.0), tol)


@pytest.mark.capability("10-65")
def test_sampled_force_loop():
    case = CASES["force_pi_sampled_one_step_delay"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    assert given["characteristic"] == "z^2+(Kfp+Kfi dt-1) z-Kfp"
    assert "F_app[k+1]" in given["model"]
    for one in expected["cases"]:
        radius = sampled_force_radius(one["Kfp"], one["Kfi_dt"])
        agree(radius, one["spectral_radius"], tol)
        assert bool(radius < 1.0) is one["stable"]
    assert expected["condition"] == "Kfp<1 and 0<Kfi dt<2(1-Kfp)"
    kp, step = np.random.default_rng(0).uniform([[0.0], [0.0]], [[1.5], [3.0]], (2, 2000))
    np.testing.assert_array_equal(sampled_force_radius(kp, step) < 1.0, (kp < 1.0) & (step < 2.0 * (1.0 - kp)))


@pytest.mark.capability("10-66")
def test_runaway_without_contact():
    case = CASES["force_law_free_space_runaway"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    assert given["v0"] == 0
    for ki, name in zip(given["Kfi"], ("speed_Kfi_10", "speed_Kfi_0"), strict=True):
        speed = free_speed(given["F_d"], given["Kfp"], ki, given["K_damp"], given["mass"], given["t"])
        agree(speed, expected[name], tol)
    assert "Kfi F_d t" in expected["late_speed_Kfi_10"]


@pytest.mark.capability("10-67", "10-4")
def test_selection_in_a_damper():
    case = CASES["damper_env"]
    given, expected = case["input"] if "input" in case.content else case, case["expected"]
    B = np.array(given["B_env"], dtype=float)
    chosen = selection(B, [[1, 0], [0, 0]], [[0, 0], [1, 0]], [given["F1"], given["V1"]])
    assert bool(chosen) is expected["specifiable"]["F1,V1"]
    agree(chosen.V[1], expected["V2"], 1e-12)
    agree(chosen.F[1], expected["F2"], 1e-12)
    conflict = selection(B, [[1, 0], [0, 0]], [[0, 0], [2, 1]])
    assert bool(conflict) is expected["specifiable"]["F1,2*V1+V2"]
    assert conflict.conflict[0] == pytest.approx(-conflict.conflict[1])
    assert conflict.explain("en") != conflict.explain("ar")
    diagonal = selection(np.diag(np.diag(B)), [[1, 0], [0, 0]], [[0, 0], [1, 0]])
    assert bool(diagonal) is expected["with_diagonal_B_env"]["F1,V1"]


@pytest.mark.capability("10-72", "10-73", "10-74")
def test_hybrid_control_at_a_wall():
    case = CASES["hybrid_planar2R_wall"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    robot, q, _ = arm(given["robot"])
    V = np.array(given["V"], dtype=float)
    qd = np.linalg.solve(XY.jacobian(robot, q), V)
    agree(qd, expected["theta_dot"], tol)
    T = robot.forward_kinematics(q)
    F_d, F_e = np.array(given["F_d"], dtype=float), np.array(given["F_e"], dtype=float)
    law = hybrid_control(
        robot,
        target(T, given["X_e"], V + given["V_e"], given["V_d_dot"]),
        given["A"],
        F_d,
        coordinates=XY,
        gains=Gains.of(2, given["Kp"], given["Kd"], given["Ki"]),
        sensor=lambda q, qd: F_d - F_e,
        force_kp=given["Kfp"],
        force_ki=given["Kfi"],
    )
    tau = law.errors(0.0, q, qd).effort(np.zeros(2), given["Kfi"] * np.array(given["int_F_e"]))
    agree(tau, expected["tau"], tol)
    now = task_dynamics(robot, q, qd, XY)
    agree(now.velocity_force, expected["gamma"], tol)
    agree(now.gravity_force, expected["eta"], tol)
    rest_force = now.velocity_force + now.gravity_force
    held = constrained_dynamics(now.inertia, rest_force, given["A"], np.linalg.solve(now.J.T, tau), V)
    agree(held.P, expected["P"], tol)
    assert np.linalg.matrix_rank(held.P) == expected["rank_P"]
    agree(held.multipliers[0], expected["lambda"], tol)
    agree(held.acceleration, expected["V_dot"], tol)


@pytest.mark.capability("10-72", "10-74")
def test_a_curved_constraint_takes_a_force_for_itself():
    case = CASES["hybrid_curved_constraint"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    assert given["constraint"] == "unit circle, A=x^T"
    assert given["V"] == "1.5*[-sin .3, cos .3]"
    c, s = np.cos(given["angle"]), np.sin(given["angle"])
    V, A = 1.5 * np.array([-s, c]), np.array([[c, s]])
    h = np.add(given["gamma"], given["eta"])
    held = constrained_dynamics(given["Lambda"], h, A, given["F"], V, V[None])
    agree(held.multipliers[0], expected["lambda"], tol)
    weight = float((A @ np.linalg.solve(given["Lambda"], A.T))[0, 0])
    wrong = float((A @ np.linalg.solve(given["Lambda"], np.subtract(given["F"], h)))[0]) / weight - V @ V / weight
    agree(wrong, expected["printed_plus_sign_form_gives"], tol)
    agree(A[0] @ held.curvature_force, expected["residual_force_without_Adot_compensation"], tol)
    agree(A @ held.acceleration + V @ V, 0.0, 1e-12)


@pytest.mark.capability("10-76", "10-82")
def test_impedance_and_admittance():
    case = CASES["impedance_admittance"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    one = Impedance.of(1, inertia=given["m"], damping=given["b"], stiffness=given["k"])
    Z = one.frequency_response(given["omega"])[:, 0, 0]
    agree(np.stack([Z.real, Z.imag], axis=1), expected["Z"], tol)
    agree(np.abs(Z), expected["abs_Z"], tol)
    Y = 1.0 / Z[given["omega"].index(10)]
    agree([Y.real, Y.imag], expected["Y_at_10"], tol)
    agree(one.natural_frequency, [expected["omega_n"]], tol)
    agree(one.damping_ratio, [expected["zeta"]], tol)
    a = given["admittance"]
    other = Impedance.of(1, inertia=a["D"], damping=a["B"], stiffness=a["K"])
    V_dot = other.acceleration(np.array([a["X"]]), np.array([a["V"]]), np.array([a["F_ext"]], dtype=float))
    agree(V_dot[0], expected["V_d_dot"], tol)


@pytest.mark.capability("10-78", "10-81", "10-96")
def test_impedance_control_of_an_arm():
    case = CASES["impedance_planar2R"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    robot, q, qd = arm(given["robot"])
    reference = target(robot.forward_kinematics(q), -np.array(given["X_minus_X_ref"]))
    wanted = Impedance.of(2, inertia=given["D"], damping=given["B"], stiffness=given["K"])
    F = np.array(given["F_ext"], dtype=float)
    law = impedance_control(robot, wanted, reference, coordinates=XY, sensor=lambda q, qd: F)
    tau = law(0.0, q, qd, Motion(q, qd, qd))
    agree(tau, expected["tau_full"], tol)
    now = task_dynamics(robot, q, qd, XY)
    wrench = np.array([0.0, 0.0, 0.0, *(robot.forward_kinematics(q)[:2, :2].T @ F), 0.0])
    qdd = robot.forward_dynamics(q, qd, tau, -wrench)
    agree(now.J @ qdd + now.J_rate @ qd, expected["V_dot"], tol)
    simple = impedance_control(robot, wanted, reference, coordinates=XY)
    agree(simple(0.0, q, qd, Motion(q, qd, qd)), expected["tau_simplified_no_inertia"], tol)
    # The second form: what an accelerometer reads is the acceleration that follows, and then no force is lacking.
    V_dot = np.array(expected["V_dot"])
    by_force = impedance_by_force(
        robot, wanted, reference, lambda q, qd: F, coordinates=XY, kp=3.0, ki=5.0, acceleration=lambda q, qd: V_dot
    )
    agree(by_force.session(0.01)(0.0, q, qd, Motion(q, qd, qd)), expected["tau_full"], tol)


@pytest.mark.capability("10-79", "10-81")
def test_an_impedance_meets_a_wall():
    """Free arc and arc in contact in closed form, by the roots of both impedances."""
    case = CASES["impedance_robot_meets_wall"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    assert given["wall"].startswith("force -4000 x")
    D, B, K, place = given["D"], given["B"], given["K"], given["X_ref"]
    free, touching = (
        Impedance.of(1, inertia=D, damping=B, stiffness=K),
        Impedance.of(1, inertia=D, damping=B, stiffness=K + 4000.0),
    )

    def arc(impedance, middle, x0, v0):
        roots = impedance.roots
        c = np.linalg.solve(np.array([[1.0, 1.0], roots]), [x0 - middle, v0])
        return lambda t: (middle + (c * np.exp(roots * t)).sum().real, (c * roots * np.exp(roots * t)).sum().real)

    def first(function, low, high):
        for _ in range(200):
            half = (low + high) / 2
            low, high = (half, high) if function(half) < 0.0 else (low, half)
        return high

    before = arc(free, place, given["x0"], given["v0"])
    t = first(lambda t: before(t)[0], 0.0, 0.5)
    agree(t, expected["contact_time"], tol)
    agree(before(t)[1], expected["contact_speed"], tol)
    middle = K * place / (K + 4000.0)
    within = arc(touching, middle, 0.0, before(t)[1])
    peak = first(lambda t: -within(t)[1], 0.0, 0.05)
    agree(peak, expected["time_of_peak_force_after_contact"], tol)
    agree(4000.0 * within(peak)[0], expected["peak_force"], tol)
    release = first(lambda t: -within(t)[0], peak, 0.1)
    agree(release, expected["release_after_contact"], tol)
    assert bool(within(release)[1] < 0.0) is expected["first_contact_is_lost"]
    agree(middle, expected["rest_x"], tol)
    agree(4000.0 * middle, expected["rest_force"], tol)


@pytest.mark.capability("10-82", "10-84", "10-97")
def test_limits_of_admittance():
    case = CASES["admittance_stability_limits"]
    given, expected, tol = case["input"], case["expected"], case.content["tol"]
    dt, K, B = given["dt"], given["total_stiffness_against_the_tip"], given["B"]
    assert given["step_semi_implicit"].startswith("V+=")
    assert given["step_explicit"].startswith("X+=")
    least = least_virtual_mass(B, K, dt)
    agree(least, expected["smallest_virtual_mass_semi_implicit"], tol)
    assert expected["formula"] == "B dt/2 + K dt^2/4"
    assert admittance_radius(least * 1.001, B, K, dt) < 1.0 < admittance_radius(least * 0.999, B, K, dt)
    agree(K * dt, expected["explicit_needs_B_above"], tol)
    assert (admittance_radius(2.0, 8.0, K, dt, explicit=True) < 1.0) is expected["explicit_stable_with_B_8_for_D_2"]
    assert (admittance_radius(1.0, 3.0, K, dt, explicit=True) < 1.0) is expected["explicit_stable_with_B_3_for_D_1"]
    fed = given["fed_to_10_31"]
    felt = effective_admittance(fed["D"], fed["B"], fed["K"], kp=fed["Kp"], kd=fed["Kd"], period=fed["dt"])
    agree(felt.inertia, expected["effective_D"], tol)
    agree(felt.damping, expected["effective_B"], tol)
    robot = mf.load("planar2r")
    still = target(np.eye(4))
    wanted = Impedance.of(2, inertia=fed["D"], damping=fed["B"], stiffness=fed["K"])
    law = admittance_control(
        robot,
        wanted,
        still,
        lambda q, qd: np.zeros(2),
        coordinates=XY,
        gains=Gains.of(2, fed["Kp"], fed["Kd"]),
        own_state=False,
    ).session(fed["dt"])
    V = np.array([fed["V"], 0.0])
    push = wanted.acceleration(np.array([fed["X"], 0.0]), V, np.array([float(fed["F_ext"]), 0.0]))
    agree(law.commanded_acceleration(V, push)[0], expected["commanded_acceleration"], tol)


@pytest.mark.capability("10-71")
def test_natural_and_artificial_constraints_of_an_eraser():
    blocked = (True, True, False, False, False, True)
    table = constraint_table(blocked, (0.0, 0.0, 0.0, 0.1, 0.0, -5.0), ("phi_x", "phi_y", "phi_z", "x", "y", "z"))
    assert [line.natural for line in table] == [
        "dphi_x/dt = 0",
        "dphi_y/dt = 0",
        "F_phi_z = 0",
        "F_x = 0",
        "F_y = 0",
        "dz/dt = 0",
    ]
    assert [line.artificial for line in table] == [
        "F_phi_x = 0", "F_phi_y = 0", "dphi_z/dt = 0", "dx/dt = 0.1", "dy/dt = 0", "F_z = -5"
    ]  # fmt: skip


def test_all_keys_are_read():
    assert set(CASES) == set(MINE)
    tests = {name: function for name, function in globals().items() if name != "test_all_keys_are_read"}
    assert [place for place in unread_after(tests, CASES) if not place.endswith(".computed")] == []
