"""What stands around the arm of a job: whether a motion meets it, and ways round it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.collision import Box, Capsule, Checker, Cone, ContactPair, ConvexHull, Cylinder, Plane, Scene, Sphere
from mafsil.collision import Obstacle as Body
from mafsil.collision.shapes import Geometry
from mafsil.job.language.description import Collision, Grasp, Job, Obstacle, SceneFile, Tool
from mafsil.job.language.reading import parse_scene
from mafsil.job.language.surrounding_tables import CONSTRAINED_PLANNER
from mafsil.job.language.text import text_of
from mafsil.job.language.units import box_in_tip, pose_matrix
from mafsil.job.planning.beside import Beside
from mafsil.job.planning.equipment import UNNAMED_TOOL, Load, box_of_tool
from mafsil.job.planning.named_files import shape_of
from mafsil.job.planning.neighbours import Neighbour, Neighbourhood, NeighbourMotion, standing_bodies
from mafsil.job.planning.placed_parts import PlacedPart, Stay
from mafsil.job.remark import Remark
from mafsil.messages.visible import visible
from mafsil.model import Mechanism
from mafsil.model.appearance import with_shapes
from mafsil.model.link import Mesh
from mafsil.planning import ArmPlan, TimedArm, plan
from mafsil.planning.kept_planning import Measured
from mafsil.planning.path_constraints import Constraint
from mafsil.planning.waiting_places import standing
from mafsil.robot import Robot, as_open_tree
from mafsil.trajectory import MotionLimits, Trajectory

STEP = 0.02
"""Largest change of a coordinate over a chord by which a motion is proved free [rad | m]."""
MOST_CHORDS = 4000
OFF = "job.unchecked_itself_off"
"""The key of the sentence that a robot is not checked against itself, as the job wants it."""
MOST_CHECKERS = 64
"""Kept at a time: each knows one load, one clearance and the parts that stand around."""
RESTS = ("pick", "place", "tool", "pause", "set", "wait", "if", "settle")
"""Kinds of legs at which nothing moves."""
ROOM = 1e-4
"""What ways round keep on top of the clearance: more than a chord by which they are proved again leaves them [m]."""
CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))
"""(8, 3) of a box with edges of length 2."""
NEARER = 1.0 - 1e-9
"""Share of the clearance by which a carried part may come nearer: one that touches is not free, whatever is rounded."""
SEARCHES, MORE_NODES, FEWEST_NODES = 4, 2, 500
"""Searches with seeds of their own of which the shortest way is taken; nodes of the later ones over the first one's."""
MOST_NODES = 200_000
"""Of a search for a way."""
RESTING = 1e-4
"""How much smaller than itself a carried part counts: it may stand on something [m]."""


@dataclass(frozen=True, eq=False, slots=True)
class Hit:
    """Where a motion comes too near to something.

    Attributes:
        time: of the motion [s].
        contact: the two bodies, how near, where.
    """

    time: float
    contact: ContactPair


@dataclass(frozen=True, eq=False, slots=True)
class WayRound:
    """How a move of the joints goes round what stands in its way.

    Attributes:
        plan: of the planner.
        contact: what the straight way would meet first, if that is known.
    """

    plan: ArmPlan
    contact: ContactPair | None

    @property
    def keeps(self) -> Measured | None:
        """What is kept on the way, and within what that is proved; None where nothing was asked for."""
        found = self.plan
        if found.kept is None or not found.kept.asked or found.checker is None:
            return None
        worst = found.kept.along(found.checker, found.path[:-1], found.path[1:])
        return None if worst is None else Measured(found.kept, worst)

    def bodies(self) -> dict[str, object]:
        """The two that meet on the straight way, for sentences."""
        first, second = ("?", "?") if self.contact is None else (self.contact.first, self.contact.second)
        return {"first": visible(first), "second": visible(second)}

    def details(self) -> dict[str, object]:
        """For the sentence about it."""
        found = self.plan
        return self.bodies() | {
            "planner": found.planner, "count": len(found.path) - 2, "states": found.configurations,
            "proofs": found.proofs, "length": f"{found.length:.3g}",
        }  # fmt: skip

    def to_dict(self) -> dict[str, object]:
        """The planner's account: what it looked at, the corners of its path, what stands in the straight way."""
        found, keeps = self.plan, self.keeps
        return {
            "planner": found.planner, "nodes": found.nodes, "configurations": found.configurations,
            "segments": found.segments, "proofs": found.proofs, "length": found.length, "path": found.path.tolist(),
            "would_hit": None if self.contact is None else [self.contact.first, self.contact.second],
            "kept": [] if keeps is None else keeps.amounts.tolist(),
        }  # fmt: skip


