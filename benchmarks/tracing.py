"""How long tracing takes in our own expressions and in CasADi: the same recursion, its Jacobian, both read as lists.

python benchmarks/tracing.py

The inverse dynamics of `kernels_raw` is built with either set of names; then every operation is read into Python, as a
compiler needs it. Operations after common subexpressions stand beside the times.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import casadi as ca
import kernels_raw
from stopwatch import machine, race

import mafsil.expression as ex
from mafsil.kernels.tape import read

CASADI: Any = SimpleNamespace(
    symbol=ca.SX.sym,
    Expression=ca.SX,
    zeros=ca.SX.zeros,
    Function=ca.Function,
    **{name: getattr(ca, name) for name in ("cos", "sin", "cross", "vertcat", "horzcat", "cse")},
)


def ours(derivatives: bool) -> int:
    """Operations of the function traced and read."""
    kernels_raw.ex = ex
    function = kernels_raw.expression()
    if derivatives:
        q, qd, qdd = function.inputs
        slope = ex.jacobian(function.outputs[0], ex.vertcat(q, qd, qdd))
        function = ex.Function("slope", [q, qd, qdd], [ex.vec(slope)], cse=True)
    return read(function).operations


def casadis(derivatives: bool) -> int:
    """Operations of the function traced and read."""
    kernels_raw.ex = CASADI
    function: Any = kernels_raw.expression()
    if derivatives:
        x = ca.SX.sym("x", 3 * kernels_raw.JOINTS)
        slope = ca.jacobian(function(*ca.vertsplit(x, kernels_raw.JOINTS)), x)
        function = ca.Function("slope", [x], [ca.densify(ca.vec(slope))], {"cse": True})
    leaves = (ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST)
    rows = [
        (function.instruction_id(k), function.instruction_input(k), function.instruction_output(k))
        for k in range(function.n_instructions())
    ]
    return sum(row[0] not in leaves for row in rows)


def main() -> None:
    """Print the table."""
    print(" | ".join(f"{key} {value}" for key, value in machine("mafsil", "numpy", "casadi").items()))
    print(f"{'inverse dynamics, 7 joints':32} {'ours':>10} {'CasADi':>10} {'ratio':>7} {'operations':>16}")
    for title, derivatives in (("traced and read", False), ("with its Jacobian by q, qd, qdd", True)):
        tasks: dict[str, Callable[[], object]] = {
            "ours": lambda derivatives=derivatives: ours(derivatives),
            "casadi": lambda derivatives=derivatives: casadis(derivatives),
        }
        counts = {name: task() for name, task in tasks.items()}
        times = race(tasks, repeats=7, seconds=0.0)
        mine, theirs = times["ours"].least, times["casadi"].least
        operations = f"{counts['ours']} and {counts['casadi']}"
        print(f"{title:32} {1e3 * mine:7.1f} ms {1e3 * theirs:7.1f} ms {theirs / mine:7.2f} {operations:>16}")


if __name__ == "__main__":
    main()
