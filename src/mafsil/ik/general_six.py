"""Six joints without a special shape: up to sixteen solutions from one eigenvalue problem.

exp(S_3 q_3) exp(S_4 q_4) exp(S_5 q_5) l = exp(-S_2 q_2) exp(-S_1 q_1) T home^-1 l,

l being the axis of joint 6 with a point p of it.

Fourteen functions of a line with a point on it are linear in (1, cos q, sin q) of every joint that moves it: p, p.p,
and the bivector of (1, p, p.p / 2) and (0, l, p.l), that is l, p.l, p x l, (p.p) l - 2 (p.l) p. Six combinations of
them do not contain q_1 and q_2. In half-angle tangents, and once more multiplied by that of q_4, they are twelve
equations linear in twelve products of powers of those of q_4 and q_5, with coefficients quadratic in that of q_3.

References: Raghavan and Roth, Inverse kinematics of the general 6R manipulator, 1993; Manocha and Canny, 1994.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.ik.chain import Chain
from mafsil.kernels.lazy import lazy

NODES: Floats = 2 * np.pi / 3 * np.arange(3.0)
"""Angles at which a function linear in (1, cos, sin) is sampled."""

TWISTS = (0.3141, 1.9)
"""Two choices of where the half-angle tangents are infinite; what one meets there, the other does not."""

ALMOST_REAL = 1e-2
"""Imaginary parts up to which a root is tried: double roots split by the square root of the rounding."""


@dataclass(frozen=True, eq=False)
class GeneralSix:
    """Elimination for one arm; what does not depend on the pose is computed once.

    Attributes:
        chain: of six joints, the last of them turning; or fewer, which are filled up with joints that stand still.
    """

    chain: Chain

    def solve(self, T: PoseMatrix) -> JointVector:
        """(k, n) candidates for one pose; Newton's method and forward kinematics have to judge them."""
        R = T @ pose.inverse(self.chain.home)
        found: list[Floats] = []
        for side in (self._forwards, self._backwards):
            if side is not None:
                found.append(side.solve(R if side is self._forwards else pose.inverse(R)))
        q = np.concatenate(found) if found else np.zeros((0, 6))
        order = [
            np.flatnonzero(np.array(self._filled.joints) == j)[0]
            for j in sorted(j for j in self._filled.joints if j >= 0)
        ]
        return q[:, order]

    @lazy
    def _filled(self) -> Chain:
        chain, generator = self.chain, np.random.default_rng(4)
        while len(chain) < 6:
            chain = chain.with_joint(
                generator.normal(size=3), chain.home[:3, 3] + 0.3 * chain.size * generator.normal(size=3)
            )
        return chain

    @lazy
    def _forwards(self) -> _Elimination | None:
        return _Elimination(self._filled, False) if not self._filled.slides[5] else None

    @lazy
    def _backwards(self) -> _Elimination | None:
        backwards = self._filled.backwards()
        return _Elimination(backwards, True) if not backwards.slides[5] else None


