"""Time laws by name. A law is one row of `LAWS`: adding one is a row, and its name in `LawName`.

What its peaks are follows from the row, and everything that takes a law by its name (Cartesian lines, the moves of a
job, the table of `profiles`) knows it.

Time laws that are one polynomial: a row of whole coefficients, whose peaks follow from them.

Straight lines in time from point to point, without blends: their velocity jumps, and the jumps are named.

The table of time laws: what each costs in velocity, acceleration and jerk, and how smooth it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from functools import cached_property
from math import pi
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.messages.tables import in_notebook, number, table
from mafsil.solvers import Outcome
from mafsil.trajectory.checks.requirements import continuity
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.profiles.shaped_law import (
    ExponentialApproach,
    Harmonic,
    Pieces,
    ShapedLaw,
    TimeLaw,
    shortest_duration,
)
from mafsil.trajectory.profiles.velocity_profiles import trapezoid
from mafsil.trajectory.splines.cubic_spline import points_and_durations
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial


def _value(coefficients: tuple[int, ...], x: Fraction, order: int) -> Fraction:
    """A derivative of the polynomial, exactly."""
    terms = (_falling(k, order) * c * x ** (k - order) for k, c in enumerate(coefficients) if k >= order)
    return sum(terms, start=Fraction(0))


def _falling(k: int, order: int) -> int:
    """k (k - 1) ... (k - order + 1)."""
    factor = 1
    for i in range(order):
        factor *= k - i
    return factor


@dataclass(frozen=True)
class PolynomialLaw:
    """s(x) = sum_k c_k x^k over x = t / T in 0 .. 1.

    Attributes:
        coefficients: c_0, c_1, ... in ascending powers, whole numbers.

    Raises:
        InputError: the polynomial does not lead from 0 to 1, or not from rest to rest.
    """

    coefficients: tuple[int, ...]

    def __post_init__(self) -> None:
        ends = [_value(self.coefficients, Fraction(x), order) for order in (0, 1) for x in (0, 1)]
        if ends != [0, 1, 0, 0]:
            raise InputError("trajectory.law_ends", coefficients=self.coefficients)

    @property
    def peaks(self) -> tuple[float, float, float]:
        """Largest |ds/dx|, |d2s/dx2| and |d3s/dx3|; see `TimeLaw.peaks`."""
        return self._peaks

    @cached_property
    def _peaks(self) -> tuple[float, float, float]:
        return self._peak(1), self._peak(2), self._peak(3)

    def unit(self) -> PiecewisePolynomial:
        """s(t) from 0 to 1 within one second."""
        return self.between(np.zeros(1), np.ones(1), 1.0)

    def between(self, start: Floats, goal: Floats, duration: float) -> PiecewisePolynomial:
        """The motion from `start` to `goal` (*batch, n) that takes `duration` [s]."""
        # A zero is positive, so that what stands still has no negative zero for a speed.
        rows = [c * (goal - start) / duration**k + 0.0 for k, c in enumerate(self.coefficients)]
        rows[0] = np.asarray(start, dtype=np.float64)
        return PiecewisePolynomial.from_pieces([duration], np.stack(rows)[None])

    def fastest(
        self,
        start: Floats,
        goal: Floats,
        *,
        velocity: Floats | float,
        acceleration: Floats | float,
        margin: float = 0.0,
        least: float = 0.0,
    ) -> PiecewisePolynomial:
        """The shortest motion whose peaks keep the limits; see `TimeLaw.fastest`."""
        shortest = self.shortest_duration(goal - start, velocity, acceleration)
        return self.between(start, goal, max(shortest * (1.0 + margin), least))

    def shortest_duration(self, distance: Floats, velocity: Floats | float, acceleration: Floats | float) -> float:
        """Shortest time of all coordinates together [s].

        Args:
            distance: (n,) D to go [rad | m | 1].
            velocity, acceleration: (n,) or a number, largest magnitudes.
        """
        return shortest_duration(self.peaks, distance, velocity, acceleration)

    def _peak(self, order: int) -> float:
        """Largest magnitude of a derivative over 0 .. 1, to the last digit.

        It lies at an end or where the next derivative vanishes; the value there, in rational numbers, has an error of
        the square of that of the place.
        """
        slope = np.array([float(_falling(k, order + 1) * c) for k, c in enumerate(self.coefficients)][order + 1 :])
        roots: NDArray[np.complex128] = np.zeros(0, dtype=np.complex128)
        if slope.any():
            roots = np.asarray(np.polynomial.polynomial.polyroots(np.trim_zeros(slope, "b")), dtype=np.complex128)
        inside = [float(x) for x in roots.real[np.abs(roots.imag) < 1e-8] if 0.0 < x < 1.0]
        return float(max(abs(_value(self.coefficients, Fraction(x), order)) for x in (0.0, *inside, 1.0)))


LawName: TypeAlias = Literal["cubic", "quintic", "septic", "cosine", "cycloid", "trapezoid", "double_s", "bang_bang"]
"""Laws from rest to rest, whose speed does not jump."""
ProfileName: TypeAlias = LawName | Literal["exponential"]
"""All of them."""


@dataclass(frozen=True)
class TrapezoidLaw:
    """Constant acceleration, constant speed, constant deceleration.

    Attributes:
        blend: share of the duration that each blend takes where no limits shape it.
    """

    blend: float = 0.25

    @property
    def peaks(self) -> tuple[float, float, float]:
        """Largest |ds/dx| and |d2s/dx2| of the unit motion; between its jumps of acceleration it has no jerk."""
        return 1.0 / (1.0 - self.blend), 1.0 / (self.blend * (1.0 - self.blend)), 0.0

    def unit(self) -> PiecewisePolynomial:
        """s(t) from 0 to 1 within one second."""
        return trapezoid(0.0, 1.0, acceleration=self.peaks[1], duration=1.0).value

    def between(self, start: Floats, goal: Floats, duration: float) -> PiecewisePolynomial:
        """The motion from `start` to `goal` (*batch, n) that takes `duration` [s], in the shape of the unit motion."""
        way, unit = np.asarray(goal - start), self.unit()
        coefficients = unit.coefficients.reshape(unit.coefficients.shape[:2] + (1,) * way.ndim) * way
        coefficients[:, 0] += start
        return PiecewisePolynomial(unit.knots, coefficients).scale_time(duration)

    def fastest(
        self,
        start: Floats,
        goal: Floats,
        *,
        velocity: Floats | float,
        acceleration: Floats | float,
        margin: float = 0.0,
        least: float = 0.0,
    ) -> PiecewisePolynomial:
        """The shortest motion; its peaks are the limits themselves, and its formula needs neither margin nor least."""
        return trapezoid(start, goal, velocity=velocity, acceleration=acceleration).value


def _seven_parts(accelerating: float, jerking: float) -> PiecewisePolynomial:
    """s(x) of seven parts of constant jerk, mirrored in the middle.

    Args:
        accelerating: share of the duration until the constant speed.
        jerking: share in which the acceleration grows, at most half of that.
    """
    parts = [jerking, accelerating - 2 * jerking, jerking, 1 - 2 * accelerating, jerking, accelerating - 2 * jerking]
    jerk = 1.0 / (jerking * (accelerating - jerking) * (1.0 - accelerating))
    pieces: list[list[float]] = []
    u = v = a = 0.0
    for h, j in zip([*parts, jerking], jerk * np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0]), strict=True):
        pieces.append([u, v, a / 2, j / 6])
        u, v, a = u + h * (v + h * (a / 2 + h * j / 6)), v + h * (a + h * j / 2), a + h * j
    return PiecewisePolynomial.from_pieces([*parts, jerking], np.array(pieces)[..., None])


QUINTIC = PolynomialLaw((0, 0, 0, 10, -15, 6))
"""No acceleration at its ends. Reference: Craig, Introduction to Robotics, eq. (7.18)."""
LAWS: dict[ProfileName, TimeLaw] = {
    "cubic": PolynomialLaw((0, 0, 3, -2)),
    "quintic": QUINTIC,
    "septic": PolynomialLaw((0, 0, 0, 0, 35, -84, 70, -20)),
    "cosine": ShapedLaw(Harmonic(0.5, 0.0, 0.5, pi, -pi / 2)),
    "cycloid": ShapedLaw(Harmonic(0.0, 1.0, -0.5 / pi, 2 * pi, 0.0)),
    "exponential": ShapedLaw(ExponentialApproach(time_constants=5.0)),
    "trapezoid": TrapezoidLaw(),
    "double_s": ShapedLaw(Pieces(_seven_parts(accelerating=3 / 8, jerking=1 / 8))),
    "bang_bang": ShapedLaw(Pieces(trapezoid(0.0, 1.0, acceleration=4.0, duration=1.0).value)),
}
"""All laws by name."""


def time_law(name: ProfileName) -> TimeLaw:
    """The law of that name.

    Raises:
        InputError: there is none; the sentence lists those that are.
    """
    if name not in LAWS:
        raise InputError("input.choice", name="law", value=name, known=", ".join(LAWS))
    return LAWS[name]


def rest_law(name: LawName) -> TimeLaw:
    """The law of that name, for a motion from rest to rest whose speed does not jump.

    Raises:
        InputError: there is none; the sentence lists those that are.
    """
    known = [each for each in LAWS if each != "exponential"]
    if name not in known:
        raise InputError("input.choice", name="law", value=name, known=", ".join(known))
    return LAWS[name]


def straight_lines(points: ArrayLike, durations: ArrayLike) -> Outcome[PiecewisePolynomial]:
    """u = u_j + (u_k - u_j)/d (t - T_j): the line that an arm cannot follow, for its velocity jumps at every point.

    Args:
        points: (*batch, k + 1, n) positions [rad | m]; (k + 1,) is one coordinate.
        durations: (k,) times from point to point, or one number for all [s].

    Returns:
        The motion, of which no arm is capable: the status is VELOCITY_JUMPS, its residual the largest jump, its details
        the `jumps` (k + 1, *batch, n) at all points, those from and into rest included. Without any jump nothing
        moves, and the status is PLANNED.

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive.
    """
    u, h = points_and_durations(points, durations)
    slopes = np.diff(u, axis=0) / h.reshape((-1,) + (1,) * (u.ndim - 1))
    still = np.zeros((1, *u.shape[1:]))
    jumps = np.diff(np.concatenate([still, slopes, still]), axis=0)
    largest = float(np.abs(jumps).max(initial=0.0))
    motion = PiecewisePolynomial.from_pieces(h, np.stack([u[:-1], slopes], axis=1))
    status = PlanStatus.VELOCITY_JUMPS if largest > 0.0 else PlanStatus.PLANNED
    worst = int(np.abs(jumps).reshape(len(jumps), -1).max(axis=1, initial=0.0).argmax())
    details: dict[str, object] = {"duration": motion.duration, "jumps": jumps, "index": worst}
    return Outcome(motion, status, largest, details=details)


COLUMNS = ("profile", "velocity", "acceleration", "jerk", "continuous")


@dataclass(frozen=True, slots=True)
class Profile:
    """One law from rest to rest.

    Attributes:
        name: in `LAWS`.
        velocity, acceleration, jerk: peaks of the motion over the distance 1 within 1 s: times D/T, D/T^2, D/T^3.
        order: of the highest derivative that is continuous, ends included: 0 if the velocity jumps, 1 if the
            acceleration does, 2 if the jerk does.
    """

    name: str
    velocity: float
    acceleration: float
    jerk: float
    order: int


@dataclass(frozen=True, slots=True, repr=False)
class ProfileTable:
    """All laws; iterable, printed as a table.

    Attributes:
        rows: one for each.
    """

    rows: tuple[Profile, ...]

    def __iter__(self) -> Iterator[Profile]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> Profile:
        return {row.name: row for row in self.rows}[name]

    def __repr__(self) -> str:
        return self.explain()

    def explain(self, language: str | None = None) -> str:
        """The table."""
        head = [say(f"trajectory.column_{name}", language=language) for name in COLUMNS]
        rows = [[row.name, *map(number, (row.velocity, row.acceleration, row.jerk)), str(row.order)] for row in self]
        return "\n".join([say("trajectory.profiles", language=language), *table(head, rows, language)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {row.name: asdict(row) for row in self.rows}

    def _repr_html_(self) -> str:
        return in_notebook(self.explain())


def profiles() -> ProfileTable:
    """Peaks and smoothness of all laws of `LAWS`, for distance 1 and duration 1."""
    found: list[Profile] = []
    for name, law in LAWS.items():
        found.append(Profile(name, *law.peaks, continuity(law.unit()).order))
    return ProfileTable(tuple(found))
