"""Arms with a spherical shoulder, an elbow and a spherical wrist: eight configurations for every arm angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.ik.answers.setting import FAR, turns_of
from mafsil.ik.chain import Chain, common_point
from mafsil.ik.redundant.parametric_form import ParametricForm, form_of_pattern
from mafsil.ik.tolerances import COINCIDENT, DEFECT, EXACT_POSE
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.arm_pattern import ArmAnglePattern

_ANGLES: Floats = 2 * np.pi / 3 * np.arange(3.0)

THIRDS: Floats = np.stack([np.ones(3), 2 * np.cos(_ANGLES), 2 * np.sin(_ANGLES)]) / 3
"""From values at three thirds of a turn to a, b and c of a + b cos + c sin."""

_ZERO, _WIDE, _UNTURNED = np.zeros(7), np.full(7, FAR), turns_of(np.zeros(7))


@dataclass(frozen=True, eq=False)
class ArmAngleForm:
    """All configurations of an S-R-S arm with seven joints by its arm angle.

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

    @lazy
    def kernels(self) -> ParametricForm:
        """Of poses and arm angles to configurations."""
        chain = self.chain
        pattern = ArmAnglePattern(np.array(chain.axes), chain.home, self.shoulder, self.elbow, self.wrist)
        return form_of_pattern(pattern)

    def solve(self, T: ArrayLike, angle: ArrayLike) -> JointVector:
        """(*batch, m, 8, 7) configurations, elbow, shoulder and wrist each with its two roots; NaN where out of reach.

        Args:
            T: (*batch, 4, 4) poses of the tip in {s}.
            angle: (*batch, m) arm angles [rad].
        """
        X, psi = np.asarray(T, dtype=np.float64), np.asarray(angle, dtype=np.float64)
        return self.kernels.configurations(X[..., None, :, :], psi[..., None], _ZERO, _UNTURNED, -_WIDE, _WIDE, np.inf)[
            0
        ]

    def breaks(self, T: PoseMatrix, lower: Floats, upper: Floats) -> list[Floats]:
        """Of each elbow all arm angles at which a configuration of one pose may come within the limits or leave them.

        The rotations of shoulder and wrist are A + B cos + C sin of the arm angle, so a joint is at its limit where
        a + b cos + c sin = 0: at most two angles. Where the middle joint of three stands still for a moment, its
        neighbours may leap: these angles are given too.

        Args:
            T: (4, 4) pose of the tip in {s}.
            lower, upper: (7,) limits [rad].

        Returns:
            Of both elbows angles in [-pi, pi), in order; without any where the elbow cannot be made.
        """
        configurations = self.solve(T, _ANGLES)
        return [self._breaks(configurations[:, 4 * elbow], lower, upper) for elbow in range(2)]

    def _breaks(self, q: JointVector, lower: Floats, upper: Floats) -> Floats:
        """Of one elbow, from its configurations at three arm angles."""
        if not np.isfinite(q).all():
            return np.zeros(0)
        found: list[Floats] = []
        for first in (0, 4):
            axes = self.chain.axes[first : first + 3]
            frame, turn = _frame(axes), _turn(axes)
            E = [pose.exp(self.chain.screws[k] * q[:, k, None])[:, :3, :3] for k in range(first, first + 3)]
            Q = frame.T @ E[0] @ E[1] @ E[2] @ frame @ _about_y(turn)
            a, b, c = (_wave(Q, weights) for weights in THIRDS)
            # The middle joint is least or most bent.
            still = float(np.arctan2(c[2, 2], b[2, 2]))
            found.append(np.array([still, still + np.pi], dtype=np.float64))
            for k, limits in enumerate(zip(lower[first : first + 3], upper[first : first + 3], strict=True)):
                for limit in limits:
                    if np.isfinite(limit):
                        weights = _at_limit(k, float(limit))
                        total = [float((weights * x).sum()) for x in (a, b, c)]
                        found.append(_zeros(total[0] - (np.cos(limit + turn) if k == 1 else 0.0), *total[1:]))
        return np.sort((np.concatenate(found) + np.pi) % (2 * np.pi) - np.pi)

    def angle(self, q: ArrayLike) -> Floats:
        """(*batch,) arm angle of configurations (*batch, 7), in (-pi, pi] [rad]; NaN if the elbow is straight."""
        x = np.asarray(q, dtype=np.float64)
        E = [pose.exp(self.chain.screws[k] * x[..., k, None]) for k in range(4)]
        before = E[0] @ E[1] @ E[2]
        elbow = _apply(before, self.elbow)
        wrist = _apply(before @ E[3], self.wrist)
        w = wrist - self.shoulder
        w = w / np.linalg.norm(w, axis=-1, keepdims=True)
        along = np.linalg.norm(np.cross(w, self.chain.axes[0]), axis=-1) < DEFECT
        up = np.asarray(np.where(along[..., None], self.chain.axes[1], self.chain.axes[0]), dtype=np.float64)
        reference, side = _across(up, w), _across(elbow - self.shoulder, w)
        straight = np.linalg.norm(side, axis=-1) < EXACT_POSE
        found = np.arctan2((np.cross(reference, side) * w).sum(-1), (reference * side).sum(-1))
        return np.where(straight, np.nan, found)