class Surroundings:
    """The arm of a job among its obstacles.

    What the report draws is what is checked: the description's collision shapes, else what it shows, else tubes along
    the links, and the boxes of tools. A carried part keeps no clearance, so that it may stand on a table; parts put
    down stand where they are.

    Args:
        job: its obstacles and clearance.
        robot: with the tool with which it starts.
        neighbours: other robots; those that only stand there belong to the scene.
    """

    def __init__(self, job: Job, robot: Robot, neighbours: tuple[Neighbour, ...] = ()) -> None:
        self.rule = job.collision or Collision()
        self.robot = robot
        self.neighbours = neighbours
        self.obstacles = scene_of(job)
        self.scene = Scene([*self.obstacles, *standing_bodies(neighbours)])
        self._others: tuple[Neighbourhood, Mapping[str, TimedArm], tuple[Stay, ...]] | None = None
        self._checkers: dict[tuple[Load, float, tuple[PlacedPart, ...]], Checker] = {}
        self._rest: JointVector | None = None
        self.judges_itself = why_not_itself(job.collision, robot.mechanism) is None
        self._mechanism = with_shapes(robot.mechanism)

    def checker(self, load: Load, clearance: float | None = None, parts: tuple[PlacedPart, ...] = ()) -> Checker:
        """The arm with what hangs on its flange among parts put down, keeping a clearance; that of the job if None."""
        kept = self.rule.clearance if clearance is None else clearance
        key = load, kept, parts
        if key not in self._checkers:
            scene = Scene([*self.scene, *(each.body for each in parts)]) if parts else self.scene
            if len(self._checkers) >= MOST_CHECKERS:
                del self._checkers[next(iter(self._checkers))]
            self._checkers[key] = Checker(
                self._mechanism,
                scene,
                attached=_hanging(load, kept),
                clearance=kept,
                self_clearance=self.rule.kept_of_itself(kept),
                srdf=self.rule.srdf,
                skip=self.rule.skip,
                self_collision=self.judges_itself,
                known_free=self._rest,
            )
        return self._checkers[key]

    def rests_at(self, q: JointVector, load: Load) -> list[Remark]:
        """From now on bodies of the arm that meet at a configuration are not checked against each other; which.

        Args:
            q: where the arm is known to be free of itself.
            load: what hangs on the flange there.
        """
        self._rest = q
        self._checkers.clear()
        pairs = self.checker(load).resting
        return [Remark("warning", "job.rest_pairs", {"pairs": ", ".join(map(str, pairs))})] if pairs else []

    def is_free(
        self, q: JointVector, load: Load, clearance: float | None = None, parts: tuple[PlacedPart, ...] = ()
    ) -> bool:
        """Whether a configuration keeps a clearance; that of the job if None."""
        return bool(self.checker(load, clearance, parts).free(q))

    def first_hit(
        self, trajectory: Trajectory, load: Load, clearance: float | None = None, parts: tuple[PlacedPart, ...] = ()
    ) -> Hit | None:
        """Where a motion first comes nearer than the clearance, by chords of it that are proved free; None if nowhere.

        Args:
            trajectory: of the joints.
            load: what hangs on the flange.
            clearance: that is kept; that of the job if None [m].
            parts: that stand in the scene.
        """
        t = np.linspace(0.0, trajectory.duration, 65)
        way = np.abs(np.diff(trajectory.at(t).u, axis=0)).sum(axis=0).max(initial=0.0)
        t = np.linspace(0.0, trajectory.duration, int(min(max(way / STEP, 1.0), MOST_CHORDS)) + 2)
        checker, q = self.checker(load, clearance, parts), trajectory.at(t).u
        found = checker.check_path(q)
        if found:
            return None
        time = float(np.interp(found.at, np.arange(len(t)), t))
        contact = found.contacts[0] if found.contacts else next(iter(checker.distance(found.q)))
        return Hit(time, contact)

    def way_round(
        self, q: JointVector, goal: JointVector, load: Load, clearance: float, planner: str | None = None,
        met: ContactPair | None = None, parts: tuple[PlacedPart, ...] = (), constraints: tuple[Constraint, ...] = (),
        *, nodes: int | None = None,
    ) -> WayRound | None:  # fmt: skip
        """A way between two configurations, or why there is none; None where the straight one is free.

        Args:
            q: (n,) where it begins.
            goal: (n,) where it ends, or (k, n) of which any will do.
            load: what hangs on the flange.
            clearance: that is kept [m].
            planner: which one searches; that of the job if None.
            met: what stands in the way, if that is known; the straight way is not asked then.
            parts: that stand in the scene.
            constraints: what is kept all the way; the straight way is not asked then.
            nodes: most that RRT-Connect may make; its own most if None.
        """
        checker = self.checker(load, clearance, parts)
        if met is None and not constraints and goal.ndim == 1:
            straight = checker.check_path(q, goal)
            if straight:
                return None
            met = straight.contacts[0] if straight.contacts else None
        roomy, rule = checker.with_clearance(clearance + ROOM), self.rule
        if roomy.free(np.concatenate([q[None], np.atleast_2d(goal)])).all():
            checker = roomy
        search = CONSTRAINED_PLANNER if constraints else planner or rule.planner
        most = nodes if nodes is not None and search == "rrt_connect" else MOST_NODES
        asked = partial(plan, checker, None, q, goal, planner=search, constraints=constraints)
        found = asked(seed=rule.seed, seconds=rule.seconds, max_nodes=most)
        if found and search in ("rrt_connect", CONSTRAINED_PLANNER):
            nodes = max(MORE_NODES * found.nodes, FEWEST_NODES)
            more = (asked(seed=rule.seed + k, seconds=rule.seconds, max_nodes=nodes) for k in range(1, SEARCHES))
            found = min([found, *(one for one in more if one)], key=lambda one: one.length)
        if found.interrupted:
            # Who stops a job wants no more of it than of its planner.
            raise KeyboardInterrupt
        return WayRound(found, met)

    def neighbourhood(self, loads: Sequence[Load]) -> Neighbourhood:
        """The robot among those that move.

        Args:
            loads: what hangs on its flange at some time; other robots keep clear of all of it at all times.
        """
        hanging = {(load.equipment.name, id(thing)): body for load in loads for thing, body in _boxes(load, 0.0)}
        boxes = [replace(body, name=f"{body.name} {k + 1}") for k, body in enumerate(hanging.values())]
        return Neighbourhood(as_open_tree(self._mechanism), self.neighbours, self.scene, boxes, self.rule)

    def settle(self, others: Beside | None, main: TimedArm) -> tuple[NeighbourMotion, ...]:
        """What the other robots do while the robot moves as planned.

        Args:
            others: those that move.
            main: the whole motion of the robot.

        Raises:
            Refused: a move of another robot for which no way was found, a wait that never ends.
        """
        found: list[NeighbourMotion] = []
        motions = {} if others is None else others.finish(main)
        for each in self.neighbours:
            if others is None or each.stands:
                still = standing(each.start, MotionLimits.of(each.robot.n, acceleration=1.0))
                found.append(NeighbourMotion(each, still))
                continue
            found.append(NeighbourMotion(each, motions[each.asked.name], others.steps(each.asked.name)))
        if others is not None:
            self._others = others.around, motions, others.parts.stays
        return tuple(found)

    def clearances_beside(self, q: Floats, t: Floats) -> Iterator[ContactPair]:
        """What moving robots come nearest to, the robot at (k, n) at times (k,) [s]; nothing where none moves."""
        if self._others is not None:
            around, motions, stays = self._others
            yield from around.clearances(q, t, motions, stays)


