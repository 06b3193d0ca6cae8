"""Triangles of a surface from the cells of its charts: where all three corners agree; is it closed, of which genus.

Reference: J.-D. Boissonnat, A. Ghosh, Manifold reconstruction using tangential Delaunay complexes, Discrete and
Computational Geometry 51 (2014).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.mobility.charts import CELL, NOBODY, Cell, Charts, Whole, cut_by, open_cell, owners

ROUNDS = 60
SHARE = 0.35
"""Weights go up to the square of this share of a radius: more than curvature moves four points off a circle, less than
what would take a point its cell."""

Triangle = tuple[int, int, int]


def agreed_triangles(charts: Charts, seed: int = 0) -> tuple[Whole, int]:
    """Triangles (t, 3) that the cells of all three corners have, and how many others are left inside.

    1. The cell of a chart names its neighbours in order: two that follow each other make a triangle with it.
    2. Four points near a circle may be split one way in one cell, otherwise in another. Random weights of the points
       concerned decide (cells of a power diagram); tried again until nothing is left to decide.
    3. Charts that gave up, or that the surface was not followed beyond, need not agree.

    Args:
        charts: of charts that have spread.
        seed: of the weights.
    """
    random, weights, around = np.random.default_rng(seed), np.zeros(len(charts.points)), _around(charts)
    stars = [_star(k, cell) for k, cell in enumerate(charts.cells)]
    inner = [k not in charts.stuck and NOBODY not in owners(cell) for k, cell in enumerate(charts.cells)]
    odd = _odd(stars)
    for _ in range(ROUNDS):
        concerned = sorted({corner for one in odd if all(inner[k] for k in one) for corner in one})
        if not concerned:
            break
        weights[concerned] = random.uniform(0.0, (SHARE * charts.radii[concerned]) ** 2)
        anew = sorted({k for corner in concerned for k in [corner, *around[corner]] if inner[k]})
        for k, cell in zip(anew, _weight(charts, anew, around, weights), strict=True):
            stars[k] = _star(k, cell)
        odd = _odd(stars)
    found = sorted({triangle for star in stars for triangle in star} - odd)
    left = sum(all(inner[k] for k in one) for one in odd)
    return np.array(found, dtype=np.intp).reshape(-1, 3), left


def _around(charts: Charts) -> list[list[int]]:
    """Charts whose cells could meet, for each."""
    near = charts.tree().within(charts.points, 2 * CELL * np.minimum(1.5 * charts.radii, charts.radius))
    return [[j for j in ids if j != k] for k, ids in enumerate(near)]


def _weight(charts: Charts, own: list[int], around: list[list[int]], weights: Floats) -> Iterator[Cell]:
    """The cells of charts in the power diagram of their neighbours."""
    first = np.repeat(np.array(own, dtype=np.intp), [len(around[k]) for k in own])
    second = np.array([j for k in own for j in around[k]], dtype=np.intp)
    together, u, _, square = charts.neighbours(first, second)
    first, second = first[together], second[together]
    limits = (square + weights[first] - weights[second]) / 2
    begins = np.searchsorted(first, [*own, own[-1] + 1])
    for k, begin, end in zip(own, begins.tolist(), begins.tolist()[1:], strict=False):
        yield cut_by(open_cell(CELL * float(charts.radii[k])), u[begin:end], limits[begin:end], second[begin:end])


def _star(k: int, cell: Cell) -> set[Triangle]:
    order = owners(cell)
    pairs = zip(order, order[1:] + order[:1], strict=True)
    return {cast("Triangle", tuple(sorted((k, a, b)))) for a, b in pairs if NOBODY not in (a, b) and a != b}


def _odd(stars: list[set[Triangle]]) -> set[Triangle]:
    """Triangles that not all of their three corners have."""
    return {one for star in stars for one in star if any(one not in stars[corner] for corner in one)}


def edges(triangles: Whole) -> tuple[Whole, Whole, Whole]:
    """Edges (e, 2) of triangles with ascending corners; of each side (3 t,) its edge, and 1, or 0 backwards."""
    a, b, c = triangles.T
    sides = np.concatenate([np.stack(pair, axis=1) for pair in ((a, b), (b, c), (a, c))])
    found, index = np.unique(sides, axis=0, return_inverse=True)
    forward = np.repeat(np.array([1, 1, 0], dtype=np.intp), len(triangles))
    return found, index.reshape(-1), forward


def is_closed(triangles: Whole, corners: int) -> bool:
    """Whether triangles make one closed surface: two at each edge, one ring around each of all corners, in one piece.

    Args:
        triangles: (t, 3) ascending indices.
        corners: how many there are.
    """
    if len(np.unique(triangles)) != corners or len(_rim(triangles)) or _torn(triangles):
        return False
    return _pieces(edges(triangles)[0], corners) == 1


def trim_openings(triangles: Whole, without: set[int]) -> tuple[Whole, Whole, int]:
    """A surface with openings: triangles without some corners, and without those at which it would not be one.

    Args:
        triangles: (t, 3) ascending indices.
        without: corners to leave out.

    Returns:
        the triangles left, their corners (k,) along openings, and the number of openings.
    """
    out = np.array(sorted(without), dtype=np.intp)
    while len(out):
        triangles = triangles[~np.isin(triangles, out).any(axis=1)]
        out = np.array(sorted(_torn(triangles)), dtype=np.intp)
    rim = _rim(triangles)
    around, index = np.unique(rim, return_inverse=True)
    return triangles, around, _pieces(index.reshape(-1, 2), len(around)) if len(around) else 0


def _rim(triangles: Whole) -> Whole:
    """(e, 2) edges of one triangle only."""
    sides, index, _ = edges(triangles)
    return sides[np.bincount(index, minlength=len(sides)) == 1]


def _torn(triangles: Whole) -> set[int]:
    """Corners around which the triangles make neither one ring nor one fan."""
    opposite: dict[int, list[tuple[int, int]]] = {}
    for a, b, c in triangles.tolist():
        for corner, pair in ((a, (b, c)), (b, (a, c)), (c, (a, b))):
            opposite.setdefault(corner, []).append(pair)
    return {corner for corner, pairs in opposite.items() if not _one_way(pairs)}


def _one_way(pairs: list[tuple[int, int]]) -> bool:
    """Whether edges make one ring, or one way from end to end."""
    beside: dict[int, list[int]] = {}
    for a, b in pairs:
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    if max(map(len, beside.values())) > 2:
        return False
    ends = [corner for corner, others in beside.items() if len(others) == 1]
    start = ends[0] if ends else pairs[0][0]
    before, here, gone = start, beside[start][0], 1
    while here != start and len(beside[here]) == 2:
        first, second = beside[here]
        before, here, gone = here, second if first == before else first, gone + 1
    return gone == len(pairs)


def is_orientable(triangles: Whole) -> bool:
    """Whether all triangles of a closed surface in one piece can be turned alike: its double cover falls apart."""
    t = len(triangles)
    _, index, forward = edges(triangles)
    order = np.argsort(index, kind="stable").reshape(-1, 2)
    first, second = (order % t).T
    same = forward[order[:, 0]] != forward[order[:, 1]]
    upper = np.stack([first, second + np.where(same, 0, t)], axis=1)
    lower = np.stack([first + t, second + np.where(same, t, 0)], axis=1)
    return _pieces(np.concatenate([upper, lower]), 2 * t) == 2


def _pieces(links: Whole, count: int) -> int:
    """Number of pieces that links (e, 2) leave of so many points."""
    into = list(range(count))

    def root(k: int) -> int:
        while into[k] != k:
            into[k] = into[into[k]]
            k = into[k]
        return k

    for a, b in links.tolist():
        into[root(a)] = root(b)
    return sum(into[k] == k for k in range(count))


def area(first: Floats, second: Floats) -> float:
    """Sum of the areas of triangles by two of their sides (t, F)."""
    square = np.sum(first**2, axis=1) * np.sum(second**2, axis=1) - np.sum(first * second, axis=1) ** 2
    return float(np.sqrt(np.maximum(square, 0.0)).sum() / 2)
