"""Does a hull of discs reach at least b in every direction? Proven cone by cone, compiled.

A cone of directions is spanned by unit vectors v_j. With points w_p of the set and multipliers l_p >= 0, sum 1, the
support function h is at least (sum l_p w_p) . u: if that is at least b for each v_j, the cone is proven (first order).
A disc a + E n that is met at its rim along unit n has, with q = E n' (n' square to n), everywhere

  h(u) >= w . u + (q . u)^2 / (2 |E' u|),  w = a + E n,

so with w_ = sum l_p w_p and any 0 <= s <= 1, where the w_p reach a positive height along every v_j,

  h(u)^2 >= u' Y u,  Y = sum l_p ((1 - s) w_ w_' + s w_p w_p' + c_p q_p q_p'),
  c_p = min over j of ((1 - s) w_ + s w_p) . v_j / |E_p' v_j|,

and if V' (Y - b^2 I) V is a nonnegative plus a positive semidefinite matrix, the cone is proven (second order): kinks
and curvature are exact to second order, so that minima in the middle of a cone can be proven too.

Branch and bound (`prove_cover`): orthants wait on a stack, a cone is proved by cutting planes (`examine`),
whose multipliers come from a matrix game (`game`), to first or second order (`second_order`), or is halved (`halve`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.loop import compiled
from mafsil.solvers.disc_loops import dot
from mafsil.solvers.matrix_game_loops import game
from mafsil.solvers.tolerances import STILL, TINY, WALL

PROVEN, LOWER, SPENT = 0, 1, 2
"""How `prove_cover` ended: every direction proven; a direction found that reaches less far; too many cones."""
CUTS = 3
"""Rounds of cutting planes for one cone at most."""
MOST = 96
"""Points of the set in the proof of a cone at most."""
SHARES = np.array([1.0, 0.3, 0.1, 0.03, 0.0])
"""Values of s that are tried."""
STACK = 1024
"""Cones that wait at most."""
DEEP, MANY = 12, 300
"""Rounds of cutting planes, and steps, of a descent at most."""


@compiled
def pieces_at(D: Floats, u: Floats, W: Floats, Q: Floats, disc: Floats, count: int) -> tuple[float, int]:
    """Add the furthest points along u of discs that reach beyond the origin; how far, how many points then.

    1. Height of each disc along u: its centre, the radius of its ellipse, its torsion; the largest is how far the set
       reaches.
    2. Of each disc that reaches beyond the origin, the point furthest along u, and how it bends as u turns: the
       ellipse's tangent there.
    """
    k, parts, m = D.shape
    best = -np.inf
    heights, xs, ys, ts = np.empty(k), np.zeros(k), np.zeros(k), np.zeros(k)
    for i in range(k):  # 1
        heights[i] = dot(D[i, 0], u)
        if parts > 1:
            xs[i], ys[i] = dot(D[i, 1], u), dot(D[i, 2], u)
            heights[i] += np.sqrt(xs[i] ** 2 + ys[i] ** 2)
        if parts > 3:
            ts[i] = dot(D[i, 3], u)
            heights[i] += abs(ts[i])
        best = max(best, heights[i])
    for i in range(k):
        if heights[i] < 0.0 or count >= len(W):  # 2
            continue
        r = np.sqrt(xs[i] ** 2 + ys[i] ** 2)
        for c in range(m):
            W[count, c], Q[count, c] = D[i, 0, c], 0.0
            if r > 0.0:
                W[count, c] += (xs[i] * D[i, 1, c] + ys[i] * D[i, 2, c]) / r
                Q[count, c] = (xs[i] * D[i, 2, c] - ys[i] * D[i, 1, c]) / r
            if parts > 3:
                W[count, c] += D[i, 3, c] if ts[i] >= 0.0 else -D[i, 3, c]
        disc[count] = i
        count += 1
    return best, count


@compiled
def semidefinite(M: Floats, L: Floats) -> bool:
    """Whether a symmetric matrix is positive definite, by Cholesky's factors."""
    m = len(M)
    for i in range(m):
        for j in range(i + 1):
            s = M[i, j]
            for c in range(j):
                s -= L[i, c] * L[j, c]
            if i == j:
                if not s > 0.0:
                    return False
                L[i, i] = np.sqrt(s)
            else:
                L[i, j] = s / L[j, j]
    return True


