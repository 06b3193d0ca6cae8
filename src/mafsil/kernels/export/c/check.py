"""The third file of an export: a C program that holds the function against stored numbers."""

from __future__ import annotations

from mafsil.arrays import Floats
from mafsil.kernels.export.c.text import Real, literal, output_name
from mafsil.kernels.export.legend import port_name
from mafsil.kernels.export.vectors import LIMIT, Vectors
from mafsil.kernels.layout import Signature


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
