"""What limits the cycle of a planned job: how much of each limit is used when, and what more of each would save."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import msgspec
import numpy as np

from mafsil.arrays import Floats
from mafsil.job.planning.plan import Plan, Timing
from mafsil.job.remark import Refused, Remark
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.robot import Robot
from mafsil.trajectory import Trajectory

OF_JOINTS = ("velocity", "acceleration", "jerk")
OF_TIP = ("tip_speed", "tip_angular_speed", "tip_acceleration")
MORE = 0.1
"""How much larger each limit is made, as share of it."""
DECIDES = 0.99
"""Share of a limit from which on it decides."""
SAMPLES = 1001
"""Even times of a leg at which is looked how much of each limit is used."""
NOTABLE = 0.01
"""Share of the cycle that more of a limit has to save to be worth a remark."""
SMALL = 1e-3
"""Share of the cycle below which neither time decided nor time saved is worth a line."""


class CycleLimit(NamedTuple):
    """One limit of a job.

    Attributes:
        quantity: `velocity`, `acceleration`, `jerk`, `tip_speed`, `tip_angular_speed` or `tip_acceleration`.
        joint: index; -1 for limits of the tip.
        deciding: how long at least 99 per cent of it are used, and of no other limit more [s].
        saved: by ten per cent more of it, each move solved again on its path [s]; NaN where one has no motion then.
    """

    quantity: str
    joint: int
    deciding: float
    saved: float


@dataclass(frozen=True, slots=True)
class NamedLimit:
    """A limit in words.

    Attributes:
        quantity: as in `CycleLimit`.
        joint: its name; empty for limits of the tip.
    """

    quantity: str
    joint: str

    def explain(self, *, language: str | None = None) -> str:
        """`the velocity of joint2`, `the speed of the tip`."""
        name = say(f"trajectory.{self.quantity}", language=language)
        return say("job.limit_of", language=language, quantity=name, joint=self.joint) if self.joint else name


def name_limit(robot: Robot, quantity: str, joint: int) -> NamedLimit:
    """A limit by the name of its joint.

    Args:
        robot: gives the names.
        quantity, joint: as in `CycleLimit`.
    """
    return NamedLimit(quantity, visible(robot.joint_names[joint]) if joint >= 0 else "")


def would_save(robot: Robot, limits: tuple[CycleLimit, ...], cycle: float) -> list[Remark]:
    """The limit of which more saves most, if that is worth a line.

    Args:
        robot: gives the names.
        limits: the most precious first.
        cycle: time of the cycle [s].
    """
    if not limits or not limits[0].saved >= NOTABLE * cycle:
        return []
    best = limits[0]
    limit = name_limit(robot, best.quantity, best.joint)
    saved = quantity(best.saved, "s")
    return [Remark("good", "job.would_save", {"more": digits(100 * MORE), "limit": limit, "saved": saved})]


def limits_of_cycle(plan: Plan) -> tuple[CycleLimit, ...]:
    """Limits that decide for at least a thousandth of the cycle or would save as much, the most precious first.

    1. How much of each limit every leg uses over time; where the greatest share is at least 99 per cent, it decides.
    2. Limits that a leg uses up somewhere, and those of the tip on its paths, are raised one by one, the leg solved
       again: paths and configurations stay as they were planned.
    3. What that saves in all, for legs follow each other; waits for signals take back what comes too early.

    Args:
        plan: of a job.
    """
    labels = labels_of(len(plan.start))
    deciding = np.zeros(len(labels))
    planned = np.array([leg.trajectory.duration for leg in plan.legs])
    shorter = np.tile(planned, (len(labels), 1))
    for i, leg in enumerate(plan.legs):
        if leg.timing is None or leg.trajectory.duration == 0.0:
            continue
        # 1
        t = np.linspace(0.0, leg.trajectory.duration, SAMPLES)
        used = shares(leg.load.robot, leg.trajectory, leg.timing, t)
        step = leg.trajectory.duration / SAMPLES
        greatest = used.argmax(axis=1)[used.max(axis=1) >= DECIDES]
        deciding += step * np.bincount(greatest, minlength=len(labels))
        # 2
        for k, (bounded, joint) in enumerate(labels):
            spent = used[:, k].max() >= DECIDES or (joint < 0 and leg.timing.speed is not None)
            if spent:
                shorter[k, i] = _again(leg.timing, bounded, joint)
    # 3
    saved = np.array([plan.duration - plan.lasting(row) if (row != planned).any() else 0.0 for row in shorter])
    least = SMALL * plan.duration
    found = [CycleLimit(*labels[k], float(deciding[k]), float(saved[k])) for k in range(len(labels))]
    kept = [one for one in found if one.deciding >= least or not one.saved < least]
    return tuple(sorted(kept, key=lambda one: (-np.nan_to_num(one.saved), -one.deciding)))


def labels_of(n: int) -> tuple[tuple[str, int], ...]:
    """Quantity and joint of every column of `shares`.

    Args:
        n: joints.
    """
    return (*((quantity, j) for quantity in OF_JOINTS for j in range(n)), *((quantity, -1) for quantity in OF_TIP))


def shares(robot: Robot, motion: Trajectory, timing: Timing, t: Floats) -> Floats:
    """(k, 3 n + 3) how much of each limit a leg uses, as share of it; 0 for limits that it does not have.

    Args:
        robot: with its tool.
        motion: of the leg.
        timing: what it keeps.
        t: (k,) times since it began [s].
    """
    u, v, a = motion.at(t)
    limits = timing.limits
    columns = [_share(v, limits.velocity), _share(a, limits.acceleration)]
    columns.append(_share(motion.jerk(t), limits.jerk) if np.isfinite(limits.jerk).any() else np.zeros_like(v))
    of_tip = np.zeros((len(t), len(OF_TIP)))
    if timing.speed is not None:
        J, J_rate = robot.jacobian_body(u), robot.jacobian_body_rate(u, v)
        V = np.einsum("kij,kj->ki", J, v)
        V_rate = np.einsum("kij,kj->ki", J, a) + np.einsum("kij,kj->ki", J_rate, v)
        pull = V_rate[:, 3:] + np.cross(V[:, :3], V[:, 3:])
        sizes = (np.linalg.norm(part, axis=1) for part in (V[:, 3:], V[:, :3], pull))
        factors = (timing.speed, timing.speed, timing.speed**2)
        for k, (size, factor, name) in enumerate(zip(sizes, factors, OF_TIP, strict=True)):
            of_tip[:, k] = size / (factor * getattr(timing.bounds, name))
    return np.concatenate([*columns, of_tip], axis=1)


def most_used(plan: Plan, t: Floats) -> tuple[Floats, tuple[tuple[str, int], ...]]:
    """(k, m) share of each limit while it is the one that is used most, else NaN; and what the columns mean.

    Args:
        plan: of a job.
        t: (k,) increasing times since the job began [s].
    """
    labels, starts = labels_of(len(plan.start)), plan.starts
    used = np.zeros((len(t), len(labels)))
    for leg, begin, end in zip(plan.legs, starts, starts[1:], strict=False):
        rows = (t >= begin) & (t < end)
        if leg.timing is not None and rows.any():
            used[rows] = shares(leg.load.robot, leg.trajectory, leg.timing, t[rows] - begin)
    most = used.argmax(axis=1)[:, None] == np.arange(len(labels))
    most &= used.max(axis=1)[:, None] > 0.0
    # A curve goes on to the row after its last one, so that the next begins where it ends.
    most[1:] |= most[:-1]
    decides = (np.where(most, used, 0.0) >= DECIDES).any(axis=0)
    rest = np.where(most & ~decides, used, 0.0).max(axis=1)
    kept = np.flatnonzero(decides)
    values = np.where(most[:, kept], used[:, kept], np.nan)
    others = np.where(rest > 0.0, rest, np.nan)[:, None]
    return np.concatenate([values, others], axis=1), (*(labels[k] for k in kept), ("others", -1))


def _again(timing: Timing, quantity: str, joint: int) -> float:
    """The duration with more of one limit [s]; NaN where there is no motion then."""
    limits, bounds = timing.limits, timing.bounds
    if joint < 0:
        bounds = msgspec.structs.replace(bounds, **{quantity: (1.0 + MORE) * getattr(bounds, quantity)})
    else:
        more = np.array(getattr(limits, quantity))
        more[joint] *= 1.0 + MORE
        limits = replace(limits, **{quantity: more})
    try:
        return timing.again(limits, bounds)
    except Refused:
        return float("nan")


def _share(values: Floats, limit: Floats) -> Floats:
    """Of a limit; 0 where there is none."""
    return np.abs(values) / np.where(limit > 0.0, limit, np.inf)
