"""How far a grasp holds in service: against the wrenches that will really come, with contacts where they should not be.

Contacts are never quite where they should be: how much closure survives, proven and by sampling. Independent contact
regions say how far each finger may be off its place without losing closure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, not_negative, whole
from mafsil.errors import InputError
from mafsil.grasp.contact import Contact
from mafsil.grasp.contact_batch import wrench_closures
from mafsil.grasp.grasp import Grasp
from mafsil.grasp.quality import hull_facets, quality_of_wrenches
from mafsil.grasp.tolerances import LEAST_FRICTION, ROUNDOFF, TYPED
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


EDGES = 8


class RobustnessStatus(Status):
    """Whether a grasp closes, and with a margin."""

    PROVEN = ("grasp.robust_proven", True)
    """It closes, and as long as its wrenches change by less than the margin."""
    NO_MARGIN = ("grasp.robust_no_margin", False)
    """As planned it does not close, or only just: every error however small may open it."""


@dataclass(frozen=True, eq=False, repr=False)
class Robustness(Answer, data="proven probability low high samples"):
    """Robustness of a grasp to errors of its contacts; true if it closes with a margin.

    Attributes:
        proven: closure is certain as long as no wrench of unit push changes by more than this (moments divided by
            the length scale): it is the epsilon quality.
        probability: share of the samples that close.
        low, high: 95 % interval of the probability that the number of samples allows (Wilson).
        samples: how many.
    """

    proven: float
    probability: float
    low: float
    high: float
    samples: int

    @property
    def status(self) -> RobustnessStatus:
        """Whether there is a margin."""
        return RobustnessStatus.PROVEN if self.proven > 0 else RobustnessStatus.NO_MARGIN

    def explain(self, language: str | None = None) -> str:
        """The margin, and the share of the samples that close with its interval."""
        shares = {"share": 100 * self.probability, "low": 100 * self.low, "high": 100 * self.high}
        return self.status.sentence(language, margin=self.proven, samples=self.samples, **shares)


def robustness(
    grasp: Grasp, *, position: float = 0.0, angle: float = 0.0, friction: float = 0.0, length: float = 1.0,
    samples: int = 1000, seed: int = 0,
) -> Robustness:  # fmt: skip
    """Closure under normally distributed errors of every contact, independent of each other.

    Args:
        grasp: the contacts as planned.
        position: standard deviation of each coordinate of a contact point [m].
        angle: standard deviation of the normal's tilt about each tangent [rad].
        friction: standard deviation of mu relative to mu; never below 0.
        length: moments are divided by it [m].
        samples: grasps drawn.
        seed: of the draws.

    Raises:
        InputError: negative deviations or no samples.
    """
    for name, value in (("position", position), ("angle", angle), ("friction", friction)):
        if not (np.isfinite(value) and value >= 0):
            raise InputError("grasp.negative_coefficient", name=name, value=value)
        not_negative(name, value)
    whole("samples", samples, 1, 10_000_000)
    rng = np.random.default_rng(seed)
    drawn = np.array(
        [
            Grasp([_shaken(c, position, angle, friction, rng) for c in grasp.contacts]).matrix(EDGES)
            for _ in range(samples)
        ]
    )
    share = float(wrench_closures(drawn).force_closure.mean())
    low, high = _wilson(share, samples)
    return Robustness(grasp.quality(length).epsilon, share, low, high, samples)


def _shaken(contact: Contact, position: float, angle: float, friction: float, rng: np.random.Generator) -> Contact:
    point = contact.point + position * rng.normal(size=contact.dimension)
    normal = contact.normal + np.tan(angle * rng.normal(size=contact.dimension - 1)) @ contact.tangents
    factor = max(0.0, 1.0 + friction * rng.normal()) if contact.mu > 0 else 1.0
    mu = max(contact.mu * factor, LEAST_FRICTION) if contact.mu > 0 else 0.0
    return Contact(point, normal, mu, contact.gamma)


def _wilson(share: float, samples: int) -> tuple[float, float]:
    z = 1.959963984540054
    middle = share + z * z / (2 * samples)
    half = z * np.sqrt(share * (1 - share) / samples + z * z / (4 * samples**2))
    size = 1 + z * z / samples
    return max(0.0, float((middle - half) / size)), min(1.0, float((middle + half) / size))


def tolerance(grasp: Grasp, length: float = 1.0) -> Floats:
    """How far each contact alone may slide, all at once, before the proof of closure is lost [m].

    Sliding by s changes the wrench of unit push by at most s sqrt(1 + mu^2) / length (normal unchanged).

    Args:
        grasp: a grasp that closes.
        length: moments are divided by it [m].

    Returns:
        (contacts,) [m]; zero if the grasp does not close.
    """
    epsilon = grasp.quality(length).epsilon
    return np.array([epsilon * length / np.sqrt(1.0 + c.mu**2) for c in grasp.contacts])


@dataclass(frozen=True, eq=False)
class PairRegions:
    """Two intervals on two edges: fingers anywhere inside close.

    Attributes:
        first, second: (2, 2) ends of the intervals [m].
        length: of the shorter one [m].
    """

    first: Floats
    second: Floats
    length: float


def two_finger_regions(first: ArrayLike, second: ArrayLike, mu: float) -> PairRegions | None:
    """The longest pair of intervals on two edges such that any two fingers on them close (facing each other).

    The line between two points lies in a cone iff a linear inequality in their places holds for each cone edge; all
    four corners of the square of places must meet them: a linear program.

    Args:
        first, second: (2, 2) ends of the edges in order, the body to the left [m].
        mu: friction coefficient of both.

    Returns:
        The regions, or None if no two points of the edges close.

    Reference:
        V.-D. Nguyen, Constructing force-closure grasps, IEEE ICRA 1986.
    """
    a, b = as_batch("first", first, (2, 2), finite=True), as_batch("second", second, (2, 2), finite=True)
    u, v = a[1] - a[0], b[1] - b[0]
    p, q = (float(np.linalg.norm(w)) for w in (u, v))
    if not p > 0 or not q > 0:
        raise InputError("grasp.same_point", indices="0, 1")
    u, v = u / p, v / q
    rows: list[Floats] = []
    right: list[float] = []
    for tangent, sign in ((u, 1.0), (v, -1.0)):
        n = np.array([-tangent[1], tangent[0]])
        for side in (-1.0, 1.0):
            # mu n.d + side t.d >= 0 for the line d from the finger to the other one
            g = sign * (mu * n + side * tangent)
            constant, by_s, by_t = float(g @ (b[0] - a[0])), -float(g @ u), float(g @ v)
            s = (0, 1) if by_s < 0 else (1, 0)
            t = (2, 3) if by_t < 0 else (3, 2)
            row = np.zeros(5)
            row[s[1]], row[t[1]] = -by_s, -by_t
            rows.append(row)
            right.append(constant)
    rows += list(np.array([[1, -1, 0, 0, 1], [0, 0, 1, -1, 1], [0, 1, 0, 0, 0], [0, 0, 0, 1, 0]], float))
    right += [0.0, 0.0, p, q]
    best = minimise(np.array([0, 0, 0, 0, -1.0]), None, None, np.array(rows, float), np.array(right))
    if best is None or best.x[4] <= TYPED * max(p, q):
        return None
    s0, s1, t0, t1, length = best.x
    return PairRegions(
        np.array([a[0] + s0 * u, a[0] + s1 * u]), np.array([b[0] + t0 * v, b[0] + t1 * v]), float(length)
    )


def frictionless_regions(grasp: Grasp, radius: float | None = None) -> Floats:
    """How far each frictionless plane finger may slide along its edge, all independently, keeping a quality.

    Moving wrench w_i keeps the ball of that radius if u . w_i(s) >= radius for every facet normal u of the seed's hull
    that w_i carries: any direction is a positive combination of such normals of total at least 1.

    Args:
        grasp: plane, frictionless, force closure, on straight edges.
        radius: of the ball that must stay; half of the seed's if None.

    Returns:
        (contacts, 2) least and greatest displacement along the tangent [m], the edge's ends not considered.

    Raises:
        InputError: no such grasp.

    Reference:
        M. A. Roa, R. Suarez, Computation of independent contact regions for grasping 3-D objects, IEEE Trans. Robotics
        25(4), 2009.
    """
    if grasp.dimension != 2 or not grasp.frictionless:
        raise InputError("grasp.needs_plane", what="frictionless_regions")
    A = grasp.normals_matrix
    facets = hull_facets(A)
    if facets is None or (facets[:, -1] >= 0).any():
        raise InputError("grasp.seed_not_closed")
    keep = 0.5 * float(-facets[:, -1].max()) if radius is None else radius
    answer = np.empty((len(grasp), 2))
    for i in range(len(grasp)):
        mine = facets[np.abs(facets[:, :-1] @ A[:, i] + facets[:, -1]) <= TYPED * np.abs(A).max()]
        # Sliding by s along the tangent adds s (t x n) to the moment: t x n = -1.
        slope, level = -mine[:, 0], mine[:, :-1] @ A[:, i] - keep
        low = [-level[k] / slope[k] for k in range(len(mine)) if slope[k] > ROUNDOFF]
        high = [-level[k] / slope[k] for k in range(len(mine)) if slope[k] < -ROUNDOFF]
        answer[i] = max(low, default=-np.inf), min(high, default=np.inf)
    return answer
