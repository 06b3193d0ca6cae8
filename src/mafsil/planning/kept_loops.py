"""What a motion of the joints keeps, such as a tool upright: measured, projected onto, proved along motions; compiled.

A row of a constraint is a vector e(q): a point of a link, or a direction fixed in a link, less where it should be, in
{s}. Rows of one group are measured together, g = |P e|, and the constraint is g <= limit. Along a straight motion of
the joints over 0..1

    |e''| <= sum_i sum_j |dq_i| |dq_j| lever(the outer of i and j) = B    (i: the inner joint turns)

for the derivative of a point by two joints is the inner joint's axis times the derivative by the outer one, no longer
than that joint's reach; of a direction it is at most 1. So e leaves the chord between its ends by at most B / 8, and
for g is convex it is nowhere more than max(g(0), g(1)) + B / 8. Halves of the motion have a quarter of B.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.workshop_loops import Kinematics, state_along
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.lanes import call_kernel
from mafsil.kernels.loops.loop import compiled

POINT, AXIS = range(2)
NEWTON = 25
"""Steps of a projection at most."""
HALVES = 12
"""How often a motion is halved before what it keeps counts as not proved."""
DAMPING = 1e-12
FINE = 0.02
"""Share of a limit by which a bound that is shown may lie above what is measured."""


class Kept(NamedTuple):
    """Constraints as arrays: m rows of k groups, j joints.

    Attributes:
        rows: (m, 19) POINT or AXIS, link, other link or -1, its group, the vector in the link (3), in {s} or in the
            other link where it should be (3), what counts of the difference: a projector (9), row by row.
        limit: (k,) of g.
        aim: (k,) what a projection brings g to.
        bend: (k,) factor of B for a group of directions.
        joints: (j, 8) as `collision.segment_loops.Motion`, the pitch with its sign.
        moves: (2 m, j) whether a joint moves the row's link (2 r) and its other one (2 r + 1).
        reach: (2 m, j) furthest their points get from the joint's axis [m].
        stretch: (2 m, j, n) what that grows by per coordinate of a sliding joint between.
        lower, upper: (n,) limits of the coordinates; equal ones stay.
    """

    rows: Floats
    limit: Floats
    aim: Floats
    bend: Floats
    joints: Floats
    moves: NDArray[np.bool_]
    reach: Floats
    stretch: Floats
    lower: Floats
    upper: Floats


class Sheet(NamedTuple):
    """Arrays to work in; `sheet_for` makes them.

    Attributes:
        e: (m, 3) differences.
        g, h: (k,) measures.
        b: (k,) bounds B.
        J: (3 m, n) derivatives.
        A: (3 m, 3 m + 1) equations of a step.
        rates: (j,) |dq| of each joint.
        q: (3, n).
        stack: (2 HALVES + 2, 2 + 2 k) intervals that wait.
        unread: (k,) bounds that nobody asked for.
    """

    e: Floats
    g: Floats
    h: Floats
    b: Floats
    J: Floats
    A: Floats
    rates: Floats
    q: Floats
    stack: Floats
    unread: Floats


@compiled
def sheet_for(kept: Kept) -> Sheet:
    """Arrays for one thread."""
    m, k, n = len(kept.rows), len(kept.limit), len(kept.lower)
    return Sheet(
        np.zeros((m, 3)), np.zeros(k), np.zeros(k), np.zeros(k), np.zeros((3 * m, n)), np.zeros((3 * m, 3 * m + 1)),
        np.zeros(len(kept.joints)), np.zeros((3, n)), np.zeros((2 * HALVES + 2, 2 + 2 * k)), np.zeros(k),
    )  # fmt: skip


@compiled
def _where(row: Floats, poses: Floats, link: int, first: int, c: int) -> float:
    """Coordinate c in {s} of a row's vector, given in a link from column `first` on."""
    T = poses[link]
    value = T[c, 0] * row[first] + T[c, 1] * row[first + 1] + T[c, 2] * row[first + 2]
    return value + T[c, 3] if row[0] == POINT else value


