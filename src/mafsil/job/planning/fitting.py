"""Whether the numbers of a job fit its robot: counts, ranges, units; every complaint names the key and the line.

A job may be without forces: the arm follows its plan exactly, where masses are missing or nobody asks for dynamics.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import NamedTuple, cast

import msgspec
import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.errors import JobError
from mafsil.ik.result import reach_bound
from mafsil.job.language.description import Grasp, Job, Move, Pose
from mafsil.job.language.driving_tables import Controller, Simulation
from mafsil.job.language.text import Keys, Places, dotted_path
from mafsil.job.language.units import angle_unit, length_unit
from mafsil.job.planning.closed_moves import limits_of, listed_joints, require_closed_job
from mafsil.job.planning.equipment import Equipment, links_without_mass
from mafsil.job.remark import Remark
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.robot import Robot
from mafsil.simulation.stored_arrays import KINEMATIC

TABLES = ("disturbance", "surface", "hole", "door", "guide", "variation")
"""Tables of a job that mean nothing without forces."""
MOVE_KEYS = ("process_wrench", "until_force")
"""Keys of moves that do not either."""
KEYS = ("method", "mass_error", "payload", "noise", "real_time")
"""Keys of `[simulation]` that do not either."""
ASSUMED = {"velocity": 2.0, "acceleration": 5.0, "jerk": 50.0}
"""Limits of joints whose description has none, where the job names none [rad | m, and time derivatives]."""
TURN = 2 * pi + 1e-3
"""An angle in radians beyond it was probably meant in degrees."""
FAR = 20.0
"""Positions beyond this many times the arm's reach were probably meant in millimetres."""


def coordinates(job: Job, robot: Robot, values: tuple[float, ...]) -> JointVector:
    """(n,) numbers of the job as joint coordinates [rad | m]; (a,) driven ones of a mechanism with loops."""
    q = np.array(values, dtype=np.float64)
    turns = revolute(robot)[listed_joints(robot, len(values))]
    return q * np.where(turns, angle_unit(job), length_unit(job))


def revolute(robot: Robot) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """(n,) which coordinates are angles."""
    return robot.mechanism.angular


def assumed_limits(job: Job, robot: Robot, name: str) -> Floats:
    """(n,) limits of joints whose description has none [rad | m, and time derivatives].

    Args:
        job: that may name one number for all, or one per joint, in the units of its file.
        robot: whose joints they are.
        name: velocity, acceleration or jerk.
    """
    turns = revolute(robot)
    asked: float | tuple[float, ...] | None = getattr(job.limits, name)
    if asked is None or (isinstance(asked, tuple) and len(asked) != robot.n):
        # A list is of the job's robot: other robots have the usual limits.
        return np.full(robot.n, ASSUMED[name])
    return np.asarray(asked) * np.where(turns, angle_unit(job), length_unit(job))


def require_fit(job: Job, robot: Robot, places: Places) -> None:
    """Refuses numbers that do not fit the robot.

    Raises:
        JobError: a list has not one number per joint, a joint would be outside its limits, or something is let go of
            that is not carried, or something taken or another tool while something is carried.
    """
    if robot.mechanism.loops:
        require_closed_job(job, robot, places)
    for path, values in _configurations(job):
        _require_count(robot, places, path, values)
        require_within(job, robot, places, path, values)
    for path, values in _lists(job):
        count = len(cast("tuple[float, ...]", values)) if isinstance(values, tuple) else robot.n
        expected = robot.n if path[0] != "controller" else _drive(robot)
        if isinstance(values, tuple) and count != expected:
            raise places.error("job.list_count", path, expected=expected, got=count)
    _require_hands(job, places)


