"""`mafsil plan`: a way of an arm round obstacles, every motion of it proved free, timed for a controller."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mafsil.cli.answer import Answer, Laid, Toned
from mafsil.cli.numerals import count, number
from mafsil.cli.plan_question import rows_of, typed_constraints, typed_goal
from mafsil.cli.state import degrees_remarks, joint_values, shown, unit
from mafsil.cli.table import brief, table
from mafsil.collision import Checker, Scene
from mafsil.job.surroundings import scene_in, with_shapes
from mafsil.messages import say
from mafsil.planning import ArmPlan
from mafsil.planning import plan as plan_path
from mafsil.robot import Robot, load
from mafsil.trajectory import MotionLimits, export

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
    around = Scene() if scene is None else scene_in(Path(scene))
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
    data: dict[str, Any] = {"robot": arm.name, **found.to_dict()}
    typed = [words for words in (start, *rows_of(goal, arm.n)) if words]
    hints = [hint for words in typed for hint in degrees_remarks(words, arm.mechanism, degrees=degrees)]
    if not found:
        return Answer(data, (), "\n".join([found.explain(), *dict.fromkeys(hints)]))
    first, *rest = found.explain().splitlines()
    lines = [Toned(first, "good"), *rest, *_points(arm, found, degrees=degrees), *dict.fromkeys(hints)]
    if free is not None:
        data["not_checked"] = [(each.first, each.second) for each in checker.resting]
        names = f" ({', '.join(map(str, checker.resting))})" if checker.resting else ""
        lines.append(say("collision.skipped_rest", count=len(checker.resting), names=names))
    near = found.clearance()
    if np.isfinite(near.distance).any():
        k = int(near.distance.argmin())
        data["clearance"] = float(near.distance[k])
        lines.append(say("cli.plan_nearest", nearest=list(near)[k].sentence()))
    if out is not None:
        timed = found.timed(_limits(arm))
        assert timed.trajectory is not None
        written = export(timed.trajectory, out, _limits(arm), joints=arm.joint_names)
        data |= {"duration": timed.duration, "file": written.to_dict()}
        lines += [*_assumed(arm), written.explain()]
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


def _assumed(arm: Robot) -> list[str]:
    """Which limits the motion kept that nobody described."""
    found: list[str] = []
    for name, value in (("velocity", VELOCITY), ("acceleration", ACCELERATION)):
        known = getattr(arm.limits, name)
        joints = [one for one, x in zip(arm.joint_names, known, strict=True) if not (np.isfinite(x) and x > 0.0)]
        if joints:
            found.append(say(f"job.{name}_assumed", joints=", ".join(joints), value=value))
    return found


def _limits(arm: Robot) -> MotionLimits:
    """Of the arm, finite where a motion needs them."""
    own = arm.limits
    velocity = np.where(np.isfinite(own.velocity) & (own.velocity > 0.0), own.velocity, VELOCITY)
    acceleration = np.where(np.isfinite(own.acceleration) & (own.acceleration > 0.0), own.acceleration, ACCELERATION)
    return MotionLimits.of(arm.n, velocity=velocity, acceleration=acceleration)
