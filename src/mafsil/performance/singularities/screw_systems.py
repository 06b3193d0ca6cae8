"""A linear system of screws by a basis that anybody would choose: couples apart, forces at their principal pitches.

A singular value decomposition hands out any basis of what is lost or carried, and reads two couples and two forces as
four screws with axes far away. Here the free parts come first, as near to the coordinate axes as they can be; the
rest is split into its principal screws, whose directions are orthogonal and whose pitches are extreme.

Reference: Hunt, Kinematic Geometry of Mechanisms, 1978, ch. 12 (principal screws); Gibson & Hunt 1990.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.performance.tolerances import CLEAR, SINGLE_DIGITS, SMALLEST


def canonical_system(directed: Floats, free: Floats) -> tuple[Floats, Floats]:
    """The canonical basis of a system of screws, without units.

    1. Combinations without a directed part (couples, translations): reduced to row echelon form.
    2. The others: orthonormal directions, the free parts orthogonal to those of step 1.
    3. The pitch is a quadratic form of the direction; its axes are the principal screws.
    4. Directions of one pitch again from a row echelon form, made orthonormal in its order.

    Args:
        directed: (k, 3) forces of wrenches, angular velocities of twists; independent rows with `free`.
        free: (k, 3) moments of wrenches, linear velocities of twists, divided by a length.

    Returns:
        directed (k, 3), free (k, 3), the purely free rows first; every row's leading part a unit vector.
    """
    if not len(directed):
        return directed, free
    U, s, Vt = np.linalg.svd(directed, full_matrices=True)
    scale = max(float(np.abs(directed).max()), float(np.abs(free).max()))
    rank = int((s > CLEAR * scale).sum())
    couples = echelon((U.T @ free)[rank:])
    lines = Vt[:rank]
    moments = (U.T @ free)[:rank] / s[:rank, None]
    if len(couples):
        Q = np.linalg.qr(couples.T)[0]
        moments = moments - moments @ Q @ Q.T
    lines, moments = _principal(lines, moments)
    nothing = np.zeros_like(couples)
    return np.concatenate([nothing, lines]), np.concatenate([couples, moments])


def _principal(lines: Floats, moments: Floats) -> tuple[Floats, Floats]:
    """Rows recombined to the axes of the form d . m, equal pitches in echelon form."""
    if not len(lines):
        return lines, moments
    form = lines @ moments.T
    pitches, turn = np.linalg.eigh((form + form.T) / 2)
    lines, moments = turn.T @ lines, turn.T @ moments
    size = max(float(np.abs(moments).max()), 1.0)
    starts = [k for k in range(len(pitches)) if k == 0 or pitches[k] - pitches[k - 1] > CLEAR * size]
    for start, end in zip(starts, [*starts[1:], len(pitches)], strict=True):
        both = echelon(np.concatenate([lines[start:end], moments[start:end]], axis=1))
        upper = np.linalg.qr(both[:, :3].T)[1]  # orthonormal again, the first direction kept
        upper *= np.sign(np.diag(upper))[:, None]
        lines[start:end], moments[start:end] = np.hsplit(np.linalg.solve(upper.T, both), 2)
    return lines, moments


def echelon(rows: Floats) -> Floats:
    """Reduced row echelon form of independent rows (k, m), each scaled to unit length, roundoff removed."""
    A = rows.copy()
    k: int = A.shape[0]
    m: int = A.shape[1]
    done = 0
    for column in range(m):
        if done == k:
            break
        pivot = done + int(np.abs(A[done:, column]).argmax())
        if abs(A[pivot, column]) <= SINGLE_DIGITS * max(float(np.abs(A[done:]).max()), SMALLEST):
            continue
        A[[done, pivot]] = A[[pivot, done]]
        A[done] /= A[done, column]
        others: NDArray[np.bool_] = np.arange(k) != done
        A[others] -= np.outer(A[others, column], A[done])
        done += 1
    A[np.abs(A) < CLEAR * np.abs(A).max(axis=1, keepdims=True)] = 0.0
    return A / np.linalg.norm(A, axis=1, keepdims=True)
