"""What a robot's controller wrote down: times, joint coordinates and efforts, checked row by row.

What is worth saying about a log, a fit or a file is a remark, which is said in either language when it is read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, frozen, positive, real_array, require_kind
from mafsil.errors import InputError
from mafsil.messages import say


@dataclass(frozen=True, slots=True)
class Remark:
    """Something worth saying about a log, a fit or a file.

    Attributes:
        key: of the sentence in the message catalogue.
        details: what the sentence mentions; remarks among them are said in the same language.
    """

    key: str
    details: Mapping[str, object] = field(default_factory=dict[str, object])

    def sentence(self, language: str | None = None) -> str:
        """The sentence in the given language, or the current one."""
        said = {
            name: value.sentence(language) if isinstance(value, Remark) else value
            for name, value in self.details.items()
        }
        return say(self.key, language=language, **said)

    def __str__(self) -> str:
        return self.sentence()


GAP = 5.0
"""A pause longer than this many usual sampling periods is a gap: nothing is interpolated across it."""
EVEN = 0.01
"""Share of the sampling period by which times may miss an even grid and still count as even."""


@dataclass(frozen=True, eq=False, kw_only=True)
class MotionLog:
    """A recorded motion of a robot.

    Attributes:
        t: (N,) times [s], increasing.
        q: (N, n) joint coordinates [rad | m].
        tau: (N, n) joint efforts [N m | N].
        qd: (N, n) measured joint rates, or None.
        qdd: (N, n) measured joint accelerations, or None.
        source: name of the file, for sentences.
        lines: (N,) line of each row in the file; rows counted from 0 if None.

    Arrays are copied.

    Raises:
        InputError: shapes that do not fit, NaN or infinities, times that do not increase; the row is named.
    """

    t: ArrayLike
    q: ArrayLike
    tau: ArrayLike
    qd: ArrayLike | None = None
    qdd: ArrayLike | None = None
    source: str = ""
    lines: NDArray[np.int64] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        times = frozen(real_array("t", self.t))
        if times.ndim != 1 or len(times) < 2:
            raise InputError("input.shape", name="t", expected="(N,), N > 1", got=times.shape, hint="")
        object.__setattr__(self, "t", times)
        expected: tuple[Any, ...] = (len(times), "n")
        for name in ("q", "tau", "qd", "qdd"):
            if name in ("qd", "qdd") and getattr(self, name) is None:
                continue
            array = frozen(real_array(name, getattr(self, name)))
            if array.ndim != 2 or len(array) != len(times) or ("n" not in expected and array.shape != expected):
                raise InputError("input.shape", name=name, expected=expected, got=array.shape, hint="")
            expected = array.shape
            object.__setattr__(self, name, array)
        self._require_clean()

    def _require_clean(self) -> None:
        """No NaN, no time that stands still or runs back."""
        for name, array in (("t", self.times), *self.signals().items()):
            bad = np.argwhere(~np.isfinite(array))
            if len(bad):
                value = float(array[tuple(bad[0])])
                raise InputError("identification.not_finite", row=int(bad[0, 0]), name=name, value=value)
        backward = np.flatnonzero(np.diff(self.times) <= 0.0)
        if len(backward):
            k = int(backward[0]) + 1
            raise InputError("identification.time_order", row=k, now=self.times[k], before=self.times[k - 1])

    @property
    def times(self) -> Floats:
        """(N,) times [s]."""
        return np.asarray(self.t)

    @property
    def n(self) -> int:
        """Number of joint coordinates."""
        return np.asarray(self.q).shape[1]

    @property
    def period(self) -> float:
        """Usual sampling period [s]: the median."""
        return float(np.median(np.diff(self.times)))

    @property
    def duration(self) -> float:
        """From the first to the last row [s]."""
        return float(self.times[-1] - self.times[0])

    def signals(self) -> dict[str, Floats]:
        """All arrays (N, n) that the log has, by name."""
        named = {name: getattr(self, name) for name in ("q", "tau", "qd", "qdd")}
        return {name: np.asarray(array) for name, array in named.items() if array is not None}

    def place(self, row: int) -> Remark:
        """Where a row stands: line of the file, or row of the arrays."""
        if self.lines is None:
            return Remark("identification.row", {"row": row})
        return Remark("identification.line", {"source": self.source, "line": int(self.lines[row])})

    def rows(self, start: int, stop: int) -> MotionLog:
        """The rows from `start` up to `stop`, not included."""
        part = slice(start, stop)
        arrays = {name: array[part] for name, array in self.signals().items()}
        return replace(self, t=self.times[part], lines=None if self.lines is None else self.lines[part], **arrays)

    def without_rates(self) -> MotionLog:
        """The same log, its measured rates and accelerations forgotten."""
        return replace(self, qd=None, qdd=None)

    def split(self, fraction: float) -> tuple[MotionLog, MotionLog | None]:
        """The log up to the last `fraction` of its time, and that last part, unless it is next to nothing."""
        end = float(self.times[-1]) - fraction * self.duration
        cut = int(np.searchsorted(self.times, end))
        if not 2 <= cut <= len(self.times) - 2:
            return self, None
        return self.rows(0, cut), self.rows(cut, len(self.times))

    def gaps(self) -> list[int]:
        """Rows after which time jumps by more than GAP usual periods."""
        return [int(k) for k in np.flatnonzero(np.diff(self.times) > GAP * self.period)]

    def segments(self) -> list[MotionLog]:
        """The log cut at its gaps."""
        cuts = [0, *(k + 1 for k in self.gaps()), len(self.times)]
        return [self.rows(a, b) for a, b in pairwise(cuts)]

    def even(self) -> tuple[float, dict[str, Floats]]:
        """The sampling period [s] and the signals on an even grid of times; call it on a segment.

        Times that miss the grid by more than EVEN of a period are interpolated by cubic splines.
        """
        count = max(round(self.duration / self.period), 1)
        period = self.duration / count
        grid = self.times[0] + period * np.arange(count + 1)
        if count + 1 == len(self.times) and np.abs(grid - self.times).max() <= EVEN * period:
            return period, self.signals()
        if len(self.times) < 4:
            return period, {name: array[:0] for name, array in self.signals().items()}
        from scipy.interpolate import CubicSpline

        return period, {name: CubicSpline(self.times, array)(grid) for name, array in self.signals().items()}

    def remarks(self) -> list[Remark]:
        """What is irregular: gaps and uneven sampling, with the place."""
        found = [
            Remark("identification.gap", {"place": self.place(k), "seconds": self.times[k + 1] - self.times[k]})
            for k in self.gaps()[:SHOWN]
        ]
        if len(self.gaps()) > SHOWN:
            found.append(Remark("identification.more_gaps", {"count": len(self.gaps()) - SHOWN}))
        steps = np.diff(self.times)
        inside = np.where(steps > GAP * self.period, self.period, steps)
        worst = int(np.abs(inside - self.period).argmax())
        if abs(inside[worst] - self.period) > 0.1 * self.period:
            details = {"place": self.place(worst), "step": steps[worst] * 1e3, "usual": self.period * 1e3}
            found.append(Remark("identification.uneven", details))
        return found


SHOWN = 5
"""Gaps that are named one by one."""


def log_of(value: object, n: int) -> MotionLog:
    """A log from whatever has t, q and tau: a MotionLog, a Recording; checked for the number of joints.

    Args:
        value: what the user gave.
        n: number of joint coordinates of the robot.

    Raises:
        InputError: something else, or another number of joints.
    """
    require_kind("log", value, "MotionLog, Recording or file", "t", "q", "tau")
    given: Any = value
    log = value if isinstance(value, MotionLog) else MotionLog(t=given.t, q=given.q, tau=given.tau)
    if log.n != n:
        raise InputError("identification.joints", got=log.n, expected=n)
    return log


def held_out_fraction(name: str, value: float) -> float:
    """The value itself, if it is a fraction of a log that may be held out: from 0 to 0.9.

    Raises:
        InputError: it is not.
    """
    if value and positive(name, value) > 0.9:
        raise InputError("input.range", name=name, value=value, low=0.0, high=0.9)
    return float(value)
