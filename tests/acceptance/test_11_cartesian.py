"""Worked numbers of the specification, part 11, orientation laws: |got - expected| <= tol max(1, |expected|)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import euler, rotation
from mafsil.trajectory import line_path

CASES = {case["id"]: case for case in json.loads(Path(__file__).with_name("11-trajectories.json").read_text())}


def agree(case, got, expected):
    expected = np.asarray(expected, dtype=float)
    assert np.all(np.abs(np.asarray(got) - expected) <= case["tol"] * np.maximum(1.0, np.abs(expected)))


def posed(R):
    T = np.eye(4)
    T[:3, :3] = R
    return T


def angle_deg(R_0, R_1):
    return np.degrees(np.linalg.norm(rotation.log(R_0.T @ R_1)))


@pytest.mark.capability("11-7", "11-9")
def test_orientation_interpolation():
    case = CASES["orientation_interpolation"]
    s, expected = case["input"]["s"], case["expected"]
    goal = posed(rotation.rot_z(np.pi / 2) @ rotation.rot_x(np.pi / 2))
    laws = {name: line_path(np.eye(4), goal, orientation=name) for name in ("relative", "euler", "cosines")}
    middle = {name: path.poses(s)[:3, :3] for name, path in laws.items()}
    turn = laws["relative"].orientation.turn
    agree(case, np.degrees(laws["relative"].angle), expected["angle_deg"])
    agree(case, turn / np.linalg.norm(turn), expected["axis"])
    agree(case, middle["relative"], expected["R_mid_axis"])
    agree(case, middle["euler"], expected["R_mid_zyx_euler"])
    agree(case, angle_deg(middle["relative"], middle["euler"]), expected["angle_between_deg"])
    determinant = laws["cosines"].orientation.determinant(np.array(s))
    agree(case, determinant, expected["det_of_averaged_direction_cosines"])


@pytest.mark.capability("11-7")
def test_orientation_short_and_long_turn():
    """R1 = R0 exp([axis] 200 deg): the short turn takes 160 deg about the opposite axis, the long one 200 deg."""
    R_0 = euler.from_euler(np.radians([20, 30, -40]), "ZYX")
    R_1 = R_0 @ rotation.exp(np.radians(200) * np.array([0.36, 0.48, 0.8]))
    short, long = (line_path(posed(R_0), posed(R_1), orientation=law) for law in ("relative", "relative_long"))
    turn = short.orientation.turn
    assert np.linalg.norm(turn) == pytest.approx(2.7925268032, abs=1e-8)
    np.testing.assert_allclose(turn / np.linalg.norm(turn), [-0.36, -0.48, -0.8], atol=1e-8)
    middle_short = [
        [0.6918392189, 0.5468165546, -0.47154019],
        [0.2121025902, 0.4703384851, 0.8566178849],
        [0.690196339, -0.6926567441, 0.2094174025],
    ]
    middle_long = [
        [-0.5951418415, -0.4178867182, 0.6864232508],
        [0.4988352833, 0.4775786796, 0.7232440563],
        [-0.6300551949, 0.7728449363, -0.0757704154],
    ]
    np.testing.assert_allclose(short.poses(0.5)[:3, :3], middle_short, atol=1e-8)
    np.testing.assert_allclose(long.poses(0.5)[:3, :3], middle_long, atol=1e-8)
    law = mf.trajectory.cubic(0.0, 1.0, 2.0).at(0.5)
    omega = short.twists(law.u[0])[0][:3] * law.v[0]
    np.testing.assert_allclose(omega, [-0.5654866776, -0.7539822369, -1.2566370614], atol=1e-8)
    space = short.poses(law.u[0])[:3, :3] @ omega
    np.testing.assert_allclose(space, [-0.2109609516, -1.5510258337, -0.1312076227], atol=1e-8)


@pytest.mark.capability("11-7", "11-9")
def test_orientation_three_readings():
    R_0, R_1 = (euler.from_euler(np.radians(a), "ZYX") for a in ([20, 30, -40], [110, -25, 60]))
    laws = {
        name: line_path(posed(R_0), posed(R_1), orientation=name) for name in ("rotation_vector", "relative", "euler")
    }
    K = laws["rotation_vector"].orientation.K.at([0.0, 1.0]).u
    np.testing.assert_allclose(K[0], [-0.766457594, 0.3798047937, 0.5104273037], atol=1e-8)
    np.testing.assert_allclose(K[1], [1.0986208966, 0.7408586689, 1.9123964088], atol=1e-8)
    middle = {name: path.poses(0.5)[:3, :3] for name, path in laws.items()}
    expected = {
        "rotation_vector": [
            [0.2356987966, -0.8378818694, 0.492341396],
            [0.9177324246, 0.3585662054, 0.1708726814],
            [-0.3197081078, 0.4115631777, 0.8534649826],
        ],
        "relative": [
            [0.1420860667, -0.8710674489, 0.4701627901],
            [0.9149354559, 0.2968411325, 0.2734564931],
            [-0.3777627049, 0.3913142491, 0.8391474824],
        ],
    }
    for name, R in expected.items():
        np.testing.assert_allclose(middle[name], R, atol=1e-8)
    for a, b, degrees in (
        ("rotation_vector", "relative", 6.8656333196),
        ("rotation_vector", "euler", 23.5870383514),
        ("relative", "euler", 27.640349256),
    ):
        assert angle_deg(middle[a], middle[b]) == pytest.approx(degrees, rel=1e-8)
