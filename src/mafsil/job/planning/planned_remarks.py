"""What in a plan deserves a remark: limits that were assumed or come close, lines that joints slow down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.job.language.description import Job, Task
from mafsil.job.planning.closed_moves import listed_joints
from mafsil.job.planning.fitting import assumed_limits, revolute
from mafsil.job.planning.goals import FIXES
from mafsil.job.planning.quickest import TIP, Deciding
from mafsil.job.planning.tip_motion import TipMotion
from mafsil.job.remark import Level, Remark, Where
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import Trajectory
from mafsil.trajectory.paths.pose_path import path_error

MOST_LIMITS, SMALL_SHARE = 4, 0.01
"""Limits that are named of a move in the shortest time, and the least share of its time that is worth naming."""
PLANNED = {"velocity": 0.99, "acceleration": 0.96}
"""Share of the limits of the description within which moves are planned at most: the feedback needs the rest.

Where a motion uses up its limits, the arm that follows it is beyond them by a few per cent of its acceleration and a
few tenths of a per cent of its speed: by the steps of the law, and by errors that the feedback takes back.
"""
TIGHT = 0.02
"""Distance to a position limit, as share of the range, below which a remark is made."""
LONG, SHORT_WAY, WAY_SAMPLES = 2.0, 0.05, 200
"""Factor of the straight way beyond which a tip's way is long, if it is so much longer [m]; moments looked at."""
SLOW = 2.0
"""How many times as long as the tip's bounds ask for a line may take before others are tried, or a warning."""
NOTABLE = 1.5
"""Times SLOW: how much slower one place of a line has to be to be worth a remark of its own."""
NEARLY = (1e-5, 1e-4)
"""What is left of the way to a pose that is met nearly, from which on a remark is made [m, rad]."""


class Tight(NamedTuple):
    """A move on which a joint comes close to a position limit.

    Attributes:
        joint: its name.
        side: lower or upper.
        share: of its range that is left.
        move: which one.
    """

    joint: str
    side: str
    share: float
    move: Where


def near_limits(robot: Robot, trajectory: Trajectory, where: Where) -> list[Tight]:
    """Joints that come close to a position limit on the way."""
    found: list[Tight] = []
    q = trajectory.at(np.linspace(0.0, trajectory.duration, 200)).u
    lower, upper = robot.limits.lower, robot.limits.upper
    for k, joint in enumerate(robot.joint_names):
        span = upper[k] - lower[k]
        if not np.isfinite(span) or span <= 0.0:
            continue
        for side, gap in (("lower", q[:, k].min() - lower[k]), ("upper", upper[k] - q[:, k].max())):
            if gap < TIGHT * span:
                found.append(Tight(joint, side, max(float(gap / span), 0.0), where))
    return found


def tight_limits(found: Sequence[Tight]) -> list[Remark]:
    """One remark for each limit: the move that comes nearest to it, and how many do.

    Args:
        found: on all moves.
    """
    grouped: dict[tuple[str, str], list[Tight]] = {}
    for one in found:
        grouped.setdefault((one.joint, one.side), []).append(one)
    remarks: list[Remark] = []
    for (joint, side), moves in grouped.items():
        nearest = min(moves, key=lambda one: one.share)
        details = {"move": nearest.move, "joint": visible(joint), "share": digits(100 * nearest.share)}
        details |= {"side": f"@job.{side}", "count": len(moves)}
        remarks.append(Remark("warning", "job.tight_limit" if len(moves) == 1 else "job.tight_limits", details))
    return remarks


def slowed_lines(robot: Robot, line: TipMotion, where: Where) -> list[Remark]:
    """A line that the joints slow down: where, which joint, how much."""
    slow = line.slowest
    if slow is None or line.configuration is None or max(line.factor, slow.factor / NOTABLE) <= SLOW:
        return []
    units = ["rad" if angle else "m" for angle in revolute(robot)]
    details: dict[str, object] = {
        "move": where,
        "time": quantity(line.trajectory.duration, "s"),
        "brisk": quantity(line.brisk, "s"),
        "place": quantity(slow.place, "share"),
        "joint": visible(robot.joint_names[slow.joint]),
        "factor": digits(slow.factor),
        "margin": digits(line.margin),
        "configuration": ", ".join(map(quantity, line.configuration, units)),
    }
    level: Level = "warning" if line.factor > SLOW else "good"
    return [Remark(level, f"job.slow_line_{slow.quantity}", details)]


def long_way(robot: Robot, motion: Trajectory, planned: bool, where: Where) -> list[Remark]:
    """A move of the joints whose tip goes more than twice as far as straight to its goal: how far, and why.

    Args:
        robot: with its tool.
        motion: of the move.
        planned: whether the move goes round something, or keeps path constraints.
        where: how the move is called.
    """
    q = motion.at(np.linspace(0.0, motion.duration, WAY_SAMPLES)).u
    p = np.asarray(robot.forward_kinematics(q))[:, :3, 3]
    length, straight = float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum()), float(np.linalg.norm(p[-1] - p[0]))
    if length <= LONG * straight + SHORT_WAY:
        return []
    swing = np.where(robot.mechanism.angular, np.abs(q[-1] - q[0]), 0.0)
    joint = int(swing.argmax())
    details = {
        "move": where, "length": quantity(length, "m"), "straight": quantity(straight, "m"),
        "joint": visible(robot.joint_names[joint]), "angle": quantity(float(swing[joint]), "rad"),
    }  # fmt: skip
    return [Remark("good", "job.long_way_planned" if planned else "job.long_way_joints", details)]


