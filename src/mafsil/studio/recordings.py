"""Recorded motions that windows replay, and how far two of them are apart.

The motion of a run while it is computed.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.job.planning.plan import Plan
from mafsil.messages.visible import visible
from mafsil.report.content import Scene
from mafsil.report.page import tape_data
from mafsil.robot import Robot
from mafsil.simulation import Recording
from mafsil.studio.broadcast import Broadcast

MOST_ROWS = 3000
"""Of a recording that a window gets; between them it draws straight lines."""
MOST_KEPT = 12
"""Recordings at one time; then the oldest goes, its files stay."""
PAUSE = 0.1
"""Between two messages about a run [s]."""
FRAME = 1 / 30
"""Between two places of a motion that is being computed [s]."""
POINTS = 1000
"""Times at which two recordings are compared."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """A recording that windows know by a number.

    Attributes:
        title: for people.
        recording: the motion.
        report: path of its report, if there is one.
        scene: what the arm carries and what stands around it, where that is known.
    """

    title: str
    recording: Recording
    report: Path | None
    scene: Scene | None = None


class Recordings:
    """The recordings of a studio.

    Args:
        robot: of the windows; only its motions are drawn.
        broadcast: to the windows.
    """

    def __init__(self, robot: Robot, broadcast: Broadcast) -> None:
        self._robot, self._broadcast = robot, broadcast
        self._kept: dict[int, Recorded] = {}
        self._count = 0
        self._lock = threading.Lock()

    def add(self, recorded: Recorded) -> int:
        """Keep one more, and tell the windows.

        Returns:
            Its number.
        """
        with self._lock:
            self._count += 1
            number = self._count
            self._kept[number] = recorded
            while len(self._kept) > MOST_KEPT:
                del self._kept[min(self._kept)]
        self._broadcast.send(self.list_recordings())
        return number

    def list_recordings(self) -> Mapping[str, Any]:
        """The message that names them all."""
        with self._lock:
            kept = list(self._kept.items())
        return {"kind": "recordings", "list": [self._about(number, one) for number, one in kept]}

    def of(self, number: int) -> Recorded:
        """The recording of a number.

        Raises:
            InputError: there is none.
        """
        with self._lock:
            found = self._kept.get(number)
        if found is None:
            raise InputError("studio.no_recording", number=number)
        return found

    def data(self, number: int) -> Mapping[str, Any]:
        """What a window needs to replay one: times [s], coordinates as they were and as they should have been, scenery.

        Raises:
            InputError: there is none, or it is of another robot.
        """
        recorded = self._drawable(number)
        tape = recorded.recording
        rows = np.unique(np.linspace(0, len(tape.t) - 1, min(MOST_ROWS, len(tape.t))).round().astype(int))
        return {
            "number": number,
            "t": tape.t[rows].tolist(),
            "q": tape.q[rows].tolist(),
            "q_ref": tape.q_ref[rows].tolist(),
            "tip_error": tape.tip_position_error[rows].tolist(),
            "scenery": recorded.scene and tape_data(recorded.scene),
        }

    def compare(self, first: int, second: int) -> Mapping[str, Any]:
        """How far the arm of one recording is from that of another at the same times, while both last.

        Raises:
            InputError: one of them is not there, or of another robot.
        """
        one, other = self._drawable(first).recording, self._drawable(second).recording
        end = min(one.t[-1], other.t[-1])
        t = np.linspace(0.0, float(end), POINTS)
        q, p = at(one, t), at(other, t)
        forward = self._robot.forward_kinematics
        distance = np.linalg.norm(forward(q)[:, :3, 3] - forward(p)[:, :3, 3], axis=1)
        apart = np.abs(q - p)
        row, joint = np.unravel_index(int(apart.argmax()), apart.shape)
        return {
            "t": t.tolist(),
            "distance": distance.tolist(),
            "largest": float(distance.max()),
            "largest_time": float(t[int(distance.argmax())]),
            "joint": visible(self._robot.joint_names[int(joint)]),
            "joint_place": int(joint),
            "joint_apart": float(apart[row, joint]),
            "joint_time": float(t[int(row)]),
            "longer": float(one.t[-1] - other.t[-1]),
        }

    def _drawable(self, number: int) -> Recorded:
        found = self.of(number)
        if not self._draws(found.recording):
            raise InputError("studio.other_robot", robot=visible(self._robot.name))
        return found

    def _draws(self, recording: Recording) -> bool:
        """Whether it is a motion of the robot that windows show; finite all along."""
        joints = [str(name) for name in recording.metadata["joints"]]
        return joints == list(self._robot.joint_names) and recording.q.ndim == 2 and len(recording.t) > 0

    def _about(self, number: int, one: Recorded) -> dict[str, Any]:
        return {
            "number": number,
            "title": visible(one.title),
            "duration": one.recording.duration,
            "report": one.report is not None,
            "draws": self._draws(one.recording),
        }


class LiveMotion:
    """The motion of a run that windows see before it has ended: the planned path of the tip, then places as they come.

    Args:
        broadcast: to the windows.

    Attributes:
        message: all that is known by now; empty before the plan is.
        fault: as of a log that is never full.
    """

    def __init__(self, broadcast: Broadcast) -> None:
        self.message: dict[str, Any] = {}
        self.fault, self._broadcast, self._pause = "", broadcast, FRAME
        self._start = self._end = self._sent = 0.0

    def show_plan(self, plan: Plan) -> None:
        """The motion is planned.

        Args:
            plan: of the run.
        """
        self._pause = max(FRAME, plan.duration / MOST_ROWS)
        moments = np.linspace(0.0, plan.duration, min(MOST_ROWS, 2 + int(plan.duration / FRAME)))
        legs = plan.legs_at(moments)
        q = np.empty((len(moments), len(plan.start)))
        for k in np.unique(legs):
            q[legs == k] = plan.legs[int(k)].trajectory.at(moments[legs == k] - plan.starts[k]).u
        path = plan.tips(moments, q)[:, :3, 3]
        with self._broadcast.lock:
            self.message = {"kind": "motion", "duration": plan.duration, "path": path.tolist(), "t": [], "q": []}
            self._broadcast.send(self.message)

    def begin(self, metadata: Mapping[str, object]) -> None:
        """A stretch of the motion begins where the one before ended."""
        self._start = self._end

    def is_due(self) -> bool:
        """Whether windows wait for more."""
        return time.monotonic() - self._sent > PAUSE

    def add(self, rows: Mapping[str, Floats]) -> None:
        """Ticks of the run."""
        t = rows["t"] + self._start
        frames = np.floor(t / self._pause)
        before = np.floor(self._end / self._pause) if self.message["t"] else -1.0
        kept = np.flatnonzero((np.diff(frames, prepend=before) > 0) & np.isfinite(rows["q"]).all(axis=-1))
        self._end, self._sent = float(t[-1]), time.monotonic()
        more = {"t": t[kept].tolist(), "q": rows["q"][kept].tolist()}
        with self._broadcast.lock:
            for name, values in more.items():
                self.message[name] += values
            self._broadcast.send({"kind": "ticks", **more})

    def end(self, metadata: Mapping[str, object]) -> None:
        """A stretch has ended."""


def at(recording: Recording, t: Floats) -> Floats:
    """(k, n) coordinates at times [s], on straight lines between the ticks."""
    columns: list[Floats] = [np.interp(t, recording.t, column) for column in recording.q.T]
    return np.stack(columns, axis=1)
