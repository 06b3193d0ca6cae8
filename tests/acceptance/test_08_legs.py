"""Worked numbers of part 08 (parallel robots): legs of any joints, Delta, Eclipse, through the public face."""

import numpy as np
import pytest

from mafsil import mobility as mo
from mafsil import parallel as pa
from mafsil.geometry import pose, rotation, screw
from mafsil.mobility.gruebler import StructureStatus
from tests.acceptance import test_08_closed_chains, test_08_planar, test_08_planar_chains
from tests.acceptance.reading import unread_after
from tests.acceptance.test_08_closed_chains import CASES, near, pose_of, stewart

OWN = {
    name: CASES[name]
    for name in (
        "ch08-01-mobility",
        "ch08-09-general-3xRPS",
        "ch08-10-delta-3xRUU",
        "ch08-11-6xUPS-general-equals-statics",
        "ch08-17-eclipse",
        "ch08-18-sylvester-3xRPS",
        "ch08-109-general-5R-5R-5R",
        "ch08-111-delta-singularities",
    )
}
"""Cases of which the tests here read every key."""


@pytest.mark.capability("08-1", "08-6", "08-13", "08-30")
def test_counted_mobility():
    for case in CASES["ch08-01-mobility"]["cases"]:
        most = {"planar": 1, "spatial": 3}[case["space"]]
        freedoms = [1] * case["J"]
        for k in range(case["sum_f"] - case["J"]):
            freedoms[k % case["J"]] += 1
        assert max(freedoms) <= most
        assert mo.gruebler_count(case["N"], freedoms, case["space"]).mobility == case["dof"]
    assert pa.three_rps(1.0, 0.5, 1.2).counted_mobility == 3
    found = mo.structure(mo.library.six_ups())
    assert (found.status, found.loops) == (StructureStatus.MANY_LOOPS, 5)


@pytest.mark.capability("08-2", "08-31", "08-41", "08-42", "08-43", "08-44")
def test_general_three_rps():
    case = CASES["ch08-09-general-3xRPS"]
    robot = pa.three_rps(case["base_radius"], case["platform_radius"], case["height"])
    near(robot.jacobian(np.zeros(15)), case["Ja_home"], 1e-8)
    found = pa.leg_forward(robot, case["q_a"])
    assert found
    near(found.T, case["T"], 1e-8)
    near(found.q, case["q_full"], 1e-8)
    for leg in range(3):
        near(robot.jacobian(found.q, leg), case["Ja"], 1e-8)
    near(np.sqrt(1.25) + np.array(case["q_a"]), case["leg_lengths"], 1e-8)
    h = 1e-6
    for k in range(3):
        step = h * np.eye(3)[k]
        T = [pa.leg_forward(robot, case["q_a"] + sign * step, found.q).T for sign in (1, -1)]
        near(pose.log(T[0] @ pose.inverse(T[1])) / (2 * h), robot.jacobian(found.q)[:, k], 1e-8)


@pytest.mark.capability("08-3", "08-11", "08-35")
def test_delta():
    case = CASES["ch08-10-delta-3xRUU"]
    robot = pa.DeltaRobot(case["rb"], case["rp"], case["L"], case["l"])
    both = robot.forward_kinematics(case["q_a"]).x
    near(both, [case["p"], case["other_assembly_mode_p"]], 1e-8)
    near(robot.jacobian(case["q_a"], case["p"]), case["J_linear"], 1e-8)
    near(robot.inverse_kinematics(case["p"]).q[:, ::-1], case["ik_two_roots_per_leg"], 1e-8)
    drawn = 0.35
    legs = pa.delta_legs(robot, drawn)
    found = pa.leg_forward(legs, np.array(case["q_a"]) - drawn)
    assert found
    near(found.T[:3, 3], case["p"], 1e-8)
    assert case["rotation"] == "identity"
    near(found.T[:3, :3], np.eye(3), 1e-10)
    J = legs.jacobian(found.q)
    assert case["J_angular"] == "zero"
    near(J[:3], np.zeros((3, 3)), 1e-10)
    near(J[3:], case["J_linear"], 1e-8)


