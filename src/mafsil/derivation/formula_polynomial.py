"""Formulas typed by people as polynomials in names, sines and cosines."""

from __future__ import annotations

import ast
from typing import cast

from mafsil.derivation.formula_text import parsed
from mafsil.derivation.polynomial import Angle, Polynomial, angle_sum, constant, symbol, trig
from mafsil.errors import InputError


def polynomial_of(text: str) -> Polynomial:
    """A typed formula, multiplied out.

    Args:
        text: numbers, names, + - * and whole powers, division by numbers, sin and cos of sums of named angles with
            whole multiples, such as `m*dx**2/2 - m*g*l*cos(theta)`.

    Raises:
        InputError: it is no formula, or divides by a name, takes a root, or turns by something else than named angles.
    """
    return _polynomial(parsed(text), text)


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
