"""Equations of motion of any system whose energies one can write down.

Formulas typed by people as polynomials in names, sines and cosines.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.document import Derivation, Grid, Line, Name, Step
from mafsil.derivation.expression import glyph
from mafsil.derivation.formula_text import evaluate, parse_formula
from mafsil.derivation.polynomial import (
    Angle,
    Factor,
    Polynomial,
    Row,
    Symbol,
    Values,
    angle_sum,
    constant,
    simplify,
    symbol,
    trig,
)
from mafsil.derivation.tolerances import COMPLEX_STEP, DIFFERENT
from mafsil.derivation.verification import LIMIT, STATES, DerivationError
from mafsil.errors import InputError

FORCE_UNITS = {"m": "N", "rad": "N m"}
"""Energy per unit of the coordinate: the unit of the generalized force."""
_STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
"""Places and weights of the derivative by differences of fourth order."""


def derive_lagrange(
    kinetic: str,
    potential: str,
    coordinates: Sequence[str] | Mapping[str, str],
    *,
    newton: Mapping[str, str] | None = None,
    name: str = "",
) -> Derivation:
    """f_i = d/dt dL/d(dq_i) - dL/dq_i with L = K - P, step by step, for a system given by its energies.

    The pairing f . dq is work and f . (dq/dt) power, so a force has the unit of energy per unit of its coordinate. Set
    f = 0 for the motion without forces. Every line is compared with the energies themselves, differentiated
    numerically at random states. To try: the particle `derive_lagrange("m*dx**2/2", "m*g*x", {"x": "m"})`.

    Args:
        kinetic: K as a formula of the coordinates, their rates and any letters; the rate of `x` is called `dx`.
        potential: P, of the coordinates and letters; its zero is where the formula has it.
        coordinates: independent names, each one's unit with it (`m` or `rad`); without units angles are the names that
            stand within sines and cosines.
        newton: for some coordinates the force as you found it otherwise (accelerations `ddx`): compared, and shown
            beside.
        name: of the system, for the title.

    Returns:
        The derivation; `to_text`, `to_latex` and `to_html` write it. Its last step holds M of K = q' M q / 2.

    Raises:
        InputError: a formula that is no polynomial in names, sines and cosines, a coordinate twice or nowhere in the
            energies, a rate in P, an unknown unit, a force in `newton` that is not the one derived.

    Reference: Lynch & Park, Modern Robotics, eq. 8.1 and sec. 8.1.1.
    """
    K, P = polynomial_of(kinetic), polynomial_of(potential)
    system = _System(K, P, _with_units(coordinates, K - P))
    judge = _Judge(system, kinetic, potential)
    L, forces = system.lagrangian, system.forces()
    momenta = system.momenta()
    steps = [
        Step("derivation.lagrange_coordinates", {}, (), _table(system)),
        Step(
            "derivation.lagrange_energies",
            {},
            (
                judge.line("K", "", K, judge.energy(kinetic)),
                judge.line("P", "", P, judge.energy(potential)),
                judge.line("L", "", L, judge.energy(kinetic) - judge.energy(potential)),
            ),
        ),
        Step("derivation.lagrange_momenta", {}, judge.lines("p", momenta, judge.momenta())),
        Step("derivation.lagrange_slopes", {}, judge.slope_lines(system.slopes())),
        Step("derivation.lagrange_forces", {}, judge.lines("f", forces, judge.forces())),
    ]
    if newton:
        steps.append(_compare(judge, newton, forces))
    steps.append(Step("derivation.lagrange_mass_matrix", {}, judge.mass_matrix()))
    title = name or ", ".join(system.names)
    return Derivation("derivation.lagrange_title", title, tuple(steps), STATES, "derivation.lagrange_checked")


@dataclass(frozen=True, slots=True, eq=False)
class _System:
    """Energies in letters, and what follows from them; n coordinates with their units."""

    K: Polynomial
    P: Polynomial
    units: Mapping[str, str]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.units)

    @property
    def lagrangian(self) -> Polynomial:
        return self.K - self.P

    def momenta(self) -> Row:
        """dL/d(dq_i)."""
        return tuple(simplify(self.K.derivative("d" + name)) for name in self.names)

    def slopes(self) -> Row:
        """dL/dq_i."""
        return tuple(simplify(self.lagrangian.derivative(name)) for name in self.names)

    def forces(self) -> Row:
        """The derivative of each momentum along the motion, less dL/dq_i."""
        return tuple(simplify(self._rate(p) - s) for p, s in zip(self.momenta(), self.slopes(), strict=True))

    def _rate(self, p: Polynomial) -> Polynomial:
        total = constant(0.0)
        for name in self.names:
            total = total + p.derivative(name) * symbol("d" + name) + p.derivative("d" + name) * symbol("dd" + name)
        return total


class _Judge:
    """The energies as typed, differentiated by numbers alone: complex steps for slopes, differences in time."""

    def __init__(self, system: _System, kinetic: str, potential: str) -> None:
        self.system = system
        self._K, self._P = parse_formula(kinetic), parse_formula(potential)
        rng = np.random.default_rng(11)
        names = {name for polynomial in (system.K, system.P) for name in _letters(polynomial)}
        names |= {order + name for name in system.names for order in ("", "d", "dd")}
        self.values: dict[str, Floats] = {name: rng.uniform(0.5, 1.5, STATES) for name in sorted(names)}

    def energy(self, text: str) -> Floats:
        return np.real(evaluate(parse_formula(text), self.values)) + np.zeros(STATES)

    def slopes(self) -> list[Floats]:
        return [self._slope(name, self.values) for name in self.system.names]

    def momenta(self) -> list[Floats]:
        return [self._slope("d" + name, self.values) for name in self.system.names]

    def forces(self) -> list[Floats]:
        """Momenta at four instants around, and the slopes now."""
        found: list[Floats] = []
        for name in self.system.names:
            rate = sum(w * self._slope("d" + name, self._after(k * DIFFERENT)) for k, w in _STENCIL) / DIFFERENT
            found.append(rate - self._slope(name, self.values))
        return found

    def _after(self, t: float) -> dict[str, Floats]:
        moved = dict(self.values)
        for name in self.system.names:
            q, qd, qdd = (self.values[order + name] for order in ("", "d", "dd"))
            moved[name], moved["d" + name] = q + t * qd + t * t / 2 * qdd, qd + t * qdd
        return moved

    def _slope(self, name: str, values: Mapping[str, Floats]) -> Floats:
        stepped = {**values, name: values[name] + 1j * COMPLEX_STEP}
        return np.imag(evaluate(self._K, stepped) - evaluate(self._P, stepped)) / COMPLEX_STEP + np.zeros(STATES)

    def line(self, letter: str, index: str, formula: Polynomial, truth: Floats) -> Line:
        """A line compared with numbers.

        Raises:
            DerivationError: it differs.
        """
        scale = max(1.0, float(np.abs(truth).max()))
        error = float(np.abs(formula.evaluate(self.values) - truth).max())
        if error > LIMIT * scale:
            raise DerivationError("derivation.differs", line=letter + index, error=error, limit=LIMIT * scale)
        return Line((Name(letter, index),), (formula,), error)

    def lines(self, letter: str, formulas: Row, truths: Sequence[Floats]) -> tuple[Line, ...]:
        return tuple(
            self.line(letter, _index(name), formula, truth)
            for name, formula, truth in zip(self.system.names, formulas, truths, strict=True)
        )

    def slope_lines(self, formulas: Row) -> tuple[Line, ...]:
        return tuple(
            self.line(f"∂L/∂{_index(name)}", "", formula, truth)
            for name, formula, truth in zip(self.system.names, formulas, self.slopes(), strict=True)
        )

    def mass_matrix(self) -> tuple[Line, ...]:
        """m_ij = d2K/d(dq_i)d(dq_j): the slope of a momentum, linear in the rates."""
        lines: list[Line] = []
        names, momenta = self.system.names, self.system.momenta()
        for i, p in enumerate(momenta):
            for j in range(i, len(names)):
                at_unit, at_rest = dict(self.values), dict(self.values)
                for k, name in enumerate(names):
                    at_unit["d" + name], at_rest["d" + name] = np.full(STATES, float(k == j)), np.zeros(STATES)
                truth = self._slope("d" + names[i], at_unit) - self._slope("d" + names[i], at_rest)
                entry = simplify(p.derivative("d" + names[j]))
                if {"d" + name for name in names} & _letters(entry):
                    return ()
                lines.append(self.line("M", f"{i + 1}{j + 1}", entry, truth))
        return tuple(lines)


def _with_units(coordinates: Sequence[str] | Mapping[str, str], L: Polynomial) -> Mapping[str, str]:
    """Each coordinate's unit, checked.

    Raises:
        InputError: see `derive_lagrange`.
    """
    if isinstance(coordinates, str):
        coordinates = [name for name in coordinates.replace(",", " ").split() if name]
    angles = {name for monomial in L.terms for f in monomial if not isinstance(f, Symbol) for name, _ in f.angle}
    given = dict(coordinates) if isinstance(coordinates, Mapping) else None
    names = list(coordinates)
    known = _letters(L)
    for name in names:
        if names.count(name) > 1 or ("d" + name not in known and name not in known):
            raise InputError("derivation.lagrange_coordinate", name=name, known=", ".join(sorted(known)))
    units = given or {name: "rad" if name in angles else "m" for name in names}
    for name, unit in units.items():
        if unit not in FORCE_UNITS:
            raise InputError("input.choice", name=name, value=unit, known=", ".join(FORCE_UNITS))
    if not names:
        raise InputError("derivation.lagrange_coordinate", name="", known=", ".join(sorted(known)))
    return units


def _letters(polynomial: Polynomial) -> set[str]:
    def names(factor: Factor) -> list[str]:
        return [factor.name] if isinstance(factor, Symbol) else [name for name, _ in factor.angle]

    return {name for monomial in polynomial.terms for factor in monomial for name in names(factor)}


def _table(system: _System) -> Grid:
    rows = tuple((symbol(name), unit, FORCE_UNITS[unit]) for name, unit in system.units.items())
    return Grid((Name("q"), "[q]", "[f]"), rows)


def _index(name: str) -> str:
    found = glyph(name)
    return found.letter + found.below


def _compare(judge: _Judge, newton: Mapping[str, str], forces: Row) -> Step:
    """The user's own forces beside the derived ones.

    Raises:
        InputError: one differs, or belongs to no coordinate.
    """
    lines: list[Line] = []
    for name, text in newton.items():
        if name not in judge.system.names:
            known = ", ".join(judge.system.names)
            raise InputError("input.choice", name="newton", value=name, known=known)
        derived, own = forces[judge.system.names.index(name)], polynomial_of(text)
        if not (derived - own).multiplied_out().is_zero:
            raise InputError("derivation.lagrange_newton", name=name, text=text[:80])
        values: Values = judge.values
        lines.append(judge.line("f", _index(name), own, np.asarray(derived.evaluate(values)) + np.zeros(STATES)))
    return Step("derivation.lagrange_compared", {}, tuple(lines))


def polynomial_of(text: str) -> Polynomial:
    """A typed formula, multiplied out.

    Args:
        text: numbers, names, + - * and whole powers, division by numbers, sin and cos of sums of named angles with
            whole multiples, such as `m*dx**2/2 - m*g*l*cos(theta)`.

    Raises:
        InputError: it is no formula, or divides by a name, takes a root, or turns by something else than named angles.
    """
    return _polynomial(parse_formula(text), text)


def _polynomial(tree: ast.expr, text: str) -> Polynomial:
    match tree:
        case ast.Constant(value=value):
            return constant(float(cast("float", value)))
        case ast.Name(id=name):
            return symbol(name)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_polynomial(operand, text)
        case ast.UnaryOp(operand=operand):
            return _polynomial(operand, text)
        case ast.Call(func=ast.Name(id=("sin" | "cos") as name), args=[argument]):
            return trig(name == "sin", _angle(argument, text))
        case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=power)):
            return _power(_polynomial(left, text), cast("int", power))
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return _polynomial(left, text) * constant(1.0 / _divisor(right, text))
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return _polynomial(left, text) * _polynomial(right, text)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _polynomial(left, text) + _polynomial(right, text)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            return _polynomial(left, text) - _polynomial(right, text)
        case _:
            raise InputError("derivation.formula_polynomial", text=text[:80])


def _power(base: Polynomial, power: int) -> Polynomial:
    total = constant(1.0)
    for _ in range(power):
        total = total * base
    return total


def _divisor(tree: ast.expr, text: str) -> float:
    """The number that stands below the line."""
    terms = _polynomial(tree, text).terms
    if list(terms) != [()]:
        raise InputError("derivation.formula_polynomial", text=text[:80])
    return terms[()]


def _angle(tree: ast.expr, text: str) -> Angle:
    """Whole multiples of names, added."""
    total: Angle = ()
    for monomial, number in _polynomial(tree, text).terms.items():
        names = [getattr(factor, "name", "") for factor in monomial]
        if len(names) != 1 or not names[0] or number != int(number):
            raise InputError("derivation.formula_polynomial", text=text[:80])
        total = angle_sum(total, ((names[0], int(number)),))
    return total
