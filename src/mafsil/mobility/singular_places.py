"""Where sheets of configurations meet: places at which the loop matrix really loses rank, found and made sure of."""

from __future__ import annotations

from typing import cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.mobility.charts import Charts, Whole, differences, tangent_planes, wrapped_points
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.loop_closure import closed_near, loop_matrix, loop_state, units
from mafsil.mobility.tolerances import CLOSED, PATH_STEP

GAUSS_NEWTON_STEPS = 30
ZERO = 1e-8
"""Singular values of the loop matrix below it are zero: differences over PATH_STEP / 10 leave 1e-9 of them."""
DEPENDENT = 1e-8
MOST_TRIES = 40
AT_ONCE = 512
"""Edges looked at together, which bounds the memory."""
SHARPEST = 1e-6
"""Points between are closed by Newton's method, which ends that near to where the rank is lost."""
Frame = tuple[Floats, Floats, Floats]
"""Kept rows of the constraints, tangent plane, and the sign of both at one end of each edge."""


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
    turned: list[tuple[Floats, ...]] = []
    for first in range(0, len(sides) if linkage.conditions else 0, AT_ONCE):
        a, b = sides[first : first + AT_ONCE].T
        start = charts.points[a]
        way = differences(linkage, start, charts.points[b])
        A = loop_matrix(linkage, start * units(linkage))
        rows = np.swapaxes(np.linalg.svd(A, full_matrices=False)[0][..., : F - 2], -1, -2)
        before = _determinant(linkage, start, rows, charts.bases[a])
        frame = rows, charts.bases[a], np.sign(before)
        after = _signed(linkage, start + way, *frame)
        flipped = np.flatnonzero(after < 0)
        if len(flipped):
            turned.append(tuple(part[flipped] for part in (start, start + way, np.abs(before), after, *frame)))
    if not turned:
        return np.zeros((0, F))
    low, high, above, below, *own = (np.concatenate(parts) for parts in zip(*turned, strict=True))
    found = [
        _between(
            linkage, (low[rows], high[rows]), (above[rows], below[rows]), cast("Frame", tuple(x[rows] for x in own))
        )
        for rows in (slice(first, first + AT_ONCE) for first in range(0, len(low), AT_ONCE))
    ]
    return wrapped_points(linkage, np.concatenate(found))


def _between(linkage: Linkage, ends: tuple[Floats, Floats], values: tuple[Floats, Floats], frame: Frame) -> Floats:
    """Where between the ends of edges the orientation reverses: false position on the chords, after Illinois.

    1. A point where the chord of the values vanishes, closed by Newton's method.
    2. It replaces the end of its sign; an end that stays twice counts half, so that it does not stay for ever.
    3. It ends where points no longer move.

    Args:
        linkage: of mobility 2.
        ends: (e, F) points.
        values: (e,) of `_signed` there, positive and negative.
        frame: of the edges.
    """
    scale, (low, high), (above, below) = units(linkage), ends, values
    here, stayed = low, np.zeros(len(low))
    for _ in range(MOST_TRIES):
        share = np.clip(above / np.maximum(above - below, np.finfo(np.float64).tiny), 0.01, 0.99)  # 1
        before, here = here, closed_near(linkage, (low + share[:, None] * (high - low)) * scale).theta / scale
        value = _signed(linkage, here, *frame)
        after = value < 0  # 2
        above = np.where(after, np.where(stayed > 0, above / 2, above), value)
        below = np.where(after, value, np.where(stayed < 0, below / 2, below))
        low, high = np.where(after[:, None], low, here), np.where(after[:, None], here, high)
        stayed = np.where(after, 1.0, -1.0)
        if float(np.minimum(_far(here, before), _far(high, low)).max()) < SHARPEST:  # 3
            break
    return here


def _far(first: Floats, second: Floats) -> Floats:
    return np.abs(first - second).max(axis=1)


def _signed(linkage: Linkage, points: Floats, rows: Floats, bases: Floats, sign: Floats) -> Floats:
    """(e,) the determinant of `_determinant`, positive where the orientation is that of the frame."""
    planes = tangent_planes(linkage, points)
    turned = np.sign(np.linalg.det(np.swapaxes(bases, -1, -2) @ planes))
    return _determinant(linkage, points, rows, planes) * turned * sign


def _determinant(linkage: Linkage, points: Floats, rows: Floats, planes: Floats) -> Floats:
    A = rows @ loop_matrix(linkage, points * units(linkage))
    return np.linalg.det(np.concatenate([A, np.swapaxes(planes, -1, -2)], axis=-2))
