"""A tape as portable C99: one assignment for each operation, nothing but arithmetic and <math.h>."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.export.legend import LIMIT, Legend, Vectors, port_name
from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.tape import Node, Tape

Real = Literal["double", "float"]
_LIBRARY = frozenset((
    "exp", "log", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "tanh", "floor", "ceil",
    "fabs", "pow", "copysign", "fmin", "fmax",
))  # fmt: skip
"""Operations whose C function has the same name."""
_SIGNS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_ORDER = {"lt": "<", "le": "<=", "eq": "==", "ne": "!="}


def header(
    signature: Signature, legend: Legend, name: str, real: Real, more: str = "", notes: tuple[str, ...] = ()
) -> str:
    """The .h file: what the function takes and gives.

    Args:
        signature: ports.
        legend: words for people.
        name: of the function.
        real: number type.
        more: further declarations.
        notes: further lines of the comment, harmless ones.
    """
    guard = f"{name.upper()}_H"
    comment = [*legend.lines(signature), *_PROMISES, *notes]
    return "\n".join(
        [
            "/*",
            *(f" * {line}".rstrip() for line in comment),
            " */",
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            *(["#include <stddef.h>", ""] if more else []),
            "#ifdef __cplusplus",
            'extern "C" {',
            "#endif",
            "",
            prototype(signature, name, real) + ";",
            *([more] if more else []),
            "",
            "#ifdef __cplusplus",
            "}",
            "#endif",
            "",
            f"#endif /* {guard} */",
            "",
        ]
    )


_PROMISES = (
    "No heap, no recursion, no loops: the time hardly depends on the state. An output may overwrite an input.",
)


def prototype(signature: Signature, name: str, real: Real) -> str:
    """The function's declaration without its semicolon."""
    inputs = [f"const {real} {port_name(p)}[{max(p.size, 1)}]" for p in signature.inputs]
    outputs = [f"{real} {output_name(p, signature)}[{max(p.size, 1)}]" for p in signature.outputs]
    return f"void {name}({', '.join([*inputs, *outputs])})"


def output_name(port: Port, signature: Signature) -> str:
    """The output's name, unlike all inputs' names."""
    name = port_name(port)
    return f"{name.rstrip('_')}_out" if name in {port_name(p) for p in signature.inputs} else name


def source(tape: Tape, signature: Signature, name: str, real: Real) -> str:
    """The .c file.

    Args:
        tape: the program.
        signature: its ports.
        name: of the function.
        real: number type.
    """
    lines = [f'#include "{name}.h"', "", "#include <math.h>", "", *_fuse(tape, real), prototype(signature, name, real)]
    lines.append("{")
    used = {(node.args[0]) for node in tape.nodes if node.op == "input"}
    lines += [f"    (void){port_name(p)};" for k, p in enumerate(signature.inputs) if k not in used]
    writer = _Writer(tape, signature, real)
    for i, node in enumerate(tape.nodes):
        if node.op != "const":
            lines.append(f"    const {real} t{i} = {writer.expression(node)};")
    for k, port in enumerate(tape.outputs):
        place = output_name(signature.outputs[k], signature)
        lines += [f"    {place}[{element}] = {writer.value(i)};" for element, i in enumerate(port)]
    return "\n".join([*lines, "}", ""])


def literal(value: float, real: Real) -> str:
    """A constant that every compiler reads back bit for bit."""
    if real == "float":
        with np.errstate(over="ignore"):
            value = float(np.float32(value))
    if math.isnan(value):
        return f"({real})NAN"
    if math.isinf(value):
        return f"({real})INFINITY" if value > 0 else f"(-({real})INFINITY)"
    text = repr(value) if real == "double" else str(np.float32(value))
    text = text if any(sign in text for sign in ".en") else text + ".0"
    text += "f" if real == "float" else ""
    return f"({text})" if text.startswith("-") else text


def _fuse(tape: Tape, real: Real) -> list[str]:
    """The macro for a product and a sum: rounded once where that is quick, else twice."""
    if not any(node.op in ("fma", "fms", "fnma", "fnms") for node in tape.nodes):
        return []
    suffix = "f" if real == "float" else ""
    return [
        f"#ifdef FP_FAST_FMA{suffix.upper()}",
        f"#define MAFSIL_FMA(a, b, c) fma{suffix}((a), (b), (c))",
        "#else",
        "#define MAFSIL_FMA(a, b, c) ((a) * (b) + (c))",
        "#endif",
        "",
    ]


class _Writer:
    """Expressions of single nodes."""

    def __init__(self, tape: Tape, signature: Signature, real: Real) -> None:
        self.tape = tape
        self.names = [port_name(port) for port in signature.inputs]
        self.real: Real = real
        self.suffix = "f" if real == "float" else ""
        self.zero, self.one = literal(0.0, real), literal(1.0, real)

    def value(self, i: int) -> str:
        node = self.tape.nodes[i]
        return literal(node.value, self.real) if node.op == "const" else f"t{i}"

    def expression(self, node: Node) -> str:
        if node.op == "input":
            return f"{self.names[node.args[0]]}[{node.args[1]}]"
        args = [self.value(a) for a in node.args]
        if node.op in _LIBRARY:
            return f"{node.op}{self.suffix}({', '.join(args)})"
        if node.op in _SIGNS:
            return f"{args[0]} {_SIGNS[node.op]} {args[1]}"
        if node.op in _ORDER:
            return self.number(f"{args[0]} {_ORDER[node.op]} {args[1]}")
        return _FORMS[node.op](self, *args)

    def number(self, condition: str) -> str:
        """1 or 0."""
        return f"({condition}) ? {self.one} : {self.zero}"


