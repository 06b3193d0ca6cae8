"""What stands around the arm of a job, as typed data: obstacles, what the tip can touch, other robots, what moves keep.

Field names are the keys of the file.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from mafsil.job.language.part import Condition, Fork, Four, NotNegative, Part, Pose, Positive, Share, SignalValue, Three

CONSTRAINED_PLANNER = "rrt_connect"
"""The planner that keeps something."""
KINDS = ("upright", "orientation", "line", "plane")
"""Keys of which at least one is given."""
DIRECTIONS = ("line", "plane")
Restitution: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=1)]
PlannerName: TypeAlias = Literal[
    "rrt_connect", "lazy_prm_star", "trajectory_optimisation", "cell_decomposition", "prm", "rrt_star"
]
"""Planners of `mafsil.planning` for ways round obstacles."""
FILE_KEYS = ("mesh", "cloud", "heights")
"""Obstacles that stand in files of their own."""


class Obstacle(Pose, frozen=True, kw_only=True):
    """A body that stands in {s}: exactly one of box, sphere, cylinder, capsule, cone, floor, mesh, cloud and heights.

    Attributes:
        name: for the report and for errors.
        box: edge lengths [m].
        sphere: radius [m].
        cylinder, capsule: radius and length along z [m]; a capsule's without its ends.
        cone: radius of its base and length along z, the apex above [m].
        floor: the half space below its frame.
        mesh: path of an STL, OBJ, Collada or MSH file, relative to the file.
        cloud: path of an .npy, .ply, .xyz, .txt or .csv file with points of a scanner or camera.
        heights: path of an .npy, .csv or .txt file with ground heights on a grid, or of a grey .png picture.
        scale: of the numbers of these files: 0.001 for millimetres; of a picture the height of white in metres.
        hull: whether the convex hull of the mesh counts, which is solid; else its surface alone.
        radius: of the ball that each point of a cloud stands for [m].
        size: extent along x and y of the grid of heights, centred on its frame [m].
        base: height of the underside of that ground; 0.1 m below its lowest place if None [m].
    """

    name: str = ""
    box: tuple[Positive, Positive, Positive] | None = None
    sphere: Positive | None = None
    cylinder: tuple[Positive, Positive] | None = None
    capsule: tuple[Positive, Positive] | None = None
    cone: tuple[Positive, Positive] | None = None
    floor: bool = False
    mesh: str | None = None
    cloud: str | None = None
    heights: str | None = None
    scale: Positive = 1.0
    hull: bool = False
    radius: Positive | None = None
    size: tuple[Positive, Positive] | None = None
    base: float | None = None

    @property
    def file(self) -> tuple[str, str] | None:
        """The key that names a file, and its path; None where the numbers stand in the table."""
        for key in FILE_KEYS:
            path = getattr(self, key)
            if path is not None:
                return key, str(path)
        return None


class Collision(Part, frozen=True, kw_only=True):
    """How near the arm may come to obstacles and to itself.

    Attributes:
        clearance: that it keeps [m].
        self_clearance: that its bodies keep from each other, some of which are always near, if that is less [m]; the
            clearance if None.
        avoid: moves of the joints go round what stands in their way, unless a move says otherwise.
        srdf: path of a semantic description whose disabled pairs of links are not checked, relative to the file.
        skip: further pairs of links or bodies that are not checked against each other.
        known_free: whether the start is known to be free of self-collision: pairs of bodies that overlap there are not
            checked, and named.
        self_collision: whether the arm is checked against itself; if None, where the description has shapes.
        seed: of the search for ways round.
        planner: that searches them.
        seconds: after which it gives up, or for planners that improve takes the best so far [s].
    """

    clearance: NotNegative = 0.0
    self_clearance: NotNegative | None = None
    avoid: bool = False
    srdf: str | None = None
    skip: tuple[tuple[str, str], ...] = ()
    known_free: bool = False
    self_collision: bool | None = None
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0
    planner: PlannerName = "rrt_connect"
    seconds: Positive = 10.0

    def kept_of_itself(self, kept: float) -> float | None:
        """Clearance of bodies of a robot from each other, where it keeps one from everything else; that one if None."""
        return None if self.self_clearance is None else min(self.self_clearance, kept)


class SceneFile(Part, frozen=True, kw_only=True):
    """A file of obstacles alone.

    Attributes:
        angles: unit of its angles.
        lengths: unit of its lengths.
    """

    angles: Literal["radians", "degrees"] = "radians"
    lengths: Literal["metres", "millimetres"] = "metres"
    obstacle: tuple[Obstacle, ...]


class Surface(Part, frozen=True, kw_only=True):
    """A plane, a ball or a round bar that the tip can touch, and that never pulls.

    Exactly one of normal, sphere and cylinder. It gives way as spring and damper, or it is rigid.

    Attributes:
        name: for the report and for errors.
        point: on the plane, in the middle of the ball, on the axis of the bar, in {s} [m].
        normal: of a plane, out of it, towards the arm.
        sphere, cylinder: radius of a ball or of a bar [m].
        axis: of the bar.
        hollow: whether the tip is inside the ball or the bar and touches its inner side.
        stiffness, damping: of one that gives way [N/m, N s/m], whatever the unit of lengths.
        friction: coefficient of what slides along it; a rigid one holds by it what presses enough.
        rigid: whether it does not give way at all.
        restitution: of a rigid one, speed after an impact over that before, 0 to 1.
    """

    name: str = ""
    point: Three
    normal: Three | None = None
    sphere: Positive | None = None
    cylinder: Positive | None = None
    axis: Three | None = None
    hollow: bool = False
    stiffness: Positive | None = None
    damping: NotNegative = 0.0
    friction: NotNegative = 0.0
    rigid: bool = False
    restitution: Restitution | None = None


class Hole(Part, frozen=True, kw_only=True):
    """A round hole in a face, with a chamfer and a bottom; the tip is the end of a peg.

    Attributes:
        name: for the report and for errors.
        mouth: where its axis comes out of the face, in {s} [m].
        axis: out of the hole.
        clearance: radius of the hole less that of the peg [m].
        depth: of the hole [m].
        chamfer: width of its edge [m].
        peg: length of the peg behind the tip, along the tip's z axis backwards, whose other end touches, too [m].
        stiffness, damping: of the material [N/m, N s/m], whatever the unit of lengths.
        friction: coefficient of what slides along it.
    """

    name: str = ""
    mouth: Three
    axis: Three
    clearance: Positive
    depth: Positive
    chamfer: NotNegative = 0.0
    peg: NotNegative = 0.0
    stiffness: Positive = 2e4
    damping: NotNegative = 100.0
    friction: NotNegative = 0.0


class Door(Part, frozen=True, kw_only=True):
    """A door whose handle the tip holds: from the start of the job to its end, or from one move to another.

    Attributes:
        name: for the report and for errors.
        hinge: a point of the hinge, in {s} [m].
        axis: of the hinge.
        stiffness, damping: of the grip against shifts [N/m, N s/m], whatever the unit of lengths.
        rotational_stiffness, rotational_damping: of the grip against rotations [N m/rad, N m s/rad].
        friction: of the hinge [N m s/rad].
        closer: spring that shuts the door [N m/rad].
        grip: name of the move with which the tip takes the handle; from the start on if empty.
        release: name of the move after which it lets go, and the door stays where it is; to the end if empty.
    """

    name: str = ""
    hinge: Three
    axis: Three
    stiffness: Positive = 2e4
    damping: NotNegative = 200.0
    rotational_stiffness: NotNegative = 50.0
    rotational_damping: NotNegative = 1.0
    friction: NotNegative = 0.0
    closer: NotNegative = 0.0
    grip: str = ""
    release: str = ""


class Guide(Part, frozen=True, kw_only=True):
    """A rail or a slot in which the tip slides, and to which it is drawn back: exactly one of direction and normal.

    Attributes:
        name: for the report and for errors.
        point: on it, in {s} [m].
        direction: of a rail, along which the tip is free.
        normal: of a slot, across which it is not.
        stiffness, damping: across it [N/m, N s/m], whatever the unit of lengths.
    """

    name: str = ""
    point: Three
    direction: Three | None = None
    normal: Three | None = None
    stiffness: Positive
    damping: NotNegative = 0.0


class OtherAction(Part, frozen=True, kw_only=True):
    """What a step of another robot does.

    Attributes:
        joints: goal in joint coordinates.
        pose: goal of its tip in {s}; the present orientation if it says none.
        pause: rest [s].
        set: values that outputs take; no other robot sets the same ones.
        wait: conditions on signals, all of them: rest until they hold.
        timeout: longest wait [s].
        speed: share of the limits for this move.
    """

    joints: tuple[float, ...] | None = None
    pose: Pose | None = None
    pause: Positive | None = None
    set: dict[str, SignalValue] = msgspec.field(default_factory=dict[str, SignalValue])
    wait: dict[str, Condition] = msgspec.field(default_factory=dict[str, Condition])
    timeout: Positive | None = None
    speed: Share = 1.0


class OtherMove(OtherAction, frozen=True, kw_only=True):
    """One step of another robot: exactly one of joints, pose, pause, set, wait and fork.

    Attributes:
        fork: whether the moves after it are made.
        skip: moves that are passed over after this one: those of the other way.
        origin: keys under the moves of the robot where it stands in the file.
    """

    fork: Fork | None = None
    skip: int = 0
    origin: tuple[str | int, ...] = ()

    @property
    def number(self) -> int:
        """Of the entry of the robot's table that it comes from, from 1."""
        return int(self.origin[0]) + 1 if self.origin else 1


