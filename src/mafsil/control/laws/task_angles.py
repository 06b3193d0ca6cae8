"""Orientations of a task as three angles: their rates, and how those follow from angular velocities."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, Matrix3, Symbolic, Vector3, fails, real_array
from mafsil.errors import InputError
from mafsil.geometry import euler

LOCKED = 1e-6
"""Determinant of the matrix from rates to angular velocity below which angles are locked: rates beyond a million."""


def rates_of_angles(angles: Vector3, sequence: str) -> Matrix3:
    """(*batch, 3, 3) from the angular velocity in {s} to the rates of three angles.

    Args:
        angles: (*batch, 3) [rad].
        sequence: such as `ZYX`.

    Raises:
        InputError: a gimbal lock, where there are no such rates.
    """
    E = euler.rates_to_angular_velocity(angles, sequence)
    if not isinstance(E, Symbolic) and fails(np.abs(np.linalg.det(E)) < LOCKED):
        raise InputError("performance.gimbal_lock", sequence=sequence)
    return real_array("E", np.linalg.inv(E))


def axes_rate(angles: Vector3, rates: Vector3, sequence: str) -> Matrix3:
    """(*batch, 3, 3) time derivative of the matrix E of omega_s = E dphi/dt, whose columns are the axes of the turns.

    Each axis is carried by the turns that stand before it: dc_i/dt = (sum of c_j dphi_j/dt before it) x c_i.

    Args:
        angles, rates: (*batch, 3) [rad, rad/s].
        sequence: such as `ZYX`.
    """
    E = euler.rates_to_angular_velocity(angles, sequence)
    E_rate, carried = np.zeros_like(E), np.zeros_like(rates)
    order = (2, 1, 0) if euler.sequence_named(sequence).fixed else (0, 1, 2)
    for k in order:
        E_rate[..., k] = np.cross(carried, E[..., k])
        carried = carried + E[..., k] * rates[..., k, None]
    return E_rate


def angle_error(wanted: Vector3, angles: Vector3) -> Floats:
    """(*batch, 3) difference of angles, each the short way round [rad].

    Args:
        wanted, angles: (*batch, 3) [rad].
    """
    return euler.wrap_symmetric(wanted - angles)
