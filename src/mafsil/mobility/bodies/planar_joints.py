"""Two bodies of the plane by points A, B and C, D: what a joint between them asks, and where it lets the second stand.

Coordinates (xA, yA, phi_AB, xC, yC, phi_CD); B = A + d_AB u(phi_AB), D = C + d_CD u(phi_CD).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, number, real_array
from mafsil.errors import InputError
from mafsil.mobility.bodies.rigid_points import planar_body

KINDS = ("R", "P", "RP", "PR")


@dataclass(frozen=True, eq=False)
class SecondBody:
    """Where the second body stands.

    Attributes:
        B, C, D: (*batch, 2) points [m].
        phi_CD: (*batch,) its direction [rad].
    """

    B: Floats
    C: Floats
    D: Floats
    phi_CD: Floats


def _unit(angle: Floats) -> Floats:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def second_body(
    kind: str, A: ArrayLike, phi_AB: ArrayLike, d_AB: float, d_CD: float, *, theta: ArrayLike = 0.0, d: ArrayLike = 0.0,
    slot: float = 0.0,
) -> SecondBody:  # fmt: skip
    """Points of the second body from independent coordinates.

    R: C = B, phi_CD = phi_AB + theta. P: C = B + d u(phi_AB + slot), phi_CD = phi_AB + theta with theta constant.
    RP (slot in the second body): C = B + d u(phi_CD + slot). PR (slot in the first): C = B + d u(phi_AB + slot).

    Args:
        kind: R, P, RP or PR.
        A: (*batch, 2) [m].
        phi_AB: (*batch,) [rad].
        d_AB, d_CD: lengths of the bodies [m].
        theta: (*batch,) angle from the first body to the second [rad].
        d: (*batch,) displacement along the slot [m].
        slot: angle of the slot in its body [rad].

    Raises:
        InputError: another kind.
    """
    d_AB, d_CD, slot = number("d_AB", d_AB), number("d_CD", d_CD), number("slot", slot)
    if kind not in KINDS:
        raise InputError("mobility.planar_kind", kind=kind, known=", ".join(KINDS))
    phi = real_array("phi_AB", phi_AB)
    B = planar_body(A, phi, d_AB)
    other = phi + real_array("theta", theta)
    along = other + slot if kind == "RP" else phi + slot
    C = B if kind == "R" else B + real_array("d", d)[..., None] * _unit(along)
    return SecondBody(B, C, planar_body(C, other, d_CD), other)


def joint_residual(kind: str, x: ArrayLike, d_AB: float, *, theta: float = 0.0, slot: float = 0.0) -> Floats:
    """(*batch, k) what the joint asks of coordinates (*batch, 6): 2 for R and P, 1 for RP and PR; zero when it holds.

    Args:
        kind: R, P, RP or PR.
        x: (*batch, 6) (xA, yA, phi_AB, xC, yC, phi_CD) [m, rad].
        d_AB: length of the first body [m].
        theta: constant angle between the bodies of P [rad].
        slot: angle of the slot in its body [rad].
    """
    d_AB, theta, slot = number("d_AB", d_AB), number("theta", theta), number("slot", slot)
    if kind not in KINDS:
        raise InputError("mobility.planar_kind", kind=kind, known=", ".join(KINDS))
    v = as_batch("x", x, (6,))
    B, C = planar_body(v[..., :2], v[..., 2], d_AB), v[..., 3:5]
    if kind == "R":
        return C - B
    along = v[..., 5] + slot if kind == "RP" else v[..., 2] + slot
    off = np.sum(_unit(along + np.pi / 2) * (C - B), axis=-1)
    if kind == "P":
        return np.stack([off, v[..., 5] - v[..., 2] - theta], axis=-1)
    return off[..., None]
