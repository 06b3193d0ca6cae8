"""The robot of a job with each of its tools, and what hangs on its flange: a tool, and perhaps a part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.errors import JobError, MafsilError
from mafsil.geometry import pose
from mafsil.ik.result import reach_bound
from mafsil.job.language.description import Grasp, Job, Tool, Track
from mafsil.job.language.text import Places
from mafsil.job.language.units import MILLIMETRE, angle_unit, length_unit, pose_matrix, with_tool
from mafsil.messages.visible import visible
from mafsil.model import JointKind, Mechanism
from mafsil.model.limits import Limits
from mafsil.model.loading import load_mechanism
from mafsil.model.mounting import on_track, on_turntable
from mafsil.robot import Robot, as_open_tree

UNNAMED_TOOL = "tool"
"""What the tool of `[tool]` is called."""
FAR_TOOL = 3.0
"""Lengths of a tool beyond this many times the arm's reach were probably meant in millimetres."""
FIXED = 1e-9
"""Tips that move against each other by less sit on one flange [m, and entries of the rotation]."""


@dataclass(frozen=True, eq=False, slots=True)
class Equipment:
    """The robot with one of its tools.

    Attributes:
        name: of the tool; None for that of `[tool]`.
        tool: as the job describes it.
        robot: with it.
        T_of_first: (4, 4) its tip frame in that of the tool with which the robot starts.
        T_of_flange: (4, 4) its tip frame in the frame that it is mounted on.
        light: links of the robot itself that its joints move without moving any mass.
    """

    name: str | None
    tool: Tool
    robot: Robot
    T_of_first: PoseMatrix
    T_of_flange: PoseMatrix
    light: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Load:
    """What hangs on the flange.

    Attributes:
        equipment: the tool, with the robot that it makes.
        carried: what the tool holds.
    """

    equipment: Equipment
    carried: Grasp | None = None

    @property
    def robot(self) -> Robot:
        """With the tool, empty-handed."""
        return self.equipment.robot


def equip_robot(job: Job, folder: Path) -> Robot:
    """The robot of a job, with its locked joints and the tool with which it starts.

    Args:
        job: the job.
        folder: to which the path of a robot file is relative.

    Raises:
        MafsilError: no such robot, or no such joint to lock.
    """
    return _robot(job, _bare(job, folder), job.start.tool)


def equipment_of(job: Job, folder: Path, places: Places | None = None) -> tuple[Equipment, ...]:
    """The robot with each tool of the job, that of the start first. Errors as for `equip_robot`, with their line.

    Args:
        job: the job.
        folder: to which the path of a robot file is relative.
        places: of the keys, for errors.

    Raises:
        JobError: tools on links that move against each other.
    """
    bare = _bare(job, folder, places)
    if places is not None:
        _require_near(job, bare, places)
    names = dict.fromkeys([job.start.tool, *(move.tool for move in job.move if move.tool is not None)])
    robots = {name: _robot(job, bare, name) for name in names}
    first, light = robots[job.start.tool], links_without_mass(bare)
    return tuple(
        Equipment(name, _tool(job, name), robot, _between(first, robot, name), _on_flange(job, name), light)
        for name, robot in robots.items()
    )


def box_of_tool(equipment: Equipment) -> PoseMatrix:
    """(4, 4) centre of the tool's box, in the tip frame."""
    return pose.compose(pose.inverse(equipment.T_of_flange), pose.from_translation(equipment.tool.centre))


def _bare(job: Job, folder: Path, places: Places | None = None) -> Mechanism:
    """The mechanism without tools; the tip link is that of `[tool]`."""
    source = folder / job.robot if Path(job.robot).suffix else job.robot
    key = "robot"
    try:
        mechanism = load_mechanism(source, tip=job.tool.link)
        for k, track in reversed(list(enumerate(job.track))):
            mechanism = _on_axis(mechanism, job, track, f"track_{k + 1}" if k else "track")
        key = "lock"
        return mechanism.with_locked_joints(_lock(job, mechanism)) if job.lock else mechanism
    except MafsilError as fault:
        if places is None:
            raise
        raise places.of_file(fault, (key,)) from None