@compiled
def measure(kept: Kept, poses: Floats, e: Floats, g: Floats) -> None:
    """Differences (m, 3) and measures (k,) of one state, in `e` and `g`."""
    for k in range(len(g)):
        g[k] = 0.0
    for r in range(len(kept.rows)):
        row = kept.rows[r]
        link, other = int(row[1]), int(row[2])
        x = _where(row, poses, link, 4, 0) - (row[7] if other < 0 else _where(row, poses, other, 7, 0))
        y = _where(row, poses, link, 4, 1) - (row[8] if other < 0 else _where(row, poses, other, 7, 1))
        z = _where(row, poses, link, 4, 2) - (row[9] if other < 0 else _where(row, poses, other, 7, 2))
        for c in range(3):
            e[r, c] = row[10 + 3 * c] * x + row[11 + 3 * c] * y + row[12 + 3 * c] * z
        g[int(row[3])] += e[r, 0] * e[r, 0] + e[r, 1] * e[r, 1] + e[r, 2] * e[r, 2]
    for k in range(len(g)):
        g[k] = np.sqrt(g[k])


@compiled
def measure_at(kept: Kept, kinematics: Kinematics, a: Floats, b: Floats, t: float, e: Floats, g: Floats) -> None:
    """`measure` at share t of the motion from a to b."""
    state_along(kinematics, a, b, t, 0)
    kinematics.rows[0] = 1
    call_kernel(kinematics.entry, kinematics.arguments, kinematics.number, kinematics.strides)
    measure(kept, kinematics.poses[0], e, g)


@compiled
def _derivatives(kept: Kept, poses: Floats, J: Floats) -> None:
    """(3 m, n) derivatives of the differences, in `J`.

    1. Where the vector stands, of the row's link and of the other one, whose part counts negative.
    2. A joint that moves the link turns it about its axis u: u x (p - o) for a point, u x d for a direction; a sliding
       joint moves points along u, a helical one both.
    3. What counts of it, in the column of the joint's coordinate.
    """
    for i in range(J.shape[0]):
        for c in range(J.shape[1]):
            J[i, c] = 0.0
    for r in range(len(kept.rows)):
        row = kept.rows[r]
        for part in range(2):
            link = int(row[1 + part])
            if link < 0:
                continue
            # 1.
            sign, first = (1.0, 4) if part == 0 else (-1.0, 7)
            x, y, z = (
                _where(row, poses, link, first, 0),
                _where(row, poses, link, first, 1),
                _where(row, poses, link, first, 2),
            )
            for j in range(len(kept.joints)):
                joint = kept.joints[j]
                column = int(joint[1])
                if not kept.moves[2 * r + part, j] or kept.lower[column] == kept.upper[column]:
                    continue
                T = poses[int(joint[0])]
                # 2.
                ux = T[0, 0] * joint[5] + T[0, 1] * joint[6] + T[0, 2] * joint[7]
                uy = T[1, 0] * joint[5] + T[1, 1] * joint[6] + T[1, 2] * joint[7]
                uz = T[2, 0] * joint[5] + T[2, 1] * joint[6] + T[2, 2] * joint[7]
                dx, dy, dz = x, y, z
                if row[0] == POINT:
                    dx, dy, dz = x - T[0, 3], y - T[1, 3], z - T[2, 3]
                vx, vy, vz = uy * dz - uz * dy, uz * dx - ux * dz, ux * dy - uy * dx
                if joint[3] == 0.0:
                    still = row[0] == AXIS
                    vx, vy, vz = (0.0, 0.0, 0.0) if still else (ux, uy, uz)
                elif row[0] == POINT:
                    vx, vy, vz = vx + joint[4] * ux, vy + joint[4] * uy, vz + joint[4] * uz
                # 3.
                rate = sign * joint[2]
                for c in range(3):
                    along = row[10 + 3 * c] * vx + row[11 + 3 * c] * vy + row[12 + 3 * c] * vz
                    J[3 * r + c, column] += rate * along


