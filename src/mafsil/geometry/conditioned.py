"""Array functions from one description each: a signature with shapes and conditions, a docstring, an expression's name.

    @compiled("se3.log")
    def log(T: PoseLike) -> Vector6:
        \"\"\"Exponential coordinates V = (omega, v) of a displacement, |omega| in [0, pi]. ...\"\"\"
        ...

is the compiled expression `mafsil.algebra.se3.log`: its inputs are the arguments, with the shapes of their annotations
and refused, or mended, where they do not meet the condition there; its outputs have the shapes of the results.

What array functions take: the shape of every argument, and the condition that it must meet, in its annotation.

To a type checker all are ArrayLike: numbers, nested lists, arrays, and what other libraries call a rotation or a pose.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import update_wrapper
from types import FunctionType
from typing import Annotated, Any, TypeAlias, TypeVar, cast, get_args, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Shape, Symbolic, as_batch
from mafsil.geometry import membership
from mafsil.geometry.membership import CORES, Declared, Member, Ports

ScalarLike: TypeAlias = Annotated[ArrayLike, Shape("*batch")]
Vector2Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 2)]
Vector3Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 3)]
Vector6Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 6)]
QuaternionLike: TypeAlias = Annotated[ArrayLike, Shape("*batch", 4)]
Matrix3Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 3, 3)]
Matrix4Like: TypeAlias = Annotated[ArrayLike, Shape("*batch", 4, 4)]
AmountLike: TypeAlias = Annotated[ArrayLike, Member("amount")]
AxisLike: TypeAlias = Annotated[ArrayLike, Member("axis")]
AxisTripleLike: TypeAlias = Annotated[ArrayLike, Member("axis_triple")]
DurationLike: TypeAlias = Annotated[ArrayLike, Member("duration")]
ExponentialCoordinatesLike: TypeAlias = Annotated[ArrayLike, Member("exponential_coordinates")]
NonzeroQuaternionLike: TypeAlias = Annotated[ArrayLike, Member("quaternion")]
PartTurnLike: TypeAlias = Annotated[ArrayLike, Member("part_turn")]
PlanarCoordinatesLike: TypeAlias = Annotated[ArrayLike, Member("planar_coordinates")]
PlanarPoseLike: TypeAlias = Annotated[ArrayLike, Member("planar_pose")]
PlanarRotationLike: TypeAlias = Annotated[ArrayLike, Member("planar_rotation")]
PoseLike: TypeAlias = Annotated[ArrayLike, Member("pose")]
RotationLike: TypeAlias = Annotated[ArrayLike, Member("rotation")]
RotationVectorLike: TypeAlias = Annotated[ArrayLike, Member("rotation_vector")]
UnitQuaternionLike: TypeAlias = Annotated[ArrayLike, Member("unit_quaternion")]
UnitScrewLike: TypeAlias = Annotated[ArrayLike, Member("unit_screw")]
Function = TypeVar("Function", bound=Callable[..., Any])


class Conditioned(Declared):
    """A declared function whose arguments meet conditions: one that does not is refused.

    Args:
        source, inputs, outputs, constants: as `Declared`.
        conditions: argument -> name of the condition it must meet (`membership`).
    """

    def __init__(
        self,
        source: str,
        inputs: str | Ports,
        outputs: str | Ports,
        *constants: object,
        conditions: Mapping[str, str],
    ) -> None:
        super().__init__(source, inputs, outputs, *constants)
        self.conditions = dict(conditions)

    def evaluation(self) -> Callable[..., Any]:
        """The kernel's call, followed by a look for NaN: the mark of a condition that is not met, or of a NaN given.

        Matrices that were printed with few digits are mended, and the kernel called again.
        """
        call, single_output, shape = self.kernel.call, len(self.outputs) == 1, self.outputs[0][1]
        core_dimensions, first_number = len(shape), (..., *(0,) * len(shape))

        def evaluate(*args: Any) -> Any:
            result = call(*args)
            first = result if single_output else result[0]
            if isinstance(first, Symbolic):
                return result
            if first.ndim == core_dimensions:
                number = first.item(0)
                marked = number != number
            else:
                marked = np.isnan(first[first_number]).any()
            if marked and (better := self._admitted(args)) is not args:
                return call(*better)
            return result

        return evaluate

    def _admitted(self, args: tuple[Any, ...]) -> tuple[Any, ...]:
        """The arguments themselves if all meet their conditions, or with those mended that nearly do."""
        better = list(args)
        for k, (name, core) in enumerate(self.inputs):
            if name in self.conditions:
                given = as_batch(name, args[k], core)
                required = membership.require(self.conditions[name], name, given)
                better[k] = args[k] if required is given else required
        return args if all(new is old for new, old in zip(better, args, strict=True)) else tuple(better)

    def __reduce__(self) -> tuple[Any, ...]:
        return _condition, (self.source, self.inputs, self.outputs, self.constants, self.conditions)


def _condition(
    source: str, inputs: Ports, outputs: Ports, constants: tuple[object, ...], conditions: Mapping[str, str]
) -> Conditioned:
    return Conditioned(source, inputs, outputs, *constants, conditions=conditions)


def compile_function(source: str, *constants: object) -> Callable[[Function], Function]:
    """The array function that a signature describes; its attribute `declared` is the compiled expression.

    Args:
        source: `module.function` of `mafsil.algebra`.
        constants: further arguments of the expression, such as the name of an Euler sequence.
    """

    def of(described: Function) -> Function:
        declared = _declare(cast("FunctionType", described), source, constants)
        made = _calling(cast("FunctionType", described), declared)
        made.__dict__["declared"] = declared
        return cast("Function", made)

    return of


def _declare(described: FunctionType, source: str, constants: tuple[object, ...]) -> Declared:
    """The compiled expression whose ports are the annotations."""
    hints = get_type_hints(described, include_extras=True)
    result = hints.pop("return")
    results = get_args(result) if not hasattr(result, "__metadata__") else (result,)
    inputs = tuple((name, _core(hint)) for name, hint in hints.items())
    outputs = tuple((f"result_{k}" if len(results) > 1 else "result", _core(hint)) for k, hint in enumerate(results))
    conditions = {name: said.kind for name, hint in hints.items() for said in _say(hint) if isinstance(said, Member)}
    if conditions:
        return Conditioned(source, inputs, outputs, *constants, conditions=conditions)
    return Declared(source, inputs, outputs, *constants)


def _say(annotation: Any) -> tuple[object, ...]:
    return annotation.__metadata__


def _core(annotation: Any) -> tuple[int, ...]:
    """The dimensions behind `*batch`, of a shape or of a kind of member."""
    said = _say(annotation)[0]
    if isinstance(said, Member):
        return CORES[said.kind]
    return tuple(int(each) for each in cast("Shape", said).dimensions[1:])


def _calling(described: FunctionType, declared: Declared) -> FunctionType:
    """A function with the described name, arguments, defaults and docstring that evaluates the declared one.

    Its code is that of one of three templates, one for each number of arguments, with the described names put in: a
    call by position costs what a function written by hand costs, a call by name works, inspection sees the description.
    """

    def evaluate(*args: Any) -> Any:
        """The first evaluation compiles, or loads, the kernel, which takes this function's place."""
        nonlocal evaluate
        result = declared(*args)
        evaluate = declared.at
        return result

    def one(a: Any) -> Any:
        return evaluate(a)

    def two(a: Any, b: Any) -> Any:
        return evaluate(a, b)

    def three(a: Any, b: Any, c: Any) -> Any:
        return evaluate(a, b, c)

    template = cast("FunctionType", (one, two, three)[len(declared.inputs) - 1])
    code = template.__code__.replace(
        co_name=described.__name__,
        co_qualname=described.__qualname__,
        co_varnames=tuple(name for name, _ in declared.inputs),
        co_filename=described.__code__.co_filename,
        co_firstlineno=described.__code__.co_firstlineno,
    )
    made = FunctionType(code, described.__globals__, described.__name__, described.__defaults__, template.__closure__)
    update_wrapper(made, described)
    del made.__dict__["__wrapped__"]
    return made
