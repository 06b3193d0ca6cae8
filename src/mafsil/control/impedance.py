"""Impedance and admittance: the tip behaves as a mass, a damper and a spring that someone else pushes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, positive, real_array, require_finite
from mafsil.control.gains import Gains
from mafsil.control.hybrid import TaskForceSensor
from mafsil.control.law import Law
from mafsil.control.task_coordinates import TaskCoordinates
from mafsil.control.task_dynamics import task_dynamics
from mafsil.control.tip_motion import TipReference
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class Impedance:
    """D dV/dt + B V + K X = F_ext, X and V against the reference.

    Attributes:
        inertia, damping, stiffness: (m, m) D, B, K; symmetric, not negative.
    """

    inertia: Floats
    damping: Floats
    stiffness: Floats

    @classmethod
    def of(cls, m: int, *, inertia: ArrayLike = 0.0, damping: ArrayLike = 0.0, stiffness: ArrayLike = 0.0) -> Impedance:
        """From numbers, diagonals (m,) or matrices (m, m).

        Raises:
            InputError: a wrong shape, a matrix that is not symmetric or has a negative eigenvalue.
        """
        given = (("inertia", inertia), ("damping", damping), ("stiffness", stiffness))
        return cls(*(_matrix(name, value, m) for name, value in given))

    def acceleration(self, X: Floats, V: Floats, force: Floats) -> Floats:
        """(*batch, m) dV/dt = D^-1 (F_ext - B V - K X).

        Args:
            X, V: (*batch, m) away from the reference.
            force: (*batch, m) from outside.

        Raises:
            InputError: D has no inverse.
        """
        if np.linalg.matrix_rank(self.inertia, hermitian=True) < len(self.inertia):
            raise InputError("control.no_virtual_mass")
        push = force - V @ self.damping - X @ self.stiffness
        return np.asarray(np.linalg.solve(self.inertia, push[..., None])[..., 0], dtype=np.float64)

    def frequency_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """(*k, m, m) Z(jw) = K + jw B - w^2 D: force for a motion of one unit; its inverse is the admittance.

        Below the natural frequency it is the spring, above it the mass.

        Args:
            frequency: (*k) w [rad/s].
        """
        w = require_finite("frequency", real_array("frequency", frequency))[..., None, None]
        return np.asarray(self.stiffness - w**2 * self.inertia + 1j * w * self.damping, dtype=np.complex128)

    @property
    def natural_frequency(self) -> Floats:
        """(m,) increasing, of D and K alone [rad/s]."""
        squares = np.linalg.eigvals(np.linalg.solve(self.inertia, self.stiffness)).real
        return np.asarray(np.sqrt(np.sort(squares).clip(0.0)), dtype=np.float64)

    @property
    def roots(self) -> NDArray[np.complex128]:
        """(2 m,) of the free motion [1/s]."""
        m = len(self.inertia)
        below = np.linalg.solve(self.inertia, np.hstack([-self.stiffness, -self.damping]))
        whole = np.vstack([np.hstack([np.zeros((m, m)), np.eye(m)]), below])
        return np.asarray(np.linalg.eigvals(whole), dtype=np.complex128)


def _matrix(name: str, value: ArrayLike, m: int) -> Floats:
    array = require_finite(name, real_array(name, value))
    if array.shape not in ((), (m,), (m, m)):
        raise InputError("input.shape", name=name, expected=(m, m), got=array.shape, hint="")
    full = array if array.shape == (m, m) else np.diag(np.broadcast_to(array, (m,)))
    if not np.allclose(full, full.T, rtol=1e-9, atol=0.0):
        raise InputError("control.not_symmetric", name=name)
    least = float(np.linalg.eigvalsh(full)[0])
    if least < -1e-12 * max(float(np.abs(full).max()), 1e-300):
        raise InputError("input.range", name=name, value=least, low=0.0, high=np.inf)
    return full.astype(np.float64)


@dataclass(frozen=True, eq=False, slots=True)
class ImpedanceControl:
    """Motion is sensed, effort commanded: tau = J' (Lambda dV/dt + gamma + eta - F),  F what the impedance wants.

    With a force sensor dV/dt = A_d + D^-1 (F_ext - B V_x - K X_x) is known, F = F_ext: the arm's inertia is not felt.
    Without one tau = J' (gamma + eta - B V_x - K X_x + Lambda A_d): the arm's own inertia is felt instead of D.

    Attributes:
        robot: the model.
        coordinates: of the task.
        impedance: that the tip should have.
        reference: from which its spring is measured.
        sensor: (q, qd) -> (m,) force from outside on the tip, or None.
    """

    robot: Robot
    coordinates: TaskCoordinates
    impedance: Impedance
    reference: TipReference
    sensor: TaskForceSensor | None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        X_e, V_e, ahead = self.coordinates.error(self.coordinates.pose(self.robot, q), self.reference(t), now.V)
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
) -> ImpedanceControl:
    """The tip as mass, damper and spring about a reference.

    Suited to light arms without much friction; renders low impedances well.

    Args:
        robot: the model.
        impedance: (m) that is wanted; its inertia needs a sensor.
        reference: of the tip.
        coordinates: of the task; all six, decoupled, if None.
        sensor: (q, qd) -> (m,) force from outside on the tip.

    Raises:
        InputError: an impedance of another size.

    Reference: Hogan, Impedance control, 1985; Lynch and Park, Modern Robotics, eq. (11.66).
    """
    task = coordinates or TaskCoordinates()
    _require_size(impedance, task)
    return ImpedanceControl(robot, task, impedance, reference, sensor)


def _require_size(impedance: Impedance, task: TaskCoordinates) -> None:
    if len(impedance.inertia) != len(task.rows):
        details = {"expected": (len(task.rows),) * 2, "got": impedance.inertia.shape, "hint": ""}
        raise InputError("input.shape", name="impedance", **details)


@dataclass(frozen=True, eq=False, slots=True)
class AdmittanceControl:
    """Force is sensed, motion commanded: dV/dt = A_d + D^-1 (F_ext - B V_x - K X_x), tracked by computed torque.

    One period ahead the virtual mass is at V + dt dV/dt and X + dt V; gains pull the arm there. What the sensor
    reads is compensated, or it would push the arm itself.

    Attributes:
        robot: the model.
        coordinates: of the task.
        impedance: that the tip should have.
        gains: (m,) of the tracking, in units of acceleration.
        reference: from which its spring is measured.
        sensor: (q, qd) -> (m,) force from outside on the tip.
        period: of the control [s]; set by the session.
    """

    robot: Robot
    coordinates: TaskCoordinates
    impedance: Impedance
    gains: Gains
    reference: TipReference
    sensor: TaskForceSensor
    period: float = 0.0

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        X_e, V_e, ahead = self.coordinates.error(self.coordinates.pose(self.robot, q), self.reference(t), now.V)
        outside = self.sensor(q, qd)
        wanted = self.impedance.acceleration(-X_e, -V_e, outside)
        return now.effort(now.force(ahead + self.commanded(now.V, wanted)) - outside)

    def commanded(self, V: Floats, wanted: Floats) -> Floats:
        """(*batch, m) acceleration that computed torque is given: dV/dt + Kp dt V + Kd dt dV/dt.

        Args:
            V: (*batch, m) velocity of the tip.
            wanted: (*batch, m) dV/dt of the virtual mass.
        """
        return wanted + self.gains.kp * self.period * V + self.gains.kd * self.period * wanted

    def session(self, period: float) -> Law:
        """The law at a control period."""
        return AdmittanceControl(
            self.robot, self.coordinates, self.impedance, self.gains, self.reference, self.sensor, period
        )


@of_robot
def admittance_control(
    robot: Robot,
    impedance: Impedance,
    reference: TipReference,
    sensor: TaskForceSensor,
    *,
    coordinates: TaskCoordinates | None = None,
    gains: Gains | None = None,
) -> AdmittanceControl:
    """The tip moves as a mass, damper and spring would under the force that is sensed.

    Suited to geared, stiff arms; renders high impedances well.

    Args:
        robot: the model.
        impedance: (m) that is wanted, with a mass in every direction.
        reference: of the tip.
        sensor: (q, qd) -> (m,) force from outside on the tip.
        coordinates: of the task; all six, decoupled, if None.
        gains: (m,) of the tracking; none if None, for the state itself is the start of each step.

    Raises:
        InputError: an impedance of another size or without mass.

    Reference: Lynch and Park, Modern Robotics, eq. (11.67).
    """
    task = coordinates or TaskCoordinates()
    _require_size(impedance, task)
    m = len(task.rows)
    impedance.acceleration(np.zeros(m), np.zeros(m), np.zeros(m))
    return AdmittanceControl(robot, task, impedance, gains or Gains.of(m, 0.0, 0.0), reference, sensor)


class EffectiveImpedance(NamedTuple):
    """What an admittance step of a period feels like when its tracking has gains."""

    inertia: float
    damping: float
    stiffness: float


def effective_admittance(
    inertia: float, damping: float, stiffness: float, *, kp: float, kd: float, period: float
) -> EffectiveImpedance:
    """The impedance along one direction that tracking a period ahead makes of a wanted one.

    The command (1 + kd dt) dV/dt + kp dt V is an impedance of D/(1 + kd dt), B/(1 + kd dt) ... in which kp dt D adds to
    what drives: D_e = D/(1 + kd dt),  B_e = B - kp dt D_e,  K_e = K.

    Args:
        inertia, damping, stiffness: D, B, K that are wanted.
        kp, kd: gains of the tracking [1/s^2, 1/s].
        period: dt [s].
    """
    D = inertia / (1.0 + kd * period)
    return EffectiveImpedance(D, damping - kp * period * D, stiffness)


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

    1. The exact step of the mass under a constant force.
    2. The force of `delay` periods ago is kept in a queue; eigenvalues of the whole.

    Args:
        mass, damping: of the arm [kg, N s/m].
        stiffness: of the wall [N/m].
        period: T [s].
        delay: of the force, in periods.
    """
    m, T = positive("mass", mass), positive("period", period)
    b = max(damping, 1e-12 * m / T)
    # 1.
    e, gone = np.exp(-b * T / m), -np.expm1(-b * T / m)
    A = np.array([[1.0, m / b * gone], [0.0, e]])
    B = np.array([T / b - m / b**2 * gone, gone / b])
    # 2.
    n = 2 + delay
    whole = np.zeros((n, n))
    whole[:2, :2] = A
    if delay:
        whole[:2, 2 + delay - 1] = B
        whole[2, 0] = -stiffness
        for k in range(3, n):
            whole[k, k - 1] = 1.0
    else:
        whole[:2, 0] -= B * stiffness
    return float(np.abs(np.linalg.eigvals(whole)).max())


def least_virtual_mass(damping: float, stiffness: float, period: float) -> float:
    """The smallest mass that an admittance step can render: D > B dt/2 + K dt^2/4.

    Of the semi-implicit step (velocity first, then position with the new velocity); K is all that is against the tip,
    its own spring and the environment's.

    Args:
        damping, stiffness: B, and K with the environment's [N s/m, N/m].
        period: dt [s].
    """
    dt = positive("period", period)
    return damping * dt / 2.0 + stiffness * dt**2 / 4.0


def admittance_radius(
    inertia: float, damping: float, stiffness: float, period: float, *, explicit: bool = False
) -> float:
    """Spectral radius of the admittance step of a virtual mass; below one it is stable.

    Args:
        inertia, damping, stiffness: D, B, K with the environment's.
        period: dt [s].
        explicit: position by the old velocity (which needs B > K dt) instead of the new one.
    """
    D, dt = positive("inertia", inertia), positive("period", period)
    a, b = dt * stiffness / D, 1.0 - dt * damping / D
    step = np.array([[1.0, dt], [-a, b]]) if explicit else np.array([[1.0 - dt * a, dt * b], [-a, b]])
    return float(np.abs(np.linalg.eigvals(step)).max())
