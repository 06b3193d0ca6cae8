"""Whether the links of a linkage can meet in all its joints: found, proven impossible by lengths, or not found.

Ways in which a linkage can be put together while some of its joints are given: all that a search finds.

A linkage that is drawn apart, closed near where it is drawn; or how near it comes to closing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, require_kind, whole
from mafsil.errors import InputError, ModelError
from mafsil.geometry import pose, rotation
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.mobility.linkages.drawing import draw_at
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.linkage_joint import Kind
from mafsil.mobility.linkages.loop_closure import are_lengths, body_poses, close_loops_near, loop_state, units
from mafsil.mobility.tolerances import TYPED
from mafsil.solvers import levenberg_marquardt

TRIES, FARTHEST = 48, np.pi
"""Further starts, and how far from the drawing the last of them are [rad, sizes]."""
SAME = 1e-6
"""Bodies that stand this near to each other (angles, lengths over the size) stand alike: ten digits after Newton."""
SHARED_POINT = (Kind.REVOLUTE, Kind.UNIVERSAL, Kind.SPHERICAL)
"""Kinds whose place is a point of both bodies for all coordinates."""


class ExistenceStatus(Status):
    """Whether the linkage can be put together."""

    EXISTS = ("mobility.exists", True)
    IMPOSSIBLE = ("mobility.exists_not", False)
    NOT_FOUND = ("mobility.exists_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class Existence(Answer, data="theta gap loop excess joint distance angle"):
    """Whether all loops can be closed at once; true if such coordinates were found.

    Attributes:
        status: exists; impossible, proven by the lengths of a loop; not found, which proves nothing.
        theta: (F,) coordinates that close all loops [rad | m], or None.
        gap: smallest gap that was met (angle, length over the size).
        loop: joints of the loop that cannot close.
        excess: by how much its longest side is longer than the others together [m]: the distance to feasibility.
        joint: that gapes most where all together gape least, if no way was found, by `distance` [m] and `angle` [rad].
    """

    status: ExistenceStatus
    theta: Floats | None
    gap: float
    loop: tuple[str, ...] = ()
    excess: float = 0.0
    joint: str = ""
    distance: float = 0.0
    angle: float = 0.0

    def explain(self, language: str | None = None) -> str:
        """The finding in one sentence with its number."""
        return self.status.sentence(
            language, gap=self.gap, loop=", ".join(self.loop), excess=self.excess, joint=self.joint,
            distance=self.distance, angle=self.angle,
        )  # fmt: skip


@on_linkage
def can_assemble(linkage: Linkage, *, starts: int = 256, seed: int = 0) -> Existence:
    """Whether a linkage can be assembled.

    1. Newton's method from the drawing.
    2. A loop of hinges, universal and spherical joints is a polygon of fixed sides: if one is longer than the others
       together, it cannot close: proven.
    3. Newton's method from many random starts.

    Args:
        linkage: drawn apart (`child_at`) or together.
        starts: of the search.
        seed: of the starts.
    """
    near = close_loops_near(linkage)  # 1
    if near:
        return Existence(ExistenceStatus.EXISTS, near.theta, float(near.gap))
    for loop in range(linkage.loops):  # 2
        sides, names = loop_sides(linkage, loop)
        excess = 2 * max(sides, default=0.0) - sum(sides)
        if excess > TYPED * linkage.size:
            return Existence(ExistenceStatus.IMPOSSIBLE, None, float(near.gap), names, excess)
    found = assembly_modes(linkage, starts=starts, seed=seed)  # 3
    gap = min(found.least_gap, float(near.gap))
    if found:
        best = close_loops_near(linkage, found.theta[0])
        return Existence(ExistenceStatus.EXISTS, best.theta, float(best.gap))
    joint, distance, angle = least_gap(linkage)
    return Existence(
        ExistenceStatus.NOT_FOUND, None, gap, joint=joint, distance=distance, angle=angle
    )  # fmt: skip


def loop_sides(linkage: Linkage, loop: int) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Sides [m] of the polygon of an independent loop, and its joints; no sides if a joint has no point of both bodies.

    Args:
        linkage: as drawn.
        loop: its index.
    """
    inside = np.flatnonzero(linkage.cycles[loop])
    names = tuple(linkage.joints[k].name for k in inside)
    if any(linkage.joints[k].kind not in SHARED_POINT for k in inside):
        return (), names
    on_body: dict[str, list[Floats]] = {}
    for k in inside:
        each = linkage.joints[k]
        on_body.setdefault(each.parent, []).append(each.point)
        on_body.setdefault(each.child, []).append(each.point if each.child_point is None else each.child_point)
    return tuple(float(np.linalg.norm(ends[0] - ends[1])) for ends in on_body.values()), names


