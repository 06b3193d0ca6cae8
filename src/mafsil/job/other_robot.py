"""Other robots of a job, as typed data: where each stands and what it does. Field names are the keys of the file."""

from __future__ import annotations

import msgspec

from mafsil.job.part import Four, Part, Pose, Positive, Share, Three
from mafsil.job.signals import Condition, Fork, SignalValue


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
