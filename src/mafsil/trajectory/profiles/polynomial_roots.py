"""Real roots of many polynomials at once, between 0 and 1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.trajectory.tolerances import REAL_ROOT


def roots_inside(polynomials: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Roots x with 0 < x < 1, nearly real ones included: a double root may come out as a complex pair.

    Args:
        polynomials: (pieces, n, degree + 1) ascending coefficients; leading ones may vanish.

    Returns:
        (k,) the piece to which each root belongs, and (k,) the roots.
    """
    pieces, n, count = polynomials.shape
    places: list[NDArray[np.intp]] = [np.zeros(0, dtype=np.intp)]
    roots: list[Floats] = [np.zeros(0)]
    if count < 2:
        return places[0], roots[0]
    flat = polynomials.reshape(-1, count)
    piece = np.repeat(np.arange(pieces, dtype=np.intp), n)
    degrees: NDArray[np.intp] = np.where(flat != 0.0, np.arange(count, dtype=np.intp), 0).max(axis=1, initial=0)
    for degree in range(1, count):
        mine = np.flatnonzero(degrees == degree)
        if not len(mine):
            continue
        x = _roots(flat[mine, : degree + 1])
        inside = (np.abs(x.imag) <= REAL_ROOT * (1.0 + np.abs(x.real))) & (x.real > 0.0) & (x.real < 1.0)
        places.append(np.repeat(piece[mine], degree).reshape(x.shape)[inside])
        roots.append(x.real[inside])
    return np.concatenate(places), np.concatenate(roots)


def _roots(polynomials: Floats) -> NDArray[np.complex128]:
    """(k, degree) roots of (k, degree + 1) ascending coefficients whose last is not zero."""
    k, degree = len(polynomials), polynomials.shape[1] - 1
    with np.errstate(over="ignore"):
        monic = polynomials[:, :-1] / polynomials[:, -1:]
    if degree == 1:
        return -monic.astype(np.complex128)
    if degree == 2:
        return _quadratic(monic)
    companion = np.zeros((k, degree, degree))
    companion[:, 1:, :-1] = np.eye(degree - 1)
    # A leading coefficient that is next to nothing has a root far away: none of the others suffers from clipping it.
    companion[:, :, -1] = -np.clip(monic, -1e150, 1e150)
    return np.asarray(np.linalg.eigvals(companion), dtype=np.complex128)


def _quadratic(monic: Floats) -> NDArray[np.complex128]:
    """Roots of x^2 + b x + c without cancellation: the larger one by the formula, the other from their product."""
    c, half = monic[:, 0], monic[:, 1] / 2.0
    root = np.sqrt((half**2 - c).astype(np.complex128))
    large = -(half + np.where(half >= 0.0, 1.0, -1.0) * root)
    with np.errstate(divide="ignore", invalid="ignore"):
        small = np.where(large != 0.0, c / large, 0.0)
    return np.asarray(np.stack([large, small], axis=1), dtype=np.complex128)