def why_not_itself(rule: Collision | None, mechanism: Mechanism) -> str | None:
    """Why a robot is not checked against itself, as the key of a sentence; None if it is.

    Args:
        rule: of the job.
        mechanism: the robot.
    """
    asked = None if rule is None else rule.self_collision
    if asked is not None:
        return None if asked else OFF
    links = mechanism.links
    shapes = [link.collisions for link in links if link.collisions] or [link.visuals for link in links if link.visuals]
    if not shapes:
        return "job.unchecked_itself_shapes"
    lost = any(isinstance(one.geometry, Mesh) and one.geometry.path is None for own in shapes for one in own)
    return "job.unchecked_itself_mesh" if lost else None


def scene_of(file: Job | SceneFile, folder: Path | None = None) -> Scene:
    """The obstacles of a file.

    Args:
        file: a job, or a file of obstacles alone.
        folder: to which paths of files are relative; the present one if None.

    Raises:
        FileError: a file that cannot be read.
    """
    degrees, home = file.angles == "degrees", folder or Path()
    return Scene([body_of(each, k, degrees, home) for k, each in enumerate(file.obstacle)])


def scene_in(path: Path) -> Scene:
    """The obstacles of a file that has them alone.

    Args:
        path: of the file.

    Raises:
        FileError: it, or a file that it names, cannot be read.
        JobError: what is no obstacle.
    """
    return scene_of(parse_scene(text_of(path), path.name), path.parent)


