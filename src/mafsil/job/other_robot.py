"""Other robots of a job, as typed data: where each stands and what it does. Field names are the keys of the file."""

from __future__ import annotations

import msgspec

from mafsil.job.part import Four, Part, Pose, Positive, Share, Three
from mafsil.job.signals import Condition, SignalValue


class OtherMove(Part, frozen=True, kw_only=True):
    """One step of another robot: exactly one of joints, pose, pause, set and wait.

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


class OtherRobot(Part, frozen=True, kw_only=True):
    """A robot beside the one of the job. It stands, or moves past the job's robot, whose motion is settled first.

    Attributes:
        name: for the report and for errors.
        robot: name of the library, or path of a file.
        position: of its base in {s} [m].
        rpy, quaternion: how its base is turned [rad, or degrees].
        joints: where it begins; zero, moved into the middle 70 % of each range, if None.
        move: one after the other; none if it only stands there.
    """

    name: str
    robot: str
    position: Three = (0.0, 0.0, 0.0)
    rpy: Three | None = None
    quaternion: Four | None = None
    joints: tuple[float, ...] | None = None
    move: tuple[OtherMove, ...] = ()