def _require_hands(job: Job, places: Places) -> None:
    """Refuses what cannot be whichever way the job goes; what depends on the way is looked at on the way."""
    coming: dict[int, list[Grasp | None]] = {0: [None]}
    for k, move in enumerate(job.move):
        carried = coming.pop(k, [])
        faults = [fault for fault in (hand_fault(move, each) for each in carried) if fault is not None]
        if faults and len(faults) == len(carried):
            raise faults[0].complaint(places, k)
        after = carried if move.pick is None and not move.place else [move.pick]
        for then in (k + 1 + move.skip, *(() if move.fork is None else (k + 1 + move.fork.skip,))):
            known = coming.setdefault(then, [])
            known += [each for each in after if not any(each is one for one in known)]


class HandFault(NamedTuple):
    """Why a part cannot be taken or let go of, or a tool not changed.

    Attributes:
        key: of the sentence.
        action: of the move.
        part: what is carried.
    """

    key: str
    action: str
    part: str

    def complaint(self, places: Places, index: int) -> JobError:
        """About the move of an index."""
        return places.error(self.key, ("move", index, self.action), part=self.part)


def hand_fault(move: Move, carried: Grasp | None) -> HandFault | None:
    """What speaks against taking a part, letting go of it or changing tools; None where nothing does.

    Args:
        move: of a job.
        carried: what the tool holds then.
    """
    part = "" if carried is None else visible(carried.name)
    if move.pick is not None and carried is not None:
        return HandFault("job.already_carried", "pick", part)
    if move.tool is not None and carried is not None:
        return HandFault("job.tool_carrying", "tool", part)
    if move.place and carried is None:
        return HandFault("job.nothing_carried", "place", part)
    return None


def unit_remarks(job: Job, robot: Robot, places: Places) -> tuple[Remark, ...]:
    """Numbers that look as if they were meant in another unit."""
    found: list[Remark] = []
    if job.angles == "radians":
        for path, values in _angles(job, robot):
            value = max(map(abs, values), default=0.0)
            if value > TURN:
                found.append(_suspect("job.degrees_suspected", path, f"{value:g}", places))
    return tuple(found)


def is_far(robot: Robot, position: JointVector) -> bool:
    """Whether a position in {s} is so far away that another unit was probably meant."""
    centre, reach = reach_bound(robot.mechanism, None)
    return bool(np.linalg.norm(position - centre) > FAR * reach > 0.0)


def _suspect(key: str, path: Keys, value: str, places: Places) -> Remark:
    details = {"name": dotted_path(places.as_typed(path)), "value": value}
    line = places.line(path)
    return (
        Remark("warning", key, details) if line is None else Remark("warning", f"{key}_line", details | {"line": line})
    )


def _configurations(job: Job) -> Iterator[tuple[Keys, tuple[float, ...]]]:
    """Every list of joint coordinates."""
    if job.start.joints is not None:
        yield ("start", "joints"), job.start.joints
    for k, move in enumerate(job.move):
        for i, via in enumerate(move.via):
            if isinstance(via, tuple):
                yield ("move", k, "via", i), via
        if move.joints is not None:
            yield ("move", k, "joints"), move.joints


def _lists(job: Job) -> Iterator[tuple[Keys, object]]:
    """What may be one number, or one per joint."""
    for name in ("velocity", "acceleration", "jerk"):
        yield ("limits", name), getattr(job.limits, name)
    yield ("controller", "kp"), job.controller.kp
    yield ("controller", "kd"), job.controller.kd
    yield ("controller", "integral"), job.controller.integral
    yield ("controller", "margin"), job.controller.margin
    yield ("tolerance", "joints"), job.tolerance.joints
    for k, move in enumerate(job.move):
        if move.tolerance is not None:
            yield ("move", k, "tolerance", "joints"), move.tolerance.joints


def _angles(job: Job, robot: Robot) -> Iterator[tuple[Keys, tuple[float, ...]]]:
    """Every list of angles."""
    for path, values in _configurations(job):
        turns = revolute(robot)[listed_joints(robot, len(values))]
        yield path, tuple(x for x, angle in zip(values, turns, strict=True) if angle)
    poses: list[tuple[Keys, Pose | None]] = [(("tool", "offset"), job.tool.offset), (("start", "pose"), job.start.pose)]
    poses += [(("tools", name, "offset"), tool.offset) for name, tool in job.tools.items()]
    for k, move in enumerate(job.move):
        poses.append((("move", k, "pose"), move.pose))
        poses += [(("move", k, "via", i), via) for i, via in enumerate(move.via) if isinstance(via, Pose)]
    for path, pose in poses:
        if pose is not None and pose.rpy is not None:
            yield (*path, "rpy"), pose.rpy


