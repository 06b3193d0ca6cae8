"""Motion generation: all four-bars and slider-cranks whose coupler takes three, four or five poses of the plane.

Dyads of five poses that have only two angles: the general elimination is singular there, a construction is not.

Three poses at least have one angle, so that every point of the coupler has its three places on equal circles: the fixed
pivot is the moving one moved by the vector to their middle. Two poses of another angle then say two circles of equal
radius for the moving pivot, which meet in two points. Three places on one line leave none, or infinitely many.

All dyads of many lists of five poses at once: for studies that vary a task thousands of times.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Booleans, Floats, Integers, real_array, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.spaces.planar_positions import circle_crossings, circle_gap
from mafsil.mobility.synthesis.answers import NOTHING, Synthesis, SynthesisStatus, outcome, rank_candidates
from mafsil.mobility.synthesis.assessment import NO_LIMITS, LinkageLimits
from mafsil.mobility.synthesis.dyads import (
    Complexes,
    Dyad,
    DyadKind,
    PoseConditions,
    as_complex,
    as_points,
    checked_poses,
    common_pole,
    cranks_and_blocks,
    dyads_of,
    in_plane,
    is_translation,
    three_pose_dyads,
)
from mafsil.mobility.synthesis.fitting import four_bars_of, slider_cranks_of
from mafsil.mobility.synthesis.five_poses import BurmesterCurves, block_of, curves_of, five_pose_pairs
from mafsil.mobility.tolerances import AT_INFINITY, EXACT, SAME_POSE

MOST_DYADS = 4


def synthesise_motion(
    poses: ArrayLike, *, fixed: ArrayLike | None = None, moving: ArrayLike | None = None, samples: int = 100,
    limits: LinkageLimits = NO_LIMITS,
) -> Synthesis:  # fmt: skip
    """Linkages whose coupler takes poses in the plane, in their order.

    Five poses have at most four dyads: all are found, and all pairs of them (up to six four-bars). Four poses have a
    curve of dyads, which is sampled. Three poses take any point of the coupler, or of the ground, as a pivot: those
    given, or a grid. Each four-bar is driven by the side link that does it better.

    Args:
        poses: (N, 3) of the coupler, N from 3 to 5: (x, y, phi) [m, rad].
        fixed: (k, 2) fixed pivots to choose from [m]; three poses only.
        moving: (k, 2) moving pivots to choose from, in the frame of the coupler [m]; three poses only.
        samples: of three poses points of the grid, of four poses lines across the curve.
        limits: region of fixed pivots, least transmission angle, longest link.

    Returns:
        All candidates with their defects, good ones first.

    Raises:
        InputError: another number of poses, two poses that coincide, pivots with more than three poses, or both kinds.
    """
    given = checked_poses(poses, 3, 5)
    if given.ndim != 2:
        raise InputError("synthesis.pose_count", got=given.shape, least=3, most=5)
    whole("samples", samples, 4, 4000)
    chosen = (fixed is not None) + (moving is not None)
    if chosen > (1 if len(given) == 3 else 0):
        raise InputError("synthesis.too_many_choices", count=len(given))
    conditions = PoseConditions.of(given)
    special = _special(conditions)
    if special is not None:
        return special
    choices = [None if each is None else pivots(name, each) for name, each in (("fixed", fixed), ("moving", moving))]
    dyads, curves, infinite = dyads_through(conditions, samples, *choices)
    if infinite:
        return Synthesis(SynthesisStatus.INFINITE, "motion", NOTHING, given, (), None, "", {})
    cranks, blocks = cranks_and_blocks(dyads)
    batches = [four_bars_of(cranks), slider_cranks_of(cranks, blocks)]
    ranking = rank_candidates(batches, float(conditions.size), either_side=True, limits=limits)
    method = {3: "by_choice" if chosen else "by_grid", 4: "by_curve", 5: "by_five"}[len(given)]
    return Synthesis(
        outcome(ranking, sampled=len(given) < 5),
        "motion",
        ranking,
        given,
        tuple(dyads),
        curves,
        method,
        count_dyads(dyads),
    )


def count_dyads(dyads: list[Dyad]) -> dict[str, Any]:
    """How many dyads there are of each kind, for sentences."""
    kinds = [one.kind for one in dyads]
    return {"real": len(kinds), **{kind.name.lower() + "s": kinds.count(kind) for kind in DyadKind}}


def pivots(name: str, value: ArrayLike) -> Floats:
    """(k, 2) points to choose from.

    Args:
        name: of the argument, for the error.
        value: what the user gave.

    Raises:
        InputError: another shape, fewer than two, or not finite.
    """
    points = real_array(name, value)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not np.isfinite(points).all():
        raise InputError("synthesis.pivots", name=name, got=points.shape)
    return points


def dyads_through(
    conditions: PoseConditions, samples: int, fixed: Floats | None = None, moving: Floats | None = None
) -> tuple[list[Dyad], BurmesterCurves | None, bool]:
    """Dyads of one list of poses, the curves of four poses, and whether five poses have infinitely many.

    Args:
        conditions: three, four or five poses.
        samples: of three poses points of a grid, of four poses lines across the curve.
        fixed, moving: pivots to choose from for three poses, or None.
    """
    count = len(conditions.d)
    if count == 3:
        return three_pose_dyads(conditions, fixed, moving, samples), None, False
    if count == 4:
        curves = curves_of(conditions, samples)
        p, q = block_of(conditions)
        p, q = np.concatenate([curves.p, p]), np.concatenate([curves.q, q])
        return dyads_of(conditions, p, q), curves, False
    group = larger_group(conditions)
    if group is not None and not group.all():
        p, q, infinite = two_angle_pairs(conditions, group)
        return dyads_of(conditions, p, q), None, infinite
    pairs = five_pose_pairs(conditions.M)
    return dyads_of(conditions, pairs.p, pairs.q), None, bool(pairs.infinite)


def _special(conditions: PoseConditions) -> Synthesis | None:
    """The answer to poses that need no four-bar, or None."""
    poses = conditions.poses
    pole = common_pole(conditions)
    if pole is not None:
        return Synthesis(
            SynthesisStatus.ONE_POLE, "motion", NOTHING, poses, (), None, "", pole_details(conditions, pole)
        )
    if not is_translation(conditions) or len(poses) == 3:
        return None
    error = circle_error(as_complex(poses[:, :2])) / float(conditions.size)
    method = "translation_on_circle" if error <= EXACT else "translation_off_circle"
    return Synthesis(SynthesisStatus.TRANSLATION, "motion", NOTHING, poses, (), None, method, {
        "count": len(poses), "error": error * float(conditions.size)})  # fmt: skip


def pole_details(conditions: PoseConditions, pole: complex) -> dict[str, Any]:
    """Where a pole of size one lies in the world, without digits that are rounding, and how many poses there are."""
    place, size = complex(conditions.in_world(np.complex128(pole))), float(conditions.size)
    x, y = (size * round(each / size, 9) + 0.0 for each in (place.real, place.imag))
    return {"count": len(conditions.poses), "x": x, "y": y}


def circle_error(z: Complexes) -> float:
    """Largest distance of points (N,) from the circle (or line) that fits them best by its equation [m]."""
    middle = z.mean()
    size = max(float(np.abs(z - middle).max()), LEAST_DIVISOR)
    unit = (z - middle) / size
    rows = np.stack([np.abs(unit) ** 2, unit.real, unit.imag, np.ones(len(z))], axis=1)
    a, b, c, d = np.linalg.svd(rows)[2][-1]
    value = rows @ np.array([a, b, c, d])
    slope = np.abs(2 * a * unit + complex(b, c))
    return float(np.abs(value / np.maximum(slope, LEAST_DIVISOR)).max()) * size


def larger_group(given: PoseConditions) -> Booleans | None:
    """(5,) which poses have the angle of most; None if there are three angles or more."""
    same = np.abs(given.E[:, None] - given.E[None]) <= SAME_POSE
    group = same[int(same.sum(axis=1).argmax())]
    others = np.flatnonzero(~group)
    if len(others) and not same[others[0], others].all():
        return None
    return np.asarray(group, dtype=np.bool_)


def two_angle_pairs(given: PoseConditions, group: Booleans) -> tuple[Floats, Floats, bool]:
    """Homogeneous fixed pivots (k, 3), moving pivots in the first pose (k, 3), and whether there are infinitely many.

    Args:
        given: one list of five poses.
        group: the poses that have the angle of most: three or four.
    """
    none = np.zeros((0, 3))
    inside, outside = np.flatnonzero(group), np.flatnonzero(~group)
    start = int(inside[0])
    E = given.E / given.E[start]
    d = given.d - E * given.d[start]  # W_j = d_j + E_j w with w in the pose `start`
    first, second = complex(d[inside[1]]), complex(d[inside[2]])
    area = (np.conj(first) * second).imag
    if abs(area) <= AT_INFINITY * abs(first) * abs(second):
        # A point may run on a line only; both poses of the other angle then ask for parallel lines in the coupler.
        step = complex(d[outside[0]] - d[outside[-1]])
        return none, none, abs((np.conj(first) * step).imag) <= AT_INFINITY * abs(first) * (1 + abs(step))
    middle = 1j * (first * abs(second) ** 2 - second * abs(first) ** 2) / (2 * area)
    if len(outside) < 2:
        fits = abs(abs(complex(d[inside[3]]) - middle) - abs(middle)) <= EXACT * abs(middle)
        return none, none, bool(fits)
    e = complex(E[outside[0]]) - 1
    centres = as_points((middle - d[outside]) / e)
    radius = abs(middle) / abs(e)
    meet = circle_gap(centres[0], radius, centres[1], radius) == 0.0
    w = as_complex(circle_crossings(centres[0], radius, centres[1], radius)[: 2 if meet else 0])
    q = given.d[0] + given.E[0] * (w - given.d[start]) / given.E[start]
    return _homogeneous(w + middle), _homogeneous(q), False


def _homogeneous(z: np.ndarray[tuple[int, ...], np.dtype[np.complex128]]) -> Floats:
    return np.stack([z.real, z.imag, np.ones(len(z))], axis=1)


@dataclass(frozen=True, eq=False, repr=False)
class ManyDyads:
    """Dyads of batches of five poses; the point of one with a slider is infinite, across the line of the slider.

    Attributes:
        fixed: (*batch, 4, 2) fixed pivots [m]; NaN beyond their number, where `there` is false.
        moving: (*batch, 4, 2) moving pivots in the frame of the coupler [m], likewise.
        count: (*batch,) number of real dyads.
        infinite: (*batch,) whether there are infinitely many, or the poses have only two angles (which
            `synthesise_motion` takes), so that none is listed.
    """

    fixed: Floats
    moving: Floats
    count: Integers
    infinite: Booleans

    def __repr__(self) -> str:
        return f"ManyDyads(count={self.count!r}, infinite={self.infinite!r})"

    @property
    def there(self) -> Booleans:
        """(*batch, 4) which places hold a dyad."""
        return np.asarray(np.arange(MOST_DYADS) < self.count[..., None], dtype=np.bool_)


def five_pose_dyads(poses: ArrayLike) -> ManyDyads:
    """All dyads of five poses each.

    Args:
        poses: (*batch, 5, 3) poses (x, y, phi) of the coupler [m, rad].

    Raises:
        InputError: not five poses, or two of one list coincide.
    """
    given = PoseConditions.of(checked_poses(poses, 5, 5))
    pairs = five_pose_pairs(given.M)
    first = np.argsort(~pairs.real, axis=-1, kind="stable")[..., :MOST_DYADS]
    p, q = (np.take_along_axis(points, first[..., None], axis=-2) for points in (pairs.p, pairs.q))
    turn = np.exp(-1j * given.poses[..., :1, 2])
    origin = given.poses[..., :1, 0] + 1j * given.poses[..., :1, 1]
    middle, size = given.middle[..., None], given.size[..., None]
    with np.errstate(invalid="ignore"):
        fixed = in_plane(np.asarray(p, dtype=np.float64), middle, size)
        moving = in_plane(np.asarray(q, dtype=np.float64), middle - origin, size, turn)
    return ManyDyads(fixed, moving, pairs.real.sum(axis=-1), pairs.infinite)