@compiled
def second_order(V: Floats, H: Floats, QV: Floats, R: Floats, weights: Floats, count: int, b: float) -> bool:
    """Whether second order proves a cone.

    1. The mean m = sum l_p w_p along every v_j; a point below the origin along one of them proves nothing.
    2. For each share s: M = V' (Y - b^2 I) V, the bends q of each point with the largest c that the heights allow.
    3. The cone is proven if M without its positive entries off the diagonal, or M itself, is positive definite.

    Args:
        V: (m, m) rows v_j.
        H, QV, R: (count, m) w_p . v_j, q_p . v_j and |E_p' v_j|.
        weights: l_p.
        count: of points.
        b: to be proven.
    """
    m = len(V)
    mean, M, S, L = np.zeros(m), np.empty((m, m)), np.empty((m, m)), np.zeros((m, m))
    for p in range(count):  # 1
        if weights[p] > 0.0:
            for j in range(m):
                mean[j] += weights[p] * H[p, j]
                if H[p, j] < 0.0:
                    return False
    for share in SHARES:  # 2
        for i in range(m):
            for j in range(i + 1):
                M[i, j] = (1.0 - share) * mean[i] * mean[j] - b * b * dot(V[i], V[j])
        for p in range(count):
            l = weights[p]
            if l <= 0.0:
                continue
            c = np.inf
            for j in range(m):
                if R[p, j] > 0.0:
                    c = min(c, ((1.0 - share) * mean[j] + share * H[p, j]) / R[p, j])
            if c == np.inf:
                c = 0.0
            for i in range(m):
                for j in range(i + 1):
                    M[i, j] += l * (share * H[p, i] * H[p, j] + c * QV[p, i] * QV[p, j])
        for i in range(m):
            for j in range(i + 1):
                M[j, i] = M[i, j]
                S[i, j] = S[j, i] = M[i, j] if i == j else min(0.0, M[i, j])
        if semidefinite(S, L) or semidefinite(M, L):  # 3
            return True
    return False


class ConeProof(NamedTuple):
    """What the proof of one cone works with; rows are points of the set.

    Attributes:
        W, Q: (most, m) points w and bends q.
        disc: (most,) of which disc each is.
        H, QV, R: (most, m) w . v_j, q . v_j and |E' v_j|.
        T, side: of the matrix game.
        weights: (most,) l.
        t: (m,) the other player's mixture of the v_j.
        u: (m,) the direction that it makes.
    """

    W: Floats
    Q: Floats
    disc: Floats
    H: Floats
    QV: Floats
    R: Floats
    T: Floats
    side: Floats
    weights: Floats
    t: Floats
    u: Floats


@compiled
def make_proof(m: int) -> ConeProof:
    """Buffers in m dimensions."""
    return ConeProof(
        np.empty((MOST, m)), np.empty((MOST, m)), np.empty(MOST), np.empty((MOST, m)), np.empty((MOST, m)),
        np.empty((MOST, m)), np.empty((MOST + 1, m + 1)), np.empty(MOST), np.empty(MOST), np.empty(m), np.empty(m),
    )  # fmt: skip


@compiled
def examine(D: Floats, V: Floats, b: float, cuts: int, prove: bool, proof: ConeProof) -> tuple[int, float]:
    """Try to prove the cone of the rows of V by cutting planes; leave the direction of the last one in `proof.u`.

    1. The set's furthest points along a mixture u of the v_j, at first the middle, join.
    2. Where the set reaches less than b along u, that is the answer.
    3. Heights and bends of the new points along the v_j.
    4. The matrix game gives multipliers l of the points, and the mixture where their proof is worst: the next u.
    5. The cone is proven to first order by the worst height, or to second order.

    Args:
        D: (k, 4, m).
        V: (m, m) unit rows.
        b: to be proven.
        cuts: rounds at most.
        prove: False to follow the cutting planes to their end, without proofs.
        proof: buffers.

    Returns:
        PROVEN, SPENT, or LOWER where the set reaches less than b along `proof.u`; how far it reaches along it.
    """
    m = len(V)
    H, QV, R, t, u = proof.H, proof.QV, proof.R, proof.t, proof.u
    t[:] = 1.0 / m
    count, last, best = 0, -np.inf, np.inf
    for _ in range(cuts):
        for c in range(m):
            u[c] = 0.0
            for j in range(m):
                u[c] += t[j] * V[j, c]
        size, before = np.sqrt(dot(u, u)), count
        reach, count = pieces_at(D, u, proof.W, proof.Q, proof.disc, count)  # 1
        best = reach / size
        if best < b:  # 2
            return LOWER, best
        if before > 0 and reach <= last + STILL * b:
            break
        shift = reach  # 3
        for p in range(before, count):
            i = int(proof.disc[p])
            for j in range(m):
                H[p, j], QV[p, j] = dot(proof.W[p], V[j]), dot(proof.Q[p], V[j])
                R[p, j] = np.hypot(dot(D[i, 1], V[j]), dot(D[i, 2], V[j]))
        for p in range(count):
            for j in range(m):
                shift = max(shift, reach - H[p, j])
        game(H, count, shift, t, proof.weights, proof.T, proof.side)  # 4
        last = np.inf
        for j in range(m):
            s = 0.0
            for p in range(count):
                s += proof.weights[p] * H[p, j]
            last = min(last, s)
        if prove and (last >= b or second_order(V, H, QV, R, proof.weights, count, b)):
            return PROVEN, best
        if count + len(D) > MOST:
            break
    return SPENT, best


@compiled
def begin(m: int, stack: Floats) -> int:
    """The orthants, as the first cones that wait; how many."""
    for s in range(1 << m):
        for j in range(m):
            for c in range(m):
                stack[s, j, c] = 0.0
            stack[s, j, j] = 1.0 if (s >> j) & 1 else -1.0
    return 1 << m


