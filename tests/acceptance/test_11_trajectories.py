"""Worked numbers of the specification, part 11: |got - expected| <= tol max(1, |expected|)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mafsil.geometry import rotation
from mafsil.trajectory import CartesianPath, PlanStatus, cubic, cubic_through, quintic, trapezoid

CASES = {case["id"]: case for case in json.loads(Path(__file__).with_name("11-trajectories.json").read_text())}


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


@pytest.mark.capability("11-24")
def test_two_segments_with_continuous_acceleration():
    case = CASES["two_segment_cubic_continuous_acc"]
    given, expected = case["input"], case["expected"]
    motion = cubic_through([given["u0"], given["u_via"], given["u_goal"]], [given["tf_each"]] * 2)
    agree(case, motion.coefficients[..., 0], [expected["seg1"], expected["seg2"]])
    agree(case, motion.at(given["tf_each"]).v[0], expected["v_via"])


@pytest.mark.capability("11-23")
def test_via_velocity_heuristic():
    case = CASES["via_velocity_heuristic"]
    for path, expected in zip(case["input"]["paths"], case["expected"]["v"], strict=True):
        motion = cubic_through(path["points"], path["durations"], velocities="heuristic")
        agree(case, motion.at(motion.knots).v[:, 0], expected)


@pytest.mark.capability("11-25", "11-26")
def test_one_leg_with_parabolic_blends():
    case = CASES["lspb"]
    given, expected = case["input"], case["expected"]
    outcome = trapezoid(given["u0"], given["uf"], acceleration=given["acc"], duration=given["tf"])
    motion = outcome.value
    agree(case, motion.knots[1], expected["tb"])
    agree(case, motion.at(given["tf"] / 2).v[0], expected["v"])
    agree(case, motion.at(expected["u_at"]["t"]).u[:, 0], expected["u_at"]["u"])
    weak = trapezoid(given["u0"], given["uf"], acceleration=expected["infeasible_if_acc"], duration=given["tf"])
    assert weak.status is PlanStatus.TOO_SHORT
    least = trapezoid(given["u0"], given["uf"], acceleration=4 * 60 / given["tf"] ** 2, duration=given["tf"])
    agree(case, 4 * 60 / given["tf"] ** 2, expected["acc_min"])
    assert least.succeeded


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


def test_unit_profiles_of_cubic_and_quintic():
    case = CASES["unit_profiles"]
    expected = case["expected"]
    profiles = [cubic(0.0, 1.0, 1.0), quintic(0.0, 1.0, 1.0)]
    agree(case, [profile.at(0.25).u[0] for profile in profiles], expected["value_at_0_25"][:2])
    agree(case, [profile.at(0.5).v[0] for profile in profiles], expected["peak_velocity"][:2])
    peak = profiles[1].at(profiles[1].stationary_times(2)).a.max()
    agree(case, peak, expected["quintic_peak_acc"])


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
