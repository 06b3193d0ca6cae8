"""What a job file may say: frames, named poses and configurations, patterns and loops. The field names are the keys."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from mafsil.job.language.description import BranchChoice, Four, Grasp, Head, Obstacle, Part, Step, Task, Three
from mafsil.job.language.part import Test
from mafsil.job.language.surrounding_tables import OtherAction, OtherPlace, PlacedConstraints

Count: TypeAlias = Annotated[int, msgspec.Meta(ge=1, le=100_000)]


class Placed(Part, frozen=True, kw_only=True):
    """A pose in a frame: position and one of rpy, quaternion (w, x, y, z) and look_at.

    Attributes:
        position: [m]; in a frame its origin if left out.
        rpy, quaternion: of the orientation; in a frame that of the frame if neither is there.
        look_at: the point that the z axis points to, the x axis level, in the same frame [m].
        frame: name of a frame, or of a pattern inside a loop over it; {s} if None.
    """

    position: Three = (0.0, 0.0, 0.0)
    rpy: Three | None = None
    quaternion: Four | None = None
    look_at: Three | None = None
    frame: str | None = None


class MovableFrame(Placed, frozen=True, kw_only=True):
    """A frame, standing or moving.

    Attributes:
        velocity: of its origin, along the axes of the frame in which it is given [m/s].
        angular_speed: about its z axis [rad/s].
        since: an input: the frame is at its pose when that last became true; at the beginning of the job if None.
        robot: another robot, on whose TCP the frame is.
    """

    velocity: Three = (0.0, 0.0, 0.0)
    angular_speed: float = 0.0
    since: str | None = None
    robot: str = ""

    @property
    def moves(self) -> bool:
        """Whether it moves."""
        return self.travels or self.robot != ""

    @property
    def travels(self) -> bool:
        """Whether it moves of itself."""
        return any(self.velocity) or self.angular_speed != 0.0


class PlacedGoal(Placed, frozen=True, kw_only=True):
    """A pose to be reached, or a displacement.

    Attributes:
        task: what of it counts, see `Goal`.
        relative: a displacement from where the tip is then, along the axes of the `tool`, of `space` or of a frame.
        branch: which of the configurations is taken, such as `{ elbow = "up" }`.
    """

    task: Task = "pose"
    relative: str | None = None
    branch: BranchChoice | None = None


class PlacedObstacle(Obstacle, frozen=True, kw_only=True):
    """A body in a frame.

    Attributes:
        frame: name of a frame; {s} if None.
    """

    position: Three = (0.0, 0.0, 0.0)
    frame: str | None = None


class Pattern(Placed, frozen=True, kw_only=True):
    """Places in rows, columns and layers along x, y and z of its pose, or those of a file.

    Attributes:
        count: how many along x; along x and y; along x, y and z.
        pitch: from one to the next, for each of them [m].
        order: `rows`: x runs fastest, always forwards; `snake`: every second row backwards.
        file: CSV with columns x, y, z in its frame, in the units of the job, and perhaps roll, pitch, yaw; the position
            is added, and the orientation is that of each place.
    """

    count: tuple[Count, ...] = ()
    pitch: tuple[float, ...] = ()
    file: str | None = None
    order: Literal["rows", "snake"] = "rows"


class Statement(Step, frozen=True, kw_only=True, rename={"if_": "if", "else_": "else", "while_": "while"}):
    """A move, a loop or a choice: exactly one of joints, pose, pick, place, tool, pause, set, wait, do, call and if.

    Attributes:
        joints: goal in joint coordinates, or the name of a configuration.
        pose: goal of the tip, or the name of a pose.
        via: points to pass through without stopping, or names of such.
        through: a pattern whose places a spline passes through, in their order; the last is its goal.
        pick: what is taken, or the name of a part.
        constraints: what the tip keeps on the way.
        do: moves that are repeated.
        call: name of a group, whose moves are made here, once or as `do` is.
        each: a pattern, or several of equally many places: `do` for each place, whose frame has the pattern's name.
        repeat: how often; with `while` at most.
        while_: tests of signals and variables, looked at before each round: where one does not hold, the loop ends.
        if_: tests of signals and variables: where all hold, `then` is done.
        then: moves.
        else_: moves that are made where they do not all hold.
    """

    joints: tuple[float, ...] | str | None = None
    pose: PlacedGoal | str | None = None
    via: tuple[tuple[float, ...] | Placed | str, ...] = ()
    through: str | None = None
    pick: Grasp | str | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    constraints: PlacedConstraints | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    do: tuple[Statement, ...] | None = None
    call: str | None = None
    each: str | tuple[str, ...] | None = None
    repeat: Count | None = None
    while_: dict[str, Test] = msgspec.field(default_factory=dict[str, Test])
    if_: dict[str, Test] = msgspec.field(default_factory=dict[str, Test])
    then: tuple[Statement, ...] | None = None
    else_: tuple[Statement, ...] | None = None


class OtherStatement(OtherAction, frozen=True, kw_only=True, rename={"if_": "if", "else_": "else", "while_": "while"}):
    """A move of another robot, a loop or a choice: exactly one of joints, pose, pause, set, wait, do and if.

    Attributes:
        do: moves that are repeated.
        repeat: how often; with `while` at most.
        while_: tests of signals and variables, looked at before each round: where one does not hold, the loop ends.
        if_: tests of signals and variables: where all hold, `then` is done.
        then: moves.
        else_: moves that are made where they do not all hold.
    """

    do: tuple[OtherStatement, ...] | None = None
    repeat: Count | None = None
    while_: dict[str, Test] = msgspec.field(default_factory=dict[str, Test])
    if_: dict[str, Test] = msgspec.field(default_factory=dict[str, Test])
    then: tuple[OtherStatement, ...] | None = None
    else_: tuple[OtherStatement, ...] | None = None


class OtherProgram(OtherPlace, frozen=True, kw_only=True):
    """A robot beside the one of the job.

    Attributes:
        move: one after the other, loops and choices among them; none if it only stands there.
    """

    move: tuple[OtherStatement, ...] = ()


class PlacedStart(Part, frozen=True, kw_only=True):
    """Where the robot begins, at rest: joints, or a pose; either may be a name.

    If neither, zero, moved into the middle 70 % of each range; a bent configuration near it if the arm is singular
    there.

    Attributes:
        tool: name of the tool that is mounted; `[tool]` if None.
    """

    joints: tuple[float, ...] | str | None = None
    pose: PlacedGoal | str | None = None
    tool: str | None = None


class LyingPart(Grasp, frozen=True, kw_only=True):
    """A part by its name, and where it lies.

    Attributes:
        at: pose of the centre of its box at the beginning; of a name one part at each place of the pattern. If None,
            a new part is taken wherever none lies.
    """

    at: Placed | str | None = None


class JobFile(Head, frozen=True, kw_only=True):
    """A whole job file.

    Attributes:
        start: where the robot begins.
        frame: frames by name, each in {s} or in another one, standing or moving.
        pose: poses by name.
        configuration: joint coordinates by name.
        pattern: places by name.
        part: what can be picked, by name.
        group: moves that are made where a move calls them, by name.
        obstacle: what stands around the arm.
        other_robot: robots beside it.
        move: what it does.
    """

    start: PlacedStart = PlacedStart()
    frame: dict[str, MovableFrame] = msgspec.field(default_factory=dict[str, MovableFrame])
    pose: dict[str, PlacedGoal] = msgspec.field(default_factory=dict[str, PlacedGoal])
    configuration: dict[str, tuple[float, ...]] = msgspec.field(default_factory=dict[str, tuple[float, ...]])
    pattern: dict[str, Pattern] = msgspec.field(default_factory=dict[str, Pattern])
    part: dict[str, LyingPart] = msgspec.field(default_factory=dict[str, LyingPart])
    group: dict[str, tuple[Statement, ...]] = msgspec.field(default_factory=dict[str, tuple[Statement, ...]])
    obstacle: tuple[PlacedObstacle, ...] = ()
    other_robot: tuple[OtherProgram, ...] = ()
    move: tuple[Statement, ...]
