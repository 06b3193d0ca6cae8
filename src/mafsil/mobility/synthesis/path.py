"""Path generation: linkages a point of whose coupler passes points, at given angles of the crank or at any.

A coupler point P with a dyad A-B-P can also be led by the dyad A-B'-P that completes the parallelogram A B P B': its
links turn as those of the first one do, exchanged (Roberts). So a crank that turns by given angles is the second link
of a dyad whose coupler turns by them, and the exact problem is two of motion generation:

1. Dyads of the poses (point, angle of the crank), as for a coupler that turns with the crank.
2. Each is exchanged: its coupler becomes the crank, and its crank's angles gamma_j are those of the coupler.
3. Dyads of the poses (point, gamma_j): each but the one of step 2 closes a linkage.

Five points have at most four dyads and three partners each: at most twelve linkages, all found.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, positive, radians, single, whole
from mafsil.errors import InputError
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.synthesis.answers import NOTHING, Synthesis, SynthesisStatus, outcome, rank_candidates
from mafsil.mobility.synthesis.assessment import NO_LIMITS, LinkageLimits
from mafsil.mobility.synthesis.cognates import cognate_positions
from mafsil.mobility.synthesis.dyads import (
    Dyad,
    DyadKind,
    PoseConditions,
    as_complex,
    common_pole,
    cranks_and_blocks,
    spread,
)
from mafsil.mobility.synthesis.fitting import Positions, fit_four_bars, four_bars_of, slider_cranks_of
from mafsil.mobility.synthesis.motion import count_dyads, dyads_through, pole_details
from mafsil.mobility.tolerances import EXACT, SAME_GROUND, SAME_POSE

NINE = 9
"""Points that any angles of the crank leave finitely many four-bars for: at most 1,442 triples of cognates."""
MOST_POINTS = 400
"""Points of a path: unknown angles of the crank make dense equations of so many columns."""
FIT = 0.02
"""Distance of a fit from its points, over their spread, up to which it counts as one if nothing else is said."""
FEW_STARTS = 12
"""Linkages of four of the points from which least squares start, besides all of five points."""


def synthesise_path(
    points: ArrayLike, timing: ArrayLike | None = None, *, samples: int = 24, tolerance: float | None = None,
    limits: LinkageLimits = NO_LIMITS,
) -> Synthesis:  # fmt: skip
    """Linkages a coupler point of which passes points of the plane in their order.

    With timing three to five points are met exactly: of five all linkages are found, of fewer a sample of the
    infinitely many. More points, and points without timing, are fitted by least squares from many starts.

    Args:
        points: (N, 2), N from 3 with timing, from 5 without [m].
        timing: (N,) angles of the crank at the points, from any line [rad]; free if None.
        samples: of a family: points of the grid for three points, lines across the curve for four.
        tolerance: greatest distance from a point at which a fit counts as one [m]; 2 % of the points' spread if None.
        limits: region of fixed pivots, least transmission angle, longest link.

    Returns:
        All candidates, driven by the crank that keeps the timing; good ones first.

    Raises:
        InputError: too few or too many points, timing of another length, two equal angles of the crank, two points
            that coincide.
    """
    z = checked_points(points, 3 if timing is not None else 5)
    whole("samples", samples, 4, 400)
    near = FIT * float(spread(as_complex(z))) if tolerance is None else positive("tolerance", tolerance)
    if timing is None:
        return _fit(z, None, samples, near, limits)
    angles = radians("timing", single("timing", timing, (len(z),)))
    require_apart(angles)
    return _fit(z, angles, samples, near, limits) if len(z) > 5 else _exact(z, angles, samples, limits)


def checked_points(points: ArrayLike, least: int, most: int = MOST_POINTS) -> Floats:
    """(N, 2) points that are apart, so many."""
    z = as_batch("points", points, (2,), finite=True)
    if z.ndim != 2 or not least <= len(z) <= most:
        raise InputError("synthesis.point_count", got=z.shape, least=least, most=most)
    near = SAME_POSE * float(spread(as_complex(z)))
    for k in range(len(z)):
        same = np.flatnonzero(np.hypot(*(z[:k] - z[k]).T) <= near)
        if len(same):
            raise InputError("synthesis.same_point", first=int(same[0]) + 1, second=k + 1)
    return z


def require_apart(angles: Floats) -> None:
    """Refuse two equal angles of the crank: it cannot be in two places then."""
    for k in range(len(angles)):
        same = np.flatnonzero(np.abs(wrap_angle(angles[:k] - angles[k])) <= SAME_POSE)
        if len(same):
            raise InputError("synthesis.same_timing", first=int(same[0]) + 1, second=k + 1)


def _exact(z: Floats, angles: Floats, samples: int, limits: LinkageLimits) -> Synthesis:
    """Three to five points with timing."""
    conditions = PoseConditions.of(np.column_stack([z, angles]))
    task = np.column_stack([z, angles])
    pole = common_pole(conditions)
    if pole is not None:
        return Synthesis(SynthesisStatus.ONE_POLE, "path", NOTHING, task, (), None, "", pole_details(conditions, pole))
    first, batches, infinite = exact_linkages(conditions, samples)
    if infinite:
        return Synthesis(SynthesisStatus.INFINITE, "path", NOTHING, task, (), None, "", {})
    ranking = rank_candidates(batches, float(conditions.size), either_side=False, limits=limits)
    method = {3: "path_by_grid", 4: "path_by_curve", 5: "path_by_five"}[len(z)]
    return Synthesis(
        outcome(ranking, sampled=len(z) < 5), "path", ranking, task, tuple(first), None, method, count_dyads(first)
    )


def exact_linkages(conditions: PoseConditions, samples: int) -> tuple[list[Dyad], list[Positions], bool]:
    """Dyads of the crank, the linkages they make, and whether there are infinitely many; steps in the module's text.

    Args:
        conditions: three to five poses of a point and a crank's angle.
        samples: of a family.
    """
    z = conditions.poses[:, :2]
    dyads, _, infinite = dyads_through(conditions, samples)  # 1
    first, batches = [_exchange(one, z) for one in cranks_and_blocks(dyads)[0]], list[Positions]()
    for one in first:
        gamma = np.angle(as_complex(z - one.places))  # 2
        partners, _, _ = dyads_through(PoseConditions.of(np.column_stack([z, gamma])), samples)  # 3
        cranks, blocks = cranks_and_blocks(partners)
        if len(z) == 5:
            cranks = _without(one, cranks, float(conditions.size))
        batches += [four_bars_of([one], cranks), slider_cranks_of([one], blocks)]
    return first, batches, infinite


def _without(one: Dyad, others: list[Dyad], size: float) -> list[Dyad]:
    """The other dyads of five poses, without the given one, which is always among them.

    Args:
        one: a crank.
        others: all cranks.
        size: of the task [m].
    """
    gaps = [float(np.abs(np.append(each.pivot - one.pivot, each.point - one.point)).max()) for each in others]
    nearest = int(np.argmin(gaps)) if gaps else 0
    return [each for k, each in enumerate(others) if k != nearest or gaps[k] > SAME_GROUND * size]


def _exchange(one: Dyad, z: Floats) -> Dyad:
    """The dyad with its two links exchanged: A B P becomes A B' P with B' = A + P - B; its frame lies along B' -> P."""
    places = one.pivot + z - one.places
    arm = float(np.hypot(*one.point))
    return Dyad(DyadKind.CRANK, one.pivot, np.array([-one.length, 0.0]), places, arm, one.residual)


