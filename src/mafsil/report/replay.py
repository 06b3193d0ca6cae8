"""What the replay of a run shows: the coordinates of the arm over time, what it carries, what stands around it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats
from mafsil.geometry import pose
from mafsil.job import Job, Run
from mafsil.job.equipment import UNNAMED_TOOL, box_of_tool
from mafsil.job.payload import box_in_tip
from mafsil.report.content import Carried, Scene
from mafsil.report.obstacles import drawn
from mafsil.report.shelves import shelves
from mafsil.report.touched import doors, standing
from mafsil.scene import Body, Drawing, Solid, compact

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
    surroundings = run.plan.surroundings
    around = [] if surroundings is None else drawn(surroundings.obstacles, size, seen)
    around += standing(run, size, tips[:, :3, 3])
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
    )


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
    at = np.clip(np.searchsorted(run.plan.starts, moments, side="right") - 1, 0, len(legs) - 1)
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
