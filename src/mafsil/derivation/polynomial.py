"""Polynomials in lengths, slides and the sines and cosines of angle sums: what formulas of arms are made of.

A factor is a `Symbol` (a length, or the coordinate of a sliding joint) or a `Trig`, the sine or cosine of an integer
combination of named angles. No expression is ever guessed: every operation here is an identity. Vectors, matrices and
poses have polynomials as their entries.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.tolerances import ROUNDING, ROUNDOFF

Angle: TypeAlias = tuple[tuple[str, int], ...]
"""Names with their integer multiples, sorted by the order in which the chain introduced them; () is the angle zero."""
Values: TypeAlias = Mapping[str, Any]
"""Numbers, or arrays of any one shape, for the names of angles [rad] and symbols [m]."""
RATES = ("dtheta", "dq", "ddtheta", "ddq")
"""Letters of rates and accelerations."""
_FIRST = {"m": 0, "I": 0, "g": 1}


class Symbol(NamedTuple):
    """A length or slide [m] by name; `joint` is its joint's number if it is a coordinate."""

    name: str
    joint: int = 0


class Trig(NamedTuple):
    """Cosine or sine of an angle whose first multiple is positive."""

    sine: bool
    angle: Angle


Factor: TypeAlias = Symbol | Trig
Monomial: TypeAlias = tuple[Factor, ...]
"""Factors in `rank` order, repeated as often as their power."""


@dataclass(frozen=True, slots=True, eq=False)
class Polynomial:
    """A sum of numbers times monomials; the empty sum is zero."""

    terms: Mapping[Monomial, float]

    def __add__(self, other: Polynomial) -> Polynomial:
        return collect_terms([*self.terms.items(), *other.terms.items()])

    def __neg__(self) -> Polynomial:
        return Polynomial({monomial: -number for monomial, number in self.terms.items()})

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + (-other)

    def __mul__(self, other: Polynomial) -> Polynomial:
        return collect_terms(
            (tuple(sorted(one + two, key=rank)), x * y)
            for one, x in self.terms.items()
            for two, y in other.terms.items()
        )

    @property
    def is_zero(self) -> bool:
        """Whether no term is left."""
        return not self.terms

    @property
    def length(self) -> int:
        """How long it is on paper: factors, and one for each term."""
        return sum(1 + len(monomial) for monomial in self.terms)

    def evaluate(self, values: Values) -> Any:
        """The number, or array of numbers, for given angles and lengths."""
        total: Any = 0.0
        for monomial, number in self.terms.items():
            product: Any = number
            for factor in monomial:
                product = product * factor_value(factor, values)
            total = total + product
        return total

    def multiplied_out(self) -> Polynomial:
        """Every product of sines and cosines as a sum of single ones: equal formulas become the same terms."""
        waiting, done = list(self.terms.items()), list[tuple[Monomial, float]]()
        while waiting:
            monomial, number = waiting.pop()
            trigs = [factor for factor in monomial if isinstance(factor, Trig)]
            if len(trigs) < 2:
                done.append((monomial, number))
                continue
            rest = list(monomial)
            rest.remove(trigs[0])
            rest.remove(trigs[1])
            waiting += (Polynomial({tuple(rest): number}) * _trigs_multiplied(trigs[0], trigs[1])).terms.items()
        return collect_terms(done)

    def derivative(self, name: str) -> Polynomial:
        """With respect to the angle or symbol of that name."""
        return collect_terms(
            (rest, number * outer)
            for monomial, number in self.terms.items()
            for k, factor in enumerate(monomial)
            for inner, outer in _slopes(factor, name)
            for rest in (tuple(sorted((*monomial[:k], *inner, *monomial[k + 1 :]), key=rank)),)
        )


def collect_terms(terms: Iterable[tuple[Monomial, float]]) -> Polynomial:
    """The sum of terms, like ones together, roundoff removed."""
    total: dict[Monomial, float] = {}
    for monomial, number in terms:
        total[monomial] = total.get(monomial, 0.0) + number
    return Polynomial({m: tidy(x) for m, x in sorted(total.items(), key=_place) if abs(x) > ROUNDING})


def constant(number: float) -> Polynomial:
    """A number."""
    return collect_terms([((), number)])


def symbol(name: str, joint: int = 0) -> Polynomial:
    """A length, or the coordinate of a sliding joint."""
    return Polynomial({(Symbol(name, joint),): 1.0})


