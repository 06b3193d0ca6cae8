"""Finite mobility: how many of the first-order motions are beginnings of real ones, and what is proven of it.

Second order: which first-order motions of a linkage the curvature of its constraints lets continue.

Along rates v with A v = 0 the loops stay closed to second order if y . H(v, v) = 0 for every stress y without load
(y A = 0), where a loop gives H(v, v) = sum [S_i, S_j] v_i v_j over its joints i before j. If only v = 0 does, the
configuration is isolated: a curve through it would have a first nonzero derivative that does. One combination of
the forms that is definite proves it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.mobility.instantaneous import InstantaneousMobility, at_state, instantaneous_mobility
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import (
    LoopState,
    configuration,
    loop_equations,
    loop_state,
    reduced_screws,
    units,
)
from mafsil.mobility.redundant_constraints import Block, blocks, left_null_space, loop_groups
from mafsil.mobility.spaces.motion_group import bracket
from mafsil.mobility.tolerances import CLOSED, DEFINITE, PATH_STEP
from mafsil.solvers import decompositions
from mafsil.solvers.linear_program import minimise
from mafsil.solvers.local_dimension import ALIKE, LOOSE, LocalSet, local_set
from mafsil.solvers.null_ways import EXACT, FINEST, solved_in_planes

ROUNDS = 40
STARTS = 64
NEWTON_STEPS = 60
DIGITS = 100.0
"""Times the largest singular value that was dropped: what the digits of a drawing leave of gaps."""
PLENTY = 8
"""Directions for each first-order motion where second order lets all of them continue."""


class FiniteStatus(Status):
    """What is known of the motions through a configuration, and how."""

    REGULAR = ("mobility.finite_regular", True)
    SMOOTH = ("mobility.finite_smooth", True)
    BRANCH_POINT = ("mobility.finite_branch_point", True)
    SHAKY = ("mobility.finite_shaky", True)
    RIGID = ("mobility.finite_rigid", False)
    RIGID_SECOND_ORDER = ("mobility.finite_rigid_second", False)
    NOT_FOUND = ("mobility.finite_not_found", False)
    IN_DOUBT = ("mobility.finite_in_doubt", False)


@dataclass(frozen=True, eq=False, repr=False)
class FiniteMobility(Answer, data="mobility instantaneous proven branches dimensions at_most order"):
    """Dimension of the set of configurations through one of them; true if it is known to move.

    Attributes:
        status: regular (proven by full rank), smooth (the rank stays around), branch point (several sets of
            configurations meet), shaky (more first-order motions than real ones), rigid (proven to first or second
            order), not found.
        mobility: largest dimension that was found.
        instantaneous: number of first-order motions.
        proven: whether `mobility` is a theorem here; else it is what a search found.
        branches: number of curves that meet, if all are curves; else 0.
        dimensions: those of the sets that were found, largest first.
        tangents: (k, F) directions along which motions were found, rates over `units`.
        theta: (k, F) configurations a small step along them [rad | m].
        at_most: above `mobility` where it is in doubt.
        order: with which loops open along first-order motions that do not continue; NaN if all do.
        gap: that left the doubt, of a loop over its own size.
    """

    status: FiniteStatus
    mobility: int
    instantaneous: int
    proven: bool
    branches: int
    dimensions: tuple[int, ...]
    tangents: Floats
    theta: Floats
    at_most: int
    order: float
    gap: float

    def __bool__(self) -> bool:
        return self.mobility > 0

    def explain(self, language: str | None = None) -> str:
        """The finding in a sentence, and how loops open along motions that do not continue."""
        found = self.status.sentence(
            language, mobility=self.mobility, instantaneous=self.instantaneous, branches=self.branches,
            looked=len(self.tangents), dimensions=", ".join(map(str, self.dimensions)) or "0",
            at_most=self.at_most, gap=self.gap,
        )  # fmt: skip
        opens = self.status in (FiniteStatus.SHAKY, FiniteStatus.NOT_FOUND) and bool(np.isfinite(self.order))
        return found + say("mobility.opens", language=language, order=self.order) if opens else found


@on_linkage
def finite_mobility(linkage: Linkage, theta: ArrayLike | None = None, *, seed: int = 0) -> FiniteMobility:
    """How many independent motions a linkage really has around a configuration.

    Each block of loops that hang together, as large as it may be, is judged alone:

    1. No first-order motion: rigid, proven.
    2. Each loop stays in the group that its joints generate; if the rank is the sum of the dimensions of these groups
       and the number of couplings, the configurations are smooth around this one and their dimension is the number of
       first-order motions: proven.
    3. Forms of second order: if a combination is definite, this configuration is isolated: proven.
    4. Else ways along the motions that second order admits: `solvers.local_dimension` decides by how gaps grow.

    Args:
        linkage: as drawn.
        theta: (F,) closed configuration [rad | m].
        seed: of the directions tried.

    Reference: A. Mueller, Local kinematic analysis of closed-loop linkages, Mechanism and Machine Theory 139 (2019).
    """
    linkage.require_all_joints()
    value = configuration(linkage, theta)
    apart, free = blocks(linkage)
    found = [_of_block(each.linkage, value[each.columns], seed) for each in apart]
    if len(found) == 1 and not len(free):
        return found[0]
    return _together(linkage, value, list(zip(apart, found, strict=True)), free)


def all_are_real(linkage: Linkage, theta: Floats, count: int) -> bool:
    """Whether all first-order motions at a configuration (F,) are real; of linkages without angles of balls unasked."""
    return bool(linkage.pairs or linkage.by_points) or finite_mobility(linkage, theta).mobility == count


def require_motions(linkage: Linkage, theta: Floats, count: int) -> None:
    """Refuse a start (F,) of as many first-order motions of which not all are real.

    Raises:
        InputError: the sentence says so.
    """
    if not all_are_real(linkage, theta, count):
        raise InputError("mobility.shaky_start", count=count)


def _of_block(linkage: Linkage, value: Floats, seed: int) -> FiniteMobility:
    """The same of one block."""
    state = loop_state(linkage, value)
    here = at_state(linkage, value, state, np.ones(linkage.coordinates))
    d = here.mobility
    if not d:  # 1
        return _isolated(FiniteStatus.RIGID, linkage, 0)
    asked = sum(g.dimension for _, g in loop_groups(linkage, reduced_screws(linkage, state.screws)))
    if here.rank == asked + len(linkage.couplings):  # 2
        tangents = here.rates.T
        ends = value + PATH_STEP * tangents * units(linkage)
        return FiniteMobility(FiniteStatus.REGULAR, d, d, True, 0, (d,), tangents, ends, d, np.nan, 0.0)
    second = second_order_forms(linkage, state, here.rates)  # 3
    if second.definite is not None:
        return _isolated(FiniteStatus.RIGID_SECOND_ORDER, linkage, d)
    u = value / units(linkage)  # 4
    tried = admitted_motions(second.forms, d, seed)[: None if len(second.forms) else PLENTY * d]
    exact = float(np.clip(DIGITS * here.dropped, FINEST, EXACT))
    found = local_set(loop_equations(linkage), u, tried @ here.rates.T, exact, seed)
    branches = found.lines if found.dimensions == (1,) else 0
    status = _status(found, d, branches, bool(len(second.forms)))
    return FiniteMobility(
        status, found.dimension, d, False, branches, found.dimensions, found.tangents, found.points * units(linkage),
        max(found.dimension, found.at_most), found.order, found.gap,
    )  # fmt: skip


def _isolated(status: FiniteStatus, linkage: Linkage, d: int) -> FiniteMobility:
    none = np.zeros((0, linkage.coordinates))
    return FiniteMobility(status, 0, d, True, 0, (), none, none, 0, 2.0 if d else np.nan, 0.0)


def _status(found: LocalSet, d: int, branches: int, bends: bool) -> FiniteStatus:
    """What was found of d first-order motions; `bends` if second order does not let all of them continue."""
    if found.at_most > found.dimension:
        return FiniteStatus.IN_DOUBT
    if not found.dimension:
        return FiniteStatus.NOT_FOUND
    if branches > 1 or len(found.dimensions) > 1 or (bends and _span(found.tangents) > found.dimension):
        return FiniteStatus.BRANCH_POINT
    return FiniteStatus.SMOOTH if found.dimension == d else FiniteStatus.SHAKY


def _span(tangents: Floats) -> int:
    """Dimension of what tangents span: more than that of a set, and several sets meet."""
    s = np.linalg.svd(tangents, compute_uv=False)
    return int((s > ALIKE * s[0]).sum())


def _together(
    linkage: Linkage, value: Floats, found: list[tuple[Block, FiniteMobility]], free: NDArray[np.intp]
) -> FiniteMobility:
    """Of all blocks and the free coordinates: their configurations are the product of those of each."""
    parts, F = [each for _, each in found], linkage.coordinates
    spun = np.eye(F)[free]
    tangents, ends = [spun], [value + PATH_STEP * spun * units(linkage)]
    for block, each in found:
        rates, places = np.zeros((len(each.tangents), F)), np.tile(value, (len(each.theta), 1))
        rates[:, block.columns] = each.tangents * units(block.linkage) / units(linkage)[block.columns]
        places[:, block.columns] = each.theta
        tangents.append(rates / np.linalg.norm(rates, axis=1, keepdims=True))
        ends.append(places)
    mobility, instantaneous, at_most = (
        len(free) + sum(counts)
        for counts in (
            [each.mobility for each in parts],
            [each.instantaneous for each in parts],
            [each.at_most for each in parts],
        )
    )
    choices = product(*(p.dimensions or (0,) for p in parts))
    dimensions = tuple(sorted({len(free) + sum(each) for each in choices} - {0}, reverse=True))
    branches = max((p.branches for p in parts), default=0) if dimensions == (1,) else 0
    orders = [p.order for p in parts if np.isfinite(p.order)]
    return FiniteMobility(
        _status_together({p.status for p in parts}, mobility, instantaneous), mobility, instantaneous,
        all(p.proven for p in parts), branches, dimensions, np.concatenate(tangents), np.concatenate(ends), at_most,
        max(orders, default=np.nan), max((p.gap for p in parts), default=0.0),
    )  # fmt: skip


def _status_together(statuses: set[FiniteStatus], mobility: int, instantaneous: int) -> FiniteStatus:
    for decisive in (FiniteStatus.IN_DOUBT, FiniteStatus.BRANCH_POINT):
        if decisive in statuses:
            return decisive
    if mobility and mobility < instantaneous:
        return FiniteStatus.SHAKY
    order = (FiniteStatus.NOT_FOUND, FiniteStatus.RIGID_SECOND_ORDER, FiniteStatus.SMOOTH)
    return next((each for each in order if each in statuses), FiniteStatus.REGULAR if mobility else FiniteStatus.RIGID)


@on_linkage
def generic_mobility(
    linkage: Linkage, theta: ArrayLike | None = None, *, step: float = 0.05, samples: int = 12, seed: int = 0
) -> int | None:
    """Least mobility by rank at configurations found around one by steps and Newton's method; None if none closed.

    Args:
        linkage: as drawn.
        theta: (F,) closed configuration [rad | m].
        step: length of the steps [rad, sizes].
        samples: number of steps.
        seed: of their directions.
    """
    found = mobility_around(linkage, theta, step=step, samples=samples, seed=seed)
    return None if found is None else found.mobility


@on_linkage
def mobility_around(
    linkage: Linkage, theta: ArrayLike | None = None, *, step: float = 0.05, samples: int = 12, seed: int = 0
) -> InstantaneousMobility | None:
    """Mobility by rank where it is least around a configuration; there where nothing moves, None if nothing closed.

    Arguments as for `generic_mobility`.
    """
    value, count = configuration(linkage, theta), whole("samples", samples, 1, 100_000)
    state = loop_state(linkage, value)
    here = at_state(linkage, value, state, np.ones(linkage.coordinates))
    if not here.mobility:
        return here
    along = np.random.default_rng(seed).normal(size=(count, here.mobility)) @ here.rates.T
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    starts, scale = value / units(linkage) + step * along, units(linkage)
    around, gap = solved_in_planes(loop_equations(linkage), starts, np.zeros((count, 0, len(scale))), step)
    closed = around[gap <= CLOSED] * scale
    if not len(closed):
        return None
    ranks = decompositions.ranks(loop_state(linkage, closed).matrix, LOOSE)
    return instantaneous_mobility(linkage, closed[int(ranks.argmax())], share=LOOSE)


@dataclass(frozen=True, eq=False)
class SecondOrderForms:
    """What the loops ask of first-order motions at second order.

    Attributes:
        forms: (s, d, d) symmetric, independent, of unit size; s = 0 if all first-order motions pass.
        definite: (s,) combination of the forms that is positive definite: the proof that nothing moves; or None.
    """

    forms: Floats
    definite: Floats | None


def second_order_forms(linkage: Linkage, state: LoopState, rates: Floats) -> SecondOrderForms:
    """The forms on first-order motions (F, d), and a definite combination if one is found.

    Args:
        linkage: as drawn.
        state: closed.
        rates: (F, d) orthonormal basis of the null space of the loop matrix.
    """
    d = rates.shape[1]
    stresses = left_null_space(state.matrix)
    if not stresses.shape[1] or not d or any(each.table for each in linkage.couplings):
        # Cams bend, which the screws do not know: a search decides.
        return SecondOrderForms(np.zeros((0, d, d)), None)
    moved = screw_rates(linkage, reduced_screws(linkage, state.screws))
    cycles, by_loop = linkage.cycles[:, linkage.joint_of], stresses[: 6 * linkage.loops].reshape(linkage.loops, 6, -1)
    raw = np.array([
        rates.T @ np.einsum("kr,kir->ik", cycles.T @ by_loop[..., a], moved) @ rates for a in range(stresses.shape[1])
    ])  # fmt: skip
    flat = (raw + raw.transpose(0, 2, 1)).reshape(len(raw), -1) / 2
    _, s, Vt = np.linalg.svd(flat, full_matrices=False)
    forms = Vt[s > DEFINITE * max(1.0, float(s.max(initial=0.0)))].reshape(-1, d, d)
    return SecondOrderForms(forms, _definite(forms))


def screw_rates(linkage: Linkage, screws: Floats) -> Floats:
    """(F, F, 6) at [k, i]: how the screw of coordinate k changes with coordinate i, [S_i, S_k] where i moves it.

    Args:
        linkage: as drawn.
        screws: (6, F) now, free of units.
    """
    by_body = linkage.paths[linkage.ends[linkage.joint_of, 0]][:, linkage.joint_of]
    same = linkage.joint_of[:, None] == linkage.joint_of[None, :]
    before = by_body + (same & (np.arange(len(same))[None, :] < np.arange(len(same))[:, None]))
    S = screws.T
    return before[:, :, None] * bracket(S[None, :, :], S[:, None, :])


def _definite(forms: Floats) -> Floats | None:
    """A combination of forms that is positive definite, by cutting planes: max t, v' Q(c) v >= t for the cuts v."""
    s, d = forms.shape[:2]
    if not s:
        return None
    cuts: Floats = np.eye(d)
    for _ in range(ROUNDS):
        values = np.einsum("cp,spq,cq->cs", cuts, forms, cuts)
        rows = np.hstack([-values, np.ones((len(cuts), 1))])
        box = np.vstack([np.hstack([np.eye(s), np.zeros((s, 1))]), np.hstack([-np.eye(s), np.zeros((s, 1))])])
        best = minimise(
            np.append(np.zeros(s), -1.0), np.zeros((0, s + 1)), np.zeros(0), np.vstack([rows, box]),
            np.concatenate([np.zeros(len(cuts)), np.ones(2 * s)]), s + 1,
        )  # fmt: skip
        if best is None or best.x[-1] <= DEFINITE:
            return None
        c = best.x[:s]
        lowest, directions = np.linalg.eigh(np.einsum("s,spq->pq", c, forms))
        if lowest[0] > DEFINITE:
            return c
        cuts = np.concatenate([cuts, np.asarray(directions.T[lowest <= DEFINITE], dtype=np.float64)])
    return None


def admitted_motions(forms: Floats, d: int, seed: int = 0) -> Floats:
    """(k, d) unit first-order motions that all forms let continue, found from many starts by Newton's method.

    Args:
        forms: (s, d, d).
        d: number of first-order motions.
        seed: of the starts.
    """
    starts = np.random.default_rng(seed).normal(size=(STARTS * max(1, d), d))
    v = starts / np.linalg.norm(starts, axis=1, keepdims=True)
    if not len(forms):
        return v
    for _ in range(NEWTON_STEPS):
        Qv = np.einsum("spq,kq->ksp", forms, v)
        residual = np.asarray(np.einsum("ksp,kp->ks", Qv, v), dtype=np.float64)
        across = Qv - residual[:, :, None] * v[:, None, :]
        back = np.asarray(np.linalg.pinv(2 * across, rcond=1e-8), dtype=np.float64)
        v = v - np.einsum("kps,ks->kp", back, residual)
        v = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), LEAST_DIVISOR)
    left = np.abs(np.einsum("kp,spq,kq->ks", v, forms, v)).max(axis=1)
    return v[left < DEFINITE]
