"""Where sheets of configurations meet: places at which the loop matrix really loses rank, found and made sure of."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.mobility.charts import Charts, Whole, differences, tangent_planes, wrapped_points
from mafsil.mobility.linkage import Linkage
from mafsil.mobility.loop_closure import closed_near, loop_matrix, loop_state, units
from mafsil.mobility.tolerances import CLOSED, PATH_STEP

GAUSS_NEWTON_STEPS = 30
ZERO = 1e-8
"""Singular values of the loop matrix below it are zero: differences over PATH_STEP / 10 leave 1e-9 of them."""
DEPENDENT = 1e-8
BISECTIONS = 40
AT_ONCE = 512
"""Edges looked at together, which bounds the memory."""
SHARPEST = 1e-6
"""Bisection is closed again by Newton's method, which ends that near to where the rank is lost."""


def singular_near(linkage: Linkage, point: Floats) -> Floats | None:
    """A configuration near a point (F,) over `units` at which the loop matrix loses more rank; None if none is found.

    Gauss-Newton's method on the closure, A' u = 0 and u' u = 1 for the left singular vector u of the singular value
    that vanishes.

    Args:
        linkage: of mobility 2.
        point: coordinates over `units`.
    """
    scale, here, F = units(linkage), point.copy(), linkage.coordinates
    h = PATH_STEP / 10
    for _ in range(GAUSS_NEWTON_STEPS):
        state = loop_state(linkage, here * scale)
        U, s, _ = np.linalg.svd(state.matrix, full_matrices=False)
        if s[F - 3] < ZERO * s[0] and float(np.abs(state.gap).max(initial=0.0)) < CLOSED:
            return here
        rows = U[:, : F - 2]
        u = rows[:, -1]
        around = here + h * np.concatenate([np.eye(F), -np.eye(F)])
        A = loop_matrix(linkage, around * scale)
        bend = np.einsum("mrf,r->fm", (A[:F] - A[F:]) / (2 * h), u)
        J = np.zeros((len(state.gap) + F + 1, F + F - 2))
        J[: len(state.gap), :F] = state.matrix
        J[len(state.gap) : -1, :F] = bend
        J[len(state.gap) : -1, F:] = state.matrix.T @ rows
        J[-1, -1] = 1.0
        missed = np.concatenate([state.gap, state.matrix.T @ u, [0.0]])
        step = np.linalg.lstsq(J, -missed, rcond=DEPENDENT)[0][:F]
        here = here + step * min(1.0, 0.3 / max(float(np.abs(step).max()), 1e-300))
    return None


def pinches(charts: Charts, reach: float) -> tuple[Floats, int]:
    """Singular places (p, F) that charts gave up at, and how many of these charts lie at none.

    Args:
        charts: of charts that have spread.
        reach: within which a place is that of a chart.
    """
    found = np.zeros((0, charts.linkage.coordinates))
    alone = 0
    for k in sorted(charts.stuck):
        point = charts.points[k]
        if bool((np.linalg.norm(differences(charts.linkage, point, found), axis=1) < reach).any()):
            continue
        place = singular_near(charts.linkage, point)
        if place is None or float(np.linalg.norm(differences(charts.linkage, point, place))) > reach:
            alone += 1
        else:
            found = np.concatenate([found, wrapped_points(charts.linkage, place)[None]])
    return found, alone


def crossings(charts: Charts, sides: Whole) -> Floats:
    """(b, F) points on edges (e, 2) at which the orientation of the constraints reverses: another sheet crosses there.

    Args:
        charts: of charts that have spread.
        sides: pairs of charts.
    """
    linkage, F = charts.linkage, charts.linkage.coordinates
    found = [np.zeros((0, F))]
    for first in range(0, len(sides) if linkage.conditions else 0, AT_ONCE):
        a, b = sides[first : first + AT_ONCE].T
        start = charts.points[a]
        way = differences(linkage, start, charts.points[b])
        A = loop_matrix(linkage, start * units(linkage))
        rows = np.swapaxes(np.linalg.svd(A, full_matrices=False)[0][..., : F - 2], -1, -2)
        frame = rows, charts.bases[a], np.sign(_determinant(linkage, start, rows, charts.bases[a]))
        flipped = np.flatnonzero(_reversed(linkage, start + way, *frame))
        if len(flipped):
            ends = start[flipped], (start + way)[flipped]
            found.append(_between(linkage, *ends, (frame[0][flipped], frame[1][flipped], frame[2][flipped])))
    return wrapped_points(linkage, np.concatenate(found))


def _between(linkage: Linkage, low: Floats, high: Floats, frame: tuple[Floats, Floats, Floats]) -> Floats:
    """Where between the ends of edges the orientation reverses, by bisection of the chords."""
    scale = units(linkage)
    for _ in range(BISECTIONS):
        middle = closed_near(linkage, (low + high) / 2 * scale).theta / scale
        after = _reversed(linkage, middle, *frame)[:, None]
        low, high = np.where(after, low, middle), np.where(after, middle, high)
        if float(np.abs(high - low).max()) < SHARPEST:
            break
    return (low + high) / 2


def _reversed(linkage: Linkage, points: Floats, rows: Floats, bases: Floats, sign: Floats) -> np.ndarray:
    planes = tangent_planes(linkage, points)
    turned = np.sign(np.linalg.det(np.swapaxes(bases, -1, -2) @ planes))
    return _determinant(linkage, points, rows, planes) * turned * sign < 0


def _determinant(linkage: Linkage, points: Floats, rows: Floats, planes: Floats) -> Floats:
    A = rows @ loop_matrix(linkage, points * units(linkage))
    return np.linalg.det(np.concatenate([A, np.swapaxes(planes, -1, -2)], axis=-2))
