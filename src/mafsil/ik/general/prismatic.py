"""Six joints, two or three of which are prismatic: orientation by the revolute joints, then the lengths are linear.

Three revolute joints b, c, d reach an orientation R in two ways, the roots of w_b . R_c w_d = w_b . R w_d = h.

Two prismatic joints: the first revolute joint is at theta, the others have to do the rest, R(theta). The pose is
reached where the
displacement that is left, t, lies in the plane of the prismatic joints: g = det(s_1, s_2, t) = 0. The product g_1 g_2
(1 - h^2)
over both ways, complex or not, is a trigonometric polynomial of theta of degree four: up to eight solutions.

Three prismatic joints: both ways, and three linear equations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.chain import Chain
from mafsil.ik.general.elimination import fourier_columns
from mafsil.ik.general.findings import Findings
from mafsil.ik.tolerances import REGULAR
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.general.circle_loops as circle_loops
else:
    circle_loops = lazily("mafsil.ik.general.circle_loops")

Complex = NDArray[np.complex128]

Numbers = NDArray[Any]
"""Real or complex."""

DEGREE = 4
"""Of the polynomial of two prismatic joints."""

WAYS: Floats = np.array([1.0, -1.0])
"""The two roots of joint c."""

START = 0.05
"""Where the first sample is: no angle that arms prefer."""


class TwoPrismatic:
    """An arm with two prismatic joints and four revolute joints; an elimination order for each of these."""

    def __init__(self, chain: Chain) -> None:
        self._chain = chain
        self._revolute = [k for k in range(6) if not chain.prismatic[k]]
        self._columns = fourier_columns(DEGREE)
        self._nodes = START + 2 * np.pi * np.arange(len(self._columns)) / len(self._columns)

    def __len__(self) -> int:
        return 4

    def take(self, order: int, found: Findings, rows: NDArray[np.int64]) -> None:
        """What one elimination order finds for some poses of a batch.

        Args:
            order: place of the joint theta among those that turn.
            found: is filled.
            rows: (k,) the poses.
        """
        P = found.P[rows]
        with np.errstate(all="ignore"):
            samples, apart = self._samples(P, order)
            harmonics = samples @ self._columns
            roundoff = 1.5 * np.sqrt((harmonics[:, 2 * DEGREE + 1 :] ** 2).mean(axis=1))
        zeros, number, certain = circle_loops.zeros_of(harmonics, roundoff, DEGREE)
        certain &= apart > REGULAR

        def candidates(row: NDArray[np.int64], theta: Floats, choice: int) -> tuple[Floats, Floats]:
            with np.errstate(all="ignore"):
                turns, _ = self._turns(P[row], order, theta, float(WAYS[choice]))
                return found.turns(_with_lengths(self._chain, P[row], turns)), np.zeros(len(row))

        found.explore_zeros(
            rows, (zeros + START, number, certain), candidates, [np.inf] * len(WAYS), self._revolute[order]
        )

    def _samples(self, P: PoseMatrix, order: int) -> tuple[Floats, Floats]:
        """(k, nodes) values of the polynomial, and (k,) how far the prismatic joints are from parallel at most."""
        many, theta = np.repeat(P, len(self._nodes), axis=0), np.tile(self._nodes, len(P))
        product: Complex = np.ones(len(theta), dtype=np.complex128)
        apart = np.zeros(len(theta))
        for way in WAYS:
            turns, lost = self._turns(many, order, theta, float(way))
            S, t = _left_over(self._chain, many, turns)
            normal = np.cross(S[:, 0], S[:, 1])
            apart = np.maximum(apart, np.abs(normal).max(axis=1))
            product = product * (normal * t).sum(axis=1) * (lost if way < 0 else 1.0)
        values = np.ascontiguousarray(np.real(product).reshape(len(P), -1))
        return values, apart.reshape(len(P), -1).max(axis=1)

    def _turns(self, P: PoseMatrix, order: int, theta: Floats, way: float) -> tuple[dict[int, Numbers], Floats]:
        """Cosines and sines (m, 2) of each revolute joint, and 1 - h^2.

        Joints before theta act as if they were after the last, about axes that the pose has moved: R_0 R_1 = R is
        R_1 R_0' = R with the axis R'w_0.
        """
        R, joints = P[:, :3, :3], self._revolute[order:] + self._revolute[:order]
        w = [self._chain.axes[k] if k >= joints[0] else self._chain.axes[k] @ R for k in joints]
        w = [np.broadcast_to(one, (len(P), 3)) for one in w]
        first = np.stack([np.cos(theta), np.sin(theta)], axis=1)
        rest = _turn(w[0], first * np.array([1.0, -1.0])) @ R
        others, lost = _three_turns(w[1], w[2], w[3], rest, way)
        return dict(zip(joints, [first, *others], strict=True)), lost


class ThreePrismatic:
    """An arm with three prismatic joints and three revolute joints: two ways, one elimination order."""

    def __init__(self, chain: Chain) -> None:
        self._chain = chain
        self._revolute = [k for k in range(6) if not chain.prismatic[k]]

    def __len__(self) -> int:
        return 1

    def take(self, order: int, found: Findings, rows: NDArray[np.int64]) -> None:
        """All solutions; proven unless the ways merge, or joints depend on each other.

        Args:
            order: there is but one.
            found: is filled.
            rows: (k,) the poses.
        """
        P = found.P[rows]
        b, c, d = (np.broadcast_to(self._chain.axes[k], (len(P), 3)) for k in self._revolute)
        regular, number = np.ones(len(P), dtype=np.bool_), np.zeros(len(P), dtype=np.int64)
        for way in WAYS:
            with np.errstate(all="ignore"):
                turns, lost = _three_turns(b, c, d, P[:, :3, :3], float(way))
                moved = dict(zip(self._revolute, turns, strict=True))
                real = np.abs(np.imag(turns[1])).max(axis=1) == 0.0
                S, _ = _left_over(self._chain, P, moved)
                # The imaginary part is zero or the root of the distance from merging; the real one is bounded by it.
                apart = np.abs(_gap(b, c, d, P[:, :3, :3]))
                regular &= (apart > REGULAR) & (np.abs(lost) > REGULAR)
                regular &= ~real | (np.abs(np.linalg.det(np.real(np.nan_to_num(S)))) > REGULAR)
                q = _with_lengths(self._chain, P, moved)
            _, closed = found.try_candidates(rows[real], found.turns(q[real]))
            number[real] += closed
            regular[np.flatnonzero(real)[~closed]] = False
        found.proof[rows] |= regular & (found.count[rows] == number)


def _gap(b: Floats, c: Floats, d: Floats, R: Floats) -> Floats:
    """(m,) 1 - cos^2 of the angle between the roots of c and where they merge."""
    return 1.0 - _cosine(b, c, d, R)[0] ** 2


def _cosine(b: Floats, c: Floats, d: Floats, R: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Cosine of joint c beyond the angle with cosine and sine (u, x, y), and h."""
    h = _dot(b, (R @ d[..., None])[..., 0])
    constant = _dot(b, c) * _dot(c, d)
    x, y = _dot(b, d) - constant, _dot(b, np.cross(c, d))
    size = np.hypot(x, y)
    return (h - constant) / size, x / size, y / size, h


