"""What cables that only pull can hold: tensions, or the direction that proves that there are none; workspaces.

Reference: Bouchard, Gosselin and Moore, On the ability of a cable-driven robot to generate a prescribed set of
wrenches, J. Mechanisms and Robotics 2 (2010); Gouttefarde and Krut, Characterization of parallel manipulator available
wrench set facets, Advances in Robot Kinematics (2010).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, as_batch, require_finite
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.lazy_module import lazily
from mafsil.parallel.cables.cable_robot import CableRobot
from mafsil.parallel.tolerances import RANK
from mafsil.solvers import decompositions
from mafsil.solvers.linear_program import bounded_least_squares

if TYPE_CHECKING:
    import mafsil.parallel.cables.cable_loops as cable_loops
else:
    cable_loops = lazily("mafsil.parallel.cables.cable_loops")


class CableStatus(Status):
    """Whether cables can hold a load."""

    HELD = ("parallel.cables_held", True)
    BEYOND = ("parallel.cables_beyond", False)
    SINGULAR = ("parallel.cables_singular", False)


STATUSES = tuple(CableStatus)
HELPING = 1e-3
"""Force of a helper over that of a cable, for the same cost."""
EXACT = 1e-9
"""Wrench that may be missing, over the largest one that a cable makes."""


@dataclass(frozen=True, eq=False, repr=False)
class CableTensions(Answer, data="tensions missing margin direction needed offered"):
    """Tensions that hold loads; true if there are some in every row, iterable over the rows.

    A no has its proof: along `direction` the load is `needed`, and cables within their bounds make at most `offered`.

    Attributes:
        verdict: (*batch) which of HELD, BEYOND, SINGULAR: cables too few or in lines that depend on each other.
        tensions: (*batch, m) within their bounds, nearest to the preferred ones; where none hold the load those whose
            wrench comes nearest to holding it [N].
        missing: (*batch) size of the wrench that they lack, moments over the robot's `size`; zero where they hold [N].
        margin: (*batch) by which any wrench may be added, moments likewise; negative: missing at least; minus infinity
            where cables are too few or depend on each other so much that no n - 1 of them are independent [N].
        direction: (*batch, n) unit wrench about the middle of the platform's ends along which the margin is least.
        needed: (*batch) of the load along it [N].
        offered: (*batch) most that cables make along it [N].
    """

    verdict: NDArray[np.int8]
    tensions: Floats
    missing: Floats
    margin: Floats
    direction: Floats
    needed: Floats
    offered: Floats

    @property
    def held(self) -> Booleans:
        """(*batch) whether there are tensions."""
        return np.asarray(self.verdict == 0, dtype=np.bool_)

    @property
    def status(self) -> CableStatus:
        """HELD if all rows are, else that of the first row that is not."""
        bad = self.verdict[self.verdict != 0]
        return STATUSES[int(bad.flat[0])] if bad.size else CableStatus.HELD

    def __bool__(self) -> bool:
        return self.status.succeeded and self.verdict.size > 0

    def __len__(self) -> int:
        return self.verdict.size

    def __iter__(self) -> Iterator[CableTensions]:
        for row in np.ndindex(self.verdict.shape):
            yield CableTensions(
                self.verdict[row], self.tensions[row], self.missing[row], self.margin[row], self.direction[row],
                self.needed[row], self.offered[row],
            )  # fmt: skip

    def explain(self, language: str | None = None) -> str:
        """The least margin, or the proof of the first row that fails."""
        if not self.verdict.size:
            return CableStatus.HELD.sentence(language, held=0, count=0, margin=0.0, low=0.0, high=0.0)
        row = np.unravel_index(int(np.argmax(self.verdict != 0)), self.verdict.shape)
        held = self.tensions[self.held]
        return self.status.sentence(
            language, held=int(self.held.sum()), count=len(self), margin=float(self.margin.min()),
            low=float(held.min(initial=np.inf)), high=float(held.max(initial=-np.inf)), needed=float(self.needed[row]),
            offered=float(self.offered[row]), missing=float(self.missing[row]),
            direction=", ".join(f"{each:.3g}" for each in self.direction[row]),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        names = [STATUSES[k].name.lower() for k in self.verdict.ravel().tolist()]
        return Answer.to_dict(self) | {"status": names if self.verdict.ndim else names[0]}


def cable_tensions(
    robot: CableRobot, x: ArrayLike, load: ArrayLike, *, prefer: ArrayLike | None = None
) -> CableTensions:
    """Tensions of the cables that hold a load at a pose, or the proof that there are none.

    The wrenches that tensions between bounds make are a convex body; its facets, found by choosing n - 1 cables each,
    decide exactly. Among all tensions those nearest to the preferred ones are unique, and continuous along a path.

    Args:
        robot: its cables.
        x: poses T_sb (*batch, 4, 4), in the plane (x, y, phi) (*batch, 3).
        load: wrench on the platform from outside (*batch, 6 | 3) in {s} about its origin [N m, N], such as
            `robot.weight(x, mass)`; of a point its moments about that point are ignored.
        prefer: (m,) or a number; the lowest tensions if None, which costs least. The middle of the bounds is stiffest.

    Raises:
        InputError: x is no pose, a cable has length zero, wrong shapes, NaN.
    """
    F = as_batch("load", load, (3 if robot.planar else 6,), finite=True)
    W, wanted, shape = platform_wrenches(robot, x, F)
    low, high = robot.lowest, robot.highest
    aim = low if prefer is None else require_finite("prefer", np.asarray(prefer, dtype=np.float64))
    preferred = np.ascontiguousarray(np.broadcast_to(aim, (robot.m,)))
    rows, n = wanted.shape
    near = facets(robot, W, wanted)
    good = np.flatnonzero(regular(W))
    tensions, left = np.empty((rows, robot.m)), np.full(rows, np.inf)
    found, rest = np.empty((len(good), robot.m)), np.empty(len(good))
    cable_loops.tensions(W[good], low, high, preferred, wanted[good], found, rest)
    tensions[good], left[good] = found, rest
    # A load on the boundary is held as far as rounding lets one see.
    exact = left <= EXACT * np.abs(W).max(axis=(1, 2), initial=0.0) * float(high.max())
    verdict = np.where(exact, 0, 1).astype(np.int8)
    verdict[~regular(W)] = 2
    open_rows = ~exact
    tensions[open_rows] = _nearest(W[open_rows], low, high, preferred, wanted[open_rows])
    lacking = _lack(W, tensions, wanted)
    return CableTensions(
        verdict.reshape(shape), tensions.reshape(*shape, robot.m), np.where(exact, 0.0, lacking).reshape(shape),
        near.margin.reshape(shape),
        near.direction.reshape(*shape, n), (near.direction * wanted).sum(axis=1).reshape(shape),
        near.offered.reshape(shape),
    )  # fmt: skip


def _nearest(W: Floats, low: Floats, high: Floats, preferred: Floats, wanted: Floats) -> Floats:
    """(rows, m) tensions within their bounds whose wrenches W t come nearest to those wanted.

    1. Forces that make up for what the cables lack, at a cost, as further cables: then every wrench can be made.
    2. Tensions at their bounds stay there, the others are those of least squares; once more for those that then leave
       their bounds.
    3. Rows in which that has not settled, by active sets.
    """
    rows, n, m = W.shape
    if not rows:
        return np.empty((0, m))
    # 1.
    helper = HELPING * np.maximum(np.abs(W).max(axis=(1, 2)), LEAST_DIVISOR)
    most = (np.abs(wanted).max(axis=1) + np.abs(W).max(axis=(1, 2)) * high.sum()).max() / helper.min()
    wide = np.concatenate([W, helper[:, None, None] * np.eye(n)], axis=2)
    bounds = (np.concatenate([each, np.full(n, side * most)]) for each, side in ((low, -1.0), (high, 1.0)))
    lower, upper = bounds
    t, left = np.empty((rows, m + n)), np.empty(rows)
    cable_loops.tensions(wide, lower, upper, np.concatenate([preferred, np.zeros(n)]), wanted, t, left)
    # 2.
    t = np.clip(t[:, :m], low, high)
    lack = _lack(W, t, wanted)
    for _ in range(m):
        inside = (t > low) & (t < high)
        rest = wanted - np.einsum("knm,km->kn", W, t)
        step = np.einsum("kmn,kn->km", decompositions.pinv(W * inside[:, None, :], RANK), rest)
        after = np.clip(t + np.where(inside, step, 0.0), low, high)
        then = _lack(W, after, wanted)
        better = then < lack
        if not better.any():
            break
        t[better], lack[better] = after[better], then[better]
    # 3.
    for row in np.flatnonzero(~_are_settled(W, t, wanted, low, high)).tolist():
        t[row] = bounded_least_squares(W[row], wanted[row], low, high)
    return t


def _are_settled(W: Floats, t: Floats, wanted: Floats, low: Floats, high: Floats) -> Booleans:
    """(rows,) whether no tension can be changed within its bounds so that less of the wrench is missing."""
    slope = np.einsum("knm,kn->km", W, np.einsum("knm,km->kn", W, t) - wanted)
    unit = np.abs(W).max(axis=(1, 2))
    size = unit * np.maximum(np.abs(wanted).max(axis=1), unit * high.max())
    open_way = np.maximum(np.where(t > low, slope, 0.0), np.where(t < high, -slope, 0.0)).max(axis=1)
    return np.asarray(open_way <= EXACT * size, dtype=np.bool_)


def _lack(W: Floats, t: Floats, wanted: Floats) -> Floats:
    """(rows,) size of the wrench that tensions (rows, m) leave."""
    return np.linalg.norm(np.einsum("knm,km->kn", W, t) - wanted, axis=1)


def cable_margins(robot: CableRobot, x: ArrayLike, load: ArrayLike) -> Floats:
    """(*batch) margins of `cable_tensions` without the tensions; minus infinity where cables depend on each other [N].

    Args:
        robot: its cables.
        x: poses T_sb (*batch, 4, 4), in the plane (x, y, phi) (*batch, 3).
        load: (*batch, 6 | 3) as for `cable_tensions`.

    Raises:
        InputError: x is no pose, a cable has length zero, wrong shapes, NaN.
    """
    W, wanted, shape = platform_wrenches(robot, x, as_batch("load", load, (3 if robot.planar else 6,), finite=True))
    return np.where(regular(W), facets(robot, W, wanted).margin, -np.inf).reshape(shape)


class Facets(NamedTuple):
    """Where a wrench lies among the facets of what cables make.

    Attributes:
        margin: (rows,) least distance to a facet, negative outside; -infinity where no n - 1 cables are independent.
        direction: (rows, n) normal of that facet.
        offered: (rows,) most that the cables make along it.
        closure: (rows,) least over all normals of the strongest pull of a unit tension.
        loose: (rows, n) that normal.
    """

    margin: Floats
    direction: Floats
    offered: Floats
    closure: Floats
    loose: Floats


def facets(robot: CableRobot, W: Floats, wanted: Floats) -> Facets:
    """Where wrenches lie among the facets of what the cables make.

    Args:
        robot: bounds of its tensions.
        W: (rows, n, m) wrenches of unit tensions.
        wanted: (rows, n) of the cables.
    """
    rows, n = wanted.shape
    found = Facets(np.empty(rows), np.empty((rows, n)), np.empty(rows), np.empty(rows), np.empty((rows, n)))
    sides = found.margin, found.direction, found.offered, found.closure, found.loose
    if robot.m < n - 1:
        for each, value in zip(sides, (-np.inf, 0.0, 0.0, 0.0, 0.0), strict=True):
            each[...] = value
    else:
        cable_loops.margins(W, robot.lowest, robot.highest, wanted, *sides)
        none = np.isnan(found.margin)
        found.margin[none] = -np.inf
        for each in (found.direction, found.offered, found.loose):
            each[none] = 0.0
    return found


def platform_wrenches(robot: CableRobot, x: ArrayLike, load: Floats) -> tuple[Floats, Floats, tuple[int, ...]]:
    """Wrenches of unit tensions (rows, n, m) and wanted of the cables (rows, n), about the platform; the batch."""
    W = robot.structure_matrix(x)
    shape = np.broadcast_shapes(W.shape[:-2], load.shape[:-1])
    unit = robot.about_platform(x, W)
    wanted = robot.about_platform(x, -load[..., None])[..., 0]
    n, m = unit.shape[-2:]
    rows = np.ascontiguousarray(np.broadcast_to(unit, (*shape, n, m)).reshape(-1, n, m))
    return rows, np.ascontiguousarray(np.broadcast_to(wanted, (*shape, n)).reshape(-1, n)), shape


def regular(W: Floats) -> Booleans:
    """(rows,) whether unit tensions (rows, n, m) span all wrenches."""
    if W.shape[2] < W.shape[1]:
        return np.zeros(len(W), dtype=np.bool_)
    values = np.linalg.svd(W, compute_uv=False)
    return np.asarray(values[:, -1] > RANK * values[:, 0], dtype=np.bool_)