@on_linkage
def close_drawing(linkage: Linkage) -> Linkage:
    """A linkage that is drawn apart, drawn where its loops close.

    Raises:
        ModelError: it cannot be put together, or no way was found; the sentence says which, and how far it is from it.
    """
    found = can_assemble(linkage)
    if found.theta is None:
        raise ModelError("mobility.not_assembled", name=linkage.name or "-", reason=_Reason(found))
    return draw_at(linkage, found.theta)


@dataclass(frozen=True)
class _Reason:
    """The sentence of an answer, in the language in which it is wanted."""

    found: Existence

    def spoken(self, language: str | None = None) -> str:
        return self.found.explain(language)


class AssemblyStatus(Status):
    """Whether ways of assembly were found; a search never says that there is none."""

    FOUND = ("mobility.modes_found", True)
    NOT_FOUND = ("mobility.modes_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class AssemblyModes(Answer, data="theta hits starts least_gap", entries="theta"):
    """Ways of assembly that were found; true if there are any, iterable over their coordinates.

    Attributes:
        theta: (k, F) coordinates [rad | m], angles in (-pi, pi].
        hits: (k,) how many starts led to each; a way that only one start found says that there may be more.
        starts: number of starts.
        least_gap: smallest gap that was met: the distance to assembly if none was found (angle, length over size).
    """

    theta: Floats
    hits: tuple[int, ...]
    starts: int
    least_gap: float

    @property
    def status(self) -> AssemblyStatus:
        """Found or not found."""
        return AssemblyStatus.FOUND if len(self.theta) else AssemblyStatus.NOT_FOUND

    def __bool__(self) -> bool:
        return len(self.theta) > 0

    def _table(self) -> list[str]:
        head = (say("mobility.mode_head"), say("mobility.hits_head"), say("mobility.theta_head"))
        rows = [
            (str(k + 1), str(hits), " ".join(map(number, theta.tolist()))[:70])
            for k, (hits, theta) in enumerate(zip(self.hits, self.theta, strict=True))
        ]
        return table(head, rows) if rows else []

    def explain(self, language: str | None = None) -> str:
        """How many were found by how many starts, or how near the search came."""
        return self.status.sentence(
            language, count=len(self.theta), starts=self.starts, gap=self.least_gap, fewest=min(self.hits, default=0)
        )


@on_linkage
def assembly_modes(
    linkage: Linkage, given: Mapping[str, float] | None = None, *, starts: int = 256, seed: int = 0
) -> AssemblyModes:
    """Different ways to close all loops while some joints have given coordinates, from many random starts.

    With all freedoms given the ways are isolated, and those with a basin of attraction are found soon; with freedoms
    left over every start ends elsewhere.

    Args:
        linkage: as drawn.
        given: coordinate by name of joints of one freedom, counted from the drawing [rad | m].
        starts: random starts, at once.
        seed: of the starts.

    Raises:
        InputError: a joint of several freedoms is given.
    """
    if given is not None:
        require_kind("given", given, "dictionary of coordinates by name", "items")
    count, fixed = whole("starts", starts, 1, 100_000), dict(given or {})
    spread = np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, linkage.coordinates))
    start = spread * np.where(units(linkage) == 1.0, 1.0, linkage.size / np.pi)
    start[0] = 0.0
    for name, value in fixed.items():
        columns = linkage.columns_of([name])
        if len(columns) != 1:
            raise InputError("mobility.one_freedom", joint=name, freedoms=len(columns))
        start[:, columns[0]] = value
    found = close_loops_near(linkage, start, fixed=fixed)
    theta = found.theta[found.closed]
    poses = body_poses(linkage, theta)
    poses[..., :3, 3] /= linkage.size
    kept: list[int] = []
    hits: list[int] = []
    for k in range(len(theta)):
        same = [m for m, other in enumerate(kept) if float(np.abs(poses[k] - poses[other]).max()) < SAME]
        if same:
            hits[same[0]] += 1
        else:
            kept.append(k)
            hits.append(1)
    angles = np.abs(linkage.screws[:3]).max(axis=0, initial=0.0) > 0
    modes = np.where(angles, np.angle(np.exp(1j * theta[kept])), theta[kept])
    return AssemblyModes(modes, tuple(hits), count, float(np.min(found.gap)))


