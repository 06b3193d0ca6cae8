"""Eight numbers side by side in compiled loops: a type for them, so that a loop is written once for eight problems.

Numba's own vectoriser has to prove that arrays do not overlap and that trip counts are large; here a variable is eight
lanes by its type, sums stay in registers, and nothing is left to prove. LLVM splits the lanes where a processor's
vectors are narrower. What a loop may write:

- `Lanes` with + - * /, unary -, comparisons (to a `Mask`), and numbers, which are the same in all lanes;
- `Mask` with & | ~; `where(mask, a, b)`, `any_lane(mask)`, `lane_bits(mask)` (bit l for lane l),
  `how_many(bits)`;
- `square_root`, `magnitude`, `rounded_down`, `larger`, `smaller`, `lanes(number)`;
- `buffer(n)` (n a literal): n lanes on the stack, `r[i]` and `r[i] = x`; `part(r, i)`: the buffer that begins at i;
  `seen(array)`: a float64 array as a buffer, whose rows are in order;
- `in_lanes(n)`: an array for n lanes, to be `seen`;
- `put(r, i, l, number)` and `get(r, i, l)`: one lane of place i;
- `spread(array, begin, stride, x)`: lane l to the flat array at begin + l stride;
- `looked_up(array, places)`: in lane l what stands in a flat float64 array at the place that lane l of `places` names.

Products and sums may be contracted to one rounding. Nothing is reordered: the same numbers in any lane give the same
result, whatever stands beside them.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, register_model

from mafsil.arrays import Floats
from mafsil.solvers.loops import compiled, inlined, reordered

ir = cgutils.ir
"""LLVM as numba writes it."""

WIDTH = 8
"""Lanes."""

Generate: TypeAlias = Callable[[Any, Any, Any, Any], Any]
"""What writes an operation: numba's context, the builder, types and values of the arguments; gives the result."""

_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
_BITS = ir.VectorType(ir.IntType(1), WIDTH)
_INT = ir.IntType(32)
_FLAGS = ("contract", "nsz")
_emitted, _resolved = intrinsic, infer_global


class _LanesType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="lanes8")


class _MaskType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="mask8")


class _BufferType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="room8")


LANES, MASK, BUFFER = _LanesType(), _MaskType(), _BufferType()
NUMBER = types.float64


def _model(kind: Any, backend: Any) -> None:
    class Model(models.PrimitiveModel):
        def __init__(self, dmm: Any, fe_type: Any) -> None:
            super().__init__(dmm, fe_type, backend)

    register_model(kind)(Model)


_model(_LanesType, _VECTOR)
_model(_MaskType, _BITS)
_model(_BufferType, _VECTOR.as_pointer())


def _broadcast(builder: Any, value: Any) -> Any:
    first = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, _INT(0))
    zeros = ir.Constant(ir.VectorType(_INT, WIDTH), None)
    return builder.shuffle_vector(first, ir.Constant(_VECTOR, ir.Undefined), zeros)


def _wide(builder: Any, kind: Any, value: Any) -> Any:
    return value if kind is LANES else _broadcast(builder, value)


