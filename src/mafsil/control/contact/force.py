"""Force control: the tip presses with a desired wrench; what it does when contact is lost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, Vector6, as_batch, real_array, require_finite, single
from mafsil.control.laws.feedback import SummingRun
from mafsil.control.laws.law import Law
from mafsil.control.laws.matrix_feedback import symmetric
from mafsil.errors import InputError
from mafsil.geometry.matrix_exponential import exponential
from mafsil.one_joint import ForceLoop
from mafsil.one_joint.rows import together
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

WrenchSensor: TypeAlias = Callable[[JointVector, JointVector], Vector6]
"""(q, qd) -> (*batch, 6) wrench that the tip exerts on the world, in the tip frame."""


@dataclass(frozen=True, eq=False, slots=True)
class ForceControl:
    """tau = g(q) + J' (F_d + Kfp F_e + Kfi int F_e - Kdamp V),  F_e = F_d - F.

    There is no derivative term: measured forces are noisy, and their derivative more so. The damping keeps the tip slow
    where nothing resists.

    Attributes:
        robot: its model.
        wrench: (6,) F_d that the tip should exert, in the tip frame [N m, N].
        kp, ki: (6,) or (6, 6) gains of the force error and of its integral [1, 1/s].
        damping: (6,) or (6, 6) of the body twist [N m s/rad, N s/m].
        sensor: what the tip exerts; None for the open-loop law.
        clamp: (6,) largest magnitude of the integral term [N m, N].
    """

    robot: Robot
    wrench: Vector6
    kp: Floats
    ki: Floats
    damping: Floats
    sensor: WrenchSensor | None
    clamp: Vector6

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) without the integral term, which needs a session [N m | N]."""
        return self.effort(q, qd, self.error(q, qd), np.zeros(6))

    def error(self, q: JointVector, qd: JointVector) -> Vector6:
        """(*batch, 6) F_d - F; zero without a sensor."""
        return np.zeros_like(self.wrench) if self.sensor is None else self.wrench - self.sensor(q, qd)

    def effort(self, q: JointVector, qd: JointVector, error: Vector6, integral: Vector6) -> JointVector:
        """Joint efforts (*batch, n) [N m | N].

        Args:
            q, qd: (*batch, n) state.
            error: (*batch, 6) of the force.
            integral: (*batch, 6) Kfi times its integral.
        """
        J = self.robot.jacobian_body(q)
        F = self.wrench + apply_gain(self.kp, error) + integral - apply_gain(self.damping, (J @ qd[..., None])[..., 0])
        return self.robot.gravity_torque(q) + (np.swapaxes(J, -1, -2) @ F[..., None])[..., 0]

    def session(self, period: float) -> Law:
        """The law with a fresh integral; the law itself if Kfi is zero."""
        return _WithIntegral(self, self.ki * period, np.zeros(6)) if self.ki.any() else self


def apply_gain(K: Floats, x: Floats) -> Floats:
    """(*batch, 6) K x for a diagonal (6,) or a matrix (6, 6).

    Args:
        K: gains.
        x: (*batch, 6).
    """
    return x @ K.T if K.ndim == 2 else K * x


class _WithIntegral(SummingRun[ForceControl]):
    """One run of a force law."""

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        error = self._law.error(q, qd)
        return self._law.effort(q, qd, error, self._sum.add(apply_gain(self._weight, error), self._law.clamp))


@of_robot
def force_control(
    robot: Robot,
    wrench: ArrayLike,
    *,
    sensor: WrenchSensor | None = None,
    kp: ArrayLike = 0.0,
    ki: ArrayLike = 0.0,
    damping: ArrayLike = 0.0,
    clamp: ArrayLike = np.inf,
) -> ForceControl:
    """Force control of a tip whose environment resists in every direction.

    Args:
        robot: its model.
        wrench: (6,) (m, f) that the tip should exert, in the tip frame [N m, N].
        sensor: (q, qd) -> wrench that it exerts; None for the open-loop law g + J' F_d, which presses as wanted only as
            far as the model's gravity is right and the joints make the efforts that they are told to.
        kp, ki: of the force error, a number, (6,) or a symmetric matrix (6, 6) [1, 1/s].
        damping: of the body twist, a number, (6,) or a symmetric matrix (6, 6).
        clamp: largest magnitude of the integral term, a number or (6,): without contact it does not grow beyond.

    Raises:
        InputError: a wrong shape, a negative gain, feedback gains without a sensor.

    Reference: Lynch and Park, Modern Robotics, sec. 11.5.
    """
    given = (("kp", kp), ("ki", ki), ("damping", damping))
    rows = {name: symmetric(name, value, 6) if np.ndim(value) == 2 else _row(name, value) for name, value in given}
    rows["clamp"] = _row("clamp", clamp)
    if sensor is None and (rows["kp"].any() or rows["ki"].any()):
        raise InputError("control.no_sensor")
    F = single("wrench", wrench, (6,))
    return ForceControl(robot, F, rows["kp"], rows["ki"], rows["damping"], sensor, rows["clamp"])


def _row(name: str, value: ArrayLike) -> Vector6:
    array = real_array(name, value)
    if array.shape not in ((), (6,)):
        raise InputError("input.shape", name=name, expected=(6,), got=array.shape, hint="")
    if np.isnan(array).any() or (array < 0.0).any():
        raise InputError("input.range", name=name, value=array.min(), low=0.0, high=np.inf)
    return np.broadcast_to(array, (6,)).astype(np.float64)


