"""Functions of Python, NumPy and lanes that loops may call, and the instructions that each of them becomes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from mafsil.kernels.loops import arrays, lanes, library, numbers
from mafsil.kernels.loops import entry as held
from mafsil.kernels.loops.block import Block, Translator, Value, constant
from mafsil.kernels.loops.kinds import (
    BITS,
    BOOL,
    BUFFER,
    COMPLEX,
    INTEGER,
    LANES,
    MASK,
    NONE,
    REAL,
    SINGLE,
    UNSIGNED,
    VECTOR,
    WIDTH,
    Array,
    Held,
    Number,
    Tuple,
    refusal,
)
from mafsil.kernels.loops.numbers import convert

Emit = Callable[[Translator, list[Value]], Value]


def _length(of: Translator, given: list[Value]) -> Value:
    (value,) = given
    if isinstance(value.kind, Tuple):
        return constant(len(value.kind.items))
    return arrays.sizes(value)[0]


def _extreme(order: str) -> Emit:
    def emit(of: Translator, given: list[Value]) -> Value:
        if len(given) == 1 and isinstance(given[0].kind, Tuple):
            given = [of.block.item(given[0], i) for i in range(len(given[0].kind.items))]
        if len(given) == 1:
            return of.call_loop(library.METHODS["min" if order == "<" else "max"], given)
        if all(value.constant is not None for value in given):
            known: list[Any] = [value.constant for value in given]
            return constant(min(known) if order == "<" else max(known))
        kind = max((value.kind for value in given), key=lambda each: each.rank if isinstance(each, Number) else -1)
        best, *others = (convert(of.block, value, kind) for value in given)
        natural = (all if order == "<" else any)(value.natural for value in given)
        for other in others:
            better = numbers.compare(of.block, order, other, best)
            best = numbers.select_value(of.block, better.name, other, best)
        return Value(kind, best.parts, None, natural and kind is INTEGER)

    return emit


def _absolute(of: Translator, given: list[Value]) -> Value:
    (value,) = given
    if isinstance(value.kind, Array):
        made = of.allocate(value.kind.of, arrays.sizes(value))
        of.call_loop(library.each_magnitude, [made, value])
        return made
    found = numbers.absolute(of.block, given[0])
    return of.call_loop(library.magnitude_of, given) if found is None else found


def _real(of: Translator, given: list[Value]) -> Value:
    return convert(of.block, given[0], REAL)


def _of_real(name: str) -> Emit:
    """A function of float64 that LLVM or the system's library has, once or several times of arguments."""

    def emit(of: Translator, given: list[Value]) -> Value:
        parts = [f"double {convert(of.block, value, REAL).name}" for value in given]
        return Value(REAL, (of.block.call(name, "double", *parts),))

    return emit


def _to_whole(name: str) -> Emit:
    def emit(of: Translator, given: list[Value]) -> Value:
        return numbers.whole(of.block, _of_real(name)(of, given))

    return emit


def _root(of: Translator, given: list[Value]) -> Value:
    return _lane_function("sqrt")(of, given) if given[0].kind is LANES else _of_real("llvm.sqrt.f64")(of, given)


def _as(kind: Number) -> Emit:
    def emit(of: Translator, given: list[Value]) -> Value:
        (value,) = given
        if kind is SINGLE and value.kind is not SINGLE:
            return of.block.number(SINGLE, f"fptrunc double {convert(of.block, value, REAL).name} to float")
        if isinstance(value.constant, int) and kind is UNSIGNED:
            bits = value.constant if value.constant < 1 << 63 else value.constant - (1 << 64)
            return Value(UNSIGNED, (str(bits),))
        return numbers.whole(of.block, value) if kind is INTEGER else convert(of.block, value, kind)

    return emit


def _complex(of: Translator, given: list[Value]) -> Value:
    parts = [convert(of.block, value, REAL).name for value in given]
    return Value(COMPLEX, (parts[0], parts[1] if len(parts) > 1 else constant(0.0).name))


def _truth(of: Translator, given: list[Value]) -> Value:
    return numbers.truth(of.block, given[0])


def _is_nan(of: Translator, given: list[Value]) -> Value:
    x = convert(of.block, given[0], REAL)
    return of.block.number(BOOL, f"fcmp uno double {x.name}, {x.name}")


