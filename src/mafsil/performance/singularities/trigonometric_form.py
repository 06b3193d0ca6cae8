"""A function of a few joint coordinates written out exactly: sines and cosines of angle sums, powers of lengths."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.performance.tolerances import (
    CLEAR,
    COMPUTED,
    FLAT_SLOPE,
    LONGEST_MOVE,
    ON_CIRCLE,
    REAL_ROOT,
    ROOT_STEP,
    SAME_FORM,
    SHOWN,
    WITHIN,
)


@dataclass(frozen=True, eq=False)
class Term:
    """coefficient * lengths^powers * exp(i k . angles); real parts of pairs k, -k make cosines and sines.

    Attributes:
        coefficient: complex.
        powers: for each joint; k for revolute joints is the multiple of the angle, for prismatic joints the power.
    """

    coefficient: complex
    powers: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class TrigonometricForm:
    """sum of terms over the coordinates `joints`.

    Attributes:
        joints: indices of the coordinates that occur.
        prismatic: for each of them, whether it is the length of a prismatic joint.
        terms: all with coefficients above roundoff.
    """

    joints: tuple[int, ...]
    prismatic: tuple[bool, ...]
    terms: tuple[Term, ...]

    def __call__(self, q: Floats) -> Floats:
        """(*batch) the value at q (*batch, n)."""
        total: Any = np.zeros(q.shape[:-1], dtype=complex)
        for term in self.terms:
            total = total + term.coefficient * self._base(q, term.powers)
        return total.real

    def _base(self, q: Floats, powers: Sequence[int], without: int | None = None) -> NDArray[np.complex128]:
        value: Any = np.ones(q.shape[:-1], dtype=complex)
        for joint, prismatic, k in zip(self.joints, self.prismatic, powers, strict=True):
            if k and joint != without:
                value = value * (q[..., joint] ** k if prismatic else np.exp(1j * k * q[..., joint]))
        return value

    def roots(self, q: Floats, joint: int) -> Floats:
        """The values of one coordinate at which the form vanishes, the others as in q (n,); angles in (-pi, pi].

        Args:
            q: one configuration; its own value of the coordinate is not read.
            joint: index of the coordinate.
        """
        place = self.joints.index(joint)
        degree = max((abs(term.powers[place]) for term in self.terms), default=0)
        prismatic = self.prismatic[place]
        low = 0 if prismatic else -degree
        coefficients = np.zeros(degree - low + 1, dtype=complex)
        for term in self.terms:
            coefficients[term.powers[place] - low] += term.coefficient * self._base(q, term.powers, joint)
        if not np.abs(coefficients).max(initial=0.0) > 0:
            return np.zeros(0)
        zeros: Any = np.roots(np.trim_zeros(coefficients[::-1], "f"))
        if prismatic:
            return np.sort(zeros[np.abs(zeros.imag) < REAL_ROOT * np.maximum(1.0, np.abs(zeros))].real)
        on_circle = zeros[np.abs(np.abs(zeros) - 1.0) < ON_CIRCLE]
        return _distinct(self._polish(q, joint, np.angle(on_circle)))

    def _polish(self, q: Floats, joint: int, angles: Floats) -> Floats:
        """Newton on the form itself; at double roots the steps stay small."""
        at = np.repeat(q[None], len(angles), axis=0)
        at[:, joint] = angles
        step = ROOT_STEP
        for _ in range(3):
            ahead, behind = at.copy(), at.copy()
            ahead[:, joint] += step
            behind[:, joint] -= step
            slope = (self(ahead) - self(behind)) / (2 * step)
            value = self(at)
            good = np.abs(slope) > FLAT_SLOPE
            move = np.where(good, value / np.where(good, slope, 1.0), 0.0)
            at[:, joint] -= np.clip(move, -LONGEST_MOVE, LONGEST_MOVE)
        return at[:, joint]

    def text(self, longest: int | None = None) -> str:
        """The form as a person reads it: `0.4318 cos(q2) + 0.0203 sin(q2 + q3)`.

        Args:
            longest: how many terms are written; all if None.
        """
        parts = [part for term in self.terms if _leads(term.powers, self.prismatic) for part in self._written(term)]
        more = f" + ... ({len(parts)} terms)" if longest is not None and len(parts) > longest else ""
        text = " ".join(f"{'-' if x < 0 else '+'} {_product(abs(x), rest)}" for x, rest in parts[:longest]) + more
        return text.removeprefix("+ ") if not text.startswith("- ") else "-" + text[2:]

    def _written(self, term: Term) -> list[tuple[float, str]]:
        lengths = [
            f"q{j + 1}" + (f"^{k}" if k > 1 else "")
            for j, s, k in zip(self.joints, self.prismatic, term.powers, strict=True)
            if s and k
        ]
        angle = _angle(
            [(j, k) for j, s, k in zip(self.joints, self.prismatic, term.powers, strict=True) if k and not s]
        )
        if not angle:
            return [(term.coefficient.real, " ".join(lengths))]
        pair = [(2 * term.coefficient.real, f"cos({angle})"), (-2 * term.coefficient.imag, f"sin({angle})")]
        largest = max(abs(t.coefficient) for t in self.terms)
        return [(x, " ".join([*lengths, name])) for x, name in pair if abs(x) > COMPUTED * largest]


def _product(x: float, rest: str) -> str:
    return rest if rest and abs(x - 1.0) < SHOWN else f"{x:.6g} {rest}".strip()


def _leads(powers: Sequence[int], prismatic: Sequence[bool]) -> bool:
    """Whether this is the member of a conjugate pair that is written: its first multiple is positive."""
    multiples = [k for k, s in zip(powers, prismatic, strict=True) if k and not s]
    return not multiples or multiples[0] > 0


def _angle(multiples: Sequence[tuple[int, int]]) -> str:
    text = ""
    for joint, k in multiples:
        times = "" if abs(k) == 1 else f"{abs(k)} "
        text += (" - " if k < 0 else " + " if text else "") + f"{times}q{joint + 1}"
    return text.strip()


def _distinct(angles: Floats) -> Floats:
    """Sorted angles in (-pi, pi], equal ones once."""
    wrapped = np.sort(np.pi - np.mod(np.pi - angles, 2 * np.pi))
    if not len(wrapped):
        return wrapped
    keep = np.concatenate([[True], np.diff(wrapped) > WITHIN])
    if len(wrapped) > 1 and keep[-1] and wrapped[0] + 2 * np.pi - wrapped[-1] < WITHIN:
        keep[0] = False
    return wrapped[keep]


def fit_trigonometric_form(
    function: Callable[[Floats], Floats], n: int, prismatic: Sequence[bool], scale: float, degree: int = 2
) -> TrigonometricForm | None:
    """The exact form of a function of q whose degree in every coordinate is at most `degree`, or None if it has none.

    Args:
        function: q (k, n) to (k,).
        n: number of coordinates.
        prismatic: (n,) which are prismatic joints.
        scale: size of prismatic joints [m].
        degree: highest multiple of an angle, or power of a prismatic joint.
    """
    rng = np.random.default_rng(5)
    joints = _dependencies(function, n, prismatic, scale, rng)
    if len(joints) > 4:
        return None
    nodes = [_nodes(prismatic[j], scale, degree) for j in joints]
    grid = np.array(list(product(*nodes))).reshape(-1, len(joints))
    q = np.zeros((len(grid), n))
    q[:, list(joints)] = grid
    values = function(q).astype(complex).reshape([2 * degree + 1 if not prismatic[j] else degree + 1 for j in joints])
    for axis, j in enumerate(joints):
        inverse = np.linalg.inv(_basis(_nodes(prismatic[j], scale, degree), prismatic[j], degree))
        values = np.moveaxis(np.tensordot(inverse, values, axes=(1, axis)), 0, axis)
    largest = np.abs(values).max(initial=0.0)
    lows = [0 if prismatic[j] else -degree for j in joints]
    terms = tuple(
        Term(complex(x), tuple(int(i) + low for i, low in zip(index, lows, strict=True)))
        for index, x in np.ndenumerate(values)
        if abs(x) > COMPUTED * largest
    )
    form = TrigonometricForm(joints, tuple(bool(prismatic[j]) for j in joints), terms)
    trial = _trial(n, prismatic, scale, rng, 32)
    return form if np.abs(form(trial) - function(trial)).max() < CLEAR * max(largest, LEAST_DIVISOR) else None


def _dependencies(
    function: Callable[[Floats], Floats], n: int, prismatic: Sequence[bool], scale: float, rng: np.random.Generator
) -> tuple[int, ...]:
    start = _trial(n, prismatic, scale, rng, 8)
    other = _trial(n, prismatic, scale, rng, 8)
    reference = function(start)
    found: list[int] = []
    for j in range(n):
        moved = start.copy()
        moved[:, j] = other[:, j]
        if np.abs(function(moved) - reference).max() > SAME_FORM * max(float(np.abs(reference).max()), LEAST_DIVISOR):
            found.append(j)
    return tuple(found)


def _trial(n: int, prismatic: Sequence[bool], scale: float, rng: np.random.Generator, count: int) -> Floats:
    return np.where(list(prismatic), scale, np.pi) * rng.uniform(-1, 1, (count, n))


def _nodes(prismatic: bool, scale: float, degree: int) -> Floats:
    if prismatic:
        return scale * np.linspace(-1, 1, degree + 1)
    return 2 * np.pi * np.arange(2 * degree + 1) / (2 * degree + 1)


def _basis(nodes: Floats, prismatic: bool, degree: int) -> NDArray[np.complex128]:
    if prismatic:
        return np.vander(nodes, degree + 1, increasing=True).astype(complex)
    return np.exp(1j * np.outer(nodes, np.arange(-degree, degree + 1)))