@compiled
def _solve(A: Floats, size: int) -> None:
    """The solution of `size` symmetric positive definite equations, in the last column of `A` (Cholesky)."""
    for i in range(size):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            A[i, j] = np.sqrt(max(total, LEAST_DIVISOR)) if i == j else total / A[j, j]
    for i in range(size):
        total = A[i, size]
        for k in range(i):
            total -= A[i, k] * A[k, size]
        A[i, size] = total / A[i, i]
    for i in range(size - 1, -1, -1):
        total = A[i, size]
        for k in range(i + 1, size):
            total -= A[k, i] * A[k, size]
        A[i, size] = total / A[i, i]


@compiled
def project(kept: Kept, kinematics: Kinematics, q: Floats, sheet: Sheet) -> bool:
    """Bring a configuration to where all constraints are kept, in place, by the shortest steps; whether that succeeded.

    1. Groups within their aim ask for nothing; the others for what is beyond it.
    2. The smallest change of the joints that gives that to first order: dq = J' (J J' + damping)^-1 e.
    3. Coordinates stay within their limits.
    """
    size, n = 3 * len(kept.rows), len(q)
    for _ in range(NEWTON):
        measure_at(kept, kinematics, q, q, 0.0, sheet.e, sheet.g)
        beyond = False
        for k in range(len(sheet.g)):
            beyond = beyond or not sheet.g[k] <= kept.aim[k]
        if not beyond:
            return True
        _derivatives(kept, kinematics.poses[0], sheet.J)
        for r in range(len(kept.rows)):  # 1
            k = int(kept.rows[r, 3])
            share = 1.0 - 0.9 * kept.aim[k] / sheet.g[k] if sheet.g[k] > kept.aim[k] else 0.0
            for c in range(3):
                sheet.A[3 * r + c, size] = share * sheet.e[r, c]
                for column in range(n):
                    sheet.J[3 * r + c, column] *= 1.0 if share > 0.0 else 0.0
        trace = 0.0
        for i in range(size):  # 2
            for j in range(i + 1):
                total = 0.0
                for c in range(n):
                    total += sheet.J[i, c] * sheet.J[j, c]
                sheet.A[i, j] = total
            trace += sheet.A[i, i]
        for i in range(size):
            sheet.A[i, i] += DAMPING * (1.0 + trace)
        _solve(sheet.A, size)
        for c in range(n):
            change = 0.0
            for i in range(size):
                change -= sheet.J[i, c] * sheet.A[i, size]
            q[c] = min(max(q[c] + change, kept.lower[c]), kept.upper[c])  # 3
    return False


@compiled
def bends(kept: Kept, a: Floats, b: Floats, sheet: Sheet) -> None:
    """The bounds B of each group for the motion from a to b, in `sheet.b`.

    1. How far each joint goes.
    2. From the inner joints outwards: the lever of each times its way, times twice the ways of those before that turn
       and once its own.
    3. Points of a group add up; directions of one frame all turn alike.
    """
    for k in range(len(sheet.b)):
        sheet.b[k] = 0.0
    for j in range(len(kept.joints)):  # 1
        joint = kept.joints[j]
        sheet.rates[j] = abs(joint[2] * (b[int(joint[1])] - a[int(joint[1])]))
    for r in range(len(kept.rows)):
        row = kept.rows[r]
        k, both = int(row[3]), 0.0
        for part in range(2):
            if row[1 + part] < 0.0:
                continue
            turned, total = 0.0, 0.0
            for j in range(len(kept.joints)):  # 2
                if not kept.moves[2 * r + part, j] or sheet.rates[j] == 0.0:
                    continue
                joint, lever = kept.joints[j], 1.0
                turns = joint[3] != 0.0
                if row[0] == POINT and turns:
                    lever = kept.reach[2 * r + part, j] + abs(joint[4])
                    for c in range(len(a)):
                        lever += kept.stretch[2 * r + part, j, c] * max(abs(a[c]), abs(b[c]))
                elif row[0] == AXIS and not turns:
                    continue
                own = sheet.rates[j] if turns else 0.0
                total += lever * sheet.rates[j] * (2.0 * turned + own)
                turned += own
            both += total
        if row[0] == POINT:  # 3
            sheet.b[k] += both
        else:
            sheet.b[k] = max(sheet.b[k], kept.bend[k] * both)


