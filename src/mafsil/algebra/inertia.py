"""Rigid-body inertia on twists (omega, v): the 6x6 matrix, its change of frame, and whether a body can have it."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra import se3, so3
from mafsil.algebra.spatial import angular, cross, linear, skew


def spatial_inertia(mass: ex.Expression, com: ex.Expression, inertia: ex.Expression) -> ex.Expression:
    """(6, 6) G = [[I_c - m [c]^2, m [c]], [-m [c], m 1]]: momentum (angular, linear) = G (omega, v).

    Args:
        mass: m [kg].
        com: (3,) centre of mass c in the frame [m].
        inertia: (3, 3) rotational inertia I_c about the centre of mass, axes of the frame [kg m^2].

    Reference: Featherstone, Rigid Body Dynamics Algorithms, eq. 2.63.
    """
    C = skew(com)
    return ex.blockcat([[inertia - mass * (C @ C), mass * C], [-mass * C, mass * ex.eye(3)]])


def momentum(mass: ex.Expression, com: ex.Expression, inertia: ex.Expression, V: ex.Expression) -> ex.Expression:
    """(6,) G V without forming the matrix: linear m (v + omega x c), angular I_c omega + c x linear.

    Arguments as `spatial_inertia`, and a twist V (6,).
    """
    omega = angular(V)
    p = mass * (linear(V) + cross(omega, com))
    return ex.vertcat(inertia @ omega + cross(com, p), p)


def shift_inertia(inertia: ex.Expression, mass: ex.Expression, offset: ex.Expression) -> ex.Expression:
    """(3, 3) inertia about a point at `offset` [m] from the centre of mass: I_c - m [d]^2 (parallel axes)."""
    D = skew(offset)
    return inertia - mass * (D @ D)


def rotate_inertia(inertia: ex.Expression, R_ab: ex.Expression) -> ex.Expression:
    """(3, 3) R I R': inertia given with the axes of {b}, expressed with those of {a}."""
    return R_ab @ inertia @ R_ab.T


def transform_inertia(G_b: ex.Expression, T_ab: ex.Expression) -> ex.Expression:
    """(6, 6) G_a = Ad(T_ba)' G_b Ad(T_ba): the same body's inertia seen from {a}."""
    Ad = se3.adjoint(se3.inverse(T_ab))
    return Ad.T @ G_b @ Ad


def kinetic_energy(G: ex.Expression, V: ex.Expression) -> ex.Expression:
    """V'GV / 2 [J]."""
    return ex.dot(V, G @ V) / 2


def pseudo_inertia(mass: ex.Expression, com: ex.Expression, inertia: ex.Expression) -> ex.Expression:
    """(4, 4) [[S, m c], [m c', m]], S the integral of x x' dm: positive definite exactly for possible bodies.

    Arguments as `spatial_inertia`.

    Reference: Wensing, Kim & Slotine, Linear matrix inequalities for physically consistent inertial parameter
    identification, IEEE RA-L 3, 2018.
    """
    about_origin = shift_inertia(inertia, mass, com)
    trace = about_origin[0, 0] + about_origin[1, 1] + about_origin[2, 2]
    return ex.blockcat([[trace / 2 * ex.eye(3) - about_origin, mass * com], [mass * com.T, mass]])


def principal_moments(inertia: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """Moments (3,) [kg m^2], in no order, and their axes, the columns of (3, 3)."""
    return so3.symmetric(inertia)


def realisability(mass: ex.Expression, inertia: ex.Expression) -> ex.Expression:
    """Smallest of m and the principal values of S_c = tr(I_c)/2 1 - I_c; a body can have (m, I_c) where it is >= 0.

    The principal values of S_c are (B + C - A)/2: positive moments and their triangle inequalities in one number.
    """
    trace = inertia[0, 0] + inertia[1, 1] + inertia[2, 2]
    values, _ = so3.symmetric(trace / 2 * ex.eye(3) - inertia)
    return ex.fmin(ex.fmin(mass, values[0]), ex.fmin(values[1], values[2]))
