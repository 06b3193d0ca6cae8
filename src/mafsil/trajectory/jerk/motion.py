"""Jerk-limited motions as answers: one trajectory or a batch of them, with the limits that bind in each interval."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import Floats, frozen
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.tables import in_notebook, number, table
from mafsil.trajectory.jerk.problem import MODES, STATUSES, JerkStatus, Problem, Synchronise, sentence
from mafsil.trajectory.motion import Motion, moving_at, overview, times
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import GIVEN

if TYPE_CHECKING:
    import mafsil.trajectory.jerk.online_loops as online_loops
else:
    online_loops = lazily("mafsil.trajectory.jerk.online_loops")


QUANTITIES = ("jerk", "acceleration", "velocity")
COLUMNS = ("coordinate", "begin", "end", "quantity", "limit")


@dataclass(frozen=True, eq=False, slots=True)
class Pieces:
    """Motions made of pieces of constant jerk, each coordinate with durations of its own.

    Attributes:
        first: (rows, n, 6) of which the first three columns are the states at the start.
        count: (rows, n) numbers of pieces.
        times: (rows, n, most) their durations [s].
        jerks: (rows, n, most) [rad/s^3 | m/s^3].
    """

    first: Floats
    count: Floats
    times: Floats
    jerks: Floats

    def sample(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Position, velocity, acceleration and jerk (k, rows, n) at the times t (k, rows)."""
        rows, n = self.count.shape
        u, v, a, j = np.empty((4, len(t), rows, n))
        online_loops.sample_rows(self.first, self.count, self.times, self.jerks, t, u, v, a, j)
        return u, v, a, j

    def largest(self) -> Floats:
        """(rows, n, 3) largest sizes of position, velocity and acceleration where pieces begin and end."""
        largest = np.empty((*self.count.shape, 3))
        online_loops.largest_rows(self.first, self.count, self.times, self.jerks, largest)
        return largest


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class JerkLimitedMotion(Answer, data="duration ruling synchronised"):
    """The shortest motion between states within limits of velocity, acceleration and jerk: a trajectory and an answer.

    True if there is one. Otherwise it has no duration, `explain()` says why, and its values cannot be asked for.

    Attributes:
        problem: what was asked.
        status: how planning ended.
        duration: [s]; infinite if there is no motion.
        ruling: index of the coordinate that the duration is due to, or that forbids the motion.
        synchronised: what was done; `phase` only where all states lie on one line.
        pieces: the motion itself.
    """

    problem: Problem
    status: JerkStatus
    duration: float
    ruling: int
    synchronised: Synchronise
    pieces: Pieces

    def __repr__(self) -> str:
        return overview(self) if self else self.explain()

    def _repr_html_(self) -> str:
        return in_notebook(repr(self))

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.problem.states.shape[-2]

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration.

        Raises:
            InputError: there is no motion; its sentence says why.
        """
        moment = times(t)
        u, v, a, _ = self._values(moment)
        moving = moving_at(moment, self.duration, 1)
        return Motion(u, v * moving, a * moving)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative at the times `t` [rad/s^3 | m/s^3]; zero outside 0 .. duration."""
        moment = times(t)
        return self._values(moment)[3] * moving_at(moment, self.duration, 1)

    def breaks(self) -> Floats:
        """(k + 1,) times between which every coordinate's jerk is constant, 0 and the duration included [s]."""
        self._require()
        ends = np.concatenate([self._ends(i) for i in range(self.n)])
        return np.unique(np.concatenate([[0.0, self.duration], np.clip(ends, 0.0, self.duration)]))

    def polynomial(self) -> PiecewisePolynomial:
        """The same motion as cubics on common knots."""
        knots = self.breaks()
        if len(knots) == 1:
            return PiecewisePolynomial.from_pieces([0.0], self.at(0.0).u[None, None])
        u, v, a, j = self._values((knots[:-1] + knots[1:]) / 2)
        h = np.diff(knots)[:, None] / 2
        begin = (u - h * (v - h * (a / 2 - h * j / 6)), v - h * (a - h * j / 2), (a - h * j) / 2, j / 6)
        return PiecewisePolynomial(knots, frozen(np.stack(begin, axis=1)))

    def binding(self) -> Bindings:
        """Which limit binds where: a row for each coordinate and interval."""
        self._require()
        begins = [np.concatenate([[0.0], self._ends(i)]) for i in range(self.n)]
        states = [self.pieces.sample(t[:, None]) for t in begins]
        v, a = ([values[k][:, 0, i] for i, values in enumerate(states)] for k in (1, 2))
        jerks = [self.pieces.jerks[0, i, : len(begins[i]) - 1] for i in range(self.n)]
        return bindings_of(begins, v, a, jerks, self.problem.limits)

    def durations(self) -> Floats:
        """(n,) shortest duration of each coordinate, as if it were alone [s]."""
        own = np.empty((1, self.n))
        online_loops.own_durations(self.problem.states.reshape(1, -1, 6), self.problem.limits, self.problem.free, own)
        return own[0]

    def residual(self) -> float:
        """How far the motion's end, computed from its pieces, lies from the goal: the largest number of all."""
        reached = np.stack(self._values(np.asarray(self.duration))[:3], axis=-1)
        missed = np.abs(reached - self.problem.states[..., 3:])
        return float(missed[..., 1:].max() if self.problem.free else missed.max())

    def explain(self, language: str | None = None) -> str:
        """One sentence: how long it takes and why, or why there is none and what to do."""
        return sentence(self.problem, self.status, self.ruling, self.duration, language)

    def to_dict(self) -> dict[str, Any]:
        """Plain data: status, duration, and the pieces of each coordinate."""
        pieces = [
            {"durations": self.pieces.times[0, i, :count].tolist(), "jerks": self.pieces.jerks[0, i, :count].tolist()}
            for i, count in enumerate(self.pieces.count[0].astype(int) if self else [])
        ]
        return Answer.to_dict(self) | {"pieces": pieces}

    def _require(self) -> None:
        if not self:
            raise InputError("jerk.no_motion", reason=self.explain())

    def _ends(self, i: int) -> Floats:
        """Ends of the pieces of a coordinate."""
        return np.cumsum(self.pieces.times[0, i, : int(self.pieces.count[0, i])])

    def _values(self, moment: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """(*times, n) position, velocity, acceleration and jerk."""
        self._require()
        clamped = np.clip(moment, 0.0, self.duration).reshape(-1, 1)
        u, v, a, j = (x.reshape(*moment.shape, self.n) for x in self.pieces.sample(clamped))
        return u, v, a, j


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class JerkLimitedBatch(Answer, data="duration ruling"):
    """Many jerk-limited motions within the same limits; indexing gives one of them.

    Memory: 248 bytes for each coordinate of each row.

    Attributes:
        problem: what was asked.
        outcome: (rows, 4) status, coordinate, synchronisation and duration of each row.
        pieces: the motions themselves.
    """

    problem: Problem
    outcome: Floats
    pieces: Pieces

    @property
    def shape(self) -> tuple[int, ...]:
        """The batch dimensions."""
        return self.problem.states.shape[:-2]

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.problem.states.shape[-2]

    @property
    def duration(self) -> Floats:
        """(*batch) [s]; infinite where there is no motion."""
        return self.outcome[:, 3].reshape(self.shape)

    @property
    def ruling(self) -> NDArray[np.intp]:
        """(*batch) index of the coordinate that each duration is due to."""
        return self.outcome[:, 1].astype(np.intp).reshape(self.shape)

    @property
    def valid(self) -> NDArray[np.bool_]:
        """(*batch) where there is a motion."""
        return (self.outcome[:, 0] == 0).reshape(self.shape)

    @property
    def status(self) -> tuple[JerkStatus, ...]:
        """One for each row."""
        return tuple(STATUSES[int(code)] for code in self.outcome[:, 0])

    def __bool__(self) -> bool:
        return bool(self.valid.all())

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[JerkLimitedMotion]:
        return (self._row(row) for row in range(len(self.outcome)))

    def __getitem__(self, index: int | tuple[int, ...]) -> JerkLimitedMotion:
        """One motion by its index in the batch."""
        place = index if isinstance(index, tuple) else (index,)
        if len(place) != len(self.shape):
            raise InputError("input.shape", name="index", expected=self.shape, got=place, hint="")
        return self._row(int(np.arange(len(self.outcome)).reshape(self.shape)[place]))

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration (*times, *batch, n) of all motions at the times `t` (*times) [s].

        Before and after it a motion rests at its ends; where there is none the values are NaN.
        """
        moment = times(t)
        ends = np.where(np.isfinite(self.outcome[:, 3]), self.outcome[:, 3], 0.0)
        each = moment.reshape(-1, 1)
        values = self.pieces.sample(np.ascontiguousarray(np.clip(each, 0.0, ends)))
        moving = ((each >= 0.0) & (each <= ends)).astype(np.float64)[..., None]
        shape = (*moment.shape, *self.shape, self.n)
        void = ~self.valid.ravel()
        for x in values:
            x[:, void] = np.nan
        u, v, a = values[0], values[1] * moving, values[2] * moving
        return Motion(u.reshape(shape), v.reshape(shape), a.reshape(shape))

    def explain(self, language: str | None = None) -> str:
        """One sentence for each row that has no motion, or one for all."""
        failed = [row for row in self if not row]
        if failed:
            return "\n".join(row.explain(language) for row in failed[:20])
        longest = float(self.outcome[:, 3].max(initial=0.0))
        return JerkStatus.PLANNED.sentence(language, duration=longest, joint=0)

    def _row(self, row: int) -> JerkLimitedMotion:
        code, ruling, mode, duration = self.outcome[row]
        ask = self.problem
        states = ask.states.reshape(-1, self.n, 6)[row]
        single = Problem(states, ask.limits, ask.free, ask.mode, ask.minimum, ask.cycle)
        part = slice(row, row + 1)
        pieces = self.pieces
        own = Pieces(pieces.first[part], pieces.count[part], pieces.times[part], pieces.jerks[part])
        return JerkLimitedMotion(single, STATUSES[int(code)], float(duration), int(ruling), MODES[int(mode)], own)


@dataclass(frozen=True, slots=True)
class BindingLimit:
    """One limit that binds for a while.

    Attributes:
        coordinate: its index.
        begin, end: times [s].
        quantity: `velocity`, `acceleration` or `jerk`.
        limit: the bound that is reached.
    """

    coordinate: int
    begin: float
    end: float
    quantity: str
    limit: float


@dataclass(frozen=True, slots=True, repr=False)
class Bindings:
    """All limits that bind, by coordinate and time; a table when it is printed.

    Attributes:
        rows: one for each interval.
    """

    rows: tuple[BindingLimit, ...]

    def __iter__(self) -> Iterator[BindingLimit]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def at(self, t: float) -> tuple[BindingLimit, ...]:
        """Those that bind at the time t [s]."""
        return tuple(row for row in self.rows if row.begin <= t <= row.end)

    def explain(self, language: str | None = None) -> str:
        """A sentence and a table: a row for each interval."""
        head = [say(f"jerk.column_{name}", language=language) for name in COLUMNS]
        cells = [
            [str(row.coordinate), number(row.begin), number(row.end), self._word(row, language), number(row.limit)]
            for row in self.rows
        ]
        return "\n".join([say("jerk.bindings", language=language, count=len(cells)), *table(head, cells, language)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data: one record for each row."""
        return {"bindings": [asdict(row) for row in self.rows]}

    def __repr__(self) -> str:
        return self.explain()

    def _repr_html_(self) -> str:
        return in_notebook(self.explain())

    def _word(self, row: BindingLimit, language: str | None) -> str:
        return say(f"trajectory.{row.quantity}", language=language)


def bindings_of(begins: list[Floats], v: list[Floats], a: list[Floats], j: list[Floats], limits: Floats) -> Bindings:
    """The bindings of pieces of constant jerk.

    Args:
        begins: for each coordinate (pieces + 1,) times [s].
        v, a: for each coordinate (pieces + 1,) values at these times.
        j: for each coordinate (pieces,) jerks.
        limits: (n, 6).
    """
    rows: list[BindingLimit] = []
    for i, bounds in enumerate(limits):
        for k, jerk in enumerate(j[i]):
            begin, end = float(begins[i][k]), float(begins[i][k + 1])
            if end <= begin:
                continue
            values = (jerk, a[i][k : k + 2], v[i][k : k + 2])
            for quantity, value, pair in zip(QUANTITIES, values, (bounds[4:], bounds[2:4], bounds[:2]), strict=True):
                hit = _touch(np.asarray(value), pair)
                if hit is not None:
                    rows.append(BindingLimit(i, begin, end, quantity, hit))
    return Bindings(tuple(_join(rows)))


def _touch(value: Floats, pair: Floats) -> float | None:
    """The bound that the values keep to."""
    for bound in pair:
        if np.isfinite(bound) and (np.abs(value - bound) <= GIVEN * max(abs(bound), LEAST_DIVISOR)).all():
            return float(bound)
    return None


def _join(rows: list[BindingLimit]) -> Iterator[BindingLimit]:
    """Intervals of the same limit that follow each other as one."""
    last: BindingLimit | None = None
    for row in rows:
        same = last is not None and (row.coordinate, row.quantity, row.limit) == (
            last.coordinate,
            last.quantity,
            last.limit,
        )
        if last is not None and same and row.begin <= last.end:
            last = BindingLimit(last.coordinate, last.begin, row.end, last.quantity, last.limit)
            continue
        if last is not None:
            yield last
        last = row
    if last is not None:
        yield last
