"""The generator that a controller calls at its update rate: position, velocity, acceleration of each tick, in time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import floor
from time import perf_counter_ns
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import Floats, positive, require_kind
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.trajectory.motion import Motion, TickStatus
from mafsil.trajectory.splines.blended_lines import BlendedLines
from mafsil.trajectory.splines.bspline import BSpline
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import ROUNDING

if TYPE_CHECKING:
    import mafsil.trajectory.jerk.online_loops as generator_loops
else:
    generator_loops = lazily("mafsil.trajectory.jerk.online_loops")


class MotionSource(Protocol):
    """What a generator needs: every trajectory has it."""

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        ...

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        ...


@dataclass(frozen=True, slots=True, repr=False)
class TickReport(Answer):
    """How long the ticks took, against the period; true if none overran it.

    Attributes:
        ticks: how many were measured.
        rate: [Hz].
        worst, mean: time of a tick [s].
        overruns: ticks that took longer than the period.
        largest_step: largest change of a coordinate from tick to tick [rad | m].
    """

    ticks: int
    rate: float
    worst: float
    mean: float
    overruns: int
    largest_step: float

    @property
    def status(self) -> TickStatus:
        """ON_TIME or OVERRUN."""
        return TickStatus.OVERRUN if self.overruns else TickStatus.ON_TIME

    def explain(self, language: str | None = None) -> str:
        """The worst tick against the period."""
        details = {name: getattr(self, name) for name in self.__slots__}
        details |= {"worst": self.worst * 1e6, "mean": self.mean * 1e6, "period": 1e6 / self.rate}
        return self.status.sentence(language, **details)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {name: getattr(self, name) for name in self.__slots__} | {"status": self.status.name.lower()}


@dataclass(eq=False)
class TrajectoryGenerator:
    """Gives the motion tick by tick; whatever it needs at a tick is there before the first one.

    Polynomials, splines and blends are evaluated by one compiled loop into the same three arrays, without a new array;
    it finds by itself which segment, straight part or blend the time is in. Other trajectories are asked by their `at`.

    Args:
        trajectory: without batch dimensions.
        rate: update rate [Hz]; the period is 1/rate.

    Attributes:
        u, v, a: (n,) of the last tick, overwritten by the next.
        index: of the next tick; its time is index/rate.
        piece: index of the piece of the last tick, -1 at rest after the end.

    Raises:
        InputError: no trajectory, a batch, a rate that is not positive.
    """

    trajectory: MotionSource
    rate: float
    u: Floats = field(init=False, repr=False)
    v: Floats = field(init=False, repr=False)
    a: Floats = field(init=False, repr=False)
    index: int = field(default=0, init=False)
    piece: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        require_kind("trajectory", self.trajectory, "Trajectory", "duration", "at")
        self.rate = positive("rate", self.rate)
        shape = self.trajectory.at(0.0).u.shape
        if len(shape) != 1:
            raise InputError("input.shape", name="trajectory", expected="one motion (n,)", got=shape, hint="")
        self.u, self.v, self.a = (np.zeros(shape) for _ in range(3))
        self._before = np.zeros(shape)
        self._pieces = _pieces(self.trajectory)
        self._blending = _blending(self.trajectory, self._pieces)
        self._arrays = (np.zeros(2), np.zeros((1, 1, shape[0])))
        if self._pieces is not None:
            self._arrays = (np.array(self._pieces.knots), np.ascontiguousarray(self._pieces.coefficients))
        # The loop is compiled before the first tick, not in it.
        self._evaluate(0.0)
        self.restart()

    @property
    def motion(self) -> Motion:
        """The arrays of the last tick; the next one overwrites them."""
        return Motion(self.u, self.v, self.a)

    @property
    def ticks(self) -> int:
        """Number of ticks from 0 to the end: after the last one the motion rests."""
        return floor(self.trajectory.duration * self.rate * (1.0 + ROUNDING)) + 1

    @property
    def blending(self) -> NDArray[np.bool_]:
        """(n,) whether each coordinate was in a blend at the last tick; never, of motions without blends."""
        if self._blending is None or self.piece < 0:
            return np.zeros(len(self.u), dtype=np.bool_)
        return self._blending[self.piece]

    def restart(self) -> None:
        """Back to the first tick; what was measured is forgotten."""
        self.index = self.piece = 0
        self._worst = self._total = self._overruns = self._measured = 0
        self._largest = 0.0

    def tick(self) -> Motion:
        """The motion at the next tick, in the generator's own arrays, measured."""
        begin = perf_counter_ns()
        np.copyto(self._before, self.u)
        self._evaluate(self.index / self.rate)
        taken = perf_counter_ns() - begin
        self._worst = max(self._worst, taken)
        self._total += taken
        self._overruns += taken * self.rate > 1e9
        if self.index:
            np.subtract(self.u, self._before, out=self._before)
            np.abs(self._before, out=self._before)
            self._largest = max(self._largest, float(self._before.max()))
        self._measured += 1
        self.index += 1
        return Motion(self.u, self.v, self.a)

    def __iter__(self) -> Iterator[Motion]:
        """All ticks from the next one to the end; copy what is to be kept."""
        while self.index < self.ticks:
            yield self.tick()

    def report(self) -> TickReport:
        """What the ticks since the start took."""
        count = max(self._measured, 1)
        worst, mean = self._worst * 1e-9, self._total * 1e-9 / count
        return TickReport(self._measured, self.rate, worst, mean, self._overruns, self._largest)

    def _evaluate(self, t: float) -> None:
        if self._pieces is None:
            motion = self.trajectory.at(t)
            self.u[:], self.v[:], self.a[:] = motion
            return
        self.piece = generator_loops.evaluate(*self._arrays, t, self.piece, self.u, self.v, self.a)


def _pieces(trajectory: MotionSource) -> PiecewisePolynomial | None:
    """The trajectory as polynomials, if it is made of them."""
    if isinstance(trajectory, PiecewisePolynomial):
        return trajectory
    return trajectory.to_polynomial() if isinstance(trajectory, BSpline | BlendedLines) else None


def _blending(trajectory: MotionSource, pieces: PiecewisePolynomial | None) -> NDArray[np.bool_] | None:
    """(pieces, n) whether each is a blend."""
    if not isinstance(trajectory, BlendedLines) or pieces is None:
        return None
    return trajectory.blending((pieces.knots[1:] + pieces.knots[:-1]) / 2)
