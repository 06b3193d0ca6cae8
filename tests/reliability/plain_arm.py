"""An arm in plain NumPy, from the description's raw numbers: a second way to what reports of runs claim.

Forward kinematics joint by joint with Rodrigues' formula, efforts by Newton and Euler with forces at the links' centres
in the world frame; nothing of `mafsil.algebra`, `mafsil.mechanics` or `mafsil.robot` is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.model import JointKind, Mechanism


@dataclass(frozen=True)
class Load:
    """A box in the tool: mass [kg], centre (3,) in the tip frame [m], inertia (3, 3) about it [kg m^2]."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray


def turn(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(k, 3, 3) rotations about a unit axis by angles (k,): 1 + sin K + (1 - cos) K^2."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle)[:, None, None] * K + (1 - np.cos(angle))[:, None, None] * (K @ K)


def angle_between(R: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Angles (k,) between rotations, by the chord for small ones [rad]."""
    chord = np.linalg.norm(R - S, axis=(1, 2)) / np.sqrt(8.0)
    return 2.0 * np.arcsin(np.clip(chord, 0.0, 1.0))


class PlainArm:
    """A tree of revolute and prismatic joints without followers.

    Args:
        mechanism: whose raw data is read.
        factor: by which all masses and inertias are multiplied.
        load: in the tool, or None; multiplied as well.
    """

    def __init__(self, mechanism: Mechanism, factor: float = 1.0, load: Load | None = None) -> None:
        self.mechanism, self.factor, self.load = mechanism, factor, load
        self.place = {link.name: k for k, link in enumerate(mechanism.links)}
        self.column = {joint.name: k for k, joint in enumerate(mechanism.coordinates)}
        assert all(joint.mimic is None and joint.kind is not JointKind.HELICAL for joint in mechanism.joints)

    def frames(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotations (k, links, 3, 3) and origins (k, links, 3) of all links in {s}."""
        count = len(q)
        R, p = np.empty((count, len(self.place), 3, 3)), np.empty((count, len(self.place), 3))
        R[:, 0], p[:, 0] = self.mechanism.T_sb[:3, :3], self.mechanism.T_sb[:3, 3]
        for joint in self.mechanism.joints:
            above, here = self.place[joint.parent], self.place[joint.child]
            Rj = R[:, above] @ joint.T_pj[:3, :3]
            p[:, here] = p[:, above] + R[:, above] @ joint.T_pj[:3, 3]
            R[:, here] = Rj
            if joint.kind is JointKind.REVOLUTE:
                R[:, here] = Rj @ turn(joint.axis, q[:, self.column[joint.name]])
            elif joint.kind is JointKind.PRISMATIC:
                p[:, here] += (Rj @ joint.axis) * q[:, self.column[joint.name], None]
        return R, p

    def tip(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotations (k, 3, 3) and positions (k, 3) of the tip."""
        R, p = self.frames(q)
        last = self.place[self.mechanism.tip]
        return R[:, last] @ self.mechanism.T_lt[:3, :3], p[:, last] + R[:, last] @ self.mechanism.T_lt[:3, 3]

    def efforts(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, push: np.ndarray | None = None) -> np.ndarray:
        """Efforts (k, n) of a motion without friction, less what a push (k, 6) on the tip does."""
        R, p = self.frames(q)
        w, al, a = self._motion(R, p, q, qd, qdd)
        f, n = np.zeros_like(p), np.zeros_like(p)
        for k, link in enumerate(self.mechanism.links):
            body = link.inertial
            if body is not None:
                self._add(f, n, k, (body.mass, body.com, body.inertia, np.eye(3)), (R, w, al, a))
        last, T = self.place[self.mechanism.tip], self.mechanism.T_lt
        if self.load is not None:
            centre = T[:3, :3] @ self.load.centre + T[:3, 3]
            self._add(f, n, last, (self.load.mass, centre, self.load.inertia, T[:3, :3]), (R, w, al, a))
        if push is not None:
            Rt = R[:, last] @ T[:3, :3]
            force, moment = _times(Rt, push[:, 3:]), _times(Rt, push[:, :3])
            f[:, last] -= force
            n[:, last] -= moment + np.cross(R[:, last] @ T[:3, 3], force)
        tau = np.zeros_like(q)
        for joint in reversed(self.mechanism.joints):
            above, here = self.place[joint.parent], self.place[joint.child]
            f[:, above] += f[:, here]
            n[:, above] += n[:, here] + np.cross(p[:, here] - p[:, above], f[:, here])
            if joint.kind is JointKind.FIXED:
                continue
            column, axis = self.column[joint.name], R[:, here] @ joint.axis
            along = n[:, here] if joint.kind is JointKind.REVOLUTE else f[:, here]
            rotor = joint.actuator.reflected_inertia if joint.actuator else 0.0
            tau[:, column] = (axis * along).sum(axis=1) + rotor * qdd[:, column]
        return tau

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """Efforts (k, n) that hold the arm still."""
        return self.efforts(q, 0.0 * q, 0.0 * q)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """(n, n) at one configuration (n,), column by column."""
        one = np.eye(len(q))
        rows = np.tile(q, (len(q), 1))
        return (self.efforts(rows, 0.0 * rows, one) - self.gravity(rows)).T

    def coulomb(self) -> np.ndarray:
        """(n,) largest static friction of each joint, with its constant offset."""
        found = np.zeros(self.mechanism.n)
        for joint in self.mechanism.coordinates:
            if joint.friction is not None:
                f = joint.friction
                negative = f.coulomb if f.coulomb_negative is None else f.coulomb_negative
                found[self.column[joint.name]] = max(f.coulomb, negative) + abs(f.offset)
        return found

    def _motion(
        self, R: np.ndarray, p: np.ndarray, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Angular rates and accelerations of all links, accelerations of their origins less gravity."""
        w, al, a = np.zeros_like(p), np.zeros_like(p), np.zeros_like(p)
        a[:, 0] = -self.mechanism.gravity
        for joint in self.mechanism.joints:
            above, here = self.place[joint.parent], self.place[joint.child]
            r = p[:, here] - p[:, above]
            w[:, here], al[:, here] = w[:, above], al[:, above]
            a[:, here] = a[:, above] + np.cross(al[:, above], r) + np.cross(w[:, above], np.cross(w[:, above], r))
            if joint.kind is JointKind.FIXED:
                continue
            column, axis = self.column[joint.name], R[:, here] @ joint.axis
            rate, gain = axis * qd[:, column, None], axis * qdd[:, column, None]
            if joint.kind is JointKind.REVOLUTE:
                w[:, here] = w[:, above] + rate
                al[:, here] = al[:, above] + gain + np.cross(w[:, above], rate)
            else:
                a[:, here] += gain + 2.0 * np.cross(w[:, above], rate)
        return w, al, a

    def _add(
        self,
        f: np.ndarray,
        n: np.ndarray,
        k: int,
        body: tuple[float, np.ndarray, np.ndarray, np.ndarray],
        motion: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    ) -> None:
        """Force and moment about the origin of link k that the motion of a body on it takes."""
        mass, com, inertia, axes = body
        R, w, al, a = (x[:, k] for x in motion)
        c, J = R @ com, self.factor * (R @ axes) @ inertia @ np.swapaxes(R @ axes, 1, 2)
        force = self.factor * mass * (a + np.cross(al, c) + np.cross(w, np.cross(w, c)))
        f[:, k] += force
        n[:, k] += np.cross(c, force) + _times(J, al) + np.cross(w, _times(J, w))


def _times(A: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.einsum("kij,kj->ki", A, x)
