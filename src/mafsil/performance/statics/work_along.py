"""Work of forces and couples along a finite motion: in closed form along a screw, by quadrature with an error else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from numpy.typing import ArrayLike

from mafsil.arrays import require_function, single
from mafsil.errors import InputError
from mafsil.floating_point import EPS
from mafsil.geometry import pose, screw, twist


class Work(NamedTuple):
    """Work done on the body by the wrench.

    Attributes:
        value: [J].
        error: bound that the quadrature estimates [J]; rounding for closed forms.
    """

    value: float
    error: float


def of_fixed_force(S: ArrayLike, amount: float, T_0: ArrayLike, force: ArrayLike, point: ArrayLike) -> Work:
    """F . (p_1 - p_0): a force of fixed direction at a point of a body that moves along a screw from T_0.

    Args:
        S: (6,) unit screw in {s}.
        amount: [rad], or [m] of a translation.
        T_0: (4, 4) pose of the body at the start.
        force: (3,) in {s} [N].
        point: (3,) in the body's frame [m].
    """
    f, p = single("force", force, (3,)), single("point", point, (3,))
    start = pose.act(T_0, p)
    return _exact(float(f @ (pose.act(screw.displacement(S, amount), start) - start)))


def of_carried_wrench(S: ArrayLike, amount: float, T_0: ArrayLike, F_b: ArrayLike) -> Work:
    """Amount F_b . (Ad(T_0^-1) S): a wrench fixed in the body, (m, f) in its frame; arguments as `of_fixed_force`."""
    return _exact(amount * float(single("F_b", F_b, (6,)) @ twist.transform(pose.inverse(T_0), single("S", S, (6,)))))


def of_fixed_couple(S: ArrayLike, amount: float, moment: ArrayLike) -> Work:
    """Amount m . omega: a couple (3,) of fixed direction in {s} [N m]; arguments as `of_fixed_force`."""
    return _exact(amount * float(single("moment", moment, (3,)) @ single("S", S, (6,))[:3]))


def along(
    wrench: Callable[[float], ArrayLike],
    velocity: Callable[[float], ArrayLike],
    start: float,
    end: float,
    *,
    tolerance: float = 1e-9,
) -> Work:
    """The integral of F . V dt by adaptive quadrature, with an estimate of its error.

    Args:
        wrench: t -> (6,) wrench (m, f) at the time t.
        velocity: t -> (6,) twist in the same frame.
        start, end: times [s].
        tolerance: largest error that is asked for, absolute [J] and relative.

    Raises:
        InputError: the tolerance is not reached, for example because a force jumps too often.
    """
    import scipy.integrate

    require_function("wrench", wrench, "function of t", 1)
    require_function("velocity", velocity, "function of t", 1)

    def power(t: float) -> float:
        return float(single("wrench(t)", wrench(t), (6,)) @ single("velocity(t)", velocity(t), (6,)))

    integrate: Any = scipy.integrate.quad  # carries no types
    found: Any = integrate(power, start, end, epsabs=tolerance, epsrel=tolerance, limit=200, full_output=1)
    value, error = float(found[0]), float(found[1])
    if error > 10 * max(tolerance, tolerance * abs(value)):
        raise InputError("performance.work_not_found", error=error, tolerance=tolerance)
    return Work(value, error)


def _exact(value: float) -> Work:
    return Work(value, 8 * EPS * abs(value))
