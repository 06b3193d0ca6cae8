"""Configurations of a linkage of mobility 2 followed as a surface: charts that cover it, triangles, Euler's number.

Charts: M. Henderson, Multiple parameter continuation, Int. J. Bifurcation and Chaos 12 (2002); in robotics J. Porta,
L. Ros, O. Bohigas, M. Manubens, C. Rosales, L. Jaillet, The CUIK suite, IEEE Robotics & Automation Magazine 21 (2014).

Where sheets of configurations meet: places at which the loop matrix really loses rank, found and made sure of.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, positive, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.mobility.balls import without_balls, without_balls_at
from mafsil.mobility.charts import SMALLEST, Charts, Whole, differences, tangent_planes, wrapped_points
from mafsil.mobility.finite import require_motions
from mafsil.mobility.instantaneous import instantaneous_mobility
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import close_loops_near, configuration, loop_matrix, loop_state, units
from mafsil.mobility.surface_mesh import agreed_triangles, area, edges, is_closed, is_orientable, trim_openings
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
LONGEST = 0.3
MOST_POINTS = 20_000
AROUND_PINCH = 8.0
"""Smallest radii of charts around a singular place within which charts that gave up belong to it."""


class SurfaceStatus(Status):
    """How following a surface ended."""

    CLOSED = ("mobility.surface_closed", True)
    ONE_SIDED = ("mobility.surface_one_sided", True)
    PINCHED = ("mobility.surface_pinched", True)
    OPEN = ("mobility.surface_open", True)
    STUCK = ("mobility.surface_stuck", False)


@dataclass(frozen=True, eq=False, repr=False)
class ConfigurationSurface(
    Answer,
    data="euler_characteristic genus area theta triangles branch_points singular_points openings left_out "
    "coordinates=linkage.coordinate_names",
):
    """A surface of configurations; true if it was followed everywhere or as far as was allowed.

    Attributes:
        linkage: of mobility 2, the balls left out: its coordinates F are those of the other joints, and nine for each
            body that hangs on balls or floats: by how much three of its points are elsewhere [m].
        status: closed, closed and one-sided, pinched (closed but for singular places), open (the number of points is
            spent), stuck (charts gave up where no singular place was found, or triangles do not fit).
        theta: (n, F) coordinates of its points [rad | m]; angles of hinges in [-pi, pi).
        triangles: (t, 3) indices of points.
        branch_points: (b, F) points where the orientation of the constraints reverses: another sheet crosses, and the
            surface goes straight on.
        singular_points: (p, F) configurations at which the loop matrix loses rank and the surface is not smooth.
        openings: how often the surface runs into singular places.
        charts: its charts.
    """

    linkage: Linkage
    status: SurfaceStatus
    theta: Floats
    triangles: Whole
    branch_points: Floats
    singular_points: Floats
    openings: int
    charts: Charts

    @property
    def euler_characteristic(self) -> int | None:
        """Points - edges + triangles: 2 of a sphere, 0 of a torus; None while it is open or stuck.

        Of a pinched surface each opening at a singular place counts as closed by a disc of its own.
        """
        if self.status in (SurfaceStatus.OPEN, SurfaceStatus.STUCK):
            return None
        points = len(np.unique(self.triangles))
        return points - len(edges(self.triangles)[0]) + len(self.triangles) + self.openings

    @property
    def genus(self) -> int | None:
        """Number of handles, 0 of a sphere, 1 of a torus; None unless it is closed and two-sided."""
        euler = self.euler_characteristic
        return (2 - euler) // 2 if euler is not None and self.status is SurfaceStatus.CLOSED else None

    @cached_property
    def area(self) -> float:
        """Area of the triangles in the coordinates [rad^2, sizes^2]."""
        a, b, c = (self.charts.points[corner] for corner in self.triangles.T)
        return area(differences(self.linkage, a, b), differences(self.linkage, a, c))

    def holds(self, theta: ArrayLike) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """(m,) whether closed configurations (m, F) lie on it: ways along it from the nearest charts end there."""
        given = as_batch("theta", theta, (self.linkage.coordinates,), finite=True)
        return self.charts.leads_to(given.reshape(-1, self.linkage.coordinates) / units(self.linkage))

    @property
    def left_out(self) -> tuple[str, ...]:
        """Names of the balls that have no coordinates on it: the others decide how they stand, but for idle spins."""
        return tuple(dict.fromkeys(name for pair in self.linkage.pairs for name in pair.joints))

    def explain(self, language: str | None = None) -> str:
        """How it ended, its size, Euler characteristic and genus, branch points, singular places, balls left out."""
        found = self.status.sentence(
            language, points=len(self.theta), triangles=len(self.triangles), area=self.area,
            euler=self.euler_characteristic, genus=self.genus, branches=len(self.branch_points),
            singular=len(self.singular_points), openings=self.openings, stuck=len(self.charts.stuck),
        )  # fmt: skip
        lines = [found]
        if self.left_out:
            lines.append(say("mobility.surface_balls", language=language, joints=", ".join(self.left_out)))
        if free := [self.linkage.joints[k].child for k, _, _ in self.linkage.by_points]:
            lines.append(say("mobility.surface_points", language=language, bodies=", ".join(free)))
        return "\n".join(lines)


@on_linkage
def trace_surface(
    linkage: Linkage, theta: ArrayLike | None = None, *, step: float = LONGEST, points: int = MOST_POINTS
) -> ConfigurationSurface:
    """Follow the configurations of a linkage of mobility 2 from a regular one, until they cover a surface.

    1. Charts (a point, its tangent plane, the cell nearer to it than to others) spread until cells fit their radii;
       radii follow the turn of the tangent plane.
    2. Neighbours in the cells make triangles, and random weights make the cells agree on them.
    3. Along edges the sign of det [kept rows; tangent plane] tells where another sheet crosses: by false position.
    4. Where radii would get too small, Gauss-Newton's method looks for a place at which the loop matrix loses rank.

    Closed means: of the triangles two meet at each edge and one ring at each point, a theorem about the triangles. That
    the surface is as they say rests on `step`; halve it to see whether the answer stays.

    Balls have no coordinates on the surface, whose angles would lock: those that close loops hold points together, rods
    between two balls keep a distance, and how they spin does not count. A body that hangs on balls or floats has the
    places of three of its points as coordinates.

    Args:
        linkage: of mobility 2 but for spins of rods between two balls.
        theta: (F,) start [rad | m]; as drawn if None.
        step: longest radius of a chart [rad, sizes].
        points: at most; memory grows in proportion to their number.

    Raises:
        InputError: the mobility by rank is not 2 at the start, or it does not close there.
        ModelError: a rod between two balls that holds on to another such rod.
    """
    largest, most = positive("step", step), whole("points", points, 3, 1_000_000)
    start = without_balls_at(linkage, configuration(linkage, theta))
    return follow_surface(without_balls(linkage), start, largest, most)


def follow_surface(linkage: Linkage, theta: Floats, largest: float, most: int) -> ConfigurationSurface:
    """The same of a linkage without balls; arguments as for `trace_surface`."""
    start = close_loops_near(linkage, theta)
    if not start:
        raise InputError("mobility.surface_start", gap=float(start.gap))
    mobility = instantaneous_mobility(linkage, start.theta).mobility
    if mobility != 2:
        raise InputError("mobility.surface_two", mobility=mobility)
    require_motions(linkage, start.theta, 2)
    charts = Charts.first_chart(linkage, start.theta, largest)
    all_covered = charts.spread(most)
    triangles, left = agreed_triangles(charts)
    triangles, rim, openings = trim_openings(triangles, charts.stuck)
    singular, alone = pinches(charts, AROUND_PINCH * SMALLEST * largest)
    branches = crossings(charts, edges(triangles)[0])
    if not all_covered:
        status = SurfaceStatus.OPEN
    elif left or alone or not _near(charts, rim, singular):
        status = SurfaceStatus.STUCK
    elif charts.stuck:
        status = SurfaceStatus.PINCHED
    elif not is_closed(triangles, len(charts.points)):
        status = SurfaceStatus.STUCK
    else:
        status = SurfaceStatus.CLOSED if is_orientable(triangles) else SurfaceStatus.ONE_SIDED
    scale = units(linkage)
    return ConfigurationSurface(
        linkage, status, charts.points * scale, triangles, branches * scale, singular * scale,
        openings if status is SurfaceStatus.PINCHED else 0, charts,
    )  # fmt: skip


def _near(charts: Charts, corners: Whole, places: Floats) -> bool:
    """Whether charts all stand around singular places."""
    ways = [np.linalg.norm(differences(charts.linkage, point, places), axis=1) for point in charts.points[corners]]
    return all(float(way.min(initial=np.inf)) < 2 * AROUND_PINCH * SMALLEST * charts.radius for way in ways)


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
        here = here + step * min(1.0, 0.3 / max(float(np.abs(step).max()), LEAST_DIVISOR))
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
        after = _sign(linkage, start + way, *frame)
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
        values: (e,) of `_sign` there, positive and negative.
        frame: of the edges.
    """
    scale, (low, high), (above, below) = units(linkage), ends, values
    here, stayed = low, np.zeros(len(low))
    for _ in range(MOST_TRIES):
        share = np.clip(above / np.maximum(above - below, LEAST_DIVISOR), 0.01, 0.99)  # 1
        before, here = here, close_loops_near(linkage, (low + share[:, None] * (high - low)) * scale).theta / scale
        value = _sign(linkage, here, *frame)
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


def _sign(linkage: Linkage, points: Floats, rows: Floats, bases: Floats, sign: Floats) -> Floats:
    """(e,) the determinant of `_determinant`, positive where the orientation is that of the frame."""
    planes = tangent_planes(linkage, points)
    turned = np.sign(np.linalg.det(np.swapaxes(bases, -1, -2) @ planes))
    return _determinant(linkage, points, rows, planes) * turned * sign


def _determinant(linkage: Linkage, points: Floats, rows: Floats, planes: Floats) -> Floats:
    A = rows @ loop_matrix(linkage, points * units(linkage))
    return np.linalg.det(np.concatenate([A, np.swapaxes(planes, -1, -2)], axis=-2))
