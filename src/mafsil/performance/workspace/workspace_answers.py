"""Workspaces as answers: maps of what was reached, and annuli of planar 2R and 3R arms, known in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.messages import say


@dataclass(frozen=True, slots=True)
class Annulus:
    """All points whose distance from the first axis lies between two radii; a disc if the inner one is zero.

    Attributes:
        inner, outer: [m].
    """

    inner: float
    outer: float

    @property
    def area(self) -> float:
        """[m^2]."""
        return pi * (self.outer**2 - self.inner**2)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """(*batch) whether points (*batch, 2), seen from the first axis, lie within."""
        distance = np.linalg.norm(as_batch("points", points, (2,)), axis=-1)
        return (distance >= self.inner) & (distance <= self.outer)


def reachable_annulus(lengths: ArrayLike) -> Annulus:
    """The annulus that the tip of a planar chain without joint limits reaches: 2R, 3R and longer.

    outer = sum of lengths; inner = longest - the others, or 0.

    Args:
        lengths: (k,) of the links [m], none negative.

    Raises:
        InputError: no lengths, or a negative one.
    """
    L = _lengths(lengths)
    return Annulus(max(0.0, float(2 * L.max() - L.sum())), float(L.sum()))


def dexterous_annuli(lengths: ArrayLike) -> tuple[Annulus, ...]:
    """Where a planar 3R arm without joint limits has every orientation: none, one or two annuli (or discs).

    The second joint's far end must reach the whole circle of radius L3 about the tip, at distances |r - L3| .. r + L3
    from the first axis, within the annulus of the first two links: r + L3 <= outer and |r - L3| >= inner.

    Args:
        lengths: (3,) of the links [m].
    """
    L = _lengths(lengths)
    if len(L) != 3:
        raise InputError("input.shape", name="lengths", expected="(3,)", got=L.shape, hint="")
    inner_annulus, last = reachable_annulus(L[:2]), float(L[2])
    most = inner_annulus.outer - last
    pieces = (
        [(0.0, most)]
        if inner_annulus.inner == 0.0
        else [(0.0, min(last - inner_annulus.inner, most)), (last + inner_annulus.inner, most)]
    )
    return tuple(Annulus(inner, outer) for inner, outer in pieces if inner <= outer and outer > 0.0)


def _lengths(lengths: ArrayLike) -> NDArray[np.float64]:
    L = np.atleast_1d(as_batch("lengths", lengths, (), finite=True))
    if L.ndim != 1 or not len(L) or (L < 0).any():
        raise InputError("performance.lengths", got=L.tolist())
    return L


BANDS = 8
"""Approach directions are counted in BANDS x BANDS cells of equal area on the sphere (64 bits)."""


View = Literal["xyz", "xy", "xz", "yz", "radial"]


class WorkspaceStatus(Status):
    """Whether anything of the space that a map shows was reached."""

    REACHED = ("performance.workspace", True)
    NOTHING_REACHED = ("performance.workspace_nothing", False)
    """No sample fell into the slice: none was found, which proves nothing."""


@dataclass(frozen=True, eq=False, repr=False)
class WorkspaceMap(Answer, data="robot view unit cell samples seed bounds"):
    """A grid of workspace cells and the samples in them; true if any cell was reached.

    Attributes:
        robot: name.
        view: `xyz`; `xy`, `xz`, `yz` (projection, or slice if one was asked for); `radial` (distance from the z axis of
            {s}, z): the section of an arm whose first axis is that one and turns freely.
        origin: (d,) lower corner of the grid [m].
        cell: edge of a cell [m].
        counts: grid of how many samples fell into each cell.
        directions: grid of bit masks of approach directions seen, or None if not asked for.
        samples: how many configurations were drawn.
        inside: how many of them fell into the slice (all, if there is none).
        seed: of the generator.
        given: ranges (low, high) [rad | m] by joint that were given for the map, in place of limits of the robot.
    """

    robot: str
    view: str
    origin: Floats
    cell: float
    counts: NDArray[np.uint32]
    directions: NDArray[np.uint64] | None
    samples: int
    inside: int
    seed: int
    given: Mapping[str, tuple[float, float]] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def status(self) -> WorkspaceStatus:
        """Whether any cell was reached."""
        return WorkspaceStatus.REACHED if self.counts.any() else WorkspaceStatus.NOTHING_REACHED

    @property
    def unit(self) -> str:
        """Of sizes: `m^2` of flat views, else `m^3`."""
        return "m^2" if self.counts.ndim == 2 and self.view != "radial" else "m^3"

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """Ends of the reached cells along every axis of the grid, by its name [m]; empty if nothing was reached."""
        if not self:
            return {}
        where = np.argwhere(self.reached)
        low = self.origin + self.cell * where.min(axis=0)
        high = self.origin + self.cell * (where.max(axis=0) + 1)
        names = ("ρ", "z") if self.view == "radial" else tuple(self.view)
        return {name: (float(a), float(b)) for name, a, b in zip(names, low, high, strict=True)}

    def to_dict(self) -> dict[str, Any]:
        """Plain data: sizes, bounds and voids; the grid itself is `counts`."""
        size, error = self.volume()
        voids = [{"place": void[:-1], "size": float(void[-1])} for void in self.voids()]
        return Answer.to_dict(self) | {"size": size, "error": error, "voids": voids}

    @property
    def reached(self) -> NDArray[np.bool_]:
        """The grid of reached cells."""
        return self.counts > 0

    @property
    def boundary(self) -> NDArray[np.bool_]:
        """Reached cells with a neighbour (across a face) that is not."""
        reached = np.pad(self.reached, 1)
        inner = reached.copy()
        for axis in range(reached.ndim):
            inner &= np.roll(reached, 1, axis) & np.roll(reached, -1, axis)
        core = tuple(slice(1, -1) for _ in range(reached.ndim))
        return self.reached & ~inner[core]

    @property
    def dexterity(self) -> Floats:
        """The grid of shares 0 .. 1 of approach directions with which a cell was seen: a lower bound.

        It needs several samples for each of the 64 directions; `settled` tells which cells have them.

        Raises:
            InputError: directions were not recorded.
        """
        if self.directions is None:
            raise InputError("performance.no_directions")
        return np.bitwise_count(self.directions).astype(float) / self._direction_cells

    @property
    def _direction_cells(self) -> int:
        return BANDS * BANDS

    @property
    def settled(self) -> NDArray[np.bool_]:
        """The grid of cells with at least six samples for each direction: their dexterity hardly grows any more."""
        return self.counts >= 6 * self._direction_cells

    def dexterous(self, share: float = 1.0) -> NDArray[np.bool_]:
        """The grid of cells reached with at least this share of directions."""
        return self.dexterity >= share

    def volume(self, cells: NDArray[np.bool_] | None = None) -> tuple[float, float]:
        """Volume [m^3] (area [m^2] of flat views, volume swept about z of the radial one), with its error.

        Cells at the boundary count one half; the error is the other half, plus one and a half times the space that
        Good and Turing's estimate leaves unseen: the share of samples in cells hit only once.

        Args:
            cells: grid of the cells that count; the reached ones if None.
        """
        chosen = self.reached if cells is None else cells
        size = self._sizes()
        edge = self.boundary & chosen
        half = 0.5 * float((size * edge).sum())
        unseen = float((self.counts == 1).sum()) / max(self.inside, 1)
        total = float((size * chosen).sum()) - half
        return total, half + 1.5 * unseen * total

    def _sizes(self) -> Floats:
        flat: Floats = np.full(self.counts.shape, self.cell**self.counts.ndim)
        if self.view == "radial":
            flat = flat * (2 * np.pi * self.centres(0))[:, None]
        return flat

    def voids(self, smallest: int = 12) -> tuple[Floats, ...]:
        """Holes: connected empty regions that do not touch the outside of the grid, largest first.

        Args:
            smallest: number of cells below which an empty region counts as not yet sampled.

        Returns:
            For each, its middle followed by its size: (d + 1,) [m], [m^3 | m^2].
        """
        import scipy.ndimage

        connected: Any = scipy.ndimage.label  # carries no types
        widen = [(0 if self.view == "radial" and axis == 0 else 1, 1) for axis in range(self.counts.ndim)]
        labels: NDArray[np.int64] = connected(~np.pad(self.reached, widen))[0]
        core = tuple(slice(before, -1) for before, _ in widen)
        sizes: NDArray[np.int64] = np.bincount(labels.ravel())
        outside = labels[(-1,) * labels.ndim]
        inner = labels[core]
        found: list[Floats] = []
        for label in np.flatnonzero(sizes >= smallest).tolist():
            if label in (0, outside):
                continue
            where = np.argwhere(inner == label)
            middle = self.origin + self.cell * (where.mean(axis=0) + 0.5)
            found.append(np.array([*middle, float(self._sizes()[tuple(where.T)].sum())]))
        return tuple(sorted(found, key=lambda void: -void[-1]))

    def centres(self, axis: int) -> Floats:
        """Middles of the cells along an axis of the grid [m]."""
        count: int = self.counts.shape[axis]
        return self.origin[axis] + self.cell * (np.arange(count) + 0.5)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """(*batch) whether points (*batch, d), in the coordinates of the view, lie in reached cells."""
        index = np.floor((as_batch("points", points, (self.counts.ndim,)) - self.origin) / self.cell).astype(int)
        inside = ((index >= 0) & (index < self.counts.shape)).all(axis=-1)
        index = np.clip(index, 0, np.array(self.counts.shape) - 1)
        return inside & self.reached[tuple(np.moveaxis(index, -1, 0))]

    def explain(self, language: str | None = None) -> str:
        """Samples, size with its error, voids."""
        size, error = self.volume()
        sentence = self.status.sentence(
            language,
            robot=self.robot,
            samples=self.samples,
            size=size,
            error=error,
            unit=self.unit,
            voids=len(self.voids()),
            cell=self.cell,
        )
        if not self.given:
            return sentence
        ranges = "; ".join(f"{joint} [{low:.4g}, {high:.4g}]" for joint, (low, high) in self.given.items())
        return f"{sentence}\n{say('performance.workspace_given', language=language, ranges=ranges)}"