def _require_count(robot: Robot, places: Places, path: Keys, values: tuple[float, ...]) -> None:
    if len(values) not in (robot.n, _drive(robot)):
        named: list[str] = [robot.joint_names[k] for k in listed_joints(robot, -1).tolist()]
        details = {"robot": visible(robot.name), "joints": ", ".join(map(visible, named))}
        raise places.error("job.joint_count", path, **details, expected=len(named), got=len(values))


def _drive(robot: Robot) -> int:
    """How many joints a list names at least."""
    return len(listed_joints(robot, -1))


def require_within(job: Job, robot: Robot, places: Places, path: Keys, values: tuple[float, ...]) -> None:
    """Refuse joint coordinates of a file that lie outside the limits, in the units of the file.

    Args:
        job: with its units.
        robot: whose joints they are.
        places: of the keys.
        path: of the list.
        values: as typed.

    Raises:
        JobError: naming the joint, its value and its limits.
    """
    columns = listed_joints(robot, len(values))
    q, limits, turns = coordinates(job, robot, values), limits_of(robot.limits, columns), revolute(robot)[columns]
    outside = np.flatnonzero(~limits.within(q))
    if not len(outside):
        return
    k = int(outside[0])

    def said(x: float) -> str:
        if not turns[k]:
            return quantity(x, "m")
        return quantity(x, "rad") if job.angles == "degrees" else f"{x:.4g} rad"

    details = {"joint": visible(robot.joint_names[int(columns[k])]), "value": said(float(q[k]))}
    details |= {"lower": said(float(limits.lower[k])), "upper": said(float(limits.upper[k]))}
    key = "job.outside_limits"
    if job.angles == "radians" and np.abs(q[turns]).max(initial=0.0) > TURN:
        key = "job.outside_limits_degrees"
    elif not turns[k] and abs(q[k]) > FAR * max(abs(limits.lower[k]), abs(limits.upper[k])):
        key = "job.outside_limits_millimetres"
    raise places.error(key, path, **details)


def kinematic(job: Job, first: Equipment, places: Places) -> Remark | None:
    """Whether the arm follows its plan exactly, as a remark that says why and what is not judged; None if it is driven.

    Args:
        job: what is asked.
        first: the robot with the tool with which it starts.
        places: of the keys, for errors.

    Raises:
        JobError: forces are asked for, and masses are missing or the job wants none.
    """
    details = {"robot": visible(first.robot.name), "links": ", ".join(map(visible, first.light))}
    asked = job.simulation.plant == KINEMATIC
    if not asked and not first.light:
        return None
    if not asked and job.simulation.plant is not None:
        still = links_without_mass(first.robot.mechanism)
        if still:
            details["links"] = ", ".join(map(visible, still))
            raise places.error("job.no_mass", ("simulation", "plant"), **details)
        return None
    why = "asked" if asked else "masses"
    for path in _forces(job):
        raise places.error(f"job.forces_{why}", path, **details)
    ignored = job.controller != Controller(frequency=job.controller.frequency)
    return Remark("warning" if ignored or not asked else "good", f"job.kinematic_{why}", details)


def _forces(job: Job) -> Iterator[Keys]:
    """The keys of a job that need forces, in their order."""
    for table in TABLES:
        if getattr(job, table):
            yield (table, 0) if isinstance(getattr(job, table), tuple) else (table,)
    for k, move in enumerate(job.move):
        yield from (("move", k, key) for key in MOVE_KEYS if getattr(move, key) is not None)
    usual = msgspec.structs.asdict(Simulation())
    for key in KEYS:
        if getattr(job.simulation, key) != usual[key]:
            yield ("simulation", key)
