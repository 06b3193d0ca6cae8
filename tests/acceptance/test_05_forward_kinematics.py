"""Worked examples of forward kinematics: tables, screws, home poses and tip poses of the reference arms."""

import numpy as np
import pytest

from mafsil.geometry import planar as plane
from mafsil.geometry import screw
from mafsil.geometry.points import common_normal
from mafsil.model import library
from mafsil.model.denavit_hartenberg import Convention, DHRow, dh_parameters, mechanism_from_dh
from mafsil.model.dh_from_axes import screws
from mafsil.model.exponentials import mechanism_from_screws
from mafsil.model.library import textbook
from mafsil.performance import rank
from mafsil.robot import Robot
from tests.acceptance.reading import cases, unread_after

CASES = cases("05-forward-kinematics.json")


def tip(mechanism, q):
    return Robot(mechanism).forward_kinematics(q)


def wrist_centre(J):
    """Where the axes of joints 4 and 5 meet."""
    first, second = screw.nearest_point(J[:, 3]), screw.nearest_point(J[:, 4])
    found = common_normal(first, J[:3, 3], second, J[:3, 4])
    assert found.distance < 1e-7
    return found.first


def rows_of(case):
    return [
        DHRow(a=row["a"], alpha=row["alpha"], d=row["d"], theta=row["phi0"], kind=row["joint"])
        for row in case["input"]["dh"]
    ]


def close(case):
    return {"atol": case["tol"], "rtol": 0}


@pytest.mark.capability("05-2", "05-7", "05-3")
def test_planar_3r():
    """Three routes: the spatial arm, frames in the plane, exponentials in the plane."""
    case = CASES["c5-01-planar3R"]
    L, theta, expected = case["input"]["L"], case["input"]["theta"], case["expected"]
    arm = textbook.planar3r(L)
    flat = np.ix_([0, 1, 3], [0, 1, 3])
    np.testing.assert_allclose(tip(arm, theta)[flat], expected["T"], **close(case))
    closed = [expected["phi"], expected["x"], expected["y"]]
    np.testing.assert_allclose(plane.coordinates(tip(arm, theta)[flat]), closed, **close(case))
    np.testing.assert_allclose(tip(arm, [0, 0, theta[2]])[flat], expected["T_only_theta3"], **close(case))
    np.testing.assert_allclose(screws(arm).S_s[:, [2, 3, 4]], expected["S_2d"], **close(case))
    frames, exponentials = np.eye(3), np.eye(3)
    for before, angle, S in zip([0.0, *L[:2]], theta, expected["S_2d"], strict=True):
        frames = plane.compose(frames, plane.pose(angle, [before, 0.0]))
        exponentials = plane.compose(exponentials, plane.exp(np.array(S, float) * angle))
    frames = plane.compose(frames, plane.pose(0.0, [L[2], 0.0]))
    exponentials = plane.compose(exponentials, plane.pose(0.0, [sum(L), 0.0]))
    np.testing.assert_allclose(frames, expected["T"], **close(case))
    np.testing.assert_allclose(exponentials, expected["T"], **close(case))
    only = plane.compose(plane.exp(np.array(expected["S_2d"][2], float) * theta[2]), plane.pose(0.0, [sum(L), 0.0]))
    np.testing.assert_allclose(only, expected["T_only_theta3"], **close(case))


@pytest.mark.capability("05-10", "05-24")
def test_modified_link_transform():
    case = CASES["c5-02-dh-link"]
    numbers = case["input"]
    row = DHRow(a=numbers["a"], alpha=numbers["alpha"], d=numbers["d"], theta=numbers["phi"])
    np.testing.assert_allclose(row.transform(Convention.MODIFIED), case["expected"]["T"], **close(case))


@pytest.mark.capability("05-20")
def test_which_poses_have_parameters():
    case = CASES["c5-03-dh-representable"]
    for pose, expected in zip(case["input"]["cases"], case["expected"]["results"], strict=True):
        found = dh_parameters(pose["T"])
        if expected is None:
            assert found is None, pose["name"]
        else:
            np.testing.assert_allclose([found.alpha, found.a, found.d, found.theta], expected, **close(case))


ARMS = {
    "c5-05-3R-fig5.5": lambda given: textbook.spatial3r(given["L1"], given["L2"]),
    "c5-06-RRRP-fig5.6": lambda given: textbook.rrrp(next(row["a"] for row in given["dh"] if row["a"])),
    "c5-07-6R-elbow-fig5.7": lambda given: textbook.elbow6r(given["L1"], given["L2"]),
}


