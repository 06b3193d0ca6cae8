"""What a report page shows, as plain data: numbers already chosen, texts already in the reader's language."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from mafsil.arrays import Floats
from mafsil.scene.solids import Body

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
    """A sentence about the run."""

    level: Level
    text: str


@dataclass(frozen=True, slots=True)
class Step:
    """A stretch of the run: one move, one pause, one action of the gripper.

    Attributes:
        name, kind: as the job calls it.
        start, end: [s].
        text: how it went.
        level: whether it went well.
    """

    name: str
    kind: str
    start: float
    end: float
    text: str = ""
    level: Level = "good"


@dataclass(frozen=True, eq=False, slots=True)
class Plot:
    """One quantity of all joints, or of what `names` says, over time.

    Attributes:
        title, unit: of the quantity.
        values: (rows, n), at the page's times.
        limits: (n, 2) lower and upper bound, infinite where there is none; None for a quantity without bounds.
        names: of the curves; empty for the joints.
    """

    title: str
    unit: str
    values: Floats
    limits: Floats | None = None
    names: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """What moves in the replay.

    Attributes:
        bodies: k bodies.
        period: time between two frames [s].
        poses: (frames, k, 7) position and quaternion (w, x, y, z) of each body in {s}.
        tips, references: (frames, 7) pose of the tip, and where it should be.
        targets: poses worth marking: name, (7,).
        centre: (3,) middle of the scene [m].
        size: radius of the scene [m].
        floor: height of the floor [m].
    """

    bodies: tuple[Body, ...]
    period: float
    poses: Floats
    tips: Floats
    references: Floats
    targets: tuple[tuple[str, Floats], ...]
    centre: tuple[float, float, float]
    size: float
    floor: float


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
        scene: the replay.
        times: (rows,) [s], of all plots.
        joints: names of the joints, in the order of the plots' columns.
        plots, figures, findings, steps: see their classes.
        joint_table: peaks against limits, joint by joint.
        details: provenance, the job, versions.
    """

    language: str
    title: str
    subtitle: str
    verdict: Finding
    duration: float
    scene: Scene
    times: Floats
    joints: tuple[str, ...]
    plots: tuple[Plot, ...]
    figures: tuple[Figure, ...]
    findings: tuple[Finding, ...]
    steps: tuple[Step, ...]
    joint_table: Table
    details: tuple[Details, ...] = field(default=())
