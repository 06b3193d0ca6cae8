"""Choice of the body frames: z stays on the joint axis; turn and slide along it are free and shorten expressions.

Where neighbouring axes allow it, frames follow the modified Denavit-Hartenberg rule: x along the common normal to the
next axis, so that the constant rotation between neighbours turns about x alone, zeros and ones for right angles.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import Attachment, Body, BodyTree
from mafsil.model import JointKind

DUST = 1e-11
"""Entries of constant rotations below this are zero: what pi/2 typed with eleven decimals leaves behind."""
SKEW = 1e-2
"""Axes closer to parallel than this angle [rad] have a far and ill-conditioned common normal: no rule is applied.

Sliding to its foot would cost as many digits as the square of the angle has zeros.
"""
COUPLED = 1e-14
"""Small entries whose removal costs the rotation more than this of its orthonormality are products of small angles."""


def regauged(tree: BodyTree) -> BodyTree:
    """The same tree in frames that make its expressions short.

    The first body's frame at zero also becomes the base frame {0} when only one body hangs on the base.
    """
    slides = _slides(tree)
    turns = _turns(tree, slides)
    return _base_moved(_reframed(tree, turns, slides))


def _slides(tree: BodyTree) -> list[float]:
    """How far each frame moves along its z axis, to the foot of the normal to the axis of its first child."""
    slides = [0.0] * len(tree.bodies)
    for i, _ in reversed(tree.moving):
        child = _first_child(tree, i)
        if child is None:
            continue
        body = tree.bodies[child]
        direction, origin = body.R[:, 2], body.p + body.R[:, 2] * slides[child]
        sine_squared = 1.0 - direction[2] ** 2
        if sine_squared < DUST**2:
            slides[i] = origin[2]
        elif sine_squared > SKEW**2:
            slides[i] = (origin[2] - direction[2] * (direction @ origin)) / sine_squared
    return [_snapped(slide) for slide in slides]


def _turns(tree: BodyTree, slides: list[float]) -> list[Floats]:
    """The rotation of each new frame in the old one: about z, x along the common normal; leaves follow their parent."""
    turns = [np.eye(3) for _ in tree.bodies]
    for i, body in tree.moving:
        child = _first_child(tree, i)
        normal = None if child is None else _common_normal(tree.bodies[child], slides[i], slides[child])
        if normal is None:
            normal = body.R.T @ turns[body.parent][:, 0]
            normal[2] = 0.0
        length = np.linalg.norm(normal)
        if length > SKEW:
            cosine, sine = normal[0] / length, normal[1] / length
            turns[i] = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return turns


def _common_normal(child: Body, slide: float, child_slide: float) -> Floats | None:
    """Direction from the parent's z axis to the child's, in the parent's old frame; None where any will do."""
    direction, offset = child.R[:, 2], child.p + child.R[:, 2] * child_slide - np.array([0.0, 0.0, slide])
    normal = np.array([-direction[1], direction[0], 0.0])
    if np.linalg.norm(normal) > SKEW:
        return normal if normal @ offset >= 0 else -normal
    across = np.array([offset[0], offset[1], 0.0])
    return across if np.linalg.norm(across) > DUST else None


def _reframed(tree: BodyTree, turns: list[Floats], slides: list[float]) -> BodyTree:
    old_origins = [np.array([0.0, 0.0, slide]) for slide in slides]

    def seen_from(body: int, R: Floats, p: Floats) -> tuple[Floats, Floats]:
        return without_dust(turns[body].T @ R), turns[body].T @ (p - old_origins[body])

    bodies = [tree.bodies[0]]
    for i, body in tree.moving:
        R, p = seen_from(body.parent, body.R @ turns[i], body.p + body.R @ old_origins[i])
        inertia = body.inertia.moved(turns[i].T, -turns[i].T @ old_origins[i])
        R, offset = _offset_taken_out(R, body)
        bodies.append(replace(body, R=R, p=_positions_without_dust(p), inertia=inertia, offset=offset))
    frames = {
        name: Attachment(frame.body, *seen_from(frame.body, frame.R, frame.p)) for name, frame in tree.frames.items()
    }
    tip = Attachment(tree.tip.body, *seen_from(tree.tip.body, tree.tip.R, tree.tip.p))
    return replace(tree, bodies=tuple(bodies), frames=frames, tip=tip)


def _offset_taken_out(R: Floats, body: Body) -> tuple[Floats, float]:
    """R = Rx(alpha) Rz(offset): a turn about the joint's own axis becomes a joint offset."""
    if body.kind is not JointKind.REVOLUTE or abs(R[0, 2]) > COUPLED:
        return R, body.offset
    cosine, sine = R[2, 2], -R[1, 2]
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])
    return about_x, body.offset + float(np.arctan2(-R[0, 1], R[0, 0]))


def _base_moved(tree: BodyTree) -> BodyTree:
    """Let {0} be the only first body's frame at zero, so that its constant pose leaves the recursions."""
    first = [(i, body) for i, body in tree.moving if body.parent == 0]
    if len(first) != 1:
        return tree
    i, body = first[0]
    bodies = list(tree.bodies)
    bodies[0] = replace(bodies[0], inertia=bodies[0].inertia.moved(body.R.T, -body.R.T @ body.p))
    bodies[i] = replace(body, R=np.eye(3), p=np.zeros(3))

    def in_new_base(frame: Attachment) -> Attachment:
        return frame if frame.body else Attachment(0, body.R.T @ frame.R, body.R.T @ (frame.p - body.p))

    return replace(
        tree,
        bodies=tuple(bodies),
        R_s0=without_dust(tree.R_s0 @ body.R),
        p_s0=tree.p_s0 + tree.R_s0 @ body.p,
        frames={name: in_new_base(frame) for name, frame in tree.frames.items()},
        tip=in_new_base(tree.tip),
        gravity=body.R.T @ tree.gravity,
    )


def without_dust(R: Floats) -> Floats:
    """The rotation with entries below DUST set to zero and its columns made orthonormal again.

    Exact zeros and ones vanish from the compiled expressions; the rotation changes by less than DUST.
    """
    cleaned = np.where(np.abs(R) < DUST, 0.0, R)
    if (cleaned == R).all() or _skewness(cleaned) > max(COUPLED, 2 * _skewness(R)):
        return R
    for _ in range(2):
        cleaned = cleaned @ (1.5 * np.eye(3) - 0.5 * cleaned.T @ cleaned)
    return np.where(np.abs(cleaned) < DUST, 0.0, cleaned)


def _skewness(R: Floats) -> float:
    """How far the columns are from orthonormal."""
    return float(np.abs(R.T @ R - np.eye(3)).max())


def _positions_without_dust(p: Floats) -> Floats:
    """Lengths below 1e-14 m are rounding."""
    return np.where(np.abs(p) < 1e-14, 0.0, p)


def _snapped(length: float) -> float:
    return 0.0 if abs(length) < 1e-14 else float(length)


def _first_child(tree: BodyTree, body: int) -> int | None:
    return next((i for i, b in tree.moving if b.parent == body), None)
