"""The mechanics of a mechanism a second time, in NumPy, link by link as the textbooks have it.

Nothing here is shared with `mafsil.mechanics`: no expressions, no regrouped inertias, no chosen frames. All functions
take complex coordinates too, so that derivatives come from the complex step f'(x) = Im f(x + i h) / h, which loses no
digits.

References: Lynch & Park, Modern Robotics, ch. 4, 5 and 8; Squire & Trapp, Using complex variables to estimate
derivatives of real functions, SIAM Review 40, 1998.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.model import Inertial, JointKind, Mechanism
from mafsil.model.joint import differentiate, polynomial

Numbers: TypeAlias = NDArray[Any]
"""Real or complex numbers."""
STEP = 1e-40
"""The complex step: its square vanishes beside one, so that nothing is cut off."""


@dataclass(frozen=True, eq=False, slots=True)
class Motion:
    """What the recursion of Newton and Euler passes through, each link in its own frame.

    Attributes:
        V: (b, L, 6) twists.
        dV: (b, L, 6) their derivatives, gravity not among them.
        F: (b, L, 6) wrench that each link gets from the one before.
        tau: (b, n) joint efforts.
    """

    V: Numbers
    dV: Numbers
    F: Numbers
    tau: Numbers


class Textbook:
    """Kinematics and dynamics of one mechanism; q, qd, qdd are (b, n).

    Attributes:
        mechanism: open chain or tree.
        share: (joints, n) rate of each joint per coordinate rate; rows of mimic joints hold their multiplier. That of a
            joint that follows along a curve changes with q (`shares`): NaN here.
        offset: (joints,) of mimic joints.
        curves: number of a joint that follows along a curve, number of the coordinate, coefficients.
        carries: (L, joints) one where a joint lies between base and link.
        G: (L, 6, 6) inertias in the links' frames.
        armature: (joints,) inertia of the motors, seen at the joint.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.share, self.offset, self.curves = _couplings(mechanism)
        self.carries = _carry(mechanism)
        self.G = np.array([spatial_inertia(link.inertial) for link in mechanism.links])
        motors = [joint.actuator for joint in mechanism.joints]
        self.armature = np.array([0.0 if motor is None else motor.reflected_inertia for motor in motors])
        self.screws = np.array([joint.screw for joint in mechanism.joints]).reshape(-1, 6)

    def place(self, frame: str | None) -> tuple[int, Floats]:
        """Number of a link, and the pose in it of the frame that a name means: the tip frame for None."""
        names = self.mechanism.link_names
        return (names.index(self.mechanism.tip), np.asarray(self.mechanism.T_lt)) if frame is None else (
            names.index(frame), np.eye(4)
        )  # fmt: skip

    def shares(self, q: Numbers, order: int = 1) -> Numbers:
        """(b, joints, n) derivatives of the joints by the coordinates: the first, or a higher one, of curves."""
        lines = np.nan_to_num(self.share) if order == 1 else np.zeros_like(self.share)
        found = np.tile(lines.astype(q.dtype), (len(q), 1, 1))
        for joint, k, curve in self.curves:
            found[:, joint, k] = polynomial(differentiate(curve, order), q[:, k])
        return found

    def rates(self, q: Numbers, qd: Numbers) -> Numbers:
        """(b, joints) rates of the joints."""
        return np.einsum("bkn,bn->bk", self.shares(q), qd)

    def gains(self, q: Numbers, qd: Numbers, qdd: Numbers) -> Numbers:
        """(b, joints) accelerations of the joints."""
        return np.einsum("bkn,bn->bk", self.shares(q), qdd) + np.einsum("bkn,bn->bk", self.shares(q, 2), qd**2)

    def rotors(self, q: Numbers, qd: Numbers, qdd: Numbers) -> Numbers:
        """(b, n) efforts that accelerate the motors."""
        return np.einsum("bkn,bk->bn", self.shares(q), self.gains(q, qd, qdd) * self.armature)

    def poses(self, q: Numbers) -> Numbers:
        """(b, L, 4, 4) poses of all links in {s}."""
        theta = q @ np.nan_to_num(self.share).T + self.offset
        for joint, k, curve in self.curves:
            theta[:, joint] = polynomial(curve, q[:, k])
        found = [np.broadcast_to(np.asarray(self.mechanism.T_sb), (len(q), 4, 4)).astype(q.dtype)]
        for k, (joint, parent) in enumerate(zip(self.mechanism.joints, self.mechanism.parents, strict=True)):
            step = np.asarray(joint.T_pj) @ _screw_motion(joint.kind, np.asarray(joint.axis), joint.pitch, theta[:, k])
            found.append(found[parent] @ step)
        return np.stack(found, axis=1)

    def pose(self, q: Numbers, frame: str | None = None) -> Numbers:
        """(b, 4, 4) pose of a frame in {s}."""
        link, T_lf = self.place(frame)
        return self.poses(q)[:, link] @ T_lf

    def jacobian_space(self, q: Numbers, frame: str | None = None) -> Numbers:
        """(b, 6, n): column j is the screw of joint j, moved by all joints before it."""
        link, _ = self.place(frame)
        return self._space_jacobians(q, self.poses(q))[:, link]

    def jacobian_body(self, q: Numbers, frame: str | None = None) -> Numbers:
        """(b, 6, n) = Ad(T^-1) J_s."""
        return adjoint(inverse(self.pose(q, frame))) @ self.jacobian_space(q, frame)

    def link_jacobians(self, q: Numbers) -> Numbers:
        """(b, L, 6, n) body Jacobians of all links."""
        T = self.poses(q)
        return adjoint(inverse(T)) @ self._space_jacobians(q, T)

    def mass_matrix(self, q: Numbers) -> Numbers:
        """(b, n, n) sum of J_l' G_l J_l over the links, armatures added.

        Reference: Lynch & Park, Modern Robotics, eq. 8.57.
        """
        J = self.link_jacobians(q)
        links = np.einsum("blin,lij,bljm->bnm", J, self.G, J, optimize=True)
        share = self.shares(q)
        return links + np.einsum("bkn,k,bkm->bnm", share, self.armature, share)

    def kinetic_energy(self, q: Numbers, qd: Numbers) -> Numbers:
        """(b,) sum of V' G V / 2 over the links, and of the rotors."""
        V = np.einsum("blin,bn->bli", self.link_jacobians(q), qd)
        rotors = self.rates(q, qd) ** 2 @ self.armature
        return np.einsum("bli,lij,blj->b", V, self.G, V) / 2 + rotors / 2

    def potential_energy(self, q: Numbers) -> Numbers:
        """(b,) minus the sum of m g . p_com over the links."""
        T, energy = self.poses(q), np.zeros(len(q), dtype=q.dtype)
        for k, link in enumerate(self.mechanism.links):
            if link.inertial is not None:
                p = T[:, k, :3, :3] @ link.inertial.com + T[:, k, :3, 3]
                energy = energy - link.inertial.mass * (p @ self.mechanism.gravity)
        return energy

    def christoffel_symbols(self, q: Floats) -> Floats:
        """(b, n, n, n) Gamma_ijk = (dm_ij/dq_k + dm_ik/dq_j - dm_jk/dq_i) / 2, by the complex step.

        Reference: Lynch & Park, Modern Robotics, eq. 8.12.
        """
        dM = gradient(self.mass_matrix, q)
        return (dM + np.swapaxes(dM, 2, 3) - np.moveaxis(dM, 3, 1)) / 2

    def twists(self, q: Floats, qd: Floats, base_twist: Floats | None = None) -> Floats:
        """(b, L, 6) twists of the links: J_l qd, and the base's twist seen from each link."""
        V = np.einsum("blin,bn->bli", self.link_jacobians(q), qd)
        if base_twist is None:
            return V
        return V + np.einsum("blij,bj->bli", adjoint(inverse(self.poses(q))), base_twist)

    def accelerations(
        self,
        q: Floats,
        qd: Floats,
        qdd: Floats,
        base_twist: Floats | None = None,
        base_acceleration: Floats | None = None,
    ) -> Floats:
        """(b, L, 6) derivatives of the links' twists: J qdd + dJ/dt qd, dJ/dt by the complex step along qd."""
        J = self.link_jacobians(q)
        dJ = along(self.link_jacobians, q, qd)
        dV = np.einsum("blin,bn->bli", J, qdd) + np.einsum("blin,bn->bli", dJ, qd)
        if base_twist is None or base_acceleration is None:
            return dV

        def seen(q: Numbers) -> Numbers:
            return adjoint(inverse(self.poses(q)))

        turned = np.einsum("blij,bj->bli", along(seen, q, qd), base_twist)
        return dV + turned + np.einsum("blij,bj->bli", seen(q), base_acceleration)

    def virtual_work(
        self, q: Floats, qd: Floats, qdd: Floats, tip_wrench: Floats | None = None, *, weight: float = 1.0
    ) -> Floats:
        """(b, n) efforts by d'Alembert: every link's inertia and weight times its virtual displacement.

        Args:
            q, qd, qdd: motion.
            tip_wrench: (b, 6) that the tip exerts on the world, in the tip frame.
            weight: 0 leaves gravity out.
        """
        J, T = self.link_jacobians(q), self.poses(q)
        V = np.einsum("blin,bn->bli", J, qd)
        W = self._wrench_needed(V, self.accelerations(q, qd, qdd), T, self.mechanism.gravity * weight)
        tau = np.einsum("blin,bli->bn", J, W) + self.rotors(q, qd, qdd)
        return tau if tip_wrench is None else tau + np.einsum("bin,bi->bn", self.jacobian_body(q), tip_wrench)

    def newton_euler(
        self,
        q: Numbers,
        qd: Numbers,
        qdd: Numbers,
        tip_wrench: Numbers | None = None,
        base_twist: Numbers | None = None,
        base_acceleration: Numbers | None = None,
    ) -> Motion:
        """The recursion over the links; arguments as in `Robot.inverse_dynamics`.

        V_l = Ad(T_lp) V_p + S qd, dV_l = Ad(T_lp) dV_p + [V_l, S qd] + S qdd,
        F_l = G (dV_l - g) - ad(V_l)' G V_l + sum of Ad(T_cl)' F_c, tau = S . F

        Reference: Lynch & Park, Modern Robotics, sec. 8.3.2.
        """
        T = self.poses(q)
        X = self._to_children(T)
        gains = self.gains(q, qd, qdd)
        V, dV = self._outward(X, self.rates(q, qd), gains, T, base_twist, base_acceleration)
        F = self._wrench_needed(V, dV, T, self.mechanism.gravity)
        if tip_wrench is not None:
            link, T_lt = self.place(None)
            F[:, link] += tip_wrench @ adjoint(inverse(T_lt))
        for k, parent in reversed(list(enumerate(self.mechanism.parents))):
            F[:, parent] += np.einsum("bji,bj->bi", X[k], F[:, k + 1])
        efforts = np.einsum("ki,bki->bk", self.screws, F[:, 1:]) + gains * self.armature
        return Motion(V, dV, F, np.einsum("bk,bkn->bn", efforts, self.shares(q)))

    def accelerations_of(self, q: Numbers, qd: Numbers, tau: Numbers, tip_wrench: Numbers | None = None) -> Numbers:
        """(b, n) joint accelerations: M qdd = tau - tau(q, qd, 0), solved."""
        bias = self.newton_euler(q, qd, np.zeros_like(qd), tip_wrench).tau
        return np.linalg.solve(self.mass_matrix(q), (tau - bias)[..., None])[..., 0]

    def _space_jacobians(self, q: Numbers, T: Numbers) -> Numbers:
        """(b, L, 6, n) space Jacobians of all links."""
        if not len(self.screws):
            return np.zeros((*T.shape[:2], 6, q.shape[1]), dtype=q.dtype)
        S = np.einsum("bkij,kj->bki", adjoint(T[:, 1:]), self.screws)
        return np.einsum("bki,lk,bkn->blin", S, self.carries, self.shares(q), optimize=True)

    def _to_children(self, T: Numbers) -> list[Numbers]:
        """Ad(T_cp) (b, 6, 6) of every joint's child c and parent p."""
        pairs = enumerate(self.mechanism.parents)
        return [adjoint(inverse(T[:, k + 1]) @ T[:, parent]) for k, parent in pairs]

    def _outward(
        self, X: list[Numbers], rates: Numbers, gains: Numbers, T: Numbers, V_0: Numbers | None, dV_0: Numbers | None
    ) -> tuple[Numbers, Numbers]:
        rest = np.zeros((len(rates), 6), dtype=rates.dtype)
        home = adjoint(inverse(T[:, 0]))
        V = [np.einsum("bij,bj->bi", home, rest if V_0 is None else V_0)]
        dV = [np.einsum("bij,bj->bi", home, rest if dV_0 is None else dV_0)]
        for k, parent in enumerate(self.mechanism.parents):
            own = rates[:, k, None] * self.screws[k]
            V.append(np.einsum("bij,bj->bi", X[k], V[parent]) + own)
            carried = np.einsum("bij,bj->bi", X[k], dV[parent])
            dV.append(carried + bracket(V[-1], own) + gains[:, k, None] * self.screws[k])
        return np.stack(V, axis=1), np.stack(dV, axis=1)

    def _wrench_needed(self, V: Numbers, dV: Numbers, T: Numbers, gravity: Floats) -> Numbers:
        """(b, L, 6) wrench that each link's own motion and weight need: G (dV - g) - ad(V)' G V."""
        fall = np.zeros_like(V)
        fall[..., 3:] = np.einsum("blji,j->bli", T[..., :3, :3], gravity)
        momentum = np.einsum("lij,blj->bli", self.G, V)
        return np.einsum("lij,blj->bli", self.G, dV - fall) - dual_bracket(V, momentum)


