"""`mafsil plan`: a way of an arm round obstacles, every motion of it proved free, timed for a controller.

What `mafsil plan` is asked for beside the start: where to go, what room that leaves, and what is kept on the way.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from mafsil.arrays import JointVector, PoseMatrix, single
from mafsil.cli import state
from mafsil.cli.answer import Answer, Laid, Toned
from mafsil.cli.motion_input import PLACES, typed_pose
from mafsil.cli.state import count, degrees_remarks, joint_values, number, shown, unit
from mafsil.cli.table import brief, table
from mafsil.collision import Checker, Scene
from mafsil.errors import InputError
from mafsil.geometry import Pose
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.model import Mechanism
from mafsil.model.appearance import with_shapes
from mafsil.planning import FixedOrientation, GoalRegion, InPlane, OnLine, Upright
from mafsil.planning import plan as plan_path
from mafsil.robot import Robot, load

if TYPE_CHECKING:
    import mafsil.job.planning.surroundings as surroundings
    import mafsil.trajectory as trajectory
    from mafsil.planning import ArmPlan
else:
    surroundings = lazily("mafsil.job.planning.surroundings")
    trajectory = lazily("mafsil.trajectory")

Goal: TypeAlias = JointVector | PoseMatrix | Pose | GoalRegion
Kept: TypeAlias = Upright | FixedOrientation | OnLine | InPlane
VELOCITY, ACCELERATION = 2.0, 5.0
"""Limits of joints that have none, as in jobs [rad/s | m/s, per s]."""


def plan(
    robot: str,
    start: list[str],
    goal: list[str],
    pose: list[str],
    box: list[str],
    angle: str | None,
    upright: str | None,
    orientation: bool,
    line: list[str],
    plane: list[str],
    scene: str | None,
    clearance: str | None,
    self_clearance: str | None,
    planner: str | None,
    srdf: str | None,
    known_free: list[str],
    active_joints: list[str],
    seed: str | None,
    seconds: str | None,
    out: str | None,
    tip: str | None,
    degrees: bool,
) -> Answer:
    """A path from a configuration to others, to poses of the tip or a region around one; it may keep something.

    Args:
        robot: name or file.
        start: (n) coordinates as typed.
        goal: (n) coordinates as typed, or of several one after the other; none if `pose` is given.
        pose: of the tip: x, y, z [m], roll, pitch, yaw, as typed; or of several.
        box, angle: room around one pose, along its axes [m] and about any.
        upright: largest angle of the tip's z axis from where it points at the start.
        orientation: whether the tip keeps its orientation.
        line, plane: (3) direction and normal, in {s}, that the tip stays along or in.
        scene: file of `[[obstacle]]` tables.
        clearance: that is kept [m].
        self_clearance: that bodies of the robot keep from each other [m].
        planner: which one searches.
        srdf: file of the pairs of links that need no check.
        known_free: (n) coordinates as typed at which the robot is known to be free of itself.
        active_joints: names of joints that may move though they end where they start; those of the moving limb if none.
        seed: of its samples.
        seconds: after which it gives up.
        out: file for the timed motion; its ending says the format.
        tip: another tip link.
        degrees: whether bare angles are degrees, and angles are printed so.

    Raises:
        MafsilError: no such robot or file, not one number per joint, no goal or two, room around none or several poses.
    """
    arm = load(robot, tip=tip)
    wanted = typed_goal(goal, pose, box, angle, arm.mechanism, degrees=degrees)
    q = joint_values("start", start, arm.mechanism, degrees=degrees)
    keep = typed_constraints(upright, orientation, line, plane, degrees=degrees)
    around = Scene() if scene is None else surroundings.scene_in(Path(scene))
    apart = 0.0 if clearance is None else number("--clearance", clearance)
    among_itself = None if self_clearance is None else number("--self-clearance", self_clearance)
    budget = 10.0 if seconds is None else number("--seconds", seconds)
    first = 0 if seed is None else count("--seed", seed)
    own = any(link.collisions or link.visuals for link in arm.mechanism.links)
    free = joint_values("known_free", known_free, arm.mechanism, degrees=degrees) if known_free else None
    checker = Checker(
        with_shapes(arm.mechanism), around, clearance=apart, self_clearance=among_itself, srdf=srdf,
        self_collision=own, known_free=free,
    )  # fmt: skip
    found = plan_path(
        checker, None, q, wanted, planner=planner or "rrt_connect", seed=first, seconds=budget, constraints=keep,
        active_joints=active_joints or None,
    )  # fmt: skip
    typed = [words for words in (start, *rows_of(goal, arm.n)) if words]
    hints = [hint for words in typed for hint in degrees_remarks(words, arm.mechanism, degrees=degrees)]
    if not found:
        refusal = "\n".join([found.explain(), *dict.fromkeys(hints)])
        return Answer({"robot": arm.name, **found.to_dict()}, (), refusal)
    return _answer(arm, found, None if free is None else checker, out, list(dict.fromkeys(hints)), degrees=degrees)


def _answer(
    arm: Robot, found: ArmPlan, checker: Checker | None, out: str | None, hints: list[str], *, degrees: bool
) -> Answer:
    """A path that was found: its points, what was not checked of the arm, where it is nearest, its file."""
    data: dict[str, Any] = {"robot": arm.name, **found.to_dict()}
    first, *rest = found.explain().splitlines()
    lines = [Toned(first, "good"), *rest, *_points(arm, found, degrees=degrees), *hints]
    if checker is not None:
        data["not_checked"] = [(each.first, each.second) for each in checker.resting]
        names = f" ({', '.join(map(str, checker.resting))})" if checker.resting else ""
        lines.append(say("collision.skipped_rest", count=len(checker.resting), names=names))
    near = found.clearance()
    if np.isfinite(near.distance).any():
        k = int(near.distance.argmin())
        data["clearance"] = float(near.distance[k])
        lines.append(say("cli.plan_nearest", nearest=list(near)[k].sentence()))
    if out is not None:
        timed = found.time_optimal(_limits(arm))
        assert timed.trajectory is not None
        written = trajectory.export(timed.trajectory, out, _limits(arm), joints=arm.joint_names)
        data |= {"duration": timed.duration, "file": written.to_dict()}
        lines += [*_assume(arm), written.explain()]
    return Answer(data, tuple(lines), interrupted=found.interrupted)


def _points(arm: Robot, found: ArmPlan, *, degrees: bool) -> list[Laid]:
    joints = arm.mechanism.coordinates
    head = ["", *(f"{joint.name} [{unit(joint.kind, degrees=degrees)}]" for joint in joints)]
    rows = [
        [
            str(k + 1),
            *(brief(shown(float(x), joint.kind, degrees=degrees)) for x, joint in zip(row, joints, strict=True)),
        ]
        for k, row in enumerate(found.path)
    ]
    return [Laid(line) for line in table(head, rows)]


def _assume(arm: Robot) -> list[str]:
    """Which limits the motion kept that nobody described."""
    found: list[str] = []
    for name, value in (("velocity", VELOCITY), ("acceleration", ACCELERATION)):
        known = getattr(arm.limits, name)
        joints = [one for one, x in zip(arm.joint_names, known, strict=True) if not (np.isfinite(x) and x > 0.0)]
        if joints:
            found.append(say(f"job.{name}_assumed", joints=", ".join(joints), value=value))
    return found


def _limits(arm: Robot) -> trajectory.MotionLimits:
    """Of the arm, finite where a motion needs them."""
    own = arm.limits
    velocity = np.where(np.isfinite(own.velocity) & (own.velocity > 0.0), own.velocity, VELOCITY)
    acceleration = np.where(np.isfinite(own.acceleration) & (own.acceleration > 0.0), own.acceleration, ACCELERATION)
    return trajectory.MotionLimits.of(arm.n, velocity=velocity, acceleration=acceleration)


def rows_of(words: list[str], length: int) -> list[list[str]]:
    """Words in rows of one length; one row of all of them where that does not divide their number."""
    if not words or len(words) % length:
        return [words]
    return [words[k : k + length] for k in range(0, len(words), length)]


def typed_goal(
    goal: list[str], pose: list[str], box: list[str], angle: str | None, mechanism: Mechanism, *, degrees: bool
) -> Goal:
    """One or several configurations or poses, of which any will do; or a region around one pose.

    Args:
        goal: n words, or k n.
        pose: x y z [m] and perhaps roll pitch yaw, or k times all six.
        box: how far the tip may be from the pose along each of its axes: one number or three [m].
        angle: by how much the tip may be turned from it.
        mechanism: the arm.
        degrees: whether bare angles are degrees.

    Raises:
        InputError: no goal or two; a wrong number of words; room around anything but one pose.
    """
    if bool(goal) == bool(pose):
        raise InputError("cli.plan_one_goal")
    if (box or angle is not None) and not (pose and len(pose) in (3, len(PLACES))):
        raise InputError("cli.plan_region")
    if goal:
        rows = [joint_values("goal", row, mechanism, degrees=degrees) for row in rows_of(goal, mechanism.n)]
        return rows[0] if len(rows) == 1 else np.stack(rows)
    poses = [typed_pose("pose", row, degrees=degrees) for row in rows_of(pose, len(PLACES))]
    if box or angle is not None:
        sizes = [number(f"--box[{k}]", word) for k, word in enumerate(box or ["0"])]
        room = sizes[0] if len(sizes) == 1 else single("box", sizes, (3,))
        turn = 0.0 if angle is None else state.angle("--angle", angle, degrees=degrees)
        return GoalRegion(poses[0], box=room, angle=turn)
    # An array of four rows could be four configurations of an arm with four joints.
    return Pose(poses[0]) if len(poses) == 1 else np.stack(poses)


def typed_constraints(
    upright: str | None, orientation: bool, line: list[str], plane: list[str], *, degrees: bool
) -> tuple[Kept, ...]:
    """What the path keeps.

    Args:
        upright: largest angle between the tip's z axis and where it points at the start.
        orientation: whether the tip keeps its orientation.
        line: direction of the line that the tip stays on, in {s}.
        plane: normal of the plane that it stays in.
        degrees: whether bare angles are degrees.

    Raises:
        InputError: no three numbers, a direction of length zero, an angle out of range.
    """
    found = list[Kept]()
    if upright is not None:
        found.append(Upright(state.angle("--upright", upright, degrees=degrees)))
    if orientation:
        found.append(FixedOrientation())
    if line:
        found.append(OnLine(single("line", [number("--line", word) for word in line], (3,))))
    if plane:
        found.append(InPlane(single("plane", [number("--plane", word) for word in plane], (3,))))
    return tuple(found)