def arm_angle_form(chain: Chain) -> ArmAngleForm | None:
    """The arm angle form of a chain; None unless seven joints turn and shoulder and wrist are spherical, orthogonal."""
    if len(chain) != 7 or any(chain.prismatic):
        return None
    size = chain.size
    ends: list[Floats] = []
    for part in (slice(0, 3), slice(4, 7)):
        axes = chain.axes[part]
        place, distance = common_point(axes, chain.points[part])
        if not distance <= DEFECT * size or max(abs(axes[0] @ axes[1]), abs(axes[1] @ axes[2])) > DEFECT:
            return None
        ends.append(place)
    w, r = chain.axes[3], chain.points[3]
    elbow = r + w * (w @ (ends[0] - r))
    offsets = [np.linalg.norm(np.cross(w, place - r)) for place in ends]
    if min(offsets) < COINCIDENT * size:
        return None
    return ArmAngleForm(chain, ends[0], elbow, ends[1])


def _frame(axes: Floats) -> Floats:
    """(3, 3) z along the first axis, y along the second."""
    y = axes[1] - (axes[1] @ axes[0]) * axes[0]
    y = y / np.linalg.norm(y)
    x = np.asarray(np.cross(y, axes[0]), dtype=np.float64)
    return np.ascontiguousarray(np.stack([x, y, axes[0]], axis=1))


def _turn(axes: Floats) -> float:
    """Angle from the first to the third axis about the second."""
    return float(np.arctan2(axes[1] @ np.cross(axes[0], axes[2]), axes[0] @ axes[2]))


def _about_y(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _wave(Q: Floats, weights: Floats) -> Floats:
    """(3, 3) sum of matrices at three thirds of a turn, weighted by cosine or sine."""
    return np.asarray((Q * weights[:, None, None]).sum(axis=0), dtype=np.float64)


def _at_limit(k: int, limit: float) -> Floats:
    """(3, 3) weights of the elements of Rot(z, a) Rot(y, b) Rot(z, c): their sum is zero, or cos b, at a limit of one.

    Args:
        k: which of the three.
        limit: its value [rad].
    """
    weights, c, s = np.zeros((3, 3)), np.cos(limit), np.sin(limit)
    if k == 0:
        weights[1, 2], weights[0, 2] = c, -s
    elif k == 2:
        weights[2, 1], weights[2, 0] = c, s
    else:
        weights[2, 2] = 1.0
    return weights


def _zeros(a: float, b: float, c: float) -> Floats:
    """Where a + b cos + c sin vanishes: none or two angles; both are the extremum where it nearly touches."""
    size = float(np.hypot(b, c))
    if not abs(a) <= size * (1 + DEFECT):
        return np.zeros(0)
    opening = np.arccos(np.clip(-a / size, -1.0, 1.0)) if size > 0.0 else 0.0
    return np.arctan2(c, b) + np.array([-opening, opening])


def _apply(T: Floats, p: Floats) -> Floats:
    return T[..., :3, :3] @ p + T[..., :3, 3]


def _across(v: Floats, w: Floats) -> Floats:
    return v - (v * w).sum(-1, keepdims=True) * w
