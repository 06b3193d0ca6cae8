"""The joints that move a frame, as a robot of their own: the others are no unknowns of inverse kinematics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.kernels.lazy import lazy
from mafsil.model import Joint, JointKind, Mechanism
from mafsil.robot import Robot


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