@compiled
def _largest(
    kept: Kept, kinematics: Kinematics, a: Floats, b: Floats, slack: float, fine: float, sheet: Sheet, worst: Floats
) -> bool:  # fmt: skip
    """Whether a motion keeps share `slack` of all limits, by a proof; what it proved of each group is in `worst`.

    1. An interval is done where max(g at its ends) + B / 8 is within the limits, and B / 8 within share `fine` of them.
    2. Else its middle is measured; beyond the limits there ends it; it is halved.
    """
    groups, stack = len(kept.limit), sheet.stack
    bends(kept, a, b, sheet)
    measure_at(kept, kinematics, a, b, 0.0, sheet.e, sheet.g)
    measure_at(kept, kinematics, a, b, 1.0, sheet.e, sheet.h)
    stack[0, 0], stack[0, 1] = 0.0, 1.0
    for k in range(groups):
        stack[0, 2 + k], stack[0, 2 + groups + k] = sheet.g[k], sheet.h[k]
        if not max(sheet.g[k], sheet.h[k]) <= slack * kept.limit[k]:
            return False
    waiting = 1
    while waiting > 0:
        waiting -= 1
        begin, width, done = stack[waiting, 0], stack[waiting, 1], True
        for k in range(groups):  # 1
            more = sheet.b[k] * width * width / 8.0
            bound = max(stack[waiting, 2 + k], stack[waiting, 2 + groups + k]) + more
            done = done and bound <= slack * kept.limit[k] and more <= fine * kept.limit[k]
        if done:
            for k in range(groups):
                bound = max(stack[waiting, 2 + k], stack[waiting, 2 + groups + k]) + sheet.b[k] * width * width / 8.0
                worst[k] = max(worst[k], bound)
            continue
        if width <= 2.0**-HALVES:
            return False
        measure_at(kept, kinematics, a, b, begin + width / 2.0, sheet.e, sheet.g)  # 2
        for k in range(groups):
            if not sheet.g[k] <= slack * kept.limit[k]:
                return False
            stack[waiting + 1, 2 + k], stack[waiting + 1, 2 + groups + k] = stack[waiting, 2 + k], sheet.g[k]
            stack[waiting, 2 + k] = sheet.g[k]
        stack[waiting + 1, 0], stack[waiting + 1, 1] = begin, width / 2.0
        stack[waiting, 0], stack[waiting, 1] = begin + width / 2.0, width / 2.0
        waiting += 2
    return True


@compiled
def keeps(kept: Kept, kinematics: Kinematics, a: Floats, b: Floats, slack: float, sheet: Sheet) -> bool:
    """Whether a straight motion of the joints is proved to keep share `slack` of all limits."""
    return _largest(kept, kinematics, a, b, slack, 1.0, sheet, sheet.unread)


@compiled
def kept_along(kept: Kept, kinematics: Kinematics, A: Floats, B: Floats, worst: Floats) -> int:
    """How many of straight motions (m, n) to (m, n), from the first on, are proved to keep everything.

    Args:
        worst: (k,) out: largest measure that the proof leaves possible.
    """
    sheet = sheet_for(kept)
    for k in range(len(A)):
        if not _largest(kept, kinematics, A[k], B[k], 1.0, FINE, sheet, worst):
            return k
    return len(A)


@compiled
def measure_constraints(kept: Kept, kinematics: Kinematics, q: Floats) -> Floats:
    """(m, k) measures of configurations (m, n)."""
    sheet, out = sheet_for(kept), np.empty((len(q), len(kept.limit)))
    for r in range(len(q)):
        measure_at(kept, kinematics, q[r], q[r], 0.0, sheet.e, out[r])
    return out


@compiled
def project_to_constraints(kept: Kept, kinematics: Kinematics, q: Floats, done: NDArray[np.bool_]) -> None:
    """Configurations (m, n) brought to where all constraints are kept, in place; (m,) out: which are."""
    sheet = sheet_for(kept)
    for r in range(len(q)):
        done[r] = project(kept, kinematics, q[r], sheet)
