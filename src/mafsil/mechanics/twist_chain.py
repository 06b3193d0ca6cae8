"""A mechanism as the textbook writes it: home poses and joint screws in frames at the centres of mass.

Frame {i} sits at the centre of mass of body i, its axes parallel to those of {s} at zero coordinates. This is the
second method for the dynamics: twists and wrenches in six dimensions, no shared algorithm with `inverse_dynamics`.

Reference: Lynch & Park, Modern Robotics, sec. 8.3.

Frames at centres of mass, axes parallel to {s} at zero coordinates: the link frames of the textbook.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.errors import ModelError
from mafsil.mechanics.body_tree import Attachment, BodyTree
from mafsil.mechanics.placement import Expression, placements, world_placements
from mafsil.model import JointKind


@dataclass(frozen=True, eq=False, slots=True)
class TwistChain:
    """N bodies, each carried by one joint of one degree of freedom.

    Attributes:
        parent: (N,) index of the carrying body, -1 for the ground.
        A: (N, 6) joint screws (omega, v) in {i}; of any length, so that q_i may have any unit.
        home: (N, 4, 4) pose of {i} in its parent's frame at zero.
        G: (N, 6, 6) inertia of body i in {i}.
        armature: (N,) further inertia that joint i feels.
        coupling: (N, n) joint rates from those of the coordinates; the identity without mimic joints.
        tip_body, T_tip: which body the tip is on, and its pose (4, 4) there.
        gravity: (3,) in the ground frame {s}.
    """

    parent: tuple[int, ...]
    A: Floats
    home: Floats
    G: Floats
    armature: Floats
    coupling: Floats
    tip_body: int
    T_tip: Floats
    gravity: Floats

    @staticmethod
    def of(tree: BodyTree) -> TwistChain:
        """The chain of a body tree with its true inertias (`lumped`).

        Raises:
            ModelError: a joint follows another along a curve.
        """
        poses = body_com_frames(tree)
        screws: list[Floats] = []
        homes: list[Floats] = []
        inertias: list[Floats] = []
        parents: list[int] = []
        for i, body in tree.moving:
            T_si, at = poses[i]
            carrier = np.eye(4) if body.parent == 0 else poses[body.parent][0]
            homes.append(inverse_of(carrier) @ T_si)
            screws.append(adjoint_of(inverse_of(at)) @ _screw(body.kind, body.pitch))
            inertia = body.inertia.in_frame(at[:3, :3].T, -at[:3, :3].T @ at[:3, 3])
            inertias.append(spatial_matrix(inertia.mass, inertia.h, inertia.I))
            parents.append(body.parent - 1)
        coupling = np.zeros((len(parents), tree.n))
        for i, body in tree.moving:
            if body.higher:
                raise ModelError("model.curved", joint=body.joint, leader=tree.coordinates[body.coordinate])
            coupling[i - 1, body.coordinate] = body.multiplier
        tip = np.eye(4)
        tip[:3, :3], tip[:3, 3] = tree.tip.R, tree.tip.p
        on_ground = tree.tip.body == 0
        return TwistChain(
            tuple(parents),
            np.array(screws).reshape(-1, 6),
            np.array(homes).reshape(-1, 4, 4),
            np.array(inertias).reshape(-1, 6, 6),
            np.array([body.armature for _, body in tree.moving]),
            coupling,
            tree.tip.body - 1,
            tip if on_ground else inverse_of(poses[tree.tip.body][1]) @ tip,
            tree.R_s0 @ tree.gravity,
        )

    @property
    def count(self) -> int:
        """How many bodies move."""
        return len(self.parent)

    def adjoints(self, q: Expression) -> list[Expression]:
        """X_i = Ad(T_ip) (6, 6) of all bodies: a twist of the parent's frame, seen from {i}.

        T_pi = home exp([A_i] theta_i)
        """
        theta = ex.Expression(self.coupling) @ q
        return [_adjoint_inverse(self.home[i], self.A[i], theta[i]) for i in range(self.count)]


def spatial_matrix(mass: float, h: Floats, inertia: Floats) -> Floats:
    """G (6, 6) = [[I, [h]], [-[h], m 1]] from mass, first moment and inertia about the origin."""
    H = np.array([[0, -h[2], h[1]], [h[2], 0, -h[0]], [-h[1], h[0], 0]])
    return np.block([[inertia, H], [-H, mass * np.eye(3)]])


def ad(V: Expression) -> Expression:
    """[ad_V] (6, 6) with [ad_V] W = [V, W]."""
    w, v = ex.skew(V[:3]), ex.skew(V[3:])
    return ex.vertcat(ex.horzcat(w, ex.zeros(3, 3)), ex.horzcat(v, w))


def _screw(kind: JointKind, pitch: float) -> Floats:
    angular, linear = float(kind is not JointKind.PRISMATIC), {JointKind.PRISMATIC: 1.0, JointKind.HELICAL: pitch}
    return np.array([0, 0, angular, 0, 0, linear.get(kind, 0.0)])


def _adjoint_inverse(home: Floats, A: Floats, theta: Expression) -> Expression:
    """Ad((home exp([A] theta))^-1)."""
    w, v = A[:3], A[3:]
    rate = float(np.linalg.norm(w))
    if rate == 0.0:
        R, p = ex.eye(3), ex.Expression(v) * theta
    else:
        K = ex.Expression(np.cross(w, np.eye(3)).T / rate)
        angle = rate * theta
        R = ex.eye(3) + ex.sin(angle) * K + (1 - ex.cos(angle)) * (K @ K)
        shift = theta * ex.eye(3) + (1 - ex.cos(angle)) / rate * K + (theta - ex.sin(angle) / rate) * (K @ K)
        p = shift @ ex.Expression(v)
    R_pi, p_pi = ex.Expression(home[:3, :3]) @ R, ex.Expression(home[:3, 3]) + ex.Expression(home[:3, :3]) @ p
    return ex.vertcat(
        ex.horzcat(R_pi.T, ex.zeros(3, 3)),
        ex.horzcat(-R_pi.T @ ex.skew(p_pi), R_pi.T),
    )


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
