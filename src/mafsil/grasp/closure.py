"""Force closure: can the contacts resist every external wrench? Yes, no or on the boundary, always with the proof."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, real_array, require_finite
from mafsil.errors import InputError
from mafsil.grasp.ball import Ball, agree, distance_to_hull, finite_ball, inscribed_ball, point_discs
from mafsil.grasp.cone import RoundSet
from mafsil.grasp.enclosure import Quick, enclose, quick
from mafsil.kernels.lazy import lazy
from mafsil.messages import say
from mafsil.solvers.rational import Columns, Judgement, Place, judge

ROUNDING = 1e-12
"""A margin below this share of the largest wrench is rounding of the input: marginal."""
Exact: TypeAlias = Columns | Callable[[], Columns | None]
"""Exact columns, or what gives them when they are asked for."""
NOISE = 1e-14
"""Rows below this share of the largest are rounding."""
RANK = 1e-10
"""Singular values below this share of the largest count as zero."""


class Verdict(Enum):
    """The three answers."""

    YES = "yes"
    NO = "no"
    MARGINAL = "marginal"


class Margin(NamedTuple):
    """How far a verdict is from changing.

    Attributes:
        lower, upper: bounds of the margin, as `Closure.margin` has it.
        weakest: (m,) direction of the external wrench that is hardest to resist; None where there is none.
    """

    lower: float
    upper: float
    weakest: Floats | None = None


NOT_ASKED = Margin(float("nan"), float("nan"))
AT_THE_EDGE = Margin(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Closure:
    """A verdict on force closure with its proof; the margin, many times dearer than the verdict, at the first look.

    Attributes:
        verdict: yes, no, or marginal: the origin lies on the boundary, the smallest change decides.
        reason: key of the sentence that explains it.
        rank: of the wrenches.
        rows: m, 3 in the plane and 6 in space.
        measured: the margin, or what finds it.
        columns: (m, n) wrenches that the proof uses.
        combination: (n,) all > 0 with columns x = 0 (and rank m): the proof of a yes; None otherwise.
        certificate: (m,) y != 0 with y . w >= 0 for every wrench of the contacts: the external wrench y cannot be
            resisted, and without friction the body is free to move along the twist y. None for a yes.
        exact: where exact arithmetic places the origin, if it was asked.
        details: further numbers of the sentence.
    """

    verdict: Verdict
    reason: str
    rank: int
    rows: int
    measured: Margin | Callable[[], Margin]
    columns: Floats
    combination: Floats | None = None
    certificate: Floats | None = None
    exact: Place | None = None
    details: tuple[tuple[str, int], ...] = ()

    @lazy
    def _margin(self) -> Margin:
        return self.measured if isinstance(self.measured, Margin) else self.measured()

    @property
    def margin(self) -> float:
        """Radius of the largest ball about the origin inside the hull of the wrenches of unit push if yes.

        Minus the distance of the hull if no; 0 if marginal. Moments are divided by the length scale.
        """
        return self._margin.lower

    @property
    def upper(self) -> float:
        """Bound of the margin from above; differs from it only for round cones."""
        return self._margin.upper

    @property
    def weakest(self) -> Floats | None:
        """(m,) direction of the external wrench that is hardest to resist, if yes."""
        return self._margin.weakest

    @property
    def force_closure(self) -> bool:
        """Whether every external wrench is resisted; a marginal grasp does not."""
        return self.verdict is Verdict.YES

    @property
    def met(self) -> bool:
        """Whether `margin` and `upper` are within a millionth of each other; False too if they were not asked for."""
        return agree(self.margin, self.upper)

    def __bool__(self) -> bool:
        return self.force_closure

    def explain(self, language: str | None = None) -> str:
        """The verdict and its reason in one sentence."""
        shown = "-" if self.certificate is None else vector(self.certificate)
        between = self.reason == "grasp.closed" and self.margin < self.upper and not self.met
        return say(
            "grasp.closed_between" if between else self.reason, language=language,
            rank=self.rank, rows=self.rows, margin=self.margin, upper=self.upper,
            count=self.columns.shape[1], least=self.rows + 1, certificate=shown, **dict(self.details),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "verdict": self.verdict.value,
            "force_closure": self.force_closure,
            "reason": self.reason.partition(".")[2],
            "rank": self.rank,
            "margin": self.margin,
            "margin_upper": self.upper,
            "margin_met": self.met,
            "combination": self.combination,
            "certificate": self.certificate,
            "weakest": self.weakest,
            "assumes": "rigid bodies",
            "exact": None if self.exact is None else self.exact.value,
        }


def closure(
    A: ArrayLike,
    *,
    exact: Exact | None = None,
    whole: RoundSet | None = None,
    transform: Floats | None = None,
    margins: bool = True,
) -> Closure:
    """Do the columns span the whole space with positive weights?

    Args:
        A: (m, n) wrenches in columns; any order of rows.
        exact: the same columns, each up to a positive factor, as exact numbers; floats are taken as the decimals they
            print as. Asked (or called for) when the origin is too near the boundary. The columns of A if None and
            `whole` is None.
        whole: all wrenches, if the columns are only some of them (round cones).
        transform: (m, m) better conditioned coordinates in which to compute; rows scaled to equal size if None.
        margins: False: the margin is not wanted, and NaN.

    Raises:
        InputError: no matrix of finite numbers.
    """
    W = require_finite("A", real_array("A", A))
    W = W.copy() if W is A else W
    if W.ndim != 2 or not W.size:
        raise InputError("input.shape", name="A", expected="(m, n)", got=W.shape, hint="")
    if W.shape[1] > len(W):
        M = transform
        found = quick(W if M is None else M @ W, whole if whole is None or M is None else whole.changed(M))
        if found.closed is not None:
            return _decided(found, W, whole, M, margins)
    return _careful(W, exact, whole, transform, margins)


def _decided(found: Quick, W: Floats, whole: RoundSet | None, M: Floats | None, margins: bool) -> Closure:
    """The verdict of the compiled program in coordinates M, in those of the wrenches."""
    if not found.closed:
        return _no(W, found.y if M is None else unit(M.T @ found.y), "grasp.open", whole, margins)
    columns = found.columns
    if M is not None:
        columns = W if whole is None else np.asarray(np.linalg.solve(M, columns), float)
    return _yes(W, columns, found.x, whole, margins)


def counted_out(found: Closure, open_directions: Floats, pushes: Floats, details: dict[str, int]) -> Closure:
    """The no of contacts that are too few for their models, whatever their places.

    Args:
        found: the verdict without counting.
        open_directions: (m, q) wrenches along which no frictional contact acts.
        pushes: (m, k) wrenches of the frictionless contacts, k <= q.
        details: numbers for the sentence.
    """
    inside = open_directions.T @ pushes
    y = _separating(inside) if pushes.shape[1] and np.abs(inside).max() > 0 else np.eye(len(inside))[0]
    measured = AT_THE_EDGE if found.verdict is Verdict.MARGINAL else found.measured
    return Closure(
        Verdict.NO, "grasp.counted_out", found.rank, found.rows, measured, found.columns,
        certificate=unit(open_directions @ y), exact=found.exact, details=tuple(details.items()),
    )  # fmt: skip


def _careful(
    W: Floats, exact: Exact | None, whole: RoundSet | None, transform: Floats | None, margins: bool
) -> Closure:
    """Few columns, flat sets, and sets near whose boundary the origin lies."""
    m, n = W.shape
    M = np.diag(1.0 / _row_sizes(W)) if transform is None else transform
    scaled = _unit_columns(M @ W) if whole is None else M @ W
    rank, null = _rank(scaled)
    if rank < m:
        reason = "grasp.too_few" if n <= m and whole is None else "grasp.flat"
        return _no(W, unit(M.T @ null), reason, whole, margins, rank)
    if n <= m and whole is None:
        return _no(W, unit(_separating(W)), "grasp.too_few", whole, margins)
    found = enclose(scaled, None if whole is None else whole.changed(M))
    if found.decided and found.lower < 0:
        return _no(W, unit(M.T @ found.certificate), "grasp.open", whole, margins)
    if found.decided:
        columns: Floats = W if whole is None else np.asarray(np.linalg.solve(M, found.columns), float)
        sizes = np.linalg.norm(M @ columns, axis=0) if whole is None else np.ones(columns.shape[1])
        x = found.combination / np.where(sizes > 0, sizes, 1.0)
        return _yes(W, columns, x / x.sum(), whole, margins)
    if whole is None:
        columns_ = exact() if callable(exact) else exact
        return _judged(W, judge(W.T.tolist() if columns_ is None else columns_), margins)
    y = unit(M.T @ found.certificate)
    return Closure(Verdict.MARGINAL, "grasp.round_marginal", rank, m, AT_THE_EDGE, W, certificate=y)


def _yes(W: Floats, columns: Floats, x: Floats, whole: RoundSet | None, margins: bool) -> Closure:
    m = len(W)
    measured = partial(inside, W, whole) if margins else NOT_ASKED
    return Closure(Verdict.YES, "grasp.closed", m, m, measured, columns, x)


def inside(W: Floats, whole: RoundSet | None) -> Margin:
    """The margin of a yes.

    Args:
        W: (m, n) wrenches.
        whole: all of them, if the columns are only some.
    """
    ball = _ball(W, whole)
    return Margin(ball.radius, ball.upper, -ball.weakest)


def _ball(W: Floats, whole: RoundSet | None) -> Ball:
    found = None if whole is None else inscribed_ball(whole.discs)
    return finite_ball(W) if found is None else found


def _no(W: Floats, y: Floats, reason: str, whole: RoundSet | None, margins: bool, rank: int | None = None) -> Closure:
    measured = partial(outside, W, whole) if margins else NOT_ASKED
    m = len(W)
    return Closure(Verdict.NO, reason, m if rank is None else rank, m, measured, W, certificate=y)


def outside(W: Floats, whole: RoundSet | None) -> Margin:
    """The margin of a no; arguments as of `inside`."""
    lower, upper, _ = distance_to_hull(point_discs(W) if whole is None else whole.discs)
    return Margin(-upper, -lower)


def _separating(W: Floats) -> Floats:
    """A y with W' y >= 0 for at most m columns: the hull's nearest point, or a null vector if that is the origin."""
    _, distance, y = distance_to_hull(point_discs(W))
    if distance > ROUNDING * float(np.abs(W).max()):
        return y
    return np.array([float(v) for v in judge(W.T.tolist()).certificate or ()])


def _judged(W: Floats, found: Judgement, margins: bool) -> Closure:
    """The verdict of exact arithmetic; a margin that the rounding of the input can undo stays marginal."""
    m, size = len(W), float(np.linalg.norm(W, axis=0).max())
    x = None if found.combination is None else np.array([float(v) for v in found.combination])
    y = None if found.certificate is None else unit(np.array([float(v) for v in found.certificate]))
    if found.place is Place.INSIDE:
        ball = finite_ball(W)
        if ball.radius > ROUNDING * size:
            assert x is not None
            measured = Margin(ball.radius, ball.upper, -ball.weakest if margins else None)
            return Closure(Verdict.YES, "grasp.closed", m, m, measured, W, x / x.sum(), exact=found.place)
    if found.place is Place.OUTSIDE:
        _, distance, _ = distance_to_hull(point_discs(W))
        if distance > ROUNDING * size:
            measured = Margin(-distance, -distance)
            return Closure(Verdict.NO, "grasp.open", m, m, measured, W, certificate=y, exact=found.place)
    return Closure(Verdict.MARGINAL, "grasp.marginal", m, m, AT_THE_EDGE, W, certificate=y, exact=found.place)


def conditioning(points: Sequence[Floats]) -> Floats:
    """(m, m) wrenches about the origin to wrenches about the middle of the contacts, moments divided by their spread.

    Args:
        points: (d,) contact points.
    """
    from mafsil.solvers import contact_loops

    where = np.array(points)
    M = np.empty((3 * (where.shape[1] - 1),) * 2)
    contact_loops.conditioning(where, M)
    return M


def vector(values: Floats) -> str:
    """Numbers in round brackets, dust as zero."""
    size = float(np.abs(values).max()) or 1.0
    return "(" + ", ".join(f"{0.0 if abs(v) < 1e-12 * size else v:.4g}" for v in values) + ")"


def _rank(W: Floats) -> tuple[int, Floats]:
    U, s, _ = np.linalg.svd(W, full_matrices=True)
    rank = int((s > RANK * s[0]).sum()) if s[0] > 0 else 0
    return rank, U[:, -1]


def unit(y: Floats) -> Floats:
    """The vector of length 1."""
    return y / np.linalg.norm(y)


def _row_sizes(W: Floats) -> Floats:
    sizes = np.abs(W).max(axis=1)
    return np.where(sizes > NOISE * sizes.max(), sizes, sizes.max() or 1.0)


def _unit_columns(W: Floats) -> Floats:
    sizes = np.linalg.norm(W, axis=0)
    return W / np.where(sizes > 0, sizes, 1.0)
