"""Other robots beside the one of a job: standing ones are obstacles, moving ones are planned past its settled motion.

The robot of the job is planned first and never slowed. Each other robot that moves goes its moves in order, waits and
goes round so that it meets neither the scene nor the robots before it; that is proved at every moment of the plan.
Bodies of an arm that are always near each other are no news: only what is nearer than usual counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.collision import ArmMount, Checker, Clearance, ContactPair, MultiArmCell, Scene
from mafsil.collision import Obstacle as Body
from mafsil.errors import MafsilError
from mafsil.job.language.description import Collision, Job, Pose
from mafsil.job.language.surrounding_tables import OtherRobot
from mafsil.job.language.text import Places
from mafsil.job.language.units import pose_matrix
from mafsil.job.planning.cell_signals import Decision
from mafsil.job.planning.fitting import assumed_limits, coordinates, require_within
from mafsil.job.planning.placed_parts import Stay
from mafsil.job.planning.resting import resting_place
from mafsil.job.remark import Remark
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.model.appearance import with_skeleton
from mafsil.model.loading import load_mechanism
from mafsil.planning import TimedArm
from mafsil.planning.arms_motion import first_unproved, unproved_moment
from mafsil.robot import Robot, as_open_tree
from mafsil.trajectory import MotionLimits

NEAR = 0.05
"""Bodies of an arm that often come nearer to each other than this are no news, as far as they do as usual [m]."""
MAIN = "job"
"""How the robot of the job is called among the arms."""
SECONDS = 30.0
"""After which the search for a move of another robot gives up."""
STANDING = 1e-3
"""Of a robot that stands, so much is proved beside a part that is put down later [s]."""


@dataclass(frozen=True, eq=False, slots=True)
class OtherStep:
    """One move of another robot.

    Attributes:
        number: of the entry of its table, from 1.
        kind: joint, pause, set, wait or if.
        text: what it sets, waits for or looks at.
        start, end: on the clock of the job [s].
        part: of its motion; None where it is there already.
        q: (n,) where it is at the end [rad | m].
        index: of the move.
        after: index of the next move.
        decision: of a choice: which way it went, and why.
    """

    number: int
    kind: str
    text: str
    start: float
    end: float
    part: TimedArm | None
    q: JointVector
    index: int
    after: int
    decision: Decision | None = None

    def to_dict(self) -> dict[str, object]:
        """Plain data."""
        choice = None if self.decision is None else self.decision.to_dict()
        where: dict[str, object] = {"number": self.number, "kind": self.kind, "text": self.text, "choice": choice}
        return where | {"start": self.start, "end": self.end}


@dataclass(frozen=True, eq=False, slots=True)
class Neighbour:
    """Another robot at its base pose.

    Attributes:
        asked: what the file says of it.
        robot: at its base pose, with shapes.
        start: (n,) where it begins [rad | m].
        goals: (n,) coordinates of each of its moves; None for what is no goal in joints.
        degrees: whether angles of the file are degrees.
        checks_itself: whether its description has shapes, so that it is checked against itself.
    """

    asked: OtherRobot
    robot: Robot
    start: JointVector
    goals: tuple[JointVector | None, ...]
    degrees: bool
    checks_itself: bool

    @property
    def name(self) -> str:
        """Of the robot, as sentences call it."""
        return visible(self.asked.name)

    @property
    def stands(self) -> bool:
        """Whether it has no moves."""
        return not self.asked.move

    def goal(self, k: int, q: JointVector) -> JointVector | PoseMatrix:
        """Where move k leads from a configuration: coordinates (n,), or a pose (4, 4) of the tip in {s}."""
        known, pose = self.goals[k], self.asked.move[k].pose
        if known is not None or pose is None:
            return q if known is None else known
        here = np.asarray(self.robot.forward_kinematics(q))
        return pose_matrix(pose, degrees=self.degrees, orientation=here[:3, :3])


@dataclass(frozen=True, eq=False, slots=True)
class NeighbourMotion:
    """What another robot does.

    Attributes:
        neighbour: the robot.
        motion: of its coordinates; it follows that exactly, its controller is not simulated.
        steps: its moves, one after the other.
    """

    neighbour: Neighbour
    motion: TimedArm
    steps: tuple[OtherStep, ...] = ()

    def arrival(self) -> Remark:
        """When it has done all of its moves."""
        times = {"duration": quantity(self.motion.duration, "s"), "waiting": quantity(self.motion.waiting, "s")}
        return Remark("good", "job.other_arrives", {"name": self.neighbour.name, **times})

    def never_made(self) -> list[Remark]:
        """For each choice that it came to: the way that was never taken."""
        moves = self.neighbour.asked.move
        ways: dict[tuple[str | int, ...], set[bool]] = {}
        first: dict[tuple[str | int, ...], OtherStep] = {}
        for step in self.steps:
            if step.decision is not None:
                place = moves[step.index].origin
                ways.setdefault(place, set()).add(step.decision.holds)
                first.setdefault(place, step)
        found: list[Remark] = []
        for place, taken in ways.items():
            step, fork = first[place], moves[first[place].index].fork
            assert fork is not None
            details = {"move": f"{self.neighbour.name} {step.number}", "tests": step.text}
            if taken == {False}:
                found.append(Remark("good", "job.loop_never" if fork.loop else "job.then_never", details))
            elif taken == {True} and fork.other:
                found.append(Remark("good", "job.else_never", details))
        return found

    def poses(self, t: Floats) -> PoseMatrix:
        """(k, L, 4, 4) of its links in {s} at times (k,) [s]."""
        return np.asarray(self.neighbour.robot.link_poses(self.motion.at(t)))


def neighbours_of(job: Job, folder: Path, places: Places) -> tuple[Neighbour, ...]:
    """The other robots of a job.

    Args:
        job: the job.
        folder: to which paths of robot files are relative.
        places: of the keys, for errors.

    Raises:
        MafsilError: a robot cannot be read; numbers that do not fit it, two of one name.
    """
    found: list[Neighbour] = []
    for k, asked in enumerate(job.other_robot):
        if asked.name in (MAIN, "") or any(asked.name == each.asked.name for each in found) or "/" in asked.name:
            raise places.error("job.other_name", ("other_robot", k, "name"), given=visible(asked.name))
        source = folder / asked.robot if Path(asked.robot).suffix else asked.robot
        try:
            mechanism = load_mechanism(source)
        except MafsilError as fault:
            raise places.of_file(fault, ("other_robot", k, "robot")) from None
        own = any(link.collisions or link.visuals for link in mechanism.links)
        if not any(link.collisions for link in mechanism.links):
            mechanism = with_skeleton(mechanism)
        pose = Pose(position=asked.position, rpy=asked.rpy, quaternion=asked.quaternion)
        T_sb = pose_matrix(pose, degrees=job.angles == "degrees", orientation=np.eye(3))
        robot = as_open_tree(replace(mechanism, T_sb=T_sb))
        start = resting_place(robot.limits)
        if asked.joints is not None:
            start = _coordinates(job, robot, asked.joints, places, ("other_robot", k, "joints"))
        goals = [
            None
            if move.joints is None
            else _coordinates(job, robot, move.joints, places, ("other_robot", k, "move", *move.origin, "joints"))
            for move in asked.move
        ]
        found.append(Neighbour(asked, robot, start, tuple(goals), job.angles == "degrees", own))
    return tuple(found)


def _coordinates(
    job: Job, robot: Robot, values: tuple[float, ...], places: Places, path: tuple[str | int, ...]
) -> JointVector:
    """Numbers of the file as joint coordinates within the limits."""
    if len(values) != robot.n:
        raise places.error("job.other_count", path, expected=robot.n, got=len(values))
    require_within(job, robot, places, path, values)
    q, limits = coordinates(job, robot, values), robot.limits
    return np.clip(q, limits.lower, limits.upper)


def standing_bodies(neighbours: Sequence[Neighbour]) -> list[Body]:
    """The bodies of robots that only stand there, as obstacles in {s}."""
    found: list[Body] = []
    for each in neighbours:
        if not each.stands:
            continue
        poses = np.asarray(each.robot.link_poses(each.start))
        for body in Checker(each.robot, self_collision=False).bodies:
            for i, (geometry, T) in enumerate(body.shapes):
                number = f" {i + 1}" if len(body.shapes) > 1 else ""
                found.append(Body(geometry, poses[body.link] @ T, f"{each.name}/{body.name}{number}"))
    return found


class Neighbourhood:
    """The robot of a job, as its plan moves it, with the other robots around it.

    Args:
        robot: of the job, with its tool and shapes.
        neighbours: the others.
        scene: obstacles, standing robots among them.
        parts: everything that the robot of the job carries at some time: met by the others at all times.
        rule: the clearance to keep, and that of each of the others from itself.
    """

    def __init__(
        self, robot: Robot, neighbours: Sequence[Neighbour], scene: Scene, parts: Sequence[Body], rule: Collision
    ) -> None:
        self.moving = tuple(each for each in neighbours if not each.stands)
        mounted = [
            ArmMount(
                each.asked.name, each.robot, srdf=each.asked.srdf, skip=each.asked.skip,
                self_collision=each.checks_itself,
            )
            for each in self.moving
        ]  # fmt: skip
        main = ArmMount(MAIN, robot, attached=parts, self_collision=False)
        self.cell = MultiArmCell(
            [main, *mounted], scene, clearance=rule.clearance, self_clearance=rule.kept_of_itself(rule.clearance)
        ).with_passive([MAIN])

    def limits(self, job: Job, speed: float) -> MotionLimits:
        """Limits of all coordinates, as jobs drive robots: shares of their own, assumed where there are none.

        Args:
            job: that has bounds.
            speed: share of them.
        """
        robot, shares = self.cell.robot, job.limits
        velocity, acceleration = (
            _drive(getattr(robot.limits, name), assumed_limits(job, robot, name), share)
            for name, share in (("velocity", shares.speed_scale), ("acceleration", shares.acceleration_scale))
        )
        return MotionLimits.of(len(velocity), velocity=velocity * speed, acceleration=acceleration * speed**2)

    def own_limits(self, name: str, job: Job, speed: float) -> MotionLimits:
        """Limits of one robot; arguments as for `limits`."""
        columns, limits = self.cell.columns[name], self.limits(job, speed)
        return MotionLimits.of(
            columns.stop - columns.start,
            velocity=limits.velocity[1, columns], acceleration=limits.acceleration[1, columns],
        )  # fmt: skip

    def unproved_from(self, motions: Mapping[str, TimedArm]) -> float | None:
        """From when on motions of all are not proved to keep the clearance; None where all of it is [s]."""
        return unproved_moment(self.cell, motions, {})

    def among_parts(self, bodies: Sequence[Body]) -> MultiArmCell:
        """The robots with more bodies in the scene."""
        return self.cell.with_scene(Scene([*self.cell.scene, *bodies])) if bodies else self.cell

    def near_part(self, name: str, motion: TimedArm, stay: Stay) -> tuple[float, ContactPair] | None:
        """From when on another robot's motion is not proved to keep the clearance from a part that stands there.

        Args:
            name: of the robot.
            motion: of it; it stands afterwards.
            stay: of the part.

        Returns:
            The moment [s], and what is nearest then; None where all of the motion is proved.
        """
        end = min(stay.taken, max(motion.duration, stay.put + STANDING))
        inner = motion.starts[(motion.starts > stay.put) & (motion.starts < end)]
        breaks = np.unique(np.concatenate([[stay.put], inner, [end]]))
        moving = [motion.is_moving(float(a), float(b)) for a, b in pairwise(breaks)]
        accelerations = np.array(moving, dtype=np.float64)[:, None] * motion.acceleration
        checker = self.cell.alone(name).with_scene(Scene([stay.body]))
        time = first_unproved(checker, motion.at, breaks, accelerations)
        return None if time is None else (time, next(iter(checker.distance(motion.at(time)))))

    def contact(self, motions: Mapping[str, TimedArm], time: float) -> ContactPair:
        """The two bodies that are nearest at a moment [s]."""
        q = self.cell.join({name: motion.at(time) for name, motion in motions.items()})
        return next(iter(self.cell.distance(q)))

    def clearances(
        self, q: JointVector, t: Floats, motions: Mapping[str, TimedArm], stays: Sequence[Stay]
    ) -> Iterator[ContactPair]:
        """What other robots come nearest to when the robot of the job is at (k, n) at times (k,) [s].

        Args:
            q: (k, n) of the robot of the job.
            t: (k,), in order.
            motions: of the others.
            stays: parts that stand in the scene for a time.
        """
        places = {name: motion.at(t) for name, motion in motions.items() if name != MAIN}
        rows = self.cell.join({MAIN: q, **places})
        there = np.array([(each.put <= t) & (t < each.taken) for each in stays]).reshape(len(stays), len(t))
        changes = np.flatnonzero((there[:, 1:] != there[:, :-1]).any(axis=0)) + 1
        for some in np.split(np.arange(len(t)), changes):
            bodies = [each.body for k, each in enumerate(stays) if there[k, some].any()]
            checker = self.among_parts(bodies)
            yield from unusual(checker, without_usual(checker), rows[some])


def _drive(own: Floats, assumed: Floats, share: float) -> Floats:
    """Bounds of joints as jobs drive them."""
    known = np.isfinite(own) & (own > 0.0)
    return np.where(known, np.where(known, own, 1.0) * share, assumed)


def without_usual(checker: Checker) -> Checker:
    """The same, where bodies of the arm that are often near each other are not looked at."""
    names, usual = [body.name for body in checker.bodies], _usual(checker)
    pairs = [k for k, (a, b) in enumerate(checker.arm.pairs.tolist()) if (names[a], names[b]) not in usual]
    return checker.checking(range(len(names)), pairs)


def _usual(checker: Checker) -> dict[tuple[str, str], float]:
    return checker.nearer_than(max(NEAR, checker.clearance))


def unusual(checker: Checker, others: Checker, q: Floats) -> Clearance:
    """Smallest distances at configurations (k, n), without those of bodies of the arm that are near as usual.

    Args:
        checker: of the arm.
        others: the same `without_usual`.
        q: configurations.
    """
    found, usual = checker.distance(q), _usual(checker)
    rows = [k for k, one in enumerate(found) if one.distance >= usual.get((one.first, one.second), np.inf)]
    if not rows:
        return found
    rest = others.distance(q[rows])
    for row, distance, first, second in zip(rows, rest.distance, rest.first, rest.second, strict=True):
        if np.isfinite(distance):
            found.distance[row], found.first[row], found.second[row] = distance, first, second
    return found
