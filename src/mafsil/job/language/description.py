"""What is to be done, as typed data: moves one after the other, poses in {s}.

Job files say it with frames, names and patterns (`mafsil.job.language`); the field names are the keys of the file.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from mafsil.job.language.driving_tables import TIP_LAWS as TIP_LAWS
from mafsil.job.language.driving_tables import Controller as Controller
from mafsil.job.language.driving_tables import Disturbance as Disturbance
from mafsil.job.language.driving_tables import LawKind as LawKind
from mafsil.job.language.driving_tables import Noise as Noise
from mafsil.job.language.driving_tables import Simulation as Simulation
from mafsil.job.language.driving_tables import Track as Track
from mafsil.job.language.driving_tables import VariationTable
from mafsil.job.language.part import Condition, Fork, Input, PathOutput, SignalValue, Six
from mafsil.job.language.part import Four as Four
from mafsil.job.language.part import NotNegative as NotNegative
from mafsil.job.language.part import Part as Part
from mafsil.job.language.part import Pose as Pose
from mafsil.job.language.part import Positive as Positive
from mafsil.job.language.part import Share as Share
from mafsil.job.language.part import Three as Three
from mafsil.job.language.surrounding_tables import Collision as Collision
from mafsil.job.language.surrounding_tables import Door as Door
from mafsil.job.language.surrounding_tables import Guide as Guide
from mafsil.job.language.surrounding_tables import Hole as Hole
from mafsil.job.language.surrounding_tables import Obstacle as Obstacle
from mafsil.job.language.surrounding_tables import OtherRobot, PathConstraints
from mafsil.job.language.surrounding_tables import PlannerName as PlannerName
from mafsil.job.language.surrounding_tables import SceneFile as SceneFile
from mafsil.job.language.surrounding_tables import Surface as Surface
from mafsil.trajectory.profiles.laws import LawName

Profile: TypeAlias = LawName | Literal["time_optimal", "jerk_limited"]
"""How a move spends its time: a law, or the shortest time along its path, or with limited jerk."""
QUICKEST = ("time_optimal", "jerk_limited")
"""The profiles of the shortest time: they pass points on the way and round corners."""
PathKind: TypeAlias = Literal["joint", "line", "arc", "spline", "screw"]
TIP_PATHS: tuple[PathKind, ...] = ("line", "arc", "spline", "screw")
"""Paths of the tip: their goal is a pose."""
Task: TypeAlias = Literal["pose", "axis", "position"]
Variable: TypeAlias = bool | float | str | tuple[float, ...]


class BranchChoice(Part, frozen=True, kw_only=True):
    """Which of the configurations for a pose: what is left out may be anything.

    Attributes:
        shoulder, elbow, wrist: names of branches, as inverse kinematics gives them.
    """

    shoulder: Literal["left", "right"] | None = None
    elbow: Literal["up", "down", "in", "out"] | None = None
    wrist: Literal["flip", "noflip"] | None = None


class Goal(Pose, frozen=True, kw_only=True):
    """A pose to be reached, and what of it counts.

    Attributes:
        task: `pose`: all of it; `axis`: the position, and the direction of the tip's z axis; `position` alone.
            What does not count is left to the arm.
        relative: a displacement instead, from where the tip is then, along its own axes (`tool`) or those of {s}
            (`space`).
        branch: which of the configurations is taken; the nearest that the plan allows if None.
        carrier: name of the moving frame in which the pose is; {s} if None.
    """

    task: Task = "pose"
    relative: Literal["tool", "space"] | None = None
    branch: BranchChoice | None = None
    carrier: str | None = None


UNNAMED = "part"
"""What a part is called that has no name."""


class Grasp(Part, frozen=True, kw_only=True):
    """A box that the tool takes.

    Attributes:
        mass: [kg].
        size: edge lengths [m].
        offset: its centre in the tip frame [m].
        com: centre of mass, from the centre of the box, along the axes of the tip frame [m].
        inertia: about the centre of mass, along the axes of the tip frame: xx, yy, zz, then perhaps xy, xz, yz; of an
            even box if None [kg m^2].
        known: whether the controller knows the mass.
    """

    name: str = UNNAMED
    mass: NotNegative
    size: tuple[Positive, Positive, Positive] = (0.05, 0.05, 0.05)
    offset: Three = (0.0, 0.0, 0.0)
    com: Three = (0.0, 0.0, 0.0)
    inertia: Annotated[tuple[float, ...], msgspec.Meta(min_length=3, max_length=6)] | None = None
    known: bool = True


class Tolerance(Part, frozen=True, kw_only=True):
    """How near a target has to be reached; what is left out is taken from the job, then from the defaults.

    Attributes:
        position: of the tip [m]; 1 mm.
        orientation: of the tip [rad, or degrees]; 0.5 degrees.
        joints: of a goal in joint coordinates, one number for all revolute joints [rad, or degrees], or one per joint
            [m for prismatic ones]; `orientation` for revolute joints and `position` for prismatic ones if left out.
    """

    position: Positive | None = None
    orientation: Positive | None = None
    joints: Positive | tuple[Positive, ...] | None = None


class Step(Part, frozen=True, kw_only=True):
    """How a move is made, whatever its goal.

    Attributes:
        name: for the report and for errors.
        path: `joint`: all joints together; of the tip: `line`, straight; `arc`, on a circle over one point; `spline`,
            smoothly through points; `screw`, about one screw axis.
        blend: how far from the goal the tip may pass when it goes on to the next path of the tip without a stop [m];
            0 stops there.
        profile: law of motion in time; `time_optimal`: the shortest time along the path; `jerk_limited`: the same with
            limited jerk. If None the shortest time with what the description knows of jerk, but a quintic where a
            duration suits it or the controller lags behind accelerations.
        duration: [s]; the shortest within the limits if left out.
        speed: share of the limits for this move.
        tip_speed, tip_acceleration, tip_angular_speed: of a path of the tip, instead of the job's [m/s, m/s^2, rad/s].
        tip_jerk: along a straight line, instead of the job's [m/s^3].
        joint_speed, joint_acceleration, joint_jerk: that no revolute joint exceeds on this move [rad/s, rad/s^2,
            rad/s^3].
        pick: take something: the tool closes, its mass hangs on the tip from then on.
        tool: change to a tool, by its name.
        place: let go of it.
        pause: rest [s].
        set: values that outputs take.
        outputs: that take values while the move is under way.
        process_wrench: (m, f) of the process on the tip while the move is under way, in the tip frame [N m, N].
        process_known: whether the controller compensates it; laws of the tip do not.
        until: conditions on signals, all of them: where they hold the move ends early.
        until_force: of contact at the tip, at which the move ends early [N].
        wait: conditions on signals, all of them: rest until they hold.
        timeout: longest wait [s]; what does not come within it is a refusal.
        hold: time that pick, place and a change of tools take [s].
        avoid: whether a move of the joints goes round what stands in its way; as the job says if None.
        planner: that searches the way round; that of the job if None.
        clearance: that it keeps, if another than the job's [m].
        constraints: what the tip keeps on the way; the way is planned then, round what stands in it.
        tolerance: of this move, if another than the job's.
    """

    name: str = ""
    path: PathKind = "joint"
    blend: NotNegative = 0.0
    profile: Profile | None = None
    duration: Positive | None = None
    speed: Share = 1.0
    tip_speed: Positive | None = None
    tip_acceleration: Positive | None = None
    tip_angular_speed: Positive | None = None
    joint_speed: Positive | None = None
    tip_jerk: Positive | None = None
    joint_acceleration: Positive | None = None
    joint_jerk: Positive | None = None
    pick: Grasp | None = None
    place: bool = False
    tool: str | None = None
    pause: Positive | None = None
    set: dict[str, SignalValue] = msgspec.field(default_factory=dict[str, SignalValue])
    outputs: tuple[PathOutput, ...] = ()
    process_wrench: Six | None = None
    process_known: bool = True
    until: dict[str, Condition] = msgspec.field(default_factory=dict[str, Condition])
    until_force: Positive | None = None
    wait: dict[str, Condition] = msgspec.field(default_factory=dict[str, Condition])
    timeout: Positive | None = None
    hold: NotNegative = 0.3
    avoid: bool | None = None
    planner: PlannerName | None = None
    clearance: NotNegative | None = None
    constraints: PathConstraints | None = None
    tolerance: Tolerance | None = None


class Move(Step, frozen=True, kw_only=True):
    """One step: exactly one of joints, pose, pick, place, tool, pause, set, wait and fork.

    Attributes:
        joints: goal in joint coordinates.
        pose: goal of the tip.
        via: points to pass through without stopping: joint coordinates on a joint path, poses on an arc or a spline.
        fork: whether the moves after it are made.
        skip: moves that are passed over after this one: those of the other way.
    """

    joints: tuple[float, ...] | None = None
    pose: Goal | None = None
    via: tuple[tuple[float, ...] | Pose, ...] = ()
    fork: Fork | None = None
    skip: int = 0

    @property
    def carried(self) -> bool:
        """Whether its goal is in a moving frame."""
        return self.pose is not None and self.pose.carrier is not None

    @property
    def stays(self) -> bool:
        """Whether the arm stands still, and has the same tool afterwards."""
        return self.joints is None and self.pose is None and self.tool is None


class Start(Part, frozen=True, kw_only=True):
    """Where the robot begins, at rest: joints, or a pose.

    If neither, zero, moved into the middle 70 % of each range; a bent configuration near it if the arm is singular
    there.

    Attributes:
        tool: name of the tool that is mounted; `[tool]` if None.
    """

    joints: tuple[float, ...] | None = None
    pose: Goal | None = None
    tool: str | None = None


class Tool(Part, frozen=True, kw_only=True):
    """What is mounted on the flange.

    Attributes:
        link: on which it is mounted, in its frame; the flange, which is the tip frame of the description, if None.
        offset: pose of the tool's tip, the TCP, in the frame on which it is mounted; that frame itself if None.
        mass: of the tool [kg], a point at `com` in that frame [m].
        size: edge lengths of a box around it, along the axes of that frame, that is drawn and meets things [m].
        centre: of that box, in that frame [m].
    """

    link: str | None = None
    offset: Pose | None = None
    mass: NotNegative = 0.0
    com: Three = (0.0, 0.0, 0.0)
    size: tuple[Positive, Positive, Positive] | None = None
    centre: Three = (0.0, 0.0, 0.0)


TIP_BOUNDS = ("tip_speed", "tip_acceleration", "tip_angular_speed", "tip_jerk")
"""Limits of paths of the tip, of the job and of each move."""
JOINT_BOUNDS = ("joint_speed", "joint_acceleration", "joint_jerk")
"""Limits of the revolute joints of each move."""


class Bounds(Part, frozen=True, kw_only=True):
    """How hard the robot may be driven.

    Attributes:
        speed_scale, acceleration_scale: of the robot's own limits.
        velocity, acceleration: bounds of joints where the description has none, one number for all or one per joint, in
            the units of the file; 2 and 5 [rad/s | m/s, rad/s^2 | m/s^2] if None.
        jerk: the same of moves with limited jerk; 50 [rad/s^3 | m/s^3] if None.
        tip_speed, tip_acceleration: of paths of the tip [m/s, m/s^2].
        tip_angular_speed: of paths of the tip [rad/s].
        tip_jerk: along straight lines; not limited if None [m/s^3].
    """

    speed_scale: Share = 0.7
    acceleration_scale: Share = 0.7
    velocity: Positive | tuple[Positive, ...] | None = None
    acceleration: Positive | tuple[Positive, ...] | None = None
    jerk: Positive | tuple[Positive, ...] | None = None
    tip_speed: Positive = 0.25
    tip_acceleration: Positive = 1.0
    tip_angular_speed: Positive = 1.0
    tip_jerk: Positive | None = None


class Report(Part, frozen=True, kw_only=True):
    """What the report looks like.

    Attributes:
        language: `en` or `ar`; the language of the command if None.
        frame_rate: of the replay [1/s].
        rows: most rows of a plot.
        megabytes: size that the files of results should not exceed: a longer recording holds every m-th tick.
    """

    language: Literal["en", "ar"] | None = None
    frame_rate: Annotated[float, msgspec.Meta(ge=1, le=240)] = 50.0
    rows: Annotated[int, msgspec.Meta(ge=50, le=20000)] = 1500
    megabytes: Annotated[float, msgspec.Meta(ge=1)] = 20.0


class MovingFrame(msgspec.Struct, frozen=True, kw_only=True):
    """A frame that moves, such as that of a conveyor or a turntable.

    Attributes:
        pose: where it is at its time zero, in {s}.
        velocity: of its origin in {s} [m/s].
        angular_speed: about its z axis [rad/s].
        since: the input whose last change to true is its time zero; the beginning of the job if None.
        robot: on whose TCP it is instead, its pose there; empty of none.
    """

    pose: Pose
    velocity: Three
    angular_speed: float
    since: str | None
    robot: str = ""


class Cell(msgspec.Struct, frozen=True, kw_only=True):
    """A file that a job includes.

    Attributes:
        source: its path as it was typed.
        text: of it.
        gave: keys of the job that it gave, each with the keys under which they stand in it.
    """

    source: str
    text: str
    gave: tuple[tuple[tuple[str | int, ...], tuple[str | int, ...]], ...]


class Head(Part, frozen=True, kw_only=True):
    """All of a job but what is to be done.

    Attributes:
        include: paths of files with tables for this and other jobs, relative to the file.
        robot: name of the library, or path of a file.
        angles: unit of all angles of the file.
        lengths: unit of all lengths of the file, and of what is per length or per time.
        lock: joints that are locked, by name [rad, or degrees; m]; they are no coordinates of the arm then.
        variables: by name; `"$name"` anywhere in the file stands for its value.
        track: linear axes that carry the robot, the first one carries the others.
        tool: on the flange, unless the arm starts with another one.
        tools: that moves change to, by name.
        output: signals that moves set, by name, with the values that they begin with.
        input: signals that the cell gives, by name.
        surface, hole: what the tip can touch.
        door, guide: what holds it.
        variation: what differs if the job is driven many times; once if None.
    """

    title: str = ""
    include: str | tuple[str, ...] = ()
    robot: str
    angles: Literal["radians", "degrees"] = "radians"
    lengths: Literal["metres", "millimetres"] = "metres"
    variables: dict[str, Variable] = msgspec.field(default_factory=dict[str, Variable])
    lock: dict[str, float] = msgspec.field(default_factory=dict[str, float])
    track: tuple[Track, ...] = ()
    tool: Tool = Tool()
    tools: dict[str, Tool] = msgspec.field(default_factory=dict[str, Tool])
    output: dict[str, SignalValue] = msgspec.field(default_factory=dict[str, SignalValue])
    input: dict[str, Input] = msgspec.field(default_factory=dict[str, Input])
    limits: Bounds = Bounds()
    tolerance: Tolerance = Tolerance()
    controller: Controller = Controller()
    simulation: Simulation = Simulation()
    report: Report = Report()
    collision: Collision | None = None
    disturbance: tuple[Disturbance, ...] = ()
    surface: tuple[Surface, ...] = ()
    hole: tuple[Hole, ...] = ()
    door: tuple[Door, ...] = ()
    guide: tuple[Guide, ...] = ()
    variation: VariationTable | None = None


class Job(Head, frozen=True, kw_only=True):
    """A whole job: all lengths in metres but coordinates of prismatic joints, all poses in {s}.

    Attributes:
        start: where the robot begins.
        obstacle: what stands around it.
        other_robot: robots beside it.
        move: one after the other.
        origins: for each move the keys in the file that it comes from; empty if they are its own.
        cells: what the file includes.
        lying: parts that lie somewhere at the beginning, the poses of their boxes, and the moving frame that carries
            them, where it is at its time zero.
        moving: frames that move, by name.
    """

    moving: dict[str, MovingFrame] = msgspec.field(default_factory=dict[str, MovingFrame])
    lying: tuple[tuple[Grasp, Pose, str | None], ...] = ()
    start: Start = Start()
    obstacle: tuple[Obstacle, ...] = ()
    other_robot: tuple[OtherRobot, ...] = ()
    move: tuple[Move, ...]
    origins: tuple[tuple[str | int, ...], ...] = ()
    cells: tuple[Cell, ...] = ()

    @property
    def control_period(self) -> float:
        """Time between two evaluations of the control law [s]."""
        return self.simulation.step if self.controller.rate is None else 1.0 / self.controller.rate
