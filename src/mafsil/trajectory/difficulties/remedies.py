"""Changes that make a path followable: another branch, the tool turned, the base moved, a detour in joints.

Detours in joints around the places where a path cannot be followed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, get_args

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, Vector3, require_kind
from mafsil.errors import InputError
from mafsil.mechanics.arm_size import arm_length
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.trajectory.difficulties.changed_paths import MovedBasePath, PathPart, TurnedToolPath
from mafsil.trajectory.difficulties.diagnosis import PathDiagnosis, diagnose_path
from mafsil.trajectory.difficulties.difficulty import BranchChange, conditioning, distance_from_path, redundant
from mafsil.trajectory.difficulties.ladder import best_chain, solution_ladder
from mafsil.trajectory.paths import TipPath

CLEAR_OF_SINGULAR = 0.02
"""Conditioning at which a detour may begin or end."""
WAY = 201
"""Configurations of a detour that are looked at."""
SHORTEST = 1e-6
"""Shortest part of a path that is followed between detours, in s."""
RemedyName = Literal["branch", "tool", "base", "detour"]
QUICK = 41
"""Samples of the first look at a changed path; one that passes is looked at again in full."""
TURN_STEP = np.radians(5.0)
TURN_FINEST = np.radians(0.25)
SHIFTS = 0.02 * 2.0 ** np.arange(6)
"""Distances by which the base is moved, in lengths of the arm."""
SHIFT_HALVINGS = 6
"""How often the distance of a shift that mends is halved towards one that does not: to 1/64 of it."""
DIRECTIONS = 3
"""Directions of the base, of those that mend at the same distance, whose distance is reduced."""


class MendStatus(Status):
    """Whether a remedy was found."""

    NOT_NEEDED = ("trajectory.mend_not_needed", True)
    MENDED = ("trajectory.mended", True)
    NOT_MENDED = ("trajectory.not_mended", False)


@dataclass(frozen=True, eq=False, slots=True)
class PathRemedy:
    """One change after which the path can be followed.

    Attributes:
        kind: `branch`, `tool`, `base` or `detour`.
        path: of the tip after the change.
        q_start: (n,) where the arm begins then [rad | m].
        turn: of the tool about its z axis [rad].
        shift: (3,) of the base in {s} [m].
        detours: motions in joints between the parts of the path.
        diagnoses: of the changed path, or of the parts between detours; each true.
    """

    kind: RemedyName
    path: TipPath
    q_start: JointVector
    diagnoses: tuple[PathDiagnosis, ...]
    turn: float = 0.0
    shift: Vector3 | None = None
    detours: tuple[Detour, ...] = ()

    def explain(self, language: str | None = None) -> str:
        """What to change, in a sentence."""
        if self.kind == "detour":
            return "; ".join(each.explain(language) for each in self.detours)
        shift = ", ".join(f"{x:.4g}" for x in (np.zeros(3) if self.shift is None else self.shift))
        start = ", ".join(f"{x:.4g}" for x in self.q_start)
        return say(
            f"trajectory.mend_{self.kind}",
            language=language,
            angle=f"{np.degrees(self.turn):.4g}",
            shift=f"({shift})",
            distance=quantity(float(np.linalg.norm(0.0 if self.shift is None else self.shift)), "m"),
            q=f"({start})",
        )


@dataclass(frozen=True, eq=False, repr=False)
class PathRemedies(Answer, entries="remedies"):
    """True if the path can be followed as it is or after one of the changes; iterable over them.

    Attributes:
        diagnosis: of the path as it is.
        remedies: each checked by a diagnosis of the changed path.
    """

    diagnosis: PathDiagnosis
    remedies: tuple[PathRemedy, ...]

    @property
    def status(self) -> MendStatus:
        """Not needed, found, or not found among what was tried."""
        if self.diagnosis:
            return MendStatus.NOT_NEEDED
        return MendStatus.MENDED if self.remedies else MendStatus.NOT_MENDED

    def explain(self, language: str | None = None) -> str:
        """The difficulties, then every change that mends them."""
        found = [each.explain(language) for each in self.diagnosis.difficulties]
        return "\n".join([*found, self.status.sentence(language), *(each.explain(language) for each in self)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        rows = [
            {
                "kind": each.kind,
                "turn": each.turn,
                "shift": None if each.shift is None else each.shift.tolist(),
                "q_start": each.q_start,
                "detours": [(one.begin, one.end) for one in each.detours],
                "text": each.explain("en"),
            }
            for each in self
        ]
        return {"status": self.status.name.lower(), "remedies": rows}


def suggest_path_fixes(
    diagnosis: PathDiagnosis, *, kinds: Sequence[RemedyName] = ("branch", "tool", "base", "detour")
) -> PathRemedies:
    """Changes after which a path can be followed, each checked by diagnosing the changed path and leading joints along.

    branch: another configuration at the beginning. tool: the smallest turn about the tool's z axis that mends, tried in
    steps of 5 degrees both ways and then halved to a quarter of a degree. base: the smallest shift found, in 26
    directions at distances that double from 2 % of the arm's length, then halved. detour: parts of the path are left
    and passed in joints, straight from one configuration to the other.

    What was not found may exist: other directions, two changes at once. Collisions are not looked at.

    Args:
        diagnosis: of a path, by `diagnose_path`.
        kinds: which changes to try.

    Raises:
        InputError: no diagnosis, an unknown kind.
    """
    require_kind("diagnosis", diagnosis, "PathDiagnosis", "difficulties", "reach", "path")
    for kind in kinds:
        if kind not in get_args(RemedyName):
            raise InputError("input.choice", name="kinds", value=kind, known=", ".join(get_args(RemedyName)))
    tried = {"branch": _branch, "tool": _tool, "base": _base, "detour": _detour}
    found = () if diagnosis else tuple(remedy for kind in kinds if (remedy := tried[kind](diagnosis)) is not None)
    return PathRemedies(diagnosis, found)


def _branch(old: PathDiagnosis) -> PathRemedy | None:
    """Any configuration at the beginning, where one was asked for."""
    if old.q_start is None:
        return None
    new = _followable(old, old.path)
    return None if new is None else PathRemedy("branch", old.path, new.q[0], (new,))


def _tool(old: PathDiagnosis) -> PathRemedy | None:
    """The smallest turn of the tool about its axis."""
    if old.task != "pose":
        return None
    for k in range(1, round(np.pi / TURN_STEP) + 1):
        for sign in (1.0, -1.0):
            if (found := _turn(old, sign * k * TURN_STEP)) is None:
                continue
            fails, mends = sign * (k - 1) * TURN_STEP, sign * k * TURN_STEP
            while abs(mends - fails) > TURN_FINEST:
                middle = (fails + mends) / 2
                less = _turn(old, middle)
                fails, mends = (middle, mends) if less is None else (fails, middle)
                found = found if less is None else less
            return found
    return None


def _turn(old: PathDiagnosis, turn: float) -> PathRemedy | None:
    path = TurnedToolPath(old.path, turn)
    new = _followable(old, path)
    return None if new is None else PathRemedy("tool", path, new.q[0], (new,), turn=turn)


def _base(old: PathDiagnosis) -> PathRemedy | None:
    """The smallest shift of the base that is found."""
    length = arm_length(old.robot.mechanism)
    directions = np.array([v for v in product((-1.0, 0.0, 1.0), repeat=3) if any(v)])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for distance in length * SHIFTS:
        found: list[PathRemedy] = []
        for direction in directions:
            if len(found) < DIRECTIONS and _shift(old, distance * direction) is not None:
                found.append(_least_shift(old, direction, float(distance)))
        if found:
            return min(found, key=_distance)
    return None


def _least_shift(old: PathDiagnosis, direction: Vector3, mends: float) -> PathRemedy:
    """A shift that mends, made smaller as long as it does."""
    found, fails = _shift(old, mends * direction), 0.0
    assert found is not None
    for _ in range(SHIFT_HALVINGS):
        middle = (fails + mends) / 2
        less = _shift(old, middle * direction)
        fails, mends = (middle, mends) if less is None else (fails, middle)
        found = found if less is None else less
    return found


def _distance(remedy: PathRemedy) -> float:
    return float(np.linalg.norm(0.0 if remedy.shift is None else remedy.shift))


def _shift(old: PathDiagnosis, shift: Vector3) -> PathRemedy | None:
    path = MovedBasePath(old.path, shift)
    new = _followable(old, path)
    return None if new is None else PathRemedy("base", path, new.q[0], (new,), shift=shift)


def _detour(old: PathDiagnosis) -> PathRemedy | None:
    """Parts of the path passed in joints."""
    found = detours(old)
    if found is None:
        return None
    ways, diagnoses, q_start = found
    return PathRemedy("detour", old.path, q_start, diagnoses, detours=ways)


def _followable(old: PathDiagnosis, path: TipPath) -> PathDiagnosis | None:
    """The diagnosis of a changed path if it can be followed from some configuration; first a look at few samples."""
    if not redundant(old.robot, old.task) and not _promising(old, path):
        return None
    new = diagnose_path(old.robot, path, task=old.task, duration=old.duration)
    return new if new else None


def _promising(old: PathDiagnosis, path: TipPath) -> bool:
    """Whether few samples show no difficulty."""
    ladder = solution_ladder(old.robot, path, old.task, np.union1d(np.linspace(0.0, 1.0, QUICK), path.breaks))
    if not ladder.within.any(axis=1).all():
        return False
    chain = best_chain(ladder, 0, len(ladder.s))
    if chain.jumps or old.duration is None:
        return not chain.jumps
    rates: Floats = np.abs(ladder.after[np.arange(len(ladder.s)), chain.rows]) / old.duration
    return bool((rates <= old.robot.limits.velocity).all())


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
