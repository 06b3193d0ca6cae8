"""Feedback of errors: its gains from natural frequency and damping, its terms, and the memory that its integral needs.

Gains of independent joints follow from the inertia that they move, as hard as the sampling rate allows. What laws
remember from one run to the next are integrals, learned parameters, efforts that wait, a contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import (
    Floats,
    JointVector,
    as_batch,
    calculable,
    frozen,
    positive,
    real_array,
    require_finite,
    require_kind,
    whole,
)
from mafsil.control.laws.law import Combined, Law
from mafsil.errors import InputError
from mafsil.fields import check_fields, finite
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot
from mafsil.trajectory import Motion

NATURAL_FREQUENCY, DAMPING_RATIO = 55.0, 0.7
"""Of each joint, all others locked [rad/s, 1]."""
MOST_RAISED = 5.0
"""How much faster a light joint may be than requested, that it is not dragged along by the heavy ones."""
MOST_DECAY = 1.5
"""Largest decay of any error in one sampling period; from 2 on the sampled loop is unstable."""
SOFT, AROUND = 0.2, 0.4
"""Where a joint gets less than this share of the requested frequency, the arm will stray; then the loop has to be
stable this far around the motion too [1, rad | m]."""
_SHRINK, _ROUNDS = 0.5, 500


@dataclass(frozen=True, eq=False, slots=True)
class Gains:
    """Gains of position error, its rate and its integral, (n,) each.

    Units are those of the quantity that they make per rad | m: accelerations [1/s^2, 1/s, 1/s^3] for computed torque,
    efforts [N m/rad | N/m, ...] for a law without a model.
    """

    kp: Floats
    kd: Floats
    ki: Floats
    __post_init__ = check_fields(kp=finite(), kd=finite(), ki=finite())

    @classmethod
    def of(cls, n: int, kp: ArrayLike, kd: ArrayLike, ki: ArrayLike = 0.0) -> Gains:
        """Gains from numbers or (n,) arrays.

        Raises:
            InputError: a wrong shape, a number that is not finite, a negative gain.
        """
        whole("n", n, 1)
        return cls(*(per_joint(name, value, n) for name, value in (("kp", kp), ("kd", kd), ("ki", ki))))

    @classmethod
    def from_natural_frequency(
        cls, n: int, natural_frequency: ArrayLike, damping_ratio: ArrayLike = 1.0, integral: ArrayLike = 0.0
    ) -> Gains:
        """Gains that make the error obey e'' + 2 zeta w e' + w^2 e + ki int e = 0.

        Args:
            n: number of joints.
            natural_frequency: w, a number or (n,) [rad/s].
            damping_ratio: zeta, a number or (n,); 1 is critical damping.
            integral: ki, a number or (n,) [1/s^3]; below 2 zeta w^3, where the loop would start to oscillate.

        Raises:
            InputError: a wrong shape, a number that is not finite or negative, an integral gain that destabilises.

        Reference: Lynch and Park, Modern Robotics, sec. 11.4.1.
        """
        whole("n", n, 1)
        w = per_joint("natural_frequency", natural_frequency, n)
        gains = cls(
            frozen(w**2),
            frozen(2.0 * per_joint("damping_ratio", damping_ratio, n) * w),
            per_joint("integral", integral, n),
        )
        bound = gains.kp * gains.kd
        if ((gains.ki > 0.0) & (gains.ki >= bound)).any():
            joint = int(np.argmax(gains.ki - bound))
            raise InputError("control.integral", joint=joint, value=gains.ki[joint], limit=bound[joint])
        return gains

    @property
    def integrates(self) -> bool:
        """Whether any integral gain is not zero."""
        return bool(self.ki.any())


def per_joint(name: str, value: ArrayLike, n: int, *, positive: bool = False) -> Floats:
    """(n,) a number, or one per joint, finite and not negative.

    Args:
        name: of the argument, for errors.
        value: as it was given.
        n: number of joints.
        positive: whether zero is refused too.

    Raises:
        InputError: a wrong shape, a number that is not finite, or negative.
    """
    array = calculable(name, require_finite(name, real_array(name, value)))
    if array.shape not in ((), (1,), (n,)):
        raise InputError("input.shape", name=name, expected=(n,), got=array.shape, hint="")
    if (array < 0.0).any():
        raise InputError("input.range", name=name, value=array.min(), low=0.0, high=np.inf)
    if positive and not (array > 0.0).all():
        raise InputError("input.positive", name=name, value=array.min())
    return frozen(np.broadcast_to(array, (n,)))


def inertia_gains(
    robot: RobotLike,
    q: ArrayLike,
    period: float,
    natural_frequency: float = NATURAL_FREQUENCY,
    damping_ratio: float = DAMPING_RATIO,
) -> Gains:
    """PD gains scaled with the inertia of each joint: Kp = w^2 M_ii, Kd = 2 zeta w M_ii.

    Algorithm:
        1. M_ii is the largest along q. w is the requested natural frequency, raised by sqrt(sum_j |M_ij| / M_ii) where
           the other joints push more mass through this one than it moves itself.
        2. The sampled rate loop is stable while period * eig(M^-1 Kd) < 2; the largest eigenvalue along q, with its
           mode, is looked for.
        3. While it is above 1.5, w of each joint is lowered by that joint's part in the mode.
        4. If that leaves a joint soft, the same again with configurations around the motion.

    Args:
        robot: the model, without loops.
        q: (k, n) configurations that the motion passes [rad | m].
        period: between two calls of the law [s].
        natural_frequency: w of each joint, the others locked [rad/s].
        damping_ratio: zeta.

    Returns:
        Gains in units of effort, without an integral.

    Raises:
        InputError: a wrong shape, a number that is not finite or not positive.
    """
    robot = as_robot(robot)
    for name, value in (("period", period), ("natural_frequency", natural_frequency), ("damping_ratio", damping_ratio)):
        positive(name, value)
    places = require_finite("q", as_batch("q", q, (robot.n,))).reshape(-1, robot.n)
    inertia, w = _frequencies(robot, places, period, natural_frequency, damping_ratio)
    if w.min() < SOFT * natural_frequency:
        around = [places + side * row for row in AROUND * np.eye(robot.n) for side in (-1.0, 1.0)]
        inertia, w = _frequencies(robot, np.concatenate([places, *around]), period, natural_frequency, damping_ratio)
    return Gains.of(robot.n, w**2 * inertia, 2.0 * damping_ratio * w * inertia)


def _frequencies(robot: Robot, q: Floats, period: float, requested: float, damping: float) -> tuple[Floats, Floats]:
    """Largest inertia (n,) of each joint along q (k, n), and the frequency (n,) that the sampling allows [rad/s]."""
    M = np.asarray(robot.mass_matrix(q), dtype=np.float64)
    inertia = np.einsum("kii->ki", M).max(axis=0)
    coupled = np.abs(M).sum(axis=2).max(axis=0)
    w = requested * np.minimum(np.sqrt(coupled / inertia), MOST_RAISED)
    inverse = np.asarray(np.linalg.inv(M), dtype=np.float64)
    for _ in range(_ROUNDS):
        decay, part = _fastest(inverse, 2.0 * damping * w * inertia)
        if decay * period <= MOST_DECAY:
            break
        w = w * (1.0 - part * (1.0 - max(MOST_DECAY / (decay * period), _SHRINK)))
    return inertia, w


def _fastest(inverse: Floats, kd: Floats) -> tuple[float, Floats]:
    """Largest eigenvalue of M^-1 Kd among all configurations [1/s], and the part (n,) of each joint in its mode."""
    root = np.sqrt(kd)
    values, modes = np.linalg.eigh(root[:, None] * inverse * root)
    hardest = int(values[:, -1].argmax())
    return float(values[hardest, -1]), modes[hardest, :, -1] ** 2


def pd(gains: Gains, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
    """The term Kp (u - q) + Kd (v - qd), (*batch, n)."""
    return gains.kp * (reference.u - q) + gains.kd * (reference.v - qd)


class RunningSum:
    """What a law adds up from call to call.

    Attributes:
        value: of all that was added.

    Args:
        start: value before the first call.
    """

    def __init__(self, start: Floats) -> None:
        self.value = self._before = start

    def add(self, growth: Floats, most: ArrayLike = np.inf) -> Floats:
        """Add the growth of a call, and return the value.

        Args:
            growth: of this call.
            most: size that the value does not exceed.
        """
        self._before = self.value
        self.value = np.minimum(np.maximum(self.value + growth, -np.asarray(most)), most)
        return self.value

    def become(self, before: Floats, value: Floats) -> None:
        """Be a sum that was added up elsewhere.

        Args:
            before: of the last growth.
            value: with it.
        """
        self._before, self.value = before, value

    def go_on(self, before: RunningSum) -> None:
        """Go on with another sum, but for its last growth: the state at which two runs meet is seen by both.

        Args:
            before: of an earlier run.
        """
        self.value = before._before


LawT = TypeVar("LawT", bound=Law)


class SummingRun(Generic[LawT]):
    """One run of a law with an integral.

    Args:
        law: whose run it is.
        weight: of what is added at a call: its gain times the period.
        start: of the sum.
    """

    def __init__(self, law: LawT, weight: Floats, start: Floats) -> None:
        self._law, self._weight, self._sum = law, weight, RunningSum(start)

    def go_on(self, before: SummingRun[LawT]) -> None:
        """Go on where an earlier run ended."""
        self._sum.go_on(before._sum)

    def session(self, period: float) -> Law:
        """A new run."""
        return self._law.session(period)


class Integral:
    """Ki times the error summed over the control periods: the rectangle rule.

    Attributes:
        sum: of all calls.

    Args:
        gains: whose ki is used.
        period: time between calls [s].
    """

    def __init__(self, gains: Gains, period: float) -> None:
        self._weight = gains.ki * period
        self.sum = RunningSum(0.0 * gains.ki)

    def __call__(self, q: JointVector, reference: Motion) -> Floats:
        """Add the present error and return the term (*batch, n)."""
        return self.sum.add(self._weight * (reference.u - q))

    def within(self, effort: Floats, limit: Floats, q: JointVector, reference: Motion) -> Floats:
        """Effort and term together (*batch, n); the term waits where it would drive them further beyond a limit.

        Args:
            effort: (*batch, n) without the term [N m | N].
            limit: (n,) > 0.
            q: (*batch, n) measured.
            reference: that is followed.
        """
        growth = self._weight * (reference.u - q)
        ahead = effort + self.sum.value + growth
        waits = (np.abs(ahead) > limit) & (ahead * growth > 0.0)
        return effort + self.sum.add(np.where(waits, 0.0, growth))

    def go_on(self, before: Integral) -> None:
        """Go on with the term that another integral ended with, whatever its gain.

        Args:
            before: of an earlier run.
        """
        self.sum.go_on(before.sum)


@runtime_checkable
class Remembering(Protocol):
    """A session that can go on where an earlier one of its kind ended."""

    def go_on(self, before: Any) -> None:
        """Take over what the earlier session knows.

        Args:
            before: which has ended; of the same class.
        """
        ...


@runtime_checkable
class Integrating(Protocol):
    """A session of a law of joints with an integral."""

    integral: Integral


class LawMemory:
    """The memory of laws across consecutive runs.

    Without it every run begins with fresh memory. An integral is handed on as what it adds to the efforts, so that it
    does not jump where the next law has other gains.

    Attributes:
        session: of the last run, or None.
        waiting: (k, b, n) commands of the last run's end that differing delays still hold back, the latest first.
    """

    def __init__(self) -> None:
        self.session: Law | None = None
        self.waiting: Floats | None = None

    def begun(self, law: Law, period: float) -> Law:
        """The session of a run, which goes on with what the last one remembers.

        Args:
            law: of the run.
            period: between its calls [s].
        """
        require_kind("law", law, "Law", "session")
        session = law.session(positive("period", period))
        take_over(session, self.session)
        self.session = session
        return session


def take_over(session: Law, before: Law | None) -> None:
    """Let a session go on where another one ended, part by part where they are of the same kind.

    Args:
        session: that begins.
        before: that has ended, or None.
    """
    if isinstance(session, Combined) and isinstance(before, Combined):
        for part, earlier in zip(session.laws, before.laws, strict=False):
            take_over(part, earlier)
    elif isinstance(session, Remembering) and type(session) is type(before):
        session.go_on(before)


def integrals_of(session: Law) -> tuple[Integral, ...]:
    """The integrals of a session of laws of joints, part by part.

    Args:
        session: of one law, or of a sum of them.
    """
    if isinstance(session, Combined):
        return tuple(integral for part in session.laws for integral in integrals_of(part))
    return (session.integral,) if isinstance(session, Integrating) else ()
