"""Defects of linkages that a crank and a row of dyads make: six-bars and spherical four-bars, by their configurations.

A dyad (two links that meet in a hinge) closes in two modes where the cosine of its transmission angle is within -1 and
1, so that all configurations are a grid of crank angles times modes. Neighbours on the grid are joined; where a dyad
stops to close, its two modes are joined: a dead point. Positions in one component without these joints are on one
branch, with them on one circuit. Minima of the margin between grid angles are taken from parabolas.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np

from mafsil.answer import Answer
from mafsil.arrays import Booleans, Floats, Integers
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.tables import number, on_screen, table
from mafsil.mobility.synthesis.answers import SynthesisStatus, limit_details
from mafsil.mobility.synthesis.assessment import LinkageLimits
from mafsil.mobility.synthesis.candidate import CandidateStatus, position_numbers
from mafsil.mobility.tolerances import DEAD, EXACT, GRID, MOST_CANDIDATES, MOST_JUDGED

sparse, csgraph = lazily("scipy.sparse"), lazily("scipy.sparse.csgraph")


class CrankChain(Protocol):
    """A crank and the dyads that follow it."""

    @property
    def kind(self) -> str:
        """Key of its sentence."""
        ...

    @property
    def dyads(self) -> int:
        """Their number."""
        ...

    @property
    def pivots(self) -> Floats:
        """(m, d) fixed pivots [m], or unit vectors along fixed axes."""
        ...

    @property
    def lengths(self) -> dict[str, float]:
        """Of the links by the names of their pins [m | rad]."""
        ...

    def cosines(self, theta: Floats, modes: Sequence[int]) -> Floats:
        """(k, dyads) cosines of the transmission angles at crank angles (k,); beyond -1 and 1 it does not close."""
        ...

    def output_angle(self, theta: Floats, modes: Sequence[int]) -> Floats:
        """(k,) angles of the output link [rad]."""
        ...


@dataclass(frozen=True, eq=False)
class Placed:
    """A linkage in N positions.

    Attributes:
        chain: crank and dyads.
        theta: (N,) angles of the crank [rad].
        modes: (N, dyads) +1 or -1.
        residual: how far the positions are missed [m | rad].
    """

    chain: CrankChain
    theta: Floats
    modes: Integers
    residual: float


@dataclass(frozen=True, eq=False, repr=False)
class ChainCandidate(Answer, data="linkage theta modes circuits defects transmission worst residual"):
    """A linkage with its defects; true if it has none.

    Attributes:
        linkage: a `SixBar` or a `SphericalFourBar`.
        theta: (N,) angles of the crank at the positions [rad].
        modes: (N, dyads) +1 or -1 of each dyad there.
        circuits: (N,) positions with the same number lie on one circuit.
        defects: all that were found.
        transmission: (N,) least transmission angle of the dyads at the positions [rad].
        worst: the least one on the way between them; 0 beyond a dead point [rad].
        residual: how far the positions are missed, closed by the crank and its modes alone [m | rad].
    """

    linkage: CrankChain
    theta: Floats
    modes: Integers
    circuits: Integers
    defects: tuple[CandidateStatus, ...]
    transmission: Floats
    worst: float
    residual: float

    @property
    def status(self) -> CandidateStatus:
        """The first defect, or that there is none."""
        return self.defects[0] if self.defects else CandidateStatus.FREE

    def explain(self, language: str | None = None) -> str:
        """Its links, and each defect with its numbers."""
        links = ", ".join(f"{name} {number(value)}" for name, value in self.linkage.lengths.items())
        lines = [say(f"synthesis.{self.linkage.kind}", language=language, links=links)]
        same = np.asarray((self.modes == self.modes[0]).all(axis=1), dtype=np.bool_)
        details = {
            "angle": float(np.degrees(self.worst)), "least": float(np.degrees(self.transmission.min())),
            "first": position_numbers(self.circuits == self.circuits[0]),
            "others": position_numbers(self.circuits != self.circuits[0]),
            "one_side": position_numbers(same), "other_side": position_numbers(~same),
            "angles": ", ".join(f"{angle:.1f}" for angle in np.degrees(self.theta)),
        }  # fmt: skip
        return "\n".join([*lines, *(one.sentence(language, **details) for one in self.defects or (self.status,))])


@dataclass(frozen=True, eq=False, repr=False)
class ChainSynthesis(
    Answer,
    entries="candidates",
    data="aim count free circuit_defects branch_defects order_defects beyond task candidates",
):
    """Six-bars or spherical four-bars for a task; true if one is free of defects, iterable, good ones first.

    Attributes:
        status: how it ended.
        aim: motion, path or function.
        candidates: the best ones.
        assembled: linkages that meet all positions.
        beyond: how many of them break the limits of pivots, of transmission, of length.
        counts: of those judged, how many have which defects.
        task: what was asked for.
        method: key of the sentence that says how the candidates were found.
        details: numbers of the sentences.
    """

    status: SynthesisStatus
    aim: str
    candidates: tuple[ChainCandidate, ...]
    assembled: int
    beyond: tuple[int, int, int]
    counts: dict[CandidateStatus, int]
    task: Floats
    method: str
    details: dict[str, Any]

    @property
    def count(self) -> int:
        """Linkages that were judged and keep to the limits."""
        return sum(self.counts.values()) if self.counts else 0

    @property
    def free(self) -> int:
        """Without a defect."""
        return self.counts.get(CandidateStatus.FREE, 0)

    @property
    def circuit_defects(self) -> int:
        """With positions on several circuits."""
        return self.counts.get(CandidateStatus.CIRCUIT, 0)

    @property
    def branch_defects(self) -> int:
        """With a dead point between positions of one circuit."""
        return self.counts.get(CandidateStatus.BRANCH, 0)

    @property
    def order_defects(self) -> int:
        """With positions in another order, and no worse defect."""
        return self.counts.get(CandidateStatus.ORDER, 0)

    @property
    def best(self) -> ChainCandidate | None:
        """The first candidate, or None."""
        return self.candidates[0] if self.candidates else None

    def __getitem__(self, index: int) -> ChainCandidate:
        return self.candidates[index]

    def __repr__(self) -> str:
        lines = on_screen("\n".join(self.explain().split("\n")[:2]))
        return "\n".join([lines, *table(*self.rows())]) if self.candidates else lines

    def rows(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Head and rows of the table of candidates."""
        names = tuple(self.candidates[0].linkage.lengths) if self.candidates else ()
        ends = tuple(say(f"synthesis.head_{name}") for name in ("worst", "defects"))
        rows: list[tuple[str, ...]] = []
        for k, one in enumerate(self.candidates):
            shown = [number(one.linkage.lengths.get(name, np.nan)) for name in names]
            defects = ", ".join(say(f"synthesis.short_{each.name.lower()}") for each in one.defects or (one.status,))
            rows.append((str(k + 1), *shown, number(float(np.degrees(one.worst))), defects))
        return (say("synthesis.head_number"), *names, *ends), rows

    def explain(self, language: str | None = None) -> str:
        """The finding, how it was found, and the best candidate with its numbers."""
        details = {
            "count": self.count, "free": self.free, "circuit": self.circuit_defects, "branch": self.branch_defects,
            "order": self.order_defects, "assembled": self.assembled, **limit_details(self.beyond), **self.details,
            "angle": float(np.degrees(self.candidates[0].worst)) if self.candidates else 0.0,
        }  # fmt: skip
        lines = [self.status.sentence(language, **details)]
        if self.method:
            lines.append(say(f"synthesis.{self.method}", language=language, **details))
        if sum(self.beyond) and self.count:
            lines.append(say("synthesis.beyond_limits", language=language, **details))
        return "\n".join(lines + ([self.candidates[0].explain(language)] if self.candidates else []))


