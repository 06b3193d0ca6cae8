"""Arms with a spherical shoulder, an elbow and a spherical wrist: eight postures for every arm angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector
from mafsil.geometry import pose
from mafsil.ik.chain import Chain, common_point

EXACT = 1e-9
"""Misfit of axes that should meet or be normal to each other that counts as rounding [rad, relative to the size]."""


@dataclass(frozen=True, eq=False)
class ArmAngleForm:
    """All postures of an S-R-S arm with seven joints by its arm angle.

    The arm angle is that of the elbow about the line from shoulder to wrist, from the side to which the first axis
    points; where the first axis runs along that line, from the home direction of the second axis instead.

    Attributes:
        chain: of the arm.
        shoulder, elbow, wrist: (3,) at q = 0; the elbow is the point of axis 4 nearest to the shoulder [m].
    """

    chain: Chain
    shoulder: Floats
    elbow: Floats
    wrist: Floats

    def solve(self, T: ArrayLike, angle: ArrayLike) -> JointVector:
        """(*batch, m, 8, 7) postures, elbow, shoulder and wrist each with its two roots; NaN where out of reach.

        Args:
            T: (*batch, 4, 4) poses of the tip in {s}.
            angle: (*batch, m) arm angles [rad].
        """
        from mafsil.ik.redundant.arm_angle_loops import BRANCHES, postures

        X, psi = np.asarray(T, dtype=np.float64), np.asarray(angle, dtype=np.float64)
        batch = np.broadcast_shapes(X.shape[:-2], psi.shape[:-1])
        count, m = int(np.prod(batch)), psi.shape[-1]
        P = np.ascontiguousarray(np.broadcast_to(X @ pose.inverse(self.chain.home), (*batch, 4, 4))).reshape(
            count, 4, 4
        )
        angles = np.ascontiguousarray(np.broadcast_to(psi, (*batch, m))).reshape(count, m)
        q = np.empty((*angles.shape, BRANCHES, 7))
        axes = np.ascontiguousarray(self.chain.axes)
        frames = np.array([_frame(axes[:3]), _frame(axes[4:])])
        turns = np.array([_turn(axes[:3]), _turn(axes[4:])])
        places = np.array([self.shoulder, self.elbow, self.wrist])
        postures(P, angles, axes, places, np.ascontiguousarray(axes[:2]), frames, turns, q)
        return q.reshape(*batch, m, BRANCHES, 7)

    def angle(self, q: ArrayLike) -> Floats:
        """(*batch,) arm angle of configurations (*batch, 7), in (-pi, pi] [rad]; NaN if the elbow is straight."""
        x = np.asarray(q, dtype=np.float64)
        E = [pose.exp(self.chain.screws[k] * x[..., k, None]) for k in range(4)]
        before = E[0] @ E[1] @ E[2]
        elbow = _applied(before, self.elbow)
        wrist = _applied(before @ E[3], self.wrist)
        w = wrist - self.shoulder
        w = w / np.linalg.norm(w, axis=-1, keepdims=True)
        along = np.linalg.norm(np.cross(w, self.chain.axes[0]), axis=-1) < 1e-9
        up = np.where(along[..., None], self.chain.axes[1], self.chain.axes[0])
        reference, side = _across(up, w), _across(elbow - self.shoulder, w)
        straight = np.linalg.norm(side, axis=-1) < 1e-12
        found = np.arctan2((np.cross(reference, side) * w).sum(-1), (reference * side).sum(-1))
        return np.where(straight, np.nan, found)


def arm_angle_form(chain: Chain) -> ArmAngleForm | None:
    """The arm angle form of a chain; None unless seven joints turn and shoulder and wrist are spherical, orthogonal."""
    if len(chain) != 7 or any(chain.slides):
        return None
    size = chain.size
    ends: list[Floats] = []
    for part in (slice(0, 3), slice(4, 7)):
        axes = chain.axes[part]
        place, miss = common_point(axes, chain.points[part])
        if not miss <= EXACT * size or max(abs(axes[0] @ axes[1]), abs(axes[1] @ axes[2])) > EXACT:
            return None
        ends.append(place)
    w, r = chain.axes[3], chain.points[3]
    elbow = r + w * (w @ (ends[0] - r))
    offsets = [np.linalg.norm(np.cross(w, place - r)) for place in ends]
    if min(offsets) < 1e-6 * size:
        return None
    return ArmAngleForm(chain, ends[0], elbow, ends[1])


def _frame(axes: Floats) -> Floats:
    """(3, 3) z along the first axis, y along the second."""
    y = axes[1] - (axes[1] @ axes[0]) * axes[0]
    y = y / np.linalg.norm(y)
    return np.ascontiguousarray(np.stack([np.cross(y, axes[0]), y, axes[0]], axis=1))


def _turn(axes: Floats) -> float:
    """Angle from the first to the third axis about the second."""
    return float(np.arctan2(axes[1] @ np.cross(axes[0], axes[2]), axes[0] @ axes[2]))


def _applied(T: Floats, p: Floats) -> Floats:
    return T[..., :3, :3] @ p + T[..., :3, 3]


def _across(v: Floats, w: Floats) -> Floats:
    return v - (v * w).sum(-1, keepdims=True) * w