@compiled
def halve(stack: Floats, at: int) -> None:
    """The cone at a place of the stack becomes two, there and after it: its longest edge is halved.

    1. The longest edge joins the two vertices of least cosine.
    2. Its middle, back on the sphere, takes the place of one end in one half and of the other end in the other.
    """
    V = stack[at]
    m = len(V)
    far, a, b = 2.0, 0, 1  # 1
    for i in range(m):
        for j in range(i):
            s = dot(V[i], V[j])
            if s < far:
                far, a, b = s, i, j
    middle = V[a] + V[b]  # 2
    size = np.sqrt(dot(middle, middle))
    stack[at + 1] = V
    for c in range(m):
        stack[at + 1, b, c] = V[a, c] = middle[c] / size


@compiled
def elsewhere(V: Floats, walls: Floats) -> bool:
    """Whether a wall x has the whole cone on its far side, x . v_j < 0: a symmetric cone is proven instead."""
    for w in range(len(walls)):
        beyond = True
        for j in range(len(V)):
            if dot(walls[w], V[j]) > -WALL:
                beyond = False
                break
        if beyond:
            return True
    return False


@compiled
def prove_cover(
    D: Floats, b: float, walls: Floats, stack: Floats, waiting: int, budget: int, lowest: Floats
) -> tuple[int, float, int, int]:
    """Prove h(u) >= b |u| in the cones that wait.

    1. A cone on the far side of a wall is left to its image under the symmetries.
    2. The cone on top of the stack is examined by cutting planes.
    3. A direction that reaches less than b ends the search; it can go on with a smaller b, for what is proven stays so.
    4. A proven cone leaves the stack; else its longest edge is halved, and both halves wait.

    Args:
        D: (k, 4, m) discs.
        b: the radius.
        walls: (n, m) of a region whose symmetric images fill the space.
        stack: (STACK, m, m) the cones that wait, changed.
        waiting: how many do.
        budget: cones to look at.
        lowest: (m,) out: the direction that reaches less far than b.

    Returns:
        How it ended, how far the set reaches along `lowest`, how many cones wait, what is left of the budget.
    """
    m = D.shape[2]
    proof = make_proof(m)
    while waiting > 0:
        if budget <= 0 or waiting >= len(stack):
            return SPENT, 0.0, waiting, budget
        budget -= 1
        at = waiting - 1
        if elsewhere(stack[at], walls):  # 1
            waiting -= 1
            continue
        state, reach = examine(D, stack[at], b, CUTS, True, proof)  # 2
        if state == LOWER:  # 3
            lowest[:] = proof.u / np.sqrt(dot(proof.u, proof.u))
            return LOWER, reach, waiting, budget
        if state == PROVEN:  # 4
            waiting -= 1
        else:
            halve(stack, at)
            waiting += 1
    return PROVEN, b, 0, budget


@compiled
def cone_about(u: Floats, width: float, V: Floats) -> None:
    """A cone about a unit vector u, to rows of V: the simplex square to the diagonal, mirrored to be square to u.

    Its vertices are a width away from u, on the other side where the width is negative.

    1. The normal x of the mirror that takes the diagonal to u.
    2. The vertices of the simplex square to the diagonal, mirrored, added to u, at length 1.
    """
    m = len(u)
    sign = 1.0 if u.sum() >= 0.0 else -1.0  # 1
    x = u + sign / np.sqrt(m)
    square = dot(x, x)
    for j in range(m):  # 2
        for c in range(m):
            V[j, c] = -width / m
        V[j, j] += width
        along = dot(x, V[j])
        for c in range(m):
            V[j, c] += u[c] - 2.0 * along * x[c] / max(square, LEAST_DIVISOR)
        size = np.sqrt(dot(V[j], V[j]))
        for c in range(m):
            V[j, c] /= size


@compiled
def descend(D: Floats, u: Floats, width: float, narrowest: float) -> float:
    """Walk downhill from a unit direction, which is changed; how far the set reaches in the end.

    The least of cutting planes over a small cone about u is the next u; where that is no gain, the cone shrinks.

    1. How far the set reaches along u.
    2. The least of cutting planes over a cone about u, turned every other time, is where to go next.
    3. A step that gains is taken, and the cone shrinks where it gained little; else the cone is halved.
    """
    m = len(u)
    proof, V = make_proof(m), np.empty((m, m))
    reach, _ = pieces_at(D, u, proof.W, proof.Q, proof.disc, 0)  # 1
    turn = 1.0
    for _ in range(MANY):
        if width < narrowest:
            break
        cone_about(u, turn * width, V)  # 2
        examine(D, V, 0.0, DEEP, False, proof)
        size = np.sqrt(dot(proof.u, proof.u))
        for c in range(m):
            proof.u[c] /= size
        found, _ = pieces_at(D, proof.u, proof.W, proof.Q, proof.disc, 0)
        if found < reach * (1.0 - TINY):  # 3
            if found > reach * (1.0 - 1e-3 * width):
                width *= 0.7
            reach = found
            u[:] = proof.u
        else:
            width *= 0.5
        turn = -turn
    return reach
