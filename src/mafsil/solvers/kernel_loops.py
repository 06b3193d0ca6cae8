"""Kernels and long loops called from compiled loops by their address, without Python in between.

A loop that is called the usual way becomes part of each of its callers, and is compiled again with each of them, and
with their callers; one that is called by its address is compiled once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba import typeof
from numba.core import cgutils, types
from numba.extending import intrinsic


@cast("Callable[[Any], Callable[[int, int, int], None]]", intrinsic)
def call_lanes(_typing: Any, entry: Any, given: Any, result: Any) -> Any:
    """Run a kernel of one result on eight rows in lanes (`lane_loops`): void (double *in, double *out).

    Args:
        entry: address, `Kernel.addresses.lanes`; the caller keeps the kernel alive.
        given: address of the inputs, one after another, each element eight numbers; a multiple of 64.
        result: address of the result, in the same form.
    """

    def generate(context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        pointer = context.get_value_type(types.voidptr)
        nothing = cgutils.ir.VoidType()  # pyright: ignore[reportPrivateImportUsage]
        function = type(builder.function.function_type)(nothing, [pointer] * 2)
        place, *places = (builder.inttoptr(value, pointer) for value in values)
        builder.call(builder.bitcast(place, function.as_pointer()), places)
        return context.get_dummy_value()

    return types.void(types.uintp, types.uintp, types.uintp), generate


@cast("Callable[[Any], Callable[[int, int, int, int], None]]", intrinsic)
def call_kernel(_typing: Any, entry: Any, arguments: Any, dimensions: Any, strides: Any) -> Any:
    """Run a kernel's batch entry: void (char **args, npy_intp *dims, npy_intp *steps, void *data).

    Args:
        entry: address, `Kernel.addresses.batch`; the caller keeps the kernel alive.
        arguments: address of an array with the addresses of all ports.
        dimensions: address of an array that begins with the number of rows.
        strides: address of an array with the bytes from row to row of every port, then its core strides in bytes.
    """

    def generate(context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        pointer = context.get_value_type(types.voidptr)
        nothing = cgutils.ir.VoidType()  # pyright: ignore[reportPrivateImportUsage]
        function = type(builder.function.function_type)(nothing, [pointer] * 4)
        place = builder.inttoptr(values[0], function.as_pointer())
        given = [builder.inttoptr(value, pointer) for value in values[1:]]
        builder.call(place, [*given, pointer(None)])
        return context.get_dummy_value()

    return types.void(types.uintp, types.uintp, types.uintp, types.uintp), generate


def loop_caller(count: int, *results: str) -> Any:
    """What calls an `uncounted` loop by its address: `call(address, *arguments)`.

    Args:
        count: of the arguments, 3 or 4.
        results: names of the types of what the loop returns.
    """
    result = types.Tuple([getattr(types, name) for name in results])

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        given = signature.args[1:]
        kind = context.call_conv.get_function_type(result, given)
        place = builder.inttoptr(values[0], kind.as_pointer())
        return context.call_conv.call_function(builder, place, result, given, values[1:])[1]

    @cast("Callable[[Any], Any]", intrinsic)
    def call_of_three(_typing: Any, address: Any, a: Any, b: Any, c: Any) -> Any:
        return result(types.uintp, a, b, c), generate

    @cast("Callable[[Any], Any]", intrinsic)
    def call_of_four(_typing: Any, address: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
        return result(types.uintp, a, b, c, d), generate

    return {3: call_of_three, 4: call_of_four}[count]


def loop_address(loop: Any, *arguments: Any) -> int:
    """Where the code of a loop for such arguments begins; it stays as long as the process.

    Args:
        loop: compiled.
        arguments: examples.
    """
    kinds = tuple(typeof(argument) for argument in arguments)
    loop.compile(kinds)
    made = loop.overloads[kinds]
    return int(made.library.get_pointer_to_function(made.fndesc.llvm_func_name))