def trig(sine: bool, angle: Angle, quarters: int = 0) -> Polynomial:
    """Sine or cosine of angle + quarters * 90 degrees."""
    turns = (quarters - 1 if sine else quarters) % 4
    sign = (1.0, -1.0, -1.0, 1.0)[turns]
    odd = turns % 2 == 1
    if angle and angle[0][1] < 0:
        angle, sign = tuple((name, -k) for name, k in angle), -sign if odd else sign
    if not angle:
        return constant(0.0 if odd else sign)
    return Polynomial({(Trig(odd, angle),): sign})


def angle_sum(one: Angle, other: Angle, sign: int = 1) -> Angle:
    """One angle plus `sign` times the other."""
    total = dict(one)
    for name, k in other:
        total[name] = total.get(name, 0) + sign * k
    return tuple(sorted(((name, k) for name, k in total.items() if k), key=lambda pair: _natural(pair[0])))


def angle_value(angle: Angle, values: Values) -> Any:
    """The angle [rad]."""
    return sum(k * values[name] for name, k in angle)


def factor_value(factor: Factor, values: Values) -> Any:
    """The number of one factor."""
    if isinstance(factor, Symbol):
        return values[factor.name]
    return (np.sin if factor.sine else np.cos)(angle_value(factor.angle, values))


def rank(factor: Factor) -> tuple[object, ...]:
    """Order of factors on paper: masses, g, lengths, then trigs by joint (of shorter sums first), then rates."""
    if isinstance(factor, Symbol):
        letter = factor.name.rstrip("0123456789").partition("_")[0]
        if letter in RATES:
            return (4, int(factor.name[len(letter) :] or 0), letter)
        return (_FIRST.get(letter, 2), _natural(factor.name))
    return (3, tuple(_natural(name) for name, _ in factor.angle), tuple(k for _, k in factor.angle), factor.sine)


def simplify(polynomial: Polynomial) -> Polynomial:
    """The shortest form that Pythagoras and the addition theorems give.

    Args:
        polynomial: any.

    Returns:
        An equal polynomial, not longer.
    """
    best = polynomial
    for _ in range(8):
        shorter = min(_rewritings(best), key=lambda p: p.length, default=best)
        if shorter.length >= best.length:
            return best
        best = shorter
    return best


def _rewritings(polynomial: Polynomial) -> Iterable[Polynomial]:
    """One rewriting per repeated angle (s^2 = 1 - c^2, c^2 = 1 - s^2) and per pair of angles with a common name."""
    pairs: set[tuple[Angle, Angle]] = set()
    squares: Counter[Trig] = Counter()
    for monomial in polynomial.terms:
        trigs = [f for f in monomial if isinstance(f, Trig)]
        for k, one in enumerate(trigs):
            for two in trigs[k + 1 :]:
                if one == two:
                    squares[one] += 1
                elif one.angle != two.angle and {name for name, _ in one.angle} & {name for name, _ in two.angle}:
                    pairs.add((one.angle, two.angle))
    for square in squares:
        yield _without_square(polynomial, square)
    for one, two in pairs:
        yield _product_to_sum(polynomial, one, two)
    for one in {square.angle for square in squares}:
        yield _product_to_sum(polynomial, one, one)


def _without_square(polynomial: Polynomial, square: Trig) -> Polynomial:
    """Every square of the factor replaced by one minus the other's square."""
    other = Trig(not square.sine, square.angle)
    terms: list[tuple[Monomial, float]] = []
    for monomial, number in polynomial.terms.items():
        if monomial.count(square) < 2:
            terms.append((monomial, number))
            continue
        rest = list(monomial)
        rest.remove(square)
        rest.remove(square)
        terms += [(tuple(rest), number), (tuple(sorted([*rest, other, other], key=rank)), -number)]
    return collect_terms(terms)


def _product_to_sum(polynomial: Polynomial, one: Angle, two: Angle) -> Polynomial:
    """In every term the first product of sines or cosines of the two angles, by the addition theorems."""
    total = Polynomial({})
    for monomial, number in polynomial.terms.items():
        rest = list(monomial)
        first = next((f for f in rest if isinstance(f, Trig) and f.angle == one), None)
        if first is not None:
            rest.remove(first)
        second = next((f for f in rest if isinstance(f, Trig) and f.angle == two), None)
        if first is None or second is None:
            total = total + Polynomial({monomial: number})
            continue
        rest.remove(second)
        total = total + Polynomial({tuple(rest): number}) * _trigs_multiplied(first, second)
    return total


def _trigs_multiplied(one: Trig, two: Trig) -> Polynomial:
    """Product of two trigs by the addition theorems."""
    plus, minus = angle_sum(one.angle, two.angle), angle_sum(one.angle, two.angle, -1)
    half = constant(0.5)
    if one.sine == two.sine:
        sign = constant(-0.5 if one.sine else 0.5)
        return half * trig(False, minus) + sign * trig(False, plus)
    difference = half * trig(True, minus)
    return half * trig(True, plus) + (difference if one.sine else -difference)


