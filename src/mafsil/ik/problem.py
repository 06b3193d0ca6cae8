"""What can be said of requested poses before any search: whether they are poses, and whether they are out of reach."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, PoseMatrix, require_finite
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import FARTHEST as FARTHEST
from mafsil.mechanics.arm_pattern import ORTHOGONALITY as ORTHOGONALITY
from mafsil.model import Joint, JointKind, Mechanism

if TYPE_CHECKING:
    import mafsil.geometry.membership as membership
    import mafsil.geometry.pose as pose
else:
    membership = lazily("mafsil.geometry.membership")
    pose = lazily("mafsil.geometry.pose")

ROUNDING = 1e-15
"""The same, of matrices that need no repair."""
_EYE: Floats = np.eye(3)


def clean_poses(T: PoseMatrix) -> tuple[PoseMatrix, NDArray[np.bool_]]:
    """Poses with their rotations brought to working precision, and which rows were poses at all.

    Args:
        T: (k, 4, 4).

    Returns:
        (k, 4, 4), identity in rows that are no poses, and (k,).
    """
    if len(T) == 1 and (defect := _defect(T[0])) <= ORTHOGONALITY:
        clean = np.array(T, dtype=np.float64)
        if defect > ROUNDING:
            clean[:, :3, :3] = _orthogonal(clean[:, :3, :3])
        clean[:, 3] = [0.0, 0.0, 0.0, 1.0]
        return clean, np.ones(1, dtype=np.bool_)
    with np.errstate(invalid="ignore", over="ignore"):
        x, y, z, p = np.ascontiguousarray(T[:, :3].transpose(2, 1, 0))
        lengths = [np.abs((v * v).sum(axis=0) - 1.0) for v in (x, y, z)]
        leans = [np.abs((v * w).sum(axis=0)) for v, w in ((x, y), (y, z), (z, x))]
        defect = np.max([*lengths, *leans], axis=0)
        proper = (x * np.cross(y, z, axis=0)).sum(axis=0) > 0.0
        ends = np.abs(T[:, 3] - np.array([0.0, 0.0, 0.0, 1.0])).max(axis=1, initial=0.0)
        valid = (defect <= ORTHOGONALITY) & proper & (ends <= ORTHOGONALITY) & (np.abs(p) < FARTHEST).all(axis=0)
    clean = np.where(valid[:, None, None], T, np.eye(4))
    rough = np.flatnonzero(valid & (defect > ROUNDING))
    if len(rough):
        clean[rough, :3, :3] = _orthogonal(clean[rough, :3, :3])
    clean[:, 3] = [0.0, 0.0, 0.0, 1.0]
    return clean, valid


def printed_pose(name: str, T: PoseMatrix) -> PoseMatrix:
    """The pose that a matrix was before it was printed with few digits.

    Args:
        name: of the argument.
        T: (*batch, 4, 4).

    Raises:
        InputError: it is none even so; names the row, its distance and the likely cause.

    Warns:
        InputWarning: of the digits that were left out.
    """
    largest = float(np.abs(require_finite(name, T)).max())
    if largest >= FARTHEST:
        raise InputError("ik.farthest", name=name, value=largest, limit=FARTHEST)
    return pose.project(membership.require("pose", name, T))


def _orthogonal(R: Floats) -> Floats:
    """(k, 3, 3) nearly orthogonal matrices made so: each Newton step for the polar factor squares the defect."""
    for _ in range(2):
        R = R @ (1.5 * _EYE - 0.5 * (R.transpose(0, 2, 1) @ R))
    return R


def _defect(T: PoseMatrix) -> float:
    """How far one matrix is from a pose, infinite of what is none; plain Python is quicker for so few numbers."""
    (a, b, c, p), (d, e, f, q), (g, h, i, r), (*low, one) = T.tolist()
    defects = (
        a * a + d * d + g * g - 1.0, b * b + e * e + h * h - 1.0, c * c + f * f + i * i - 1.0,
        a * b + d * e + g * h, b * c + e * f + h * i, c * a + f * d + i * g, *low, one - 1.0,
    )  # fmt: skip
    # Comparisons with NaN are false: what is no number has no defect that could be mended.
    if not all(-ORTHOGONALITY <= defect <= ORTHOGONALITY for defect in defects):
        return inf
    proper = a * (e * i - h * f) + d * (h * c - b * i) + g * (b * f - e * c) > 0.0
    if not (proper and abs(p) < FARTHEST and abs(q) < FARTHEST and abs(r) < FARTHEST):
        return inf
    return max(map(abs, defects[:6]))


def reach_bound(mechanism: Mechanism, frame: str | None) -> tuple[Floats, float]:
    """A sphere that the origin of a frame cannot leave.

    The centre is the origin of the first moving joint; the radius is the sum of the distances between consecutive
    joints on the way to the frame, with the strokes of prismatic and helical joints (infinite if unlimited).

    Returns:
        (3,) centre in {s} [m], and radius [m].
    """
    carrier = {joint.child: joint for joint in mechanism.joints}
    link = mechanism.tip if frame is None else frame
    path: list[Joint] = []
    while link in carrier:
        path.insert(0, carrier[link])
        link = path[0].parent
    T = np.asarray(mechanism.T_sb)
    while path and not path[0].moves:
        T = T @ path.pop(0).T_pj
    if not path:
        return (T @ (mechanism.T_lt if frame is None else np.eye(4)))[:3, 3], 0.0
    radius = _stroke(path[0]) + sum(float(np.linalg.norm(joint.T_pj[:3, 3])) + _stroke(joint) for joint in path[1:])
    last = float(np.linalg.norm(mechanism.T_lt[:3, 3])) if frame is None else 0.0
    return (T @ path[0].T_pj)[:3, 3], radius + last


def _stroke(joint: Joint) -> float:
    """Largest distance that a joint moves its child's origin along its axis [m]."""
    if joint.kind in (JointKind.REVOLUTE, JointKind.FIXED):
        return 0.0
    if joint.mimic is not None:
        return float("inf")
    per_unit = 1.0 if joint.kind is JointKind.PRISMATIC else abs(joint.pitch)
    return per_unit * max(abs(joint.limits.lower), abs(joint.limits.upper))
