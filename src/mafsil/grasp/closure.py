"""Force closure: can the contacts resist every external wrench? Yes, no or on the boundary, always with the proof."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, real_array, require_finite
from mafsil.errors import InputError
from mafsil.grasp import loops
from mafsil.grasp.enclosure import ConeWrenches, SimplexVerdict, enclose, positive_combination
from mafsil.grasp.quality import (
    GraspQuality,
    agree,
    distance_to_hull,
    point_discs,
    quality_of_discs,
    quality_of_wrenches,
)
from mafsil.grasp.tolerances import NEGLIGIBLE, RANK, ROUNDOFF
from mafsil.kernels.lazy import lazy
from mafsil.messages import say
from mafsil.solvers.rational import Columns, Location, OriginLocation, locate_origin

Exact: TypeAlias = Columns | Callable[[], Columns | None]
"""Exact columns, or what gives them when they are asked for."""


class ClosureStatus(Status):
    """Whether contacts resist every external wrench, and why not."""

    CLOSED = ("grasp.closed", True)
    OPEN = ("grasp.open", False)
    TOO_FEW = ("grasp.too_few", False)
    FLAT = ("grasp.flat", False)
    COUNTED_OUT = ("grasp.counted_out", False)
    MARGINAL = ("grasp.marginal", False)
    ROUND_MARGINAL = ("grasp.round_marginal", False)

    @property
    def verdict(self) -> Literal["yes", "no", "marginal"]:
        """The status in a word: marginal, if the origin lies on the boundary and the smallest change decides."""
        if self in (ClosureStatus.MARGINAL, ClosureStatus.ROUND_MARGINAL):
            return "marginal"
        return "yes" if self.succeeded else "no"


class Margin(NamedTuple):
    """How far a verdict is from changing.

    Attributes:
        lower, upper: bounds of the margin, as `Closure.margin` has it.
        weakest_direction: (m,) of the external wrench that is hardest to resist; None where there is none.
    """

    lower: float
    upper: float
    weakest_direction: Floats | None = None


NOT_REQUESTED = Margin(float("nan"), float("nan"))
ON_BOUNDARY = Margin(0.0, 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class Closure(Answer, data="verdict force_closure rank margin combination certificate weakest_direction"):
    """A verdict on force closure with its proof, true if every external wrench is resisted.

    The margin, many times dearer than the verdict, is found when it is looked at first.

    Attributes:
        status: closed, open for one of several reasons, or marginal: the origin lies on the boundary, the smallest
            change decides.
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

    status: ClosureStatus
    rank: int
    rows: int
    measured: Margin | Callable[[], Margin]
    columns: Floats
    combination: Floats | None = None
    certificate: Floats | None = None
    exact: Location | None = None
    details: tuple[tuple[str, int], ...] = ()

    @lazy
    def _margin(self) -> Margin:
        return self.measured if isinstance(self.measured, Margin) else self.measured()

    @property
    def verdict(self) -> Literal["yes", "no", "marginal"]:
        """The status in a word."""
        return self.status.verdict

    @property
    def margin(self) -> float:
        """Epsilon quality (radius of the largest ball inside the hull of the wrenches of unit push) if yes.

        Minus the distance of the hull if no; 0 if marginal. Moments are divided by the length scale.
        """
        return self._margin.lower

    @property
    def upper(self) -> float:
        """Bound of the margin from above; differs from it only for round cones."""
        return self._margin.upper

    @property
    def weakest_direction(self) -> Floats | None:
        """(m,) direction of the external wrench that is hardest to resist, if yes."""
        return self._margin.weakest_direction

    @property
    def force_closure(self) -> bool:
        """Whether every external wrench is resisted; a marginal grasp does not."""
        return self.status.succeeded

    @property
    def converged(self) -> bool:
        """Whether `margin` and `upper` are within a millionth of each other; False too if they were not requested."""
        return agree(self.margin, self.upper)

    def explain(self, language: str | None = None) -> str:
        """The verdict and its reason in one sentence."""
        shown = "-" if self.certificate is None else vector(self.certificate)
        between = self.status.succeeded and self.margin < self.upper and not self.converged
        return say(
            "grasp.closed_between" if between else self.status.key, language=language,
            rank=self.rank, rows=self.rows, margin=self.margin, upper=self.upper,
            count=self.columns.shape[1], least=self.rows + 1, certificate=shown, **dict(self.details),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {
            "margin_upper": self.upper,
            "margin_converged": self.converged,
            "assumes": "rigid bodies",
            "exact": None if self.exact is None else self.exact.value,
        }


def closure(
    A: ArrayLike,
    *,
    exact: Exact | None = None,
    cones: ConeWrenches | None = None,
    transform: Floats | None = None,
    margins: bool = True,
) -> Closure:
    """Force closure of a set of wrenches: whether the columns positively span the space.

    1. The compiled simplex method decides all but those that are nearly on the boundary.
    2. Columns that are flat, or at most as many as rows, are a no with a certificate from their singular values.
    3. Linear programs of HiGHS bound how far beyond the origin the hull reaches (`enclosure`).
    4. What they leave open is judged by exact arithmetic, or is marginal for round cones.

    Args:
        A: (m, n) wrenches in columns; any order of rows.
        exact: the same columns, each up to a positive factor, as exact numbers; floats are taken as the decimals they
            print as. Asked (or called for) when the origin is too near the boundary. The columns of A if None and
            `cones` is None.
        cones: all wrenches, if the columns are only some of them (round cones).
        transform: (m, m) better conditioned coordinates in which to compute; rows scaled to equal size if None.
        margins: False: the margin is not requested, and NaN.

    Raises:
        InputError: no matrix of finite numbers.
    """
    W = require_finite("A", real_array("A", A))
    W = W.copy() if W is A else W
    if W.ndim != 2 or not W.size:
        raise InputError("input.shape", name="A", expected="(m, n)", got=W.shape, hint="")
    if W.shape[1] > len(W):  # 1
        M = transform
        found = positive_combination(
            W if M is None else M @ W, cones if cones is None or M is None else cones.transform(M)
        )
        if found.closed is not None:
            return _closure_of_simplex(found, W, cones, M, margins)
    return _closure_near_boundary(W, exact, cones, transform, margins)


def _closure_of_simplex(
    found: SimplexVerdict, W: Floats, cones: ConeWrenches | None, M: Floats | None, margins: bool
) -> Closure:
    """The verdict of the compiled program in coordinates M, in those of the wrenches."""
    if not found.closed:
        y = found.y if M is None else unit(M.T @ found.y)
        return _not_closed(W, y, ClosureStatus.OPEN, cones, margins)
    columns = found.columns
    if M is not None:
        columns = W if cones is None else np.asarray(np.linalg.solve(M, columns), float)
    return _closure_of(W, columns, found.x, cones, margins)


def counted_out(found: Closure, open_directions: Floats, pushes: Floats, details: dict[str, int]) -> Closure:
    """The no of contacts that are too few for their models, whatever their places.

    Args:
        found: the verdict without counting.
        open_directions: (m, q) wrenches along which no frictional contact acts.
        pushes: (m, k) wrenches of the frictionless contacts, k <= q.
        details: numbers for the sentence.
    """
    within = open_directions.T @ pushes
    y = _separating(within) if pushes.shape[1] and np.abs(within).max() > 0 else np.eye(len(within))[0]
    measured = ON_BOUNDARY if found.verdict == "marginal" else found.measured
    return Closure(
        ClosureStatus.COUNTED_OUT, found.rank, found.rows, measured, found.columns,
        certificate=unit(open_directions @ y), exact=found.exact, details=tuple(details.items()),
    )  # fmt: skip


def _closure_near_boundary(
    W: Floats, exact: Exact | None, cones: ConeWrenches | None, transform: Floats | None, margins: bool
) -> Closure:
    """Steps 2 to 4 of `closure`: few columns, flat sets, and sets near whose boundary the origin lies."""
    m, n = W.shape
    M = np.diag(1.0 / _row_sizes(W)) if transform is None else transform
    scaled = _unit_columns(M @ W) if cones is None else M @ W
    rank, null = _rank(scaled)  # 2
    if rank < m:
        status = ClosureStatus.TOO_FEW if n <= m and cones is None else ClosureStatus.FLAT
        return _not_closed(W, unit(M.T @ null), status, cones, margins, rank)
    if n <= m and cones is None:
        return _not_closed(W, unit(_separating(W)), ClosureStatus.TOO_FEW, cones, margins)
    found = enclose(scaled, None if cones is None else cones.transform(M))  # 3
    if found.decided and found.lower < 0:
        return _not_closed(W, unit(M.T @ found.certificate), ClosureStatus.OPEN, cones, margins)
    if found.decided:
        columns: Floats = W if cones is None else np.asarray(np.linalg.solve(M, found.columns), float)
        sizes = np.linalg.norm(M @ columns, axis=0) if cones is None else np.ones(columns.shape[1])
        x = found.combination / np.where(sizes > 0, sizes, 1.0)
        return _closure_of(W, columns, x / x.sum(), cones, margins)
    if cones is None:  # 4
        columns_ = exact() if callable(exact) else exact
        return _closure_of_exact_arithmetic(W, locate_origin(W.T.tolist() if columns_ is None else columns_), margins)
    y = unit(M.T @ found.certificate)
    return Closure(ClosureStatus.ROUND_MARGINAL, rank, m, ON_BOUNDARY, W, certificate=y)


def _closure_of(W: Floats, columns: Floats, x: Floats, cones: ConeWrenches | None, margins: bool) -> Closure:
    m = len(W)
    measured = partial(margin_inside, W, cones) if margins else NOT_REQUESTED
    return Closure(ClosureStatus.CLOSED, m, m, measured, columns, x)


def margin_inside(W: Floats, cones: ConeWrenches | None) -> Margin:
    """The margin of a yes.

    Args:
        W: (m, n) wrenches.
        cones: all of them, if the columns are only some.
    """
    found = _quality(W, cones)
    return Margin(found.epsilon, found.upper, -found.weakest_direction)


def _quality(W: Floats, cones: ConeWrenches | None) -> GraspQuality:
    found = None if cones is None else quality_of_discs(cones.discs)
    return quality_of_wrenches(W) if found is None else found


def _not_closed(
    W: Floats, y: Floats, status: ClosureStatus, cones: ConeWrenches | None, margins: bool, rank: int | None = None
) -> Closure:
    measured = partial(margin_outside, W, cones) if margins else NOT_REQUESTED
    m = len(W)
    return Closure(status, m if rank is None else rank, m, measured, W, certificate=y)


def margin_outside(W: Floats, cones: ConeWrenches | None) -> Margin:
    """The margin of a no; arguments as of `margin_inside`."""
    lower, upper, _ = distance_to_hull(point_discs(W) if cones is None else cones.discs)
    return Margin(-upper, -lower)


def _separating(W: Floats) -> Floats:
    """A y with W' y >= 0 for at most m columns: the hull's nearest point, or a null vector if that is the origin."""
    _, distance, y = distance_to_hull(point_discs(W))
    if distance > ROUNDOFF * float(np.abs(W).max()):
        return y
    return np.array([float(v) for v in locate_origin(W.T.tolist()).certificate or ()])


def _closure_of_exact_arithmetic(W: Floats, found: OriginLocation, margins: bool) -> Closure:
    """The verdict of exact arithmetic; a margin that the rounding of the input can undo stays marginal."""
    m, size = len(W), float(np.linalg.norm(W, axis=0).max())
    x = None if found.combination is None else np.array([float(v) for v in found.combination])
    y = None if found.certificate is None else unit(np.array([float(v) for v in found.certificate]))
    if found.place is Location.INSIDE:
        quality = quality_of_wrenches(W)
        if quality.epsilon > ROUNDOFF * size:
            assert x is not None
            measured = Margin(quality.epsilon, quality.upper, -quality.weakest_direction if margins else None)
            return Closure(ClosureStatus.CLOSED, m, m, measured, W, x / x.sum(), exact=found.place)
    if found.place is Location.OUTSIDE:
        _, distance, _ = distance_to_hull(point_discs(W))
        if distance > ROUNDOFF * size:
            measured = Margin(-distance, -distance)
            return Closure(ClosureStatus.OPEN, m, m, measured, W, certificate=y, exact=found.place)
    return Closure(ClosureStatus.MARGINAL, m, m, ON_BOUNDARY, W, certificate=y, exact=found.place)


def conditioning(points: Sequence[Floats]) -> Floats:
    """(m, m) wrenches about the origin to wrenches about the middle of the contacts, moments divided by their spread.

    Args:
        points: (d,) contact points.
    """
    where = np.array(points)
    M = np.empty((3 * (where.shape[1] - 1),) * 2)
    loops.disc_loops.conditioning(where, M)
    return M


def vector(values: Floats) -> str:
    """Numbers in round brackets, roundoff as zero."""
    size = float(np.abs(values).max()) or 1.0
    return "(" + ", ".join(f"{0.0 if abs(v) < ROUNDOFF * size else v:.4g}" for v in values) + ")"


def _rank(W: Floats) -> tuple[int, Floats]:
    U, s, _ = np.linalg.svd(W, full_matrices=True)
    rank = int((s > RANK * s[0]).sum()) if s[0] > 0 else 0
    return rank, U[:, -1]


def unit(y: Floats) -> Floats:
    """The vector of length 1."""
    return y / np.linalg.norm(y)


def _row_sizes(W: Floats) -> Floats:
    sizes = np.abs(W).max(axis=1)
    return np.where(sizes > NEGLIGIBLE * sizes.max(), sizes, sizes.max() or 1.0)


def _unit_columns(W: Floats) -> Floats:
    sizes = np.linalg.norm(W, axis=0)
    return W / np.where(sizes > 0, sizes, 1.0)
