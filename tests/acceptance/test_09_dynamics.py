"""Worked examples of dynamics: particle, planar 2R, published spatial 3R, RRPRRR, rigid bodies, motions over time."""

from functools import cache

import numpy as np
import pytest

import mafsil as mf
import mafsil.expression as ex
from mafsil.errors import ModelError
from mafsil.geometry import twist, wrench
from mafsil.mechanics.quantities.energy import christoffel_of, euler_lagrange, mass_matrix_of
from mafsil.mechanics.stacked_form import newton_euler
from mafsil.mechanics.twist_chain import TwistChain, spatial_matrix
from mafsil.model import Friction, Inertial
from mafsil.model.library.textbook import planar2r_point_masses
from mafsil.robot import Robot
from tests.acceptance.reading import cases, unread_after

ELSEWHERE = ("9-06", "9-10", "9-12", "9-18")
"""Cases of the arm and body that 09-definitions.json defines, in test_09_more."""
CASES = {name: case for name, case in cases("09-dynamics.json").items() if name not in ELSEWHERE}


def close(value, expected, rtol=1e-9, atol=1e-9):
    np.testing.assert_allclose(value, expected, rtol=rtol, atol=atol)


def state(case):
    return [np.array(case["input"][name], float) for name in ("theta", "dtheta", "ddtheta")]


@cache
def planar_arm():
    numbers = CASES["9-02"]["input"]
    mechanism = planar2r_point_masses(numbers["L"], numbers["m"])
    return Robot(mechanism.with_gravity(np.array(numbers["g_vec"], float)))


@pytest.mark.capability("09-11", "09-12", "09-13", "09-14")
def test_particle_by_typed_energies():
    numbers = CASES["9-01"]["input"]
    found = mf.derivation.derive_lagrange("m*dx**2/2", "m*g*x", {"x": "m"}, newton={"x": "m*ddx + m*g"})
    values = {"m": numbers["m"], "g": numbers["g"], "x": 0.7, "dx": -0.3, "ddx": numbers["xdd"]}
    by_lagrange, by_newton = (line.sides[0] for line in found.lines if line.left[0].letter == "f")
    close(by_lagrange.evaluate(values), CASES["9-01"]["expect"]["f"])
    close(by_newton.evaluate(values), CASES["9-01"]["expect"]["f"])


@pytest.mark.capability("09-12", "09-13")
def test_particle_by_expressions():
    numbers, (x, xd, xdd) = CASES["9-01"]["input"], (ex.symbol(name) for name in ("x", "xd", "xdd"))
    m, g = numbers["m"], numbers["g"]
    f = euler_lagrange(m * xd**2 / 2 - m * g * x, x, xd, xdd)
    force = ex.Function("f", [x, xd, xdd], [f])(0.7, -0.3, numbers["xdd"])
    close(float(force), CASES["9-01"]["expect"]["f"])
    assert float(ex.Function("rest", [x, xd, xdd], [f])(0.7, -0.3, -g)) == pytest.approx(0, abs=1e-12)


@pytest.mark.capability("09-9", "09-15", "09-16", "09-19", "09-20", "09-21", "09-59")
def test_planar_2r():
    planar = planar_arm()
    case, (q, qd, qdd) = CASES["9-02"], state(CASES["9-02"])
    expect = case["expect"]
    for method in (planar.inverse_dynamics, planar.lagrange_torque):
        close(method(q, qd, qdd), expect["tau"])
        assert np.abs(method(q, qd, qdd) - expect["printed_book_tau_is_wrong"]).max() > 0.1
    M = planar.mass_matrix(q)
    close(M, expect["M"])
    close(np.linalg.det(M), expect["detM"])
    close(planar.velocity_torque(q, qd), expect["c"])
    close(planar.gravity_torque(q), expect["grav"])
    Gamma = np.zeros((2, 2, 2))
    for index, value in expect["Gamma"].items():
        if index != "others":
            Gamma[tuple(int(digit) - 1 for digit in index)] = value
    close(planar.christoffel_symbols(q), Gamma)


