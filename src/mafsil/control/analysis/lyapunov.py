"""The certificate of PD control with gravity compensation: an energy that falls along every motion to a set point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, as_batch, require_kind
from mafsil.control.laws.joint_feedback import JointFeedback
from mafsil.control.laws.matrix_feedback import MatrixFeedback
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.robot import Robot, of_robot

ROUNDING = 1e-9
"""Share of the first energy by which a sum of sampled energies may rise: rounding and the recording's last digits."""


class CertificateStatus(Status):
    """Whether the energy falls."""

    FALLS = ("control.energy_falls", True)
    RISES = ("control.energy_rises", False)


@dataclass(frozen=True, eq=False, repr=False)
class EnergyCertificate(Answer, data="t energy spring kinetic power rise"):
    """V = e' Kp e/2 + qd' M qd/2 along a motion, with dV/dt = -qd' (Kd + b) qd; true if it never rises.

    Where qd stays zero the error is zero too (LaSalle), so the set point is reached from everywhere.

    Attributes:
        status: whether it falls.
        t: (k,) times [s].
        energy: (k,) V [J]: the sum of the next two.
        spring: (k,) e' Kp e/2, of the virtual springs [J].
        kinetic: (k,) qd' M qd/2 [J].
        power: (k,) -qd' (Kd + b) qd [W].
        balance: (k,) V(0) - V(t) less what was dissipated, by the rule of Simpson between the samples [J].
        rise: largest rise of V from one sample to the next, as share of V(0).
    """

    status: CertificateStatus
    t: Floats
    energy: Floats
    spring: Floats
    kinetic: Floats
    power: Floats
    balance: Floats
    rise: float

    def explain(self, language: str | None = None) -> str:
        """The status with the first and the last energy."""
        first, last = float(self.energy[0]), float(self.energy[-1])
        details = {"first": first, "last": last, "rise": self.rise}
        return self.status.sentence(language) + say("control.energy_ends", language=language, **details)


@of_robot
def energy_certificate(
    robot: Robot,
    law: JointFeedback | MatrixFeedback,
    goal: ArrayLike,
    t: ArrayLike,
    q: ArrayLike,
    qd: ArrayLike,
    *,
    viscous: ArrayLike = 0.0,
) -> EnergyCertificate:
    """The Lyapunov function of PD control with gravity compensation, along a motion.

    Args:
        robot: its model, whose gravity the law compensates exactly.
        law: of `gravity_compensation` or `matrix_gravity_compensation`, without integral.
        goal: (n,) set point [rad | m].
        t: (k,) times [s].
        q, qd: (k, n) motion, such as that of a recording.
        viscous: friction of the joints, a number or (n,) [N m s/rad | N s/m].

    Raises:
        InputError: a wrong shape, a number that is not finite, a law with an integral or without gravity compensation.

    Reference: Takegaki and Arimoto, A new feedback method for dynamic control of manipulators, 1981; Lynch and Park,
        Modern Robotics, sec. 11.4.2.
    """
    require_kind("law", law, "law of gravity_compensation or matrix_gravity_compensation", "gains", "model")
    kp, kd = (np.diag(K) if K.ndim == 1 else K for K in (law.gains.kp, law.gains.kd))
    if law.gains.ki.any() or law.model is None or (isinstance(law, MatrixFeedback) and law.whole_model):
        raise InputError("control.no_certificate")
    times = as_batch("t", t, np.shape(t)[-1:], finite=True)
    q, qd = (as_batch(name, x, (len(times), robot.n), finite=True) for name, x in (("q", q), ("qd", qd)))
    e = as_batch("goal", goal, (robot.n,), finite=True) - q
    spring, kinetic = 0.5 * ((e @ kp) * e).sum(axis=-1), robot.kinetic_energy(q, qd)
    energy = spring + kinetic
    power = -((qd @ kd + np.asarray(viscous) * qd) * qd).sum(axis=-1)
    rise = float(np.diff(energy).max(initial=0.0)) / max(float(energy[0]), LEAST_DIVISOR)
    status = CertificateStatus.FALLS if rise <= ROUNDING else CertificateStatus.RISES
    balance = energy[0] - energy + _integral(times, power)
    return EnergyCertificate(status, times, energy, spring, kinetic, power, balance, rise)


def _integral(t: Floats, power: JointVector) -> Floats:
    """Of samples from the first on: parabolas through three neighbours, averaged where two cover an interval."""
    h = np.diff(t)
    if len(t) < 3:
        return np.concatenate([[0.0], np.cumsum(h * (power[1:] + power[:-1]) / 2.0)])
    slopes = np.diff(power) / h
    bends = np.diff(slopes) / (h[1:] + h[:-1])
    bend = np.concatenate([bends[:1], (bends[1:] + bends[:-1]) / 2.0, bends[-1:]])
    return np.concatenate([[0.0], np.cumsum(h * (power[1:] + power[:-1]) / 2.0 - bend * h**3 / 6.0)])