@pytest.mark.capability("08-53", "08-58", "08-60")
def test_delta_singularities():
    case = CASES["ch08-111-delta-singularities"]
    robot, expected = pa.DeltaRobot(case["rb"], case["rp"], case["L"], case["l"]), case["expected"]
    actuator = expected["actuator_singular"]
    q = np.full(3, actuator["q_equal"])
    near(np.degrees(q[0]), actuator["q_deg"], case["tol"])
    p = np.array(actuator["p"])
    near(np.linalg.norm(p - robot.elbows(q), axis=1), np.full(3, robot.forearm), 1e-8)
    found = robot.singularity(q, p)
    W, _ = robot.motor_matrices(q, p)
    assert np.linalg.matrix_rank(W, 1e-8) == actuator["rank_W"]
    assert found.status is pa.SingularKind.SECOND
    near(np.abs(found.free_motion), actuator["free_direction"], 1e-7)
    assert actuator["left_null"] == "(1,1,1)/sqrt3"
    near(np.abs(found.internal_forces), np.full(3, 3**-0.5), 1e-7)
    near(robot.forward_kinematics(q + 1e-3).x[:, 2], actuator["modes_at_q_plus_0p001_z"], case["tol"])
    assert actuator["at_q_minus_0p001"] == "no solution"
    assert not robot.forward_kinematics(q - 1e-3)
    end = expected["end_effector_singular"]
    edge = [0.0, 0.0, -np.sqrt((robot.arm + robot.forearm) ** 2 - robot.offset**2)]
    near(edge, end["p"], case["tol"])
    near(robot.inverse_kinematics(edge).q[:, 0], end["q"], 1e-6)
    near(np.degrees(end["q"]), np.full(3, end["q_deg"]), 1e-6)
    near(np.diagonal(robot.motor_matrices(end["q"], end["p"])[1]), end["B_diag"], case["tol"])
    assert robot.singularity(end["q"], end["p"]).status is pa.SingularKind.FIRST


@pytest.mark.capability("08-7", "08-8", "08-44", "08-46")
def test_six_legs_as_screws_equal_statics():
    case = CASES["ch08-11-6xUPS-general-equals-statics"]
    robot, T = stewart(), pose_of(CASES["ch08-05-stewart-ik-jacobian-statics"])
    legs = pa.stewart_legs(robot, T)
    zero = np.zeros(legs.n)
    assert legs.loop_matrix(zero).shape == (30, 36)
    near(legs.jacobian(zero) @ robot.jacobian(T), np.eye(6), case["tol"])
    A, B = pa.legs.reduced_equations(legs, zero)
    near(np.linalg.solve(A, B), legs.jacobian(zero), case["tol"])
    spinning = case["SPS_variant"]
    idle = pa.stewart_legs(robot, T, "S")
    H = idle.loop_matrix(np.zeros(idle.n))
    assert list(H.shape) == spinning["H_shape"]
    assert np.linalg.matrix_rank(H) == spinning["rank_H"]
    assert idle.n - np.linalg.matrix_rank(H) == spinning["nullity"]
    rates = idle.rates(np.zeros(idle.n))
    assert rates.free.shape[1] == spinning["nullity_with_prismatic_locked"]
    assert spinning["platform_twist_of_locked_null_space"] == "zero"
    near(idle.jacobian(np.zeros(idle.n)) @ robot.jacobian(T), np.eye(6), case["tol"])
    assert idle.singularity(np.zeros(idle.n))


