"""Frames at centres of mass, axes parallel to {s} at zero coordinates: the link frames of the textbook."""

from __future__ import annotations

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.placement import placements, world_placements


def link_com_frames(tree: BodyTree) -> list[Attachment]:
    """Where the frame of each link at its centre of mass sits, in the order of `tree.frames`.

    A link without mass gets it at its frame's origin.
    """
    R, _ = _home(tree)
    frames: list[Attachment] = []
    for link, frame in zip(tree.links, tree.frames.values(), strict=True):
        axes = R[frame.body].T @ tree.R_s0.T
        frames.append(Attachment(frame.body, axes, frame.p + frame.R @ link.com))
    return frames


def body_com_frames(tree: BodyTree) -> list[tuple[Floats, Floats]]:
    """Of each body, base first: pose (4, 4) of the frame at its centre of mass at zero, in {s}, and in the body."""
    R, p = _home(tree)
    poses: list[tuple[Floats, Floats]] = []
    for i, body in enumerate(tree.bodies):
        at, T_si = np.eye(4), np.eye(4)
        at[:3, :3] = R[i].T @ tree.R_s0.T
        at[:3, 3] = body.inertia.h / body.inertia.mass if body.inertia.mass else 0.0
        T_si[:3, 3] = tree.p_s0 + tree.R_s0 @ (p[i] + R[i] @ at[:3, 3])
        poses.append((T_si, at))
    return poses


def inverse_of(T: Floats) -> Floats:
    """T^-1 of a pose (4, 4)."""
    inverse = np.eye(4)
    inverse[:3, :3], inverse[:3, 3] = T[:3, :3].T, -T[:3, :3].T @ T[:3, 3]
    return inverse


def adjoint_of(T: Floats) -> Floats:
    """Ad(T) (6, 6) = [[R, 0], [[p] R, R]] of a pose (4, 4)."""
    R, p = T[:3, :3], T[:3, 3]
    P = np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])
    return np.block([[R, np.zeros((3, 3))], [P @ R, R]])


def _home(tree: BodyTree) -> tuple[list[Floats], list[Floats]]:
    """Rotations and origins of all bodies in {0} at zero coordinates."""
    R, p = world_placements(tree, placements(tree, ex.zeros(tree.n, 1)))
    return [_numbers(x) for x in R], [_numbers(x).ravel() for x in p]


def _numbers(x: ex.Expression) -> Floats:
    return np.array(ex.evalf(x).full())