def _pairs(function: Any, result: Any, emit: Callable[[Any, Any, Any], Any]) -> None:
    """One operator on lanes, and on lanes and numbers in either order."""
    pairs = ((LANES, LANES), (LANES, NUMBER), (NUMBER, LANES))

    class Template(ConcreteTemplate):
        cases: ClassVar[list[Any]] = [signature(result, *pair) for pair in pairs]

    _resolved(function)(Template)

    def lowered(_context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return emit(builder, *(_wide(builder, kind, value) for kind, value in zip(sig.args, args, strict=True)))

    for pair in pairs:
        lower_builtin(function, *pair)(lowered)


def _arithmetic(name: str) -> Callable[[Any, Any, Any], Any]:
    return lambda builder, a, b: getattr(builder, name)(a, b, flags=_FLAGS)


def _comparison(sign: str) -> Callable[[Any, Any, Any], Any]:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


_of: Any = operator
for _plain, _inplace, _name in (
    (_of.add, _of.iadd, "fadd"),
    (_of.sub, _of.isub, "fsub"),
    (_of.mul, _of.imul, "fmul"),
    (_of.truediv, _of.itruediv, "fdiv"),
):
    _pairs(_plain, LANES, _arithmetic(_name))
    _pairs(_inplace, LANES, _arithmetic(_name))
for _plain, _sign in ((_of.lt, "<"), (_of.gt, ">"), (_of.le, "<="), (_of.ge, ">=")):
    _pairs(_plain, MASK, _comparison(_sign))
_pairs(_of.eq, MASK, _comparison("=="))


def _single(function: Any, sig: Any, emit: Callable[[Any, Any], Any]) -> None:
    class Template(ConcreteTemplate):
        cases: ClassVar[list[Any]] = [sig]

    _resolved(function)(Template)

    def lowered(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return emit(builder, args)

    lower_builtin(function, *sig.args)(lowered)


_single(_of.neg, signature(LANES, LANES), lambda builder, args: builder.fneg(args[0]))
_single(_of.invert, signature(MASK, MASK), lambda builder, args: builder.not_(args[0]))
_single(_of.and_, signature(MASK, MASK, MASK), lambda builder, args: builder.and_(args[0], args[1]))
_single(_of.or_, signature(MASK, MASK, MASK), lambda builder, args: builder.or_(args[0], args[1]))


def _place(builder: Any, place: Any, index: Any) -> Any:
    return builder.gep(place, [index])


def _load(builder: Any, place: Any, index: Any) -> Any:
    value = builder.load(_place(builder, place, index))
    value.align = 8
    return value


def _store(builder: Any, place: Any, index: Any, value: Any) -> None:
    builder.store(value, _place(builder, place, index), align=8)


class _GetItem(ConcreteTemplate):
    cases: ClassVar[list[Any]] = [signature(LANES, BUFFER, types.intp)]


class _SetItem(ConcreteTemplate):
    cases: ClassVar[list[Any]] = [signature(types.none, BUFFER, types.intp, kind) for kind in (LANES, NUMBER)]


_resolved(operator.getitem)(_GetItem)
_resolved(operator.setitem)(_SetItem)


@lower_builtin(operator.getitem, BUFFER, types.intp)
def _getitem(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
    return _load(builder, args[0], args[1])


@lower_builtin(operator.setitem, BUFFER, types.intp, LANES)
@lower_builtin(operator.setitem, BUFFER, types.intp, NUMBER)
def _setitem(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    _store(builder, args[0], args[1], _wide(builder, sig.args[2], args[2]))
    return context.get_dummy_value()


@_emitted
def lanes(_typing: Any, _number: Any) -> tuple[Any, Generate]:
    """A number in all lanes."""
    return LANES(NUMBER), lambda _context, builder, _sig, args: _broadcast(builder, args[0])


def _called(builder: Any, name: str, value: Any) -> Any:
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(_VECTOR, [_VECTOR]), f"llvm.{name}.v{WIDTH}f64"
    )
    return builder.call(function, [value])


@_emitted
def square_root(_typing: Any, x: Any) -> tuple[Any, Generate]:
    """The root of each lane, and of a number."""
    return LANES(LANES), lambda _context, builder, _sig, args: _called(builder, "sqrt", args[0])


@_emitted
def magnitude(_typing: Any, x: Any) -> tuple[Any, Generate]:
    """The absolute value of each lane."""
    return LANES(LANES), lambda _context, builder, _sig, args: _called(builder, "fabs", args[0])


@_emitted
def rounded_down(_typing: Any, x: Any) -> tuple[Any, Generate]:
    """The greatest whole number not above each lane."""
    return LANES(LANES), lambda _context, builder, _sig, args: _called(builder, "floor", args[0])


@_emitted
def where(_typing: Any, mask: Any, a: Any, b: Any) -> tuple[Any, Generate]:
    """Lanes of a where the mask is set, else of b; either may be a number."""
    sig = LANES(MASK, *(LANES if kind is LANES else NUMBER for kind in (a, b)))

    def generate(_context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (_wide(builder, kind, value) for kind, value in zip(sig.args[1:], args[1:], strict=True))
        return builder.select(args[0], a, b)

    return sig, generate


@_emitted
def lane_bits(_typing: Any, mask: Any) -> tuple[Any, Generate]:
    """Bit l for lane l."""

    def generate(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        return builder.zext(builder.bitcast(args[0], ir.IntType(WIDTH)), ir.IntType(64))

    return types.int64(MASK), generate


@_emitted
def how_many(_typing: Any, bits: Any) -> tuple[Any, Generate]:
    """Bits of a whole number that are set."""
    return types.int64(types.int64), lambda _context, builder, _sig, args: builder.ctpop(args[0])


@_emitted
def any_lane(_typing: Any, mask: Any) -> tuple[Any, Generate]:
    """Whether a lane of the mask is set."""

    def generate(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", bits, bits.type(0))

    return types.boolean(MASK), generate


@_emitted
def buffer(_typing: Any, count: Any) -> tuple[Any, Generate] | None:
    """Lanes on the stack, as many as a literal says; they hold nothing yet."""
    if not isinstance(count, types.IntegerLiteral):
        return None
    size = count.literal_value

    def generate(_context: Any, builder: Any, _sig: Any, _args: Any) -> Any:
        with builder.goto_entry_block():
            place = builder.alloca(ir.ArrayType(_VECTOR, size))
            place.align = 64
        return builder.bitcast(place, _VECTOR.as_pointer())

    return BUFFER(count), generate


@_emitted
def part(_typing: Any, place: Any, index: Any) -> tuple[Any, Generate]:
    """The buffer that begins at a place of another."""
    return BUFFER(BUFFER, types.intp), lambda _context, builder, _sig, args: _place(builder, args[0], args[1])


def _numbers(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    array = context.make_array(kind)(context, builder, value)
    return array.data


@_emitted
def seen(_typing: Any, array: Any) -> tuple[Any, Generate]:
    """A float64 array whose rows are in order, as a buffer."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.bitcast(_numbers(context, builder, sig.args[0], args[0]), _VECTOR.as_pointer())

    return BUFFER(array), generate


@_emitted
def looked_up(_typing: Any, array: Any, places: Any) -> tuple[Any, Generate]:
    """In each lane the number of a flat float64 array at its place; whoever asks keeps the places inside."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        numbers = _numbers(context, builder, sig.args[0], args[0])
        whole = builder.fptosi(args[1], ir.VectorType(ir.IntType(64), WIDTH))
        found = ir.Constant(_VECTOR, ir.Undefined)
        for lane in range(WIDTH):
            place = builder.gep(numbers, [builder.extract_element(whole, _INT(lane))])
            found = builder.insert_element(found, builder.load(place), _INT(lane))
        return found

    return LANES(array, LANES), generate


@_emitted
def put(_typing: Any, place: Any, index: Any, lane: Any, value: Any) -> tuple[Any, Generate]:
    """One lane of a place set."""

    def generate(context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        begin = builder.bitcast(_place(builder, args[0], args[1]), ir.DoubleType().as_pointer())
        builder.store(args[3], builder.gep(begin, [args[2]]))
        return context.get_dummy_value()

    return types.none(BUFFER, types.intp, types.intp, NUMBER), generate


@_emitted
def get(_typing: Any, place: Any, index: Any, lane: Any) -> tuple[Any, Generate]:
    """One lane of a place."""

    def generate(_context: Any, builder: Any, _sig: Any, args: Any) -> Any:
        begin = builder.bitcast(_place(builder, args[0], args[1]), ir.DoubleType().as_pointer())
        return builder.load(builder.gep(begin, [args[2]]))

    return NUMBER(BUFFER, types.intp, types.intp), generate


@_emitted
def spread(_typing: Any, array: Any, begin: Any, stride: Any, x: Any) -> tuple[Any, Generate]:
    """Lane l to the array, seen as flat, at begin + l stride."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = _numbers(context, builder, sig.args[0], args[0])
        for lane in range(WIDTH):
            at = builder.add(args[1], builder.mul(args[2], args[2].type(lane)))
            builder.store(builder.extract_element(args[3], _INT(lane)), builder.gep(data, [at]))
        return context.get_dummy_value()

    return types.none(array, types.intp, types.intp, LANES), generate


@compiled
def in_lanes(count: int) -> Floats:
    """An array for so many lanes that begins with a cache line: keep it as long as what is `seen` of it."""
    numbers = np.empty((count + 1) * WIDTH)
    beyond = (numbers.ctypes.data // 8) % WIDTH
    return numbers[(WIDTH - beyond) % WIDTH :]


@inlined
def larger(a: Any, b: Any) -> Any:
    """The larger of both in each lane; the second may be a number."""
    return where(a > b, a, b)


@inlined
def smaller(a: Any, b: Any) -> Any:
    """The smaller of both in each lane; the second may be a number."""
    return where(a < b, a, b)


@reordered
def angle_of(cosine: Any, sine: Any) -> Any:
    """The angle in (-pi, pi] of cosine and sine up to a factor, in each lane, within 2 ulp.

    1. Of the larger over the smaller component only tan x <= 1 is left, and beyond tan (pi / 8) it is turned by pi / 4.
    2. atan x = x + x^3 P(x^2) / Q(x^2) (Moshier, Cephes, 1995).
    3. The turns of step 1 are undone, and the signs put back.
    """
    # 1.
    a, b = magnitude(cosine), magnitude(sine)
    steep = b > a
    low, high = where(steep, a, b), where(steep, b, a)
    turned = low > 0.41421356237309503 * high
    x = where(turned, low - high, low) / where(turned, low + high, where(high > 0.0, high, 1.0))
    # 2.
    z = x * x
    p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1) * z
         - 1.228866684490136173410e2) * z - 6.485021904942025371773e1  # fmt: skip
    q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2) * z
         + 4.853903996359136964868e2) * z + 1.945506571482613964425e2  # fmt: skip
    angle = x + x * z * (p / q)
    # 3.
    angle = where(turned, 0.78539816339744830962 + (angle + 3.061616997868383e-17), angle)
    angle = where(steep, 1.57079632679489661923 - (angle - 6.123233995736766e-17), angle)
    angle = where(cosine < 0.0, 3.14159265358979323846 - (angle - 1.2246467991473532e-16), angle)
    return where((sine < 0.0) & (angle < 3.14159265358979323846), -angle, angle)
