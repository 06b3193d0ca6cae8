"""The answer of a synthesis: all candidates, good ones first, how they were found, and why there are none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats
from mafsil.messages import say
from mafsil.messages.tables import number, on_screen, table
from mafsil.mobility.four_bar import FourBar
from mafsil.mobility.synthesis.assessment import NO_LIMITS, Assessment, LinkageLimits
from mafsil.mobility.synthesis.candidate import Candidate, CandidateStatus, candidate
from mafsil.mobility.synthesis.dyads import Dyad
from mafsil.mobility.synthesis.fitting import Positions
from mafsil.mobility.synthesis.five_poses import BurmesterCurves
from mafsil.mobility.tolerances import BULKY, EXACT, MOST_CANDIDATES


class SynthesisStatus(Status):
    """Whether linkages meet the task; true if one does without a defect."""

    FREE = ("synthesis.free", True)
    DEFECTIVE = ("synthesis.defective", False)
    NONE = ("synthesis.none", False)
    TRANSLATION = ("synthesis.translation", False)
    ONE_POLE = ("synthesis.one_pole", False)
    INFINITE = ("synthesis.infinite", False)
    NOT_FOUND = ("synthesis.not_found", False)
    FAR = ("synthesis.far", False)
    LIMITED = ("synthesis.limited", False)
    NO_LINKAGE = ("synthesis.no_linkage", False)


@dataclass(frozen=True, eq=False)
class Ranking:
    """Candidates of a synthesis, counted and in order.

    Attributes:
        candidates: the best ones, good ones first: mildest defects, then the better transmission angle at worst.
        count: of all that were assessed.
        free, circuit, branch, order: how many have no defect, and how many have each.
        beyond: how many more were left out for their pivots, their transmission angle, their length: the first limit
            that they break.
    """

    candidates: tuple[Candidate, ...]
    count: int
    free: int
    circuit: int
    branch: int
    order: int
    beyond: tuple[int, int, int] = (0, 0, 0)


def rank_candidates(
    batches: Sequence[Positions], size: float, *, either_side: bool, limits: LinkageLimits = NO_LIMITS
) -> Ranking:
    """Candidates of batches of linkages.

    Args:
        batches: of four-bars and slider-cranks.
        size: of the task [m].
        limits: what they must keep to.
        either_side: whether a four-bar may be driven by either of its two side links: the better one becomes its crank.
    """
    keys: list[Floats] = []
    parts: list[tuple[Positions, Assessment]] = []
    beyond = np.zeros(3, dtype=int)
    for batch in batches:
        positions = batch.built(size)
        if not len(positions):
            continue
        found = positions.assess()
        # A candidate meets the task itself: its links keep their lengths from position to position.
        kept = np.asarray(found.residual <= EXACT * found.lengths.max(axis=1), dtype=np.bool_)
        if not kept.all():
            positions = positions.chosen(kept)
            if not len(positions):
                continue
            found = positions.assess()
        if either_side and not positions.slider:
            positions, found = _better_sides(positions, found)
        broken = limits.violations(positions.fixed_pivots, found.worst, found.lengths.max(axis=1))
        beyond += np.bincount(broken.argmax(axis=0)[broken.any(axis=0)], minlength=3)
        positions = positions.chosen(np.asarray(~broken.any(axis=0), dtype=np.bool_))
        if not len(positions):
            continue
        found = positions.assess() if broken.any() else found
        bulky = found.lengths.max(axis=1) > BULKY * size
        place = np.stack([np.full(len(positions), len(parts)), np.arange(len(positions))], axis=1)
        quality = -found.worst if positions.misses is None else positions.misses
        keys.append(np.column_stack([found.severity.astype(float), bulky.astype(float), quality, place.astype(float)]))
        parts.append((positions, found))
    rows = np.concatenate(keys) if keys else np.zeros((0, 5))
    rows = rows[np.lexsort(rows.T[::-1])]
    counts = [sum(int(np.sum(getattr(found, name))) for _, found in parts) for name in (
        "circuit_defect", "branch_defect", "order_defect")]  # fmt: skip
    best = tuple(candidate(*parts[int(part)], int(k)) for part, k in rows[:MOST_CANDIDATES, 3:])
    free, left_out = int((rows[:, 0] == 0).sum()), (int(beyond[0]), int(beyond[1]), int(beyond[2]))
    return Ranking(best, len(rows), free, counts[0], counts[1], counts[2], left_out)


def _better_sides(positions: Positions, found: Assessment) -> tuple[Positions, Assessment]:
    """Each four-bar driven by the side link with milder defects, then with the better transmission angle."""
    other = positions.driven_from_the_other_side()
    seen = other.assess()
    better: Booleans = np.asarray(
        (seen.severity < found.severity) | ((seen.severity == found.severity) & (seen.worst > found.worst)),
        dtype=np.bool_,
    )
    rows = better[:, None]
    mixed = Positions(
        np.where(better, other.A, positions.A),
        np.where(rows, other.B, positions.B),
        np.where(rows, other.C, positions.C),
        np.where(better, other.D, positions.D),
        np.where(rows, other.frame, positions.frame),
    )
    return mixed, mixed.assess()


@dataclass(frozen=True, eq=False, repr=False)
class Synthesis(
    Answer,
    entries="candidates",
    data="aim count=ranking.count free=ranking.free circuit_defects=ranking.circuit "
    "branch_defects=ranking.branch order_defects=ranking.order task candidates dyads",
):
    """Linkages for a task; true if one is free of defects, iterable over the candidates, good ones first.

    Attributes:
        status: how it ended.
        aim: motion, path or function.
        ranking: the candidates and how many of all have which defect.
        task: what was asked for: poses (N, 3), points (N, 2) or with timing (N, 3), angles (N, 2).
        dyads: all dyads of five poses, or those sampled of a family.
        curves: Burmester's curves of four poses.
        method: key of the sentence that says how the candidates were found.
        details: numbers of the sentences.
    """

    status: SynthesisStatus
    aim: Literal["motion", "path", "function"]
    ranking: Ranking
    task: Floats
    dyads: tuple[Dyad, ...]
    curves: BurmesterCurves | None
    method: str
    details: dict[str, Any]

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """Good ones first."""
        return self.ranking.candidates

    @property
    def best(self) -> Candidate | None:
        """The first candidate, or None."""
        return self.candidates[0] if self.candidates else None

    def __getitem__(self, index: int) -> Candidate:
        return self.candidates[index]

    def __repr__(self) -> str:
        head, rows = rows_of(self.candidates)
        lines = self.explain().split("\n")[:2]
        return on_screen("\n".join(lines)) + ("\n" + "\n".join(table(head, rows[:18])) if rows else "")

    def explain(self, language: str | None = None) -> str:
        """The finding, how it was found, and the best candidate with its numbers."""
        ranking = self.ranking
        angle = float(np.degrees(self.candidates[0].worst)) if self.candidates else 0.0
        details = {
            "count": ranking.count, "free": ranking.free, "circuit": ranking.circuit, "branch": ranking.branch,
            "order": ranking.order, "angle": angle, **limit_details(ranking.beyond), **self.details,
        }  # fmt: skip
        lines = [self.status.sentence(language, **details)]
        if self.method:
            lines.append(say(f"synthesis.{self.method}", language=language, **details))
        if sum(ranking.beyond) and ranking.count:
            lines.append(say("synthesis.beyond_limits", language=language, **details))
        if self.candidates:
            lines.append(self.candidates[0].explain(language))
        return "\n".join(lines)


def limit_details(beyond: tuple[int, int, int]) -> dict[str, int]:
    """Numbers of linkages beyond limits, for sentences."""
    pivots, transmission, length = beyond
    return {"beyond": sum(beyond), "by_pivots": pivots, "by_transmission": transmission, "by_length": length}


def rows_of(candidates: Sequence[Candidate]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Head and rows of a table of candidates."""
    names = ("number", "crank", "coupler", "rocker", "ground", "worst", "defects")
    rows = [(str(k + 1), *_row(one)) for k, one in enumerate(candidates)]
    return tuple(say(f"synthesis.head_{name}") for name in names), rows


def _row(one: Candidate) -> tuple[str, ...]:
    """Lengths, transmission angle and defects of a candidate, for a table."""
    if isinstance(one.linkage, FourBar):
        lengths = [number(length) for length in one.linkage.lengths.tolist()]
    else:
        lengths = [number(one.linkage.crank), number(one.linkage.rod), "-", "-"]
    names = ", ".join(say(f"synthesis.short_{each.name.lower()}") for each in one.defects or (CandidateStatus.FREE,))
    return (*lengths, number(float(np.degrees(one.worst))), names)


NOTHING = Ranking((), 0, 0, 0, 0, 0)


def outcome(ranking: Ranking, *, sampled: bool = False) -> SynthesisStatus:
    """The status that a ranking gives; an empty one proves that there is none, unless its linkages were sampled."""
    if not ranking.count and sum(ranking.beyond):
        return SynthesisStatus.LIMITED
    if not ranking.count:
        return SynthesisStatus.NOT_FOUND if sampled else SynthesisStatus.NONE
    return SynthesisStatus.FREE if ranking.free else SynthesisStatus.DEFECTIVE