def _three_turns(b: Floats, c: Floats, d: Floats, R: Floats, way: float) -> tuple[list[Numbers], Floats]:
    """Cosines and sines (m, 2) of three joints whose product is a rotation, complex out of reach; and 1 - h^2.

    Args:
        b, c, d: (m, 3) axes.
        R: (m, 3, 3) the rotation.
        way: which root of joint c, 1 or -1.
    """
    u, x, y, h = _cosine(b, c, d, R)
    root = way * np.sqrt(1.0 - u * u + 0j)
    middle = np.stack([x * u - y * root, y * u + x * root], axis=-1)
    Rc, lost = _turn(c, middle), 1.0 - h * h
    ends = [
        _turn_between(b, (Rc @ d[..., None])[..., 0], (R @ d[..., None])[..., 0], h, lost),
        _turn_between(-d, (b[..., None, :] @ Rc)[..., 0, :], (b[..., None, :] @ R)[..., 0, :], h, lost),
    ]
    return [ends[0], middle, ends[1]], lost


def _turn_between(w: Floats, start: Numbers, goal: Numbers, h: Floats, lost: Floats) -> Numbers:
    """(m, 2) cosine and sine of the turn about w from one unit vector to another, both with the same component h."""
    cosine, sine = _dot(start, goal) - h * h, _dot(np.cross(start, goal), w)
    return np.stack([cosine, sine], axis=-1) / lost[..., None]


def _turn(w: Floats, turn: Numbers) -> Numbers:
    """(m, 3, 3) rotations about unit axes (m, 3) by angles of cosine and sine (m, 2), complex or not."""
    c, s = turn[..., 0, None, None], turn[..., 1, None, None]
    cross = np.cross(w[..., None, :], np.eye(3))
    return c * np.eye(3) - s * cross + (1 - c) * (w[..., :, None] * w[..., None, :])


def _left_over(chain: Chain, P: PoseMatrix, turns: dict[int, Numbers]) -> tuple[Numbers, Numbers]:
    """(m, prismatic, 3) directions of the prismatic joints, and (m, 3) the displacement that they have to make."""
    R: Numbers = np.broadcast_to(np.eye(3), (len(P), 3, 3))
    t: Numbers = P[:, :3, 3]
    directions: list[Numbers] = []
    for k in range(6):
        if chain.prismatic[k]:
            directions.append(R @ chain.axes[k])
        else:
            E = _turn(np.broadcast_to(chain.axes[k], (len(P), 3)), turns[k])
            t = t - (R @ (chain.points[k] - E @ chain.points[k])[..., None])[..., 0]
            R = R @ E
    return np.stack(directions, axis=1), t


def _with_lengths(chain: Chain, P: PoseMatrix, turns: dict[int, Numbers]) -> JointVector:
    """(m, 6) coordinates: the angles, and the lengths that come closest to the place."""
    real = {k: np.real(turn) for k, turn in turns.items()}
    q = np.zeros((len(P), 6))
    for k, turn in real.items():
        q[:, k] = np.arctan2(turn[:, 1], turn[:, 0])
    S, t = _left_over(chain, P, real)
    flat = np.swapaxes(np.nan_to_num(S), 1, 2)
    prismatic = [k for k in range(6) if chain.prismatic[k]]
    q[:, prismatic] = (np.linalg.pinv(flat) @ np.nan_to_num(t)[..., None])[..., 0]
    return q


def _dot(a: Numbers, b: Numbers) -> Numbers:
    return (a * b).sum(axis=-1)
