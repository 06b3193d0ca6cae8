"""What is to be done, as typed data: moves one after the other, poses in {s}.

Job files say it with frames, names and patterns (`mafsil.job.language`); the field names are the keys of the file.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from mafsil.job.other_robot import OtherRobot
from mafsil.job.part import Four as Four
from mafsil.job.part import NotNegative as NotNegative
from mafsil.job.part import Part as Part
from mafsil.job.part import Pose as Pose
from mafsil.job.part import Positive as Positive
from mafsil.job.part import Share as Share
from mafsil.job.part import Three as Three
from mafsil.job.variation_table import VariationTable
from mafsil.trajectory.laws import LawName

Profile: TypeAlias = LawName | Literal["time_optimal", "jerk_limited"]
"""How a move spends its time: a law, or the shortest time along its path, or with limited jerk."""
QUICKEST = ("time_optimal", "jerk_limited")
"""The profiles of the shortest time: they pass points on the way and round corners."""
PathKind: TypeAlias = Literal["joint", "line", "arc", "spline", "screw"]
TIP_PATHS: tuple[PathKind, ...] = ("line", "arc", "spline", "screw")
"""Paths of the tip: their goal is a pose."""
Task: TypeAlias = Literal["pose", "axis", "position"]
Six: TypeAlias = tuple[float, float, float, float, float, float]


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
    """

    task: Task = "pose"
    relative: Literal["tool", "space"] | None = None
    branch: BranchChoice | None = None


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


class Obstacle(Pose, frozen=True, kw_only=True):
    """A body that stands in {s}: exactly one of box, sphere, cylinder, capsule and floor.

    Attributes:
        name: for the report and for errors.
        box: edge lengths [m].
        sphere: radius [m].
        cylinder, capsule: radius and length along z [m]; a capsule's without its ends.
        floor: the half space below its frame.
    """

    name: str = ""
    box: tuple[Positive, Positive, Positive] | None = None
    sphere: Positive | None = None
    cylinder: tuple[Positive, Positive] | None = None
    capsule: tuple[Positive, Positive] | None = None
    floor: bool = False


class Collision(Part, frozen=True, kw_only=True):
    """How near the arm may come to obstacles and to itself.

    Attributes:
        clearance: that it keeps [m].
        avoid: moves of the joints go round what stands in their way, unless a move says otherwise.
        self_collision: whether the arm is checked against itself; if None, where the description has shapes.
        seed: of the search for ways round.
    """

    clearance: NotNegative = 0.0
    avoid: bool = False
    self_collision: bool | None = None
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0


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
        profile: law of motion in time, quintic if None; `time_optimal`: the shortest time along the path;
            `jerk_limited`: the same with limited jerk.
        duration: [s]; the shortest within the limits if left out.
        speed: share of the limits for this move.
        pick: take something: the tool closes, its mass hangs on the tip from then on.
        tool: change to a tool, by its name.
        place: let go of it.
        pause: rest [s].
        hold: time that pick, place and a change of tools take [s].
        avoid: whether a move of the joints goes round what stands in its way; as the job says if None.
        tolerance: of this move, if another than the job's.
    """

    name: str = ""
    path: PathKind = "joint"
    blend: NotNegative = 0.0
    profile: Profile | None = None
    duration: Positive | None = None
    speed: Share = 1.0
    pick: Grasp | None = None
    place: bool = False
    tool: str | None = None
    pause: Positive | None = None
    hold: NotNegative = 0.3
    avoid: bool | None = None
    tolerance: Tolerance | None = None


class Move(Step, frozen=True, kw_only=True):
    """One step: exactly one of joints, pose, pick, place, tool and pause.

    Attributes:
        joints: goal in joint coordinates.
        pose: goal of the tip.
        via: points to pass through without stopping: joint coordinates on a joint path, poses on an arc or a spline.
    """

    joints: tuple[float, ...] | None = None
    pose: Goal | None = None
    via: tuple[tuple[float, ...] | Pose, ...] = ()


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
        link: that carries the tip frame; the description's own tip if None.
        offset: pose of the tip frame in that link, if another than the description's.
        mass: of the tool [kg], a point at `com` in the link's frame [m].
        size: edge lengths of a box around it, along the axes of the link's frame, that is drawn and meets things [m].
        centre: of that box, in the link's frame [m].
    """

    link: str | None = None
    offset: Pose | None = None
    mass: NotNegative = 0.0
    com: Three = (0.0, 0.0, 0.0)
    size: tuple[Positive, Positive, Positive] | None = None
    centre: Three = (0.0, 0.0, 0.0)