def _on_axis(mechanism: Mechanism, job: Job, track: Track, name: str) -> Mechanism:
    """A mechanism on a linear axis or a turntable."""
    unit = length_unit(job) if track.axis is None else angle_unit(job)
    bounds = {"velocity": track.speed, "acceleration": track.acceleration}
    known = {key: unit * value for key, value in bounds.items() if value is not None}
    limits = Limits(lower=unit * track.range[0], upper=unit * track.range[1], **known)
    if track.axis is not None:
        return on_turntable(mechanism, track.axis, track.point, limits, name)
    assert track.direction is not None
    return on_track(mechanism, track.direction, limits, name)


def _tool(job: Job, name: str | None) -> Tool:
    return job.tool if name is None else job.tools[name]


def _on_flange(job: Job, name: str | None) -> PoseMatrix:
    """(4, 4) the tip frame of a tool in the frame that it is mounted on."""
    offset = _tool(job, name).offset
    return np.eye(4) if offset is None else pose_matrix(offset, degrees=job.angles == "degrees")


def _robot(job: Job, bare: Mechanism, name: str | None) -> Robot:
    mechanism = with_tool(bare, _tool(job, name), degrees=job.angles == "degrees")
    return as_open_tree(mechanism)


def _between(first: Robot, robot: Robot, name: str | None) -> PoseMatrix:
    """(4, 4) the tip frame of a robot in that of the first one, the same in all configurations."""
    if robot is first:
        return np.eye(4)
    q = np.stack([np.zeros(first.n), np.linspace(0.3, 0.7, first.n)])
    here, there = pose.compose(pose.inverse(first.forward_kinematics(q)), robot.forward_kinematics(q))
    if np.abs(here - there).max() > FIXED * max(1.0, np.abs(here).max()):
        raise JobError("job.tool_flange", tool=visible(str(name)))
    return here


def _require_near(job: Job, bare: Mechanism, places: Places) -> None:
    """Refuse a tool so far away or so large that its numbers are probably millimetres."""
    _, reach = reach_bound(bare, None)
    tools = [(("tool",), job.tool), *((("tools", name), tool) for name, tool in job.tools.items())]
    for path, tool in tools:
        lengths = {"com": tool.com, "centre": tool.centre, "size": tool.size or ()}
        lengths |= {} if tool.offset is None else {"offset": tool.offset.position}
        for key, values in lengths.items():
            size = max(map(abs, values), default=0.0)
            if size > FAR_TOOL * reach > 0.0:
                known = f"{MILLIMETRE * size:g}"
                raise places.error("job.tool_far", (*path, key), size=f"{size:g}", reach=f"{reach:.3g}", known=known)


def _lock(job: Job, mechanism: Mechanism) -> dict[str, float]:
    """Coordinates of the joints that the job locks [rad | m]."""
    prismatic = {joint.name for joint in mechanism.joints if joint.kind is JointKind.PRISMATIC}
    units = {True: length_unit(job), False: angle_unit(job)}
    return {name: units[name in prismatic] * value for name, value in job.lock.items()}


def links_without_mass(mechanism: Mechanism) -> tuple[str, ...]:
    """Links that a joint moves without moving any mass or inertia, so that its acceleration is not defined.

    Args:
        mechanism: with or without a tool.
    """
    carried = [link.inertial is not None and link.inertial.mass > 0.0 for link in mechanism.links]
    for k in reversed(range(len(mechanism.joints))):
        parent = mechanism.parents[k]
        if mechanism.joints[k].kind is JointKind.FIXED or parent:
            carried[parent] = carried[parent] or carried[k + 1]
    moved = [(k, joint) for k, joint in enumerate(mechanism.joints) if joint.moves]
    return tuple(
        joint.child
        for k, joint in moved
        if not any(carried) or (not carried[k + 1] and not (joint.actuator and joint.actuator.reflected_inertia > 0.0))
    )
