"""Feedback gains from what a designer wants: natural frequency and damping."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, calculable, frozen, real_array, require_finite, whole
from mafsil.errors import InputError
from mafsil.fields import check_fields, finite


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