def force_error(kp: ArrayLike, ki: ArrayLike, disturbance: ArrayLike, t: ArrayLike) -> Floats:
    """F_e(t) of the quasi-static loop under a constant wrench that the model does not know.

    (1 + kp) F_e + ki int F_e = -w:  F_e = -w/(1 + kp) exp(-t ki/(1 + kp)), which for ki = 0 stays.
    Of matrices F_e = -exp(-t (I + Kfp)^-1 Kfi) (I + Kfp)^-1 w: eigenvalues of (I + Kfp)^-1 Kfi are rates.

    Args:
        kp, ki: gains: numbers or arrays that act one by one; or a matrix (m, m) and a number or another matrix.
        disturbance: w = J^-T (model gravity - gravity) [N]; (m,) for matrices.
        t: times [s]; a number or (k,) for matrices.

    Returns:
        Errors of the common shape; (m,) or (k, m) for matrices.

    Raises:
        InputError: a number that is not finite, shapes of matrices that do not go together.

    Reference: Lynch and Park, Modern Robotics, eq. (11.54) and (11.55).
    """
    kp, ki, w, t = (
        require_finite(name, real_array(name, x))
        for name, x in (("kp", kp), ("ki", ki), ("disturbance", disturbance), ("t", t))
    )
    if max(kp.ndim, ki.ndim) >= 2:
        return _coupled_error(kp, ki, w, t)
    kp, ki, w, t = together(kp=kp, ki=ki, disturbance=w, t=t)
    return np.asarray(-w / (1.0 + kp) * np.exp(-t * ki / (1.0 + kp)), dtype=np.float64)


def _coupled_error(kp: Floats, ki: Floats, w: Floats, t: Floats) -> Floats:
    m = max(kp.shape[-1] if kp.ndim else 1, ki.shape[-1] if ki.ndim else 1)
    for name, value, shapes in (("kp", kp, ((), (m, m))), ("ki", ki, ((), (m, m))), ("disturbance", w, ((m,),))):
        if value.shape not in shapes:
            raise InputError("input.shape", name=name, expected=shapes[-1], got=value.shape, hint="")
    if t.ndim > 1:
        raise InputError("input.shape", name="t", expected="() or (k,)", got=t.shape, hint="")
    I = np.eye(m)
    P, Q = (K if K.ndim else K * I for K in (kp, ki))
    rates = np.asarray(np.linalg.solve(I + P, Q), dtype=np.float64)
    begin = np.asarray(np.linalg.solve(I + P, -w), dtype=np.float64)
    return np.stack([exponential(-moment * rates) @ begin for moment in t.ravel().tolist()]).reshape(*t.shape, m)


def free_speed(wrench: float, kp: float, ki: float, damping: float, mass: float, t: ArrayLike) -> Floats:
    """Speed of a tip of some mass that meets nothing: m v' = (1 + kp) F_d + ki F_d t - Kdamp v, from rest.

    v = a/d (1 - e) + r/d t - m r/d^2 (1 - e),  a = (1 + kp) F_d,  r = ki F_d,  e = exp(-d t/m): with ki it runs away.
    `mafsil.one_joint.ForceLoop` has the same for batches and any speed at the start.

    Args:
        wrench: F_d [N].
        kp, ki: gains of the force error and its integral.
        damping: d; without it nothing bounds the speed at all [N s/m].
        mass: m [kg].
        t: times from 0 on [s].

    Raises:
        InputError: a number that is not finite or out of its range.
    """
    moments = require_finite("t", real_array("t", t))
    given = {"wrench": wrench, "kp": kp, "ki": ki, "damping": damping, "mass": mass}
    F, p, i, d, m = (single(name, value, ()) for name, value in given.items())
    return ForceLoop.of(p, i, d).free_speed(moments.reshape(-1), F, m).reshape(moments.shape)


def sampled_force_radius(kp: ArrayLike, ki_period: ArrayLike) -> Floats:
    """Spectral radius of the sampled force loop on rigid contact, one period late; below one it is stable.

    z^2 + (kp + ki dt - 1) z - kp:  stable if and only if kp < 1 and 0 < ki dt < 2 (1 - kp).

    Args:
        kp: gain of the force error.
        ki_period: gain of its integral times the period.
    """
    kp, step = together(
        kp=require_finite("kp", real_array("kp", kp)),
        ki_period=require_finite("ki_period", real_array("ki_period", ki_period)),
    )
    b = kp + step - 1.0
    root = np.sqrt(b**2 + 4.0 * kp + 0j)
    return np.asarray(np.maximum(np.abs(-b + root), np.abs(-b - root)) / 2.0, dtype=np.float64)


def applied_wrench(sensed: ArrayLike, adjoint: ArrayLike, tool_weight: ArrayLike, bias: ArrayLike = 0.0) -> Vector6:
    """What the tip exerts on the world, from a sensor between arm and tool: F = Ad' (F_sensor - bias) - tool weight.

    Args:
        sensed: (*batch, 6) reading, the wrench that the arm exerts on the tool, in the sensor's frame.
        adjoint: (6, 6) Ad of the tip frame in the sensor's frame, Ad(T_sensor,tip).
        tool_weight: (*batch, 6) that gravity needs to be held, in the tip frame.
        bias: (6,) reading without any load.
    """
    rest = require_finite("bias", real_array("bias", bias))
    F = as_batch("sensed", sensed, (6,), finite=True) - (as_batch("bias", rest, (6,)) if rest.ndim else rest)
    Ad = as_batch("adjoint", adjoint, (6, 6), finite=True)
    return (np.swapaxes(Ad, -1, -2) @ F[..., None])[..., 0] - as_batch("tool_weight", tool_weight, (6,), finite=True)
