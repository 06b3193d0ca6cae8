"""Worked numbers of the specification, part 11: |got - expected| <= tol max(1, |expected|)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import rotation
from mafsil.model import Limits
from mafsil.planning import PotentialField, disc_distance
from mafsil.planning.outcome import PlanningStatus
from mafsil.trajectory import (
    cubic,
    cubic_through,
    line_path,
    linear_blends,
    quintic,
    reachability,
    time_law,
    trapezoid,
    via_rates,
)
from mafsil.trajectory.motion import BlendStatus, PlanStatus
from mafsil.trajectory.paths import CartesianPath
from mafsil.trajectory.splines import first_leg, last_leg
from tests.acceptance.reading import cases, unread_after

CASES = cases("11-trajectories.json", "11-more.json")
NOT_YET = {
    "orientation_interpolation",
    "orientation_short_and_long_turn",
    "orientation_three_readings",
}
"""Cases of Cartesian motions, read in test_11_cartesian.py."""


def agree(case, got, expected):
    expected = np.asarray(expected, dtype=float)
    assert np.all(np.abs(np.asarray(got) - expected) <= case["tol"] * np.maximum(1.0, np.abs(expected)))


@pytest.mark.capability("11-18")
def test_cubic_rest_to_rest():
    case = CASES["cubic_rest_to_rest"]
    given, expected = case["input"], case["expected"]
    motion = cubic(given["u0"], given["uf"], given["tf"])
    middle = motion.at(given["tf"] / 2)
    agree(case, motion.coefficients[0, :, 0], expected["a"])
    agree(case, [middle.u[0], middle.v[0]], [expected["u_mid"], expected["v_max"]])
    agree(case, motion.at([0, given["tf"]]).a[:, 0], [expected["acc0"], expected["acc_f"]])
    agree(case, motion.jerk(1.0)[0], expected["jerk"])


@pytest.mark.capability("11-19")
def test_cubic_with_velocities():
    case = CASES["cubic_with_velocities"]
    given, expected = case["input"], case["expected"]
    motion = cubic(given["u0"], given["uf"], given["tf"], start_velocity=given["v0"], goal_velocity=given["vf"])
    agree(case, motion.coefficients[0, :, 0], expected["a"])
    agree(case, [motion.at(1.0).u[0], motion.at(1.0).v[0]], [expected["u_1"], expected["v_1"]])
    agree(case, -motion.coefficients[0, 3, 0], expected["printed_sign_a3_would_be"])


@pytest.mark.capability("11-24")
def test_two_segments_with_continuous_acceleration():
    case = CASES["two_segment_cubic_continuous_acc"]
    given, expected = case["input"], case["expected"]
    ends = {"start_velocity": given["v_ends"], "goal_velocity": given["v_ends"]}
    motion = cubic_through([given["u0"], given["u_via"], given["u_goal"]], [given["tf_each"]] * 2, **ends)
    agree(case, motion.coefficients[..., 0], [expected["seg1"], expected["seg2"]])
    agree(case, motion.at(given["tf_each"]).v[0], expected["v_via"])


@pytest.mark.capability("11-24")
def test_clamped_spline_with_moving_ends():
    case = CASES["spline_clamped_nonzero_ends"]
    given, expected = case["input"], case["expected"]
    motion = cubic_through(given["points"], given["durations"], start_velocity=given["v0"], goal_velocity=given["vn"])
    agree(case, motion.at(motion.knots[1:-1]).v[:, 0], expected["v_via"])
    agree(case, motion.at(motion.knots).a[:, 0], expected["acc_at_points"])
    agree(case, motion.at(expected["value"]["t"]).u[:, 0], expected["value"]["u"])
    agree(case, motion.coefficients[1, :, 0], expected["a_segment_2"])


@pytest.mark.capability("11-23")
def test_via_velocity_heuristic():
    case = CASES["via_velocity_heuristic"]
    assert case["input"]["rule"].startswith("zero when the slope changes sign")
    for path, expected in zip(case["input"]["paths"], case["expected"]["v"], strict=True):
        motion = cubic_through(path["points"], path["durations"], velocities="heuristic")
        agree(case, motion.at(motion.knots).v[:, 0], expected)


def planar_arm(*lengths):
    """A planar arm about z, stretched along x at home."""
    home, starts = np.eye(4), np.cumsum([0.0, *lengths])
    home[0, 3] = starts[-1]
    return mf.Robot.from_screws([[0.0, 0.0, 1.0, 0.0, -x, 0.0] for x in starts[:-1]], home)


@pytest.mark.capability("11-22")
def test_via_velocity_from_that_of_the_tip():
    case = CASES["via_velocity_from_jacobian"]
    given = case["input"]
    assert given["robot"] == "planar 2R L1=1 L2=0.8"
    rates = via_rates(planar_arm(1.0, 0.8), given["theta"], linear=[*given["tip_velocity"], 0.0])
    assert rates
    agree(case, rates.qd, case["expected"]["theta_dot"])


@pytest.mark.capability("11-22")
def test_via_velocity_and_the_order_of_linear_and_angular():
    case = CASES["via_velocity_planar3R_orders"]
    given, expected = case["input"], case["expected"]
    robot, v, w = planar_arm(*given["L"]), given["v_tip"], given["wz"]
    rates = via_rates(robot, given["theta"], linear=[*v, 0.0], angular=[0.0, 0.0, w])
    agree(case, rates.qd, expected["theta_dot"])
    agree(case, rates.condition, expected["cond_J"])
    agree(case, (robot.jacobian_space(given["theta"]) @ rates.qd)[[2, 3, 4]], expected["space_twist"])
    wrong = via_rates(robot, given["theta"], linear=[w, v[0], 0.0], angular=[0.0, 0.0, v[1]])
    agree(case, wrong.qd, expected["wrong_order"])


@pytest.mark.capability("11-25", "11-26")
def test_one_leg_with_parabolic_blends():
    case = CASES["lspb"]
    given, expected = case["input"], case["expected"]
    plan = linear_blends([given["u0"], given["uf"]], [given["tf"]], acceleration=given["acc"])
    outcome = trapezoid(given["u0"], given["uf"], acceleration=given["acc"], duration=given["tf"])
    agree(case, plan.blend[:, 0], [expected["tb"]] * 2)
    agree(case, [plan.slope[0, 0], plan.trajectory.at(given["tf"] / 2).v[0]], [expected["v"]] * 2)
    for motion in (plan.trajectory, outcome.value):
        agree(case, motion.breaks()[1], expected["tb"])
        agree(case, motion.at(expected["u_at"]["t"]).u[:, 0], expected["u_at"]["u"])
    weak = linear_blends([given["u0"], given["uf"]], [given["tf"]], acceleration=expected["infeasible_if_acc"])
    assert weak.status is BlendStatus.TOO_SHORT_TO_BLEND
    agree(case, weak.infeasible[0].acceleration_needed, expected["acc_min"])
    agree(case, weak.infeasible[0].least_acceleration, expected["acc_min"])
    weak = trapezoid(given["u0"], given["uf"], acceleration=expected["infeasible_if_acc"], duration=given["tf"])
    assert weak.status is PlanStatus.TOO_SHORT
    assert linear_blends([given["u0"], given["uf"]], given["tf"], acceleration=4 * 60 / given["tf"] ** 2)


@pytest.mark.capability("11-25", "11-26")
def test_one_leg_downwards_on_a_clock_that_starts_late():
    case = CASES["lspb_negative_offset_start"]
    given, expected = case["input"], case["expected"]
    ends, duration = [given["u0"], given["uf"]], given["tf"] - given["t0"]
    plan = linear_blends(ends, duration, acceleration=given["acc"])
    agree(case, [plan.blend[0, 0], plan.slope[0, 0]], [expected["tb"], expected["v_cruise"]])
    at = plan.trajectory.at(np.array(expected["at"]["t"]) - given["t0"])
    agree(case, [at.u[:, 0], at.v[:, 0]], [expected["at"]["u"], expected["at"]["v"]])
    weak = linear_blends(ends, duration, acceleration=expected["acc_min"] / 2)
    agree(case, weak.infeasible[0].acceleration_needed, expected["acc_min"])
    corner = linear_blends(ends, duration, acceleration=expected["triangular"]["acc"])
    agree(case, corner.blend[:, 0], expected["triangular"]["tb"])
    agree(case, corner.slope[0, 0], expected["triangular"]["v_peak"])


@pytest.mark.capability("11-27", "11-28", "11-31")
def test_several_legs_with_parabolic_blends():
    case = CASES["lfpb_multi_segment"]
    given, expected = case["input"], case["expected"]
    plan = linear_blends(given["points"], given["durations"], acceleration=given["acc"])
    agree(case, plan.acceleration[:, 0], expected["signed_acc"])
    agree(case, plan.blend[:, 0], expected["blend"])
    agree(case, plan.slope[:, 0], expected["v"])
    agree(case, plan.straight[:, 0], expected["linear"])
    agree(case, plan.trajectory.duration, expected["total"])
    end = plan.trajectory.at(plan.trajectory.duration)
    agree(case, [end.u[0], end.v[0]], expected["end"])
    agree(case, plan.trajectory.at(plan.via_times[1:-1]).u[:, 0], expected["u_at_nominal_via_times"])
    agree(case, np.array(given["points"][1:-1]) + plan.miss[:, 0], expected["u_at_nominal_via_times"])


@pytest.mark.capability("11-28")
def test_sign_of_the_last_leg():
    case = CASES["lfpb_last_segment_sign"]
    given, expected = case["input"], case["expected"]
    distance, duration, A = (np.float64(x) for x in (given["u"][1] - given["u"][0], given["td"], given["acc"]))
    leg = last_leg(distance, duration, A)
    agree(case, leg.blend, expected["tn"])
    assert leg.acceleration == A  # It slows a downward motion.
    agree(case, duration - np.sqrt(duration**2 - 2 * distance / leg.acceleration), expected["printed_minus_gives"])
    assert leg.blend == first_leg(distance, duration, A).blend


@pytest.mark.capability("11-32")
def test_pseudo_via_points():
    case = CASES["pass_through_via_virtual_points"]
    given, expected = case["input"], case["expected"]
    path, acceleration = (given["points"], given["durations"]), given["acc"]
    through = {1: given["via_velocity"]}
    plan = linear_blends(*path, acceleration=acceleration, through=through, delta=given["delta"])
    agree(case, np.c_[plan.via_times, plan.points][1:3], expected["virtual"])
    agree(case, plan.blend[:, 0], expected["blend"])
    agree(case, plan.slope[:, 0], expected["v"])
    agree(case, plan.straight[:, 0], expected["linear"])
    at = plan.trajectory.at(given["durations"][0])
    agree(case, [at.u[0], at.v[0]], [expected["u_at_2"], expected["v_at_2"]])
    plain = linear_blends(*path, acceleration=acceleration)
    agree(case, plain.trajectory.at(given["durations"][0]).u[0], expected["plain_blend_u_at_2"])


@pytest.mark.capability("11-30")
def test_blends_that_do_not_fit():
    case = CASES["lfpb_infeasible"]
    radicand, overlap = (
        linear_blends(given["points"], given["durations"], acceleration=given["acc"]) for given in case["input"]
    )
    first, second = case["expected"]
    for plan, expected in ((radicand, first), (overlap, second)):
        assert bool(plan) is expected["feasible"]
        assert plan.infeasible[0].leg + 1 == expected["leg"]
    assert first["reason"] == "radicand"
    assert radicand.status is BlendStatus.TOO_SHORT_TO_BLEND
    agree(case, radicand.infeasible[0].acceleration_needed, first["acc_for_radicand"])
    agree(case, radicand.infeasible[0].duration_needed, first["td_for_radicand"])
    assert overlap.status is BlendStatus.BLENDS_OVERLAP
    agree(case, overlap.straight[:, 0], second["linear"])
    agree(case, overlap.infeasible[0].least_acceleration, second["acc_min_all"])


@pytest.mark.capability("11-29")
def test_durations_from_default_speeds():
    case = CASES["default_speed_durations"]
    given, expected = case["input"], case["expected"]
    for k, (D, speed, A) in enumerate(zip(given["D"], given["v_default"], given["acc"], strict=True)):
        agree(case, linear_blends([0.0, D], velocity=speed, acceleration=1e9).durations, expected["td_speed"][k])
        agree(case, linear_blends([0.0, D], velocity=speed, acceleration=A).durations, expected["td_feasible"][k])
    ends = [[0.0, 0.0, 0.0], given["D"]]
    plan = linear_blends(ends, velocity=given["v_default"], acceleration=given["acc"])
    agree(case, plan.durations, expected["t"])
    agree(case, plan.blend[0], expected["tb"])
    agree(case, plan.slope[0], expected["cruise"])


@pytest.mark.capability("11-48")
def test_quintic_blend_at_a_via_point():
    case = CASES["quintic_blend_at_via"]
    given, expected = case["input"], case["expected"]
    u, v1, v2, b = given["u_k"], given["v1"], given["v2"], 2 * given["tau"]
    points, durations = [u - v1, u - v1, u, u + v2, u + v2], [1.0] * 4
    peaks = [1e3, 1e3, expected["peak_acc"], 1e3, 1e3]
    plan = linear_blends(points, durations, acceleration=peaks, blend="quintic")
    agree(case, plan.blend[2, 0], b)
    pieces = plan.trajectory.to_polynomial()
    piece = int(np.argmin(np.abs(pieces.knots - (2.0 - given["tau"]))))
    agree(case, pieces.coefficients[piece, :, 0], expected["a"])
    agree(case, plan.miss[1, 0], expected["miss"])
    agree(case, np.abs(plan.trajectory.at(2.0).a[0]), expected["peak_acc"])
    peaks[2] = abs(expected["parabola"]["acc"])
    parabola = linear_blends(points, durations, acceleration=peaks)
    agree(case, parabola.blend[2, 0], b)
    agree(case, [parabola.acceleration[2, 0], parabola.miss[1, 0]], [expected["parabola"][k] for k in ("acc", "miss")])


@pytest.mark.capability("11-34")
def test_quintic():
    case = CASES["quintic"]
    given = case["input"]
    motion = quintic(
        given["u0"],
        given["uf"],
        given["tf"],
        start_velocity=given["v0"],
        goal_velocity=given["vf"],
        start_acceleration=given["a0"],
        goal_acceleration=given["af"],
    )
    agree(case, motion.coefficients[0, :, 0], case["expected"]["a"])


@pytest.mark.capability("11-17")
def test_unit_profiles():
    case = CASES["unit_profiles"]
    expected = case["expected"]
    assert case["input"]["s"] == "t/tf"
    laws = [time_law(kind) for kind in case["input"]["kinds"]]
    agree(case, [law.unit().at(0.25).u[0] for law in laws], expected["value_at_0_25"])
    agree(case, [law.peaks[0] for law in laws], expected["peak_velocity"])
    agree(case, laws[case["input"]["kinds"].index("quintic")].peaks[1], expected["quintic_peak_acc"])


@pytest.mark.capability("11-7")
def test_orientation_turns_about_one_axis():
    case = CASES["orientation_interpolation"]
    expected = case["expected"]
    goal = np.eye(4)
    goal[:3, :3] = rotation.exp([0.0, 0.0, np.pi / 2]) @ rotation.exp([np.pi / 2, 0.0, 0.0])
    for interpolation in ("straight", "screw"):
        path = CartesianPath(np.eye(4), goal, interpolation)
        agree(case, np.degrees(path.angle), expected["angle_deg"])
        agree(case, path.twists(0.0)[0][:3] / path.angle, expected["axis"])
        agree(case, path.poses(case["input"]["s"])[:3, :3], expected["R_mid_axis"])


def bounded(robot, lower, upper):
    """The same arm with limits of its joints."""
    ends = iter(zip(lower, upper, strict=True))
    joints = [replace(joint, limits=Limits(*next(ends))) if joint.moves else joint for joint in robot.mechanism.joints]
    return mf.Robot(replace(robot.mechanism, joints=tuple(joints)))


def planar_line(a, b):
    ends = np.eye(4)[None].repeat(2, axis=0)
    ends[:, :2, 3] = a, b
    return line_path(*ends)


@pytest.mark.capability("11-10")
def test_cartesian_unreachable_middle():
    case = CASES["cartesian_unreachable_middle"]
    assert case["input"]["robot"] == "2R L1=1 L2=0.5"
    path = planar_line(case["input"]["A"], case["input"]["B"])
    answer = reachability(planar_arm(1.0, 0.5), path, task="position")
    assert not answer
    assert answer.unreachable
    agree(case, answer.unreachable, [case["expected"]["unreachable_s_open_interval"]])


@pytest.mark.capability("11-12")
def test_cartesian_branch_change():
    case, expected = CASES["cartesian_branch_change"], CASES["cartesian_branch_change"]["expected"]
    assert case["input"]["robot"] == "2R L1=L2=1, |theta1|<=70 deg"
    limit = np.radians(70)
    robot = bounded(planar_arm(1.0, 1.0), [-limit, -np.pi], [limit, np.pi])
    path = planar_line(case["input"]["A"], case["input"]["B"])
    ends = mf.ik.inverse_kinematics(robot, path.poses([0.0, 1.0]), task="position").q
    rows = {"theta2>0": int(ends[0, :, 1].argmax()), "theta2<0": int(ends[0, :, 1].argmin())}
    for name, row in rows.items():
        agree(case, np.degrees(ends[0, row, 0]), expected["theta1_deg_at_A"][name])
        agree(case, np.degrees(ends[1, row, 0]), expected["theta1_deg_at_B"][name])
    answer = reachability(robot, path, task="position")
    ((first, last),) = answer.branches[rows["theta2>0"]]
    agree(case, path.poses(first)[1, 3], expected["theta2_positive_feasible_for_y_at_least"])
    assert last == 1.0
    ((first, last),) = answer.branches[rows["theta2<0"]]
    agree(case, path.poses(last)[1, 3], expected["theta2_negative_feasible_for_y_at_most"])
    assert first == 0.0
    assert bool(answer.covering) is expected["single_branch_whole_line"]
    assert bool(answer) is expected["every_point_reachable"]


@pytest.mark.capability("11-44")
def test_potential_field():
    case = CASES["potential_field"]
    given, expected, tol = case["input"], case["expected"], case["tol"]
    obstacle = disc_distance(given["disc"]["c"], given["disc"]["r"])
    field = PotentialField.of(given["goal"], [obstacle], kp=given["kp"], eta=given["eta"], reach=given["rho0"])
    x = np.array(given["x"], dtype=float)
    np.testing.assert_allclose(obstacle(x)[0], expected["rho"], atol=tol)
    np.testing.assert_allclose(field.repulsion(x), expected["F_rep"], atol=tol)
    np.testing.assert_allclose(field.attraction(x), expected["F_att"], atol=tol)
    np.testing.assert_allclose(field.force(x), expected["F"], atol=tol)
    stuck = expected["local_minimum"]
    ahead = PotentialField.of(
        given["goal"],
        [disc_distance(stuck["disc"]["c"], stuck["disc"]["r"])],
        kp=given["kp"],
        eta=given["eta"],
        reach=given["rho0"],
    )
    found = ahead.path(stuck["start"])
    assert found.status is PlanningStatus.LOCAL_MINIMUM
    assert not found
    np.testing.assert_allclose(found.path[-1], [stuck["stuck_x"], 0.0], atol=1e-6)
    escaped = ahead.path(stuck["start"], escapes=20, seed=3)
    assert escaped
    np.testing.assert_allclose(escaped.path[-1], given["goal"], atol=1e-7)


def test_every_key_of_every_case_is_read(capsys):
    unread = unread_after(globals(), {name: case for name, case in CASES.items() if name not in NOT_YET})
    assert not unread
    with capsys.disabled():
        print(f"\nnot read here: {', '.join(sorted(NOT_YET & set(CASES)))}")
