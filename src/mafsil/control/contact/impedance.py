"""Impedance: the tip behaves as a mass, a damper and a spring that someone else pushes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array, require_finite, require_function, single
from mafsil.control.contact.tip_sensor import TaskForceSensor, from_outside
from mafsil.control.laws.law import Law
from mafsil.control.laws.matrix_feedback import symmetric
from mafsil.control.laws.task_coordinates import TaskCoordinates, task_dynamics
from mafsil.control.laws.tip_motion import TipReference
from mafsil.errors import InputError
from mafsil.fields import check_fields, square
from mafsil.one_joint import JointArm, JointLaw, sampled_stability
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

NO_INVERSE = 1e-14
"""Share of the largest singular value of Z below which it has no inverse: rounding."""


@dataclass(frozen=True, eq=False, slots=True)
class Impedance:
    """D dV/dt + B V + K X = F_ext, X and V against the reference.

    Attributes:
        inertia, damping, stiffness: (m, m) D, B, K; symmetric, not negative.
    """

    inertia: Floats
    damping: Floats
    stiffness: Floats
    __post_init__ = check_fields(inertia=square, damping=square, stiffness=square)

    @classmethod
    def of(cls, m: int, *, inertia: ArrayLike = 0.0, damping: ArrayLike = 0.0, stiffness: ArrayLike = 0.0) -> Impedance:
        """From numbers, diagonals (m,) or matrices (m, m).

        Raises:
            InputError: a wrong shape, a matrix that is not symmetric or has a negative eigenvalue.
        """
        given = (("inertia", inertia), ("damping", damping), ("stiffness", stiffness))
        return cls(*(symmetric(name, value, m) for name, value in given))

    def acceleration(self, X: Floats, V: Floats, force: Floats) -> Floats:
        """(*batch, m) dV/dt = D^-1 (F_ext - B V - K X).

        Args:
            X, V: (*batch, m) away from the reference.
            force: (*batch, m) from outside.

        Raises:
            InputError: D has no inverse.
        """
        self._require_mass()
        X, V, force = (as_batch(name, x, self.damping.shape[-1:]) for name, x in (("X", X), ("V", V), ("force", force)))
        push = force - V @ self.damping - X @ self.stiffness
        return real_array("inertia", np.linalg.solve(self.inertia, push[..., None]))[..., 0]

    def frequency_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """(*k, m, m) Z(jw) = K + jw B - w^2 D: force for a motion of one unit; its inverse is the admittance.

        Below the natural frequency it is the spring, above it the mass.

        Args:
            frequency: (*k) w [rad/s].
        """
        w = require_finite("frequency", real_array("frequency", frequency))[..., None, None]
        return np.asarray(self.stiffness - w**2 * self.inertia + 1j * w * self.damping, dtype=np.complex128)

    def admittance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """(*k, m, m) Y(jw) = Z(jw)^-1: motion for a force of one unit; infinite where Z has no inverse.

        Args:
            frequency: (*k) w [rad/s].
        """
        Z = self.frequency_response(frequency)
        sizes = np.linalg.svd(Z, compute_uv=False)
        known = sizes[..., -1] > NO_INVERSE * sizes[..., 0]
        Y = np.full(Z.shape, complex(np.inf))
        Y[known] = np.linalg.inv(Z[known])
        return Y

    def asymptotes(self, frequency: ArrayLike) -> ImpedanceAsymptotes:
        """What Z(jw) tends to: K for slow motions, -w^2 D for fast ones.

        Args:
            frequency: (*k) w [rad/s].
        """
        w = require_finite("frequency", real_array("frequency", frequency))[..., None, None]
        return ImpedanceAsymptotes(self.stiffness + 0.0 * w, -(w**2) * self.inertia)

    @property
    def natural_frequency(self) -> Floats:
        """(m,) increasing, of D and K alone [rad/s].

        Raises:
            InputError: D has no inverse.
        """
        return self._modes()[0]

    @property
    def damping_ratio(self) -> Floats:
        """(m,) of the modes of D and K, in the order of `natural_frequency`: b / 2 sqrt(k m) along one direction.

        Above one where a mode does not oscillate, infinite without a spring. What B couples of the modes is not in it.

        Raises:
            InputError: D has no inverse.
        """
        w, modes = self._modes()
        own = np.einsum("ik,ij,jk->k", modes, self.damping, modes)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(own > 0.0, own / (2.0 * w), 0.0), dtype=np.float64)

    def _modes(self) -> tuple[Floats, Floats]:
        """(m,) natural frequencies, increasing, and (m, m) modes with modes' D modes = 1, as columns."""
        self._require_mass()
        L = np.linalg.inv(np.linalg.cholesky(self.inertia))
        squares, axes = np.linalg.eigh(L @ self.stiffness @ L.T)
        return np.sqrt(np.asarray(squares, dtype=np.float64).clip(0.0)), np.asarray(L.T @ axes, dtype=np.float64)

    @property
    def roots(self) -> NDArray[np.complex128]:
        """(2 m,) of the free motion [1/s].

        Raises:
            InputError: D has no inverse.
        """
        self._require_mass()
        m = len(self.inertia)
        below = np.linalg.solve(self.inertia, np.hstack([-self.stiffness, -self.damping]))
        whole = np.vstack([np.hstack([np.zeros((m, m)), np.eye(m)]), below])
        return np.asarray(np.linalg.eigvals(whole), dtype=np.complex128)

    def _require_mass(self) -> None:
        if np.linalg.matrix_rank(self.inertia, hermitian=True) < len(self.inertia):
            raise InputError("control.no_virtual_mass")


