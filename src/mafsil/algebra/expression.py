"""An algebra function by its name, as a function with one column per port, elements in C order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from math import nan

import mafsil.expression as ex
from mafsil.algebra.membership import is_member

Shape = tuple[int, ...]


def function(
    source: str,
    inputs: Sequence[tuple[str, Shape]],
    outputs: Sequence[tuple[str, Shape]],
    conditions: Mapping[str, str] | None = None,
    constants: Sequence[object] = (),
) -> ex.Function:
    """The function of symbols.

    Args:
        source: `module.function` of this package.
        inputs: name and core shape of every argument that is an expression, in order; at most two dimensions.
        outputs: name and core shape of every result.
        conditions: argument name -> kind it must be a member of (`membership.MEASURES`); where it is not, every
            result is NaN.
        constants: further arguments, after the expressions.
    """
    columns = [ex.symbol(name, max(1, _size(shape))) for name, shape in inputs]
    arguments = [_shape(column, shape) for column, (_, shape) in zip(columns, inputs, strict=True)]
    answer = _find(source)(*arguments, *constants)
    results = list(answer) if isinstance(answer, tuple) else [answer]
    names = [name for name, _ in inputs]
    for name, condition in (conditions or {}).items():
        met = is_member(condition, arguments[names.index(name)])
        results = [ex.if_else(met, result, nan) for result in results]
    flat = [ex.vec(ex.Expression(result).T) for result in results]
    return ex.Function(source.replace(".", "_"), columns, flat, names, [name for name, _ in outputs], cse=True)


def _find(source: str) -> Callable[..., ex.Expression | tuple[ex.Expression, ...]]:
    module, _, name = source.partition(".")
    return getattr(import_module(f"mafsil.algebra.{module}"), name)


def _shape(column: ex.Expression, shape: Shape) -> ex.Expression:
    return ex.reshape(column, shape[1], shape[0]).T if len(shape) == 2 else column


def _size(shape: Shape) -> int:
    size = 1
    for length in shape:
        size *= length
    return size
