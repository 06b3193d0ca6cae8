"""Loops a second time, in NumPy, from the positions of the links as the textbook has them: followers move with leaders.

Where a joint that closes a loop puts its child {c}, seen from its frame {p} on the parent, must be a pose T that the
joint allows. What it misses is a list of numbers g(T), linear in T but for the angle of a screw, more of them than
needed. Nothing is shared with `mafsil.mechanics.loop_constraints`: its rows are other numbers with the same null space.

    g(q) = 0,   G = dg/dq by the complex step,   G qd = 0,   G qdd + c = 0,   c = d(G qd)/dt at constant qd

Reference: Lynch & Park, Modern Robotics, sec. 7.1; Udwadia and Kalaba, Analytical Dynamics, 1996.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.mechanics.textbook import Numbers, Textbook, adjoint, along, gradient, inverse, skew
from mafsil.model import Joint, JointKind

HINGED = (JointKind.REVOLUTE, JointKind.CYLINDRICAL, JointKind.PLANAR, JointKind.HELICAL)
"""Joints that keep an axis of the child along one of the parent."""
PINNED = (JointKind.FIXED, JointKind.REVOLUTE, JointKind.UNIVERSAL, JointKind.SPHERICAL)
"""Joints that keep a point of the child on one of the parent."""


class LoopBook:
    """The conditions of the loops of one mechanism; q, qd (b, n).

    Attributes:
        book: kinematics and dynamics of its tree.
        size: lengths are taken over it [m].
    """

    def __init__(self, book: Textbook, size: float) -> None:
        self.book, self.size = book, size

    def gap(self, q: Numbers) -> Numbers:
        """(b, r) what the loops miss, lengths over the size."""
        T = self.book.poses(q)
        return np.concatenate([self._missed(joint, self._seen(joint, T)) for joint in self._joints], axis=1)

    def rows(self, q: Floats) -> Floats:
        """(b, r, n) G, by the complex step."""
        return gradient(self.gap, q)

    def rates(self, q: Numbers, qd: Numbers) -> Numbers:
        """(b, r) G qd from the twists of the links, for one more derivative."""
        T, J = self.book.poses(q), self.book.link_jacobians(q)
        V = np.einsum("blin,bn->bli", J, qd)
        found: list[Numbers] = []
        for joint in self._joints:
            parent, child = self._ends(joint)
            seen = self._seen(joint, T)
            there = adjoint(inverse(np.asarray(joint.T_pj))).astype(V.dtype) @ V[:, parent, :, None]
            twist = V[:, child] - (adjoint(inverse(seen)) @ there)[..., 0]
            change = np.zeros_like(seen)
            change[:, :3, :3], change[:, :3, 3] = skew(twist[:, :3]), twist[:, 3:]
            found.append(self._linear(joint, seen @ change, twist[:, :3] @ joint.axis))
        return np.concatenate(found, axis=1)

    def curvature(self, q: Floats, qd: Floats) -> Floats:
        """(b, r) c: how the rates of the gaps change at constant rates of the joints."""
        return along(lambda x: self.rates(x, qd.astype(x.dtype)), q, qd)

    @property
    def _joints(self) -> tuple[Joint, ...]:
        return self.book.mechanism.loops

    def _ends(self, joint: Joint) -> tuple[int, int]:
        names = self.book.mechanism.link_names
        return names.index(joint.parent), names.index(joint.child)

    def _seen(self, joint: Joint, T: Numbers) -> Numbers:
        """(b, 4, 4) {c} in {p}."""
        parent, child = self._ends(joint)
        return inverse(T[:, parent] @ np.asarray(joint.T_pj)) @ T[:, child]

    def _missed(self, joint: Joint, T: Numbers) -> Numbers:
        """(b, r) g of poses (b, 4, 4)."""
        still = np.broadcast_to(np.eye(4), T.shape)
        return self._linear(joint, T, _angle(joint.axis, T)) - self._linear(joint, still, np.zeros(len(T)))

    def _linear(self, joint: Joint, T: Numbers, angle: Numbers) -> Numbers:
        """(b, r) the part of g that is linear in the pose T (b, 4, 4) and the angle (b,), of a change of these too."""
        a, R, p = np.asarray(joint.axis), T[:, :3, :3], T[:, :3, 3] / self.size
        found: list[Numbers] = []
        if joint.kind in (JointKind.FIXED, JointKind.PRISMATIC):
            found.append(R.reshape(len(T), 9))
        elif joint.kind in HINGED:
            found.append(R @ a)
        elif joint.kind is JointKind.UNIVERSAL:
            found.append((R @ np.asarray(joint.second) @ a)[:, None])
        if joint.kind in PINNED:
            found.append(p)
        elif joint.kind is JointKind.PLANAR:
            found.append((p @ a)[:, None])
        else:
            found.append(p - (p @ a)[:, None] * a)
        if joint.kind is JointKind.HELICAL:
            found.append((p @ a - joint.pitch / self.size * angle)[:, None])
        return np.concatenate(found, axis=1)


def _angle(axis: Floats, T: Numbers) -> Numbers:
    """(b,) angle of poses about an axis, within half a turn; its imaginary part to first order, as the step is."""
    across = np.linalg.svd(axis[None])[2][1]
    turned = T[:, :3, :3] @ across
    x, y = turned @ across, turned @ np.cross(axis, across)
    first = np.arctan2(y.real, x.real)
    if not np.iscomplexobj(T):
        return first
    return first + 1j * (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)
