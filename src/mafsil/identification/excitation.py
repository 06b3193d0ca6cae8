"""Excitation trajectories for identification: Fourier series inside the joint limits, well conditioned.

Reference: Swevers, Ganseman, Tuekel, de Schutter & van Brussel, Optimal robot excitation and identification, IEEE T-RA
13, 1997.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, positive, real_array, require_finite, whole
from mafsil.csv_table import csv_text, joint_columns
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.identification.tolerances import NO_EFFORT, NO_EXCITATION, NO_MOTION, WORST_CONDITION
from mafsil.identification.torque_model import TorqueModel
from mafsil.mechanics.friction import SMOOTHING
from mafsil.messages import say
from mafsil.messages.tables import in_notebook, joint_units, number, table
from mafsil.model.limits import snap_to_bounds
from mafsil.robot import Robot, of_robot
from mafsil.whole_file import write_whole

SAMPLES = 120
"""Instants at which a candidate is looked at."""
MARGIN = 0.95
"""Share of every limit that is used."""
WITHOUT_LIMIT = (np.pi, 1.0, 2.0)
"""Reach to either side [rad | m], rate and acceleration where the description has no limits."""
MOST_TRIED = 100_000
"""Of harmonics, draws and changes: more take days."""
FIRST_STEP, LAST_STEP = 0.5, 0.05
"""Size of the random changes when improving, at the beginning and at the end, against the coefficients."""

COLUMNS = ("joint", "lowest", "highest", "velocity", "acceleration")
"""Of the table that is printed."""


class Motion(NamedTuple):
    """Position, velocity and acceleration, each (*times, n) [rad | m] and time derivatives."""

    u: Floats
    v: Floats
    a: Floats


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class ExcitationTrajectory:
    """A periodic motion that begins and ends at rest.

    q_i(t) = centre_i + sum over l of (sine_il sin(l w t) + cosine_il (cos(l w t) - 1)),  w = 2 pi / period

    Attributes:
        joints: names.
        period: [s]; the motion repeats after it.
        repetitions: how often it is done.
        centre: (n,) position at the beginning [rad | m].
        sine, cosine: (n, harmonics) coefficients [rad | m].
        condition_number: of the base regressor, columns scaled to length one.
        acceptance_rate: share of the candidates that kept the limits and were accepted.
    """

    joints: tuple[str, ...]
    period: float
    repetitions: int
    centre: Floats
    sine: Floats
    cosine: Floats
    condition_number: float
    acceptance_rate: float

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.centre)

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return self.period * self.repetitions

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        times = require_finite("t", real_array("t", t))
        inside = ((times >= 0.0) & (times <= self.duration))[..., None]
        q, qd, qdd = _series(times, self.period, self.sine, self.cosine)
        still = np.zeros_like(q)
        return Motion(self.centre + np.where(inside, q, 0.0), np.where(inside, qd, still), np.where(inside, qdd, still))

    def __repr__(self) -> str:
        motion = self.at(np.linspace(0.0, self.period, 20 * SAMPLES + 1))
        reach = motion.u.min(axis=0), motion.u.max(axis=0)
        columns = [*reach, *(np.abs(x).max(axis=0) for x in (motion.v, motion.a))]
        rows = [[joint, *(number(float(x)) for x in row)] for joint, *row in zip(self.joints, *columns, strict=True)]
        head = [say(f"identification.column_{name}") for name in COLUMNS]
        title = say("identification.excitation", period=self.period, count=self.repetitions)
        condition = say("identification.condition", condition_number=self.condition_number)
        return "\n".join([title, *table(head, rows, units=joint_units(COLUMNS)), condition])

    def _repr_html_(self) -> str:
        return in_notebook(repr(self))

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative at the times `t` [rad/s^3 | m/s^3]."""
        times = require_finite("t", real_array("t", t))
        w, angle = _phases(times, self.period, self.sine.shape[1])
        inside = ((times >= 0.0) & (times <= self.duration))[..., None]
        return np.where(inside, (np.sin(angle) * w**3) @ self.cosine.T - (np.cos(angle) * w**3) @ self.sine.T, 0.0)

    def breaks(self) -> Floats:
        """(2,) the motion is smooth from its beginning to its end [s]."""
        return np.array([0.0, self.duration])

    def save(self, path: str | PathLike[str], rate: float = 1000.0) -> None:
        """Write t, q[JOINT], qd[JOINT], qdd[JOINT] as CSV.

        Args:
            path: an existing file is replaced.
            rate: samples per second [Hz].

        Raises:
            InputError: a rate that is not positive.
            FileError: a place that cannot be written.
        """
        t = np.arange(round(self.duration * positive("rate", rate)) + 1) / rate
        motion = self.at(t)
        write_whole(Path(path), b"".join(csv_text({"t": t, **joint_columns(("q", "qd", "qdd"), motion, self.joints)})))


