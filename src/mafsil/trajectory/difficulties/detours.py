"""Detours in joints around the places where a path cannot be followed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import JointVector
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.trajectory.difficulties.changed_paths import PathPart
from mafsil.trajectory.difficulties.diagnosis import PathDiagnosis, diagnose_path
from mafsil.trajectory.difficulties.difficulty import BranchChange
from mafsil.trajectory.difficulties.rates import conditioning, distance_from_path

CLEAR_OF_SINGULAR = 0.02
"""Conditioning at which a detour may begin or end."""

WAY = 201
"""Configurations of a detour that are looked at."""

SHORTEST = 1e-6
"""Shortest part of a path that is followed between detours, in s."""


@dataclass(frozen=True, eq=False, slots=True)
class Detour:
    """A straight motion in joints that leaves the path and comes back to it.

    Attributes:
        begin, end: where it leaves the path, and where it comes back.
        q_begin, q_end: (n,) there; both, and so all between them, are within the joint limits [rad | m].
        distance: largest distance of the tip from the whole path on the way, at the configurations looked at [m].
    """

    begin: float
    end: float
    q_begin: JointVector
    q_end: JointVector
    distance: float

    def explain(self, language: str | None = None) -> str:
        """Where to leave the path, and how far the tip goes from it."""
        return say(
            "trajectory.mend_detour",
            language=language,
            begin=self.begin,
            end=self.end,
            distance=quantity(self.distance, "m"),
        )


def detours(diagnosis: PathDiagnosis) -> tuple[tuple[Detour, ...], tuple[PathDiagnosis, ...], JointVector] | None:
    """Detours around all difficulties of a path, the diagnoses of the parts between them, and where the arm begins.

    1. Each difficulty asks for a part of the path to be left: a change of branch for the step over which the chain
       jumps, others for their interval. Its ends move away from singular configurations; parts that meet become one.
    2. Every part between is diagnosed from the configuration in which a detour arrives; all must be followable.

    Args:
        diagnosis: of a path with difficulties.

    Returns:
        None if the path begins or ends where it cannot be followed, or a part between detours cannot be.
    """
    # 1
    left = _intervals(diagnosis)
    if left is None or not left:
        return None
    s, q, robot = diagnosis.s, diagnosis.q, diagnosis.robot
    ways: list[Detour] = []
    for a, b in left:
        way = q[a] + np.linspace(0.0, 1.0, WAY)[:, None] * (q[b] - q[a])
        away = float(distance_from_path(robot, diagnosis.path, way).max())
        ways.append(Detour(float(s[a]), float(s[b]), q[a], q[b], away))
    # 2
    starts = [(0.0, q[0]), *((each.end, each.q_end) for each in ways)]
    ends = [*(each.begin for each in ways), 1.0]
    found: list[PathDiagnosis] = []
    for (begin, q_start), end in zip(starts, ends, strict=True):
        if end - begin <= SHORTEST:
            continue
        part = PathPart(diagnosis.path, begin, end)
        duration = None if diagnosis.duration is None else diagnosis.duration * (end - begin)
        found.append(diagnose_path(robot, part, task=diagnosis.task, q_start=q_start, duration=duration))
        if not found[-1]:
            return None
    return tuple(ways), tuple(found), q[0]


def _intervals(diagnosis: PathDiagnosis) -> list[tuple[int, int]] | None:
    """First and last sample of every part to be left, in order; None if the path begins or ends in one."""
    s, q = diagnosis.s, diagnosis.q
    inside = np.isfinite(q[:, 0])
    clear = inside.copy()
    near = conditioning(diagnosis.robot, q[inside], diagnosis.task)
    clear[inside] = ~(near < CLEAR_OF_SINGULAR)
    found: list[tuple[int, int]] = []
    for each in diagnosis.difficulties:
        if isinstance(each, BranchChange):
            first = int(np.flatnonzero(np.abs(q - each.q_before).max(axis=1) == 0.0)[0])
            last = first + 1
        else:
            first = int(np.searchsorted(s, each.where.begin, side="left")) - 1
            last = int(np.searchsorted(s, each.where.end, side="right"))
        while first >= 0 and not clear[first]:
            first -= 1
        while last < len(s) and not clear[last]:
            last += 1
        if first < 0 or last >= len(s):
            return None
        found.append((first, last))
    joined: list[tuple[int, int]] = []
    for first, last in sorted(found):
        if joined and first <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(last, joined[-1][1]))
        else:
            joined.append((first, last))
    return joined
