"""Choice of the body frames: z is the joint axis; rotation about and shift along it are free and shorten expressions.

Where neighbouring axes allow it, frames follow the modified Denavit-Hartenberg rule: x along the common normal to the
next axis, so that the constant rotation between neighbours is about x alone, zeros and ones for right angles.

Inertia that a joint cannot feel moves to the parent body, where it is felt the same: fewer numbers, equal motion.

For a revolute joint about z these are the mass, the first moment along z and Iyy (taken from Ixx too); for a prismatic
one the whole rotational inertia. The moved part dG satisfies dG S = 0 and does not change under the joint's motion, so
joint efforts, mass matrix and accelerations stay as they were; link wrenches do not.

Reference: Khalil & Dombre, Modeling, Identification and Control of Robots, sec. 9.4 (base inertial parameters).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mechanics.body_tree import Attachment, Body, BodyTree, RigidInertia
from mafsil.mechanics.tolerances import NEGLIGIBLE_INERTIA, ROUNDED, SKEW, TYPED
from mafsil.model import JointKind


def in_chosen_frames(tree: BodyTree) -> BodyTree:
    """The same tree in frames that make its expressions short.

    The first body's frame at zero also becomes the base frame {0} when only one body hangs on the base.
    """
    shifts = _shifts(tree)
    rotations = _rotations(tree, shifts)
    return _base_moved(_with_origin_at(tree, rotations, shifts))


def _shifts(tree: BodyTree) -> list[float]:
    """How far each frame moves along its z axis, to the foot of the normal to the axis of its first child."""
    shifts = [0.0] * len(tree.bodies)
    for i, _ in reversed(tree.moving):
        child = _first_child(tree, i)
        if child is None:
            continue
        body = tree.bodies[child]
        direction, origin = body.R[:, 2], body.p + body.R[:, 2] * shifts[child]
        sine_squared = 1.0 - direction[2] ** 2
        if sine_squared < TYPED**2:
            shifts[i] = origin[2]
        elif sine_squared > SKEW**2:
            shifts[i] = (origin[2] - direction[2] * (direction @ origin)) / sine_squared
    return [_snap(shift) for shift in shifts]


def _rotations(tree: BodyTree, shifts: list[float]) -> list[Floats]:
    """The rotation of each new frame in the old one: about z, x along the common normal; leaves follow their parent."""
    rotations = [np.eye(3) for _ in tree.bodies]
    for i, body in tree.moving:
        child = _first_child(tree, i)
        normal = None if child is None else _common_normal(tree.bodies[child], shifts[i], shifts[child])
        if normal is None:
            normal = body.R.T @ rotations[body.parent][:, 0]
            normal[2] = 0.0
        length = np.linalg.norm(normal)
        if length > SKEW:
            cosine, sine = normal[0] / length, normal[1] / length
            rotations[i] = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return rotations


def _common_normal(child: Body, shift: float, child_shift: float) -> Floats | None:
    """Direction from the parent's z axis to the child's, in the parent's old frame; None where any will do."""
    direction, offset = child.R[:, 2], child.p + child.R[:, 2] * child_shift - np.array([0.0, 0.0, shift])
    normal = np.array([-direction[1], direction[0], 0.0])
    if np.linalg.norm(normal) > SKEW:
        return normal if normal @ offset >= 0 else -normal
    across = np.array([offset[0], offset[1], 0.0])
    return across if np.linalg.norm(across) > TYPED else None


def _with_origin_at(tree: BodyTree, rotations: list[Floats], shifts: list[float]) -> BodyTree:
    old_origins = [np.array([0.0, 0.0, shift]) for shift in shifts]

    def seen_from(body: int, R: Floats, p: Floats) -> tuple[Floats, Floats]:
        return without_rounding(rotations[body].T @ R), rotations[body].T @ (p - old_origins[body])

    bodies = [tree.bodies[0]]
    for i, body in tree.moving:
        R, p = seen_from(body.parent, body.R @ rotations[i], body.p + body.R @ old_origins[i])
        inertia = body.inertia.in_frame(rotations[i].T, -rotations[i].T @ old_origins[i])
        R, offset = _offset_taken_out(R, body)
        bodies.append(replace(body, R=R, p=_positions_without_rounding(p), inertia=inertia, offset=offset))
    frames = {
        name: Attachment(frame.body, *seen_from(frame.body, frame.R, frame.p)) for name, frame in tree.frames.items()
    }
    tip = Attachment(tree.tip.body, *seen_from(tree.tip.body, tree.tip.R, tree.tip.p))
    return replace(tree, bodies=tuple(bodies), frames=frames, tip=tip)