@of_robot
def excitation_trajectory(
    robot: Robot,
    *,
    period: float = 10.0,
    repetitions: int = 3,
    harmonics: int = 5,
    candidates: int = 40,
    improvements: int = 200,
    seed: int = 0,
    speed: float = 1.0,
    centre: ArrayLike | None = None,
    accept: Callable[[Floats], bool] | None = None,
) -> ExcitationTrajectory:
    """A motion that excites all parameters: the best of random draws, improved step by step.

    Limits of position, rate, acceleration and effort of the description are kept; collisions are not checked unless
    `accept` does.

    Args:
        robot: its limits, and its masses for the efforts.
        period: of the slowest oscillation [s].
        repetitions: periods in the motion; more of them average more noise away.
        harmonics: oscillations per joint.
        candidates: random draws.
        improvements: random changes tried on the best draw.
        seed: of all random numbers.
        speed: share of the limits of rate and acceleration, 0 to 1.
        centre: (n,) where the motion begins [rad | m]; the middle of the range if None.
        accept: says of positions (SAMPLES, n) along a period whether they may be run, such as free of collisions.

    Returns:
        The motion, its condition number in it.

    Raises:
        InputError: numbers out of range, or no candidate was accepted.

    Reference: as the module.
    """
    for name, count in (("harmonics", harmonics), ("candidates", candidates), ("improvements", improvements)):
        whole(name, count, 0, MOST_TRIED)
    if min(harmonics, candidates, repetitions) < 1 or harmonics < 2 or improvements < 0:
        raise InputError("identification.excitation_counts", harmonics=harmonics, candidates=candidates)
    if not 0.0 < positive("speed", speed) <= 1.0:
        raise InputError("input.range", name="speed", value=speed, low=0.0, high=1.0)
    search = _Search(robot, positive("period", period), speed, centre, accept)
    rng = np.random.default_rng(seed)
    draws = [rng.normal(size=(2, robot.n, harmonics)) / np.arange(1, harmonics + 1) for _ in range(candidates)]
    judged = [search.condition(draw) for draw in draws]
    best, least = draws[int(np.argmin(judged))], min(judged)
    for k in range(improvements):
        size = FIRST_STEP * (LAST_STEP / FIRST_STEP) ** (k / max(improvements - 1, 1))
        joint = int(rng.integers(robot.n))
        changed = best.copy()
        changed[:, joint] += size * rng.normal(size=(2, harmonics)) / np.arange(1, harmonics + 1)
        condition = search.condition(changed)
        if condition < least:
            best, least = changed, condition
    if not np.isfinite(least):
        raise InputError("identification.no_motion", count=candidates + improvements)
    start, sine, cosine = search.scaled(best)
    return ExcitationTrajectory(
        robot.joint_names, float(period), repetitions, frozen(start), frozen(sine), frozen(cosine), float(least),
        search.acceptance_rate,
    )  # fmt: skip