class Bounds(Part, frozen=True, kw_only=True):
    """How hard the robot may be driven.

    Attributes:
        speed_share, acceleration_share: of the robot's own limits.
        velocity, acceleration: bounds for all joints where the description has none [rad/s | m/s and per s].
        jerk: the same of moves with limited jerk [rad/s^3 | m/s^3].
        tip_speed, tip_acceleration: of paths of the tip [m/s, m/s^2].
        tip_turn_rate: of paths of the tip [rad/s].
    """

    speed_share: Share = 0.7
    acceleration_share: Share = 0.7
    velocity: Positive = 2.0
    acceleration: Positive = 5.0
    jerk: Positive = 50.0
    tip_speed: Positive = 0.25
    tip_acceleration: Positive = 1.0
    tip_turn_rate: Positive = 1.0


class Surface(Part, frozen=True, kw_only=True):
    """A plane that the tip can touch: it gives way as spring and damper, and never pulls.

    Attributes:
        name: for the report and for errors.
        point: on it, in {s} [m].
        normal: out of it, towards the arm.
        stiffness, damping: [N/m, N s/m], whatever the unit of lengths.
        friction: coefficient of what slides along it.
    """

    name: str = ""
    point: Three
    normal: Three
    stiffness: Positive
    damping: NotNegative = 0.0
    friction: NotNegative = 0.0


LawKind: TypeAlias = Literal[
    "computed_torque", "pd_gravity", "pid", "feedforward", "sliding_mode", "min_max", "adaptive",
    "model_predictive", "linear_quadratic", "task_computed_torque", "impedance", "admittance", "hybrid",
]  # fmt: skip
"""Laws of the joints, then laws of the tip."""
TIP_LAWS: tuple[LawKind, ...] = ("task_computed_torque", "impedance", "admittance", "hybrid")


class Controller(Part, frozen=True, kw_only=True):
    """The law that drives the joints.

    Attributes:
        kind: `computed_torque`; `pd_gravity`, PD with gravity compensation; `pid` of each joint by itself;
            `feedforward` of the model with PD; `sliding_mode` and `min_max`, for masses known within a share;
            `adaptive`, which learns what the tool carries; `model_predictive`, which looks ahead and keeps efforts
            within their limits; `linear_quadratic`, of least cost about the middle of the motion. Of the tip:
            `task_computed_torque`; `impedance` and `admittance`, a tip that gives way; `hybrid`, motion along the first
            surface and force into it.
        frequency: natural frequency of the error dynamics of computed torque, in joints or at the tip, and of
            the motion of `hybrid`, 20 if None; of `model_predictive` away from limits 80, of `linear_quadratic` about
            its pose 40 if None [rad/s].
        damping: its damping ratio, or that of the tip's impedance; 1 if None.
        stiffness, rate_gain: of the PD and PID laws, one number or one per joint; from the inertia of each joint if
            None [N m/rad, N m s/rad].
        integral: gain of PID, likewise; a tenth of what would make it unstable if None [N m/(rad s)].
        mass_share: by which sliding mode takes every mass, and min-max all together, to be wrong; 0.2 if None.
        margin: effort of sliding mode for friction; what the model's friction asks for and 1 if None [N m | N].
        width: of the boundary layer; 0.02 if None [rad/s | m/s], of min-max 1 [N m/s | N/s].
        horizon: intervals that `model_predictive` looks ahead; 20 if None.
        interval: length of one; 0.005 if None [s].
        tip_stiffness, turn_stiffness: of impedance and admittance, against shifts and against rotations; if None, what
            makes the arm's inertia at the start swing with 20 rad/s [N/m, N m/rad].
        tip_mass, turn_inertia: of admittance; those of the arm at the start if None [kg, kg m^2].
        press: force of `hybrid` into the surface; 10 if None [N].
        force_gain, force_integral: of the error of that force; 0 and 10 if None [1, 1/s].
        learning: how fast the adaptive law learns; 1 if None.
        rate: how often the law is evaluated [Hz]; each simulation step if None.
        delay: from the measurement to the effort, a whole number of periods of the law [s].
    """

    kind: LawKind = "computed_torque"
    frequency: Positive | None = None
    damping: Positive | None = None
    stiffness: Positive | tuple[Positive, ...] | None = None
    rate_gain: Positive | tuple[Positive, ...] | None = None
    integral: NotNegative | tuple[NotNegative, ...] | None = None
    mass_share: NotNegative | None = None
    margin: NotNegative | tuple[NotNegative, ...] | None = None
    width: Positive | None = None
    horizon: Annotated[int, msgspec.Meta(ge=1, le=200)] | None = None
    interval: Positive | None = None
    learning: NotNegative | None = None
    tip_stiffness: Positive | None = None
    turn_stiffness: Positive | None = None
    tip_mass: Positive | None = None
    turn_inertia: Positive | None = None
    press: Positive | None = None
    force_gain: NotNegative | None = None
    force_integral: NotNegative | None = None
    rate: Positive | None = None
    delay: NotNegative = 0.0


