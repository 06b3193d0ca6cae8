"""Dynamics of robots on rods: efforts for a motion, accelerations for efforts, energy.

Slender parts of even thickness move as three points of a sixth, four sixths and a sixth of their mass at their ends and
middle. With P' = J V of all points, platform (omega, v) = J_p V and motors q' = K V,

    M = sum m J'J + J_p' diag(I, m) J_p + K' diag(j) K,    M V' + h = K' tau.

Reference: Merlet, Parallel Robots, 2nd ed., ch. 9 (principle of virtual work).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, not_negative, real_array, require_finite, single, spread
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.parallel.legs.leg_lines import require_regular
from mafsil.parallel.legs.rod_robot import LegDrive, RodRobot

SHARES = ((0.0, 1 / 6), (0.5, 4 / 6), (1.0, 1 / 6))
"""Places along a slender part, and how much of its mass moves there."""


@dataclass(frozen=True, eq=False)
class RodMasses:
    """Masses of a robot on rods.

    Attributes:
        platform: with what it carries [kg].
        rods: one or (m,) [kg]; of rods that motors extend half is the cylinder, half the piston.
        com: (3,) centre of mass of the platform in {b} [m].
        inertia: (3, 3) about it, in {b} [kg m^2].
        arms: of cranks of even thickness, one or (m,) [kg].
        motors: inertia of each motor about the axis of its crank [kg m^2], or mass of its carriage [kg].
        sleeves: length of cylinders and of pistons [m].
    """

    platform: float
    rods: Floats = field(default_factory=lambda: frozen(0.0))
    com: Floats = field(default_factory=lambda: frozen(np.zeros(3)))
    inertia: Floats = field(default_factory=lambda: frozen(np.zeros((3, 3))))
    arms: Floats = field(default_factory=lambda: frozen(0.0))
    motors: Floats = field(default_factory=lambda: frozen(0.0))
    sleeves: Floats = field(default_factory=lambda: frozen(0.0))

    def __post_init__(self) -> None:
        object.__setattr__(self, "platform", not_negative("platform", self.platform))
        I = single("inertia", self.inertia, (3, 3))
        if np.abs(I - I.T).max() > 0 or np.linalg.eigvalsh(I)[0] < 0:
            raise InputError("parallel.inertia", value=I.tolist())
        object.__setattr__(self, "inertia", frozen(I))
        object.__setattr__(self, "com", frozen(single("com", self.com, (3,))))
        for name in ("rods", "arms", "motors", "sleeves"):
            value = require_finite(name, real_array(name, getattr(self, name)))
            if value.ndim > 1:
                raise InputError("input.shape", name=name, expected="() or (m,)", got=value.shape, hint="")
            if not (value >= 0).all():
                raise InputError("input.positive", name=name, value=value.tolist())
            object.__setattr__(self, name, frozen(value))


@dataclass(frozen=True, eq=False)
class _State:
    """Points of mass and motors of a robot in motion: by columns of V, batches first.

    Attributes:
        mass: (k,) of the points [kg].
        P, J, bias: (*batch, k, 3) places, (*batch, k, 3, m) of P' = J V, and P'' at V' = 0.
        K, turn: (*batch, m, m) of q' = K V, and q'' at V' = 0.
        J_w: (3, m) of omega = J_w V.
        I, omega: (*batch, 3, 3) inertia of the platform in {s}, (*batch, 3).
    """

    mass: Floats
    P: Floats
    J: Floats
    bias: Floats
    K: Floats
    turn: Floats
    J_w: Floats
    I: Floats
    omega: Floats


@dataclass(frozen=True, eq=False)
class RodDynamics:
    """A robot on rods with masses: V is the motion of the platform in {s}, as of `RodRobot.jacobian`.

    Attributes:
        robot: its geometry.
        masses: of its parts.
        gravity: (3,) [m/s^2].
    """

    robot: RodRobot
    masses: RodMasses
    gravity: Floats = field(default_factory=lambda: frozen([0.0, 0.0, -9.81]))

    def __post_init__(self) -> None:
        object.__setattr__(self, "gravity", frozen(single("gravity", self.gravity, (3,))))

    def mass_matrix(self, x: ArrayLike, q: ArrayLike) -> Floats:
        """(*batch, m, m) M of the energy V' M V / 2.

        Args:
            x, q: poses or short coordinates, and coordinates of the motors (*batch, m) that belong together.
        """
        return self._inertia(self._state(x, q, np.zeros(self.robot.m)))

    def inverse_dynamics(self, x: ArrayLike, q: ArrayLike, V: ArrayLike, Vd: ArrayLike, F: ArrayLike = 0.0) -> Floats:
        """(*batch, m) efforts of the motors [N m | N] for a motion.

        Args:
            x, q: that belong together.
            V, Vd: (*batch, m) motion of the platform in {s} and its derivative.
            F: (*batch, m) wrench that the platform exerts on the world, dual to V.

        Raises:
            InputError: x and q do not belong together, or the robot is singular there.
        """
        at = self._state(x, q, V)
        acceleration = as_batch("Vd", Vd, (self.robot.m,), finite=True)
        W = np.einsum("...ij,...j->...i", self._inertia(at), acceleration) + self._rest(at) + real_array("F", F)
        across = require_regular(np.swapaxes(at.K, -1, -2))
        return np.asarray(np.linalg.solve(across, W[..., None])[..., 0], dtype=np.float64)

    def forward_dynamics(self, x: ArrayLike, q: ArrayLike, V: ArrayLike, tau: ArrayLike, F: ArrayLike = 0.0) -> Floats:
        """(*batch, m) V' of the platform for efforts of the motors (*batch, m); others as of `inverse_dynamics`."""
        at, effort = self._state(x, q, V), as_batch("tau", tau, (self.robot.m,), finite=True)
        W = np.einsum("...ji,...j->...i", at.K, effort) - self._rest(at) - real_array("F", F)
        return np.asarray(np.linalg.solve(require_regular(self._inertia(at)), W[..., None])[..., 0], dtype=np.float64)

    def energy(self, x: ArrayLike, q: ArrayLike, V: ArrayLike) -> tuple[Floats, Floats]:
        """(*batch,) kinetic energy and that of weight, zero at the origin of {s} [J]."""
        at, rate = self._state(x, q, V), as_batch("V", V, (self.robot.m,), finite=True)
        kinetic = 0.5 * np.einsum("...i,...ij,...j->...", rate, self._inertia(at), rate)
        return np.asarray(kinetic), np.asarray(-np.einsum("k,...ki,i->...", at.mass, at.P, self.gravity))

    def motor_accelerations(self, x: ArrayLike, q: ArrayLike, V: ArrayLike, Vd: ArrayLike) -> tuple[Floats, Floats]:
        """q' and q'' (*batch, m) of the motors for a motion of the platform."""
        at = self._state(x, q, V)
        rate, change = (as_batch(name, each, (self.robot.m,), finite=True) for name, each in (("V", V), ("Vd", Vd)))
        return np.einsum("...ij,...j->...i", at.K, rate), np.einsum("...ij,...j->...i", at.K, change) + at.turn

    @property
    def _motor_inertia(self) -> Floats:
        """(m,) inertia that motors add to their own motion; carriages are points of mass."""
        m = self.robot.m
        return np.zeros(m) if self.robot.drive is LegDrive.LINEAR else spread("motors", self.masses.motors, (m,))

    def _inertia(self, at: _State) -> Floats:
        M = np.einsum("k,...kia,...kib->...ab", at.mass, at.J, at.J) + at.J_w.T @ at.I @ at.J_w
        return M + np.einsum("...ia,i,...ib->...ab", at.K, self._motor_inertia, at.K)

    def _rest(self, at: _State) -> Floats:
        """H: what accelerations at V' = 0 and weights ask."""
        spin = np.cross(at.omega, np.einsum("...ij,...j->...i", at.I, at.omega))
        asked = np.einsum("k,...kia,...ki->...a", at.mass, at.J, at.bias - self.gravity) + spin @ at.J_w
        return asked + np.einsum("...ia,i,...i->...a", at.K, self._motor_inertia, at.turn)

    def _state(self, x: ArrayLike, q: ArrayLike, V: ArrayLike) -> _State:
        robot, m = self.robot, self.robot.m
        T, angle, rate = robot.poses(x), as_batch("q", q, (m,), finite=True), as_batch("V", V, (m,), finite=True)
        A, B = robot.motor_matrices(T, angle)
        K = np.asarray(np.linalg.solve(require_regular(B), A), dtype=np.float64)
        twist = np.zeros((*rate.shape[:-1], 6))
        twist[..., robot.motion.columns] = rate
        omega, v = twist[..., :3], twist[..., 3:]
        R, p = T[..., :3, :3], T[..., :3, 3]
        held = robot.rotating @ np.swapaxes(R, -1, -2) + p[..., None, :]
        body = np.concatenate([held, (p + R @ self.masses.com)[..., None, :]], axis=-2)
        J = np.concatenate([-rotation.hat(body), np.broadcast_to(np.eye(3), (*body.shape, 3))], axis=-1)
        J = J[..., robot.motion.columns]
        moved = v[..., None, :] + np.cross(omega[..., None, :], body)
        bent = np.cross(omega[..., None, :], moved)
        C, B_end, swing = robot.carriers(angle), robot.ends(T), self._swings(angle)
        qd = np.einsum("...ij,...j->...i", K, rate)
        turn, back = self._motor_bias(C, B_end, moved[..., :m, :], bent[..., :m, :], angle, qd)
        J_C = (
            swing[..., None] * K[..., None, :]
            if robot.drive is not LegDrive.EXTEND
            else np.zeros_like(J[..., :m, :, :])
        )
        near, far = _Points(C, J_C, back), _Points(B_end, J[..., :m, :, :], bent[..., :m, :])
        points = [(self.masses.platform * np.ones(1), _Points(body[..., m:, :], J[..., m:, :, :], bent[..., m:, :]))]
        points += self._slender(near, far, rate)
        parts = [each for _, each in points]
        shape = np.broadcast_shapes(*(each.P.shape[:-2] for each in parts), rate.shape[:-1])
        P, J, bias = (
            np.concatenate([np.broadcast_to(a, (*shape, *a.shape[-k:])) for a in arrays], axis=-k)
            for arrays, k in (([e.P for e in parts], 2), ([e.J for e in parts], 3), ([e.bias for e in parts], 2))
        )
        I: Floats = R @ self.masses.inertia @ np.swapaxes(R, -1, -2)
        J_w = np.eye(6)[:3, robot.motion.columns]
        return _State(np.concatenate([mass for mass, _ in points]), P, J, bias, K, turn, J_w, I, omega)

    def _swings(self, q: Floats) -> Floats:
        """(*batch, m, 3) C'; rods that motors extend stay where they are held."""
        return np.zeros((*q.shape, 3)) if self.robot.drive is LegDrive.EXTEND else self.robot.swings(q)

    def _motor_bias(
        self, C: Floats, B: Floats, Bd: Floats, bent: Floats, q: Floats, qd: Floats
    ) -> tuple[Floats, Floats]:
        """q'' (*batch, m) of the motors and C'' (*batch, m, 3) at V' = 0, from |B - C| = l twice differentiated."""
        robot, d = self.robot, B - C
        if robot.drive is LegDrive.EXTEND:
            l = np.linalg.norm(d, axis=-1)
            return ((d * bent).sum(axis=-1) + (Bd**2).sum(axis=-1) - qd**2) / l, np.zeros_like(bent)
        swing = robot.swings(q)
        inward = (robot.base - C) * qd[..., None] ** 2 if robot.drive is LegDrive.CRANK else np.zeros_like(bent)
        across = ((Bd - swing * qd[..., None]) ** 2).sum(axis=-1)
        turn = ((d * (bent - inward)).sum(axis=-1) + across) / (d * swing).sum(axis=-1)
        return turn, swing * turn[..., None] + inward

    def _slender(self, near: _Points, far: _Points, rate: Floats) -> list[tuple[Floats, _Points]]:
        """Points of the rods, or of their cylinders and pistons, and of the cranks."""
        robot, m = self.robot, self.robot.m
        rods = spread("rods", self.masses.rods, (m,))
        if robot.drive is LegDrive.EXTEND:
            along, long = _direction(near, far, rate), spread("sleeves", self.masses.sleeves, (m,))
            found = [(share * rods / 2, near.plus(along, s * long)) for s, share in SHARES]
            return found + [(share * rods / 2, far.plus(along, -s * long)) for s, share in SHARES]
        found = [(share * rods, near.between(far, s)) for s, share in SHARES]
        if robot.drive is LegDrive.CRANK:
            pivots = _Points(np.broadcast_to(robot.base, near.P.shape), 0.0 * near.J, 0.0 * near.bias)
            arms = spread("arms", self.masses.arms, (m,))
            found += [(share * arms, pivots.between(near, s)) for s, share in SHARES]
        if robot.drive is LegDrive.LINEAR:
            found.append((spread("motors", self.masses.motors, (m,)), near))
        return found


