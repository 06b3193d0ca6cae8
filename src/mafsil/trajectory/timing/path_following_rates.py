"""Joint positions, rates and accelerations of a motion of the tip at an update rate, by both ways of computing them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, positive, single
from mafsil.errors import InputError
from mafsil.ik import Track, TrackTask, track
from mafsil.ik.tracking import TrackStatus
from mafsil.robot import Robot, of_robot
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.path_task import PathTask, multiply_rows, path_equations, path_rates
from mafsil.trajectory.profiles.laws import LawName, rest_law

RatesBy = Literal["jacobian", "differences"]

WINDOW = 7
"""Positions through which a polynomial is laid to differentiate them: its rates have errors of order 6."""

CUTOFF = 1e-9
"""Singular values of a Jacobian below this share of the largest belong to motions that the arm does not have."""


@dataclass(frozen=True, eq=False, repr=False)
class JointMotion(Answer, data="by times q qd qdd"):
    """Joints at every update of a motion of the tip; true if the branch was kept to the end.

    Attributes:
        times: (k,) of the updates [s].
        q, qd, qdd: (k, n) positions, rates and accelerations [rad | m, /s, /s^2]; NaN where the path was not reached.
        by: how the rates were computed.
        track: how inverse kinematics went along the path, with every switch of branch.
    """

    times: Floats
    q: JointVector
    qd: Floats
    qdd: Floats
    by: RatesBy
    track: Track

    @property
    def status(self) -> TrackStatus:
        """That of the track."""
        return self.track.status

    def explain(self, language: str | None = None) -> str:
        """How the path was tracked."""
        return self.track.explain(language)


@of_robot
def joint_motion(
    robot: Robot,
    path: TipPath,
    q_start: ArrayLike,
    duration: float,
    *,
    task: TrackTask = "pose",
    law: LawName = "quintic",
    rate: float = 500.0,
    by: RatesBy = "jacobian",
) -> JointMotion:
    """Move the tip along a path by a time law, and convert every update to joints on the branch of the start.

    1. s, ds/dt and d2s/dt2 of the law at every update, and the tip's poses there.
    2. Inverse kinematics of all poses, each from the one before (`ik.track`).
    3. jacobian:     q' = A# b,  q'' = A# (b' - A' q'),  of A q' = b: J q' = V of the path, or its rows that count;
                     qd = q' ds/dt,  qdd = q'' (ds/dt)^2 + q' d2s/dt2
       differences:  derivatives of the polynomial through seven neighbouring positions, none across a break of the
       path or a switch of branch.

    Both agree up to the rounding of the first and the order of the second. Of redundant arms the first has the rates of
    least norm at each configuration, the second those of the positions as tracked.

    Args:
        robot: whose tip moves.
        path: of the tip.
        q_start: (n,) near the beginning of the path [rad | m].
        duration: [s].
        task: `pose`, or `position`: the orientation is left to the arm.
        law: time law along the path, a name of `mafsil.trajectory.profiles.LAWS`.
        rate: of updates [Hz]; the last is at the end.
        by: `jacobian` or `differences`.

    Raises:
        InputError: a wrong shape, an unknown law or way, a duration or rate that is not positive.

    Reference: Craig, Introduction to Robotics, sec. 7.7: path generation at run time.
    """
    if by not in get_args(RatesBy):
        raise InputError("input.choice", name="by", value=by, known=", ".join(get_args(RatesBy)))
    T, updates, start = positive("duration", duration), positive("rate", rate), single("q_start", q_start, (robot.n,))
    # 1
    times: Floats = np.linspace(0.0, T, max(int(np.ceil(T * updates)), 2) + 1)
    s, speed, growth = rest_law(law).unit().scale_time(T).at(times)
    places = np.clip(s[:, 0], 0.0, 1.0)
    # 2
    found = track(robot, path.poses(places), start, times=times, task=task)
    if task == "position" and not found:  # a motion that keeps to the orientation keeps to the position
        other = track(robot, path.poses(places), start, times=times)
        found, task = (other, "pose") if other else (found, task)
    # 3
    if by == "jacobian":
        qd, qdd = _by_jacobian(robot, path, found.q, places, speed, growth, task)
    else:
        pieces = np.searchsorted(path.breaks[1:-1], places, side="right")
        for switch in found.switches:
            pieces[switch.index :] += len(path.breaks)
        qd, qdd = _by_differences(times, found.q, pieces)
    return JointMotion(times, found.q, qd, qdd, by, found)


def _by_jacobian(
    robot: Robot, path: TipPath, q: JointVector, s: Floats, speed: Floats, growth: Floats, task: PathTask
) -> tuple[Floats, Floats]:
    """(k, n) rates and accelerations from the equations A q' = b of the path and their derivatives; NaN where q is."""
    qd, qdd = np.full_like(q, np.nan), np.full_like(q, np.nan)
    done = np.isfinite(q[:, 0])
    at, places = q[done], s[done]
    T, J = robot.forward_kinematics(at), robot.jacobian_body(at)
    A, b = path_equations(T, J, path, places, task)
    inverse: Floats = np.asarray(np.linalg.pinv(A, rcond=CUTOFF), dtype=np.float64)
    slope = multiply_rows(inverse, b)
    _, _, A_rate, b_slope = path_rates(T, J, robot.jacobian_body_rate(at, slope), slope, path, places, task)
    qd[done] = slope * speed[done]
    qdd[done] = multiply_rows(inverse, b_slope - multiply_rows(A_rate, slope)) * speed[done] ** 2 + slope * growth[done]
    return qd, qdd


def _by_differences(times: Floats, q: JointVector, pieces: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """(k, n) derivatives of polynomials through neighbouring positions of the same piece; NaN in pieces too short."""
    qd, qdd = np.full_like(q, np.nan), np.full_like(q, np.nan)
    h = float(times[1] - times[0])
    for piece in np.unique(pieces):
        (index,) = np.nonzero(pieces == piece)
        width = min(WINDOW, len(index))
        if width < 3:
            continue
        steps = np.arange(len(index))
        first = np.clip(steps - width // 2, 0, len(index) - width)
        around = first[:, None] + np.arange(width)
        slope, bend = np.moveaxis(_weights(width)[steps - first] @ q[index[around]], 1, 0)
        qd[index], qdd[index] = slope / h, bend / h**2
    return qd, qdd


def _weights(width: int) -> Floats:
    """(width, 2, width) what gives both derivatives at each of equally spaced places from the values at all of them."""
    places = np.arange(float(width))
    powers = (places[None, :] - places[:, None])[..., None] ** np.arange(width)
    return np.asarray(np.linalg.inv(powers)[:, 1:3], dtype=np.float64) * np.array([[1.0], [2.0]])
