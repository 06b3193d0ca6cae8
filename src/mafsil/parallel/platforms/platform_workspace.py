"""Where a platform on six legs can be: lengths, cones of the joints and legs that keep apart, on a grid of places.

Every place of the grid is judged for every orientation that is asked for. A place with all orientations allowed belongs
to the workspace with all of them, with one allowed to the reachable workspace. Volumes are sums of cells; cells whose
neighbours differ are the boundary, and half of them is how far the volume may be wrong.

Reference: Merlet, Parallel Robots, ch. 7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, as_batch, not_negative, number, positive, single, whole
from mafsil.errors import InputError
from mafsil.fields import check_fields
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import rotation
from mafsil.parallel.legs.leg_lines import line_matrix
from mafsil.parallel.platforms.stewart import StewartPlatform

BLOCK = 4096
"""Poses that are judged at once: some 20 MB with all pairs of legs."""
REASONS = ("short", "long", "base_cone", "platform_cone", "legs_meet", "singular")
"""Why a pose is not allowed, in the order in which reasons are counted."""


@dataclass(frozen=True)
class PlatformLimits:
    """Limits of the legs of a platform.

    Attributes:
        shortest, longest: lengths of every leg [m].
        base_cone: largest angle of a leg from z of {s} at the base [rad].
        platform_cone: largest angle of a leg from z of {b} at the platform [rad].
        leg_radius: of the legs as capsules [m]; zero, they may touch.
        least_measure: poses whose Jacobian has a least singular value below it are refused, moments over the size.
    """

    shortest: float
    longest: float
    base_cone: float = np.pi
    platform_cone: float = np.pi
    leg_radius: float = 0.0
    least_measure: float = 0.0
    _numbers = check_fields(
        shortest=number, longest=positive, base_cone=positive, platform_cone=positive, leg_radius=not_negative,
        least_measure=not_negative,
    )  # fmt: skip

    def __post_init__(self) -> None:
        self._numbers()
        if not 0 <= self.shortest < self.longest:
            raise InputError("parallel.stroke", low=self.shortest, high=self.longest)


class WorkspaceStatus(Status):
    """Whether some place is allowed."""

    SOME = ("parallel.workspace_some", True)
    EMPTY = ("parallel.workspace_empty", False)


@dataclass(frozen=True, eq=False, repr=False)
class PlatformWorkspace(Answer, data="axes allowed reasons", entries="allowed"):
    """Where a platform can be, on a grid; true if it can be anywhere, iterable over the orientations.

    Attributes:
        axes: places of the grid along x, y and z [m].
        allowed: (k, nx, ny, nz) for each of k orientations.
        reasons: poses that were refused by each of REASONS first.
    """

    axes: tuple[Floats, Floats, Floats]
    allowed: Booleans
    reasons: dict[str, int]

    @property
    def everywhere(self) -> Booleans:
        """(nx, ny, nz) where all orientations are allowed."""
        return np.asarray(self.allowed.all(axis=0), dtype=np.bool_)

    @property
    def somehow(self) -> Booleans:
        """(nx, ny, nz) where some orientation is allowed."""
        return np.asarray(self.allowed.any(axis=0), dtype=np.bool_)

    def volume(self, places: Booleans) -> tuple[float, float]:
        """Volume of places (nx, ny, nz) and how far it may be wrong, half of the cells of the boundary [m^3]."""
        return grid_volume(self.axes, places)

    def voids(self, places: Booleans) -> tuple[int, float]:
        """How many holes there are inside of places (nx, ny, nz), enclosed by them, and their volume [m^3].

        In a plane of one cell thickness holes are those of the area.
        """
        count, volume = 0, 0.0
        cell = grid_volume(self.axes, np.ones(places.shape, dtype=bool))[0] / places.size
        rest = ~places & ~_flood(~places, _border(places.shape))
        while rest.any():
            seed = np.zeros(places.shape, dtype=bool)
            seed[np.unravel_index(int(rest.argmax()), places.shape)] = True
            hole = _flood(rest, seed)
            count, volume, rest = count + 1, volume + cell * int(hole.sum()), rest & ~hole
        return count, volume

    @property
    def status(self) -> WorkspaceStatus:
        """Some or none."""
        return WorkspaceStatus.SOME if self.allowed.any() else WorkspaceStatus.EMPTY

    def explain(self, language: str | None = None) -> str:
        """Volumes with their errors, and what refuses most poses."""
        most = max(self.reasons, key=lambda name: self.reasons[name])
        (all_, all_error), (some, some_error) = self.volume(self.everywhere), self.volume(self.somehow)
        return self.status.sentence(
            language, all=all_, all_error=all_error, some=some, some_error=some_error, orientations=len(self),
            reason=most, refused=self.reasons[most], poses=self.allowed.size,
        )  # fmt: skip


def grid_volume(axes: tuple[Floats, ...], places: Booleans) -> tuple[float, float]:
    """Volume of places of a grid, and how far it may be wrong: half of the cells of the boundary [m^k].

    Args:
        axes: (n,) evenly spaced along each side [m]; one with a single place counts as one metre.
        places: (n, ...) which belong to it.
    """
    cell = float(np.prod([float(axis[1] - axis[0]) if len(axis) > 1 else 1.0 for axis in axes]))
    edge = np.zeros(places.shape, dtype=bool)
    for axis in range(places.ndim):
        before, after = [slice(None)] * places.ndim, [slice(None)] * places.ndim
        before[axis], after[axis] = slice(None, -1), slice(1, None)
        differs = places[tuple(before)] != places[tuple(after)]
        edge[tuple(before)] |= differs
        edge[tuple(after)] |= differs
    return cell * int(places.sum()), cell * int(edge.sum()) / 2


def _border(shape: tuple[int, ...]) -> Booleans:
    """Cells on a side of the box; of a side of one cell none."""
    found = np.zeros(shape, dtype=np.bool_)
    for axis, n in enumerate(shape):
        if n > 1:
            for end in (0, -1):
                found[(slice(None),) * axis + (end,)] = True
    return found


def _flood(free: Booleans, seed: Booleans) -> Booleans:
    """Free cells that are joined with the seeds through sides of free cells."""
    wet = free & seed
    while True:
        wider = wet.copy()
        for axis in range(free.ndim):
            before = (slice(None),) * axis + (slice(None, -1),)
            after = (slice(None),) * axis + (slice(1, None),)
            wider[after] |= wet[before]
            wider[before] |= wet[after]
        wider &= free
        if (wider == wet).all():
            return wet
        wet = wider


def platform_workspace(
    robot: StewartPlatform, limits: PlatformLimits, lower: ArrayLike, upper: ArrayLike, cells: int = 41,
    orientations: ArrayLike | None = None,
) -> PlatformWorkspace:  # fmt: skip
    """Where a platform can be within its limits, at the middles of the cells of a box.

    Args:
        robot: its geometry.
        limits: of its legs and joints.
        lower, upper: (3,) corners of the box [m].
        cells: along each side.
        orientations: (k, 3, 3) of the platform; the identity alone if None.
    """
    low, high, n = single("lower", lower, (3,)), single("upper", upper, (3,)), whole("cells", cells, 1, 2000)
    if not (low < high).all():
        raise InputError("parallel.box", low=low.tolist(), high=high.tolist())
    R = rotation.check(np.eye(3)[None] if orientations is None else as_batch("orientations", orientations, (3, 3)))
    R = R.reshape(-1, 3, 3)
    steps = (np.arange(n) + 0.5) / n
    axes = tuple(low[k] + (high[k] - low[k]) * steps for k in range(3))
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    why = np.zeros((len(R), len(places)), dtype=np.int8)
    for k, turn in enumerate(R):
        for first in range(0, len(places), BLOCK):
            why[k, first : first + BLOCK] = _refuse(robot, limits, turn, places[first : first + BLOCK])
    reasons = {name: int((why == number).sum()) for number, name in enumerate(REASONS, start=1)}
    return PlatformWorkspace((axes[0], axes[1], axes[2]), (why == 0).reshape(len(R), n, n, n), reasons)


def _refuse(robot: StewartPlatform, limits: PlatformLimits, R: Floats, p: Floats) -> Floats:
    """(k,) number of the first reason against places (k, 3), zero if there is none."""
    d = p[:, None] + robot.platform @ R.T - robot.base
    s = np.linalg.norm(d, axis=-1)
    u = d / np.maximum(s, LEAST_DIVISOR)[..., None]
    against = [
        (s < limits.shortest).any(axis=1),
        (s > limits.longest).any(axis=1),
        (u[..., 2] < np.cos(min(limits.base_cone, np.pi))).any(axis=1) & (limits.base_cone < np.pi),
        (u @ R[:, 2] < np.cos(min(limits.platform_cone, np.pi))).any(axis=1) & (limits.platform_cone < np.pi),
        np.zeros(len(p), dtype=bool),
        np.zeros(len(p), dtype=bool),
    ]
    if limits.leg_radius > 0:
        against[4] = _nearest_legs(robot.base, d) < 2 * limits.leg_radius
    if limits.least_measure > 0:
        about = line_matrix(robot.platform @ R.T, u) / np.concatenate([np.full(3, robot.size), np.ones(3)])
        against[5] = np.linalg.svd(about, compute_uv=False)[:, -1] < limits.least_measure
    return np.select(against, list(range(1, len(REASONS) + 1)), 0)


def _nearest_legs(a: Floats, d: Floats) -> Floats:
    """(k,) least distance of two legs from a_i to a_i + d_i, for d (k, 6, 3); legs with a common end are left out."""
    ends = a + d
    least = np.full(len(d), np.inf)
    for i in range(6):
        for j in range(i + 1, 6):
            apart = np.linalg.norm(a[i] - a[j]) > 0
            gap = segment_distance(a[i], d[:, i], a[j], d[:, j])
            joined = np.linalg.norm(ends[:, i] - ends[:, j], axis=1) <= 1e-12
            least = np.where(joined | (not apart), least, np.minimum(least, gap))
    return least


def segment_distance(p: Floats, u: Floats, q: Floats, v: Floats) -> Floats:
    """(k,) distance of the segments from p along u (k, 3) and from q along v (k, 3).

    Reference: Ericson, Real-Time Collision Detection, 2005, sec. 5.1.9.
    """
    r = np.broadcast_to(p - q, u.shape)
    a, e, f = (u * u).sum(-1), (v * v).sum(-1), (v * r).sum(-1)
    b, c = (u * v).sum(-1), (u * r).sum(-1)
    tiny = LEAST_DIVISOR
    den = a * e - b * b
    s = np.where(den > 1e-14 * a * e, np.clip((b * f - c * e) / np.maximum(den, tiny), 0, 1), 0.0)
    t = np.clip((b * s + f) / np.maximum(e, tiny), 0, 1)
    s = np.clip((b * t - c) / np.maximum(a, tiny), 0, 1)
    t = np.clip((b * s + f) / np.maximum(e, tiny), 0, 1)
    return np.linalg.norm(r + s[..., None] * u - t[..., None] * v, axis=-1)
