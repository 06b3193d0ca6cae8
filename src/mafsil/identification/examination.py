"""Faults of logs that a description gives away: reversed signs, other units, swapped columns, a motor's efforts.

1. Each joint's effort is regressed on what the description asks for there, beside friction, an offset and a rotor, of
   which descriptions know little: the slope, and the share of the rest that it explains.
2. Slopes far from one that explain most of an effort: a sign, or another unit.
3. Unless the log fits as it is, one change after the other is tried on it: a joint or two turned round, degrees,
   milliseconds, two columns swapped. The one that explains most joints counts, if it explains them several times better
   than the log as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from mafsil.arrays import Booleans, Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.identification.log import Remark
from mafsil.identification.smoothing import SmoothMotion
from mafsil.mechanics.friction import SMOOTHING
from mafsil.robot import Robot
from mafsil.robot.compiled_robot import has_inertia

ROWS = 800
"""Samples that are looked at, evenly spread."""
EXPLAINED = 0.9
"""Share of an effort that a description explains of which masses, but no signs and units, are wrong."""
ODD = 8.0
"""A slope beyond this or below its reciprocal is no matter of masses."""
BETTER = 4.0
"""Factor by which a change must lower what stays unexplained before it is believed."""
LEAST_JOINTS = 2
"""So many must be explained by a change: one alone is explained by chance."""
FELT = 1e-3
"""Share of a joint's effort that is more than friction, offset and rotor can explain, for it to be judged."""
SECONDS = {"milliseconds": 1e-3, "microseconds": 1e-6, "minutes": 60.0}


@dataclass(frozen=True, eq=False, slots=True)
class _Rows:
    """Samples of a log: motion and efforts, (k, n) each."""

    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats

    def scale_motion(self, factors: Floats) -> _Rows:
        """The motion times factors (n,) of the joints."""
        return _Rows(self.q * factors, self.qd * factors, self.qdd * factors, self.tau)

    def slowed(self, seconds: float) -> _Rows:
        """The motion with another unit of time."""
        return _Rows(self.q, self.qd / seconds, self.qdd / seconds**2, self.tau)

    def swapped(self, own: list[int], efforts: bool) -> _Rows:
        """Columns of the motion, or of the efforts, in another order."""
        if efforts:
            return _Rows(self.q, self.qd, self.qdd, self.tau[:, own])
        return _Rows(self.q[:, own], self.qd[:, own], self.qdd[:, own], self.tau)


@dataclass(frozen=True, eq=False, slots=True)
class _Judged:
    """Slopes of the efforts against the description's, and what it explains of what friction does not; (n,) each."""

    slope: Floats
    explained: Floats

    @property
    def clear(self) -> Booleans:
        """Joints whose effort is explained."""
        return self.explained > EXPLAINED

    @property
    def odd(self) -> Booleans:
        """Explained joints whose slope is no matter of masses: a sign, or another unit."""
        size = np.abs(self.slope)
        return self.clear & ((self.slope < 0.0) | (size > ODD) | (size < 1.0 / ODD))

    @property
    def fits(self) -> bool:
        """Whether every joint that can be judged is explained as it is: no change could explain more."""
        felt = self.explained > 0.0
        return bool(felt.any() and self.clear[felt].all() and not self.odd.any())

    @property
    def rank(self) -> tuple[int, float]:
        """Less is better: more joints explained, and these better."""
        return -int(self.clear.sum()), self.left(self.clear) if self.clear.any() else 1.0

    def left(self, judged: Booleans) -> float:
        """Mean share of the efforts of some joints that stays unexplained."""
        return float((1.0 - self.explained[judged]).mean())