@pytest.mark.capability("09-12", "09-13", "09-15", "09-20")
def test_planar_2r_from_positions():
    """Nothing of ours but the differentiation: energies of two points written down by hand."""
    case = CASES["9-02"]
    (m1, m2), (L1, L2) = case["input"]["m"], case["input"]["L"]
    q, qd, qdd = (ex.symbol(name, 2) for name in ("q", "qd", "qdd"))
    one = L1 * ex.vertcat(ex.cos(q[0]), ex.sin(q[0]))
    two = one + L2 * ex.vertcat(ex.cos(q[0] + q[1]), ex.sin(q[0] + q[1]))
    v1, v2 = ex.jtimes(one, q, qd), ex.jtimes(two, q, qd)
    K = m1 * ex.dot(v1, v1) / 2 + m2 * ex.dot(v2, v2) / 2
    P = 9.81 * (m1 * one[1] + m2 * two[1])
    M = mass_matrix_of(K, qd)
    f = ex.Function("f", [q, qd, qdd], [euler_lagrange(K - P, q, qd, qdd), M, *christoffel_of(M, q)])
    tau, mass, *Gamma = (x.full() for x in f.call(state(case)))
    close(tau.ravel(), case["expect"]["tau"])
    close(mass, case["expect"]["M"])
    close(Gamma[0][0, 1], case["expect"]["Gamma"]["112"])
    close(Gamma[1][0, 0], case["expect"]["Gamma"]["211"])


@pytest.mark.capability("09-15", "09-45")
def test_planar_2r_stretched():
    planar = planar_arm()
    given = CASES["9-03"]["input"]
    for name in ("m", "L", "g_vec"):
        assert given[name] == CASES["9-02"]["input"][name]
    close(planar.inverse_dynamics(*state(CASES["9-03"])), CASES["9-03"]["expect"]["tau"])


@pytest.mark.capability("09-35", "09-36")
def test_lie_bracket_and_dual():
    numbers, expect = CASES["9-07"]["input"], CASES["9-07"]["expect"]
    close(twist.bracket(numbers["V1"], numbers["V2"]), expect["bracket"])
    close(wrench.dual_bracket(numbers["V1"], numbers["F"]), expect["adV1T_F"])
    close(twist.bracket(numbers["V1"], numbers["V1"]), np.zeros(6))
    close(twist.bracket(numbers["V2"], numbers["V1"]), -np.array(expect["bracket"]))


def spatial_3r():
    """The published chain: screws as given, the first not of unit length."""
    numbers = CASES["9-08"]["input"]
    relative, S = np.array(numbers["M_rel"]), np.array(numbers["S"])
    home = [np.eye(4)]
    for T in relative:
        home.append(home[-1] @ T)
    G = np.array([np.diag(row) for row in numbers["G_diag"]])
    A = [twist.transform(np.linalg.inv(home[i + 1]), S[i]) for i in range(3)]
    gravity = np.array(numbers["g_vec"])
    return (
        S,
        home,
        G,
        TwistChain((-1, 0, 1), np.array(A), relative[:3], G, np.zeros(3), np.eye(3), 2, relative[3], gravity),
    )


@pytest.mark.capability("09-39", "09-41", "09-47", "09-48", "09-55", "09-63", "09-64")
def test_published_spatial_3r_in_twists():
    expect, chain = CASES["9-08"]["expect"], spatial_3r()[-1]
    symbols = [ex.symbol(name, size) for name, size in (("q", 3), ("qd", 3), ("qdd", 3), ("F", 6))]
    tau = ex.Function("tau", symbols, [newton_euler(chain, *symbols).tau])
    q, qd, qdd = state(CASES["9-08"])
    F, zero = np.array(CASES["9-08"]["input"]["Ftip"]), np.zeros(3)

    def efforts(*values):
        return tau(*values).full().ravel()

    g = efforts(q, zero, zero, np.zeros(6))
    close(efforts(q, qd, qdd, F), expect["tau_id"])
    close(g, expect["grav"])
    close(efforts(q, qd, zero, np.zeros(6)) - g, expect["c"])
    close(efforts(q, zero, zero, F) - g, expect["tip_torque"])
    M = np.stack([efforts(q, zero, e, np.zeros(6)) - g for e in np.eye(3)], axis=1)
    close(M, expect["M"])
    load = np.array(CASES["9-08"]["input"]["tau_fd"]) - efforts(q, qd, zero, F)
    close(np.linalg.solve(M, load), expect["ddtheta_fd"])


