"""Worked examples of forward kinematics: tables, screws, home poses and tip poses of the reference arms."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from mafsil.model import library
from mafsil.model.denavit_hartenberg import Convention, DHRow, dh_parameters, mechanism_from_dh
from mafsil.model.exponentials import mechanism_from_screws, screws
from mafsil.model.library import planar, textbook

CASES = {
    case["id"]: case for case in json.loads((Path(__file__).parent / "05-forward-kinematics.json").read_text("utf-8"))
}


def bracket(S):
    (x, y, z), v = S[:3], S[3:]
    return np.array([[0, -z, y, v[0]], [z, 0, -x, v[1]], [-y, x, 0, v[2]], [0, 0, 0, 0]])


def tip_pose(mechanism, q):
    T = mechanism.T_sb
    for joint, value in zip(mechanism.joints, q, strict=True):
        T = T @ joint.T_pj @ expm(bracket(joint.screw) * value)
    return T @ mechanism.T_lt


def rows_of(case):
    return [
        DHRow(a=row["a"], alpha=row["alpha"], d=row["d"], theta=row["phi0"], kind=row["joint"])
        for row in case["input"]["dh"]
    ]


def close(case):
    return {"atol": case["tol"], "rtol": 0}


@pytest.mark.capability("05-2", "05-7")
def test_planar_3r():
    case = CASES["c5-01-planar3R"]
    arm = planar.planar3r(case["input"]["L"])
    planar_rows = np.ix_([0, 1, 3], [0, 1, 3])
    theta = case["input"]["theta"]
    np.testing.assert_allclose(tip_pose(arm, theta)[planar_rows], case["expected"]["T"], **close(case))
    locked = tip_pose(arm, [0, 0, theta[2]])
    np.testing.assert_allclose(locked[planar_rows], case["expected"]["T_only_theta3"], **close(case))
    np.testing.assert_allclose(screws(arm).S_s[:, [2, 3, 4]], case["expected"]["S_2d"], **close(case))


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


TABLES = {
    "c5-05-3R-fig5.5": textbook.spatial3r(1.0, 0.5),
    "c5-06-RRRP-fig5.6": textbook.rrrp(0.7),
    "c5-07-6R-elbow-fig5.7": textbook.elbow6r(0.5, 0.4),
}


@pytest.mark.capability("05-27", "05-28", "05-29", "05-37", "05-40")
@pytest.mark.parametrize("name", TABLES)
def test_arms_of_the_book_by_table_and_by_screws(name):
    case = CASES[name]
    theta, expected = case["input"]["theta"], case["expected"]
    for arm in (mechanism_from_dh(rows_of(case), "modified"), TABLES[name]):
        S_s, S_b, home = screws(arm)
        np.testing.assert_allclose(home, expected["M"], **close(case))
        np.testing.assert_allclose(S_s, expected["S"], **close(case))
        np.testing.assert_allclose(S_b, expected.get("B", S_b), **close(case))
        np.testing.assert_allclose(tip_pose(arm, theta), expected["T"], **close(case))
    by_screws = mechanism_from_screws(expected["S"], expected["M"])
    np.testing.assert_allclose(tip_pose(by_screws, theta), expected["T"], **close(case))


@pytest.mark.capability("05-29")
def test_the_wrist_of_the_elbow_arm_is_zyz():
    case = CASES["c5-07-6R-elbow-fig5.7"]
    product = np.eye(4)
    for row, value in list(zip(rows_of(case), case["input"]["theta"], strict=True))[3:]:
        product = product @ tip_pose(mechanism_from_dh([row], "modified"), [value])
    np.testing.assert_allclose(product[:3, :3], case["expected"]["R36"], **close(case))


@pytest.mark.capability("05-39", "05-44")
@pytest.mark.parametrize("form", ["space", "body"])
def test_rrprrr_of_figure_5_10(form):
    case = CASES["c5-09-RRPRRR-fig5.10"]
    axes = case["input"]["S"] if form == "space" else case["expected"]["B"]
    for arm in (mechanism_from_screws(axes, case["input"]["M"], form=form), textbook.rrprrr(0.5, 0.3)):
        np.testing.assert_allclose(tip_pose(arm, case["input"]["theta"]), case["expected"]["T"], **close(case))
        np.testing.assert_allclose(screws(arm).S_b, case["expected"]["B"], **close(case))


@pytest.mark.capability("05-53", "05-54", "05-88")
@pytest.mark.parametrize(
    ("name", "arm"),
    [
        ("c6-01-Js-RRRP-fig6.2", textbook.scara_rrrp(0.2, 0.6, 0.4)),
        ("c6-02-Js-RRPRRR-fig6.3", textbook.rrprrr_upright(0.5, 0.3)),
    ],
)
def test_screws_of_the_arms_of_chapter_6(name, arm):
    np.testing.assert_allclose(screws(arm).S_s, CASES[name]["input"]["S"], **close(CASES[name]))
    if "M" in CASES[name]["input"]:
        np.testing.assert_allclose(screws(arm).home, CASES[name]["input"]["M"], **close(CASES[name]))


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
    turned = tip_pose(arm, [0, 0, 0, np.pi / 2, 0, 0])
    np.testing.assert_allclose(turned[:3, 3], [0, L, -2 * L], atol=1e-15)


@pytest.mark.capability("05-88")
def test_every_arm_of_the_book_is_in_the_library():
    arms = {"planar2r", "planar3r", "spatial3r", "rrrp", "elbow6r", "arm6r", "rrprrr", "scara_rrrp", "rrprrr_upright"}
    assert arms <= set(library.names())