@pytest.mark.capability("05-27", "05-28", "05-29", "05-37", "05-40")
def test_arms_of_the_book_by_table_and_by_screws():
    for name, drawn in ARMS.items():
        case = CASES[name]
        theta, expected = case["input"]["theta"], case["expected"]
        for arm in (mechanism_from_dh(rows_of(case), "modified"), drawn(case["input"])):
            S_s, S_b, home = screws(arm)
            np.testing.assert_allclose(home, expected["M"], **close(case))
            np.testing.assert_allclose(S_s, expected["S"], **close(case))
            if "B" in expected:
                np.testing.assert_allclose(S_b, expected["B"], **close(case))
            np.testing.assert_allclose(tip(arm, theta), expected["T"], **close(case))
        by_screws = mechanism_from_screws(expected["S"], expected["M"])
        np.testing.assert_allclose(tip(by_screws, theta), expected["T"], **close(case))


@pytest.mark.capability("05-29")
def test_the_wrist_of_the_elbow_arm_is_zyz():
    case = CASES["c5-07-6R-elbow-fig5.7"]
    product = np.eye(4)
    for row, value in list(zip(rows_of(case), case["input"]["theta"], strict=True))[3:]:
        product = product @ tip(mechanism_from_dh([row], "modified"), [value])
    np.testing.assert_allclose(product[:3, :3], case["expected"]["R36"], **close(case))


@pytest.mark.capability("05-39", "05-44")
def test_rrprrr_of_figure_5_10():
    case = CASES["c5-09-RRPRRR-fig5.10"]
    given, expected = case["input"], case["expected"]
    arms = [
        mechanism_from_screws(given["S"], given["M"], form="space"),
        mechanism_from_screws(expected["B"], given["M"], form="body"),
        textbook.rrprrr(given["L1"], given["L2"]),
    ]
    for arm in arms:
        np.testing.assert_allclose(tip(arm, given["theta"]), expected["T"], **close(case))
        np.testing.assert_allclose(screws(arm).S_b, expected["B"], **close(case))
        det = np.linalg.det(Robot(arm).jacobian_space(given["theta"]))
        np.testing.assert_allclose(det, expected["det_Js"], **close(case))


@pytest.mark.capability("05-53", "05-54", "05-88")
def test_screws_of_the_arms_of_chapter_6():
    scara, upright = CASES["c6-01-Js-RRRP-fig6.2"], CASES["c6-02-Js-RRPRRR-fig6.3"]
    given, expected = scara["input"], scara["expected"]
    arm = textbook.scara_rrrp(0.2, given["L2"], given["L3"])
    np.testing.assert_allclose(screws(arm).S_s, given["S"], **close(scara))
    J = Robot(arm).jacobian_space(given["theta"])
    np.testing.assert_allclose(J, expected["Js"], **close(scara))
    np.testing.assert_allclose(np.linalg.det(J[2:]), expected["minor_rows3to6"], **close(scara))
    straight = [given["theta"][0], 0.0, *given["theta"][2:]]
    assert rank(Robot(arm), given["theta"]) == expected["rank"]
    assert rank(Robot(arm), straight) == expected["rank_theta2_0"]
    given, expected = upright["input"], upright["expected"]
    arm = textbook.rrprrr_upright(given["L1"], given["L2"])
    np.testing.assert_allclose(screws(arm).S_s, given["S"], **close(upright))
    np.testing.assert_allclose(screws(arm).home, given["M"], **close(upright))
    J = Robot(arm).jacobian_space(given["theta"])
    np.testing.assert_allclose(J, expected["Js"], **close(upright))
    np.testing.assert_allclose(np.linalg.det(J), expected["det"], **close(upright))
    np.testing.assert_allclose(wrist_centre(J), expected["q_w"], **close(upright))


@pytest.mark.capability("05-38", "05-45")
def test_6r_of_figure_5_9_in_space_and_body_form():
    """The corrected table of the book, and its check: joint 4 alone by a quarter turn."""
    L = 0.4
    arm = textbook.arm6r(L)
    S_b = [
        [0, 0, 1, -3 * L, 0, 0],
        [0, 1, 0, 0, 0, 0],
        [-1, 0, 0, 0, 0, -3 * L],
        [-1, 0, 0, 0, 0, -2 * L],
        [-1, 0, 0, 0, 0, -L],
        [0, 1, 0, 0, 0, 0],
    ]
    np.testing.assert_allclose(screws(arm).S_b, S_b, atol=1e-15)
    turned = tip(arm, [0, 0, 0, np.pi / 2, 0, 0])
    np.testing.assert_allclose(turned[:3, 3], [0, L, -2 * L], atol=1e-15)


@pytest.mark.capability("05-88")
def test_every_arm_of_the_book_is_in_the_library():
    arms = {"planar2r", "planar3r", "spatial3r", "rrrp", "elbow6r", "arm6r", "rrprrr", "scara_rrrp", "rrprrr_upright"}
    assert arms <= set(library.robots())


def test_every_key_of_every_case_is_read(request):
    del request  # an argument, so that the guard does not call itself
    assert unread_after(globals(), CASES) == []
