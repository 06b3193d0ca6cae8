"""From one configuration to another in joints or along a straight line of the tip: what each costs, side by side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, positive, whole
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.messages.tables import in_notebook, number, table
from mafsil.robot import Robot, of_robot
from mafsil.trajectory.motion import Motion, PlanStatus, times
from mafsil.trajectory.paths.cartesian_path import CartesianPath
from mafsil.trajectory.paths.pose_path import PathTask, path_equations, path_error, path_rates
from mafsil.trajectory.profiles.laws import QUINTIC
from mafsil.trajectory.profiles.polynomial import quintic
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.timing.generator import TickReport, TrajectoryGenerator
from mafsil.trajectory.timing.path_following import follow

COLUMNS = ("route", "worst_tick", "mean_tick", "largest_step", "peak_rate", "off_chord")
NEWTON = 2
"""Corrections of the configuration at a tick: the tick before is so near that the second is below rounding."""
MOST_TICKS = 1_000_000
"""Ticks of a comparison, each of which is a row of its tables."""


@dataclass(frozen=True, slots=True)
class Route:
    """One way to move.

    Attributes:
        name: `joints` or `cartesian`.
        ticks: what its ticks took.
        peak_rate: largest joint rate [rad/s | m/s].
        off_chord: largest distance of the tip from the straight line between its ends [m].
    """

    name: str
    ticks: TickReport
    peak_rate: float
    off_chord: float


@dataclass(frozen=True, slots=True, repr=False)
class RouteComparison(Answer, entries="routes"):
    """Both routes; true if the tip can keep to the straight line.

    Attributes:
        routes: the joint route, and the Cartesian one if there is one.
        status: how the straight line was followed, FOLLOWED or why not.
        reason: what stopped it, in a sentence.
    """

    routes: tuple[Route, ...]
    status: Status
    reason: str

    def explain(self, language: str | None = None) -> str:
        """A table, and what stopped the straight line."""
        head = [say(f"trajectory.column_{name}", language=language) for name in COLUMNS]
        rows = [
            [
                say(f"trajectory.route_{route.name}", language=language),
                number(route.ticks.worst * 1e6),
                number(route.ticks.mean * 1e6),
                number(route.ticks.largest_step),
                number(route.peak_rate),
                number(route.off_chord),
            ]
            for route in self.routes
        ]
        lines = [say("trajectory.routes", language=language, rate=self.routes[0].ticks.rate)]
        lines += table(head, rows, language)
        return "\n".join(lines if self else [*lines, self.reason])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        rows = {r.name: r.ticks.to_dict() | {"peak_rate": r.peak_rate, "off_chord": r.off_chord} for r in self.routes}
        return {"status": self.status.name.lower(), "routes": rows}

    def _repr_html_(self) -> str:
        return in_notebook(self.explain())


@dataclass(eq=False)
class TipMotion:
    """Joint motion along a path of the tip, computed anew at each time from the configuration of the time before.

    Attributes:
        robot: whose tip moves.
        path: of the tip.
        law: s(t) of one coordinate.
        q: (n,) configuration of the last time, the start at first [rad | m].
        task: what of the path the tip keeps to.
    """

    robot: Robot
    path: CartesianPath
    law: PiecewisePolynomial
    q: Floats
    task: PathTask = "pose"

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return self.law.duration

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration (*times, n) at times that follow one another closely [s]."""
        moments = times(t)
        found = np.array([self._at(float(moment)) for moment in moments.ravel()])
        u, v, a = np.moveaxis(found.reshape(*moments.shape, 3, self.robot.n), -2, 0)
        return Motion(u, v, a)

    def _at(self, t: float) -> tuple[Floats, Floats, Floats]:
        """1. The pose on the path.  2. The configuration.  3. Rates and accelerations."""
        # 1
        robot, q, task = self.robot, self.q, self.task
        s, rate, growth = (float(x[0]) for x in self.law.at(t))
        target = self.path.poses(s)
        # 2
        for _ in range(NEWTON):
            T = robot.forward_kinematics(q)
            A = path_equations(T, robot.jacobian_body(q), self.path, s, task)[0]
            q = q + np.linalg.pinv(A) @ path_error(T, target, task)
        self.q = q
        # 3
        T, J = robot.forward_kinematics(q), robot.jacobian_body(q)
        A, b = path_equations(T, J, self.path, s, task)
        inverse = np.linalg.pinv(A)
        slope = inverse @ b
        _, _, A_rate, b_slope = path_rates(T, J, robot.jacobian_body_rate(q, slope), slope, self.path, s, task)
        return q, slope * rate, inverse @ (b_slope - A_rate @ slope) * rate**2 + slope * growth


@of_robot
def compare_routes(
    robot: Robot,
    q_start: ArrayLike,
    q_goal: ArrayLike,
    duration: float,
    *,
    rate: float = 1000.0,
    task: PathTask = "pose",
) -> RouteComparison:
    """Run both routes tick by tick, by the quintic law, and measure them.

    In joints a tick evaluates polynomials. Along the line it evaluates the tip's pose and twist, corrects the
    configuration of the tick before onto the pose by Newton's method, and takes q' = J# V, q'' = J# (V' - J' q').

    Args:
        robot: whose tip moves.
        q_start, q_goal: (n,) [rad | m]; the line leads to the tip's pose at q_goal, on the branch of q_start.
        duration: [s].
        rate: update rate [Hz].
        task: what of the line the tip keeps to: `pose`; `axis`, the position and the direction of z; `position`.

    Returns:
        Times of ticks, largest joint step between them, peak rate, and how far the tip leaves the chord. If the line
        cannot be followed there is only the joint route, and the status says why.

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration or rate that is not positive.
    """
    start = as_batch("q_start", q_start, (robot.n,), finite=True)
    goal = as_batch("q_goal", q_goal, (robot.n,), finite=True)
    T = positive("duration", duration)
    whole("duration * rate", int(T * positive("rate", rate)), most=MOST_TICKS)
    path = CartesianPath(robot.forward_kinematics(start), robot.forward_kinematics(goal))
    joints = TrajectoryGenerator(quintic(start, goal, T), rate)
    routes = [_measure("joints", robot, joints, path)]
    planned = follow(robot, path, start, task=task)
    if planned.value is None or not planned.succeeded:
        return RouteComparison(tuple(routes), planned.status, planned.explain())
    kept = cast("PathTask", planned.details["task"])
    line = TipMotion(robot, path, QUINTIC.between(np.zeros(1), np.ones(1), T), start, kept)
    routes.append(_measure("cartesian", robot, TrajectoryGenerator(line, rate), path))
    return RouteComparison(tuple(routes), PlanStatus.FOLLOWED, "")


def _measure(name: str, robot: Robot, generator: TrajectoryGenerator, path: CartesianPath) -> Route:
    """Every tick of a route."""
    q, qd = np.zeros((generator.ticks, robot.n)), np.zeros((generator.ticks, robot.n))
    for k, motion in enumerate(generator):
        q[k], qd[k] = motion.u, motion.v
    tip = robot.forward_kinematics(q)[:, :3, 3]
    chord = path.T_goal[:3, 3] - path.T_start[:3, 3]
    along = chord / max(float(np.linalg.norm(chord)), LEAST_DIVISOR)
    off = tip - path.T_start[:3, 3]
    off = off - (off @ along)[:, None] * along
    return Route(name, generator.report(), float(np.abs(qd).max()), float(np.linalg.norm(off, axis=1).max()))