def rank_chains(
    placed: Sequence[Sequence[Placed]],
    limits: LinkageLimits,
    aim: str,
    task: Floats,
    method: str,
    *,
    complete: bool,
    details: dict[str, Any] | None = None,
) -> ChainSynthesis:
    """Judge linkages and put the good ones first.

    Args:
        placed: linkages, of each the choices of its crank, of which the best is kept.
        limits: what they must keep to.
        aim: motion, path or function.
        task: what was asked for.
        method: key of the sentence about the search.
        complete: whether these are all linkages there are.
        details: more numbers for the sentences.
    """
    exact = [one for one in placed if one and one[0].residual <= EXACT * max(one[0].chain.lengths.values())]
    transmission = [float(_transmission(one[0]).min()) for one in exact]
    order: list[int] = np.argsort(-np.array(transmission), kind="stable")[:MOST_JUDGED].tolist()
    found, beyond = list[ChainCandidate](), np.zeros(3, dtype=int)
    for k in order:
        one = min(map(judge_positions, exact[k]), key=_badness)
        longest = np.array([max(one.linkage.lengths.values())])
        broken = limits.violations(_either_sense(one.linkage.pivots, limits), np.array([one.worst]), longest)[:, 0]
        if broken.any():
            beyond[int(broken.argmax())] += 1
        else:
            found.append(one)
    found.sort(key=_badness)
    counts = {status: sum(one.status is status for one in found) for status in CandidateStatus}
    none = SynthesisStatus.NO_LINKAGE if complete else SynthesisStatus.NOT_FOUND
    status = SynthesisStatus.LIMITED if beyond.any() else none
    if found:
        status = SynthesisStatus.FREE if counts[CandidateStatus.FREE] else SynthesisStatus.DEFECTIVE
    left_out = int(beyond[0]), int(beyond[1]), int(beyond[2])
    more = {"judged": len(order), **(details or {})}
    return ChainSynthesis(
        status, aim, tuple(found[:MOST_CANDIDATES]), len(exact), left_out, counts, task, method, more
    )  # fmt: skip


