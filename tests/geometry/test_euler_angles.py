"""Euler angles: all 24 sequences, both branches, gimbal locks as families, general axis triples and the wrist."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation as Oracle

from mafsil.errors import InputError
from mafsil.geometry import euler, rotation
from mafsil.geometry.wrist import Wrist

EPS = 2.0**-52
SEQUENCES = sorted(euler.SEQUENCES)
LOCKS = {True: (0.0, pi), False: (pi / 2, -pi / 2)}


def turned(a, b):
    """Difference of angles, whole turns removed."""
    return np.abs(np.angle(np.exp(1j * (np.asarray(a) - np.asarray(b)))))


@pytest.mark.capability("04-32")
def test_elementary_rotations():
    a = 0.3
    c, s = np.cos(a), np.sin(a)
    assert np.abs(rotation.rot_x(a) - [[1, 0, 0], [0, c, -s], [0, s, c]]).max() <= EPS
    assert np.abs(rotation.rot_y(a) - [[c, 0, s], [0, 1, 0], [-s, 0, c]]).max() <= EPS
    assert np.abs(rotation.rot_z(a) - [[c, -s, 0], [s, c, 0], [0, 0, 1]]).max() <= EPS
    assert rotation.rot_z(np.zeros((3, 1, 2))).shape == (3, 1, 2, 3, 3)


@pytest.mark.capability("04-44", "04-18")
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_agreement_with_scipy(sequence: str):
    angles = np.random.default_rng(0).uniform(-pi, pi, (2000, 3))
    R = rotation.from_euler(angles, sequence)
    theirs = Oracle.from_euler(sequence, angles)
    assert np.abs(R - theirs.as_matrix()).max() <= 4 * EPS
    assert turned(rotation.to_euler(R, sequence), theirs.as_euler(sequence)).max() < 1e-11
    q = euler.quaternion_from_euler(angles, sequence)
    assert np.abs(rotation.from_quaternion(q) - R).max() <= 8 * EPS


@pytest.mark.capability("04-35", "04-36", "04-42", "04-44", "04-50", "04-39")
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_both_branches_reach_every_rotation_within_their_ranges(sequence: str):
    known = euler.SEQUENCES[sequence]
    R = rotation.random(np.random.default_rng(1), 3000)
    found = euler.solutions(R, sequence)
    assert not found.locked.any()
    for branch in (0, 1):
        assert np.abs(rotation.from_euler(found.angles[:, branch], sequence) - R).max() <= 16 * EPS
    middle = found.angles[:, 0, 1]
    low, high = (0, pi) if known.symmetric else (-pi / 2, pi / 2)
    assert low <= middle.min() <= middle.max() <= high
    assert np.abs(found.angles).max() <= 3 * pi / 2
    positive = found.positive()
    assert 0 <= positive.min() <= positive.max() < 2 * pi
    assert turned(positive, found.angles).max() < 1e-14


@pytest.mark.capability("04-37", "04-39")
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_gimbal_locks_are_families(sequence: str):
    known = euler.SEQUENCES[sequence]
    for lock in LOCKS[known.symmetric]:
        R = rotation.from_euler([0.4, lock, -1.3], sequence)
        found = euler.solutions(R, sequence)
        assert found.locked
        leftmost = 2 if known.fixed else 0
        assert found.angles[0, leftmost] == 0
        assert found.angles[1, leftmost] == 0
        assert turned(found.angles[0, 1], lock) < 1e-7
        for t in np.linspace(-3, 3, 7):
            assert np.abs(rotation.from_euler(found.family(t), sequence) - R).max() <= 32 * EPS
        fixed_sum = 0.4 - 1.3 * (-1 if found.direction[2] > 0 else 1)
        principal = found.angles[0]
        assert turned(principal[0] + principal[2] * (-1 if found.direction[2] > 0 else 1), fixed_sum) < 1e-12


@pytest.mark.parametrize("sequence", SEQUENCES)
@pytest.mark.parametrize("distance", [0, 1e-17, 1e-16, 1e-15, 3e-15, 4e-15, 1e-14, 1e-12, 1e-9, 1e-8, 1e-7, 1e-4])
def test_no_digit_is_lost_near_a_gimbal_lock(sequence: str, distance: float):
    for lock in LOCKS[euler.SEQUENCES[sequence].symmetric]:
        for side in (-1, 1):
            R = rotation.from_euler([2.0, lock + side * distance, 0.7], sequence)
            again = rotation.from_euler(rotation.to_euler(R, sequence), sequence)
            assert np.abs(again - R).max() <= 24 * EPS


@pytest.mark.capability("04-34", "04-46", "04-49")
def test_closed_form_of_zyx_and_the_aircraft_value():
    a, b, c = 0.5, -0.3, 1.2
    ca, sa, cb, sb, cg, sg = np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(c), np.sin(c)
    closed = [
        [ca * cb, ca * sb * sg - sa * cg, ca * sb * cg + sa * sg],
        [sa * cb, sa * sb * sg + ca * cg, sa * sb * cg - ca * sg],
        [-sb, cb * sg, cb * cg],
    ]
    assert np.abs(rotation.from_euler([a, b, c], "ZYX") - closed).max() <= 2 * EPS
    # Vehicle axes: x forward, y along the wing, z down; roll 10, pitch 5, yaw 30 degrees.
    R = [
        [0.862729916, -0.479297071, 0.161156479],
        [0.498097349, 0.860435750, -0.107467908],
        [-0.087155743, 0.172987394, 0.981060262],
    ]
    assert np.abs(rotation.from_rpy(np.deg2rad([10, 5, 30])) - R).max() < 1e-9


@pytest.mark.capability("04-41")
def test_closed_form_of_zyz():
    a, b, c = 0.5, 0.8, 1.2
    ca, sa, cb, sb, cg, sg = np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(c), np.sin(c)
    closed = [
        [ca * cb * cg - sa * sg, -ca * cb * sg - sa * cg, ca * sb],
        [sa * cb * cg + ca * sg, -sa * cb * sg + ca * cg, sa * sb],
        [-sb * cg, sb * sg, cb],
    ]
    assert np.abs(rotation.from_euler([a, b, c], "ZYZ") - closed).max() <= 2 * EPS


@pytest.mark.capability("04-38")
def test_quadrants_and_wrapping():
    planar_angle = rotation.to_rpy(rotation.rot_z([pi / 4, -3 * pi / 4]))[:, 2]
    assert planar_angle == pytest.approx([pi / 4, -3 * pi / 4])
    assert euler.wrap_positive(planar_angle) == pytest.approx([pi / 4, 5 * pi / 4])
    assert euler.wrap_positive([-1e-300, 2 * pi, -2 * pi]).tolist() == [0, 0, 0]
    assert euler.wrap_symmetric([-pi, 3 * pi, 7.0]) == pytest.approx([pi, pi, 7 - 2 * pi])


@pytest.mark.capability("04-47")
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_fixed_and_moving_readings(sequence: str):
    angles = np.array([[0.1, 0.2, 0.3], [1.0, -2.0, 3.0]])
    R = rotation.from_euler(angles, sequence)
    for read in (euler.to_fixed, euler.to_moving):
        other, name = read(angles, sequence)
        assert np.abs(rotation.from_euler(other, name) - R).max() <= EPS
    assert euler.to_fixed(angles, "ZYX")[1] == "xyz"
    assert euler.to_moving(angles, "xyz")[1] == "ZYX"


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
@pytest.mark.capability("04-43")
def test_general_axis_triples(seed: int):
    rng = np.random.default_rng(seed)
    n2 = rng.standard_normal(3)
    n1, n3 = np.cross(n2, rng.standard_normal(3)), np.cross(n2, rng.standard_normal(3))
    axes = np.array([n / np.linalg.norm(n) for n in (n1, n2, n3)])
    if seed % 4 == 0:
        axes[2] = -axes[0]
    R = rotation.random(rng, (3, 1, 2))
    both = rotation.to_davenport(R, axes)
    assert both.shape == (3, 1, 2, 2, 3)
    for branch in (0, 1):
        assert np.abs(rotation.from_davenport(both[..., branch, :], axes) - R).max() <= 32 * EPS


@pytest.mark.capability("04-43")
def test_axis_triples_that_leave_orientations_out_are_refused():
    oblique = [[0, 0, 1], [0, 0.6, 0.8], [1, 0, 0]]
    with pytest.raises(InputError, match="cannot reach every orientation"):
        rotation.from_davenport([0.1, 0.2, 0.3], oblique)
    with pytest.raises(InputError, match="axes"):
        Wrist(((0, 0, 1), (0, 0.6, 0.8), (1, 0, 0)))


@pytest.mark.capability("04-44")
def test_every_sequence_is_a_case_of_the_general_triple():
    angles = np.array([0.4, 0.5, -0.6])
    for name, known in euler.SEQUENCES.items():
        ordered = angles[::-1] if known.fixed else angles
        general = rotation.from_davenport(ordered, np.eye(3)[list(known.body_axes)])
        assert np.abs(general - rotation.from_euler(angles, name)).max() <= 8 * EPS
    assert len(euler.SEQUENCES) == 24


@pytest.mark.capability("04-33", "04-39", "04-40", "04-41")
def test_wrist():
    wrist = Wrist.of_sequence("ZYX")
    angles = np.array([0.3, -0.5, 0.9])
    R_01, R_12, R_23 = wrist.link_rotations(angles)
    assert np.abs(R_01 - rotation.rot_z(0.3)).max() <= 2 * EPS
    assert np.abs(R_12 - rotation.rot_y(-0.5)).max() <= 2 * EPS
    assert np.abs(R_23 - rotation.rot_x(0.9)).max() <= 2 * EPS
    assert np.abs(wrist.rotation(angles) - R_01 @ R_12 @ R_23).max() <= 4 * EPS
    assert np.abs(wrist.rotation(np.zeros(3)) - np.eye(3)).max() == 0
    R = rotation.random(np.random.default_rng(2), (500,))
    for branch in (0, 1):
        assert np.abs(wrist.rotation(wrist.angles(R)[:, branch]) - R).max() <= 32 * EPS
    # The wrist at 90 degrees: axes 1 and 3 on one line, opposed, so that turning both alike changes nothing.
    locked = [wrist.rotation([0.3 + t, pi / 2, 0.9 + t]) for t in (0.0, 0.5, 2.0)]
    assert np.abs(np.array(locked) - locked[0]).max() <= 4 * EPS
    # ZYZ is the ZYX wrist with the zero of its middle joint moved by 90 degrees, seen from a tool turned back.
    moved = wrist.with_middle_zero(-pi / 2)
    zyz = rotation.from_euler([0.3, 0.4, 0.5], "ZYZ")
    assert np.abs(moved.rotation([0.3, 0.4, 0.5]) @ rotation.rot_y(pi / 2) - zyz).max() <= 8 * EPS
    assert min(turned(row, angles).max() for row in moved.angles(moved.rotation(angles))) < 1e-12


def test_rate_matrix_gives_the_angular_velocity():
    angles, rates, h = np.array([0.4, -0.3, 1.0]), np.array([0.2, 0.5, -0.7]), 1e-6
    for name in SEQUENCES:
        before, after = (rotation.from_euler(angles + sign * h * rates, name) for sign in (-1, 1))
        omega = rotation.vee((after - before) / (2 * h) @ rotation.inverse(rotation.from_euler(angles, name)))
        assert np.abs(euler.rates_to_angular_velocity(angles, name) @ rates - omega).max() < 1e-8


def test_small_pitch_keeps_its_digits():
    for pitch in (1e-9, 1e-15, 1e-200):
        assert rotation.to_rpy(rotation.rot_y(pitch))[1] == pytest.approx(pitch, rel=4 * EPS, abs=0)


def test_unknown_sequence_is_refused():
    with pytest.raises(InputError, match="ZYX"):
        rotation.from_euler([0, 0, 0], "ZZX")
    with pytest.raises(ValueError, match="0, 0, 1"):
        euler.EulerSequence((0, 0, 1), True)
