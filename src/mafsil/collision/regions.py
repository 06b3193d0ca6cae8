"""Balls that the bodies of an arm never leave, seen from any of its links, and how far they get from axes.

From link to link, towards the base or away from it: what turns about an axis stays in a ball about the foot of the
ball's centre on the axis, larger by the centre's distance from it; what slides, in one larger by half of the way.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm
from mafsil.collision.joints import Joints
from mafsil.model import Mechanism

Ball: TypeAlias = tuple[Floats, float]
"""Centre (3,) and radius."""


class Regions:
    """Where the bodies of an arm can be.

    Args:
        mechanism, joints, arm: the arm.
        lower, upper: (n,) ends of the coordinates of sliding joints; hinges may turn as they like.
    """

    def __init__(self, mechanism: Mechanism, joints: Joints, arm: Arm, lower: Floats, upper: Floats) -> None:
        self._mechanism, self._joints, self._arm = mechanism, joints, arm
        self._ends = lower, upper
        self._of_link = {int(link): j for j, link in enumerate(joints.link)}
        self._above: list[set[int]] = [{0}]
        for link, parent in enumerate(mechanism.parents, start=1):
            self._above.append(self._above[parent] | {link})
        self._known: dict[tuple[int, int], Ball] = {}

    def in_space(self) -> Floats:
        """(b, 4) for each body a ball in {s} that it never leaves."""
        T, found = self._mechanism.T_sb, np.empty((len(self._arm.bodies), 4))
        for b in range(len(found)):
            centre, radius = self.ball(b, 0)
            found[b] = *(T[:3, :3] @ centre + T[:3, 3]), radius
        return found

    def levers(self) -> Floats:
        """(j, b) how far any point of a body gets from the axis of a hinge that moves it; zero elsewhere."""
        joints, links = self._joints, self._arm.bodies[:, 0].astype(np.int64)
        found = np.zeros((len(joints.link), len(links)))
        for j, screw in enumerate(joints.screw):
            for b, link in enumerate(links):
                if screw[:3].any() and joints.moves[j, link]:
                    found[j, b] = self.lever(j, b)
        return found

    def lever(self, j: int, b: int) -> float:
        """How far any point of body b gets from the axis of hinge j, whether that moves it or not."""
        link, axis = int(self._joints.link[j]), self._joints.screw[j, :3]
        carried = self._joints.moves[j, int(self._arm.bodies[b, 0])]
        centre, radius = self.ball(b, link) if carried else self._into(b, link)
        return float(np.linalg.norm(centre - axis * (axis @ centre))) + radius

    def ball(self, b: int, link: int) -> Ball:
        """Where body b stays as link sees it."""
        if (b, link) not in self._known:
            self._known[b, link] = self._from_neighbour(b, link)
        return self._known[b, link]

    def _from_neighbour(self, b: int, link: int) -> Ball:
        row, parents = self._arm.bodies[b], self._mechanism.parents
        own = int(row[0])
        if own == link:
            return row[4:7], float(row[7])
        if link not in self._above[own]:
            return self._sweep(self._into(b, link), link, -1.0)
        child = own
        while parents[child - 1] != link:
            child = parents[child - 1]
        T = self._mechanism.joints[child - 1].T_pj
        centre, radius = self._sweep(self.ball(b, child), child, 1.0)
        return T[:3, :3] @ centre + T[:3, 3], radius

    def _into(self, b: int, link: int) -> Ball:
        """Where body b stays as the joint frame of a link sees it, which that joint does not move."""
        T = self._mechanism.joints[link - 1].T_pj
        centre, radius = self.ball(b, self._mechanism.parents[link - 1])
        return T[:3, :3].T @ (centre - T[:3, 3]), radius

    def _sweep(self, ball: Ball, link: int, direction: float) -> Ball:
        """What a ball sweeps while the joint of a link moves it, or moves backwards what sees it."""
        if link not in self._of_link:
            return ball
        j, joints, (centre, radius) = self._of_link[link], self._joints, ball
        axis, along = joints.screw[j, :3], joints.screw[j, 3:]
        foot = axis * (axis @ centre) if axis.any() else centre
        radius += float(np.linalg.norm(centre - foot))
        if along.any():
            mimic = self._mechanism.joints[link - 1].mimic
            ends = np.array([end[joints.column[j]] for end in self._ends])
            ends = (joints.factor[j] * ends if joints.factor[j] else 0.0 * np.sign(ends)) + (
                0.0 if mimic is None else mimic.offset
            )
            middle = ends.mean() if np.isfinite(ends).all() else 0.0
            foot = foot + direction * middle * along
            radius += float(np.abs(ends - middle).max() * np.linalg.norm(along))
        return foot, radius