class OtherPlace(Part, frozen=True, kw_only=True):
    """Another robot without what it does.

    Attributes:
        name: for the report and for errors.
        robot: name of the library, or path of a file.
        position: of its base in {s} [m].
        rpy, quaternion: how its base is turned [rad, or degrees].
        joints: where it begins; zero, moved into the middle 70 % of each range, if None.
        srdf: path of a semantic description whose disabled pairs of its links are not checked, relative to the file.
        skip: further pairs of its links or bodies that are not checked against each other.
    """

    name: str
    robot: str
    position: Three = (0.0, 0.0, 0.0)
    rpy: Three | None = None
    quaternion: Four | None = None
    joints: tuple[float, ...] | None = None
    srdf: str | None = None
    skip: tuple[tuple[str, str], ...] = ()


class OtherRobot(OtherPlace, frozen=True, kw_only=True):
    """A robot beside the one of the job. It stands, or moves past the job's robot, whose motion is settled first.

    Attributes:
        move: one after the other; none if it only stands there.
    """

    move: tuple[OtherMove, ...] = ()


class PathConstraints(Part, frozen=True, kw_only=True):
    """What the tip keeps from where the move begins: one or several.

    Attributes:
        upright: largest angle between its z axis and where that pointed [rad, or degrees].
        orientation: its orientation.
        line: direction of the straight line through its place on which it stays, in {s}.
        plane: normal of the plane through its place in which it stays, in {s}.
        tolerance: of line and plane [m].
        angle: of the orientation [rad, or degrees].
    """

    upright: Positive | None = None
    orientation: bool = False
    line: Three | None = None
    plane: Three | None = None
    tolerance: Positive | None = None
    angle: Positive | None = None


class PlacedConstraints(PathConstraints, frozen=True, kw_only=True):
    """The same along the axes of a frame.

    Attributes:
        frame: of line and plane; {s} if None.
    """

    frame: str | None = None
