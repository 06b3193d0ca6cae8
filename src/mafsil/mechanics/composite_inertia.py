"""Inertia of bodies as expressions: of one body, of all bodies behind a joint, seen from other frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mafsil.expression as ex
from mafsil.mechanics.body_tree import RigidInertia
from mafsil.mechanics.placement import Expression, Placement, constant


@dataclass(frozen=True, slots=True)
class CompositeInertia:
    """Mass, first moment h (3,) and rotational inertia I (3, 3) about the origin, as expressions."""

    mass: Expression
    h: Expression
    I: Expression

    @staticmethod
    def of(inertia: RigidInertia) -> CompositeInertia:
        """Of a body whose numbers are known; zeros among them are structural."""
        return CompositeInertia(ex.Expression(inertia.mass), constant(inertia.h), constant(inertia.I))

    @staticmethod
    def of_parameters(phi: Sequence[Expression]) -> CompositeInertia:
        """Of a body with ten parameters m, hx, hy, hz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the origin."""
        m, hx, hy, hz, *moments = phi
        return CompositeInertia(m, ex.vertcat(hx, hy, hz), _from_six(*moments))

    def add(self, other: CompositeInertia) -> CompositeInertia:
        """Both bodies as one."""
        return CompositeInertia(self.mass + other.mass, self.h + other.h, self.I + other.I)

    def in_parent(self, step: Placement) -> CompositeInertia:
        """Seen from the parent's frame: turned, then shifted by the offset (Steiner)."""
        h = step.to_parent(self.h)
        turned = turned_symmetric(self.I, step)
        p = step.offset
        return CompositeInertia(self.mass, h + self.mass * p, turned + _shift(p, h + 0.5 * self.mass * p))

    def unit_acceleration(self, step: Placement) -> tuple[Expression, Expression]:
        """G S: the wrench (moment, force) per unit acceleration of the joint with the screw S = (w z, v z)."""
        h = self.h
        moment = step.omega * self.I[:, 2] + step.v * ex.vertcat(h[1], -h[0], 0)
        return moment, step.omega * ex.vertcat(-h[1], h[0], 0) + step.v * ex.vertcat(0, 0, self.mass)


def turned_symmetric(inertia: Expression, step: Placement) -> Expression:
    """R_c Rz I Rz' R_c' for a symmetric I, by double angles about z, then the constant turn."""
    c, s = step.cosine, step.sine
    xx, yy, zz, xy, xz, yz = inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]
    half_swing = s * (s * (yy - xx) - 2 * c * xy)
    new_xx, new_yy = xx + half_swing, yy - half_swing
    new_xy = c * (s * (xx - yy) + 2 * c * xy) - xy
    new_xz, new_yz = c * xz - s * yz, s * xz + c * yz
    about_z = _from_six(new_xx, new_yy, zz, new_xy, new_xz, new_yz)
    return step.R @ about_z @ step.R.T


def _from_six(
    xx: Expression, yy: Expression, zz: Expression, xy: Expression, xz: Expression, yz: Expression
) -> Expression:
    return ex.vertcat(ex.horzcat(xx, xy, xz), ex.horzcat(xy, yy, yz), ex.horzcat(xz, yz, zz))


def _shift(p: Expression, g: Expression) -> Expression:
    """(p . g + g . p) E - p g' - g p': what moving the origin by p adds, with g = h + m p / 2."""
    px, py, pz = p[0], p[1], p[2]
    gx, gy, gz = g[0], g[1], g[2]
    x, y, z = 2 * px * gx, 2 * py * gy, 2 * pz * gz
    return _from_six(y + z, x + z, x + y, -(px * gy + py * gx), -(px * gz + pz * gx), -(py * gz + pz * gy))
