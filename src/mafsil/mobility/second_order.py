"""Second order: which first-order motions of a linkage the curvature of its constraints lets continue.

Along rates v with A v = 0 the loops stay closed to second order if y . H(v, v) = 0 for every stress y without load
(y A = 0), where a loop gives H(v, v) = sum [S_i, S_j] v_i v_j over its joints i before j. If only v = 0 does, the
configuration is isolated: a curve through it would have a first nonzero derivative that does. One combination of
the forms that is definite proves it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.loop_closure import LoopState, reduced_screws
from mafsil.mobility.redundant_constraints import left_null_space
from mafsil.mobility.spaces.motion_group import bracket
from mafsil.mobility.tolerances import DEFINITE
from mafsil.solvers.linear_program import minimise

ROUNDS = 40
STARTS = 64
NEWTON_STEPS = 60


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
    if not stresses.shape[1] or not d:
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


def admitted(forms: Floats, d: int, seed: int = 0) -> Floats:
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
        v = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-300)
    left = np.abs(np.einsum("kp,spq,kq->ks", v, forms, v)).max(axis=1)
    return v[left < DEFINITE]
