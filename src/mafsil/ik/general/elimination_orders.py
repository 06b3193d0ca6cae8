"""Orders of elimination for six joints: which joint is found first, and the constants of the elimination for it.

A loop E_1 ... E_6 = P, E_k = exp(S_k q_k), is cut so that three neighbours c, d, e move the axis of the joint f after
them, and the joints a, b of the rest, with P between or beside them, move it back:

E_c E_d E_e l_f = G(q_a, q_b, P) l_f.

Fourteen functions of a line l with a point p on it are linear in (1, cos q, sin q) of every joint that moves it: p,
p.p, and the bivector of (1, p, p.p / 2) and (0, l, p.l), that is l, p.l, p x l, (p.p) l - 2 (p.l) p. Six combinations
of them do not contain q_a and q_b. With the half-angle (cos, sin) of q_d as homogeneous unknowns, and each equation
multiplied by both, they are twelve equations linear in twelve products. Their determinant is a trigonometric polynomial
of q_c, of degree eight if all joints turn: sampled on the circle, nothing has to be divided out and no angle is at
infinity.

References: Raghavan and Roth, Inverse kinematics of the general 6R manipulator, 1993; Manocha and Canny, 1994.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.geometry import pose
from mafsil.ik.chain import Chain

NODES: Floats = 2 * np.pi / 3 * np.arange(3.0)
"""Angles at which a function linear in (1, cos, sin) is sampled."""

PRISMATIC_NODES: Floats = np.array([-1.0, 0.0, 1.0])
"""Lengths, in units of the arm, at which a quadratic function is sampled."""

TWIST = 0.3141
"""Where the half angle of joint d is zero: no place that arms prefer."""


@dataclass(frozen=True, eq=False)
class EliminationOrder:
    """Constants of one elimination.

    Attributes:
        joints: (6,) positions of a, b, c, d, e, f in the chain seen from its base.
        backwards: whether the chain is seen from its tip.
        before: (9, 6) lines (p, l) before P moves them; only the first `lines` count.
        lines: 1, 3 or 9.
        after: (9, 3, 4) displacements after P; only the first 9 / `lines` count.
        products: (9, 9) from samples, by rows, to coefficients of the products of a and b, by columns.
        left: (14, 27) coefficients of the functions moved by c, d, e: (1, cos, sin) of c, homogeneous of d, of e.
        unit: (3,) the constant one as a homogeneous form of d.
    """

    joints: NDArray[np.int64]
    backwards: bool
    before: Floats
    lines: int
    after: Floats
    products: Floats
    left: Floats
    unit: Floats

    @property
    def constants(self) -> tuple[Floats, int, Floats, Floats, Floats, Floats]:
        """What the elimination of a pose takes, in its order."""
        return self.before, self.lines, self.after, self.products, self.left, self.unit


def orders(chain: Chain) -> list[EliminationOrder]:
    """All elimination orders of a chain of six joints whose origin and unit of length fit it."""
    found: list[EliminationOrder] = []
    for backwards in (False, True):
        seen = chain.backwards() if backwards else chain
        for first in (2, 1, 0):
            if not seen.prismatic[first] and not seen.prismatic[first + 3]:
                found.append(_order(seen, first, backwards))
    return found


def line_functions(p: Floats, l: Floats) -> Floats:
    """(..., 14) the functions of lines.

    Args:
        p: (..., 3) a point of each.
        l: (..., 3) its direction.
    """
    pp, pl = (p * p).sum(-1, keepdims=True), (p * l).sum(-1, keepdims=True)
    return np.concatenate([p, pp, l, pl, np.cross(p, l), pp * l - 2 * pl * p], axis=-1)


def _order(chain: Chain, first: int, backwards: bool) -> EliminationOrder:
    c, d, e, f = first, first + 1, first + 2, first + 3
    a, b = {2: (0, 1), 1: (0, 5), 0: (4, 5)}[first]
    place, line = chain.points[f], chain.axes[f]
    at_a, at_b = _displace(chain, a, -1.0), _displace(chain, b, -1.0)
    nothing = np.eye(4)[None]
    before, after = {
        2: (nothing, (at_b[None] @ at_a[:, None]).reshape(9, 4, 4)),
        1: (at_b, at_a),
        0: ((at_b[None] @ at_a[:, None]).reshape(9, 4, 4), nothing),
    }[first]
    lines = np.zeros((9, 6))
    lines[: len(before)] = np.concatenate(
        [before[:, :3, :3] @ place + before[:, :3, 3], before[:, :3, :3] @ line], axis=1
    )
    moves = np.zeros((9, 3, 4))
    moves[: len(after)] = after[:, :3]
    left, unit = _left(chain, (c, d, e), place, line)
    order = [5 - k for k in (a, b, c, d, e, f)] if backwards else [a, b, c, d, e, f]
    one, two = np.linalg.inv(_basis(chain.prismatic[a])), np.linalg.inv(_basis(chain.prismatic[b]))
    products: Floats = np.ascontiguousarray(np.kron(one, two).T, dtype=np.float64)
    return EliminationOrder(np.array(order, dtype=np.int64), backwards, lines, len(before), moves, products, left, unit)


def _left(chain: Chain, middle: tuple[int, int, int], place: Floats, line: Floats) -> tuple[Floats, Floats]:
    """(14, 27) coefficients of the functions on the left, and the constant one as a form of joint d."""
    c, d, e = middle
    E = _displace(chain, c)[:, None, None] @ _displace(chain, d)[:, None] @ _displace(chain, e)
    samples = line_functions(E[..., :3, :3] @ place + E[..., :3, 3], E[..., :3, :3] @ line)
    form, unit = _homogeneous(chain.prismatic[d])
    one, three = np.linalg.inv(_basis(chain.prismatic[c])), np.linalg.inv(_basis(chain.prismatic[e]))
    two = form @ np.linalg.inv(_basis(chain.prismatic[d]))
    out = np.einsum("ia,jb,kc,abcf->fijk", one, two, three, samples).reshape(14, 27)
    return np.ascontiguousarray(out), unit


def _displace(chain: Chain, k: int, sign: float = 1.0) -> Floats:
    """(3, 4, 4) displacements of a joint at its nodes."""
    nodes = PRISMATIC_NODES if chain.prismatic[k] else NODES
    return pose.exp(chain.screws[k] * (sign * nodes)[:, None])


def _basis(prismatic: bool) -> Floats:
    """(3, 3) rows (1, cos, sin), or (1, q, q^2) of a prismatic joint, at the nodes."""
    if prismatic:
        return np.stack([np.ones(3), PRISMATIC_NODES, PRISMATIC_NODES**2], axis=1)
    return np.stack([np.ones(3), np.cos(NODES), np.sin(NODES)], axis=1)


def _homogeneous(prismatic: bool) -> tuple[Floats, Floats]:
    """From coefficients of (1, cos, sin) to those of (c^2, c s, s^2), of half the angle beyond `TWIST`; the one.

    A prismatic joint is s / c - `TWIST`.
    """
    if prismatic:
        # q = s / c - TWIST, so (1, q, q^2) c^2 = (c^2, c s - TWIST c^2, s^2 - 2 TWIST c s + TWIST^2 c^2).
        forms = np.array([[1.0, 0.0, 0.0], [-TWIST, 1.0, 0.0], [TWIST**2, -2 * TWIST, 1.0]])
        return forms.T, forms[0]
    C, S = np.cos(TWIST), np.sin(TWIST)
    forms = np.array([[1.0, 0.0, 1.0], [C, -2 * S, -C], [S, 2 * C, -S]])
    return forms.T, forms[0]
