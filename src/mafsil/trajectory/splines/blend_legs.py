"""The legs of straight lines with blends: accelerations with their signs, blend times and slopes of each kind of leg.

Everywhere A is the acceleration at which a blend changes speed, a magnitude; of blends that are no parabolas it is the
mean over the blend. What has no solution is NaN.

Reference: Craig, Introduction to Robotics, eqs. (7.24), (7.26), (7.28).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats
from mafsil.trajectory.tolerances import ROUNDING


class EndLeg(NamedTuple):
    """A leg that starts from rest, or ends in it, with one blend wholly inside.

    Attributes:
        acceleration: signed, of that blend [rad/s^2 | m/s^2].
        blend: its duration [s].
        slope: velocity of the straight part [rad/s | m/s].
    """

    acceleration: Floats
    blend: Floats
    slope: Floats


class SingleLeg(NamedTuple):
    """A leg from rest to rest, both blends inside.

    Attributes:
        acceleration: signed, of the first and the last blend [rad/s^2 | m/s^2].
        blend: their durations [s].
        slope: velocity of the straight part [rad/s | m/s].
    """

    acceleration: tuple[Floats, Floats]
    blend: tuple[Floats, Floats]
    slope: Floats


def first_leg(distance: Floats, duration: Floats, A: Floats) -> EndLeg:
    """The leg that leaves the start: a_1 = sgn(D) A,  t_1 = d - sqrt(d^2 - 2 D/a_1),  v = D/(d - t_1/2).

    Args:
        distance: u_2 - u_1 [rad | m]; with 0 the leg rests and has no blend.
        duration: d [s].
        A: magnitude of the acceleration [rad/s^2 | m/s^2].
    """
    blend = _smaller_root(duration, 2.0 * np.abs(distance) / A)
    return EndLeg(np.sign(distance) * A, blend, slope(distance, duration - blend / 2))


def interior_blend(before: Floats, after: Floats, A: Floats) -> tuple[Floats, Floats]:
    """Signed acceleration and duration of the blend between two slopes: a_k = sgn(dv) A,  t_k = dv/a_k.

    Args:
        before, after: slopes v_jk and v_kl [rad/s | m/s]; equal ones need no blend.
        A: magnitude of the acceleration [rad/s^2 | m/s^2].
    """
    change = after - before
    return np.sign(change) * A, np.abs(change) / A


def last_leg(distance: Floats, duration: Floats, A: Floats) -> EndLeg:
    """The leg that arrives at the goal: a_n = -sgn(D) A,  t_n = d - sqrt(d^2 + 2 D/a_n),  v = D/(d - t_n/2).

    Args:
        distance: u_n - u_{n-1} [rad | m]; with 0 the leg rests and has no blend.
        duration: d [s].
        A: magnitude of the acceleration [rad/s^2 | m/s^2].
    """
    mirrored = first_leg(distance, duration, A)
    return mirrored._replace(acceleration=-mirrored.acceleration)


def single_leg(distance: Floats, duration: Floats, A_start: Floats, A_goal: Floats) -> SingleLeg:
    """The only leg, from rest to rest: |v| solves v^2/A - d v + |D| = 0 with 2/A = 1/A_start + 1/A_goal.

    Args:
        distance: D [rad | m].
        duration: d [s].
        A_start, A_goal: magnitudes of the accelerations [rad/s^2 | m/s^2]; of equal ones
            t_b = d/2 - sqrt(d^2/4 - |D|/A).
    """
    A, sign = mean_acceleration(A_start, A_goal), np.sign(distance)
    blend = _smaller_root(duration / 2, np.abs(distance) / A)
    speed = A * blend
    return SingleLeg((sign * A_start, -sign * A_goal), (speed / A_start, speed / A_goal), sign * speed)


def mean_acceleration(A_start: Floats, A_goal: Floats) -> Floats:
    """The one acceleration that takes as long as two different ones: their harmonic mean."""
    return 2.0 * A_start * A_goal / (A_start + A_goal)


def slope(distance: Floats, duration: Floats) -> Floats:
    """Velocity of a straight part; a leg without distance rests, however short it is."""
    moving = distance != 0.0
    return np.where(moving, distance / np.where(moving, duration, 1.0), 0.0)


def _smaller_root(duration: Floats, gap: Floats) -> Floats:
    """d - sqrt(d^2 - gap) as gap/(d + sqrt(d^2 - gap)), where nothing cancels; NaN where the leg is too short."""
    radicand = duration**2 - gap
    close = np.abs(radicand) <= ROUNDING * duration**2
    root = np.sqrt(np.where(close, 0.0, np.where(radicand < 0.0, np.nan, radicand)))
    return np.where(gap > 0.0, gap / np.where(gap > 0.0, duration + root, 1.0), 0.0)
