"""Angles of cranks whose rods hold a platform, for poses of the platform: both of each, or by how much its rod misses.

A crank of length L goes round in a plane; its rod of length l ends at a point of that plane, `reach` from the motor, or
at some distance `across` from it. The angle between crank and point is acos(K / reach), with
K = (reach^2 + across^2 + L^2 - l^2) / (2 L).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.tolerances import TOUCHING


class MotorAnglesStatus(Status):
    """Whether all motors reach all poses."""

    REACHED = ("parallel.motors_reach", True)
    SOME = ("parallel.motors_some", False)
    OUT_OF_REACH = ("parallel.motors_out_of_reach", False)


@dataclass(frozen=True, eq=False, repr=False)
class MotorAngles(Answer, data="q misfit free reached"):
    """Both angles of each motor; true if every pose is reached, iterable over all choices, of a batch over its rows.

    Attributes:
        q: (*batch, m, 2) angles in (-pi, pi]; twice the one at which the rod comes nearest where it does not fit [rad].
        misfit: (*batch, m) by how much each rod is too short (positive) or too long; zero where it fits [m].
        free: (*batch, m) whether any angle will do: the rod ends on the axis of its motor, at the right distance.
        unit: deg of motors that turn, whose angles are radians all the same; m of motors that slide.
    """

    q: Floats
    misfit: Floats
    free: Booleans
    unit: str = "deg"

    @property
    def reached(self) -> Booleans:
        """(*batch,) whether all rods fit."""
        return np.asarray((self.misfit == 0.0).all(axis=-1), dtype=np.bool_)

    @property
    def choices(self) -> Floats:
        """(*batch, 2^m, m) all combinations of one angle for each motor, the last motor changing first."""
        m = self.q.shape[-2]
        picked = [self.q[..., np.arange(m), list(choice)] for choice in product((0, 1), repeat=m)]
        return np.stack(picked, axis=-2)

    @property
    def status(self) -> MotorAnglesStatus:
        """Of all rows together."""
        if self.reached.all():
            return MotorAnglesStatus.REACHED
        return MotorAnglesStatus.SOME if self.reached.any() else MotorAnglesStatus.OUT_OF_REACH

    def __len__(self) -> int:
        if self.misfit.ndim > 1:
            return len(self.q)
        return int(2 ** self.q.shape[-2]) if self else 0

    def __iter__(self) -> Iterator[Any]:
        if self.misfit.ndim > 1:
            return (MotorAngles(*row, self.unit) for row in zip(self.q, self.misfit, self.free, strict=True))
        return iter(self.choices if self else self.choices[:0])

    def _table(self) -> list[str]:
        if self.misfit.ndim > 1 or not self:
            return []
        head = (say("cli.parallel_motor"), f"1 [{self.unit}]", f"2 [{self.unit}]")
        shown = np.degrees(self.q) if self.unit == "deg" else self.q
        rows = [(str(k + 1), *map(number, both)) for k, both in enumerate(shown.tolist())]
        return table(head, rows)

    def explain(self, language: str | None = None) -> str:
        """How many poses are reached; of the row that misses most which motor, and by how much."""
        rows = self.misfit.reshape(-1, self.misfit.shape[-1])
        row, motor = np.unravel_index(int(np.abs(rows).argmax()), rows.shape) if rows.size else (0, 0)
        worst = float(rows[row, motor]) if rows.size else 0.0
        sentence = self.status.sentence(
            language, reached=int(self.reached.sum()), rows=len(rows), motors=rows.shape[-1], free=int(self.free.sum())
        )
        if not worst:
            return sentence
        reason = "short" if worst > 0 else "long"
        missed = say(f"parallel.rod_{reason}", language=language, motor=int(motor) + 1, length=abs(worst))
        return f"{sentence}: {missed}"


def crank_angles(along: Floats, up: Floats, across: Floats | float, crank: Floats | float, rod: Floats) -> MotorAngles:
    """Both angles of cranks, that with its elbow to the left of the line from the motor to the point first.

    Args:
        along, up: (*batch, m) place of the end of the rod in the plane of the crank, from its motor [m].
        across: (*batch, m) its distance from that plane [m].
        crank, rod: lengths [m].
    """
    reach = np.hypot(along, up)
    misfit = rod_misfit(reach, across, crank, rod)
    misfit = np.where(np.abs(misfit) <= TOUCHING * (crank + rod), 0.0, misfit)
    K = (reach**2 + across**2 + crank**2 - rod**2) / (2 * crank)
    free = np.asarray((reach <= TOUCHING * (crank + rod)) & (misfit == 0.0), dtype=np.bool_)
    ratio = np.divide(K, reach, out=np.ones_like(K), where=reach > 0.0)
    half = np.arccos(np.clip(ratio, -1.0, 1.0))
    middle = np.arctan2(up, along)
    return MotorAngles(wrap_angle(np.stack([middle + half, middle - half], axis=-1)), misfit, free)


def rod_misfit(along: Floats, across: Floats | float, crank: Floats | float, rod: Floats | float) -> Floats:
    """Lengths [m] that rods miss: positive where they are too short, negative where too long, zero where they fit.

    Args:
        along: distance of the far end of the rod from the motor, in the plane in which the crank goes round [m].
        across: its distance from that plane [m].
        crank, rod: lengths [m].
    """
    near, far = np.hypot(across, along - crank), np.hypot(across, along + crank)
    return np.maximum(near - rod, 0.0) - np.maximum(rod - far, 0.0)
