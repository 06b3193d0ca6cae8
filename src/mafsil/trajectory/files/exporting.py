"""Trajectories in files for controllers: held against the limits first, written whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TypeAlias

from mafsil.answer import Answer, Status
from mafsil.errors import InputError
from mafsil.robot import Robot
from mafsil.trajectory.checks.limit_check import LimitCheck, check, not_checked
from mafsil.trajectory.files import formats as csv_file
from mafsil.trajectory.files import formats as ros2
from mafsil.trajectory.files import formats as urscript
from mafsil.trajectory.files.formats import Samples, sample_trajectory
from mafsil.trajectory.motion import Trajectory
from mafsil.trajectory.motion_limits import Limits
from mafsil.whole_file import write_whole

Format: TypeAlias = Literal["csv", "ros2_yaml", "ros2_json", "urscript"]

FORMATS: dict[Format, tuple[tuple[str, ...], Callable[[Samples], bytes]]] = {
    "csv": ((".csv",), csv_file.as_csv),
    "ros2_yaml": ((".yaml", ".yml"), ros2.as_yaml),
    "ros2_json": ((".json",), ros2.as_json),
    "urscript": ((".script", ".urscript"), urscript.as_urscript),
}
"""All formats: the endings of files by which they are known, and what writes them."""


class ExportStatus(Status):
    """Whether a trajectory was written."""

    WRITTEN = ("trajectory.written", True)
    LIMITS_EXCEEDED = ("trajectory.not_written", False)


@dataclass(frozen=True, slots=True, repr=False)
class TrajectoryFile(Answer):
    """True if the file was written; false, and nothing written, if the trajectory exceeds a limit.

    Attributes:
        status: whether it was written.
        path: of the file.
        rows: points in it.
        limit_check: what the trajectory was held against, and how it ended.
    """

    status: ExportStatus
    path: Path
    rows: int
    limit_check: LimitCheck

    def explain(self, language: str | None = None) -> str:
        """What was written, or which limits kept it from being written."""
        details = {"path": str(self.path), "rows": self.rows, "count": len(self.limit_check)}
        sentence = self.status.sentence(language, **details)
        if self:
            return sentence + not_checked(self.limit_check.unchecked, language)
        return "\n".join([sentence, self.limit_check.explain(language)])

    def to_dict(self) -> dict[str, Any]:
        """Status, path, number of rows and violations as plain data."""
        data = {"status": self.status.name.lower(), "path": str(self.path), "rows": self.rows}
        return data | {"violations": self.limit_check.to_dict()["violations"]}


def export(
    trajectory: Trajectory,
    path: str | PathLike[str],
    limits: Limits,
    *,
    joints: Sequence[str] = (),
    rate: float = 125.0,
    format: Format | None = None,
    ends: bool = True,
) -> TrajectoryFile:
    """Write a trajectory for a controller, if it keeps the limits.

    Every position, velocity, acceleration and jerk is checked over the whole motion before a byte is written, and jumps
    that no finite limit allows.

    Args:
        trajectory: of n joints, not a batch.
        path: of the file; its ending says the format: .csv, .yaml (ROS 2 JointTrajectory), .json (the same as JSON),
            .script (URScript).
        limits: a robot, or bounds of n coordinates; what has no limits is written with `MotionLimits.of(n)`.
        joints: (n) names; those of the robot if `limits` is one, else joint1, joint2, ...
        rate: points per second [Hz]; URScript's servoj runs at 125 or 500.
        format: if the ending does not say it: `csv`, `ros2_yaml`, `ros2_json` or `urscript`.
        ends: whether jumps from rest at the start and into rest at the end count; False for a part of a longer motion.

    Returns:
        Whether it was written; if not, which limit is exceeded, when and by how much.

    Raises:
        InputError: an unknown format, names that do not fit, a rate that is not positive.
        FileError: the place cannot be written.

    Example: `mf.trajectory.export(motion, "pick.yaml", robot, rate=100)`
    """
    write = FORMATS[_format(Path(path), format)][1]
    names = tuple(joints) or (limits.joint_names if isinstance(limits, Robot) else ())
    samples = sample_trajectory(trajectory, names, rate)
    verdict = check(trajectory, limits, samples.joints, ends=ends)
    if not verdict:
        return TrajectoryFile(ExportStatus.LIMITS_EXCEEDED, Path(path), 0, verdict)
    write_whole(Path(path), write(samples))
    return TrajectoryFile(ExportStatus.WRITTEN, Path(path), len(samples.t), verdict)


def _format(path: Path, format: Format | None) -> Format:
    if format is None:
        for name, (endings, _) in FORMATS.items():
            if path.suffix.lower() in endings:
                return name
        known = ", ".join(ending for endings, _ in FORMATS.values() for ending in endings)
        raise InputError("input.choice", name="path", value=path.suffix, known=known)
    if format not in FORMATS:
        raise InputError("input.choice", name="format", value=format, known=", ".join(FORMATS))
    return format
