"""What the tip of a job can touch, as typed data. Field names are the keys of the file."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import msgspec

from mafsil.job.part import NotNegative, Part, Positive, Three

Restitution: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=1)]


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