@pytest.mark.capability("09-2", "09-4", "09-48", "09-63")
def test_published_spatial_3r_as_a_robot():
    """Screws scaled to unit length: the first coordinate counts sqrt 2 times as much, its effort as much less."""
    S, home, G, _ = spatial_3r()
    case, expect = CASES["9-08"], CASES["9-08"]["expect"]
    robot = Robot.from_screws(
        S,
        home[-1],
        normalise=True,
        inertials=[Inertial(g[3, 3], np.zeros(3), g[:3, :3]) for g in G],
        inertial_frames=home[1:4],
        gravity=case["input"]["g_vec"],
    )
    scale = np.linalg.norm(S[:, :3], axis=1)
    q, qd, qdd = (scale * x for x in state(case))
    F = case["input"]["Ftip"]
    close(scale * robot.inverse_dynamics(q, qd, qdd, F), expect["tau_id"])
    close(scale[:, None] * robot.mass_matrix(q) * scale, expect["M"])
    close(scale * robot.velocity_torque(q, qd), expect["c"])
    close(scale * robot.gravity_torque(q), expect["grav"])
    close(scale * (robot.jacobian_body(q).T @ F), expect["tip_torque"])
    assert case["input"]["note_frames"] == "M_rel = M01, M12, M23, M34 (4 = tool frame n+1)"
    close(robot.forward_dynamics(q, qd, case["input"]["tau_fd"] / scale, F) / scale, expect["ddtheta_fd"])


@pytest.mark.capability("09-17", "09-38", "09-48", "09-55", "09-62")
def test_rrprrr():
    case = CASES["9-11"]
    numbers, expect = case["input"]["robot"], case["expect"]
    assert numbers["com_rotations"] == "identity"
    frames = [np.eye(4) for _ in range(6)]
    for frame, place in zip(frames, numbers["com_positions"], strict=True):
        frame[:3, 3] = place
    home = np.eye(4)
    home[:3, 3] = numbers["M_tip_position"]
    robot = Robot.from_screws(
        numbers["S"],
        home,
        inertials=[
            Inertial(m, np.zeros(3), np.diag(I)) for m, I in zip(numbers["masses"], numbers["I_diag"], strict=True)
        ],
        inertial_frames=frames,
        gravity=case["input"]["g_vec"],
    )
    q, qd, qdd = state(case)
    close(robot.inverse_dynamics(q, qd, qdd, case["input"]["Ftip"]), expect["tau"])
    close(robot.mass_matrix(q), expect["M"])
    close(robot.velocity_torque(q, qd), expect["c"])
    close(robot.gravity_torque(q), expect["grav"])
    close(robot.forward_dynamics(q, qd, np.zeros(6), case["input"]["Ftip"]), expect["ddtheta_fd_tau_zero"])
    close(robot.lagrange_torque(q, qd, qdd), robot.inverse_dynamics(q, qd, qdd), atol=1e-12)


