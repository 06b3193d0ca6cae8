"""Where an arm reaches, and with how many orientations: maps filled by streaming millions of configurations.

Chunks of seeded random configurations go through the compiled forward kinematics and are counted in the cells of a
grid; memory is the grid plus one chunk. The same seed gives the same map, on one core or on many machines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, number, positive, single, whole
from mafsil.errors import InputError
from mafsil.performance.tolerances import LEAST_SPAN, WITHIN
from mafsil.performance.velocity.scaling import prismatic_joints
from mafsil.performance.velocity.scaling import ranges as drawn_from
from mafsil.performance.workspace.workspace_answers import BANDS, View, WorkspaceMap
from mafsil.robot import Robot, of_robot

CHUNK = 65_536
"""Configurations that are evaluated at once."""
MOST_CELLS = 50_000_000
PER_CELL = 20
"""Samples for each cell of the grid, if the size of the cells is left to us."""

_AXES: dict[str, tuple[int, ...]] = {"xyz": (0, 1, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


@dataclass(frozen=True, eq=False)
class _Grid:
    """What a chunk needs to know; pickles."""

    robot: Robot
    lower: Floats
    upper: Floats
    frame: str | None
    view: str
    slab: tuple[float, float] | None
    origin: Floats
    shape: tuple[int, ...]
    cell: float
    dexterous: bool


@of_robot
def workspace_map(
    robot: Robot,
    samples: int = 1_000_000,
    *,
    view: View = "xyz",
    cell: float | None = None,
    at: float | None = None,
    limited: bool = True,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    dexterous: bool = False,
    frame: str | None = None,
    seed: int = 0,
    dask: bool = False,
) -> WorkspaceMap:
    """The reachable workspace as cells, from random configurations.

    Args:
        robot: the arm.
        samples: configurations, uniform in the joint ranges.
        view: grid: `xyz`, a projection `xy`, `xz`, `yz`, or `radial`, see `WorkspaceMap`.
        cell: edge of a cell [m]; if None about 20 samples (240 where directions are recorded) for each
            cell of the grid, at most 240 cells across.
        at: for flat views: only positions within half a cell of this coordinate of the third axis count: a slice [m].
        limited: whether the joint limits are kept; if not, revolute joints make a full turn.
        ranges: (low, high) [rad | m] by name of joint, in place of its limits: needed for prismatic joints without
            limits, whose reach nobody can know.
        dexterous: whether approach directions (z axis of the tip) are recorded.
        frame: name of a link; the tip frame if None.
        seed: of the generator; chunk k uses its k-th child, whoever works on it.
        dask: hand the chunks to dask's current scheduler (a cluster, if a client is connected).

    Raises:
        InputError: no samples, an unknown view, too fine a grid, a prismatic joint without limits and without a given
            range, ranges of no joint or the wrong way round, or dask is asked for and not installed.
    """
    at = None if at is None else number("at", at)
    if view != "radial" and view not in _AXES:
        raise InputError("input.choice", name="view", value=view, known=", ".join([*_AXES, "radial"]))
    if whole("samples", samples) < 1:
        raise InputError("input.positive", name="samples", value=samples)
    grid = _grid(robot, samples, view, cell, at, _ranges(robot, limited, ranges or {}), dexterous, frame)
    counts = np.zeros(int(np.prod(grid.shape)), dtype=np.uint32)
    masks = np.zeros(counts.shape, dtype=np.uint64) if dexterous else None
    inside = 0
    for cells, seen, hits in _chunks(grid, samples, seed, dask):
        np.add.at(counts, cells, hits)
        inside += int(hits.sum())
        if masks is not None:
            masks[cells] |= seen
    directions = None if masks is None else masks.reshape(grid.shape)
    return WorkspaceMap(
        robot.name,
        view,
        grid.origin,
        grid.cell,
        counts.reshape(grid.shape),
        directions,
        samples,
        inside,
        seed,
        MappingProxyType({name: (float(low), float(high)) for name, (low, high) in (ranges or {}).items()}),
    )


def _ranges(robot: Robot, limited: bool, given: Mapping[str, tuple[float, float]]) -> tuple[Floats, Floats]:
    """Where configurations are drawn from: limits, full turns, and what was given; no range is made up."""
    lower, upper = (np.array(bound) for bound in drawn_from(robot, limited=limited))
    names = robot.joint_names
    for name, bounds in given.items():
        if name not in names:
            raise InputError("input.choice", name="ranges", value=name, known=", ".join(names))
        low, high = single(f"ranges[{name!r}]", bounds, (2,))
        if low > high:
            raise InputError("performance.range_order", joint=name, low=low, high=high)
        lower[names.index(name)], upper[names.index(name)] = low, high
    endless = np.isinf(robot.limits.lower) | np.isinf(robot.limits.upper)
    for joint in np.flatnonzero(prismatic_joints(robot) & endless):
        if names[joint] not in given:
            raise InputError("performance.prismatic_without_limits", robot=robot.name, joint=names[joint])
    return lower, upper


Chunk = tuple[NDArray[np.int64], NDArray[np.uint64], NDArray[np.uint32]]


def _chunks(grid: _Grid, samples: int, seed: int, dask: bool) -> Iterator[Chunk]:
    """Cells, direction masks and hits of every chunk, in order."""
    sizes = [CHUNK] * (samples // CHUNK) + ([samples % CHUNK] if samples % CHUNK else [])
    work: list[Callable[[], Chunk]] = [partial(_chunk, grid, size, seed, k) for k, size in enumerate(sizes)]
    if not dask:
        yield from (job() for job in work)
        return
    try:
        compute: Any = import_module("dask.base").compute
        delayed: Any = import_module("dask.delayed").delayed
    except ImportError:
        raise InputError("performance.no_dask") from None
    at_once = 64
    for begin in range(0, len(work), at_once):
        yield from compute(*(delayed(job)() for job in work[begin : begin + at_once]))


def _chunk(grid: _Grid, size: int, seed: int, index: int) -> Chunk:
    """One chunk: draw, evaluate, bin; cells once each."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    T = grid.robot.forward_kinematics(rng.uniform(grid.lower, grid.upper, (size, grid.robot.n)), frame=grid.frame)
    p = T[:, :3, 3]
    if grid.slab is not None:
        (missing,) = {0, 1, 2} - set(_AXES[grid.view])
        keep = (p[:, missing] >= grid.slab[0]) & (p[:, missing] < grid.slab[1])
        T, p = T[keep], p[keep]
    x = np.stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2]], axis=1) if grid.view == "radial" else p[:, _AXES[grid.view]]
    index_nd = np.clip(np.floor((x - grid.origin) / grid.cell).astype(np.int64), 0, np.array(grid.shape) - 1)
    flat: Any = np.ravel_multi_index(tuple(index_nd.T), grid.shape)
    if not grid.dexterous:
        cells, hits = np.unique(flat, return_counts=True)
        return cells, np.zeros(len(cells), np.uint64), hits.astype(np.uint32)
    order: Any = np.argsort(flat, kind="stable")
    bits = np.uint64(1) << _direction_cell(_approach(T, grid.view))[order].astype(np.uint64)
    found: Any = np.unique(flat[order], return_index=True, return_counts=True)
    cells, starts, hits = found
    seen: Any = np.bitwise_or.reduceat(bits, starts) if len(starts) else np.zeros(0, np.uint64)
    return cells, seen, hits.astype(np.uint32)


