"""What a configuration cannot do: lost twists and reciprocal wrenches, read as screws with axis, point and pitch.

How many independent motions a set of screws gives, with no robot around them.

A linear system of screws by a basis that anybody would choose: couples apart, forces at their principal pitches.

A singular value decomposition hands out any basis of what is lost or carried, and reads two couples and two forces as
four screws with axes far away. Here the free parts come first, as near to the coordinate axes as they can be; the
rest is split into its principal screws, whose directions are orthogonal and whose pitches are extreme.

Reference: Hunt, Kinematic Geometry of Mechanisms, 1978, ch. 12 (principal screws); Gibson & Hunt 1990.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, Vector3, as_batch, not_negative, positive
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.performance.tolerances import CLEAR, COARSEST, ROUNDOFF, SHOWN, SINGLE_DIGITS, WITHIN
from mafsil.performance.velocity.scaling import TOLERANCE, at_point, central_point, rank_in_doubt, rank_of


class ScrewParameters(NamedTuple):
    """A screw by axis, pitch and magnitude.

    Attributes:
        direction: (3,) unit vector along the axis.
        point: (3,) point of the axis nearest to the origin [m]; NaN for infinite pitch.
        pitch: [m]; 0 a pure rotation or force, infinite a pure translation or couple.
    """

    direction: Vector3
    point: Vector3
    pitch: float

    def sentence(self, key: str, language: str | None = None) -> str:
        """The words for `<key>_line`, `<key>_screw` or `<key>_free`, whichever fits the pitch."""
        form = "free" if np.isinf(self.pitch) else "line" if abs(self.pitch) < WITHIN else "screw"
        details = {"direction": vector_text(self.direction), "point": vector_text(self.point), "pitch": self.pitch}
        return say(f"performance.{key}_{form}", language=language, **details)


def twist_screw(V: ArrayLike, *, length: float = 1.0) -> ScrewParameters:
    """Axis, point and pitch of a twist (omega, v).

    Args:
        V: (6,).
        length: [m] by which translations are compared with turns when deciding that it does not turn at all.
    """
    twist = as_batch("V", V, (6,), finite=True)
    return _screw(twist[:3], twist[3:], positive("length", length))


def wrench_screw(F: ArrayLike, *, length: float = 1.0) -> ScrewParameters:
    """Axis, point and pitch of a wrench (m, f): its line of action.

    Args:
        F: (6,).
        length: [m] by which forces are compared with moments when deciding that it has no force.
    """
    wrench = as_batch("F", F, (6,), finite=True)
    return _screw(wrench[3:], wrench[:3], positive("length", length))


def _screw(directed: Floats, moment: Floats, length: float) -> ScrewParameters:
    size = float(np.linalg.norm(directed))
    if size * length <= CLEAR * float(np.linalg.norm(moment)) or size == 0.0:
        total = float(np.linalg.norm(moment))
        return ScrewParameters(
            canonical_direction(moment / total if total else moment), np.full(3, np.nan), float("inf")
        )
    pitch = float(directed @ moment) / size**2
    return ScrewParameters(canonical_direction(directed / size), np.cross(directed, moment) / size**2, pitch)


def canonical_direction(direction: Vector3) -> Vector3:
    """The same line's direction with its first clearly non-zero component positive, and no roundoff."""
    clean = np.where(np.abs(direction) < ROUNDOFF, 0.0, direction)
    first = clean[np.argmax(np.abs(clean) > WITHIN)]
    return clean * np.sign(first) if first else clean


def vector_text(vector: Floats) -> str:
    """(x, y, z) with four digits."""
    return "(" + ", ".join(f"{x:.4g}" if abs(x) > SHOWN else "0" for x in vector) + ")"


class ScrewRank(NamedTuple):
    """The rank of a set of screws and what it leaves.

    Attributes:
        rank: number of independent screws.
        singular_values: of the screws without units, largest first.
        null_rates: (k - rank, k) rates along the screws that cancel.
        reciprocal: (6 - rank, 6) wrenches (m, f) that do no work on any of them, in their canonical basis.
        length: [m] that divided translations.
        tolerance: of the rank.
    """

    rank: int
    singular_values: Floats
    null_rates: Floats
    reciprocal: Floats
    length: float
    tolerance: float = TOLERANCE

    @property
    def in_doubt(self) -> bool:
        """Whether screws of six digits leave the rank open."""
        return bool(rank_in_doubt(self.singular_values, self.tolerance))


def rank_of_screws(S: ArrayLike, *, length: float | None = None, tolerance: float = TOLERANCE) -> ScrewRank:
    """The rank of screws, or twists, (omega, v) in one frame.

    Linear parts are taken at the point nearest to all axes and divided by a length, so that neither the origin nor the
    unit of length matters; every screw counts by its direction only, not by its size.

    Args:
        S: (k, 6) screws, none of them zero.
        length: [m]; the root mean square distance of the axes from that point if None, 1 m if they all meet there.
        tolerance: singular values below this share of the largest count as zero.
    """
    length = None if length is None else positive("length", length)
    tolerance = not_negative("tolerance", tolerance, most=COARSEST)
    axes = np.atleast_2d(as_batch("S", S, (6,), finite=True)).T
    point = central_point(axes)
    J = at_point(axes, point)
    revolute = np.linalg.norm(J[:3], axis=0) > 0
    levers = np.linalg.norm(J[3:, revolute], axis=0) / np.linalg.norm(J[:3, revolute], axis=0)
    extent = float(np.sqrt((levers**2).mean())) if revolute.any() else 0.0
    size = max(float(np.abs(point).max()), float(np.abs(axes[3:]).max()))
    scale = length if length is not None else extent if extent > WITHIN * size else 1.0
    units = J / np.repeat([1.0, scale], 3)[:, None]
    units = units / np.linalg.norm(units, axis=0)
    U, s, Vt = np.linalg.svd(units)
    found = int(rank_of(s, tolerance))
    sizes = np.linalg.norm(J / np.repeat([1.0, scale], 3)[:, None], axis=0)
    left = U[:, found:].T
    f, m = canonical_system(left[:, 3:] / 1.0, left[:, :3])
    F = np.concatenate([m, f / scale], axis=1)
    F[:, :3] += np.cross(point, F[:, 3:])
    return ScrewRank(found, s, Vt[found:] / sizes, F, float(scale), tolerance)


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
        if abs(A[pivot, column]) <= SINGLE_DIGITS * max(float(np.abs(A[done:]).max()), LEAST_DIVISOR):
            continue
        A[[done, pivot]] = A[[pivot, done]]
        A[done] /= A[done, column]
        others: NDArray[np.bool_] = np.arange(k) != done
        A[others] -= np.outer(A[others, column], A[done])
        done += 1
    A[np.abs(A) < CLEAR * np.abs(A).max(axis=1, keepdims=True)] = 0.0
    return A / np.linalg.norm(A, axis=1, keepdims=True)
