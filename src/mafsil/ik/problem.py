"""Inverse kinematics as equations: poses that are poses, joint bounds, errors and Jacobians, a bound of reach."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil import kernels
from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.kernels import Kernel, Port, Signature
from mafsil.kernels.lazy import lazy
from mafsil.model import Joint, JointKind, Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.robot import Robot

ORTHOGONALITY = 1e-6
"""Largest |R'R - I| that is taken for rounding of a printed matrix and repaired."""

RELATIVE_DAMPING = 0.02
"""Damping relative to the squared error norm. Small enough for long steps, which also leave poor valleys."""

SMALLEST_DAMPING = 1e-14
"""Keeps the factorisation regular at singular poses without slowing the last steps elsewhere."""


@dataclass(frozen=True, eq=False)
class PoseProblem:
    """Find q with T_sf(q) = T_sd for many poses of one frame.

    Attributes:
        robot: whose joints are sought.
        frame: name of the link, or None for the tip.
        lower, upper: (n,) bounds, infinite for joints without [rad | m].
        length: scale that makes positions comparable with angles [m].
    """

    robot: Robot
    frame: str | None
    lower: Floats
    upper: Floats
    length: float

    @property
    def bounded(self) -> bool:
        """Whether any joint has a bound."""
        return bool(np.isfinite(self.lower).any() or np.isfinite(self.upper).any())

    @property
    def middle(self) -> JointVector:
        """(n,) the middle of the bounds, zero where one is missing."""
        both = np.isfinite(self.lower) & np.isfinite(self.upper)
        return np.where(both, (np.where(both, self.lower, 0.0) + np.where(both, self.upper, 0.0)) / 2, 0.0)

    def unbounded(self) -> PoseProblem:
        """The same without bounds."""
        return replace(self, lower=np.full_like(self.lower, -np.inf), upper=np.full_like(self.upper, np.inf))

    def poses(self, q: JointVector) -> PoseMatrix:
        """(k, 4, 4) poses of the frame."""
        if self.frame is None:
            return self.robot.forward_kinematics(q)
        return self.robot.forward_kinematics(q, frame=self.frame)

    def jacobians(self, q: JointVector) -> Floats:
        """(k, 6, n) body Jacobians of the frame."""
        if self.frame is None:
            return self.robot.jacobian_body(q)
        return self.robot.jacobian_body(q, frame=self.frame)

    def errors(self, q: JointVector, T_sd: PoseMatrix) -> Floats:
        """(k, 6) body twists log(T_sf^-1 T_sd) that lead to the wanted poses in unit time."""
        return pose.error(self.poses(q), T_sd)

    def stepped(self, q: JointVector, T_sd: PoseMatrix) -> tuple[JointVector, Floats]:
        """(k, n) after one bounded damped step from q, and (k, 6) errors at q itself, by one kernel."""
        table = self._step.ufunc(q, T_sd, self.lower, self.upper, self.length)
        return table[:, : self.robot.n], table[:, self.robot.n :]

    @lazy
    def _step(self) -> Kernel:
        return _step_kernel(self.robot.mechanism, self.frame)

    def sample(self, generator: np.random.Generator, count: int) -> JointVector:
        """(count, n) uniform configurations within the bounds; within a turn, or the length, where there are none."""
        sliding = [joint.kind is JointKind.PRISMATIC for joint in self.robot.mechanism.coordinates]
        span = np.where(sliding, self.length, np.pi)
        lower = np.where(np.isfinite(self.lower), self.lower, np.minimum(-span, self.upper - 2 * span))
        upper = np.where(np.isfinite(self.upper), self.upper, np.maximum(span, self.lower + 2 * span))
        return generator.uniform(lower, upper, (count, self.robot.n))

    def clipped(self, q: JointVector) -> JointVector:
        """The nearest configuration within the bounds."""
        return np.clip(q, self.lower, self.upper)

    def wound(self, q: JointVector, near: JointVector) -> JointVector:
        """Turning joints moved by whole turns as close to `near` as their bounds allow."""
        turning = np.array([joint.kind is JointKind.REVOLUTE for joint in self.robot.mechanism.coordinates])
        turns = np.where(turning, 2 * np.pi * np.round((q - near) / (2 * np.pi)), 0.0)
        moved = q - turns
        return np.where((moved >= self.lower) & (moved <= self.upper), moved, q)


@lru_cache(maxsize=64)
def _step_kernel(mechanism: Mechanism, frame: str | None) -> Kernel:
    n = mechanism.n
    inputs = (Port("q", (n,)), Port("T_sd", (4, 4)), Port("lower", (n,)), Port("upper", (n,)), Port("length"))
    return kernels.compile(
        Signature("pose_step", inputs, (Port("step", (n + 6,)),)),
        partial(_build_step, mechanism, frame),
        key=f"{fingerprint(mechanism)} pose_step {frame!r} {RELATIVE_DAMPING} {SMALLEST_DAMPING}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
        recipe=(_step_kernel, (mechanism, frame)),
    )


def _build_step(mechanism: Mechanism, frame: str | None) -> Any:
    """The casadi.Function; CasADi is loaded only when a kernel has to be made."""
    from mafsil.mechanics.pose_step import function

    return function(mechanism, frame, RELATIVE_DAMPING, SMALLEST_DAMPING)


def clean_poses(T: PoseMatrix) -> tuple[PoseMatrix, NDArray[np.bool_]]:
    """Poses with their rotations brought to working precision, and which rows were poses at all.

    Args:
        T: (k, 4, 4).

    Returns:
        (k, 4, 4), identity in rows that are no poses, and (k,).
    """
    R = T[:, :3, :3]
    with np.errstate(invalid="ignore", over="ignore"):
        defect = np.abs(R.transpose(0, 2, 1) @ R - np.eye(3)).max(axis=(1, 2), initial=0.0)
        proper = np.linalg.det(np.where(np.isfinite(R), R, 0.0)) > 0.0
        ends = np.abs(T[:, 3] - np.array([0.0, 0.0, 0.0, 1.0])).max(axis=1, initial=0.0)
        valid = (defect <= ORTHOGONALITY) & proper & (ends <= ORTHOGONALITY) & np.isfinite(T[:, :3, 3]).all(axis=1)
    clean = np.where(valid[:, None, None], T, np.eye(4))
    R = clean[:, :3, :3]
    for _ in range(2):
        # Newton's iteration for the polar factor: the defect is squared each time.
        R = R @ (1.5 * np.eye(3) - 0.5 * (R.transpose(0, 2, 1) @ R))
    clean[:, :3, :3] = R
    clean[:, 3] = [0.0, 0.0, 0.0, 1.0]
    return clean, valid


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