class _Elimination:
    """The eliminated equations of a chain seen from one end."""

    def __init__(self, chain: Chain, flipped: bool) -> None:
        self.screws, self.slides, self.flipped, self.size = chain.screws, chain.slides, flipped, chain.size
        self.screws = self.screws.copy()
        self.screws[:, 3:] /= np.where(np.array(chain.slides), 1.0, self.size)[:, None]
        self.line = chain.axes[5]
        self.place = chain.points[5] / self.size
        self.nodes: list[Floats] = [np.array([-1.0, 0.0, 1.0]) if slides else NODES for slides in self.slides]
        self.left = self._sampled_left()

    def _moved(self, k: int, q: Floats, sign: float = 1.0) -> Floats:
        return pose.exp(self.screws[k] * (sign * np.asarray(q))[..., None])

    def _sampled_left(self) -> Floats:
        """(14, 3, 3, 3) the functions of the line moved by joints 3, 4, 5 at the nodes of each."""
        E3, E4, E5 = (self._moved(k, self.nodes[k]) for k in (2, 3, 4))
        E = E3[:, None, None] @ E4[None, :, None] @ E5[None, None]
        return np.moveaxis(_functions(E, self.place, self.line), -1, 0)

    def _sampled_right(self, P: PoseMatrix) -> Floats:
        """(14, 9) coefficients of the products of (1, cos, sin) of joints 1 and 2."""
        E1, E2 = (self._moved(k, self.nodes[k], -1.0) for k in (0, 1))
        samples = np.moveaxis(_functions(E2[None] @ E1[:, None] @ P, self.place, self.line), -1, 0)
        one, two = (_basis(self.nodes[k], self.slides[k]) for k in (0, 1))
        return np.einsum("ia,jb,eab->eij", np.linalg.inv(one), np.linalg.inv(two), samples).reshape(14, 9)

    def solve(self, P: PoseMatrix) -> JointVector:
        """(k, 6) candidates for the displacement P of the whole chain."""
        P = P.copy()
        P[:3, 3] /= self.size
        right = self._sampled_right(P)
        constant, rest = right[:, 0], right[:, 1:]
        U, values, _ = np.linalg.svd(rest)
        rank = int((values > 1e-9 * values[0]).sum())
        free = U[:, max(rank, 8) :].T
        equations = np.einsum("re,exyz->rxyz", free, self.left - constant[:, None, None, None])
        inner = np.concatenate([self._inner(equations, twist) for twist in TWISTS])
        return self._completed(inner, P, rest, constant)

    def _inner(self, equations: Floats, twist: float) -> Floats:
        """(k, 3) candidates for joints 3, 4, 5."""
        for axis, k in enumerate((2, 3, 4)):
            to_powers = _powers(self.nodes[k], self.slides[k], twist)
            equations = np.moveaxis(np.tensordot(to_powers, equations, axes=(1, axis + 1)), 0, axis + 1)
        A = np.zeros((3, 12, 4, 3))
        coefficients = np.moveaxis(equations, 1, 0)
        A[:, :6, :3], A[:, 6:, 1:] = coefficients, coefficients
        A0, A1, A2 = A.reshape(3, 12, 12)
        try:
            companion = np.block(
                [[np.zeros((12, 12)), np.eye(12)], [-np.linalg.solve(A2, A0), -np.linalg.solve(A2, A1)]]
            )
            x, V = np.linalg.eig(companion)
        except np.linalg.LinAlgError:
            return np.zeros((0, 3))
        big = np.abs(x) > 1.0
        v = np.where(big, V[12:], V[:12]).reshape(4, 3, 24)
        x4, x5 = (
            _ratio(v[:3].reshape(9, 24), v[1:].reshape(9, 24)),
            _ratio(v[:, :2].reshape(8, 24), v[:, 1:].reshape(8, 24)),
        )
        roots = np.stack([x, x4, x5], axis=1)
        real = (np.abs(roots.imag) <= ALMOST_REAL * (1 + np.abs(roots.real))).all(axis=1)
        values = roots.real[real]
        return np.where([self.slides[k] for k in (2, 3, 4)], values, twist + 2 * np.arctan(values))

    def _completed(self, inner: Floats, P: PoseMatrix, rest: Floats, constant: Floats) -> JointVector:
        """(k, 6) joints 1 and 2 from the linear equations, joint 6 from what is left."""
        if not len(inner):
            return np.zeros((0, 6))
        E = self._moved(2, inner[:, 0]) @ self._moved(3, inner[:, 1]) @ self._moved(4, inner[:, 2])
        products = (np.linalg.pinv(rest) @ (_functions(E, self.place, self.line) - constant).T).T
        table = np.concatenate([np.ones((len(inner), 1)), products], axis=1).reshape(-1, 3, 3)
        one, two = table[:, :, 0], table[:, 0, :]
        q1 = one[:, 1] if self.slides[0] else np.arctan2(one[:, 2], one[:, 1])
        q2 = two[:, 1] if self.slides[1] else np.arctan2(two[:, 2], two[:, 1])
        before = self._moved(0, q1) @ self._moved(1, q2) @ E
        left = np.linalg.inv(before) @ P
        aside = np.cross(self.line, np.eye(3)[int(np.abs(self.line).argmin())])
        turned = left[:, :3, :3] @ aside
        q6 = np.arctan2(np.cross(aside, turned) @ self.line, turned @ aside)
        q = np.concatenate([q1[:, None], q2[:, None], inner, q6[:, None]], axis=1)
        q = q * np.where(np.array(self.slides), self.size, 1.0)
        q = q[np.isfinite(q).all(axis=1)]
        return q[:, ::-1] if self.flipped else q


def _functions(E: PoseMatrix, place: Floats, line: Floats) -> Floats:
    """(..., 14) the functions of the moved line."""
    p, l = E[..., :3, :3] @ place + E[..., :3, 3], E[..., :3, :3] @ line
    pp, pl = (p * p).sum(-1, keepdims=True), (p * l).sum(-1, keepdims=True)
    return np.concatenate([p, pp, l, pl, np.cross(p, l), pp * l - 2 * pl * p], axis=-1)


def _basis(nodes: Floats, slides: bool) -> Floats:
    """(3, 3) rows (1, cos, sin), or (1, q, q^2) of a slide, at the nodes."""
    return np.stack([np.ones(3), nodes, nodes**2] if slides else [np.ones(3), np.cos(nodes), np.sin(nodes)], axis=1)


def _powers(nodes: Floats, slides: bool, twist: float) -> Floats:
    """(3, 3) from values at the nodes to coefficients of 1, x, x^2 after multiplication by 1 + x^2.

    x = tan((q - twist) / 2).
    """
    if slides:
        return np.asarray(np.linalg.inv(np.stack([np.ones(3), nodes, nodes**2], axis=1)), dtype=np.float64)
    x = np.tan((nodes - twist) / 2)
    return np.asarray(np.linalg.inv(np.stack([np.ones(3), x, x * x], axis=1)) * (1 + x * x), dtype=np.float64)


def _ratio(below: NDArray[np.complex128], above: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Quotient of the pair whose members are largest together."""
    best = (np.abs(below) + np.abs(above) * 1e-3).argmax(axis=0)
    columns = np.arange(below.shape[1])
    divisor = below[best, columns]
    return above[best, columns] / np.where(divisor == 0, 1e-300, divisor)
