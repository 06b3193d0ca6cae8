"""What a report page shows, as plain data: numbers already chosen, texts already in the reader's language."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from mafsil.arrays import Floats
from mafsil.robot import Robot
from mafsil.scene.drawing import Body

Level: TypeAlias = Literal["good", "warning", "failure"]
"""How good the news is."""


@dataclass(frozen=True, slots=True)
class Figure:
    """One number that matters, with its unit and a remark."""

    label: str
    value: str
    unit: str = ""
    note: str = ""
    level: Level = "good"


@dataclass(frozen=True, slots=True)
class Finding:
    """A sentence about the run, and when that was [s]; None where it is of all of it."""

    level: Level
    text: str
    time: float | None = None


@dataclass(frozen=True, slots=True)
class Step:
    """A stretch of the run: one move, one pause, one action of the gripper.

    Attributes:
        name, kind: as the job calls it.
        start, end: [s].
        text: how it went.
        level: whether it went well.
        beside: whether another robot makes it meanwhile; the replay and the plots follow the robot of the job.
    """

    name: str
    kind: str
    start: float
    end: float
    text: str = ""
    level: Level = "good"
    beside: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Plot:
    """One quantity of all joints, or of what `names` says, over time.

    Attributes:
        column: the quantity's name in tables, such as `tau`.
        title, unit: of the quantity.
        values: (rows, n), at the page's times.
        limits: (n, 2) lower and upper bound, infinite where there is none; None for a quantity without bounds.
        names: of the curves; empty for the joints.
        keys: of several curves with names, in tables.
    """

    column: str
    title: str
    unit: str
    values: Floats
    limits: Floats | None = None
    names: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Carried:
    """A thing that is picked, carried and put down; or, carried in no frame, a link of another robot.

    Attributes:
        body: its solids.
        poses: (frames, 7) position and quaternion (w, x, y, z) in {s}.
        first, end: frames in which the tip carries it: from `first` on, before `end`.
    """

    body: Body
    poses: Floats
    first: int
    end: int


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """What moves in the replay.

    Attributes:
        bodies: of the robot's links.
        period: time between two frames [s].
        times: (frames,) [s].
        q: (frames, n) coordinates of the robot [rad | m].
        tips, references: (frames, 7) pose of the tip, and where it should be.
        targets: poses worth marking: name, (7,).
        carried: what is picked, and links of other robots that move.
        fixed: what stands around, with its pose (7,).
        centre: (3,) middle of the scene [m].
        size: radius of the scene [m].
        floor: height of the floor [m].
        forces: (frames, 3) what touches the tip exerts on it, in its frame [N]; None where nothing can.
    """

    bodies: tuple[Body, ...]
    period: float
    times: Floats
    q: Floats
    tips: Floats
    references: Floats
    targets: tuple[tuple[str, Floats], ...]
    carried: tuple[Carried, ...]
    fixed: tuple[tuple[Body, Floats], ...]
    centre: tuple[float, float, float]
    size: float
    floor: float
    forces: Floats | None = None


@dataclass(frozen=True, slots=True)
class Details:
    """A titled list of label and value; `text` is shown word for word instead, if given."""

    title: str
    pairs: tuple[tuple[str, str], ...] = ()
    text: str = ""
    open: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    """A table of texts; numbers among them are isolated left to right."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False, slots=True)
class Page:
    """The whole page.

    Attributes:
        language: `en` or `ar`.
        title, subtitle: headline and the line under it.
        verdict: how the run went, in a few words.
        duration: of the run [s].
        robot: with its tool, empty-handed; the page computes with its kernels.
        recipe: lines of Python that do the run again, so that `run.robot` is this robot.
        scene: the replay.
        times: (rows,) [s], of all plots.
        joints: names of the joints, in the order of the plots' columns.
        plots, figures, findings, steps: see their classes.
        joint_table: peaks against limits, joint by joint.
        limit_table: what limits the cycle, and what more of it would save.
        details: provenance, the job, versions.
        variation_table, variation_findings: many runs of the job; None and empty where it was driven once.
    """

    language: str
    title: str
    subtitle: str
    verdict: Finding
    duration: float
    robot: Robot
    recipe: tuple[str, ...]
    scene: Scene
    times: Floats
    joints: tuple[str, ...]
    plots: tuple[Plot, ...]
    figures: tuple[Figure, ...]
    findings: tuple[Finding, ...]
    steps: tuple[Step, ...]
    joint_table: Table
    limit_table: Table
    details: tuple[Details, ...] = field(default=())
    variation_table: Table | None = None
    variation_findings: tuple[Finding, ...] = ()
