"""Arms under control near a state and far from it: as linear systems, and by an energy that falls.

Near a state or along a run, with exact derivatives of the dynamics:

d/dt (dq, dqd) = A (dq, dqd) + B dtau,   A = [[0, I], [D_q, D_qd]],  B = [[0], [M^-1]],  C = I,  D = 0.

Far from it PD control with gravity compensation has an energy that falls along every motion to a set point.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array, require_finite, require_kind
from mafsil.control.laws.joint_feedback import JointFeedback
from mafsil.control.laws.law import Law, as_law
from mafsil.control.laws.matrix_feedback import MatrixFeedback
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

ROUNDING = 1e-9
"""Share of the first energy by which a sum of sampled energies may rise: rounding and the recording's last digits."""
DIFFERENCE = 1e-5
"""Of the state, by which the derivative of a law is found: exact for laws that are linear in it."""
SQUARINGS, TERMS = 0.5, 18
"""Norm up to which a matrix exponential is summed, and terms of the series: rounding is all that is left."""


@dataclass(frozen=True, eq=False, slots=True)
class LinearArm:
    """An arm near states: states are (q, qd) less those of the point, inputs efforts, outputs the states.

    Iterable over the states of a batch, such as those of a run: `[each.to_control() for each in linear]`.

    Attributes:
        A: (*batch, 2 n, 2 n).
        B: (*batch, 2 n, n).
        q, qd, tau: (*batch, n) the point; accelerations there need not be zero.
    """

    A: Floats = field(repr=False)
    B: Floats = field(repr=False)
    q: JointVector
    qd: JointVector
    tau: JointVector

    def __len__(self) -> int:
        return self.A.shape[0] if self.A.ndim > 2 else 1

    def __iter__(self) -> Iterator[LinearArm]:
        return iter((self,)) if self.A.ndim == 2 else (self[k] for k in range(len(self)))

    def __getitem__(self, which: int | slice) -> LinearArm:
        if self.A.ndim == 2:
            raise InputError("control.one_linear_arm")
        return LinearArm(self.A[which], self.B[which], self.q[which], self.qd[which], self.tau[which])

    @property
    def C(self) -> Floats:
        """(2 n, 2 n) the states are the outputs."""
        return np.eye(self.A.shape[-1])

    @property
    def D(self) -> Floats:
        """(2 n, n) zero: efforts do not act at once."""
        return np.zeros(self.B.shape[-2:])

    @property
    def poles(self) -> Any:
        """(*batch, 2 n) complex eigenvalues of A [1/s]."""
        return np.linalg.eigvals(self.A)

    def discrete(self, period: float) -> tuple[Floats, Floats]:
        """A (*batch, 2 n, 2 n) and B (*batch, 2 n, n) from sample to sample, efforts constant between, exactly.

        Args:
            period: between samples [s].
        """
        h, (size, inputs) = positive("period", period), self.B.shape[-2:]
        whole = np.zeros((*self.A.shape[:-2], size + inputs, size + inputs))
        whole[..., :size, :size], whole[..., :size, size:] = h * self.A, h * self.B
        found = exponential(whole)
        return found[..., :size, :size], found[..., :size, size:]

    def close_loop(self, law: Law, reference: Motion, t: float = 0.0) -> LinearArm:
        """The loop with a law: efforts are what is added to those of the law.

        Args:
            law: without memory; its derivatives by the state are taken at the point.
            reference: that it follows, (n,) each.
            t: time [s].
        """
        n, law = self.B.shape[-1], as_law(law)
        require_kind("reference", reference, "Motion", "u", "v", "a")
        columns = [
            (law(t, self.q + x[:n], self.qd + x[n:], reference) - law(t, self.q - x[:n], self.qd - x[n:], reference))
            / (2.0 * DIFFERENCE)
            for x in DIFFERENCE * np.eye(2 * n)
        ]
        feedback = np.stack(columns, axis=-1)
        return LinearArm(self.A + self.B @ feedback, self.B, self.q, self.qd, self.tau)

    def to_control(self, period: float | None = None) -> Any:
        """A `StateSpace` of the package python-control.

        Args:
            period: of a system from sample to sample, efforts constant between; in continuous time if None [s].

        Raises:
            InputError: a batch, or the package is not installed.
        """
        if self.A.ndim != 2:
            raise InputError("control.many_linear_arms", count=len(self))
        try:
            package = importlib.import_module("control")
        except ImportError:
            raise InputError("control.no_package") from None
        if period is None:
            return package.ss(self.A, self.B, self.C, self.D)
        return package.ss(*self.discrete(period), self.C, self.D, period)


@of_robot
def linearize(robot: Robot, q: ArrayLike, qd: ArrayLike | None = None, tau: ArrayLike | None = None) -> LinearArm:
    """An arm as a linear system near states, such as those of a run, by exact derivatives.

    Args:
        robot: the arm; its dry friction is left out, viscous friction counts.
        q: (*batch, n) coordinates [rad | m].
        qd: (*batch, n) rates; at rest if None.
        tau: (*batch, n) efforts; those that keep the rates constant if None [N m | N].

    Raises:
        InputError: wrong shapes, NaN.
        ModelError: the robot has no masses.
    """
    n = robot.n
    here = as_batch("q", q, (n,), finite=True)
    rate = np.zeros_like(here) if qd is None else as_batch("qd", qd, (n,), finite=True)
    here, rate = np.broadcast_arrays(here, rate)
    effort = robot.inverse_dynamics(here, rate, np.zeros_like(here)) if tau is None else as_batch("tau", tau, (n,))
    here, rate, effort = (np.array(each) for each in np.broadcast_arrays(here, rate, effort))
    slopes = robot.forward_dynamics_derivatives(here, rate, effort)
    by_q, by_rate, by_effort = (np.asarray(slopes[..., k, :, :]) for k in range(3))
    shape = here.shape[:-1]
    A, B = np.zeros((*shape, 2 * n, 2 * n)), np.zeros((*shape, 2 * n, n))
    A[..., :n, n:] = np.eye(n)
    viscous = np.array([0.0 if j.friction is None else j.friction.viscous for j in robot.mechanism.coordinates])
    A[..., n:, :n], A[..., n:, n:] = by_q, by_rate - by_effort * viscous
    B[..., n:, :] = by_effort
    return LinearArm(A, B, here, rate, effort)


def exponential(A: ArrayLike) -> Floats:
    """(*batch, m, m) e^A by scaling, a series of Taylor, and squaring.

    Args:
        A: (*batch, m, m).

    Reference: Golub and Van Loan, Matrix Computations, sec. 9.3.
    """
    matrix = require_finite("A", real_array("A", A)).copy()
    largest = float(np.abs(matrix).sum(axis=-1).max(initial=0.0))
    squarings = max(int(np.ceil(np.log2(largest / SQUARINGS))), 0) if largest > SQUARINGS else 0
    matrix /= 2.0**squarings
    total = term = np.broadcast_to(np.eye(matrix.shape[-1]), matrix.shape)
    for k in range(1, TERMS):
        term = term @ matrix / k
        total = total + term
    for _ in range(squarings):
        total = total @ total
    return total


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
