"""Difficulty 2: stretches of a path on which joints would have to be too fast, or the arm is nearly singular."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.tolerances import NEARLY_SINGULAR
from mafsil.robot import Robot
from mafsil.trajectory.difficulties.branch_changes import place_of
from mafsil.trajectory.difficulties.difficulty import FastStretch
from mafsil.trajectory.difficulties.rates import at_limited_rates, conditioning, distance_from_path, singular_causes
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.path_task import PathTask

CAUSED_BY_SINGULARITY = 0.02
"""Conditioning below which high rates are put down to the singularity nearby."""

RATE = 1e-9
"""Share of a limit by which a rate at it may exceed it."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A motion along a part of a path without jumps, at samples.

    Attributes:
        robot, path, task: what was asked.
        s: (c,) samples.
        q, rates: (c, n) coordinates, and their derivatives by s.
    """

    robot: Robot
    path: TipPath
    task: PathTask
    s: Floats
    q: JointVector
    rates: Floats


def stretches(piece: Piece, duration: float | None) -> Iterator[FastStretch]:
    """Where rates exceed their limits at constant ds/dt; without a duration where the arm is nearly singular.

    Args:
        piece: a motion without jumps.
        duration: of the whole path [s].
    """
    yield from _singular_stretches(piece) if duration is None else _fast_stretches(piece, duration)


def _singular_stretches(piece: Piece) -> Iterator[FastStretch]:
    """Where the arm is nearly singular; not where that is the edge of its reach, which is a difficulty of its own."""
    robot = piece.robot
    ratios = conditioning(robot, piece.q, piece.task)
    excess = NEARLY_SINGULAR / np.maximum(ratios, 1e-300)
    for a, b in _runs(excess > 1.0):
        at_edge = (a == 0 and piece.s[0] > 0.0) or (b == len(piece.s) - 1 and piece.s[-1] < 1.0)
        if at_edge:
            continue
        k = int(a + excess[a : b + 1].argmax())
        j = int(np.abs(piece.rates[k]).argmax())
        where = place_of(piece.path, _crossing(piece.s, excess, a, -1), _crossing(piece.s, excess, b, 1))
        joint, rate = robot.joint_names[j], float(abs(piece.rates[k, j]))
        causes = singular_causes(robot, piece.q[k], piece.task)
        yield FastStretch(where, joint, float(piece.s[k]), rate, np.inf, float(ratios[k]), causes, np.nan)


def _fast_stretches(piece: Piece, duration: float) -> Iterator[FastStretch]:
    """Where joints are faster than their limits, and by how much the tip leaves the path if they are not."""
    robot = piece.robot
    speeds = np.abs(piece.rates) / duration
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.nan_to_num(speeds / robot.limits.velocity, posinf=np.inf)
    excess = shares.max(axis=1)
    runs = list(_runs(excess > 1.0 + RATE))
    if not runs:
        return
    distance = np.nan
    if len(piece.s) > 1:
        slowed = at_limited_rates(robot, piece.s, piece.q, piece.rates, duration)
        distance = float(distance_from_path(robot, piece.path, slowed).max())
    for a, b in runs:
        k = int(a + excess[a : b + 1].argmax())
        j = int(shares[k].argmax())
        near = float(conditioning(robot, piece.q[k], piece.task))
        causes = singular_causes(robot, piece.q[k], piece.task) if near < CAUSED_BY_SINGULARITY else ()
        where = place_of(piece.path, _crossing(piece.s, excess, a, -1), _crossing(piece.s, excess, b, 1))
        limit = float(robot.limits.velocity[j])
        joint, rate = robot.joint_names[j], float(speeds[k, j])
        yield FastStretch(where, joint, float(piece.s[k]), rate, limit, near, causes, distance)


def _runs(over: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """First and last index of every run of True."""
    padded = np.concatenate([[False], over, [False]])
    ends = np.flatnonzero(padded[1:] != padded[:-1])
    yield from zip(ends[::2].tolist(), (ends[1::2] - 1).tolist(), strict=True)


def _crossing(s: Floats, excess: Floats, k: int, step: int) -> float:
    """Where the excess falls to one beside a sample, on the straight line between samples."""
    other = k + step
    if not 0 <= other < len(s):
        return float(s[k])
    share = (excess[k] - 1.0) / (excess[k] - excess[other])
    return float(s[k] + share * (s[other] - s[k]))
