"""Cells in a plane: convex polygons about the origin, cut by the half-planes nearer to it than to neighbours."""

from __future__ import annotations

from math import cos, hypot, pi, sin

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats

Corner = tuple[float, float, int]
"""A corner (x, y) and the owner of the edge from it to the next corner."""
Cell = list[Corner]
NOBODY = -1
"""Owner of edges that no neighbour has cut yet."""
SIDES = 8


def open_cell(radius: float) -> Cell:
    """A regular polygon with corners at a radius, whose edges nobody owns."""
    return [(radius * cos(2 * pi * k / SIDES), radius * sin(2 * pi * k / SIDES), NOBODY) for k in range(SIDES)]


def cut(cell: Cell, a: float, b: float, c: float, owner: int) -> Cell:
    """What is left of a cell where a x + b y <= c; the new edge belongs to the owner."""
    over = [a * x + b * y - c for x, y, _ in cell]
    if max(over, default=0.0) <= 0.0:
        return cell
    kept: Cell = []
    for k, (x, y, own) in enumerate(cell):
        after = (k + 1) % len(cell)
        here, there = over[k], over[after]
        if here <= 0.0:
            kept.append((x, y, own))
        if (here <= 0.0) != (there <= 0.0):
            share = here / (here - there)
            x2, y2, _ = cell[after]
            kept.append((x + share * (x2 - x), y + share * (y2 - y), owner if here <= 0.0 else own))
    return kept


def cut_by(cell: Cell, directions: Floats, limits: Floats, owners: NDArray[np.intp]) -> Cell:
    """What is left of a cell where directions @ (x, y) <= limits, the nearest first: most of them miss what is left.

    Args:
        cell: about the origin.
        directions: (m, 2).
        limits: (m,).
        owners: (m,) of the new edges.
    """
    if not len(owners):
        return cell
    away = limits / np.maximum(np.linalg.norm(directions, axis=1), np.finfo(np.float64).tiny)
    order = np.argsort(away, kind="stable")
    reach = farthest(cell)[0]
    rows = (part[order].tolist() for part in (away, directions, limits, owners))
    for far, (a, b), limit, owner in zip(*rows, strict=True):
        if far >= reach:
            break
        after = cut(cell, a, b, limit, owner)
        if after is not cell:
            cell, reach = after, farthest(after)[0]
    return cell


def farthest(cell: Cell) -> tuple[float, float, float]:
    """(distance, x, y) of the corner farthest from the origin; zeros of an empty cell."""
    return max(((hypot(x, y), x, y) for x, y, _ in cell), default=(0.0, 0.0, 0.0))


def owners(cell: Cell) -> list[int]:
    """Owners of the edges in order around the origin."""
    return [own for _, _, own in cell]