def _is_finite(of: Translator, given: list[Value]) -> Value:
    size = of.block.call("llvm.fabs.f64", "double", f"double {convert(of.block, given[0], REAL).name}")
    return of.block.number(BOOL, f"fcmp olt double {size}, {constant(math.inf).name}")


def _call(loop: Any) -> Emit:
    return lambda of, given: of.call_loop(loop, given)


# Lanes ----------------------------------------------------------------------------------------------------------------


def _lane_function(name: str) -> Emit:
    def emit(of: Translator, given: list[Value]) -> Value:
        x = convert(of.block, given[0], LANES)
        return Value(LANES, (_intrinsic(of.block, name, x),))

    return emit


def _intrinsic(block: Block, name: str, x: Value) -> str:
    function = f"llvm.{name}.v{WIDTH}f64"
    block.declared.add(f"declare {VECTOR} @{function}({VECTOR})")
    return block.let(f"call {VECTOR} @{function}({VECTOR} {x.name})")


def _where(of: Translator, given: list[Value]) -> Value:
    mask, a, b = given
    a, b = convert(of.block, a, LANES), convert(of.block, b, LANES)
    if mask.kind is MASK:
        return of.block.number(LANES, f"select {BITS} {mask.name}, {VECTOR} {a.name}, {VECTOR} {b.name}")
    truth = numbers.truth(of.block, mask)
    return of.block.number(LANES, f"select i1 {truth.name}, {VECTOR} {a.name}, {VECTOR} {b.name}")


def _extreme_lanes(order: str) -> Emit:
    def emit(of: Translator, given: list[Value]) -> Value:
        a, b = (convert(of.block, value, LANES) for value in given)
        return _where(of, [numbers.compare(of.block, order, a, b), a, b])

    return emit


def _lane_bits(of: Translator, given: list[Value]) -> Value:
    bits = of.block.let(f"bitcast {BITS} {given[0].name} to i{WIDTH}")
    return Value(INTEGER, (of.block.let(f"zext i{WIDTH} {bits} to i64"),), None, True)


def _any_lane(of: Translator, given: list[Value]) -> Value:
    bits = of.block.let(f"bitcast {BITS} {given[0].name} to i{WIDTH}")
    return of.block.number(BOOL, f"icmp ne i{WIDTH} {bits}, 0")


def _how_many(of: Translator, given: list[Value]) -> Value:
    return Value(INTEGER, (of.block.call("llvm.ctpop.i64", "i64", f"i64 {given[0].name}"),), None, True)


def _buffer(of: Translator, given: list[Value]) -> Value:
    count = given[0].constant
    if not isinstance(count, int):
        raise refusal("a buffer whose size is no constant")
    return Value(BUFFER, (of.block.room(8 * WIDTH * max(count, 1), 64),))


def _part(of: Translator, given: list[Value]) -> Value:
    return Value(BUFFER, (of.lane_place(*given),))


def _seen(of: Translator, given: list[Value]) -> Value:
    return Value(BUFFER, (given[0].name,))


def _in_lanes(of: Translator, given: list[Value]) -> Value:
    return of.allocate(REAL, [of.arithmetic("*", given[0], constant(WIDTH))])


def _one_lane(of: Translator, given: list[Value]) -> str:
    lane = convert(of.block, given[2], INTEGER)
    return of.block.let(f"getelementptr inbounds double, ptr {of.lane_place(*given[:2])}, i64 {lane.name}")


def _put(of: Translator, given: list[Value]) -> Value:
    of.block.store_element(REAL, convert(of.block, given[3], REAL), _one_lane(of, given))
    return Value(NONE, ())


def _get(of: Translator, given: list[Value]) -> Value:
    return of.block.load_element(REAL, _one_lane(of, given))


def _spread(of: Translator, given: list[Value]) -> Value:
    array, begin, stride, x = given
    for lane in range(WIDTH):
        at = of.arithmetic("+", begin, of.arithmetic("*", stride, constant(lane)))
        place = of.block.let(f"getelementptr inbounds double, ptr {array.name}, i64 {at.name}")
        number = of.block.number(REAL, f"extractelement {VECTOR} {x.name}, i32 {lane}")
        of.block.store_element(REAL, number, place)
    return Value(NONE, ())


