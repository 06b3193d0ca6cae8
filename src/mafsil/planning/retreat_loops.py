"""Ways out of where the tools of an arm are, compiled: configurations a little back, up, or nearer to the arm's base.

Most arms reach into a place along their tool, and leave it the same way. So before a search draws samples it looks at
eight configurations in which each tool has gone back without turning, as the Jacobian has it:

1. The joints' axes at the configuration from one call of the kernel, a coordinate in each lane.
2. Per limb the directions of `_find_directions`, and the rates of its joints for each: J' (J J' + mu I)^-1 of the
   motion that does not rotate, lengths in units of the limb's reach, about the middle of the tool's body.
3. Eight sums of these, as `SUMS` says, added to the configuration and brought within bounds.

What the joints cannot do of a direction is left out. Nothing here is exact, or needs to be: what comes out are samples.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.workshop_loops import Kinematics
from mafsil.kernels.loops.lanes import WIDTH, call_lanes, get, lanes, part, put, seen
from mafsil.kernels.loops.loop import compiled
from mafsil.solvers.cholesky_loops import factor, solve

END, TOOL, BEFORE, ROLL, SHOULDER = range(5)
"""Columns of `Limbs.parts`."""
BACK, INWARD, UP = range(3)
"""Directions a tool can go: back along itself, nearer to the axis of the shoulder, against gravity."""
SUMS = np.array([
    [0.25, 0.0, 0.0], [0.12, 0.12, 0.12], [0.0, 0.0, 0.5], [0.24, 0.24, 0.24],
    [0.2, 0.0, 0.2], [0.0, 0.2, 0.2], [0.14, 0.14, 0.0], [0.1, 0.0, 0.0],
])  # fmt: skip
"""(WIDTH, 3) how far in each direction, as shares of the limb's reach."""
DAMPING = 1e-3
"""mu above: what would take joints further than some radians is done in part."""
ALONG = 0.7
"""Cosine beyond which the axis of the last joint that turns is where a tool points."""


class Limbs(NamedTuple):
    """Limbs whose tools can go back, and room to find how.

    Attributes:
        kinematics: the kernels of the arm, for one thread.
        joints: as in `Motion`.
        parts: (m, 5) the joint that carries the limb's END, its TOOL's body, a body BEFORE the tool or -1, coordinates
            of the joint about which the tool ROLLs and of the SHOULDER or -1.
        own: (m, n) coordinates of the limb.
        reach: (m,) how far it reaches [m], above zero.
        up: (3,) direction against gravity; zero where there is none.
        twists: (m, n, 6) of the END per unit of each coordinate, about the origin of {s}.
        rates: (3, n) of the coordinates, for one reach in each direction.
        directions: (3, 3) in rows.
        arm: (3,) from the tool to the axis of its shoulder.
        J: (n, 6) twists about the middle of the tool's body, of the coordinates that move; lengths in reaches.
        A: (6, 6), b: (6,) of the equations.
    """

    kinematics: Kinematics
    joints: Floats
    parts: NDArray[np.int64]
    own: NDArray[np.bool_]
    reach: Floats
    up: Floats
    twists: Floats
    rates: Floats
    directions: Floats
    arm: Floats
    J: Floats
    A: Floats
    b: Floats


def room_for(
    kinematics: Kinematics, joints: Floats, parts: NDArray[np.int64], own: NDArray[np.bool_], reach: Floats, up: Floats
) -> Limbs:
    """The limbs with fresh arrays to work in."""
    m, n = own.shape
    return Limbs(
        kinematics, joints, parts, own, reach, up, np.zeros((m, n, 6)), np.zeros((3, n)), np.zeros((3, 3)), np.zeros(3),
        np.zeros((n, 6)), np.zeros((6, 6)), np.zeros(6),
    )  # fmt: skip


@compiled
def retreats(limbs: Limbs, q: Floats, bounds: Floats, out: Floats) -> bool:
    """Configurations in which the tools have gone back, (WIDTH, n) out; whether any does.

    Args:
        limbs: of the arm.
        q: (n,) where the tools are.
        bounds: (2, n) lowest and highest coordinates; where they are the same a coordinate stays.
        out: a row for each of `SUMS`.
    """
    for lane in range(WIDTH):
        for c in range(len(q)):
            out[lane, c] = q[c]
    if len(limbs.parts) == 0:
        return False
    _find_twists(limbs, q)  # 1
    some = False
    for limb in range(len(limbs.parts)):
        if _find_rates(limbs, limb, bounds):  # 2
            some = True
            for lane in range(WIDTH):  # 3
                for k in range(3):
                    for c in range(len(q)):
                        out[lane, c] += SUMS[lane, k] * limbs.rates[k, c]
    for lane in range(WIDTH):
        for c in range(len(q)):
            out[lane, c] = min(max(out[lane, c], bounds[0, c]), bounds[1, c])
    return some