def _approach(T: Floats, view: str) -> Floats:
    """(k, 3) approach directions; in the radial view seen from the half plane through the tip."""
    z = T[:, :3, 2]
    if view != "radial":
        return z
    turn = -np.arctan2(T[:, 1, 3], T[:, 0, 3])
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([c * z[:, 0] - s * z[:, 1], s * z[:, 0] + c * z[:, 1], z[:, 2]], axis=1)


def _direction_cell(z: Floats) -> NDArray[np.int64]:
    """Which of the BANDS x BANDS cells of equal area a direction (k, 3) lies in."""
    band = np.clip((BANDS * (z[:, 2] + 1) / 2).astype(np.int64), 0, BANDS - 1)
    turn = np.arctan2(z[:, 1], z[:, 0]) / (2 * np.pi) % 1.0
    return band * BANDS + np.minimum((BANDS * turn).astype(np.int64), BANDS - 1)


def _grid(
    robot: Robot,
    samples: int,
    view: str,
    cell: float | None,
    at: float | None,
    drawn: tuple[Floats, Floats],
    dexterous: bool,
    frame: str | None,
) -> _Grid:
    lower, upper = drawn
    low, high = _bounds(robot, view, lower, upper, frame)
    if cell is None:
        flat = view != "xyz" and at is None
        share = PER_CELL * (12 if dexterous else 1)
        across: float = (samples / share) ** (1 / 2 if flat else 1 / 3)
        width: float = float((high - low).max()) / min(max(across, 12.0), 240.0)
    else:
        width = cell
    counts: Floats = np.maximum(np.ceil((high - low) / positive("cell", width)), 1.0)
    if np.prod(counts) > MOST_CELLS:
        raise InputError("performance.too_many_cells", count=float(np.prod(counts)), limit=MOST_CELLS)
    shape = tuple(int(n) for n in counts)
    if at is not None and view not in ("xy", "xz", "yz"):
        raise InputError("performance.no_slice", view=view)
    slab = None if at is None else (at - width / 2, at + width / 2)
    return _Grid(robot, lower, upper, frame, view, slab, low, shape, width, dexterous)


def _bounds(robot: Robot, view: str, lower: Floats, upper: Floats, frame: str | None) -> tuple[Floats, Floats]:
    """A box around what a seeded sample shows, a tenth wider on every side; what falls outside counts at its rim."""
    rng = np.random.default_rng(np.random.SeedSequence(7))
    p = robot.forward_kinematics(rng.uniform(lower, upper, (20_000, robot.n)), frame=frame)[:, :3, 3]
    x = np.stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2]], axis=1) if view == "radial" else p[:, _AXES[view]]
    low, high = x.min(axis=0), x.max(axis=0)
    margin = 0.1 * np.maximum(high - low, LEAST_SPAN * max(float((high - low).max()), WITHIN))
    low, high = low - margin, high + margin
    if view == "radial":
        low[0] = 0.0
    return low, high
