"""Poses, rotations and quaternions as NumPy and MATLAB print them: three to five digits, mended with one warning."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.algebra.tolerance import PRINTED
from mafsil.errors import InputWarning, MafsilError
from mafsil.geometry import membership, pose, rotation

UR5E, PANDA = mf.load("ur5e"), mf.load("panda")
Q = np.array([0.1, -1.0, 1.0, 0.2, 0.3, 0.4])
T = UR5E.forward_kinematics(Q)
TAKERS = {
    "Pose": lambda X: mf.Pose(X).array,
    "Rotation": lambda X: mf.Rotation(X[:3, :3]).array,
    "log": lambda X: pose.exp(pose.log(X)),
    "inverse_kinematics": lambda X: UR5E.forward_kinematics(mf.inverse_kinematics(UR5E, X).q[0]),
    "a batch of inverse_kinematics": lambda X: UR5E.forward_kinematics(mf.inverse_kinematics(UR5E, [X, T]).q[0, 0]),
    "solve_ik": lambda X: UR5E.forward_kinematics(mf.solve_ik(UR5E, X, q0=Q).q),
    "a batch of solve_ik": lambda X: UR5E.forward_kinematics(mf.solve_ik(UR5E, [T, X]).q[1]),
    "an arm of seven joints": lambda X: PANDA.forward_kinematics(mf.inverse_kinematics(PANDA, X).q[0]),
    "track": lambda X: UR5E.forward_kinematics(mf.ik.track(UR5E, [X, X], Q).q[-1]),
    "with_tool": lambda X: np.asarray(UR5E.with_tool(X).mechanism.T_lt),
    "line_path": lambda X: mf.trajectory.line_path(X, T).poses(0.0),
}


@pytest.mark.parametrize("digits", [3, 4, 5])
@pytest.mark.parametrize("taker", TAKERS)
def test_printed_poses_are_taken_with_a_warning_that_names_the_distance(taker: str, digits: int) -> None:
    printed = np.round(T, digits)
    distance = float(membership.measure("pose", printed))
    with pytest.warns(InputWarning, match=f"{distance:.2g}"):
        taken = TAKERS[taker](printed)
    if taken.shape == T.shape:
        np.testing.assert_allclose(taken[:3, :3], rotation.project(printed[:3, :3]), atol=1e-7)
    assert float(membership.measure("rotation", taken[:3, :3])) < 1e-6


def test_every_rotation_of_three_digits_is_mended() -> None:
    """The limit holds for all, and what is mended is the nearest rotation."""
    R = np.round(mf.Rotation.random(0, 20000).array, 3)
    assert float(membership.measure("rotation", R).max()) < PRINTED
    with pytest.warns(InputWarning):
        np.testing.assert_allclose(rotation.check(R), rotation.project(R), atol=1e-12)
    q = np.round(rotation.to_quaternion(mf.Rotation.random(1, 20000).array), 3)
    with pytest.warns(InputWarning):
        made = membership.require("unit_quaternion", "q", q)
    np.testing.assert_allclose(np.linalg.norm(made, axis=1), 1.0, atol=2e-6)


MIRROR, SHEARED = np.diag([1.0, 1.0, -1.0, 1.0]), np.eye(4)
SHEARED[0, 1] = 0.3
WRONG = {
    "transpose it": T.T,
    "right-handed": T @ MIRROR,
    "length 1000": np.block([[1000.0 * T[:3, :3], T[:3, 3:]], [np.zeros(3), 1.0]]),
    r"norm of R'R - I of its rotation is 0.434": SHEARED,
    "last row": np.ones((4, 4)),
    "not a finite number": np.full((4, 4), np.nan),
}


@pytest.mark.parametrize("words", WRONG)
def test_what_no_printing_explains_is_refused_with_its_likely_cause(words: str) -> None:
    for taker in (mf.Pose, lambda X: mf.inverse_kinematics(UR5E, X), lambda X: mf.solve_ik(UR5E, X), UR5E.with_tool):
        with pytest.raises(MafsilError, match=words):
            taker(WRONG[words])


@pytest.mark.parametrize("kind", [mf.Pose, mf.Rotation, mf.Twist, mf.Wrench, mf.ScrewAxis])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_values_refuse_what_is_not_finite(kind, value: float) -> None:
    whole = {mf.Pose: np.eye(4), mf.Rotation: np.eye(3)}.get(kind, np.array([0.0, 0, 1, 0, 0, 0]))
    whole = whole.copy()
    whole[(0, -1) if whole.ndim == 2 else 3] = value
    with pytest.raises(MafsilError):
        kind(whole)