def _badness(one: ChainCandidate) -> tuple[int, float]:
    """Order of candidates: milder defects, then the better transmission angle."""
    weight = {CandidateStatus.CIRCUIT: 4, CandidateStatus.BRANCH: 2, CandidateStatus.ORDER: 1}
    return sum(weight[each] for each in one.defects), -one.worst


def _either_sense(pivots: Floats, limits: LinkageLimits) -> list[Floats]:
    """Fixed pivots as batches of one; of axes the sense that lies in the box, if one does."""
    if pivots.shape[1] < 3 or limits.pivots is None:
        return [each[None] for each in pivots]
    return [(each if limits.contains(each) else -each)[None] for each in pivots]


def _transmission(placed: Placed) -> Floats:
    """(N,) least transmission angle of the dyads at positions [rad]."""
    theta, modes = placed.theta, placed.modes
    cosines = np.stack([placed.chain.cosines(theta[k : k + 1], modes[k].tolist())[0] for k in range(len(theta))])
    return np.arccos(np.clip(np.abs(cosines), 0.0, 1.0)).min(axis=1)


def judge_positions(placed: Placed) -> ChainCandidate:
    """Circuit, branch and order of the positions of a linkage, and its least transmission angle on the way."""
    chain, theta, modes = placed.chain, placed.theta, placed.modes
    wound = np.mod(theta, 2 * np.pi)
    angles = np.unique(np.concatenate([np.linspace(0, 2 * np.pi, GRID, endpoint=False), wound]))
    choices: list[tuple[int, ...]] = list(product((1, -1), repeat=chain.dyads))
    cosines = np.stack([chain.cosines(angles, each) for each in choices])
    inside = np.abs(cosines) <= 1.0 + DEAD
    at = np.searchsorted(angles, wound)
    rows = np.array([choices.index(tuple(each)) for each in modes.tolist()])
    # A position at a dead point may be off the grid of what closes by rounding: it closes.
    inside[rows, at] = True
    closes = np.asarray(inside.all(axis=2), dtype=np.bool_)
    joined = closes & np.roll(closes, -1, axis=1) & ~_gaps(1.0 - np.abs(cosines).max(axis=2))
    steps = _steps(joined)
    branches = _components(closes.size, steps)
    circuits = _components(closes.size, np.concatenate([steps, _turns(closes, joined, inside, choices)]))
    place = rows * len(angles) + at
    transmission = _transmission(placed)
    branch, circuit = branches[place], circuits[place]
    one_circuit = bool((circuit == circuit[0]).all())
    dead = bool((np.sin(transmission) <= DEAD).any())
    one_branch = bool((branch == branch[0]).all() and not dead)
    ordered, way = _way(joined[rows[0]], at)
    least = np.arccos(np.clip(np.abs(cosines[rows[0]]).max(axis=1), 0.0, 1.0))
    worst = float(least[way].min()) if one_branch else 0.0 if one_circuit else float(transmission.min())
    checks = (
        (CandidateStatus.CIRCUIT, not one_circuit),
        (CandidateStatus.BRANCH, one_circuit and not one_branch),
        (CandidateStatus.ORDER, not ordered),
    )
    defects = tuple(status for status, defect in checks if defect)
    numbers = np.unique(circuit, return_inverse=True)[1].astype(int)
    return ChainCandidate(chain, theta, modes, numbers, defects, transmission, worst, placed.residual)


