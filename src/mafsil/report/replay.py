"""What the replay of a run shows: the coordinates of the arm over time, what it carries, what stands around it.

What stands around the arm of a run, as solids to draw.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats, Integers, JointVector
from mafsil.collision import Cone, ConvexHull, HeightMap, Obstacle, PointCloud, TriangleMesh
from mafsil.geometry import pose
from mafsil.ik import inverse_kinematics
from mafsil.job import Job, Run
from mafsil.job.language.text import Places
from mafsil.job.language.units import box_in_tip, goal_matrix, pose_matrix
from mafsil.job.planning.equipment import UNNAMED_TOOL, box_of_tool
from mafsil.job.planning.fitting import coordinates, require_fit
from mafsil.job.planning.neighbours import neighbours_of
from mafsil.job.planning.resting import resting_configuration, starting_place
from mafsil.job.planning.surroundings import scene_of
from mafsil.model.link import Box, Capsule, Cylinder, Sphere
from mafsil.model.mesh import Surface
from mafsil.model.mesh.decimation import decimate
from mafsil.model.mesh.surface import SIDES, hull_surface
from mafsil.report.content import Carried, Scene
from mafsil.report.touched import doors, shelves, standing
from mafsil.robot import Robot
from mafsil.scene import Body, Drawing, Solid, compact
from mafsil.scene.inline import patch

OBSTACLE_COLOUR = (0.72, 0.66, 0.58, 1.0)
MOST_TRIANGLES = 20_000
"""Of one obstacle in a picture; what is checked keeps all of them."""
MOST_POINTS = 2_000
"""Of one cloud in a picture."""
MOST_ROWS = 96
"""Of one grid of heights in a picture, along each side."""
WIDE, THIN = 1.5, 2e-3
"""What the plate of a half space has beside the scene, and its thickness, as shares of the scene."""
FLAT = 1e-3
"""Thickness of what is flat, in a picture [m]."""
OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], np.float64)
EIGHT_FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
MOST_NUMBERS = 420_000
"""Of the replay: a long run gets fewer frames, so that its replay stays below 2.3 MB."""
PART_COLOUR = (0.23, 0.47, 0.70, 1.0)
TOOL_COLOUR = (0.35, 0.35, 0.38, 1.0)
JOB = "job.toml"
"""The job beside its report."""


def recipe(job: Job) -> tuple[str, ...]:
    """Lines of Python that do a run again, beside its report; the robot is `run.robot` then.

    Robots, included files and shapes of obstacles are looked for from where the script runs.
    """
    folder = ', folder="."' if Path(job.robot).suffix or job.cells or any(each.file for each in job.obstacle) else ""
    return ("from mafsil.job import solve_file", f'run = solve_file("{JOB}"{folder})')


def replay_scene(run: Run) -> Scene:
    """Frames of the replay, the parts that are carried included."""
    t, mechanism = run.recording.t, run.robot.mechanism
    boxes = sum(one.kind == "pick" for one in run.plan.legs) + len({one.load.equipment for one in run.plan.legs})
    boxes += sum(len(one.neighbour.robot.mechanism.links) for one in run.plan.neighbours if not one.neighbour.stands)
    period = max(1.0 / run.job.report.frame_rate, t[-1] * (mechanism.n + 14 + 7 * boxes) / MOST_NUMBERS)
    moments = np.minimum(np.arange(0.0, t[-1] + period * 0.999, period), t[-1])
    rows = np.minimum(np.searchsorted(t, moments), len(t) - 1)
    q = run.recording.q[rows]
    poses = np.asarray(run.robot.link_poses(q))
    tips, references = run.tips(rows)
    parts = part_tracks(run, moments)
    carried = [*parts, *tool_tracks(run, moments)]
    near = [one.poses(moments[:1])[0, :, :3, 3] for one in run.plan.neighbours]
    seen = np.concatenate([poses[:, :, :3, 3].reshape(-1, 3), tips[:, :3, 3], *near])
    drawing = Drawing(mechanism)
    centre, size, floor = drawing.extent(seen, poses[0])
    floor = min([floor, *(_lowest(one) for one in carried)])
    beside, still = _neighbours(run, moments, floor)
    beside += [Part(body, track, 0, 0) for body, track in doors(run, moments, tips)]
    targets = [(leg.name, compact(leg.target)) for leg in run.plan.legs if leg.target is not None]
    surroundings, touched = run.plan.surroundings, run.recording.contact_wrench
    around = [] if surroundings is None else drawn(surroundings.obstacles, size, seen)
    around += standing(run.job, size, tips[:, :3, 3])
    around += shelves([place for part in parts for place in part.lying()], around, floor, size)
    return Scene(
        bodies=drawing.bodies(floor, poses[0]),
        period=period,
        times=moments,
        q=q,
        tips=compact(tips),
        references=compact(references),
        targets=tuple(targets),
        carried=tuple(Carried(one.body, compact(one.track), one.first, one.end) for one in (*carried, *beside)),
        fixed=tuple((body, compact(T)) for body, T in (*around, *still)),
        centre=centre,
        size=size,
        floor=floor,
        forces=None if touched is None else touched[rows][:, 3:],
    )


def waiting_scene(job: Job, robot: Robot, folder: Path, text: str = "") -> Scene:
    """What stands around the arm of a job before anything is planned: where it begins, targets, parts, obstacles.

    A target is where its move says that it is, from the one before if it is relative; a part waits where the tip takes
    it. The one frame is the start.

    Args:
        job: what is asked.
        robot: of the job, with the tool with which it starts.
        folder: to which paths of files are relative.
        text: of the job, for the lines of errors.

    Raises:
        MafsilError: the start or the goals do not fit the robot, or a file cannot be read.
    """
    places = Places(text).of(job)
    require_fit(job, robot, places)
    q = _beginning(job, robot)
    poses = np.asarray(robot.link_poses(q))
    tip = here = np.asarray(robot.forward_kinematics(q))
    targets: list[tuple[str, Floats]] = []
    parts: list[Part] = []
    for move in job.move:
        if move.pose is not None:
            here = goal_matrix(move.pose, here, degrees=job.angles == "degrees")
            targets.append((move.name, here))
        elif move.joints is not None and not robot.mechanism.loops:
            here = np.asarray(robot.forward_kinematics(coordinates(job, robot, move.joints)))
        if move.pick is not None and all(move.pick.name != each.body.name for each in parts):
            solid = Solid("box", move.pick.size, colour=PART_COLOUR)
            parts.append(Part(Body(move.pick.name, (solid,)), (here @ box_in_tip(move.pick))[None], 0, 0))
    others = neighbours_of(job, folder, places)
    neighbours = [(one, np.asarray(one.robot.link_poses(one.start))) for one in others]
    goals = np.array([T[:3, 3] for _, T in targets]).reshape(-1, 3)
    seen = np.concatenate([poses[:, :3, 3], tip[None, :3, 3], goals, *(each[:, :3, 3] for _, each in neighbours)])
    drawing = Drawing(robot.mechanism)
    centre, size, floor = drawing.extent(seen, poses)
    floor = min([floor, *(_lowest(one) for one in parts)])
    around = drawn(scene_of(job, folder).obstacles, size, seen) if job.obstacle else []
    around += standing(job, size, np.concatenate([tip[None, :3, 3], goals]))
    for one, placed in neighbours:
        around += zip(Drawing(one.robot.mechanism).bodies(floor, placed), placed, strict=True)
    return Scene(
        bodies=drawing.bodies(floor, poses),
        period=1.0,
        times=np.zeros(1),
        q=q[None],
        tips=compact(tip[None]),
        references=compact(tip[None]),
        targets=tuple((name, compact(T)) for name, T in targets),
        carried=tuple(Carried(one.body, compact(one.track), 0, 0) for one in parts),
        fixed=tuple((body, compact(T)) for body, T in around),
        centre=centre,
        size=size,
        floor=floor,
    )


def _beginning(job: Job, robot: Robot) -> JointVector:
    """(n,) where a job begins, as far as that is known without a plan."""
    if robot.mechanism.loops:
        return resting_configuration(robot.mechanism)
    if job.start.joints is not None:
        return coordinates(job, robot, job.start.joints)
    if job.start.pose is not None:
        T = pose_matrix(job.start.pose, degrees=job.angles == "degrees")
        found = inverse_kinematics(robot, T, q0=starting_place(robot), task=job.start.pose.task)
        if len(found):
            return np.asarray(found.q[0])
    return starting_place(robot)


@dataclass(frozen=True, eq=False)
class Part:
    """A thing that is picked, or a tool.

    Attributes:
        body: its solid.
        track: (frames, 4, 4) its pose in {s}.
        first, end: frames in which the tip carries it: from `first` on, before `end`.
    """

    body: Body
    track: Floats
    first: int
    end: int

    def lying(self) -> list[tuple[Body, Floats]]:
        """Where it lies before the first frame that moves it and after the last one, unless the tip has it then."""
        frames = [0] * (self.first > 0 or self.end == 0) + [-1] * (self.end < len(self.track))
        return [(self.body, self.track[k]) for k in frames]


def part_tracks(run: Run, moments: Floats) -> list[Part]:
    """Each thing that is picked, with its pose at each moment: waiting where the plan takes it, carried, left.

    1. Where it waits: where the plan takes it; where it was left, if it was taken before.
    2. While it is carried it stays in the tip as the plan takes it; then it lies where the tip was.

    Args:
        run: what happened.
        moments: (frames,) times [s].
    """
    found: dict[int, Part] = {}
    starts, legs, t = run.plan.starts, run.plan.legs, run.recording.t
    tips, _ = run.tips(np.minimum(np.searchsorted(t, np.minimum(moments, t[-1])), len(t) - 1))
    taken = {one.stretch.first - 1 for one in run.passed if one.gripped}
    for k, leg in enumerate(legs):
        grasp = run.job.move[leg.index].pick if leg.kind == "pick" else None
        if grasp is None:
            continue
        T_tip = np.asarray(leg.load.robot.forward_kinematics(leg.trajectory.at(leg.trajectory.duration).u))
        known = found.get(leg.thing)
        # 1
        lying = T_tip @ box_in_tip(grasp) if known is None else known.track[-1]
        track = np.tile(lying, (len(moments), 1, 1)) if known is None else known.track.copy()
        begin = end = 0
        if k in taken:
            # 2
            until = next((j for j in range(k + 1, len(legs)) if legs[j].kind == "place"), None)
            begin = int(np.searchsorted(moments, float(starts[k + 1])))
            end = len(moments) if until is None else int(np.searchsorted(moments, float(starts[until + 1])))
            in_tip = pose.compose(pose.inverse(T_tip), lying)
            track[begin:end] = tips[begin:end] @ in_tip
            track[end:] = tips[min(end, len(tips)) - 1] @ in_tip
        body = Body(grasp.name, (Solid("box", grasp.size, colour=PART_COLOUR),)) if known is None else known.body
        carried = (begin, end) if known is None else (0, 0)
        found[leg.thing] = Part(body, track, *carried)
    return list(found.values())


def tool_tracks(run: Run, moments: Floats) -> list[Part]:
    """Each tool with a box, with its pose at each moment: on the flange, else where it was taken or left.

    Args:
        run: what happened.
        moments: (frames,) times [s].
    """
    legs, t = run.plan.legs, run.recording.t
    tips, _ = run.tips(np.minimum(np.searchsorted(t, np.minimum(moments, t[-1])), len(t) - 1))
    at = run.plan.legs_at(moments)
    found: list[Part] = []
    for equipment in dict.fromkeys(leg.load.equipment for leg in legs):
        mounted = np.flatnonzero(np.array([leg.load.equipment is equipment for leg in legs])[at])
        if equipment.tool.size is None or not len(mounted):
            continue
        begin, end = int(mounted[0]), int(mounted[-1]) + 1
        # The frame before each moment at which it was on the flange; the first one before it ever was.
        latest = mounted[np.maximum(np.searchsorted(mounted, np.arange(len(moments)), "right") - 1, 0)]
        body = Body(equipment.name or UNNAMED_TOOL, (Solid("box", equipment.tool.size, colour=TOOL_COLOUR),))
        interval = (begin, end) if len(mounted) == end - begin else (0, 0)
        found.append(Part(body, tips[latest] @ box_of_tool(equipment), *interval))
    return found


def _neighbours(run: Run, moments: Floats, floor: float) -> tuple[list[Part], list[tuple[Body, Floats]]]:
    """Links of other robots: of those that move with their poses at each moment, of those that stand with one."""
    moving: list[Part] = []
    standing: list[tuple[Body, Floats]] = []
    for one in run.plan.neighbours:
        poses = one.poses(moments[:1] if one.neighbour.stands else moments)
        for k, body in enumerate(Drawing(one.neighbour.robot.mechanism).bodies(floor, poses[0])):
            if one.neighbour.stands:
                standing.append((body, poses[0, k]))
            else:
                moving.append(Part(body, poses[:, k], 0, 0))
    return moving, standing


def _lowest(part: Part) -> float:
    """Height of the lowest corner of a box on its way [m]."""
    half = np.array(part.body.solids[0].size) / 2
    return float((part.track[:, 2, 3] - np.abs(part.track[:, 2, :3]) @ half).min())


def drawn(obstacles: Iterable[Obstacle], size: float, seen: Floats) -> list[tuple[Body, Floats]]:
    """Each obstacle with its pose; a half space is a flat plate under the scene, wider than it.

    Args:
        obstacles: of the run.
        size: radius of the scene [m].
        seen: (k, 3) points of the scene.
    """
    return [(Body(each.name, (_solid(each, size, seen),)), np.asarray(each.T_so)) for each in obstacles]


def _solid(obstacle: Obstacle, size: float, seen: Floats) -> Solid:
    """One obstacle in its own frame."""
    match obstacle.geometry:
        case Box(size=edges):
            return Solid("box", edges, colour=OBSTACLE_COLOUR)
        case Sphere(radius=radius):
            return Solid("sphere", (radius,), colour=OBSTACLE_COLOUR)
        case Cylinder(radius=radius, length=length):
            return Solid("cylinder", (radius, length), colour=OBSTACLE_COLOUR)
        case Capsule(radius=radius, length=length):
            return Solid("capsule", (radius, length), colour=OBSTACLE_COLOUR)
        case Cone(radius=radius, length=length):
            return _hull(_points_of_cone(radius, length))
        case ConvexHull(points=points):
            return _hull(points)
        case TriangleMesh(vertices=vertices, faces=faces):
            return _surface(Surface(vertices, faces))
        case PointCloud(points=points, radius=radius):
            return _surface(_balls(points, radius))
        case HeightMap() as ground:
            return _surface(_ground(ground))
        case _:
            thin = THIN * size
            (x, y), (a, b) = (each.tolist() for each in patch(np.asarray(obstacle.T_so), seen, WIDE * size))
            return Solid("box", (a, b, thin), (x, y, -thin / 2, 1.0, 0.0, 0.0, 0.0), OBSTACLE_COLOUR)


def _surface(surface: Surface) -> Solid:
    return Solid("surface", (), colour=OBSTACLE_COLOUR, surface=decimate(surface, MOST_TRIANGLES))


def _hull(points: Floats) -> Solid:
    """The hull of points; of flat ones, which have none, the box around them."""
    surface = hull_surface(points)
    if surface is not None:
        return _surface(surface)
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = ((low + high) / 2).tolist()
    a, b, c = np.maximum(high - low, FLAT).tolist()
    return Solid("box", (a, b, c), (x, y, z, 1.0, 0.0, 0.0, 0.0), OBSTACLE_COLOUR)


def _points_of_cone(radius: float, length: float) -> Floats:
    """(k, 3) of its base and its apex [m]."""
    angles = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    base = np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(SIDES, -length / 2.0)], axis=1)
    return np.concatenate([base, [[0.0, 0.0, length / 2.0]]])


def _balls(points: Floats, radius: float) -> Surface:
    """An octahedron for each ball of a cloud, of a large one for some of them."""
    some = points[_some(len(points), MOST_POINTS)]
    corners = some[:, None] + radius * OCTAHEDRON
    faces = EIGHT_FACES + len(OCTAHEDRON) * np.arange(len(some))[:, None, None]
    return Surface(corners.reshape(-1, 3), faces.reshape(-1, 3))


def _ground(ground: HeightMap) -> Surface:
    """Top and sides of a height map, of a fine one every few rows and columns."""
    (rows, columns), (width, depth) = ground.heights.shape, ground.size
    i, j = _some(rows, MOST_ROWS), _some(columns, MOST_ROWS)
    x, y = np.meshgrid(np.linspace(-width / 2, width / 2, columns)[j], np.linspace(-depth / 2, depth / 2, rows)[i])
    top = np.stack([x, y, ground.heights[np.ix_(i, j)]], axis=2)
    number = np.arange(len(i) * len(j)).reshape(len(i), len(j))
    faces = _quads(number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    rim = np.concatenate([number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]])
    after, low = np.roll(rim, -1), number.size + np.arange(len(rim))
    under = top.reshape(-1, 3)[rim] * [1.0, 1.0, 0.0] + [0.0, 0.0, ground.base]
    sides = _quads(rim, low, np.roll(low, -1), after)
    return Surface(np.concatenate([top.reshape(-1, 3), under]), np.concatenate([faces, sides]))


def _some(count: int, most: int) -> Integers:
    """Numbers below a count, evenly, the first and the last among them."""
    found: Floats = np.linspace(0.0, count - 1.0, min(count, most))
    return found.round().astype(np.int64)


def _quads(
    *corners: np.ndarray[tuple[int, ...], np.dtype[np.int64]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """(2 k, 3) triangles of quadrilaterals whose corners go round."""
    a, b, c, d = (np.ravel(each) for each in corners)
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