class Noise(Part, frozen=True, kw_only=True):
    """Errors of the sensors: standard deviations, reproducible by the seed; of forces at the tip [N]."""

    position: NotNegative = 0.0
    velocity: NotNegative = 0.0
    force: NotNegative = 0.0
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0


class Simulation(Part, frozen=True, kw_only=True):
    """How the motion is simulated.

    Attributes:
        step: of the integrator [s].
        method: integrator; rk4 if None, or implicit_friction where the friction of light links is too stiff for the
            step. A method that is named is used or refused, never replaced.
        settle: time at rest after the last move [s].
        friction: whether the joints have the friction of the description.
        mass_error: the real masses are this much larger than the controller believes (0.1 is ten per cent).
        noise: of the sensors.
        plant: who computes the motion: `mafsil`, or `mujoco` where it is installed.
        real_time: every evaluation of the law begins when it is due, and those that come late are counted; a run takes
            as long as the motion.
    """

    step: Annotated[float, msgspec.Meta(ge=1e-6, le=0.1)] = 0.001
    method: Literal["rk4", "semi_implicit_euler", "implicit_friction"] | None = None
    settle: NotNegative = 0.3
    friction: bool = True
    mass_error: Annotated[float, msgspec.Meta(gt=-1, le=10)] = 0.0
    noise: Noise = Noise()
    plant: Literal["mafsil", "mujoco"] = "mafsil"
    real_time: bool = False


class Disturbance(Part, frozen=True, kw_only=True):
    """A push of the world on the tip.

    Attributes:
        start, duration: [s].
        wrench: (m, f) on the tip, in the tip frame [N m, N].
    """

    start: NotNegative
    duration: Positive
    wrench: Six


class SceneFile(Part, frozen=True, kw_only=True):
    """A file of obstacles alone.

    Attributes:
        angles: unit of its angles.
    """

    angles: Literal["radians", "degrees"] = "radians"
    obstacle: tuple[Obstacle, ...]


class Report(Part, frozen=True, kw_only=True):
    """What the report looks like.

    Attributes:
        language: `en` or `ar`; the language of the command if None.
        frame_rate: of the replay [1/s].
        rows: most rows of a plot.
    """

    language: Literal["en", "ar"] | None = None
    frame_rate: Annotated[float, msgspec.Meta(ge=1, le=240)] = 50.0
    rows: Annotated[int, msgspec.Meta(ge=50, le=20000)] = 1500


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
        tool: on the flange, unless the arm starts with another one.
        tools: that moves change to, by name.
        surface: what the tip can touch.
        other_robot: robots beside it.
        variation: what differs if the job is driven many times; once if None.
    """

    title: str = ""
    include: str | tuple[str, ...] = ()
    robot: str
    angles: Literal["radians", "degrees"] = "radians"
    lengths: Literal["metres", "millimetres"] = "metres"
    variables: dict[str, float | str | tuple[float, ...]] = msgspec.field(
        default_factory=dict[str, float | str | tuple[float, ...]]
    )
    lock: dict[str, float] = msgspec.field(default_factory=dict[str, float])
    tool: Tool = Tool()
    tools: dict[str, Tool] = msgspec.field(default_factory=dict[str, Tool])
    limits: Bounds = Bounds()
    tolerance: Tolerance = Tolerance()
    controller: Controller = Controller()
    simulation: Simulation = Simulation()
    report: Report = Report()
    collision: Collision | None = None
    disturbance: tuple[Disturbance, ...] = ()
    surface: tuple[Surface, ...] = ()
    other_robot: tuple[OtherRobot, ...] = ()
    variation: VariationTable | None = None


class Job(Head, frozen=True, kw_only=True):
    """A whole job: all lengths in metres but coordinates of prismatic joints, all poses in {s}.

    Attributes:
        start: where the robot begins.
        obstacle: what stands around it.
        move: one after the other.
        origins: for each move the keys in the file that it comes from; empty if they are its own.
        cells: what the file includes.
    """

    start: Start = Start()
    obstacle: tuple[Obstacle, ...] = ()
    move: tuple[Move, ...]
    origins: tuple[tuple[str | int, ...], ...] = ()
    cells: tuple[Cell, ...] = ()