def _offset_taken_out(R: Floats, body: Body) -> tuple[Floats, float]:
    """R = Rx(alpha) Rz(offset): a turn about the joint's own axis becomes a joint offset."""
    if body.kind is not JointKind.REVOLUTE or abs(R[0, 2]) > ROUNDED:
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
    bodies[0] = replace(bodies[0], inertia=bodies[0].inertia.in_frame(body.R.T, -body.R.T @ body.p))
    bodies[i] = replace(body, R=np.eye(3), p=np.zeros(3))

    def in_new_base(frame: Attachment) -> Attachment:
        return frame if frame.body else Attachment(0, body.R.T @ frame.R, body.R.T @ (frame.p - body.p))

    return replace(
        tree,
        bodies=tuple(bodies),
        R_s0=without_rounding(tree.R_s0 @ body.R),
        p_s0=tree.p_s0 + tree.R_s0 @ body.p,
        frames={name: in_new_base(frame) for name, frame in tree.frames.items()},
        tip=in_new_base(tree.tip),
        gravity=body.R.T @ tree.gravity,
    )


def without_rounding(R: Floats) -> Floats:
    """The rotation with entries below TYPED set to zero and its columns made orthonormal again.

    Exact zeros and ones vanish from the compiled expressions; the rotation changes by less than TYPED.
    """
    cleaned = np.where(np.abs(R) < TYPED, 0.0, R)
    if (cleaned == R).all() or _skewness(cleaned) > max(ROUNDED, 2 * _skewness(R)):
        return R
    for _ in range(2):
        cleaned = cleaned @ (1.5 * np.eye(3) - 0.5 * cleaned.T @ cleaned)
    return np.where(np.abs(cleaned) < TYPED, 0.0, cleaned)


def _skewness(R: Floats) -> float:
    """How far the columns are from orthonormal."""
    return float(np.abs(R.T @ R - np.eye(3)).max())


def _positions_without_rounding(p: Floats) -> Floats:
    return np.where(np.abs(p) < ROUNDED, 0.0, p)


def _snap(length: float) -> float:
    return 0.0 if abs(length) < ROUNDED else float(length)


def _first_child(tree: BodyTree, body: int) -> int | None:
    return next((i for i, b in tree.moving if b.parent == body), None)


def regroup(tree: BodyTree) -> BodyTree:
    """The same tree with the fewest inertial numbers; the base keeps none."""
    bodies = list(tree.bodies)
    for i, _ in reversed(tree.moving):
        kept, passed = _split(bodies[i].kind, bodies[i].inertia)
        parent = bodies[bodies[i].parent]
        bodies[i] = replace(bodies[i], inertia=_without_rounding(kept))
        bodies[bodies[i].parent] = replace(parent, inertia=parent.inertia + passed.in_frame(bodies[i].R, bodies[i].p))
    bodies[0] = replace(bodies[0], inertia=RigidInertia.zero())
    return replace(tree, bodies=tuple(bodies))


def _split(kind: JointKind, inertia: RigidInertia) -> tuple[RigidInertia, RigidInertia]:
    """(what the joint feels, what it does not)."""
    match kind:
        case JointKind.REVOLUTE:
            passed = RigidInertia(
                inertia.mass,
                np.array([0.0, 0.0, inertia.h[2]]),
                np.diag([inertia.I[1, 1], inertia.I[1, 1], 0.0]),
            )
        case JointKind.PRISMATIC:
            passed = RigidInertia(0.0, np.zeros(3), inertia.I)
        case _:
            passed = RigidInertia.zero()
    return RigidInertia(inertia.mass - passed.mass, inertia.h - passed.h, inertia.I - passed.I), passed


def _without_rounding(inertia: RigidInertia) -> RigidInertia:
    """Entries at rounding level against the body's own largest one are zero."""
    scale = max(float(np.abs(inertia.I).max()), LEAST_DIVISOR)
    return replace(inertia, I=np.where(np.abs(inertia.I) < NEGLIGIBLE_INERTIA * scale, 0.0, inertia.I))