def decided_by(robot: Robot, binding: Deciding, where: Where) -> list[Remark]:
    """Which limits decide how fast a move in the shortest time is, and for how much of it."""
    if not binding.shares:
        return []
    listed = tuple(
        Limiting(one.quantity, visible((*robot.joint_names, *TIP)[one.joint]), round(100 * one.share))
        for one in binding.shares[:MOST_LIMITS]
        if one.share >= SMALL_SHARE
    )
    return [Remark("good", "job.decided_by", {"move": where, "limits": Listed(listed)})]


@dataclass(frozen=True, slots=True)
class Limiting:
    """A limit that decides how fast a move is: quantity, joint, and per cent of its time."""

    quantity: str
    joint: str
    percent: int


@dataclass(frozen=True, slots=True)
class Listed:
    """Limits in a sentence, in any language."""

    limits: tuple[Limiting, ...]

    def explain(self, *, language: str | None = None) -> str:
        """`the velocity of joint2 (64 %), the acceleration of joint6 (30 %)`."""
        separator = say("job.list_separator", language=language)
        return separator.join(
            say(
                "job.limiting",
                language=language,
                quantity=say(f"trajectory.{one.quantity}", language=language),
                joint=say(f"job.{one.joint}", language=language) if one.joint in TIP else one.joint,
                percent=one.percent,
            )
            for one in self.limits
        )


def nearly_met(robot: Robot, q: JointVector, target: PoseMatrix, task: Task, where: Where) -> list[Remark]:
    """A pose that an arm with few joints meets only nearly, and what is left."""
    if robot.n >= FIXES[task]:
        return []
    left = np.abs(path_error(np.asarray(robot.forward_kinematics(q)), target, task))
    turn, way = float(np.linalg.norm(left[:-3])), float(np.linalg.norm(left[-3:]))
    if way <= NEARLY[0] and turn <= NEARLY[1]:
        return []
    details = {"position": quantity(way, "m"), "angle": quantity(turn, "rad"), "joints": robot.n}
    return [Remark("good", "job.nearly_met", {"move": where, **details})]


def driving_limits(job: Job, robot: Robot) -> tuple[JointLimits, list[Remark]]:
    """Limits as the job wants them, finite wherever motion needs them, with remarks on what was assumed."""
    own, bounds = robot.limits, job.limits
    driven = np.zeros(robot.n, dtype=np.bool_)
    driven[listed_joints(robot, -1)] = True
    remarks: list[Remark] = []
    values: dict[str, Floats] = {}
    reserved = False
    for name, asked in (("velocity", bounds.speed_scale), ("acceleration", bounds.acceleration_scale)):
        known: Floats = getattr(own, name)
        share = min(asked, PLANNED[name])
        reserved |= share < asked and bool((np.isfinite(known) & (known > 0.0) & driven).any())
        assumed = ~(np.isfinite(known) & (known > 0.0)) & driven
        usual = assumed_limits(job, robot, name)
        values[name] = np.where(assumed, usual, np.where(assumed, 1.0, known) * share)
        remarks += _assume(robot, name, usual, assumed)
    if reserved:
        kept = {name: quantity(share, "share") for name, share in PLANNED.items()}
        remarks.append(Remark("good", "job.reserve", kept))
    without = ~np.isfinite(own.effort) & driven
    if without.any():
        remarks.append(Remark("good", "job.effort_unknown", {"joints": _list(robot, without)}))
    jerk = np.full(robot.n, np.inf)
    if any(move.profile == "jerk_limited" for move in job.move):
        unknown = ~(np.isfinite(own.jerk) & (own.jerk > 0.0))
        usual = assumed_limits(job, robot, "jerk")
        jerk = np.where(unknown, usual, own.jerk * bounds.acceleration_scale)
        remarks += _assume(robot, "jerk", usual, unknown)
    return replace(own, **values, jerk=jerk), remarks


def _assume(robot: Robot, name: str, usual: Floats, chosen: NDArray[np.bool_]) -> list[Remark]:
    """That limits were assumed, and which."""
    power = {"velocity": "/s", "acceleration": "/s²", "jerk": "/s³"}[name]
    turns = robot.mechanism.angular
    said = {f"{usual[k]:.4g} {'rad' if turns[k] else 'm'}{power}": None for k in np.flatnonzero(chosen)}
    details = {"joints": _list(robot, chosen), "value": ", ".join(said)}
    return [Remark("good", f"job.{name}_assumed", details)] if chosen.any() else []


def _list(robot: Robot, chosen: NDArray[np.bool_]) -> str:
    names = [visible(name) for name, yes in zip(robot.joint_names, chosen, strict=True) if yes]
    return ", ".join(names) if len(names) < robot.n else "@job.all_joints"
