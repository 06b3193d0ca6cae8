"""What stands around the arm of a job, as typed data. Field names are the keys of the file."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import msgspec

from mafsil.job.part import NotNegative, Part, Pose, Positive

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