def _fit(z: Floats, angles: Floats | None, samples: int, tolerance: float, limits: LinkageLimits) -> Synthesis:
    """Least squares from linkages that meet some of the points: fits within the tolerance, or else the nearest few.

    Args:
        z: (N, 2) points.
        angles: (N,) of the crank, or None.
        samples: of the families from which fits start.
        tolerance: of a fit [m].
        limits: what the linkages must keep to.
    """
    if angles is None:
        starts = [one for guess in _guesses(z) for one in _starts(z, guess, samples)]
    else:
        starts = _starts(z, angles, samples)
    size = float(spread(as_complex(z)))
    found = fit_four_bars(as_complex(z), angles, starts)
    misses = np.zeros(0) if found.misses is None else found.misses
    least = float(misses.min(initial=np.inf))
    batches = [found.chosen(misses <= max(tolerance, 2 * least))]
    method, triples = "by_fit", 0
    if angles is None and len(z) == NINE:
        # Nine points leave no freedom: each exact four-bar stands in a triple of cognates, all of which are answers.
        exact = found.chosen(misses <= EXACT * size)
        triples = exact.triples()
        batches += cognate_positions(exact)[1:]
        method = "by_nine"
    ranking = rank_candidates(batches, size, either_side=False, limits=limits)
    task = z if angles is None else np.column_stack([z, angles])
    details = {"starts": len(starts), "points": len(z), "miss": least, "tolerance": tolerance, "triples": triples}
    status = SynthesisStatus.FAR if ranking.count and least > tolerance else outcome(ranking, sampled=True)
    return Synthesis(status, "path", ranking, task, (), None, method if ranking.count else "", details)


def _guesses(z: Floats) -> list[Floats]:
    """Angles of the crank by the length of the path, for several whole angles and both senses."""
    steps = np.hypot(*np.diff(z, axis=0).T)
    share = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    closed = 2 * np.pi * steps.sum() / (steps.sum() + np.hypot(*(z[-1] - z[0])))
    return [sign * whole_angle * share for whole_angle in (closed, np.pi, np.pi / 2) for sign in (1.0, -1.0)]


def _starts(z: Floats, angles: Floats, samples: int) -> list[Positions]:
    """Linkages through five and through four of the points, one in each batch; of four those of mildest defects."""
    found: list[Positions] = []
    for count in (5, 4):
        if len(z) < count:
            continue
        chosen = np.unique(np.round(np.linspace(0, len(z) - 1, count)).astype(int))
        conditions = PoseConditions.of(np.column_stack([z[chosen], angles[chosen]]))
        _, batches, _ = exact_linkages(conditions, min(samples, 8) if count == 4 else samples)
        built = [batch.built(float(conditions.size)) for batch in batches if not batch.slider]
        singles = [batch.chosen(np.array([k])) for batch in built for k in range(len(batch))]
        if count == 4:
            singles.sort(key=lambda one: int(one.assess().severity[0]))
            singles = singles[:FEW_STARTS]
        found += singles
    return found