def _slopes(factor: Factor, name: str) -> list[tuple[Monomial, float]]:
    """Derivative of a factor: factors and number."""
    if isinstance(factor, Symbol):
        return [((), 1.0)] if factor.name == name else []
    multiple = dict(factor.angle).get(name, 0)
    other = Trig(not factor.sine, factor.angle)
    return [((other,), float(multiple if factor.sine else -multiple))] if multiple else []


def tidy(number: float) -> float:
    """The nearest half integer if it is that but for rounding."""
    nearest = round(2 * number) / 2
    return nearest if abs(number - nearest) < ROUNDING else number


def _place(term: tuple[Monomial, float]) -> tuple[object, ...]:
    """Order of terms on paper: those of early joints first, shorter ones first."""
    trigs = tuple(rank(f) for f in term[0] if isinstance(f, Trig))
    return (trigs, len(term[0]), tuple(rank(f) for f in term[0]))


def _natural(name: str) -> tuple[str, int]:
    """Letters and number of a name, so that 2 stands before 10."""
    letters = name.rstrip("0123456789")
    return letters, int(name[len(letters) :] or 0)


Row: TypeAlias = tuple[Polynomial, ...]
Entries: TypeAlias = tuple[Row, ...]
"""Rows of a matrix; a vector is one row."""
ZERO, ONE = constant(0.0), constant(1.0)


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicPose:
    """Rotation (3, 3) and origin (3,) of a frame in another one."""

    R: Entries
    p: Row

    @property
    def entries(self) -> Entries:
        """(4, 4) homogeneous matrix."""
        return (*((*row, x) for row, x in zip(self.R, self.p, strict=True)), (ZERO, ZERO, ZERO, ONE))

    @property
    def z(self) -> Row:
        """(3,) third column of the rotation."""
        return tuple(row[2] for row in self.R)


def rotation_x(angle: Angle, quarters: int = 0) -> Entries:
    """Rot(x, angle + quarters * 90 degrees)."""
    c, s = trig(False, angle, quarters), trig(True, angle, quarters)
    return ((ONE, ZERO, ZERO), (ZERO, c, -s), (ZERO, s, c))


def rotation_z(angle: Angle, quarters: int = 0) -> Entries:
    """Rot(z, angle + quarters * 90 degrees)."""
    c, s = trig(False, angle, quarters), trig(True, angle, quarters)
    return ((c, -s, ZERO), (s, c, ZERO), (ZERO, ZERO, ONE))


def numbers(values: Floats) -> Entries:
    """A matrix of numbers, roundoff of zeros and ones removed."""
    rounded = np.where(np.abs(values - np.round(values)) < ROUNDOFF, np.round(values), values)
    return tuple(tuple(constant(float(x)) for x in row) for row in rounded)


def product(A: Entries, B: Entries) -> Entries:
    """A B, every entry simplified."""
    columns = tuple(zip(*B, strict=True))
    return tuple(tuple(dot(row, column) for column in columns) for row in A)


def transform(A: Entries, x: Row) -> Row:
    """A x."""
    return tuple(dot(row, x) for row in A)


def transpose(A: Entries) -> Entries:
    """Rows as columns."""
    return tuple(zip(*A, strict=True))


def dot(x: Row, y: Row) -> Polynomial:
    """Inner product, simplified."""
    total = ZERO
    for one, two in zip(x, y, strict=True):
        total = total + one * two
    return simplify(total)


def cross(x: Row, y: Row) -> Row:
    """Vector product, simplified."""
    return tuple(simplify(x[i] * y[j] - x[j] * y[i]) for i, j in ((1, 2), (2, 0), (0, 1)))


def plus(x: Row, y: Row) -> Row:
    """X + y, simplified."""
    return tuple(simplify(one + two) for one, two in zip(x, y, strict=True))


def minus(x: Row, y: Row) -> Row:
    """X - y, simplified."""
    return tuple(simplify(one - two) for one, two in zip(x, y, strict=True))


def scale_row(number: Polynomial, x: Row) -> Row:
    """A multiple of x, simplified."""
    return tuple(simplify(number * one) for one in x)


def evaluate(A: Entries, values: Values, count: int) -> Floats:
    """(count, rows, columns) numbers of a matrix at `count` states."""
    flat: list[Any] = [np.broadcast_to(x.evaluate(values), (count,)) for row in A for x in row]
    return np.stack(flat, axis=-1).reshape(count, len(A), len(A[0]))