@pytest.mark.capability("08-15", "08-37", "08-44", "08-45", "08-63", "08-66")
def test_general_five_five_five():
    case = CASES["ch08-109-general-5R-5R-5R"]
    expected = case["expected"]
    screws = [
        np.stack([screw.from_axis(w, q) for w, q in zip(axes, points, strict=True)])
        for axes, points in zip(case["axis_directions"], case["axis_points"], strict=True)
    ]
    robot = pa.LegMechanism(pa.legs_from_screws(screws, pose.from_translation([0, 0, 1.2])), (0, 5, 10))
    assert robot.counted_mobility == 3
    zero, tol = np.zeros(15), case["tol"]
    H = robot.loop_matrix(zero)
    assert np.linalg.matrix_rank(H) == expected["rank_H"]
    near(abs(np.linalg.det(H[:, list(robot.passive)])), abs(expected["det_Hp_home"]), tol)
    near(robot.jacobian(zero), expected["Ja_home"], tol)
    found = pa.leg_forward(robot, case["q_a"])
    near(found.T, expected["T"], tol)
    near(found.q, expected["q_full"], tol)
    for leg in range(3):
        near(robot.jacobian(found.q, leg), expected["Ja"], tol)
    forces = pa.leg_forces(robot, found.q, case["F_s"])
    near(forces.efforts, expected["tau_a"], tol)
    near(robot.jacobian(found.q).T @ case["F_s"], expected["tau_a"], tol)
    near(forces.leg_wrenches.sum(axis=0), case["F_s"], tol)
    assert forces.possible
    assert forces.unique
    for name, driven in (("theta3_phi2_psi5", (2, 6, 14)), ("theta1_theta2_theta3", (0, 1, 2))):
        passive = np.delete(robot.loop_matrix(found.q), driven, axis=1)
        near(abs(np.linalg.det(passive)), abs(expected[f"det_Hp_if_actuated_{name}"]), tol)
    A, B = pa.legs.reduced_equations(robot, found.q)
    near(np.linalg.solve(A, B), expected["Ja"], tol)


@pytest.mark.capability("08-12", "08-53", "08-56")
def test_eclipse():
    case = CASES["ch08-17-eclipse"]
    robot, given = pa.Eclipse(1.0, 1.0, 0.3), case["ik"]
    assert given["T"] == "p=(0.05,-0.02,1.2), R=Ry(0.2)Rx(0.1) rad"
    T = pose.from_translation([0.05, -0.02, 1.2])
    T[:3, :3] = rotation.rot_y(0.2) @ rotation.rot_x(0.1)
    found = robot.inverse_kinematics(T)
    near(found[:, 0], given["gamma"], 1e-9)
    near(found[:, 1], given["column_height"], 1e-9)
    for axis, turn, angles in (
        ("y", rotation.rot_y, case["actuator_singular_tilt_deg_about_y_at_p_0_0_1p2"]),
        ("x", rotation.rot_x, case["about_x"]),
    ):
        for degrees in angles:
            tilted = pose.from_translation([0, 0, 1.2])
            tilted[:3, :3] = turn(np.radians(degrees))
            legs = pa.legs.eclipse_legs(robot, tilted)
            assert legs.counted_mobility == 6
            zero = np.zeros(legs.n)
            s = np.linalg.svd(legs.loop_matrix(zero)[:, list(legs.passive)], compute_uv=False)
            assert s[-1] < 1e-8 * s[0]
            helped = [
                leg + 1 for leg in range(3)
                if not legs.with_driven(*legs.driven, 6 * leg + 2).rates(zero).free.size
            ]  # fmt: skip
            if axis == "y":
                assert helped[:1] == [1] if degrees > 0 else helped == [2, 3]


@pytest.mark.capability("08-28")
def test_elimination_of_three_rps():
    case, legs = CASES["ch08-18-sylvester-3xRPS"], CASES["ch08-09-general-3xRPS"]
    found = pa.ThreeRPS(legs["base_radius"], legs["platform_radius"]).forward_kinematics(
        np.sqrt(1.25) + np.array(legs["q_a"])
    )
    assert len(pa.platforms.trim_leading(found.coefficients)) - 1 == case["degree"]
    assert len(found.t) == case["n_solutions"]
    assert found.real == case["n_real"]
    t1 = found.t[: found.real, 0].real
    near(sorted(t1[t1 > 0]), case["positive_real_t1"], 1e-8)
    given = case["solution_matching_case_09"]
    best = np.abs(np.degrees(found.theta) - given["theta_deg"]).max(axis=1).argmin()
    near(np.degrees(found.theta[best]), given["theta_deg"], 1e-7)
    near(found.T[best, :3, 3], given["platform_centre"], 1e-8)
    near(found.T[best, :3, 3], np.array(legs["T"])[:3, 3], 1e-8)


def test_every_key_is_read():
    assert unread_after({name: item for name, item in globals().items() if name != "test_every_key_is_read"}, OWN) == []


def test_every_case_has_tests_that_read_it():
    owners = (test_08_closed_chains, test_08_planar, test_08_planar_chains)
    assert sorted([*OWN, *(name for module in owners for name in module.OWN)]) == sorted(CASES)