_FORMS_OF_ONE: dict[str, Callable[[_Writer, str], str]] = {
    "neg": lambda w, x: f"-{x}",
    "sign": lambda w, x: f"({x} > {w.zero}) ? {w.one} : (({x} < {w.zero}) ? -{w.one} : {x})",
    "not": lambda w, x: w.number(f"{x} == {w.zero}"),
}
_FORMS_OF_TWO: dict[str, Callable[[_Writer, str, str], str]] = {
    "and": lambda w, x, y: w.number(f"{x} != {w.zero} && {y} != {w.zero}"),
    "or": lambda w, x, y: w.number(f"{x} != {w.zero} || {y} != {w.zero}"),
    "if_else_zero": lambda w, c, x: f"({c} != {w.zero}) ? {x} : {w.zero}",
}
_FORMS_OF_THREE: dict[str, Callable[[_Writer, str, str, str], str]] = {
    "select": lambda w, c, x, y: f"({c} != {w.zero}) ? {x} : {y}",
    "fma": lambda w, a, b, c: f"MAFSIL_FMA({a}, {b}, {c})",
    "fms": lambda w, a, b, c: f"MAFSIL_FMA({a}, {b}, -{c})",
    "fnma": lambda w, a, b, c: f"MAFSIL_FMA(-{a}, {b}, {c})",
    "fnms": lambda w, a, b, c: f"MAFSIL_FMA(-{a}, {b}, -{c})",
}
_FORMS: dict[str, Callable[..., str]] = {**_FORMS_OF_ONE, **_FORMS_OF_TWO, **_FORMS_OF_THREE}
"""Operations that are no function of <math.h> and no infix sign."""


def program(signature: Signature, name: str, real: Real, stored: Vectors) -> str:
    """A main() that says `ok`, or which number is off by how much; its exit code is 0 or 1.

    Args:
        signature: ports of the function.
        name: of the function.
        real: its number type.
        stored: what it must give.
    """
    inputs = [(f"in_{port_name(p)}", p.size, x) for p, x in zip(signature.inputs, stored.inputs, strict=True)]
    outputs = [
        (output_name(p, signature), p.size, y, u)
        for p, y, u in zip(signature.outputs, stored.outputs, stored.units, strict=True)
    ]
    arrays = [_array(real, label, size, x, real) for label, size, x in inputs]
    for label, size, values, units in outputs:
        arrays += [_array("double", f"expected_{label}", size, values), _array("double", f"unit_{label}", size, units)]
    given = [f"in_{port_name(p)}[row]" for p in signature.inputs] + [f"out_{label}" for label, *_ in outputs]
    lines = [
        f'#include "{name}.h"',
        "",
        "#include <math.h>",
        "#include <stdio.h>",
        "",
        f"enum {{ ROWS = {stored.rows} }};",
        "/* How far a number may be off, in units in the last place of its natural scale. */",
        f"static const double LIMIT = {LIMIT!r};",
        "",
        *arrays,
        _DISTANCE,
        "int main(void)",
        "{",
        "    double worst = 0.0;",
        "    int row;",
        "    int k;",
        *(f"    {real} out_{label}[{max(size, 1)}];" for label, size, *_ in outputs),
        "    for (row = 0; row < ROWS; ++row) {",
        f"        {name}({', '.join(given)});",
    ]
    for label, size, *_ in outputs:
        lines += [
            f"        for (k = 0; k < {size}; ++k) {{",
            f"            const double found = distance((double)out_{label}[k], expected_{label}[row][k], "
            f"unit_{label}[row][k]);",
            "            if (!(found <= LIMIT)) {",
            f'                printf("{name}: row %d, {label}[%d]: %.17g instead of %.17g\\n", row, k,',
            f"                       (double)out_{label}[k], expected_{label}[row][k]);",
            "                return 1;",
            "            }",
            "            worst = found > worst ? found : worst;",
            "        }",
        ]
    said = f'    printf("ok {name}: %d rows, worst %.3g units in the last place\\n", (int)ROWS, worst);'
    return "\n".join([*lines, "    }", said, "    return 0;", "}", ""])


_DISTANCE = """static double distance(double found, double expected, double unit)
{
    if (isnan(expected) || isinf(expected)) {
        return (isnan(expected) ? isnan(found) : found == expected) ? 0.0 : (double)INFINITY;
    }
    return found == expected ? 0.0 : fabs(found - expected) / unit;
}
"""


def _array(kind: Real, label: str, size: int, rows: Floats, real: Real = "double") -> str:
    texts = [", ".join(literal(float(x), real) for x in row) or literal(0.0, real) for row in rows]
    body = ",\n".join(f"    {{ {text} }}" for text in texts)
    return f"static const {kind} {label}[ROWS][{max(size, 1)}] = {{\n{body}\n}};\n"
