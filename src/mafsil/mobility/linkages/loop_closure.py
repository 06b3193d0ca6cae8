"""Where bodies of a linkage stand, how far its loops gape, and what the loops ask of the rates of its joints.

Rows of loops are free of units: screws about the middle of the linkage, lengths over its size, coordinates of
translation over its size. Memory: (6 L + 32 N + 22 F) numbers for each row of a batch.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, frozen, real_array, single
from mafsil.errors import ModelError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose, rotation
from mafsil.mobility.bodies.three_points import SCALE, SIDES, distances, pose_by_points
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.linkage_joint import Kind
from mafsil.mobility.tolerances import CLOSED, RANK
from mafsil.solvers import decompositions
from mafsil.solvers.null_ways import Equations

MOST_STEPS = 60
IN_PLANE = np.array([2, 3, 4])
"""Rows of twists of the plane: turn about z, x, y."""
CONTRACTED = 0.1
"""Share of the gap that a step with slopes of before may leave; where it leaves more, they are taken anew."""
SMALLEST_LOOP = 1e-6
"""Share of the size of the linkage below which the joints of a loop stand in one point."""
LONGEST_STEP = 0.5
"""Of coordinates [rad, sizes] in one Newton step."""


def coordinates(linkage: Linkage, theta: ArrayLike | None) -> Floats:
    """Coordinates of all joints as an array (*batch, F); zero, where the linkage is drawn, if None."""
    if theta is None:
        return np.zeros(linkage.coordinates)
    return as_batch("theta", theta, (linkage.coordinates,), finite=True)


def configuration(linkage: Linkage, theta: ArrayLike | None) -> Floats:
    """Coordinates of one configuration (F,); zero, where the linkage is drawn, if None."""
    return np.zeros(linkage.coordinates) if theta is None else single("theta", theta, (linkage.coordinates,))


def units(linkage: Linkage) -> Floats:
    """(F,) one for angles, the size of the linkage [m] for translations, SCALE times that for places of points."""
    scale = np.where(are_lengths(linkage), linkage.size, 1.0)
    for _, _, columns in linkage.by_points:
        scale[columns] *= SCALE
    return scale


def are_lengths(linkage: Linkage) -> NDArray[np.bool_]:
    """(F,) which coordinates are translations and places [m], no angles."""
    found = np.abs(linkage.screws[:3]).max(axis=0, initial=0.0) == 0
    for _, _, columns in linkage.by_points:
        found[columns] = True
    return found


def _joint_motions(linkage: Linkage, theta: Floats) -> tuple[Floats, Floats]:
    """Displacement by each joint (*batch, J, 4, 4), and by what stands before each coordinate (*batch, F, 4, 4)."""
    steps = pose.exp(theta[..., None] * linkage.screws.T)
    columns = {index: own for index, _, own in linkage.by_points}
    eye = np.broadcast_to(np.eye(4), (*theta.shape[:-1], 4, 4))
    motions: list[Floats] = []
    before: list[Floats] = []
    first = 0
    for index, each in enumerate(linkage.joints):
        done = eye
        for k in range(first, first + each.freedoms):
            before.append(done)
            done = done @ steps[..., k, :, :] if each.corners is None else eye
        if each.corners is not None:
            done = pose_by_points(each.corners, theta[..., columns[index]])[0]
        motions.append(done @ linkage.apart[each.name] if each.name in linkage.apart else done)
        first += each.freedoms
    empty = np.zeros((*theta.shape[:-1], 0, 4, 4))
    return np.stack(motions, axis=-3), np.stack(before, axis=-3) if before else empty


@on_linkage
def body_poses(linkage: Linkage, theta: ArrayLike | None = None) -> Floats:
    """Displacements of the bodies from where they are drawn, along the walk from the ground.

    Args:
        linkage: as drawn.
        theta: (*batch, F) coordinates [rad | m].

    Returns:
        (*batch, N, 4, 4).
    """
    value = coordinates(linkage, theta)
    return _poses(linkage, value, _joint_motions(linkage, value)[0])


def _poses(linkage: Linkage, theta: Floats, motions: Floats) -> Floats:
    T = np.zeros((*theta.shape[:-1], len(linkage.bodies), 4, 4))
    T[..., 0, :, :] = np.eye(4)
    for k, forward in linkage.tree:
        start, end = linkage.ends[k] if forward else linkage.ends[k][::-1]
        step = motions[..., k, :, :] if forward else pose.inverse(motions[..., k, :, :])
        T[..., end, :, :] = T[..., start, :, :] @ step
    return T


@on_linkage
def point_position(linkage: Linkage, body: str, point: ArrayLike, theta: ArrayLike | None = None) -> Floats:
    """(*batch, 3) where a point of a body is: R p + o, for p where it is drawn [m].

    Args:
        linkage: as drawn.
        body: its name.
        point: (3,) place in the drawing, of a planar linkage (2,) too [m].
        theta: (*batch, F) coordinates [rad | m].

    Raises:
        ModelError: no such body.
    """
    if body not in linkage.bodies:
        raise ModelError("mobility.no_output", output=body, known=", ".join(linkage.bodies))
    T = body_poses(linkage, theta)[..., linkage.bodies.index(body), :, :]
    place = real_array("point", point)
    if linkage.planar and place.shape == (2,):
        place = np.append(place, 0.0)
    return np.asarray(pose.act(T, single("point", place, (3,))))


@dataclass(frozen=True, eq=False)
class LoopState:
    """A linkage at coordinates theta, batches first.

    Attributes:
        poses: (*batch, N, 4, 4) displacements of the bodies.
        screws: (*batch, 6, F) of the joints where they are now, in the frame of the drawing.
        gap: (*batch, 6 L + K + P) twist that would close each loop at the joint that closes it, free of units; then
            what the K couplings miss, the pairs of points, and the sides of bodies that have three points.
        matrix: (*batch, 6 L + K + P, F) rates of the gaps per rate of coordinates, free of units.
    """

    poses: Floats
    screws: Floats
    gap: Floats
    matrix: Floats


def loop_state(linkage: Linkage, theta: ArrayLike | None = None) -> LoopState:
    """Poses, screws, gaps and loop matrix at coordinates.

    The loop through joint (a, b) closes if G = T_a E T_b^-1 = 1; its rate is V_a + S theta' - Ad(G) V_b.

    Args:
        linkage: as drawn.
        theta: (*batch, F) [rad | m].
    """
    value = coordinates(linkage, theta)
    motions, before = _joint_motions(linkage, value)
    T = _poses(linkage, value, motions)
    parents = linkage.ends[linkage.joint_of, 0]
    screws = np.einsum("...kij,jk->...ik", pose.adjoint(T[..., parents, :, :] @ before), linkage.screws)
    for k, corners, columns in linkage.by_points:
        twists = pose_by_points(corners, value[..., columns])[1]
        screws[..., columns] = pose.adjoint(T[..., linkage.ends[k, 0], :, :]) @ twists
    gap, rows = _gaps(linkage, T, motions, screws)
    if linkage.couplings:
        missed, moved, _ = coupling_errors(linkage, value)
        gap, rows = np.concatenate([gap, missed], axis=-1), np.concatenate([rows, moved], axis=-2)
    if linkage.pairs:
        missed, moved = _pairs_of(linkage, T, screws)
        gap, rows = np.concatenate([gap, missed], axis=-1), np.concatenate([rows, moved], axis=-2)
    for _, corners, columns in linkage.by_points:
        missed, moved = distances(corners, value[..., columns])
        sides = np.zeros((*rows.shape[:-2], len(SIDES), linkage.coordinates))
        sides[..., columns] = moved * SCALE
        gap = np.concatenate([gap, missed / linkage.size], axis=-1)
        rows = np.concatenate([rows, sides], axis=-2)
    return LoopState(T, screws, gap, rows)


def coupling_errors(linkage: Linkage, theta: Floats) -> tuple[Floats, Floats, Floats]:
    """What the couplings miss (*batch, K), its first and second derivatives by the coordinates (*batch, K, F).

    u_follower - f(u_leader) = 0, coordinates over `units`, free of units.

    Args:
        linkage: as drawn.
        theta: (*batch, F) [rad | m].
    """
    scale, shape = units(linkage), (*theta.shape[:-1], len(linkage.couplings))
    gap, rows, bends = np.zeros(shape), np.zeros((*shape, linkage.coordinates)), np.zeros((*shape, linkage.coordinates))
    for k, each in enumerate(linkage.couplings):
        follower, leader = (int(linkage.columns_of([name])[0]) for name in (each.follower, each.leader))
        value, slope, bend = each.motion(theta[..., leader])
        gap[..., k] = (theta[..., follower] - value) / scale[follower]
        rows[..., k, follower], rows[..., k, leader] = 1.0, -slope * scale[leader] / scale[follower]
        bends[..., k, leader] = -bend * scale[leader] ** 2 / scale[follower]
    return gap, rows, bends


def _pairs_of(linkage: Linkage, T: Floats, screws: Floats) -> tuple[Floats, Floats]:
    """What the pairs of points miss (*batch, P), over the size, and its rates (*batch, P, F)."""
    own: Floats = reduced_screws(linkage, screws)
    index = np.array([[linkage.bodies.index(body) for body in pair.bodies] for pair in linkage.pairs])
    points = np.array([pair.points for pair in linkage.pairs])
    of = T[..., index, :, :]
    x = np.einsum("...peij,pej->...pei", of[..., :3, :3], points) + of[..., :3, 3]
    x = (x - linkage.middle) / linkage.size
    moved = own[..., None, None, 3:, :] - rotation.hat(x) @ own[..., None, None, :3, :]
    moved = linkage.paths[index][..., linkage.joint_of][:, :, None, :] * moved
    missed, rows = list[Floats](), list[Floats]()
    for k, pair in enumerate(linkage.pairs):
        apart, rate = x[..., k, 0, :] - x[..., k, 1, :], moved[..., k, 0, :, :] - moved[..., k, 1, :, :]
        if pair.length > 0:
            far = np.linalg.norm(apart, axis=-1, keepdims=True)
            along = apart / np.maximum(far, LEAST_DIVISOR)
            apart, rate = far - pair.length / linkage.size, along[..., None, :] @ rate
        missed.append(apart)
        rows.append(rate)
    return np.concatenate(missed, axis=-1), np.concatenate(rows, axis=-2)


def _gaps(linkage: Linkage, T: Floats, motions: Floats, screws: Floats) -> tuple[Floats, Floats]:
    batch, F = T.shape[:-3], linkage.coordinates
    closing = list(linkage.closing)
    a, b = linkage.ends[closing].T
    G = T[..., a, :, :] @ motions[..., closing, :, :] @ pose.inverse(T[..., b, :, :])
    hat = _without_units(linkage)
    gap = np.einsum("ij,...lj->...li", hat, pose.log(G)) if closing else np.zeros((*batch, 0, 6))
    own = reduced_screws(linkage, screws)
    to_end = linkage.paths[b][:, linkage.joint_of]
    to_start = linkage.paths[a][:, linkage.joint_of] + (np.array(closing)[:, None] == linkage.joint_of)
    over = hat @ pose.adjoint(G) @ np.linalg.inv(hat) if closing else np.zeros((*batch, 0, 6, 6))
    rows = to_start[:, None, :] * own[..., None, :, :]
    rows = rows - over @ (to_end[:, None, :] * own[..., None, :, :])
    return gap.reshape(*batch, 6 * len(closing)), rows.reshape(*batch, 6 * len(closing), F)


def _without_units(linkage: Linkage) -> Floats:
    """(6, 6) from twists of the drawing to twists about the middle with lengths over the size."""
    D = np.eye(6)
    x, y, z = linkage.middle
    D[3:, :3] = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    D[3:] /= linkage.size
    return D


def reduced_screws(linkage: Linkage, screws: Floats | None = None) -> Floats:
    """(*batch, 6, F) screws free of units, about the middle of the linkage; as drawn if None."""
    given = linkage.screws if screws is None else screws
    return _without_units(linkage) @ given * units(linkage)


@on_linkage
def loop_matrix(linkage: Linkage, theta: ArrayLike | None = None) -> Floats:
    """(*batch, 6 L, F) what the loops ask: loop_matrix @ (rates of coordinates over `units`) = 0."""
    return loop_state(linkage, theta).matrix


def largest_gap(linkage: Linkage, theta: ArrayLike | None = None) -> Floats:
    """(*batch,) largest gap of a loop: angle, or length over the size of the linkage."""
    gap = np.abs(loop_state(linkage, theta).gap)
    return gap.max(axis=-1, initial=0.0)


def loop_equations(linkage: Linkage) -> Equations:
    """Gaps and their rates at coordinates over `units` (k, F), each loop over its own size, for `solvers`.

    Loops of the plane have three rows: the others hold by themselves.
    """
    own, scale = _over_own_sizes(linkage)[0], units(linkage)
    loops, rows = len(own), 6 * len(own)
    of_loops = 6 * np.arange(loops)[:, None] + (IN_PLANE if linkage.planar else np.arange(6))
    kept = np.concatenate([of_loops.ravel(), np.arange(rows, linkage.conditions)])

    def equations(u: Floats) -> tuple[Floats, Floats]:
        state = loop_state(linkage, u * scale)
        gap, matrix = state.gap.copy(), state.matrix.copy()
        for part in (gap[..., None], matrix):
            block = part[:, :rows].reshape(len(u), loops, 6, part.shape[2])
            part[:, :rows] = (own @ block).reshape(len(u), rows, part.shape[2])
        return gap[:, kept], matrix[:, kept]

    return equations


def misfit(linkage: Linkage, theta: Floats) -> Floats:
    """(k,) largest gap of a loop at its own joints, angles times its size [m], at coordinates (k, F)."""
    own, sizes = _over_own_sizes(linkage)
    gap = loop_state(linkage, theta).gap[:, : 6 * len(own)].reshape(len(theta), len(own), 6, 1)
    return (np.abs(own @ gap)[..., 0].max(axis=-1) * sizes).max(axis=1, initial=0.0)


@lru_cache(maxsize=64)
def _over_own_sizes(linkage: Linkage) -> tuple[Floats, Floats]:
    """(L, 6, 6) from twists over the size of the linkage to twists about the middle of each loop over its own size.

    And these sizes (L,) [m].
    """
    found, sizes = np.tile(np.eye(6), (linkage.loops, 1, 1)), np.full(linkage.loops, linkage.size)
    for k, cycle in enumerate(linkage.cycles):
        inside = [linkage.joints[j] for j in np.flatnonzero(cycle) if linkage.joints[j].kind is not Kind.PRISMATIC]
        if not inside:
            continue
        places = np.array([each.point for each in inside])
        size = float(np.ptp(places, axis=0).max()) / 2
        sizes[k] = size if size > SMALLEST_LOOP * linkage.size else linkage.size
        found[k, 3:, :3] = -rotation.hat((places.mean(axis=0) - linkage.middle) / linkage.size)
        found[k, 3:] *= linkage.size / sizes[k]
    return frozen(found), frozen(sizes)


class ClosureStatus(Status):
    """Whether coordinates that close all loops were found."""

    CLOSED = ("mobility.closed", True)
    NOT_FOUND = ("mobility.not_closed", False)


@dataclass(frozen=True, eq=False, repr=False)
class LoopClosure(Answer, data="theta gap closed"):
    """Coordinates that close all loops, if they were found; of a batch, row by row.

    Attributes:
        status: closed if every row is.
        theta: (*batch, F) [rad | m]; of rows that did not close the best that was met.
        gap: (*batch,) largest gap that is left.
        closed: (*batch,) which rows close.
    """

    status: ClosureStatus
    theta: Floats
    gap: Floats
    closed: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

    def explain(self, language: str | None = None) -> str:
        """The finding in one sentence with the gap."""
        return self.status.sentence(language, gap=float(np.max(self.gap, initial=0.0)))


@on_linkage
def close_loops_near(
    linkage: Linkage, theta: ArrayLike | None = None, *, fixed: Iterable[str] = (), steps: int = MOST_STEPS
) -> LoopClosure:
    """Coordinates near given ones that close all loops: Newton's method with least-norm steps, row by row.

    A search: rows that did not close prove nothing.

    Args:
        linkage: as drawn.
        theta: (*batch, F) where it starts; as drawn if None.
        fixed: names of joints whose coordinates stay.
        steps: at most.
    """
    start = coordinates(linkage, theta)
    moving = np.ones(linkage.coordinates)
    moving[linkage.columns_of(fixed)] = 0.0
    found, gap = _newton(linkage, start.reshape(-1, linkage.coordinates).copy(), moving, steps)
    return _closure(found.reshape(start.shape), gap.reshape(start.shape[:-1]))


def _closure(theta: Floats, gap: Floats) -> LoopClosure:
    closed = np.asarray(gap <= CLOSED)
    status = ClosureStatus.CLOSED if bool(closed.all()) else ClosureStatus.NOT_FOUND
    return LoopClosure(status, theta, gap, closed)


def _newton(
    linkage: Linkage, theta: Floats, moving: Floats, steps: int, back: Floats | None = None
) -> tuple[Floats, Floats]:
    """Damped where a full step would be long; keeps the best of each row.

    1. The gap at each row. A row ends that is closed, or whose gap is rounding: below what counts as closed, and hardly
       better than before.
    2. A step with slopes of before that made the gap wider is taken back.
    3. Slopes are taken anew where the last step left too much of the gap.
    4. The step; one with new slopes that is too short to close anything is the last of its row.

    Args:
        linkage: as drawn.
        theta: (rows, F) starts, spent.
        moving: (F,) zero for coordinates that stay.
        steps: at most.
        back: (rows, F, 6 L + K) pseudoinverses to begin with, spent; those at the starts if None.
    """
    scale = units(linkage)
    best, least = theta.copy(), np.full(len(theta), np.inf)
    live, old = np.arange(len(theta)), np.full(len(theta), back is not None)
    if back is None:
        back = np.zeros((len(theta), linkage.coordinates, linkage.conditions))
    known = old.copy()
    for _ in range(steps + 1):
        if not len(live):
            break
        state = loop_state(linkage, theta[live])  # 1
        gap, before = np.abs(state.gap).max(axis=-1, initial=0.0), least[live]
        better = gap < before
        least[live[better]], best[live[better]] = gap[better], theta[live[better]]
        going = (gap > CLOSED / 100) & ~((before <= CLOSED) & (gap > before / 2))
        wider = going & ~(gap < before) & old[live]  # 2
        theta[live[wider]], known[live[wider]], old[live[wider]] = best[live[wider]], False, False
        step = going & ~wider
        kept = known[live] & (gap <= CONTRACTED * before)  # 3
        renewed = live[step & ~kept]
        back[renewed] = decompositions.damped_inverse(state.matrix[step & ~kept] * moving, RANK)
        known[renewed], old[renewed], old[live[step & kept]] = True, False, True
        move = -np.einsum("...ij,...j->...i", back[live[step]], state.gap[step]) * moving  # 4
        length = np.abs(move).max(axis=-1, keepdims=True, initial=0.0)
        move = move * np.minimum(1.0, LONGEST_STEP / np.maximum(length, LONGEST_STEP))
        theta[live[step]] += move * scale
        going[step] &= (length[:, 0] > CLOSED / 100) | old[live[step]]
        live = live[going]
    return best, least
