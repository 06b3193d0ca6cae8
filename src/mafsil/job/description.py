"""What a job file says, as typed data. The field names are the keys of the file."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from mafsil.trajectory.laws import LawName

Positive: TypeAlias = Annotated[float, msgspec.Meta(ge=1e-9)]
NotNegative: TypeAlias = Annotated[float, msgspec.Meta(ge=0)]
Share: TypeAlias = Annotated[float, msgspec.Meta(ge=1e-6, le=1)]
Profile: TypeAlias = LawName | Literal["time_optimal", "jerk_limited"]
"""How a move spends its time: a law, or the shortest time along its path, or with limited jerk."""
QUICKEST = ("time_optimal", "jerk_limited")
"""The profiles of the shortest time: they pass points on the way and round corners."""
PathKind: TypeAlias = Literal["joint", "line", "arc", "spline", "screw"]
TIP_PATHS: tuple[PathKind, ...] = ("line", "arc", "spline", "screw")
"""Paths of the tip: their goal is a pose."""
Three: TypeAlias = tuple[float, float, float]
Four: TypeAlias = tuple[float, float, float, float]
Task: TypeAlias = Literal["pose", "axis", "position"]
Six: TypeAlias = tuple[float, float, float, float, float, float]


class Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of the job file; unknown keys are refused."""


class Pose(Part, frozen=True, kw_only=True):
    """A pose of the tip in {s}: position [m] and one of rpy [rad, or degrees] and quaternion (w, x, y, z)."""

    position: Three
    rpy: Three | None = None
    quaternion: Four | None = None


class Goal(Pose, frozen=True, kw_only=True):
    """A pose to be reached, and what of it counts.

    Attributes:
        task: `pose`: all of it; `axis`: the position, and the direction of the tip's z axis; `position` alone.
            What does not count is left to the arm.
    """

    task: Task = "pose"


class Grasp(Part, frozen=True, kw_only=True):
    """A box that the tool takes.

    Attributes:
        mass: [kg].
        size: edge lengths [m].
        offset: its centre in the tip frame [m].
        known: whether the controller knows the mass.
    """

    name: str = "part"
    mass: NotNegative
    size: tuple[Positive, Positive, Positive] = (0.05, 0.05, 0.05)
    offset: Three = (0.0, 0.0, 0.0)
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


class Move(Part, frozen=True, kw_only=True):
    """One step: exactly one of joints, pose, pick, place and pause.

    Attributes:
        name: for the report and for errors.
        joints: goal in joint coordinates.
        pose: goal of the tip.
        path: `joint`: all joints together; of the tip: `line`, straight; `arc`, on a circle over one point; `spline`,
            smoothly through points; `screw`, about one screw axis.
        via: points to pass through without stopping: joint coordinates on a joint path, poses on an arc or a spline.
        blend: how far from the goal the tip may pass when it goes on to the next path of the tip without a stop [m];
            0 stops there.
        profile: law of motion in time, quintic if None; `time_optimal`: the shortest time along the path;
            `jerk_limited`: the same with limited jerk.
        duration: [s]; the shortest within the limits if left out.
        speed: share of the limits for this move.
        pick: take something: the tool closes, its mass hangs on the tip from then on.
        place: let go of it.
        pause: rest [s].
        hold: time that pick and place take [s].
        avoid: whether a move of the joints goes round what stands in its way; as the job says if None.
        tolerance: of this move, if another than the job's.
    """

    name: str = ""
    joints: tuple[float, ...] | None = None
    pose: Goal | None = None
    path: PathKind = "joint"
    via: tuple[tuple[float, ...] | Pose, ...] = ()
    blend: NotNegative = 0.0
    profile: Profile | None = None
    duration: Positive | None = None
    speed: Share = 1.0
    pick: Grasp | None = None
    place: bool = False
    pause: Positive | None = None
    hold: NotNegative = 0.3
    avoid: bool | None = None
    tolerance: Tolerance | None = None


class Start(Part, frozen=True, kw_only=True):
    """Where the robot begins, at rest: joints, or a pose.

    If neither, zero, moved into the middle 70 % of each range; a bent configuration near it if the arm is singular
    there.
    """

    joints: tuple[float, ...] | None = None
    pose: Goal | None = None


class Tool(Part, frozen=True, kw_only=True):
    """What is mounted on the flange.

    Attributes:
        link: that carries the tip frame; the description's own tip if None.
        offset: pose of the tip frame in that link, if another than the description's.
        mass: of the tool [kg], a point at `com` in the link's frame [m].
    """

    link: str | None = None
    offset: Pose | None = None
    mass: NotNegative = 0.0
    com: Three = (0.0, 0.0, 0.0)


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


class Controller(Part, frozen=True, kw_only=True):
    """The law that drives the joints.

    Attributes:
        kind: `computed_torque`, or `pd_gravity` (PD with gravity compensation).
        frequency: natural frequency of the error dynamics of computed torque; 20 if None [rad/s].
        damping: its damping ratio; 1 if None.
        stiffness, rate_gain: of the PD law, one number or one per joint; from the inertia of each joint if None
            [N m/rad, N m s/rad].
        rate: how often the law is evaluated [Hz]; each simulation step if None.
    """

    kind: Literal["computed_torque", "pd_gravity"] = "computed_torque"
    frequency: Positive | None = None
    damping: Positive | None = None
    stiffness: Positive | tuple[Positive, ...] | None = None
    rate_gain: Positive | tuple[Positive, ...] | None = None
    rate: Positive | None = None


class Noise(Part, frozen=True, kw_only=True):
    """Errors of the sensors: standard deviations, reproducible by the seed."""

    position: NotNegative = 0.0
    velocity: NotNegative = 0.0
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
    """

    step: Annotated[float, msgspec.Meta(ge=1e-6, le=0.1)] = 0.001
    method: Literal["rk4", "semi_implicit_euler", "implicit_friction"] | None = None
    settle: NotNegative = 0.3
    friction: bool = True
    mass_error: Annotated[float, msgspec.Meta(gt=-1, le=10)] = 0.0
    noise: Noise = Noise()


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


class Job(Part, frozen=True, kw_only=True):
    """A whole job file.

    Attributes:
        robot: name of the library, or path of a file.
        angles: unit of all angles of the file.
        lock: joints that are locked, by name [rad, or degrees; m]; they are no coordinates of the arm then.
    """

    title: str = ""
    robot: str
    angles: Literal["radians", "degrees"] = "radians"
    lock: dict[str, float] = {}
    tool: Tool = Tool()
    start: Start = Start()
    limits: Bounds = Bounds()
    tolerance: Tolerance = Tolerance()
    controller: Controller = Controller()
    simulation: Simulation = Simulation()
    report: Report = Report()
    collision: Collision | None = None
    obstacle: tuple[Obstacle, ...] = ()
    move: tuple[Move, ...]
    disturbance: tuple[Disturbance, ...] = ()
