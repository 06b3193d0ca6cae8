"""Quality for a task: how strongly a grasp resists the wrenches that will really come."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.quality import quality_of_wrenches
from mafsil.solvers.linear_program import minimise


def task_scale(grasp: Grasp, wrenches: ArrayLike, facets: int = 16) -> tuple[float, int]:
    """The greatest factor by which every one of the task's wrenches is resisted with a total push of 1.

    Args:
        grasp: the contacts.
        wrenches: (k, m) external wrenches (m, f); their convex hull is resisted by the same factor.
        facets: edges of round cones (inscribed: the factor is on the safe side).

    Returns:
        The factor (0 if one cannot be resisted) and the index of the wrench that limits it.
    """
    each = as_batch("wrenches", wrenches, (grasp.rows,), finite=True)
    if each.ndim != 2 or not len(each) or not np.linalg.norm(each, axis=1).all():
        raise InputError("grasp.no_task")
    A = grasp.matrix(facets)
    factors = [_reach(A, -w) for w in each]
    worst = int(np.argmin(factors))
    return factors[worst], worst


def _reach(A: Floats, b: Floats) -> float:
    """Max s with A x = s b, sum x <= 1, x >= 0."""
    n = A.shape[1]
    limit = np.append(np.ones(n), 0.0)[None]
    best = minimise(np.append(np.zeros(n), -1.0), np.column_stack([A, -b]), np.zeros(len(b)), limit, np.ones(1))
    return 0.0 if best is None else -best.value


def ellipsoid_scale(grasp: Grasp, axes: ArrayLike, facets: int = 16) -> float:
    """The greatest factor by which an ellipsoid of task wrenches fits into the wrenches of unit push.

    Args:
        grasp: the contacts.
        axes: (m, m) its half axes in columns, (m, f).
        facets: edges of round cones.
    """
    E = as_batch("axes", axes, (grasp.rows, grasp.rows), finite=True)
    return quality_of_wrenches(np.asarray(np.linalg.solve(E, grasp.matrix(facets)), float)).epsilon


def smallest_singular_value(grasp: Grasp, length: float = 1.0) -> float:
    """Smallest singular value of the map from contact forces to wrenches: 0 where a wrench is out of reach.

    Args:
        grasp: the contacts.
        length: moments are divided by it [m].
    """
    G = np.array(grasp.map)
    G[: grasp.rows - grasp.dimension] /= length
    s = np.linalg.svd(G, compute_uv=False)
    return float(s[-1]) if len(s) == grasp.rows else 0.0
