"""The joints that move a frame: as lines in space, which closed forms look at, and as a robot of their own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3
from mafsil.geometry import pose
from mafsil.ik.tolerances import NO_EXTENT, TYPED_ZERO
from mafsil.kernels.lazy import lazy
from mafsil.model import Joint, JointKind, Mechanism
from mafsil.model.dh_from_axes import screws
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.mechanism import JointLimits
from mafsil.robot import Robot


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


@dataclass(frozen=True, eq=False)
class MovingPart:
    """What of a robot moves a frame.

    Attributes:
        whole: the robot.
        robot: of the joints on the way from the base to the frame alone, the frame its tip; `whole` itself where every
            joint is on the way.
        frame: name of the link as `robot` is asked for it; None for its tip.
        requested: the same as the whole robot is asked for it.
        places: (m,) which coordinate of the whole robot each of the part is; None where every joint is on the way.
    """

    whole: Robot
    robot: Robot
    frame: str | None
    requested: str | None
    places: NDArray[np.intp] | None

    def own(self, q: JointVector) -> JointVector:
        """(*batch, m) the part's own of the coordinates (*batch, n) of the whole robot."""
        return q if self.places is None else np.ascontiguousarray(q[..., self.places])

    def lift(self, q: JointVector, others: JointVector) -> JointVector:
        """(*batch, n) coordinates of the whole robot.

        Args:
            q: (*batch, m) of the part.
            others: (n,) or (*batch, n) where the joints that do not move the frame are.
        """
        if self.places is None:
            return q
        lifted = np.broadcast_to(others, (*q.shape[:-1], self.whole.n)).copy()
        lifted[..., self.places] = q
        return lifted

    def lifted_bits(self, bits: NDArray[np.signedinteger]) -> NDArray[np.signedinteger]:
        """Sums of 2^i over coordinates of the part as sums over coordinates of the whole robot."""
        if self.places is None:
            return bits
        moved = np.zeros_like(bits)
        for i, place in enumerate(self.places):
            moved |= (bits >> i & 1) << int(place)
        return moved

    @lazy
    def columns(self) -> NDArray[np.intp]:
        """(m,) the coordinates that move the frame."""
        return np.arange(self.whole.n) if self.places is None else self.places

    @lazy
    def middle(self) -> JointVector:
        """(n,) the middle of the limits of the whole robot, zero where one is missing."""
        return middle_of(self.whole)

    @lazy
    def lower(self) -> Floats:
        """(n,) limits of the whole robot."""
        return np.array(self.whole.limits.lower)

    @lazy
    def upper(self) -> Floats:
        """(n,) limits of the whole robot."""
        return np.array(self.whole.limits.upper)

    @lazy
    def revolute(self) -> NDArray[np.bool_]:
        """(n,) which coordinates of the whole robot are angles."""
        kinds = [joint.kind is JointKind.REVOLUTE for joint in self.whole.mechanism.coordinates]
        return np.array(kinds, dtype=np.bool_)


def middle_of(robot: Robot) -> JointVector:
    """(n,) the middle of a robot's limits, zero where one is missing."""
    lower, upper = robot.limits.lower, robot.limits.upper
    both = np.isfinite(lower) & np.isfinite(upper)
    return np.where(both, (np.where(both, lower, 0.0) + np.where(both, upper, 0.0)) / 2, 0.0)


@lru_cache(maxsize=128)
def moving_part(robot: Robot, frame: str | None = None) -> MovingPart:
    """The part of a robot that moves a frame; made once.

    A joint that follows another moves the frame if it is on the way; its leader then counts, wherever it is.

    Args:
        robot: any.
        frame: name of a link; the tip if None.

    Raises:
        ModelError: an unknown frame.
    """
    mechanism = robot.mechanism
    if frame is not None:
        mechanism.link(frame)
    path = _path(mechanism, mechanism.tip if frame is None else frame)
    leaders = {joint.mimic.leader for joint in path if joint.mimic is not None and joint.moves}
    names = {joint.name for joint in path if joint.moves and joint.mimic is None} | leaders
    if len(names) in (0, mechanism.n) or mechanism.loops:
        return MovingPart(robot, robot, frame, frame, None)
    part = _part(mechanism, path, leaders, frame)
    places = np.array([mechanism.joint_names.index(name) for name in part.joint_names], dtype=np.intp)
    return MovingPart(robot, Robot(part), None, frame, places)


def _path(mechanism: Mechanism, link: str) -> list[Joint]:
    """The joints between the base and a link, base first."""
    carrying = {joint.child: joint for joint in mechanism.joints}
    path: list[Joint] = []
    while link in carrying:
        path.insert(0, carrying[link])
        link = path[0].parent
    return path


def _part(mechanism: Mechanism, path: list[Joint], leaders: set[str], frame: str | None) -> Mechanism:
    """The path alone; leaders beside it stand on the base, where they move nothing but what follows them."""
    base = mechanism.links[0].name
    on_path = {joint.name for joint in path}
    beside = [
        replace(joint, parent=base) for joint in mechanism.joints if joint.name in leaders and joint.name not in on_path
    ]
    joints = [*path, *beside]
    links = [mechanism.link(name) for name in (base, *(joint.child for joint in joints))]
    return Mechanism.assemble(
        mechanism.name,
        links,
        joints,
        tip=mechanism.tip if frame is None else frame,
        T_lt=mechanism.T_lt if frame is None else None,
        T_sb=mechanism.T_sb,
        gravity=(float(mechanism.gravity[0]), float(mechanism.gravity[1]), float(mechanism.gravity[2])),
        provenance=mechanism.provenance,
    )
