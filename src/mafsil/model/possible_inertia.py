"""Inertias that no body has, made possible without changing any motion: what is too little is moved between links.

A turn about a joint axis a does not change omega - (a . omega) a, so delta (1 - a a') may be taken from the link on one
side of a revolute joint and given to the link on the other. Across a prismatic or a fixed joint omega is the same on
both sides, and any direction will do. What stands still takes and gives everything.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Floats, Vector3, frozen
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Inertial, Link
from mafsil.model.mechanism import Mechanism

ROUNDING = 1e-12
"""Share of the largest second moment by which one may be negative after a shift: what rounding leaves."""


def possible_inertias(mechanism: Mechanism) -> tuple[Mechanism, tuple[str, ...], dict[str, float]]:
    """The mechanism with inertias that bodies can have where a shift along joint axes gives such.

    Args:
        mechanism: any.

    Returns:
        The mechanism, the links whose inertia was shifted, and those whose inertia no body has still, each with what
        it lacks as a share of its largest second moment.
    """
    shifts = _Shifts(mechanism, {link.name: _second_moments(link) for link in mechanism.links})
    for link in mechanism.links:
        if link.name in shifts.moving and _lack(shifts.moments[link.name]) > ROUNDING:
            shifts.mend(link.name)
    lacks = {name: _lack(S) for name, S in shifts.moments.items() if name in shifts.moving}
    links = [_with_moments(link, shifts.moments) if link.name in shifts.touched else link for link in mechanism.links]
    touched = tuple(link.name for link in mechanism.links if link.name in shifts.touched)
    return replace(mechanism, links=tuple(links)), touched, {name: x for name, x in lacks.items() if x > ROUNDING}


@dataclass(slots=True)
class _Shifts:
    """Second moments of all links, which may be moved across joints."""

    mechanism: Mechanism
    moments: dict[str, Floats]
    touched: set[str]
    moving: set[str]

    def __init__(self, mechanism: Mechanism, moments: dict[str, Floats]) -> None:
        self.mechanism, self.moments, self.touched, self.moving = mechanism, moments, set(), set()
        for joint in mechanism.joints:
            if joint.moves or joint.parent in self.moving:
                self.moving.add(joint.child)

    def mend(self, name: str) -> None:
        """Give a link what it lacks along the axis of one of its joints, if its neighbour can spare it."""
        for neighbour, axis, R in self._neighbours(name):
            delta = _lacking(self.moments[name], axis)
            if delta is None:
                continue
            given = delta * np.outer(axis, axis)
            rest = self.moments[neighbour] - R @ given @ R.T
            if neighbour in self.moving and _lack(rest) > ROUNDING:
                continue
            self.moments[name] = self.moments[name] + given
            self.touched.add(name)
            if neighbour in self.moving:
                self.moments[neighbour] = rest
                self.touched.add(neighbour)
            return

    def _neighbours(self, name: str) -> Iterator[tuple[str, Vector3, Floats]]:
        """Links on the other side of a joint, the direction in this link, and the rotation into the neighbour."""
        for joint in self.mechanism.joints:
            R = np.asarray(joint.T_pj[:3, :3])
            if joint.child == name:
                yield joint.parent, self._direction(joint, name, np.eye(3)), R
            elif joint.parent == name:
                yield joint.child, self._direction(joint, name, R), R.T

    def _direction(self, joint: Joint, name: str, R: Floats) -> Vector3:
        if joint.kind is JointKind.REVOLUTE:
            return R @ joint.axis
        _, axes = np.linalg.eigh(self.moments[name])
        return axes[:, 0]


def _second_moments(link: Link) -> Floats:
    """(3, 3) tr(I)/2 1 - I, which no body has negative."""
    inertia = np.zeros((3, 3)) if link.inertial is None else np.asarray(link.inertial.inertia)
    return np.eye(3) * np.trace(inertia) / 2 - inertia


def _with_moments(link: Link, moments: Mapping[str, Floats]) -> Link:
    S = moments[link.name]
    body = Inertial(0.0) if link.inertial is None else link.inertial
    inertia = np.eye(3) * np.trace(S) - S
    return replace(link, inertial=Inertial(body.mass, body.com, frozen((inertia + inertia.T) / 2)))


def _lacking(S: Floats, axis: Vector3) -> float | None:
    """The least delta for which S + delta a a' is not negative; None if none is enough."""
    lowest, axes = np.linalg.eigh(S)
    along = axes.T @ axis
    if lowest[1] < 0.0 or along[0] == 0.0:
        return None
    # det(S + delta a a') = det(S) (1 + delta a' S^-1 a), multiplied out so that zero moments do no harm
    rest = lowest[1] * lowest[2] * along[0] ** 2 + lowest[0] * (lowest[2] * along[1] ** 2 + lowest[1] * along[2] ** 2)
    whole = lowest[0] * lowest[1] * lowest[2]
    delta = float(-whole / rest if rest > 0.0 else -lowest[0] / along[0] ** 2)
    return delta if _lack(S + delta * np.outer(axis, axis)) <= ROUNDING else None


def _lack(S: Floats) -> float:
    """By how much the lowest second moment is negative, as a share of the largest."""
    values = np.linalg.eigvalsh(S)
    largest = float(np.abs(values).max())
    return max(0.0, -float(values[0]) / largest) if largest else 0.0
