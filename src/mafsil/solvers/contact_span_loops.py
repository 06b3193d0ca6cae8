"""Do contacts hold a body in every direction? From points, normals and coefficients to the verdict, compiled.

1. Wrenches are taken about the middle of the points, and moments divided by their spread.
2. Each contact becomes a disc of wrenches of unit push (see `disc_loops`).
3. A few points on the rims of the discs are the first columns of the simplex method, which asks the discs for further
   ones until the verdict is certain (`positive_span_loops`).
4. A no needs the set clearly away from the origin, or two hard contacts whose line leaves the moments of all others on
   one side: about that line nothing turns the body back, wherever exactly the contacts are.
5. Of a no, the certificate is brought back to the frame of the points. Of a yes, the positive weights are summed for
   each contact: forces strictly inside the cones that balance.

A contact is a row (point, normal, mu, gamma), 2 d + 2 numbers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.solvers.disc_loops import Dimension
from mafsil.solvers.positive_span_loops import (
    DOUBTFUL,
    OPEN,
    ROUNDS,
    SPANS,
    Tableau,
    make_tableau,
    span,
    stands_apart,
)
from mafsil.solvers.tolerances import ASIDE


class Placement(NamedTuple):
    """The contacts of one grasp in its own coordinates, and its columns.

    Attributes:
        normals: (k, d) of length 1.
        middle: (d,) of the points.
        force: (d,) to work in.
        discs: (k, 4, m) wrenches of unit push.
        rim: (m, k edges) points on the rims, the first columns of the simplex method.
        more: (m, k ROUNDS) columns for which it asks the discs.
    """

    normals: Floats
    middle: Floats
    force: Floats
    discs: Floats
    rim: Floats
    more: Floats


@compiled
def make_placement(k: int, d: int, m: int, edges: int) -> Placement:
    """Buffers for grasps of k contacts."""
    return Placement(
        np.empty((k, d)), np.empty(d), np.empty(d), np.empty((k, 4, m)), np.empty((m, k * edges)),
        np.empty((m, k * ROUNDS)),
    )  # fmt: skip


@compiled
def arrange(contacts: Floats, circle: Floats, P: Placement) -> float:
    """Steps 1 to 3 up to the first columns; the spread of the points.

    Args:
        contacts: (k, 2 d + 2).
        circle: (edges, 2) cosines and sines.
        P: out.
    """
    length = about_middle(contacts, P.middle)  # 1
    discs(contacts, P.normals, P.middle, length, P.force, P.discs)  # 2
    rims(P.discs, circle, P.rim)  # 3
    return length


@compiled
def about_middle(contacts: Floats, middle: Floats) -> float:
    """The middle of the points, and their spread about it; 1 of a single point.

    Args:
        contacts: (k, 2 d + 2).
        middle: (d,) out.
    """
    k, d, spread = len(contacts), len(middle), 0.0
    for c in range(d):
        middle[c] = 0.0
        for i in range(k):
            middle[c] += contacts[i, c] / k
    for i in range(k):
        square = 0.0
        for c in range(d):
            square += (contacts[i, c] - middle[c]) ** 2
        spread = max(spread, np.sqrt(square))
    return spread if spread > 0.0 else 1.0


@compiled
def place(contacts: Floats, i: int, middle: Floats, length: float, f: Floats, w: Floats) -> None:
    """The wrench of a force at a contact, ((r - middle) x f / length, f).

    Args:
        contacts: (k, 2 d + 2).
        i: which contact.
        middle, length: from `about_middle`.
        f: (d,) force.
        w: (m,) out.
    """
    d = len(f)
    if d == 2:
        w[0] = ((contacts[i, 0] - middle[0]) * f[1] - (contacts[i, 1] - middle[1]) * f[0]) / length
        w[1], w[2] = f[0], f[1]
        return
    x, y, z = contacts[i, 0] - middle[0], contacts[i, 1] - middle[1], contacts[i, 2] - middle[2]
    w[0], w[1], w[2] = (y * f[2] - z * f[1]) / length, (z * f[0] - x * f[2]) / length, (x * f[1] - y * f[0]) / length
    w[3], w[4], w[5] = f[0], f[1], f[2]


@compiled
def discs(contacts: Floats, normals: Floats, middle: Floats, length: float, f: Floats, D: Floats) -> None:
    """Wrenches of unit push of each contact: centre, two friction directions, torsion.

    1. The unit normal, from the normal scaled by its longest part: the push.
    2. Friction in the plane is one direction, square to the push.
    3. In space: the couple of torsion along the normal, and two friction directions of length mu that are square to it
       and to each other.

    Args:
        contacts: (k, 2 d + 2).
        normals: (k, d) out: of length 1; scaled by their longest part first, so that nothing overflows.
        middle, length: from `about_middle`.
        f: (d,) to work in.
        D: (k, 4, m) out.
    """
    d = len(middle)
    for i in range(len(contacts)):
        n, mu, gamma = normals[i], contacts[i, 2 * d], contacts[i, 2 * d + 1]
        longest, square = 0.0, 0.0  # 1
        for c in range(d):
            longest = max(longest, abs(contacts[i, d + c]))
        for c in range(d):
            n[c] = contacts[i, d + c] / longest
            square += n[c] * n[c]
        size = np.sqrt(square)
        for c in range(d):
            n[c] /= size
        place(contacts, i, middle, length, n, D[i, 0])
        for c in range(D.shape[2]):
            D[i, 1, c] = D[i, 2, c] = D[i, 3, c] = 0.0
        if d == 2:  # 2
            f[0], f[1] = -mu * n[1], mu * n[0]
            place(contacts, i, middle, length, f, D[i, 1])
            continue
        for c in range(3):  # 3
            D[i, 3, c] = gamma * n[c] / length
        if mu > 0.0:
            p = 0 if abs(n[0]) <= abs(n[1]) and abs(n[0]) <= abs(n[2]) else 1 if abs(n[1]) <= abs(n[2]) else 2
            q, s = (p + 1) % 3, (p + 2) % 3
            across = np.sqrt(n[q] * n[q] + n[s] * n[s])
            f[p], f[q], f[s] = 0.0, -mu * n[s] / across, mu * n[q] / across
            place(contacts, i, middle, length, f, D[i, 1])
            x, y, z = f[0], f[1], f[2]
            f[0], f[1], f[2] = n[1] * z - n[2] * y, n[2] * x - n[0] * z, n[0] * y - n[1] * x
            place(contacts, i, middle, length, f, D[i, 2])


@compiled
def rims(D: Floats, circle: Floats, W: Floats) -> None:
    """Points on the rims of discs, torsion to and fro in turn.

    Args:
        D: (k, 4, m).
        circle: (edges, 2) cosines and sines.
        W: (m, k edges) out.
    """
    edges = len(circle)
    for i in range(len(D)):
        for e in range(edges):
            x, y, t = circle[e, 0], circle[e, 1], 1.0 if e % 2 else -1.0
            for c in range(D.shape[2]):
                W[c, i * edges + e] = D[i, 0, c] + x * D[i, 1, c] + y * D[i, 2, c] + t * D[i, 3, c]


@compiled
def moment_aside(contacts: Floats, normals: Floats, u: Floats, at: int, to: int) -> float:
    """Least moment about the line through two contacts that any other contact gives with unit push; positive or not.

    1. The gradient g of the moment about the line by a force at the contact: its axis crossed with the lever.
    2. The push's moment, less the most that friction in the tangent plane and torsion can take from it.

    Args:
        contacts: (k, 2 d + 2) in space.
        normals: (k, 3) of length 1.
        u: (3,) unit vector from contact `at` to contact `to`.
        at, to: which two.
    """
    least = np.inf
    for i in range(len(contacts)):
        if i in (at, to):
            continue
        x, y = contacts[i, 0] - contacts[at, 0], contacts[i, 1] - contacts[at, 1]  # 1
        z = contacts[i, 2] - contacts[at, 2]
        g0, g1, g2 = u[1] * z - u[2] * y, u[2] * x - u[0] * z, u[0] * y - u[1] * x
        n = normals[i]  # 2
        along = g0 * n[0] + g1 * n[1] + g2 * n[2]
        across = np.sqrt(max(0.0, g0 * g0 + g1 * g1 + g2 * g2 - along * along))
        turned = abs(u[0] * n[0] + u[1] * n[1] + u[2] * n[2])
        least = min(least, along - contacts[i, 6] * across - contacts[i, 7] * turned)
    return least


@compiled
def line_leaves_a_side(contacts: Floats, normals: Floats, length: float, y: Floats) -> bool:
    """Whether the line through two hard contacts has the moments of all other contacts on one side.

    1. The line from one hard contact to another, both without torsion, so that their own moments about it are zero.
    2. Every other contact must give a positive moment about it, with all its friction.
    3. The moment about that line as a wrench about the origin of the frame, at length 1.

    Args:
        contacts: (k, 2 d + 2).
        normals: (k, d) of length 1.
        length: spread of the points.
        y: (m,) out: then the moment about the line, of length 1 in the frame of the points.
    """
    if len(y) == 3:
        return False
    u = np.empty(3)
    for at in range(len(contacts)):  # 1
        for to in range(len(contacts)):
            if at == to or contacts[at, 7] > 0.0 or contacts[to, 7] > 0.0:
                continue
            for c in range(3):
                u[c] = contacts[to, c] - contacts[at, c]
            size = np.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
            if not size > ASIDE * length:
                continue
            for c in range(3):
                u[c] /= size
            if not moment_aside(contacts, normals, u, at, to) > ASIDE * length:  # 2
                continue
            x, b, z = contacts[at, 0], contacts[at, 1], contacts[at, 2]  # 3
            y[0], y[1], y[2] = u[0], u[1], u[2]
            y[3], y[4], y[5] = b * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - b * u[0]
            unit(y)
            return True
    return False


@compiled
def unit(y: Floats) -> None:
    """Make a vector one of length 1."""
    square = 0.0
    for c in range(len(y)):
        square += y[c] * y[c]
    for c in range(len(y)):
        y[c] /= np.sqrt(square)


@compiled
def apart(
    dimension: Dimension,
    contacts: Floats,
    P: Placement,
    length: float,
    count: int,
    y: Floats,
    T: Tableau,
) -> int:
    """What is left of a no that the simplex method gave: OPEN with a certificate in the frame of the points, or doubt.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        contacts: (k, 2 d + 2).
        P, length: from `arrange`.
        count: columns that the program had.
        y: (m,) out.
        T: as the program left it.
    """
    m, d, middle = len(y), len(P.middle), P.middle
    if not stands_apart(dimension, P.discs * T.rows, count, y, T):  # 4
        return OPEN if line_leaves_a_side(contacts, P.normals, length, y) else DOUBTFUL
    for c in range(m - d):  # 5: the moment about the middle over the spread, as a wrench about the origin
        y[c] /= length
    if d == 2:
        y[1] += middle[1] * y[0]
        y[2] -= middle[0] * y[0]
    else:
        y[3] += middle[1] * y[2] - middle[2] * y[1]
        y[4] += middle[2] * y[0] - middle[0] * y[2]
        y[5] += middle[0] * y[1] - middle[1] * y[0]
    unit(y)
    return OPEN


@compiled
def in_frame(middle: Floats, length: float, w: Floats) -> None:
    """Replace a wrench about the middle, its moment over the spread, by one about the origin of the frame."""
    if len(w) == 3:
        w[0] = w[0] * length + middle[0] * w[2] - middle[1] * w[1]
        return
    x, y, z = middle[0], middle[1], middle[2]
    w[0] = w[0] * length + y * w[5] - z * w[4]
    w[1] = w[1] * length + z * w[3] - x * w[5]
    w[2] = w[2] * length + x * w[4] - y * w[3]


@compiled
def contact_span(
    dimension: Dimension,
    contacts: Floats,
    circle: Floats,
    weights: Floats,
    doubt: float,
    columns: Floats,
    x: Floats,
    y: Floats,
) -> tuple[int, int]:
    """The verdict on one grasp.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        contacts: (k, 2 d + 2).
        circle: (edges, 2) cosines and sines of the points on each rim to begin with.
        weights, doubt: as in `positive_span_loops.span`.
        columns: (k (edges + ROUNDS), m) out: wrenches in the frame of the points, one a row; of a yes those that its
            proof uses.
        x: (as many,) out: their weights > 0, sum 1, with which they are zero, if SPANS.
        y: (m,) out: the certificate in the frame of the points, if OPEN.

    Returns:
        SPANS, OPEN or DOUBTFUL, and the number of columns.
    """
    m, k, d = len(dimension), len(contacts), contacts.shape[1] // 2 - 1
    P, T = make_placement(k, d, m, len(circle)), make_tableau(m, len(x))
    length = arrange(contacts, circle, P)  # 1, 2
    verdict, count = span(dimension, P.rim, P.discs, P.more, weights, doubt, x, y, T)  # 3
    if verdict == OPEN:
        verdict = apart(dimension, contacts, P, length, count, y, T)  # 4, 5
    first, used = P.rim.shape[1], 0
    for j in range(count if verdict == SPANS else first):  # 5
        if verdict == SPANS and not x[j] > 0.0:
            continue
        for c in range(m):
            columns[used, c] = P.rim[c, j] if j < first else P.more[c, j - first]
        in_frame(P.middle, length, columns[used])
        x[used] = x[j]
        used += 1
    return verdict, used


@compiled
def contact_spans(
    dimension: Dimension,
    contacts: Floats,
    circle: Floats,
    weights: Floats,
    doubt: float,
    forces: Floats,
    torsions: Floats,
    y: Floats,
    verdict: NDArray[np.int8],
) -> None:
    """The verdict on each grasp of a batch.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        contacts: (b, k, 2 d + 2).
        circle, weights, doubt: as in `contact_span`.
        forces: (b, k, d) out: balanced forces strictly inside the cones, total push 1, in the axes of the body, if
            SPANS.
        torsions: (b, k) out: the moments about the normals that belong to them.
        y: (b, m) out: certificates, if OPEN.
        verdict: (b,) out.
    """
    m, k, d = len(dimension), contacts.shape[1], contacts.shape[2] // 2 - 1
    P, x = make_placement(k, d, m, len(circle)), np.empty(k * (len(circle) + ROUNDS))
    T, sums = make_tableau(m, len(x)), np.empty((k, m))
    for b in range(len(contacts)):
        length = arrange(contacts[b], circle, P)  # 1, 2
        state, count = span(dimension, P.rim, P.discs, P.more, weights, doubt, x, y[b], T)  # 3
        if state == OPEN:
            state = apart(dimension, contacts[b], P, length, count, y[b], T)  # 4, 5
        if state == SPANS:
            contact_sums(x, P, count, T, sums)  # 5
            at_contacts(contacts[b], P, length, sums, forces[b], torsions[b])
        verdict[b] = state


@compiled
def contact_sums(x: Floats, P: Placement, count: int, T: Tableau, sums: Floats) -> None:
    """The weighted sum of the columns of each contact.

    Args:
        x: (count,) weights.
        P: columns `rim` and `more`.
        count: of all columns.
        T: knows to which contact each of `more` belongs.
        sums: (k, m) out.
    """
    first, (k, m) = P.rim.shape[1], sums.shape
    sums[:] = 0.0
    for j in range(first):
        for c in range(m):
            sums[j // (first // k), c] += x[j] * P.rim[c, j]
    for j in range(first, count):
        if x[j] > 0.0:
            for c in range(m):
                sums[T.owner[j], c] += x[j] * P.more[c, j - first]


@compiled
def at_contacts(contacts: Floats, P: Placement, length: float, sums: Floats, forces: Floats, torsions: Floats) -> None:
    """Wrenches of contacts as forces, and as the couples along the normals that these do not explain.

    Args:
        contacts: (k, 2 d + 2).
        P, length: from `arrange`.
        sums: (k, m) in their coordinates; destroyed.
        forces, torsions: (k, d), (k,) out.
    """
    d = len(P.middle)
    for i in range(len(contacts)):
        w = sums[i]
        in_frame(P.middle, length, w)
        for c in range(d):
            forces[i, c] = w[len(w) - d + c]
        torsions[i] = 0.0
        for a in range(3 if contacts[i, 2 * d + 1] > 0.0 else 0):
            b, c = (a + 1) % 3, (a + 2) % 3
            torsions[i] += (w[a] - contacts[i, b] * w[3 + c] + contacts[i, c] * w[3 + b]) * P.normals[i, a]