def spatial_inertia(inertial: Inertial | None) -> Floats:
    """(6, 6) inertia in the frame in which the body is given: [[I + m [c]'[c], m [c]], [m [c]', m E]]."""
    if inertial is None:
        return np.zeros((6, 6))
    m, C = inertial.mass, skew(np.asarray(inertial.com))
    return np.block([[inertial.inertia + m * C.T @ C, m * C], [m * C.T, m * np.eye(3)]])


def skew(x: Numbers) -> Numbers:
    """(*b, 3, 3) matrix of the vector product with x (*b, 3)."""
    zero = np.zeros_like(x[..., 0])
    rows = [[zero, -x[..., 2], x[..., 1]], [x[..., 2], zero, -x[..., 0]], [-x[..., 1], x[..., 0], zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def inverse(T: Numbers) -> Numbers:
    """(*b, 4, 4) inverse of poses, without conjugation."""
    Rt = np.swapaxes(T[..., :3, :3], -1, -2)
    found = np.zeros_like(T)
    found[..., :3, :3], found[..., 3, 3] = Rt, 1.0
    found[..., :3, 3] = -np.einsum("...ij,...j->...i", Rt, T[..., :3, 3])
    return found


def adjoint(T: Numbers) -> Numbers:
    """(*b, 6, 6) Ad(T) = [[R, 0], [[p] R, R]]."""
    R = T[..., :3, :3]
    found = np.zeros((*T.shape[:-2], 6, 6), dtype=T.dtype)
    found[..., :3, :3] = found[..., 3:, 3:] = R
    found[..., 3:, :3] = skew(T[..., :3, 3]) @ R
    return found


def bracket(V: Numbers, W: Numbers) -> Numbers:
    """[V, W] (*b, 6) = (w x w', w x v' - w' x v)."""
    w, v, w2, v2 = V[..., :3], V[..., 3:], W[..., :3], W[..., 3:]
    return np.concatenate([np.cross(w, w2), np.cross(w, v2) + np.cross(v, w2)], axis=-1)


def dual_bracket(V: Numbers, P: Numbers) -> Numbers:
    """ad(V)' P (*b, 6) = (m x w + f x v, f x w)."""
    w, v, m, f = V[..., :3], V[..., 3:], P[..., :3], P[..., 3:]
    return np.concatenate([np.cross(m, w) + np.cross(f, v), np.cross(f, w)], axis=-1)


def along(function: Callable[[Numbers], Numbers], x: Floats, direction: Floats) -> Floats:
    """Derivative of a function (b, n) -> (b, ...) at x (b, n) along a direction (b, n), by the complex step."""
    return np.imag(function(x + 1j * STEP * direction)) / STEP


def gradient(function: Callable[[Numbers], Numbers], x: Floats) -> Floats:
    """(b, ..., n) derivatives of a function by every component of x (b, n), by the complex step."""
    count, n = x.shape
    directions = np.tile(np.eye(n), (count, 1))
    values = along(function, np.repeat(x, n, axis=0), directions)
    return np.moveaxis(values.reshape(count, n, *values.shape[1:]), 1, -1)


def repeat_states(x: Numbers, count: int) -> Numbers:
    """Rows of states repeated for the directions in which `gradient` asks."""
    return np.repeat(x, count // len(x), axis=0)


def _couplings(mechanism: Mechanism) -> tuple[Floats, Floats, list[tuple[int, int, tuple[float, ...]]]]:
    names, curves = mechanism.joint_names, list[tuple[int, int, tuple[float, ...]]]()
    share, offset = np.zeros((len(mechanism.joints), len(names))), np.zeros(len(mechanism.joints))
    for k, joint in enumerate(mechanism.joints):
        if joint.moves and joint.mimic is None:
            share[k, names.index(joint.name)] = 1.0
        elif joint.mimic is not None:
            leader = names.index(joint.mimic.leader)
            share[k, leader], offset[k] = joint.mimic.multiplier, joint.mimic.offset
            if joint.mimic.higher:
                share[k, leader] = np.nan
                curves.append((k, leader, joint.mimic.curve()))
    return share, offset, curves


def _carry(mechanism: Mechanism) -> Floats:
    found = np.zeros((len(mechanism.links), len(mechanism.joints)))
    for k, parent in enumerate(mechanism.parents):
        found[k + 1] = found[parent]
        found[k + 1, k] = 1.0
    return found


def _screw_motion(kind: JointKind, axis: Floats, pitch: float, theta: Numbers) -> Numbers:
    """(b, 4, 4) motion of a joint by Rodrigues' formula."""
    T = np.tile(np.eye(4, dtype=theta.dtype), (len(theta), 1, 1))
    if kind in (JointKind.REVOLUTE, JointKind.HELICAL):
        K, s, c = skew(axis), np.sin(theta)[:, None, None], np.cos(theta)[:, None, None]
        T[:, :3, :3] = np.eye(3) + s * K + (1 - c) * (K @ K)
        T[:, :3, 3] = theta[:, None] * (pitch * axis)
    elif kind is JointKind.PRISMATIC:
        T[:, :3, 3] = theta[:, None] * axis
    return T