def closed_beside_drawing(linkage: Linkage, seed: int = 0) -> Floats | None:
    """Coordinates (F,) that close all loops, the nearest that a search finds; None if it finds none.

    1. Newton's method from where the linkage is drawn: links on one line keep it there, though they could meet.
    2. Then from starts around, ever farther away; of those that close, the one with the least coordinates.

    Args:
        linkage: as drawn.
        seed: of the starts.
    """
    found = close_loops_near(linkage)
    if found:
        return found.theta
    reach = np.linspace(0.0, FARTHEST, TRIES + 1)[1:, None]
    starts = reach * np.random.default_rng(seed).uniform(-1.0, 1.0, (TRIES, linkage.coordinates))
    starts = np.where(are_lengths(linkage), starts / FARTHEST, starts) * units(linkage)
    around = close_loops_near(linkage, starts)
    if not around.closed.any():
        return None
    closed = around.theta[around.closed]
    return closed[int(np.abs(closed / units(linkage)).max(axis=1).argmin())]


def least_gap(linkage: Linkage) -> tuple[str, float, float]:
    """The joint that gapes most where all together gape least, and by how much [m], [rad]; found by least squares.

    Gaps are taken at the joints that close the loops, where an angle is no distance: squares of angles, and of lengths
    over the size.

    Args:
        linkage: as drawn, with loops that do not close.
    """
    scale = units(linkage)

    def gaps(u: Floats) -> tuple[Floats, Floats]:
        return _at_joints(linkage, u * scale)

    rng = np.random.default_rng(0)
    starts = [np.zeros(linkage.coordinates), *rng.uniform(-1.0, 1.0, (3, linkage.coordinates))]
    best = min((levenberg_marquardt(gaps, start) for start in starts), key=lambda found: found.residual)
    twists = gaps(best.value)[0][: 6 * linkage.loops].reshape(-1, 6) * np.repeat([1.0, linkage.size], 3)
    worst = int(np.abs(twists).max(axis=1).argmax())
    omega, v = np.linalg.norm(twists[worst].reshape(2, 3), axis=1).tolist()
    return linkage.joints[linkage.closing[worst]].name, v, omega


def _at_joints(linkage: Linkage, theta: Floats) -> tuple[Floats, Floats]:
    """What loops and couplings miss (m,), and its rates (m, F), of the loops where the joints that close them stand."""
    state = loop_state(linkage, theta)
    gap, rows = state.gap.copy(), state.matrix.copy()
    for loop, index in enumerate(linkage.closing):
        here = pose.act(state.poses[linkage.ends[index, 0]], linkage.joints[index].point)
        lever = -rotation.hat((here - linkage.middle) / linkage.size)
        turns, shifts = slice(6 * loop, 6 * loop + 3), slice(6 * loop + 3, 6 * loop + 6)
        gap[shifts] += lever @ gap[turns]
        rows[shifts] += lever @ rows[turns]
    return gap, rows