def examine_log(robot: Robot, motions: Sequence[SmoothMotion]) -> list[Remark]:
    """What is probably wrong with a log, each with its number; nothing where the description cannot tell.

    Args:
        robot: with masses.
        motions: of the log.
    """
    rows = _sample(motions)
    if rows is None or not has_inertia(robot.mechanism):
        return []
    first = _judge(robot, rows)
    if first.fits:
        return []
    tried = [(remark, _judge(robot, changed)) for remark, changed in _changes(robot, rows)]
    remark, best = min(tried, key=lambda one: one[1].rank)
    judged = best.clear
    few = judged.sum() < max(first.clear.sum(), min(robot.n, LEAST_JOINTS))
    if few or best.left(judged) * BETTER > first.left(judged):
        return _slopes(robot, first)
    details = {"before": 100.0 * (1.0 - first.left(judged)), "after": 100.0 * (1.0 - best.left(judged))}
    return [Remark(remark.key, {**remark.details, **details}), *_slopes(robot, best)]


def _sample(motions: Sequence[SmoothMotion]) -> _Rows | None:
    q, qd, qdd, tau = (np.concatenate([getattr(m, name) for m in motions]) for name in ("q", "qd", "qdd", "tau"))
    if len(q) < 10 * (q.shape[1] + 5):
        return None
    at = np.unique(np.linspace(0, len(q) - 1, ROWS).astype(np.intp))
    return _Rows(q[at], qd[at], qdd[at], tau[at])


def _judge(robot: Robot, rows: _Rows) -> _Judged:
    wanted = np.asarray(robot.inverse_dynamics(rows.q, rows.qd, rows.qdd))
    n = robot.n
    slope, explained = np.zeros(n), np.zeros(n)
    for k in range(n):
        rate = rows.qd[:, k]
        known = np.stack([np.ones_like(rate), rate, np.tanh(rate / SMOOTHING), rows.qdd[:, k]], axis=1)
        known = np.linalg.qr(known / np.maximum(np.abs(known).max(axis=0), LEAST_DIVISOR))[0]
        x, y = (each - known @ (known.T @ each) for each in (wanted[:, k], rows.tau[:, k]))
        if x @ x > FELT**2 * (wanted[:, k] @ wanted[:, k]) > 0.0 and y @ y > 0.0:
            slope[k], explained[k] = (x @ y) / (x @ x), (x @ y) ** 2 / ((x @ x) * (y @ y))
    return _Judged(slope, explained)


def _slopes(robot: Robot, found: _Judged) -> list[Remark]:
    """What slopes far from one say: of all joints together, or of each."""
    odd = np.flatnonzero(found.odd).tolist()
    reversed_ones = [k for k in odd if found.slope[k] < 0.0]
    if len(reversed_ones) > 1 and len(reversed_ones) == int(found.clear.sum()):
        share = float(np.median(found.slope[reversed_ones]))
        return [Remark("identification.reversed_efforts", {"slope": share})]
    return [
        Remark(
            "identification.reversed_effort" if found.slope[k] < 0.0 else "identification.scaled_effort",
            {"joint": robot.joint_names[k], "slope": float(found.slope[k]), "ratio": float(1.0 / abs(found.slope[k]))},
        )
        for k in odd
    ]


def _changes(robot: Robot, rows: _Rows) -> Iterator[tuple[Remark, _Rows]]:
    """Changes of the log that one would make by mistake, undone; each with its sentence."""
    n, names = robot.n, robot.joint_names
    for turned in [*combinations(range(n), 1), *combinations(range(n), 2)]:
        factors = np.where(np.isin(np.arange(n), turned), -1.0, 1.0)
        which = ", ".join(names[k] for k in turned)
        yield Remark("identification.reversed_joint", {"joint": which}), rows.scale_motion(factors)
    revolves = robot.mechanism.angular
    yield Remark("identification.in_degrees"), rows.scale_motion(np.where(revolves, np.pi / 180.0, 1.0))
    for unit, seconds in SECONDS.items():
        yield Remark("identification.time_unit", {"unit": unit}), rows.slowed(seconds)
    for i, j in combinations(range(n), 2):
        order = [j if k == i else i if k == j else k for k in range(n)]
        for signal, efforts in (("tau", True), ("q", False)):
            details = {"signal": signal, "first": names[i], "second": names[j]}
            yield Remark("identification.swapped_columns", details), rows.swapped(order, efforts)
