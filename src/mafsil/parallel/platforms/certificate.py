"""Proof that poses of a platform on six legs exist, differ and are all: Kantorovich's theorem at every pose found.

Unknowns z = (R, p), complex (12,), of the twelve quadrics (|p + R b_i - a_i|^2 - s_i^2) / 2 = 0 and R'R = 1. With
eta = |F'(z)^-1 F(z)| and omega, a bound of |F'(z)^-1 F''(u, v)| for unit u and v, for F'' is constant,
h = omega eta <= 1/2 proves a zero within 2 eta of z, and no other nearer than 1 / omega. Rounding is
bounded by ROUNDING of the sizes of the terms of F. Where geometry and z are real, so is the zero. A platform has forty
isolated poses at most; where forty are proven to differ, none is missing.

References: Ortega and Rheinboldt, 1970, sec. 12.6 (Kantorovich); Wampler, Forward displacement analysis of general
six-in-parallel SPS (Stewart) platform manipulators using soma coordinates, Mech. Mach. Theory 31, 1996 (forty).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats
from mafsil.floating_point import EPS
from mafsil.parallel.platforms.platform_sets import MOST, Complexes

ROUNDING = 64 * float(np.finfo(np.longdouble).eps)
"""Of the sum of sizes of the terms of a quadric: each has fewer than sixty operations, in the longest floats here."""
NEWTON = 5
"""Steps in these floats before the proof: matrices in float64 are good enough for steps."""
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class CertificateStatus(Status):
    """What is proven of the poses of one row of lengths."""

    ALL = ("parallel.certificate_all", True)
    THESE = ("parallel.certificate_these", True)
    NOT_PROVEN = ("parallel.certificate_not_proven", False)


@dataclass(frozen=True, eq=False, repr=False)
class Certificate(Answer, data="found proven real radius largest_h"):
    """What is proven of the poses that were found; true if each of them is proven.

    Attributes:
        found: number of poses found, complex ones included.
        proven: of them proven to be near a zero and apart from each other.
        real: number of proven real ones.
        radius: largest distance of a proven zero from what was found, entries of R, and p over the size.
        largest_h: largest h of Kantorovich's theorem over all poses; proven up to 1/2.
    """

    found: int
    proven: int
    real: int
    radius: float
    largest_h: float

    @property
    def status(self) -> CertificateStatus:
        """All there are, all that were found, or not even these."""
        if self.proven < self.found:
            return CertificateStatus.NOT_PROVEN
        return CertificateStatus.ALL if self.proven == MOST else CertificateStatus.THESE

    def explain(self, language: str | None = None) -> str:
        """What is proven, with the numbers that prove it."""
        return self.status.sentence(
            language, found=self.found, proven=self.proven, real=self.real, radius=self.radius, h=self.largest_h,
            most=MOST,
        )  # fmt: skip


def certificate_of(a: Floats, b: Floats, s: Floats, x: Complexes, real: Booleans) -> Certificate:
    """What is proven of poses of one platform of size one.

    Args:
        a, b: (6, 3) ends of the legs.
        s: (6,) lengths.
        x: (k, 7) poses as quaternions of norm one and places.
        real: (k,) those whose numbers are real.
    """
    if not len(x):
        return Certificate(0, 0, 0, 0.0, 0.0)
    z = np.concatenate([_rotations(x[:, :4]).reshape(-1, 9), x[:, 4:]], axis=1).astype(np.clongdouble)
    for _ in range(NEWTON):
        F, J, _ = _quadrics(a, b, s, z)
        z = z - _solve(J, F)
    F, J, size = _quadrics(a, b, s, z)
    inverse = np.linalg.inv(J.astype(np.complex128))
    condition = np.linalg.norm(J.astype(np.complex128), axis=(1, 2)) * np.linalg.norm(inverse, axis=(1, 2))
    step = np.linalg.norm(_solve(J, F).astype(np.complex128), axis=1)
    # The computed inverse is good to its condition times rounding; the residual to ROUNDING of its terms.
    exact = condition * 64 * EPS < 0.1
    weights = np.abs(inverse)
    rounding = np.linalg.norm(np.einsum("kij,kj->ki", weights, ROUNDING * size), axis=1)
    eta = 1.2 * (step + rounding)
    bends = np.concatenate([1 + (b**2).sum(axis=1), np.full(6, 2.0)])
    omega = 1.2 * np.linalg.norm(weights @ bends, axis=1)
    h = omega * eta
    near = exact & (h <= 0.5)
    gaps = np.linalg.norm((z[:, None] - z).astype(np.complex128), axis=2) + np.where(
        np.eye(len(z), dtype=bool), np.inf, 0.0
    )
    apart = gaps > 2 * (eta[:, None] + eta) * 1.01
    proven = near & (apart | ~near).all(axis=1)
    radius = float((2 * eta[proven]).max(initial=0.0))
    return Certificate(len(x), int(proven.sum()), int((proven & real).sum()), radius, float(h.max()))


def _rotations(q: Complexes) -> Complexes:
    w, i, j, k = q.T
    rows = [
        [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)],
        [2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)],
        [2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)],
    ]
    return np.asarray(np.moveaxis(np.array(rows), 2, 0), dtype=np.complex128)


def _solve(J: NDArray[Any], F: NDArray[Any]) -> NDArray[Any]:
    return np.linalg.solve(J.astype(np.complex128), F.astype(np.complex128)[..., None])[..., 0]


def _quadrics(a: Floats, b: Floats, s: Floats, z: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], Floats]:
    """F (k, 12), F' (k, 12, 12) by R, row by row, and p, and the sizes of the terms of F (k, 12)."""
    k, R, p = len(z), z[:, :9].reshape(-1, 3, 3), z[:, 9:]
    d = p[:, None] + (b[:, None, :] * R[:, None]).sum(axis=3) - a
    F, J = np.zeros((k, 12), dtype=z.dtype), np.zeros((k, 12, 12), dtype=z.dtype)
    F[:, :6] = ((d * d).sum(axis=2) - s.astype(np.longdouble) ** 2) / 2
    J[:, :6, :9] = (d[..., :, None] * b[:, None, :]).reshape(k, 6, 9)
    J[:, :6, 9:] = d
    for row, (i, j) in enumerate(PAIRS, start=6):
        F[:, row] = (R[:, :, i] * R[:, :, j]).sum(axis=1) - (i == j)
        for axis in range(3):
            J[:, row, 3 * axis + i] += R[:, axis, j]
            J[:, row, 3 * axis + j] += R[:, axis, i]
    sizes, turned = np.abs(d).astype(np.float64), np.abs(R).astype(np.float64)
    reach = sizes + np.abs(p).astype(np.float64)[:, None] + np.abs(b) @ np.swapaxes(turned, 1, 2) + np.abs(a)
    products = np.einsum("kai,kaj->kij", turned, turned)
    of_rotation = np.stack([products[:, i, j] + (i == j) for i, j in PAIRS], axis=1)
    return F, J, np.concatenate([(reach**2).sum(axis=2) + s**2, of_rotation], axis=1)