class _Search:
    """Judges candidates: coefficients (2, n, harmonics) of any size."""

    def __init__(
        self,
        robot: Robot,
        period: float,
        speed: float,
        centre: ArrayLike | None,
        accept: Callable[[Floats], bool] | None,
    ) -> None:
        self.robot, self.period, self.accept = robot, period, accept
        limits, (reach, rate, acceleration) = robot.limits, WITHOUT_LIMIT
        self.lower = np.where(np.isfinite(limits.lower), limits.lower, np.minimum(limits.upper, reach) - 2 * reach)
        self.upper = np.where(np.isfinite(limits.upper), limits.upper, self.lower + 2 * reach)
        self.rate = MARGIN * speed * np.where(np.isfinite(limits.velocity), limits.velocity, rate)
        finite = np.isfinite(limits.acceleration)
        self.acceleration = (
            MARGIN * speed * np.where(finite, limits.acceleration, acceleration * np.maximum(self.rate, 1))
        )
        self.model = TorqueModel(robot, SMOOTHING)
        self.columns = list(self.model.base.columns)
        self.times = np.linspace(0.0, period, SAMPLES, endpoint=False)
        self.start = None
        if centre is not None:
            given = as_batch("centre", centre, (robot.n,), finite=True).reshape(robot.n)
            self.start = snap_to_bounds(given, self.lower, self.upper)
        self.tried, self.passed = 0, 0
        if self.start is not None:
            outside = np.flatnonzero((self.start < self.lower) | (self.start > self.upper))
            if len(outside):
                k = int(outside[0])
                low, high = self.lower[k], self.upper[k]
                raise InputError("input.range", name=f"centre[{k}]", value=self.start[k], low=low, high=high)

    @property
    def acceptance_rate(self) -> float:
        """Share of the candidates that could be run."""
        return self.passed / max(self.tried, 1)

    def scaled(self, draw: Floats) -> tuple[Floats, Floats, Floats]:
        """Start (n,) and coefficients (n, harmonics) that begin at rest and use the limits of motion."""
        sine, cosine = _at_rest(draw)
        q, qd, qdd = _series(self.times, self.period, sine, cosine)
        low, high = q.min(axis=0), q.max(axis=0)
        if self.start is None:
            middle = (self.lower + self.upper) / 2
            reach_factor = MARGIN * (self.upper - self.lower) / np.maximum(high - low, NO_MOTION)
        else:
            middle = self.start
            above = (self.upper - self.start) / np.maximum(high, NO_MOTION)
            reach_factor = MARGIN * np.minimum(above, (self.start - self.lower) / np.maximum(-low, NO_MOTION))
        fast = self.rate / np.maximum(np.abs(qd).max(axis=0), NO_MOTION)
        hard = self.acceleration / np.maximum(np.abs(qdd).max(axis=0), NO_MOTION)
        factor = np.minimum(reach_factor, np.minimum(fast, hard))
        start = middle if self.start is not None else middle - factor * (low + high) / 2
        return start, factor[:, None] * sine, factor[:, None] * cosine

    def condition(self, draw: Floats) -> float:
        """Condition number of the candidate, infinite if it may not be run."""
        self.tried += 1
        start, sine, cosine = self.scaled(draw)
        q, qd, qdd = _series(self.times, self.period, sine, cosine)
        q = q + start
        tau = self.robot.inverse_dynamics(q, qd, qdd) + self.robot.friction_torque(qd)
        if (np.abs(tau).max(axis=0) > self.robot.limits.effort).any() or (self.accept and not self.accept(q)):
            return np.inf
        self.passed += 1
        W = self.model.columns(q, qd, qdd)[..., self.columns]
        W = W / np.maximum(np.sqrt((tau**2).mean(axis=0)), NO_EFFORT)[:, None]
        W = W.reshape(-1, len(self.columns))
        W = W / np.maximum(np.linalg.norm(W, axis=0), LEAST_DIVISOR)
        weights = np.linalg.eigvalsh(W.T @ W)
        return float(np.sqrt(weights[-1] / weights[0])) if weights[0] > NO_EXCITATION * weights[-1] else WORST_CONDITION


def _at_rest(draw: Floats) -> tuple[Floats, Floats]:
    """Coefficients nearest to the drawn ones with rate and acceleration zero at the beginning."""
    order = np.arange(1.0, draw.shape[-1] + 1)
    sine, cosine = (part - np.outer(part @ w, w) / (w @ w) for part, w in zip(draw, (order, order**2), strict=True))
    return sine, cosine


def _phases(t: Floats, period: float, harmonics: int) -> tuple[Floats, Floats]:
    """Frequencies (harmonics,) [rad/s] and angles (*times, harmonics)."""
    w = np.arange(1.0, harmonics + 1.0) * (2.0 * np.pi / period)
    return w, t[..., None] * w


def _series(t: Floats, period: float, sine: Floats, cosine: Floats) -> tuple[Floats, Floats, Floats]:
    """Position from the start, rate and acceleration, each (*times, n)."""
    w, angle = _phases(t, period, sine.shape[1])
    s, c = np.sin(angle), np.cos(angle)
    q = s @ sine.T + (c - 1.0) @ cosine.T
    return q, (c * w) @ sine.T - (s * w) @ cosine.T, -(s * w**2) @ sine.T - (c * w**2) @ cosine.T