@compiled
def _find_twists(limbs: Limbs, q: Floats) -> None:
    """Twists of the ends per unit of each coordinate; the centres of all bodies (step 1)."""
    kinematics, joints = limbs.kinematics, limbs.joints
    given, twists = seen(kinematics.q_lanes), seen(kinematics.twists)
    for c in range(len(q)):
        given[c] = lanes(q[c])
    for first in range(0, len(q), WIDTH):
        for j in range(len(joints)):
            given[len(q) + j] = lanes(0.0)
            column = int(joints[j, 1])
            if first <= column < first + WIDTH:
                put(given, len(q) + j, column - first, joints[j, 2])
        call_lanes(kinematics.in_motion, kinematics.q_address, kinematics.motion_address)
        for limb in range(len(limbs.parts)):
            end = part(twists, 6 * (limbs.parts[limb, END] + 1))
            for c in range(first, min(first + WIDTH, len(q))):
                for i in range(6):
                    limbs.twists[limb, c, i] = get(end, i, c - first)


@compiled
def _find_rates(limbs: Limbs, limb: int, bounds: Floats) -> bool:
    """Rates of a limb's coordinates for each direction of its tool; whether any of them moves (step 2).

    1. The Jacobian about the middle of the tool's body.
    2. J J' + mu I factored.
    3. Rates for each direction.
    """
    J, A, b, n = limbs.J, limbs.A, limbs.b, limbs.own.shape[1]
    middle = part(seen(limbs.kinematics.balls), 3 * limbs.parts[limb, TOOL])
    x, y, z = get(middle, 0, 0), get(middle, 1, 0), get(middle, 2, 0)
    if not _take_columns(limbs, limb, bounds, x, y, z):  # 1
        return False
    for i in range(6):  # 2
        for k in range(i + 1):
            total = DAMPING if i == k else 0.0
            for c in range(n):
                total += J[c, i] * J[c, k]
            A[i, k] = total
    if not factor(A, 6):
        return False
    _find_directions(limbs, limb, x, y, z)
    for k in range(3):  # 3
        for i in range(3):
            b[i], b[3 + i] = 0.0, limbs.directions[k, i]
        solve(A, 6, b)
        for c in range(n):
            rate = 0.0
            for i in range(6):
                rate += J[c, i] * b[i]
            limbs.rates[k, c] = rate
    return True


@compiled
def _take_columns(limbs: Limbs, limb: int, bounds: Floats, x: float, y: float, z: float) -> bool:
    """The Jacobian of a limb about a point, zero for what stays; whether any coordinate moves."""
    J, some, reach = limbs.J, False, limbs.reach[limb]
    for c in range(limbs.own.shape[1]):
        moves, w = limbs.own[limb, c] and bounds[0, c] < bounds[1, c], limbs.twists[limb, c]
        some |= moves
        for i in range(3):
            J[c, i] = w[i] if moves else 0.0
        J[c, 3] = (w[3] + w[1] * z - w[2] * y) / reach if moves else 0.0
        J[c, 4] = (w[4] + w[2] * x - w[0] * z) / reach if moves else 0.0
        J[c, 5] = (w[5] + w[0] * y - w[1] * x) / reach if moves else 0.0
    return some


@compiled
def _find_directions(limbs: Limbs, limb: int, x: float, y: float, z: float) -> None:
    """Unit vectors of the ways a tool whose body is about (x, y, z) can go; zero for one that is none.

    1. Back: along the axis about which it rolls, if that is where it points seen from the body before; else straight
       towards that body.
    2. Inward: square to the axis of the shoulder.
    """
    before, roll, shoulder = limbs.parts[limb, BEFORE], limbs.parts[limb, ROLL], limbs.parts[limb, SHOULDER]
    back, inward, arm = limbs.directions[BACK], limbs.directions[INWARD], limbs.arm
    for i in range(3):
        back[i], inward[i], limbs.directions[UP, i] = 0.0, 0.0, limbs.up[i]
    if before >= 0:  # 1
        other = part(seen(limbs.kinematics.balls), 3 * before)
        back[0], back[1], back[2] = get(other, 0, 0) - x, get(other, 1, 0) - y, get(other, 2, 0) - z
        _to_unit(back)
        if roll >= 0:
            axis = limbs.twists[limb, roll]
            along = axis[0] * back[0] + axis[1] * back[1] + axis[2] * back[2]
            if abs(along) > ALONG:
                for i in range(3):
                    back[i] = axis[i] if along > 0.0 else -axis[i]
    if shoulder >= 0:  # 2
        w = limbs.twists[limb, shoulder]
        arm[0] = w[1] * w[5] - w[2] * w[4] - x
        arm[1] = w[2] * w[3] - w[0] * w[5] - y
        arm[2] = w[0] * w[4] - w[1] * w[3] - z
        along = arm[0] * w[0] + arm[1] * w[1] + arm[2] * w[2]
        for i in range(3):
            inward[i] = arm[i] - along * w[i]
        _to_unit(inward)


@compiled
def _to_unit(v: Floats) -> None:
    """A vector of length one in place of another; one of no length stays."""
    length = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if length > 0.0:
        for i in range(3):
            v[i] /= length