@dataclass(frozen=True, eq=False)
class _Points:
    """Places P (*batch, k, 3), J (*batch, k, 3, m) of P' = J V, and P'' at V' = 0; or directions."""

    P: Floats
    J: Floats
    bias: Floats

    def between(self, other: _Points, share: float) -> _Points:
        """A share of the way to others."""
        kept = 1.0 - share
        return _Points(
            kept * self.P + share * other.P, kept * self.J + share * other.J, kept * self.bias + share * other.bias
        )

    def plus(self, other: _Points, lengths: Floats) -> _Points:
        """Lengths (k,) along directions from here."""
        l = lengths[:, None]
        return _Points(self.P + l * other.P, self.J + l[..., None] * other.J, self.bias + l * other.bias)


def _direction(near: _Points, far: _Points, rate: Floats) -> _Points:
    """Unit directions from points to others: u' = (1 - u u') d' / |d|."""
    d, Jd = far.P - near.P, far.J - near.J
    s = np.linalg.norm(d, axis=-1)[..., None]
    u = d / s
    across = Jd - u[..., None] * (u[..., None] * Jd).sum(axis=-2, keepdims=True)
    J = across / s[..., None]
    ud, dd = (np.einsum("...ia,...a->...i", each, rate[..., None, :]) for each in (J, Jd))
    longer = (u * dd).sum(axis=-1, keepdims=True)
    bent = far.bias - near.bias
    bent = bent - u * (u * bent).sum(axis=-1, keepdims=True)
    return _Points(u, J, (bent - 2 * longer * ud) / s - u * (ud**2).sum(axis=-1, keepdims=True))