@pytest.mark.capability("09-3", "09-60", "09-61", "09-65")
def test_one_joint_with_friction_by_explicit_euler():
    numbers, expect = CASES["9-14"]["input"], CASES["9-14"]["expect"]
    M, m, r, g = (numbers[name] for name in ("M", "m", "r", "g"))
    robot = Robot.from_screws(
        [[0, 0, 1, 0, 0, 0]],
        np.eye(4),
        inertials=[Inertial(m, np.array([r, 0, 0]), np.diag([0, 0, M - m * r * r]))],
        frictions=[Friction(viscous=numbers["b"])],
        gravity=[0, -g, 0],
    )

    start, rate, tau = [numbers["theta0"]], [numbers["dtheta0"]], [numbers["tau"]]
    end, h = numbers["N"] * numbers["h"], numbers["h"]
    euler = mf.simulation.forward_dynamics_trajectory(robot, start, rate, tau, duration=end, method="euler", step=h)
    close(euler.q[-1, 0], expect["theta_end"])
    close(euler.qd[-1, 0], expect["dtheta_end"])
    assert len(euler.t) == numbers["N"] + 1
    fine = mf.simulation.forward_dynamics_trajectory(robot, start, rate, tau, duration=end, tolerance=1e-12)
    close([fine.q[-1, 0], fine.qd[-1, 0]], [expect["reference_theta"], expect["reference_dtheta"]])
    without = mf.simulation.forward_dynamics_trajectory(robot, start, rate, tau, duration=end, friction=False)
    assert abs(without.q[-1, 0] - expect["reference_theta"]) > 0.01


@pytest.mark.capability("09-7", "09-65", "09-66")
def test_planar_2r_in_free_fall():
    planar = planar_arm()
    numbers, expect = CASES["9-15"]["input"], CASES["9-15"]["expect"]
    assert numbers["robot"] == "9-02"
    given = {"q": numbers["theta0"], "qd": numbers["dtheta0"], "tau": numbers["tau"], "duration": numbers["t_end"]}

    def by_euler(h):
        return mf.simulation.forward_dynamics_trajectory(planar, **given, method="euler", step=h)

    def end(motion):
        return np.concatenate([motion.q[-1], motion.qd[-1]])

    coarse, fine = by_euler(0.01), by_euler(0.005)
    close(end(coarse), expect["euler_h_0_01"])
    close(end(fine), expect["euler_h_0_005"])
    close(coarse.energy[0], expect["energy0"])
    close(coarse.energy[-1], expect["energy_euler_h_0_01"])
    exact = mf.simulation.forward_dynamics_trajectory(planar, **given, tolerance=1e-12)
    close(end(exact), expect["reference_state"])
    errors = [np.linalg.norm(end(m) - end(exact)) for m in (coarse, fine, by_euler(0.00125), by_euler(0.000625))]
    assert abs(errors[0] / errors[1] - expect["error_ratio_about"]) < 0.25
    assert abs(errors[2] / errors[3] - 2.0) < 0.05, "first order"


@pytest.mark.capability("09-8", "09-22")
def test_a_robot_as_a_system_of_efforts_and_motion():
    planar = planar_arm()
    """Efforts assembled from M, c and g, as a controller does, make errors die as those of unit masses."""
    wanted, omega = np.array([0.4, -0.9]), 8.0

    def tau(t, q, qd):
        a = omega**2 * (wanted - q) - 2 * omega * qd
        return planar.mass_matrix(q) @ a + planar.velocity_torque(q, qd) + planar.gravity_torque(q)

    start = np.array([0.1, 0.3])
    motion = mf.simulation.forward_dynamics_trajectory(planar, start, tau=tau, duration=1.0, tolerance=1e-11)
    t = np.array([0.2, 0.7, 1.0])
    error = (1 + omega * t) * np.exp(-omega * t)
    close(motion.at(t)[0], wanted + error[:, None] * (start - wanted), atol=1e-8)


@pytest.mark.capability("09-71")
def test_task_space_terms_of_a_pose():
    """Lambda and eta belong to a pose and a twist once a branch of the inverse kinematics is chosen: V = J qd."""
    robot = mf.load("ur5e")
    X, V = robot.forward_kinematics([0.3, -1.1, 1.4, -0.6, 0.9, 0.2]), np.array([0.2, -0.1, 0.3, 0.05, 0.1, -0.2])
    branches = mf.inverse_kinematics(robot, X).q
    assert len(branches) > 1
    rates = np.linalg.solve(robot.jacobian_body(branches), V)
    task = robot.task_space(branches, rates)
    dV = np.array([0.1, 0.2, -0.3, 0.4, -0.5, 0.6])
    for q, qd, F in zip(branches, rates, task.force(np.broadcast_to(dV, (len(branches), 6))), strict=True):
        J, drift = robot.jacobian_body(q), robot.jacobian_body_rate(q, qd) @ qd
        tau = robot.inverse_dynamics(q, qd, np.linalg.solve(J, dV - drift))
        close(J.T @ F, tau, atol=1e-9)