def _components(count: int, pairs: Integers) -> Integers:
    """(count,) numbers of the components that pairs (k, 2) of grid points join."""
    joined = sparse.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(csgraph.connected_components(joined, directed=False)[1], dtype=np.int64)


def _gaps(margin: Floats) -> Booleans:
    """(C, M) steps from a grid angle to the next within which a parabola through the margins (C, M) falls below 0."""
    before, after = np.roll(margin, 1, axis=1), np.roll(margin, -1, axis=1)
    bend, slope = before - 2 * margin + after, (after - before) / 2
    safe = np.where(bend > 0, bend, 1.0)
    valley = (bend > 0) & (np.abs(slope) <= bend) & (margin - slope**2 / (2 * safe) < -DEAD)
    ahead = valley & (slope <= 0)
    return np.asarray(ahead | np.roll(valley & (slope > 0), -1, axis=1), dtype=np.bool_)


def _steps(joined: Booleans) -> Integers:
    """(k, 2) pairs of grid points that follow each other."""
    index = np.arange(joined.size).reshape(joined.shape)
    return np.stack([index[joined], np.roll(index, -1, axis=1)[joined]], axis=1)


def _turns(closes: Booleans, joined: Booleans, inside: Booleans, choices: list[tuple[int, ...]]) -> Integers:
    """(k, 2) pairs of grid points beside a dead point: the modes of the first dyad that stops to close beyond it."""
    index = np.arange(closes.size).reshape(closes.shape)
    pairs = list[Integers]()
    for k, modes in enumerate(choices):
        for on, ahead in ((joined[k], -1), (np.roll(joined[k], 1), 1)):
            ends = closes[k] & ~on
            # Where the gap lies between two grid angles that both close, the last dyad is the one that may stop.
            stopped = np.where(inside[k].all(axis=1), False, True)
            beyond = np.roll(~inside[k], ahead, axis=0)
            first = np.where(np.roll(stopped, ahead), beyond.argmax(axis=1), len(modes) - 1)
            for dyad in range(len(modes)):
                other = choices.index(tuple(-m if i == dyad else m for i, m in enumerate(modes)))
                both = ends & (first == dyad) & closes[other]
                pairs.append(np.stack([index[k][both], index[other][both]], axis=1))
    return np.concatenate(pairs)


def _way(joined: Booleans, at: Integers) -> tuple[bool, Integers]:
    """Whether grid points follow each other along one row of joined steps, and all grid points on the way.

    Args:
        joined: (M,) steps of the row to the next grid angle.
        at: (N,) grid points in their order.
    """
    count = len(joined)
    if joined.all():
        forward, back = (int(np.mod(sign * np.diff(at), count).sum()) for sign in (1, -1))
        sense, length = (1, forward) if forward <= back else (-1, back)
        steps = np.arange(min(length, count - 1) + 1)
        return length < count, np.mod(at[0] + sense * steps, count)
    start = int(np.flatnonzero(~joined)[0]) + 1
    place: Integers = (at - start) % count
    steps: Integers = np.diff(place)
    way = (start + np.arange(int(place.min()), int(place.max()) + 1)) % count
    return bool((steps > 0).all() or (steps < 0).all()), way
