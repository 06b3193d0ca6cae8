"""Feedback gains from what a designer wants: natural frequency and damping.

Gains of independent joints from the inertia that they move, as hard as the sampling rate allows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import (
    Floats,
    as_batch,
    calculable,
    frozen,
    positive,
    real_array,
    require_finite,
    whole,
)
from mafsil.errors import InputError
from mafsil.fields import check_fields, finite
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot


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