def _looked_up(of: Translator, given: list[Value]) -> Value:
    array, places = given
    whole = of.block.let(f"fptosi {VECTOR} {places.name} to <{WIDTH} x i64>")
    found = "poison"
    for lane in range(WIDTH):
        at = of.block.let(f"extractelement <{WIDTH} x i64> {whole}, i32 {lane}")
        place = of.block.let(f"getelementptr inbounds double, ptr {array.name}, i64 {at}")
        number = of.block.load_element(REAL, place)
        found = of.block.let(f"insertelement {VECTOR} {found}, double {number.name}, i32 {lane}")
    return Value(LANES, (found,))


# Memory and kernels ---------------------------------------------------------------------------------------------------


def _open(of: Translator, given: list[Value]) -> Value:
    if not isinstance(given[0].kind, Held):
        raise refusal(f"{given[0].kind} where a held value is needed")
    return of.block.open_tuple(given[0])


def _address(of: Translator, given: list[Value]) -> Value:
    if not isinstance(given[0].kind, Array):
        raise refusal(f"the address of {given[0].kind}")
    return of.block.number(INTEGER, f"ptrtoint ptr {given[0].name} to i64")


def _kernel(of: Translator, given: list[Value]) -> Value:
    """void (ptr, ptr, ...) at an address; a batch entry takes null as its last argument."""
    entry, *places = (of.block.let(f"inttoptr i64 {value.name} to ptr") for value in given)
    last = ", ptr null" if len(places) == 3 else ""
    of.block.do(f"call void {entry}({', '.join(f'ptr {place}' for place in places)}{last})")
    return Value(NONE, ())


FUNCTIONS: dict[Any, Emit] = {
    len: _length, min: _extreme("<"), max: _extreme(">"), abs: _absolute, float: _real, bool: _truth,
    int: lambda of, given: numbers.whole(of.block, given[0]), complex: _complex,
    round: _to_whole("llvm.rint.f64"), math.floor: _to_whole("llvm.floor.f64"), math.ceil: _to_whole("llvm.ceil.f64"),
    math.sqrt: _root, np.sqrt: _root, np.abs: _absolute, math.fabs: _absolute,
    math.isfinite: _is_finite, np.isfinite: _is_finite, math.isnan: _is_nan, np.isnan: _is_nan,
    np.floor: _of_real("llvm.floor.f64"), np.ceil: _of_real("llvm.ceil.f64"), np.rint: _of_real("llvm.rint.f64"),
    np.round: _of_real("llvm.rint.f64"),
    math.copysign: _of_real("llvm.copysign.f64"), np.copysign: _of_real("llvm.copysign.f64"),
    np.nextafter: _of_real("nextafter"), math.fmod: _of_real("fmod"), np.float64: _real,
    np.int64: _as(INTEGER), np.uint64: _as(UNSIGNED), np.float32: _as(SINGLE),
    np.arange: _call(library.counted), np.argmax: _call(library.place_of_largest),
    np.argmin: _call(library.place_of_least), np.concatenate: _call(library.rows_joined), np.sum: _call(library.total),
    library.along: lambda of, given: of.along(given),
    np.max: _call(library.largest), np.min: _call(library.least),
    lanes.lanes: lambda of, given: convert(of.block, given[0], LANES),
    lanes.square_root: _root, lanes.magnitude: _lane_function("fabs"), lanes.rounded_down: _lane_function("floor"),
    lanes.where: _where, lanes.larger: _extreme_lanes(">"), lanes.smaller: _extreme_lanes("<"),
    lanes.lane_bits: _lane_bits, lanes.any_lane: _any_lane, lanes.how_many: _how_many, lanes.buffer: _buffer,
    lanes.part: _part, lanes.seen: _seen, lanes.in_lanes: _in_lanes, lanes.put: _put, lanes.get: _get,
    lanes.spread: _spread, lanes.looked_up: _looked_up, held.open_held: _open, lanes.address: _address,
    lanes.call_kernel: _kernel, lanes.call_lanes: _kernel,
}  # fmt: skip
"""What each function becomes."""
for _name in ("sin", "cos", "exp", "log"):
    FUNCTIONS[getattr(math, _name)] = FUNCTIONS[getattr(np, _name)] = _of_real(f"llvm.{_name}.f64")
for _name, _other in (
    ("tan", "tan"),
    ("asin", "arcsin"),
    ("acos", "arccos"),
    ("atan", "arctan"),
    ("atan2", "arctan2"),
    ("tanh", "tanh"),
    ("hypot", "hypot"),
):
    FUNCTIONS[getattr(math, _name)] = FUNCTIONS[getattr(np, _other)] = _of_real(_name)
