"""Gears, belts and cams: joints whose coordinate is a function of that of another one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, number, real_array
from mafsil.errors import InputError
from mafsil.fields import check_fields
from mafsil.solvers.cubic_spline import Spline

FULL_TURN = 1e-9
"""How far the table of a cam may miss a whole turn [rad], or its end the beginning: nine typed digits."""


def _cam_rows(name: str, value: object) -> tuple[tuple[float, float], ...]:
    """Rows of a cam over one turn; none is no cam.

    Raises:
        InputError: the leader does not increase through one turn, or the follower does not come back.
    """
    given = real_array(name, cast("ArrayLike", value))
    if not given.size:
        return ()
    rows = as_batch(name, given, (2,), finite=True)
    increases = rows.ndim == 2 and len(rows) > 3 and bool((np.diff(rows[:, 0]) > 0).all())
    ends = rows[-1] - rows[0] if increases else np.zeros(2)
    if not increases or abs(ends[0] - 2 * np.pi) > FULL_TURN or abs(ends[1]) > FULL_TURN * np.abs(rows[:, 1]).max():
        raise InputError("mobility.cam", name=name, count=len(rows), turn=float(ends[0]), miss=float(ends[1]))
    inside = [(float(angle), float(lift)) for angle, lift in rows[:-1]]
    return (*inside, (inside[0][0] + 2 * np.pi, inside[0][1]))


@dataclass(frozen=True)
class Coupling:
    """Gears, belts, cams, joints that follow others: theta_follower = f(theta_leader) - f(0), counted from the drawing.

    Attributes:
        follower, leader: names of joints of one freedom.
        ratio: f is ratio theta_leader [1, m/rad or rad/m]; not zero, unless there is a table.
        table: of a cam, rows (leader, follower) [rad, rad | m] over one turn of the leader, the last follower as the
            first: f is the periodic cubic spline through them, so that accelerations are continuous.
    """

    follower: str
    leader: str
    ratio: float = 0.0
    table: tuple[tuple[float, float], ...] = ()
    __post_init__ = check_fields(ratio=number, table=_cam_rows)

    @cached_property
    def _spline(self) -> Spline:
        angle, lift = np.array(self.table).T
        return Spline(angle, lift, periodic=True)

    def motion(self, leader: Floats) -> tuple[Floats, Floats, Floats]:
        """Coordinate of the follower with its first and second derivative, at coordinates (*batch) of the leader."""
        if not self.table:
            return self.ratio * leader, np.full(leader.shape, self.ratio), np.zeros(leader.shape)
        value, slope, bend = (self._spline(leader, k) for k in range(3))
        return value - self._spline(0.0), slope, bend

    def counted_from(self, leader: float) -> Coupling:
        """The same with coordinates that are zero where the leader is at one [rad | m]."""
        return replace(self, table=tuple((angle - leader, lift) for angle, lift in self.table))