def body_of(obstacle: Obstacle, index: int, degrees: bool, folder: Path) -> Body:
    """An obstacle of a job file.

    Args:
        obstacle: as the file has it.
        index: its number, where it has no name.
        degrees: unit of its angles.
        folder: to which the path of a mesh is relative.
    """
    geometry: Geometry = Plane()
    if obstacle.box is not None:
        geometry = Box(obstacle.box)
    elif obstacle.sphere is not None:
        geometry = Sphere(obstacle.sphere)
    elif obstacle.cylinder is not None:
        geometry = Cylinder(*obstacle.cylinder)
    elif obstacle.capsule is not None:
        geometry = Capsule(*obstacle.capsule)
    elif obstacle.cone is not None:
        geometry = Cone(*obstacle.cone)
    elif obstacle.file is not None:
        geometry = shape_of(obstacle, folder)
    T = pose_matrix(obstacle, degrees=degrees, orientation=np.eye(3))
    return Body(geometry, T, visible(obstacle.name) or f"obstacle[{index}]")


def _hanging(load: Load, clearance: float) -> list[Body]:
    """Tool and part, in the tip frame of the tool with which the robot starts."""
    return [body for _, body in _boxes(load, clearance)]


def _boxes(load: Load, clearance: float) -> Iterator[tuple[Tool | Grasp, Body]]:
    """Tool and part, each with its box; that of the part is smaller by what it may stand on and keeps no clearance."""
    equipment, carried = load.equipment, load.carried
    tool = equipment.tool
    if tool.size is not None:
        T = equipment.T_of_first @ box_of_tool(equipment)
        yield tool, Body(Box(tool.size), T, visible(equipment.name or UNNAMED_TOOL))
    if carried is not None:
        size = np.array(carried.size)
        corners = np.maximum(size / 2.0 - RESTING, 0.05 * size / 2.0) * CORNERS
        hull = ConvexHull(corners, rounding=-NEARER * clearance)
        yield carried, Body(hull, equipment.T_of_first @ box_in_tip(carried), visible(carried.name))