@pytest.mark.capability("09-30", "09-31")
def test_free_body_about_its_intermediate_axis():
    numbers, expect = CASES["9-16"]["input"], CASES["9-16"]["expect"]
    body = mf.simulation.RigidBody(Inertial(1.0, np.zeros(3), np.diag(numbers["I_diag"]).astype(float)))
    start = np.concatenate([numbers["omega0"], np.zeros(3)])
    moved = mf.simulation.free_body_motion(body, np.eye(4), start, duration=numbers["t_end"], tolerance=1e-13)
    V = moved.V[-1]
    close(V[:3], expect["omega_end"])
    close(body.kinetic_energy(V), expect["K"])
    close(np.linalg.norm(body.momentum(V)), expect["h_norm"])


@pytest.mark.capability("09-5")
def test_degenerate_mass_matrix():
    case = CASES["9-19"]
    robot = Robot(planar2r_point_masses(case["input"]["L"], case["input"]["m"]))
    q = case["input"]["theta"]
    M = robot.mass_matrix(q)
    close(M, case["expect"]["M"])
    close(np.linalg.det(M), case["expect"]["detM"])
    with pytest.raises(ModelError, match=r"joint1.*moves no inertia"):
        robot.forward_dynamics(q, [0, 0], [1, 0])
    assert case["expect"]["must"] == "report a singular mass matrix, not return accelerations"
    assert np.isnan(robot.forward_dynamics([q], [0, 0], [1, 0])).all(), "no accelerations in batches"
    report = robot.mass_matrix_singularity(q)
    assert report.singular
    assert report.joints == robot.joint_names
    assert np.abs(M @ report.motion).max() < 1e-12
    with pytest.raises(ModelError, match="moves no inertia") as caught:
        report.require_regular()
    assert all(name in str(caught.value) for name in robot.joint_names)
    assert not robot.mass_matrix_singularity([0.4, 0.3]).singular


@pytest.mark.capability("09-47", "09-64")
def test_sign_of_an_external_wrench():
    planar = planar_arm()
    case = CASES["9-20"]
    robot = Robot(planar.mechanism.with_gravity(np.zeros(3)))
    given = case["input"]
    assert (given["robot"], given["gravity"], given["theta"]) == ("9-02", 0, [0, "pi/2"])
    q, qd, tau = np.array([0, np.pi / 2]), np.array(given["dtheta"], float), np.array(given["tau"], float)
    R = robot.forward_kinematics(q)[:3, :3]
    force_on_tip = R.T @ case["input"]["force_ON_tip_in_space_axes"]
    exerted = -np.concatenate([np.zeros(3), force_on_tip])
    qdd = robot.forward_dynamics(q, qd, tau, exerted)
    close(qdd, case["expect"]["ddtheta"])
    close(R @ (robot.jacobian_body(q) @ qdd)[3:], case["expect"]["tip_acceleration_space"])


def test_spatial_matrix_is_that_of_a_rigid_body():
    body = Inertial(2.0, np.array([0.1, -0.2, 0.3]), np.diag([0.1, 0.2, 0.25]))
    c = body.com
    about_origin = body.inertia + body.mass * (c @ c * np.eye(3) - np.outer(c, c))
    close(spatial_matrix(body.mass, body.mass * c, about_origin), mf.simulation.RigidBody(body).spatial_inertia)


def test_every_key_of_every_case_is_read(request):
    del request  # an argument, so that the guard does not call itself
    assert unread_after(globals(), CASES) == []
