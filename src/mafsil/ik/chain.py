"""The joints between base and tip as lines in space: what recognition and closed forms look at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.geometry import pose
from mafsil.ik.tolerances import NO_EXTENT, TYPED_ZERO
from mafsil.model import JointKind, Mechanism
from mafsil.model.dh_from_axes import screws
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.mechanism import JointLimits


@dataclass(frozen=True, eq=False)
class Chain:
    """An open chain exp(S_1 q_1) ... exp(S_m q_m) home of revolute and prismatic joints.

    Attributes:
        axes: (m, 3) unit directions at q = 0, in {s}.
        points: (m, 3) the point of each axis nearest to the origin [m]; zero for prismatic joints.
        prismatic: (m) whether the joint is prismatic.
        joints: (m) coordinate of the robot; -1 an added joint that must stand still, -2 one that may turn.
        home: (4, 4) pose of the tip at q = 0.
        reversed: the chain is seen from the tip.
    """

    axes: Floats
    points: Floats
    prismatic: tuple[bool, ...]
    joints: tuple[int, ...]
    home: PoseMatrix
    reversed: bool = False

    def __len__(self) -> int:
        return len(self.prismatic)

    @property
    def screws(self) -> Floats:
        """(m, 6) screw axes in {s}."""
        moment = np.cross(self.points, self.axes)
        revolute = ~np.array(self.prismatic, dtype=np.bool_)[:, None]
        return np.concatenate([self.axes * revolute, np.where(revolute, moment, self.axes)], axis=1)

    @property
    def size(self) -> float:
        """A length of the arm [m]: the widest extent of its axes and tip, one if it has none."""
        places = np.concatenate([self.points[~np.array(self.prismatic, dtype=np.bool_)], self.home[None, :3, 3]])
        extent = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
        return extent if extent > NO_EXTENT else 1.0

    def length_without(self, k: int, limits: JointLimits) -> float:
        """How far the tip may come from the origin while joint k, a prismatic joint, is at zero [m].

        Args:
            k: place of the joint.
            limits: of the robot's coordinates.
        """
        revolute = ~np.array(self.prismatic, dtype=np.bool_)
        places = np.concatenate([np.zeros((1, 3)), self.points[revolute], self.home[None, :3, 3]])
        total = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
        for i, joint in enumerate(self.joints):
            if self.prismatic[i] and i != k and joint >= 0:
                total += float(max(abs(limits.lower[joint]), abs(limits.upper[joint])))
        return total if np.isfinite(total) else 1e3 * self.size

    def backwards(self) -> Chain:
        """The chain of the inverse motion: exp(-S_m q_m) ... exp(-S_1 q_1)."""
        return Chain(
            -self.axes[::-1], self.points[::-1], self.prismatic[::-1], self.joints[::-1], self.home, not self.reversed
        )

    def with_joint(
        self, axis: Vector3, point: Vector3, *, prismatic: bool = False, joint: int = -1, at: int = -1
    ) -> Chain:
        """The chain with an added joint, at the end unless said otherwise."""
        k = len(self) if at < 0 else at
        return Chain(
            np.insert(self.axes, k, np.asarray(axis) / np.linalg.norm(axis), axis=0),
            np.insert(self.points, k, point, axis=0),
            (*self.prismatic[:k], prismatic, *self.prismatic[k:]),
            (*self.joints[:k], joint, *self.joints[k:]),
            self.home,
            self.reversed,
        )

    def lock_joint(self, k: int, value: float) -> Chain:
        """The chain with joint k locked at a value: all joints after it, and the tip, are carried along."""
        E = pose.exp(self.screws[k] * value)
        axes, points = self.axes.copy(), self.points.copy()
        axes[k + 1 :] = axes[k + 1 :] @ E[:3, :3].T
        points[k + 1 :] = points[k + 1 :] @ E[:3, :3].T + E[:3, 3]
        home = E @ self.home if not self.reversed else self.home
        keep = [i for i in range(len(self)) if i != k]
        return Chain(
            axes[keep],
            points[keep],
            tuple(self.prismatic[i] for i in keep),
            tuple(self.joints[i] for i in keep),
            home,
            self.reversed,
        )


def chain_of(mechanism: Mechanism) -> Chain | None:
    """The chain of a mechanism's tip; None where a joint is helical, follows another, or does not move the tip."""
    path = [joint for joint in chain_to_tip(mechanism) if joint.moves]
    if any(joint.mimic is not None or joint.kind is JointKind.HELICAL for joint in path):
        return None
    if [joint.name for joint in path] != list(mechanism.joint_names):
        return None
    S, _, home = screws(mechanism)
    prismatic = tuple(joint.kind is JointKind.PRISMATIC for joint in path)
    column = np.array(prismatic, dtype=np.bool_).reshape(-1, 1)
    axes = np.where(column, S[:, 3:], S[:, :3])
    points = np.where(column, 0.0, np.cross(S[:, :3], S[:, 3:]))
    return Chain(_snap(axes), _snap(points), prismatic, tuple(range(len(path))), _snap(home))


def _snap(x: Floats) -> Floats:
    """Rounding removed from zeros and ones."""
    x = np.where(np.abs(x) < TYPED_ZERO, 0.0, x)
    return np.where(np.abs(np.abs(x) - 1.0) < TYPED_ZERO, np.sign(x), x)


def meeting_point(w1: Vector3, r1: Vector3, w2: Vector3, r2: Vector3) -> tuple[Vector3, float]:
    """The point nearest to two lines that are not parallel, and their distance [m].

    Args:
        w1, r1: (3,) unit direction and a point [m] of the first line.
        w2, r2: of the second.
    """
    normal = np.cross(w1, w2)
    t1, _, gap = np.linalg.solve(np.stack([w1, -w2, normal], axis=1), r2 - r1)
    middle = r1 + t1 * w1 + gap / 2 * normal
    return middle, abs(float(gap)) * float(np.linalg.norm(normal))


def common_point(axes: Floats, points: Floats) -> tuple[Vector3, float]:
    """The point nearest to several lines, and its largest distance from them [m]; NaN if all are parallel.

    Args:
        axes: (k, 3) unit directions.
        points: (k, 3) a point of each [m].
    """
    P = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    total = P.sum(axis=0)
    if np.linalg.cond(total) > 1e8:
        return np.full(3, np.nan), float("inf")
    place = np.asarray(np.linalg.solve(total, (P @ points[:, :, None]).sum(axis=0)[:, 0]), dtype=np.float64)
    return place, float(np.linalg.norm((P @ (place - points)[:, :, None])[:, :, 0], axis=1).max())


def distance_to_line(w: Vector3, r: Vector3, x: Vector3) -> float:
    """Distance of a point from a line [m].

    Args:
        w, r: (3,) unit direction and a point [m] of the line.
        x: (3,) the point [m].
    """
    return float(np.linalg.norm(np.cross(w, x - r)))
