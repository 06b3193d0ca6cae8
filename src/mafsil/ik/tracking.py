"""Along a path of poses: the same branch as long as it lasts, every switch named."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, gate
from mafsil.ik.inverse import inverse_kinematics
from mafsil.ik.refine import refined
from mafsil.messages import say
from mafsil.robot import Robot


@dataclass(frozen=True, eq=False)
class Switch:
    """A place where the branch could not be kept.

    Attributes:
        index: sample of the path.
        jump: (n,) change of the coordinates there [rad | m].
        conditioning: of the posture before: near zero, the branch ended at a singular posture.
        reason: `limit` or `singular`.
        joint: the joint that would have left its limits, or that jumps most.
    """

    index: int
    jump: JointVector
    conditioning: float
    reason: str
    joint: str

    def explain(self, language: str | None = None) -> str:
        """The switch in a sentence."""
        facts = {"index": self.index, "joint": self.joint, "jump": float(np.abs(self.jump).max())}
        return say(f"ik.switch_{self.reason}", language=language, **facts, conditioning=self.conditioning)


@dataclass(frozen=True, eq=False)
class Track:
    """Joint path along a path of poses.

    Attributes:
        q: (k, n) coordinates; rows after the last pose that could be reached are NaN.
        residual: (k,) larger of position and rotation error [m | rad].
        switches: where the branch was left.
        reached: number of poses reached, from the first on.
    """

    q: JointVector
    residual: Floats
    switches: tuple[Switch, ...]
    reached: int

    @property
    def continuous(self) -> bool:
        """Whether the whole path was followed on one branch."""
        return self.reached == len(self.q) and not self.switches


def track(
    robot: Robot, T_path: ArrayLike, start: ArrayLike, *, tolerance: float = 1e-9, largest_step: float = 0.5
) -> Track:
    """Joint coordinates along a path of poses, each from the one before.

    Every pose is reached by Newton's method from the coordinates before it, with steps of least norm, so that the
    branch is kept. Where that fails, jumps, or leaves the limits, the nearest of all other solutions is taken, and the
    switch is named.

    Args:
        robot: any arm.
        T_path: (k, 4, 4) poses of the tip in {s}.
        start: (n,) coordinates near the first pose.
        tolerance: largest residual [m | rad].
        largest_step: change of a coordinate between neighbours that counts as a jump [rad | m].

    Raises:
        InputError: wrong shapes, numbers that are not finite.
    """
    poses = gate("T_path", T_path, (4, 4), finite=True).reshape(-1, 4, 4)
    q = gate("start", start, (robot.n,), finite=True)
    rows = np.full((len(poses), robot.n), np.nan)
    residual = np.full(len(poses), np.nan)
    switches: list[Switch] = []
    whole = np.ones(6, dtype=np.bool_)
    for k, T in enumerate(poses):
        found, size = refined(robot, q[None], T, whole, None, steps=12)
        new, error = found[0], float(size[0])
        jumps = bool(np.abs(new - q).max() > largest_step) and k > 0
        outside = (new < robot.limits.lower - 1e-12) | (new > robot.limits.upper + 1e-12)
        if error > tolerance or jumps or outside.any():
            others = inverse_kinematics(robot, T, near=q, tolerance=tolerance)
            if not others:
                break
            new = others.nearest(q)
            error = float(others.residual.max())
            if k > 0 and np.abs(new - q).max() > largest_step:
                switches.append(_switch(robot, k, q, new, outside))
        rows[k], residual[k], q = new, error, new
    reached = int(np.isfinite(residual).sum())
    return Track(rows, residual, tuple(switches), reached)


def _switch(robot: Robot, index: int, q: JointVector, new: JointVector, outside: ArrayLike) -> Switch:
    left = np.asarray(outside)
    values = np.linalg.svd(robot.jacobian_body(q), compute_uv=False)
    j = int(left.argmax()) if left.any() else int(np.abs(new - q).argmax())
    reason = "limit" if left.any() else "singular"
    return Switch(index, new - q, float(values[min(6, robot.n) - 1] / values[0]), reason, robot.joint_names[j])
