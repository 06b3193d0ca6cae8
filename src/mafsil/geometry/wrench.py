"""Wrenches F = (m, f) [N m, N]: forces and couples, changes of frame and power; any batch."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Scalar, Vector3, Vector6, as_batch
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.geometry.conditioned import PoseLike, Vector3Like, Vector6Like, compile_function


@compile_function("spatial.wrench_of_force")
def from_force(point: Vector3Like, force: Vector3Like) -> Vector6:
    """Wrench (r x f, f) of a force at a point.

    Args:
        point: (*batch, 3) r [m].
        force: (*batch, 3) f [N], in the same frame.

    Returns:
        (*batch, 6) [N m, N].
    """
    ...


def from_couple(moment: ArrayLike) -> Vector6:
    """(*batch, 6) wrench (m, 0) of a pure couple (*batch, 3) [N m]."""
    m = as_batch("moment", moment, (3,))
    return np.concatenate([m, np.zeros_like(m)], axis=-1)


@compile_function("spatial.transform_wrench")
def transform(T_ab: PoseLike, F_a: Vector6Like) -> Vector6:
    """F_b = Ad(T_ab)' F_a = (R' (m - p x f), R' f): the same wrench seen from {b}.

    Note the subscripts: a twist goes from {b} to {a} with Ad(T_ab), a wrench from {a} to {b} with its transpose.

    Args:
        T_ab: (*batch, 4, 4) pose of {b} in {a}.
        F_a: (*batch, 6).

    Returns:
        (*batch, 6).

    Reference: Lynch & Park, Modern Robotics, eq. 3.98.
    """
    ...


def resultant(wrenches: ArrayLike, poses: ArrayLike | None = None) -> Vector6:
    """(6,) sum of wrenches in one frame, each first carried there; its negative balances them.

    Args:
        wrenches: (k, 6) (m, f), each in its own frame [N m, N].
        poses: (k, 4, 4) poses of these frames in the common one; all in the common frame already if None.

    Raises:
        InputError: not one pose for each wrench.
    """
    F = np.atleast_2d(as_batch("wrenches", wrenches, (6,)))
    if poses is None:
        return F.sum(axis=0)
    T = np.reshape(as_batch("poses", poses, (4, 4)), (-1, 4, 4))
    if len(T) != len(F):
        raise InputError("input.shape", name="poses", expected=(len(F), 4, 4), got=np.shape(poses), hint="")
    return np.asarray(transform(pose.inverse(T), F)).sum(axis=0)


@compile_function("spatial.power")
def power(V: Vector6Like, F: Vector6Like) -> Scalar:
    """(*batch) V . F [W] of a twist and a wrench in one frame; the same in every frame."""
    ...


@compile_function("spatial.dual_bracket")
def dual_bracket(V: Vector6Like, F: Vector6Like) -> Vector6:
    """(*batch, 6) ad(V)' F, the change of a wrench seen from a frame that moves with the twist V."""
    ...


@compile_function("screw.wrench_pitch")
def pitch(F: Vector6Like) -> Scalar:
    """(*batch) moment along the force over the force, m.f / |f|^2 [m] (Poinsot); infinite for a pure couple."""
    ...


@compile_function("screw.wrench_axis_point")
def axis_point(F: Vector6Like) -> Vector3:
    """(*batch, 3) point of the wrench's axis nearest to the origin, f x m / |f|^2 [m]; NaN for a pure couple."""
    ...
