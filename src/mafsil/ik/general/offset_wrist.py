"""Arms whose wrist is offset: axes 2 and 3 are parallel, axes 4 and 5 meet, and the last one passes them by.

The last joint moves the point w where axes 4 and 5 meet, and the direction z of axis 5. At a value of it

1. joint 1 takes the plane of axes 2 and 3 to w: two ways, the roots of rho^2 = D;
2. axis 4 lies in it, or makes its angle with it, and makes that of the wrist with z: two ways again;
3. the elbow has its length where F = 0, which is one equation for the last joint.

The product of F over the four ways is free of roots. Its denominator is known, and what is left is a trigonometric
polynomial of the last joint, of degree eight; where F is the same on both sides of the shoulder (no offset of it and of
the forearm), of degree four, each of whose zeros gives two solutions. Zeros that are isolated with a proof, each the
last joint of its own solutions, prove a list; elimination takes what is not proven.

Reference: Abbes and Poisson, Geometric approach for inverse kinematics of the FANUC CRX collaborative robot, 2024, for
the search over the last joint of one arm of the kind.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3
from mafsil.ik.chain import Chain, meeting_point
from mafsil.ik.general.elimination import fourier_columns
from mafsil.ik.general.findings import Findings, loop_frames
from mafsil.ik.tolerances import EXACT_POSE, SLIGHT, WELL_POSED
from mafsil.kernels.loops.loop import hold
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.general.circle_loops as circle_loops
    import mafsil.ik.general.offset_list_loops as offset_list_loops
    import mafsil.ik.general.offset_wrist_loops as offset_wrist_loops
else:
    circle_loops = lazily("mafsil.ik.general.circle_loops")
    offset_list_loops = lazily("mafsil.ik.general.offset_list_loops")
    offset_wrist_loops = lazily("mafsil.ik.general.offset_wrist_loops")


class ProvenLists(NamedTuple):
    """Solutions of many poses, one after the other.

    Attributes:
        q, error: (m, 6) and (m,) solutions and their errors in the loop [rad, unit of length].
        rows: (m,) which pose each belongs to.
        counts: (k,) solutions of each pose; -1 where nothing is proven.
    """

    q: JointVector
    error: Floats
    rows: NDArray[np.int64]
    counts: NDArray[np.int64]


class OffsetWrist:
    """The polynomial of the last joint of one arm, and the way back from its zeros.

    Attributes:
        symmetric: whether each zero gives two solutions, one on either side of the shoulder.
        degree: of the polynomial.
    """

    def __init__(self, loop: Chain, seen: Chain, placing: tuple[PoseMatrix, Floats, float]) -> None:
        numbers, vectors, self.symmetric = _dimensions(seen)
        self.degree = 4 if self.symmetric else 8
        fourier = fourier_columns(self.degree)
        angle = 2 * np.pi / len(fourier) * np.arange(len(fourier))
        order = np.arange(5, -1, -1) if seen.reversed != loop.reversed else np.arange(6)
        home, middle, unit = placing
        arm = offset_wrist_loops.OffsetArm(
            home, middle, np.array([unit]), loop_frames(loop), numbers, vectors, order, bool(order[0]), self.symmetric
        )
        circle = offset_wrist_loops.Circle(
            np.cos(angle)[None], np.sin(angle)[None], fourier, self.degree, *circle_loops.harmonics(self.degree)
        )
        self._arm, self._circle = hold(arm), hold(circle)

    def solve_poses(self, T: PoseMatrix) -> ProvenLists:
        """Proven lists of poses (k, 4, 4) of the tip, one after the other."""
        return self._solve(offset_list_loops.solve_poses, T)

    def take(self, found: Findings) -> None:
        """The proven lists of the poses of a batch."""
        lists = self._solve(offset_list_loops.solve_loops, found.P)
        found.proof, found.count = lists.counts >= 0, np.maximum(lists.counts, 0)
        place = np.arange(len(lists.q)) - (np.cumsum(found.count) - found.count)[lists.rows]
        found.q[lists.rows, place], found.size[lists.rows, place] = lists.q, lists.error
        found.attempts += 1

    def _solve(self, solve: Callable[..., int], poses: PoseMatrix) -> ProvenLists:
        room = 16 * len(poses) + 8
        q, error, rows = np.empty((room, 6)), np.empty(room), np.empty(room, dtype=np.int64)
        count = np.empty(len(poses), dtype=np.int64)
        total = solve(self._arm, self._circle, poses, q, error, rows, count)
        return ProvenLists(q[:total], error[:total], rows[:total], count)


def offset_wrist(loop: Chain, placing: tuple[PoseMatrix, Floats, float]) -> OffsetWrist | None:
    """The way of such an arm, seen from its base or from its tip; None where it is none.

    Args:
        loop: the arm about an origin of its own, in a unit of its own.
        placing: inverse of the tip's home pose, that origin, and that unit.
    """
    for seen in (loop, loop.backwards()):
        if not any(loop.prismatic) and _is_offset(seen):
            return OffsetWrist(loop, seen, placing)
    return None


def _is_offset(chain: Chain) -> bool:
    """Whether axes 2 and 3 are parallel, axes 4 and 5 meet, and no other pair that must differ is parallel."""
    axes, points = chain.axes, chain.points
    sines = [float(np.linalg.norm(np.cross(axes[k], axes[k + 1]))) for k in range(5)]
    apart = points[2] - points[1]
    elbow = np.linalg.norm(apart - (apart @ axes[1]) * axes[1])
    if sines[1] > EXACT_POSE or min(sines[0], sines[2], sines[3], float(elbow)) < WELL_POSED:
        return False
    return meeting_point(axes[3], points[3], axes[4], points[4])[1] <= EXACT_POSE


def _dimensions(chain: Chain) -> tuple[Floats, Floats, bool]:
    """Numbers and (12, 3) vectors as `OffsetArm` has them, and whether both sides of the shoulder are alike."""
    axes: list[Vector3] = list(chain.axes)
    points: list[Vector3] = list(chain.points)
    e, y, _, z4, z5, axis = axes
    r1, r2, r3, r4, r5, centre = points
    w = meeting_point(z4, r4, z5, r5)[0]
    # The frame of the shoulder: n along the common normal of axes 1 and 2, t in the plane that y is normal to.
    normal = np.cross(e, y)
    sine, cosine = float(np.linalg.norm(normal)), float(e @ y)
    n: Floats = normal / sine
    along = np.asarray(np.linalg.solve(np.stack([e, -y, normal], axis=1), r2 - r1), dtype=np.float64)
    origin: Floats = r1 + along[0] * e
    shoulder: Floats = r2 + along[1] * y
    plane: Floats = np.stack([n, np.cross(n, y)])
    forward: Floats = (y - cosine * e) / sine
    B: Floats = np.stack([forward, n, e])
    elbow: Floats = plane @ (r3 - shoulder)
    k: Floats = plane @ z4
    sine_4, length = float(np.linalg.norm(k)), float(np.linalg.norm(elbow))
    k /= sine_4
    forearm: Floats = plane @ (w - shoulder) - elbow
    v1, v2 = float(forearm @ k), float(forearm[1] * k[0] - forearm[0] * k[1])
    cosine_4, cosine_5 = float(y @ z4), float(z4 @ z5)
    x5: Floats = z4 - cosine_5 * z5
    start: Floats = np.array([z5 @ (y - cosine_4 * z4), z5 @ np.cross(z4, y)])
    sense = 1.0 if chain.axes[2] @ y > 0 else -1.0
    offset, lateral = float((shoulder - origin) @ n), float(y @ (w - shoulder))
    numbers: list[float] = [
        cosine,
        sine,
        offset,
        lateral,
        cosine_4,
        sine_4,
        cosine_5,
        v1,
        v2,
        length,
        sense,
        *k.tolist(),
        *elbow.tolist(),
        *start.tolist(),
    ]
    # Where all of these are zero, the roots of rho^2 come in no term but their squares.
    even = max(abs(cosine), abs(offset), abs(lateral), abs(cosine_4)) <= SLIGHT
    symmetric = even and (abs(v2) <= SLIGHT or (abs(v1) <= SLIGHT and abs(cosine_5) <= SLIGHT))
    parts = [_turned(w - centre, axis), _turned(z5, axis), _turned(x5 / np.linalg.norm(x5), axis)]
    parts[0][0] += centre
    return np.array(numbers), np.concatenate([*parts, B, origin[None]]), symmetric


def _turned(r: Floats, axis: Floats) -> Floats:
    """(3, 3) rows r_0, r_1, r_2: exp(-axis theta) r = r_0 + r_1 cos theta + r_2 sin theta."""
    along: Floats = (axis @ r) * axis
    return np.stack([along, r - along, -np.cross(axis, r)])