class ImpedanceAsymptotes(NamedTuple):
    """Low- and high-frequency asymptotes of an impedance, (*k, m, m) each, in the units of Z.

    Attributes:
        spring: K, of slow motions.
        mass: -w^2 D, of fast ones.
    """

    spring: Floats
    mass: Floats


@dataclass(frozen=True, eq=False, slots=True)
class ImpedanceControl:
    """Motion is sensed, effort commanded: tau = J' (Lambda dV/dt + gamma + eta - F),  F what the impedance wants.

    With a force sensor dV/dt = D^-1 (F_ext - B V_x - K X_x) is known, F = F_ext: the arm's inertia is not felt.
    Without one tau = J' (gamma + eta - B V_x - K X_x): the arm's own inertia is felt instead of D.

    Attributes:
        robot: the model.
        coordinates: of the task.
        impedance: that the tip should have.
        reference: from which its spring is measured.
        sensor: (q, qd) -> (m,) force from outside on the tip, or None.
        shift_acceleration: whether the mass too is measured from the reference, D (dV/dt - A_d): without a force from
            outside the tip then follows exactly.
    """

    robot: Robot
    coordinates: TaskCoordinates
    impedance: Impedance
    reference: TipReference
    sensor: TaskForceSensor | None
    shift_acceleration: bool = False

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        X_e, V_e, ahead = self.coordinates.error(self.coordinates.pose(self.robot, q), self.reference(t), now.V)
        ahead = ahead if self.shift_acceleration else 0.0 * ahead
        if self.sensor is None:
            spring = X_e @ self.impedance.stiffness + V_e @ self.impedance.damping
            return now.effort(now.force(ahead) + spring)
        outside = self.sensor(q, qd)
        return now.effort(now.force(ahead + self.impedance.acceleration(-X_e, -V_e, outside)) - outside)

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def impedance_control(
    robot: Robot,
    impedance: Impedance,
    reference: TipReference,
    *,
    coordinates: TaskCoordinates | None = None,
    sensor: TaskForceSensor | None = None,
    shift_acceleration: bool = False,
) -> ImpedanceControl:
    """The tip as mass, damper and spring about a reference: D dV/dt + B (V - V_d) + K (X - X_d) = F_ext.

    Suited to light arms without much friction; renders low impedances well.

    Args:
        robot: the model.
        impedance: (m) that is wanted; its inertia needs a sensor.
        reference: of the tip.
        coordinates: of the task; all six, decoupled, if None.
        sensor: a `TipForceSensor`, or a function (q, qd) -> (m,) of the force from outside on the tip.
        shift_acceleration: D (dV/dt - A_d) instead of D dV/dt, which follows a moving reference exactly.

    Raises:
        InputError: an impedance of another size.

    Reference: Hogan, Impedance control, 1985; Lynch and Park, Modern Robotics, eq. (11.66).
    """
    require_function("reference", reference, "function of time", 1)
    if sensor is not None:
        require_function("sensor", sensor, "function (q, qd)", 2)
        sensor = from_outside(sensor)
    task = coordinates or TaskCoordinates()
    require_size(impedance, task)
    return ImpedanceControl(robot, task, impedance, reference, sensor, shift_acceleration)


def require_size(impedance: Impedance, task: TaskCoordinates) -> None:
    """Raise where an impedance has not as many rows as a task has coordinates.

    Args:
        impedance: that is wanted.
        task: coordinates.

    Raises:
        InputError: another size.
    """
    if len(impedance.inertia) != len(task.rows):
        details = {"expected": (len(task.rows),) * 2, "got": impedance.inertia.shape, "hint": ""}
        raise InputError("input.shape", name="impedance", **details)


def stiffest_wall(damping: float, period: float) -> float:
    """The stiffest virtual wall that a sampled arm can render without giving out energy: K = 2 b/T [N/m].

    Args:
        damping: b of the arm itself [N s/m].
        period: T of the control [s].

    Reference: Colgate and Schenkel, Passivity of a class of sampled-data systems, 1997; Lynch and Park, sec. 11.7.1.
    """
    return 2.0 * positive("damping", damping) / positive("period", period)


def sampled_wall_radius(mass: float, damping: float, stiffness: float, period: float, delay: int = 0) -> float:
    """Spectral radius of a mass against a virtual wall whose force is held over each period; below one it is stable.

    Args:
        mass, damping: of the arm [kg, N s/m].
        stiffness: of the wall [N/m].
        period: T [s].
        delay: of the force, in periods.

    Raises:
        InputError: a number out of its range.
    """
    device = JointArm.of(positive("mass", mass), friction=single("damping", damping, ()))
    law = JointLaw.pid(single("stiffness", stiffness, ()))
    found = sampled_stability(device, law, positive("period", period), delay)
    return float(found.spectral_radius)
