"""Finite motions of a plane body between its fingers: as far as a picture shows, without a finger inside the body.

A velocity that no normal forbids is no motion yet. The body is moved along it by a finite step and then shifted as
little as possible until no finger is inside, the boundary at each contact being an arc of the given curvature.
Where that shift would undo the step, the motion is not possible.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.grasp.closure import conditioning
from mafsil.grasp.contact import Contact
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.tolerances import TYPED
from mafsil.solvers.linear_program import minimise

ROUNDS = 20
UNDONE = 0.5
"""Shifts beyond this share of the step undo the motion."""


def free_twists(grasp: Grasp) -> list[tuple[Floats, bool]]:
    """Motions of a plane grasp that neither order forbids, each with whether it goes both ways; none if immobile.

    Args:
        grasp: in the plane.
    """
    immobility = grasp.second_order()
    if immobility.immobile:
        return []
    free = grasp.free_motions()
    found = [(y, True) for y in free.reversible] + [(y, False) for y in free.rays]
    if immobility.motion is not None:
        found.append((immobility.motion, False))
    steps = [(y, both, size_of(grasp) * 0.05) for y, both in found]
    kept: list[tuple[Floats, bool]] = []
    for y, both, step in steps:
        ways = [sign for sign in ((1.0, -1.0) if both else (1.0,)) if displaced_pose(grasp, sign * y, step) is not None]
        if len(ways) == 2:
            kept.append((y, True))
        elif ways:
            kept.append((ways[0] * y, False))
    return kept


def size_of(grasp: Grasp) -> float:
    """Extent of the contact points [m].

    Args:
        grasp: any.
    """
    return float(np.ptp([c.point for c in grasp.contacts], axis=0).max()) or 1.0


def displaced_pose(grasp: Grasp, twist: Floats, step: float) -> Floats | None:
    """(3, 3) pose of the body after a motion with no finger inside it; None if fingers are in the way.

    Args:
        grasp: in the plane, in its pose at rest.
        twist: (3,) (omega, v).
        step: how far the fastest contact point goes [m].
    """
    if any(c.finger_shape is not None and not c.finger_shape[0, 0] > 0 for c in grasp.contacts):
        return None  # flat or hollow fingers touch elsewhere after a finite step
    to_scaled: Floats = np.asarray(np.linalg.inv(conditioning([c.point for c in grasp.contacts]).T), float)
    length, size = float(np.linalg.norm(to_scaled @ twist)), size_of(grasp)
    fastest = max(float(np.linalg.norm(_velocity(twist, c.point))) for c in grasp.contacts)
    share = step / max(fastest, LEAST_DIVISOR)
    pose, shifted = _exp(share * twist), np.zeros(3)
    for _ in range(ROUNDS):
        gaps = np.array([_gap(pose, c) for c in grasp.contacts])
        if gaps.min() >= -TYPED * size:
            return pose
        rows = np.column_stack([_row(pose, c) for c in grasp.contacts])
        shift = _least_shift(rows, gaps, to_scaled)
        if shift is None:
            return None
        shifted = shifted + shift
        if np.linalg.norm(to_scaled @ shifted) > UNDONE * share * length:
            return None
        pose = _exp(shift) @ pose
    return None


def _gap(pose: Floats, contact: Contact) -> float:
    """Distance between finger and moved body, negative inside: both are arcs of their curvatures."""
    R, k = pose[:2, :2], float(contact.shape[0, 0])
    radius = _finger_radius(contact)
    offset = R.T @ (contact.point - radius * contact.normal - pose[:2, 2]) - contact.point
    a, h = float(offset @ contact.tangents[0]), -float(offset @ contact.normal)
    return (k * (a * a + h * h) + 2.0 * h) / (np.hypot(k * a, k * h + 1.0) + 1.0) - radius


def _finger_radius(contact: Contact) -> float:
    finger = contact.finger_shape
    return 0.0 if finger is None else 1.0 / float(finger[0, 0])


def _row(pose: Floats, contact: Contact) -> Floats:
    """What a further small twist adds to the gap: the wrench of a push on the moved normal at the finger."""
    n = pose[:2, :2] @ contact.normal
    x, y = contact.point
    return np.array([x * n[1] - y * n[0], *n])


def _least_shift(rows: Floats, gaps: Floats, to_scaled: Floats) -> Floats | None:
    """The twist d, least in its largest scaled coordinate, with gaps + rows' d >= 0."""
    one = np.ones((3, 1))
    G = np.vstack([
        np.hstack([np.zeros((len(gaps), 1)), -rows.T]), np.hstack([-one, to_scaled]), np.hstack([-one, -to_scaled])
    ])  # fmt: skip
    best = minimise(np.array([1.0, 0, 0, 0]), None, None, G, np.concatenate([gaps, np.zeros(6)]), free=3)
    return None if best is None else best.x[1:]


def _velocity(twist: Floats, point: Floats) -> Floats:
    return twist[1:] + twist[0] * np.array([-point[1], point[0]])


def _exp(twist: Floats) -> Floats:
    """(3, 3) pose after a plane twist."""
    a, v = float(twist[0]), twist[1:]
    c, s = np.cos(a), np.sin(a)
    half = np.sin(a / 2) * np.sinc(a / (2 * np.pi))
    V = np.array([[np.sinc(a / np.pi), -half], [half, np.sinc(a / np.pi)]])
    pose = np.eye(3)
    pose[:2, :2] = [[c, -s], [s, c]]
    pose[:2, 2] = V @ v
    return pose
