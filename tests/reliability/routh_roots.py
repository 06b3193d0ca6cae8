"""R22: Routh's array against the roots of random polynomials of order 1 to 10.

`python -m tests.reliability.routh_roots --polynomials 1000000 --resume DIR`

Coefficients are normal, or all positive, or those of roots that were planted over six decades, many of them near the
axis; signs and scales of whole polynomials and of time vary. The roots are eigenvalues of the balanced companion
matrix, by LAPACK; where one is nearer to the axis than its uncertainty, the polynomial is unclear and left out.
"""

from __future__ import annotations

import sys

import numpy as np

from mafsil.arrays import Floats
from mafsil.one_joint import routh_hurwitz
from mafsil.one_joint.polynomial import StabilityStatus
from tests.reliability import figures

CHUNK, MOST_ORDER = 2_000, 10
KINDS = ("normal", "positive", "planted", "near")
CLEAR = 100.0
"""Times the uncertainty of a root that it has to be away from the axis."""


def random_polynomials(rng: np.random.Generator, count: int, order: int, kind: str) -> Floats:
    """(count, order + 1) coefficients, highest power first."""
    if kind in ("normal", "positive"):
        a = rng.normal(size=(count, order + 1))
        a = np.abs(a) if kind == "positive" else a
    else:
        pairs, size = order // 2, 10.0 ** rng.uniform(-1, 1, (count, order))
        away = 10.0 ** rng.uniform(-6, 0, (count, order)) if kind == "near" else np.ones((count, order))
        real = size * away * np.where(rng.random((count, order)) < 0.85, -1.0, 1.0)
        a = np.ones((count, 1))
        for k in range(pairs):
            w = size[:, 2 * k]
            factor = np.stack([np.ones(count), -2.0 * real[:, 2 * k], real[:, 2 * k] ** 2 + w * w], axis=1)
            a = _product(a, factor)
        if order % 2:
            a = _product(a, np.stack([np.ones(count), -real[:, -1]], axis=1))
    faster = 10.0 ** rng.uniform(-2, 2, (count, 1))
    sign = np.where(rng.random((count, 1)) < 0.5, -1.0, 1.0) * 10.0 ** rng.uniform(-3, 3, (count, 1))
    return sign * a * faster ** np.arange(a.shape[1])


def _product(a: Floats, b: Floats) -> Floats:
    """Of polynomials, row by row."""
    found = np.zeros((len(a), a.shape[1] + b.shape[1] - 1))
    for k in range(b.shape[1]):
        found[:, k : k + a.shape[1]] += b[:, k : k + 1] * a
    return found


def roots_and_uncertainty(a: Floats) -> tuple[Floats, Floats]:
    """Real parts (count, order) of the roots, and by how much rounding of coefficients may move each."""
    order = a.shape[1] - 1
    scaled = a / a[:, :1]
    # Time in the unit of the geometric mean of the roots: companions of equal sizes.
    unit = np.abs(scaled[:, -1:]) ** (1.0 / order)
    scaled = scaled / unit ** np.arange(order + 1)
    companion = np.zeros((len(a), order, order))
    companion[:, np.arange(1, order), np.arange(order - 1)] = 1.0
    companion[:, 0, :] = -scaled[:, 1:]
    s = np.linalg.eigvals(companion).astype(complex)
    powers = np.abs(s)[..., None] ** np.arange(order, -1, -1)
    slope = np.abs(sum((order - k) * scaled[:, k, None] * s ** (order - k - 1) for k in range(order)))
    eps = np.finfo(float).eps
    with np.errstate(divide="ignore"):
        moved = eps * (np.abs(scaled)[:, None, :] * powers).sum(axis=-1) / slope
        return s.real, moved + eps * order * np.abs(companion).max(axis=(1, 2))[:, None]


def work(seed: int, polynomials: int) -> dict[str, int]:
    """Counts of one shard: chunks of polynomials of all kinds and orders."""
    rng = np.random.default_rng([41, seed])
    total = dict.fromkeys(("polynomials", "unclear", "stable", "bad_stable", "bad_right_roots", "bad_marginal"), 0)
    for begin in range(0, polynomials, CHUNK):
        turn = begin // CHUNK
        kind, order = KINDS[turn % len(KINDS)], 1 + (turn // len(KINDS)) % MOST_ORDER
        a = random_polynomials(rng, min(CHUNK, polynomials - begin), order, kind)
        answer = routh_hurwitz(a)
        real, moved = roots_and_uncertainty(a)
        clear = (np.abs(real) > CLEAR * moved).all(axis=1)
        stable, right = (real < 0.0).all(axis=1), (real > 0.0).sum(axis=1)
        marginal = list(StabilityStatus).index(StabilityStatus.MARGINAL)
        total["polynomials"] += len(a)
        total["unclear"] += int((~clear).sum())
        total["stable"] += int((stable & clear).sum())
        total["bad_stable"] += int((answer.stable != stable)[clear].sum())
        total["bad_right_roots"] += int((answer.right_roots != right)[clear].sum())
        total["bad_marginal"] += int((answer.verdict == marginal)[clear].sum())
    return total


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "polynomials", 100_000, 100_000)
    sys.exit(not figures.run("R22", options, work)["passed"])
